// The organs as the session deforms them, and the instruments.
import {onColourChange, toolColour} from './chart.js';
import {makeSinking, OrganSurface} from './ffd.js';
import {Instrument, makeView} from './scene3d.js';

const organColours = ['#b8694f', '#8a9b4a', '#c9a227', '#8d76b5', '#5f9496', '#c48aa8'];

// Displaced tissue takes this colour, fully at this displacement in m.
const displacedColour = '#fff1b8', wholly = 0.02;

export class OrganScene {
  /// Writes the organs, and why there is no picture, into `session`.
  constructor(element, session) {
    this.element = element;
    this.session = session;
    this.organs = new Map();  // number -> {version, surface, mesh, shape, dirty}
    this.instruments = [];
    this.onLoaded = () => {};
    this.sinking = () => 0;
    try {
      this.view = makeView(element, {height: (width) => Math.round(Math.min(Math.max(0.72 * width, 260), 520))});
      this.view.controls.addEventListener('start', () => { this.turned = true; });
    } catch {
      session.noWebGl = 'This browser has no WebGL: there is no 3-D view, but everything else works.';
    }
    onColourChange(() => {
      this.instruments.forEach((instrument, i) => instrument.recolour(toolColour(i)));
      this.view?.render();
    });
  }

  setSinking(table) { this.sinking = makeSinking(table); }

  keepOnly(numbers) {
    for (const number of [...this.organs.keys()]) {
      if (!numbers.includes(number)) this.remove(number);
    }
  }

  remove(number) {
    const organ = this.organs.get(number);
    if (organ?.mesh) {
      this.view.scene.remove(organ.mesh);
      organ.mesh.geometry.dispose();
      organ.mesh.material.dispose();
    }
    this.organs.delete(number);
    this.session.organNames.delete(number);
    this.session.organsWithoutFit.delete(number);
  }

  /// Fetches a mesh that an update names.
  async load({organ: number, version, name}) {
    this.remove(number);
    const organ = {version, surface: null, mesh: null, shape: null, dirty: true};
    this.organs.set(number, organ);
    this.session.organNames.set(number, name);
    for (let wait = 250; this.organs.get(number) === organ; wait = Math.min(2 * wait, 4000)) {
      const mesh = await fetch(`mesh/${number}`).then((answer) => answer.ok ? answer.json() : null, () => null);
      if (mesh) {
        organ.surface = new OrganSurface(mesh);
        break;
      }
      await new Promise((done) => setTimeout(done, wait));  // until the connection is back
    }
    if (this.organs.get(number) !== organ) return;
    if (this.view) this.addMesh(number, organ);
    this.onLoaded();
  }

  addMesh(number, organ) {
    const {THREE, scene} = this.view;
    const geometry = new THREE.BufferGeometry();
    const dynamic = (values) =>
        new THREE.BufferAttribute(values, 3).setUsage(THREE.DynamicDrawUsage);
    geometry.setAttribute('position', dynamic(organ.surface.positions));
    geometry.setAttribute('normal', dynamic(organ.surface.normals));
    geometry.setAttribute('color', dynamic(new Float32Array(organ.surface.rest.length)));
    this.paint(number, organ.surface, geometry.attributes.color, [0, 0, 0]);
    geometry.setIndex(new THREE.BufferAttribute(new Uint32Array(organ.surface.triangles), 1));
    const material = new THREE.MeshStandardMaterial(
        {vertexColors: true, roughness: 0.55, side: THREE.DoubleSide});
    organ.mesh = new THREE.Mesh(geometry, material);
    organ.mesh.frustumCulled = false;  // its bounds move
    scene.add(organ.mesh);
    if (!this.turned) this.lookAtAll();
    this.showLegend();
  }

  paint(number, {rest, positions}, colours, offset) {
    const {THREE} = this.view;
    const still = new THREE.Color(organColours[number % organColours.length]).toArray();
    const moved = new THREE.Color(displacedColour).toArray();
    for (let v = 0; v < rest.length; v += 3) {
      const distance = Math.hypot(positions[v] - rest[v] - offset[0],
          positions[v + 1] - rest[v + 1] - offset[1], positions[v + 2] - rest[v + 2] - offset[2]);
      const share = Math.min(distance / wholly, 1);
      for (let k = 0; k < 3; ++k) colours.array[v + k] = still[k] + share * (moved[k] - still[k]);
    }
    colours.needsUpdate = true;
  }

  lookAtAll() {
    const {THREE, fit} = this.view;
    const box = new THREE.Box3(), point = new THREE.Vector3();
    for (const {surface} of this.organs.values()) {
      for (let i = 0; surface && i < surface.rest.length; i += 3) {
        box.expandByPoint(point.fromArray(surface.rest, i));
      }
    }
    if (!box.isEmpty()) fit(box);
  }

  showLegend() {
    const legend = document.getElementById('legend');
    legend.replaceChildren();
    for (const [number, organ] of this.organs) {
      if (!organ.mesh) continue;
      const item = document.createElement('span'), dot = document.createElement('i');
      dot.style.background = organColours[number % organColours.length];
      item.append(dot, organ.surface.name);
      legend.append(item);
    }
    const rest = document.createElement('span'), pale = document.createElement('i');
    pale.style.background = displacedColour;
    pale.style.outline = '1px solid';
    rest.className = 'muted';
    rest.append(pale, `displaced by ${1000 * wholly} mm or more · arrow: force on the hand, 2 cm for 1 N, at most 8 cm`);
    legend.append(rest);
  }

  deform(shape) {
    const organ = this.organs.get(shape.organ);
    if (!organ) return;
    organ.shape = shape;
    organ.dirty = true;
    if (shape.fits === false) {
      this.session.organsWithoutFit.add(shape.organ);
    } else {
      this.session.organsWithoutFit.delete(shape.organ);
    }
  }

  /// Draws the changes.
  show() {
    if (!this.view) return;
    for (const organ of this.organs.values()) {
      if (!organ.dirty || !organ.mesh || !organ.shape) continue;
      organ.dirty = false;
      organ.surface.deform(organ.shape, this.sinking);
      const {position, normal, color} = organ.mesh.geometry.attributes;
      position.needsUpdate = normal.needsUpdate = true;
      this.paint(organ.shape.organ, organ.surface, color, organ.shape.offset ?? [0, 0, 0]);
    }
    const {tools} = this.session;
    const poses = tools?.poses ?? [];
    while (this.instruments.length < poses.length) {
      const instrument = new Instrument(toolColour(this.instruments.length));
      this.instruments.push(instrument);
      this.view.scene.add(instrument.group);
    }
    this.instruments.forEach((instrument, i) => {
      instrument.group.visible = i < poses.length;
      if (i < poses.length) {
        instrument.set(poses[i].tip, poses[i].trocar, tools.tools[i]?.force ?? [0, 0, 0]);
      }
    });
    this.view.render();
  }
}
