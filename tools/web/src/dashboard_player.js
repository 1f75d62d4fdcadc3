// Buttons of the log player.

const clock = (seconds) => {
  const whole = Math.floor(seconds / 60);
  return `${whole}:${(seconds - 60 * whole).toFixed(1).padStart(4, '0')}`;
};

const ask = (command, value) => fetch('control', {
  method: 'POST',
  headers: {'Content-Type': 'application/json'},
  body: JSON.stringify({command, value}),
}).catch(() => { /* the page says that the connection is lost */ });

/// Returns a function that shows the player's state. Without one (a live session) the buttons stay
/// hidden.
export function makePlayer() {
  const find = (id) => document.getElementById(id);
  const bar = find('player'), play = find('play'), seek = find('seek'), speed = find('speed');
  let player = null, holding = false;
  play.onclick = async () => {
    const {ended, paused} = player;  // the state that the button shows; a seek changes it
    if (ended) await ask('seek', 0);
    await ask(ended || paused ? 'play' : 'pause');
  };
  seek.oninput = () => {
    holding = true;
    find('position').textContent = clock(Number(seek.value));
  };
  seek.onchange = async () => {
    await ask('seek', Number(seek.value));
    holding = false;
  };
  speed.onchange = () => ask('speed', Number(speed.value));
  return (now) => {
    player = now ?? null;
    bar.hidden = !player;
    if (!player) return;
    play.textContent = player.ended ? 'Replay' : player.paused ? 'Play' : 'Pause';
    seek.max = player.duration;
    if (!holding) {
      seek.value = player.position;
      find('position').textContent = `${clock(player.position)} of ${clock(player.duration)}`;
    }
    if (document.activeElement === speed) return;
    const value = String(player.speed);
    if (![...speed.options].some((option) => option.value === value)) {
      speed.add(new Option(`${value} x`, value));  // as --speed gave it
    }
    speed.value = value;
  };
}
