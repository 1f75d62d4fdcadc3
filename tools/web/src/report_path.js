// The paths of the tips in 3-D, coloured by force, with the organs at rest; flat without WebGL.
import {makeView} from './scene3d.js';

// Viridis (S. van der Walt, N. Smith): its lightness rises evenly, for colour-blind readers too.
const viridis = [
  [68, 1, 84], [71, 44, 122], [59, 81, 139], [44, 113, 142], [33, 144, 141], [39, 173, 129],
  [92, 200, 99], [170, 220, 50], [253, 231, 37],
];
const over = [208, 0, 40];  // above the limit

/// Returns three channels of 0..255.
function colourOf(force, limit) {
  if (force > limit) return over;
  const at = Math.min(Math.max(force / limit, 0), 1) * (viridis.length - 1);
  const i = Math.min(Math.floor(at), viridis.length - 2);
  return viridis[i].map((c, k) => c + (at - i) * (viridis[i + 1][k] - c));
}
const css = (c) => `rgb(${c.map(Math.round).join(',')})`;

function bytesOf(base64) {
  return Uint8Array.from(atob(base64), (c) => c.charCodeAt(0)).buffer;
}

/// Calls visit(a, b) with the indices of each piece of a path.
function eachPiece(path, visit) {
  for (let i = 1; i < path.x.length; ++i) {
    if (path.x[i] != null && path.x[i - 1] != null) visit(i - 1, i);
  }
}

function addOrgans(view, data) {
  const {THREE, scene} = view;
  const tints = [0xa65b4f, 0x7f9a5a, 0xc08a4a, 0x8c6d9c, 0x5d8aa8, 0xb07a86];
  data.organs.forEach((organ, i) => {
    const geometry = new THREE.BufferGeometry();
    const tenths = new Int16Array(bytesOf(organ.vertices));
    geometry.setAttribute('position',
                          new THREE.BufferAttribute(Float32Array.from(tenths, (v) => v * 1e-4), 3));
    geometry.setIndex(new THREE.BufferAttribute(new Uint32Array(bytesOf(organ.triangles)), 1));
    geometry.computeVertexNormals();
    const material = new THREE.MeshLambertMaterial(
        {color: tints[i % tints.length], transparent: true, opacity: 0.38, side: THREE.DoubleSide,
         depthWrite: false});
    scene.add(new THREE.Mesh(geometry, material));
  });
}

/// Adds a stick for each piece of a path, one instanced mesh per hand.
function addPaths(view, data) {
  const {THREE, scene} = view;
  const box = new THREE.Box3();
  data.hands.forEach((hand, tool) => {
    const {path} = hand;
    const pieces = [];
    eachPiece(path, (a, b) => pieces.push([a, b]));
    if (pieces.length === 0) return;
    const stick = new THREE.CylinderGeometry(1, 1, 1, tool === 0 ? 6 : 4);
    const mesh = new THREE.InstancedMesh(stick, new THREE.MeshBasicMaterial(), pieces.length);
    const up = new THREE.Vector3(0, 1, 0), from = new THREE.Vector3(), to = new THREE.Vector3();
    const matrix = new THREE.Matrix4(), turn = new THREE.Quaternion(), paint = new THREE.Color();
    const at = (i, v) => v.set(path.x[i], path.y[i], path.z[i]).multiplyScalar(1e-3);
    pieces.forEach(([a, b], k) => {
      at(a, from);
      at(b, to);
      box.expandByPoint(from);
      box.expandByPoint(to);
      const along = to.clone().sub(from), length = along.length();
      turn.setFromUnitVectors(up, length > 0 ? along.divideScalar(length) : up);
      const radius = tool === 0 ? 0.0007 : 0.0005;
      matrix.compose(from.lerp(to, 0.5), turn, new THREE.Vector3(radius, length, radius));
      mesh.setMatrixAt(k, matrix);
      const [r, g, b255] = colourOf(Math.max(path.force[a], path.force[b]), data.limit);
      mesh.setColorAt(k, paint.setRGB(r / 255, g / 255, b255 / 255, THREE.SRGBColorSpace));
    });
    scene.add(mesh);
  });
  return box;
}

/// Draws three views along the axes, for browsers without WebGL.
function drawFlat(into, data) {
  const note = document.createElement('p');
  note.className = 'note';
  note.textContent = 'This browser has no WebGL; the paths are shown from three sides.';
  into.append(note);
  const sides = [['x', 'z', 'from the front'], ['y', 'z', 'from the side'], ['x', 'y', 'from above']];
  const holder = document.createElement('div');
  holder.className = 'pictures';
  into.append(holder);
  for (const [h, v, name] of sides) {
    const figure = document.createElement('figure');
    const svg = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
    const values = (axis) => data.hands.flatMap(({path}) => path[axis].filter((p) => p != null));
    const low = (axis) => values(axis).reduce((a, b) => Math.min(a, b), Infinity);
    const high = (axis) => values(axis).reduce((a, b) => Math.max(a, b), -Infinity);
    if (values('x').length === 0) return;
    const margin = 5;
    svg.setAttribute('viewBox', [low(h) - margin, -high(v) - margin, high(h) - low(h) + 2 * margin,
                                 high(v) - low(v) + 2 * margin].join(' '));
    svg.setAttribute('width', '100%');
    for (const {path} of data.hands) {
      eachPiece(path, (a, b) => {
        const piece = document.createElementNS('http://www.w3.org/2000/svg', 'line');
        const set = (key, value) => piece.setAttribute(key, value);
        set('x1', path[h][a]);
        set('y1', -path[v][a]);
        set('x2', path[h][b]);
        set('y2', -path[v][b]);
        set('stroke', css(colourOf(Math.max(path.force[a], path.force[b]), data.limit)));
        set('stroke-width', 0.6);
        svg.append(piece);
      });
    }
    const caption = document.createElement('figcaption');
    caption.textContent = name;
    figure.append(svg, caption);
    holder.append(figure);
  }
}

function addLegend(into, data) {
  const legend = document.createElement('div');
  legend.className = 'legend';
  const entry = (text, style, name) => {
    const span = document.createElement('span');
    const sample = document.createElement('i');
    if (name) sample.className = name;
    sample.style.cssText = style;
    span.append(sample, text);
    legend.append(span);
  };
  entry(`0 to ${data.limit} N`,
        `background:linear-gradient(90deg, ${viridis.map(css).join(',')});width:9rem`, 'scale');
  entry('above the limit', `background:${css(over)}`);
  for (const [tool, hand] of data.hands.entries()) {
    entry(`${hand.name}: ${tool === 0 ? 'thick' : 'thin'} line`,
          `height:${tool === 0 ? 4 : 2}px;background:var(--text)`);
  }
  for (const name of data.organs_left_out) entry(`${name}: not drawn, too many vertices`, '');
  into.append(legend);
}

export function drawPath(into, data) {
  addLegend(into, data);
  let view;
  try {
    // Checked first, because three.js reports missing WebGL as an error of the page.
    if (!document.createElement('canvas').getContext('webgl2')) throw new Error('no WebGL');
    view = makeView(into, {height: (width) => Math.min(420, Math.max(width * 0.8, 240))});
  } catch {
    drawFlat(into, data);
    return;
  }
  addOrgans(view, data);
  const box = addPaths(view, data);
  if (!box.isEmpty()) view.fit(box);
  const help = document.createElement('p');
  help.className = 'note help';
  help.textContent = 'Drag with the mouse or a finger to turn; use the wheel to zoom.';
  into.append(help);
}
