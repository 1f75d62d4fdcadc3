// Makes built/PAGE.html from each src/PAGE.html: one file that works offline, with its scripts
// bundled and minified in place of <!-- page --> and its styles at the head's end. npm is needed only
// to change src/:
//
//     cd tools/web && npm ci && npm run build
//
// The page's second line has a hash of all sources, with which a test detects a stale page.
import * as esbuild from 'esbuild';
import {readdirSync, readFileSync, writeFileSync} from 'node:fs';

// 64-bit FNV-1a over names and contents in the order of the names, as
// tests/tools/web/web_pages_test.cc has it.
function hashOfSources() {
  let hash = 0xcbf29ce484222325n;
  const add = (bytes) => {
    for (const byte of bytes) hash = BigInt.asUintN(64, (hash ^ BigInt(byte)) * 0x100000001b3n);
  };
  for (const name of readdirSync('src').sort()) {
    add(Buffer.from(name));
    add(readFileSync(`src/${name}`));
  }
  return hash.toString(16).padStart(16, '0');
}

const hash = hashOfSources();
for (const page of ['dashboard', 'report']) {
  const result = await esbuild.build({
    entryPoints: [`src/${page}.js`],
    bundle: true,
    minify: true,
    write: false,
    outdir: 'out',
    format: 'iife',
    target: 'es2022',
    legalComments: 'eof',
  });
  const text = (suffix) => result.outputFiles.find((file) => file.path.endsWith(suffix))?.text ?? '';
  // A script ends at the first "</script", even inside a string.
  const script = text('.js').replaceAll('</script', '<\\/script');
  // Styles come first: otherwise the page is laid out once without them, and zoomed out on a phone.
  const html = readFileSync(`src/${page}.html`, 'utf8')
      .replace('</head>', () => `<style>${text('.css')}</style>\n</head>`)
      .replace('<!-- page -->', () => `<script>${script}</script>`);
  writeFileSync(`built/${page}.html`, html.replace('\n', `\n<!-- sources ${hash} -->\n`));
}
