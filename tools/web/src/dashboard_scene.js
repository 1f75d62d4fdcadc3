// The organs as the session deforms them, and the instruments.
import {onColourChange, toolColour} from './chart.js';
import {makeSinking, OrganSurface} from './ffd.js';
import {Instrument, makeView} from './scene3d.js';

const organColours = ['#b8694f', '#8a9b4a', '#c9a227', '#8d76b5', '#5f9496', '#c48aa8'];

export class OrganScene {
  /// `session` is told which organs there are, and why there is no picture.
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
      session.noWebGl = 'This browser shows no WebGL: there is no 3-D view, all else works.';
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
      try {
        const answer = await fetch(`mesh/${number}`);
        if (answer.ok) {
          organ.surface = new OrganSurface(await answer.json());
          break;
        }
      } catch { /* the connection: tried again */ }
      await new Promise((done) => setTimeout(done, wait));
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
    geometry.setIndex(new THREE.BufferAttribute(new Uint32Array(organ.surface.triangles), 1));
    const material = new THREE.MeshStandardMaterial(
        {color: organColours[number % organColours.length], roughness: 0.55, side: THREE.DoubleSide});
    organ.mesh = new THREE.Mesh(geometry, material);
    organ.mesh.frustumCulled = false;  // its bounds move
    scene.add(organ.mesh);
    if (!this.turned) this.lookAtAll();
    this.showLegend();
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
    const arrows = document.createElement('span');
    arrows.className = 'muted';
    arrows.textContent = 'arrow: force on the hand, 2 cm per N, at most 8 cm';
    legend.append(arrows);
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

  /// Draws what has changed.
  show() {
    if (!this.view) return;
    for (const organ of this.organs.values()) {
      if (!organ.dirty || !organ.mesh || !organ.shape) continue;
      organ.dirty = false;
      organ.surface.deform(organ.shape, this.sinking);
      organ.mesh.geometry.attributes.position.needsUpdate = true;
      organ.mesh.geometry.attributes.normal.needsUpdate = true;
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
