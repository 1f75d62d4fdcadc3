// The choice of colours for good, warning and bad (page.css). It is kept in the browser; an address with
// ?palette=colour-blind or ?palette=standard chooses it too.

const key = 'hpdm.palette', safe = 'colour-blind';

function kept() {
  try {
    return localStorage.getItem(key);
  } catch {
    return null;  // storage is refused
  }
}

export function makePalette() {
  const button = document.getElementById('palette'), root = document.documentElement;
  const show = (palette) => {
    root.dataset.palette = palette === safe ? safe : 'standard';
    button.setAttribute('aria-pressed', String(palette === safe));
  };
  show(new URLSearchParams(location.search).get('palette') ?? kept());
  button.addEventListener('click', () => {
    const palette = root.dataset.palette === safe ? 'standard' : safe;
    show(palette);
    try {
      localStorage.setItem(key, palette);
    } catch {
      // The choice holds for this page only.
    }
  });
}
