// A 3-D view (three.js) that turns with the mouse or a finger. World frame and metres as in the
// engine.
import * as THREE from 'three';
import {OrbitControls} from 'three/examples/jsm/controls/OrbitControls.js';

/// Makes a canvas in `element`. Add objects to `scene`, then call render(). Throws without WebGL.
export function makeView(element, {height = 420} = {}) {
  const renderer = new THREE.WebGLRenderer({antialias: true, alpha: true, preserveDrawingBuffer: true});
  renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
  element.append(renderer.domElement);
  renderer.domElement.style.display = 'block';
  const scene = new THREE.Scene();
  const camera = new THREE.PerspectiveCamera(35, 1, 0.005, 10);
  camera.up.set(0, 0, 1);
  const controls = new OrbitControls(camera, renderer.domElement);
  scene.add(new THREE.HemisphereLight(0xffffff, 0x605050, 1.6));
  const lamp = new THREE.DirectionalLight(0xffffff, 1.8);
  scene.add(lamp);
  const render = () => {
    lamp.position.copy(camera.position);
    lamp.target.position.copy(controls.target);
    lamp.target.updateMatrixWorld();
    renderer.render(scene, camera);
  };
  const resize = () => {
    const width = Math.max(element.clientWidth, 1);
    const high = typeof height === 'function' ? height(width) : height;
    renderer.setSize(width, high);
    camera.aspect = width / high;
    camera.updateProjectionMatrix();
    render();
  };
  new ResizeObserver(resize).observe(element);
  resize();
  controls.addEventListener('change', render);

  /// Looks at a box (THREE.Box3) from `direction` (towards the eye), nearly all of it in view.
  const fit = (box, direction = [0.3, -0.65, 0.85]) => {
    const sphere = box.getBoundingSphere(new THREE.Sphere());
    const half = Math.min(camera.fov, camera.fov * camera.aspect) * Math.PI / 360;
    const distance = 0.85 * Math.max(sphere.radius, 1e-3) / Math.sin(half);
    // Centred above the middle, where the instruments come from.
    controls.target.copy(sphere.center).addScaledVector(camera.up, 0.25 * sphere.radius);
    camera.position.set(...direction).normalize().multiplyScalar(distance).add(controls.target);
    camera.near = distance / 100;
    camera.far = distance * 10;
    camera.updateProjectionMatrix();
    controls.update();
    render();
  };
  return {THREE, scene, camera, controls, render, fit};
}

/// A stick between two points that can be moved: a shaft, an arrow's body.
function stick(radius, material) {
  const mesh = new THREE.Mesh(new THREE.CylinderGeometry(radius, radius, 1, 20), material);
  const along = new THREE.Vector3(), up = new THREE.Vector3(0, 1, 0);
  mesh.between = (from, to) => {
    along.subVectors(to, from);
    const length = along.length();
    mesh.visible = length > 1e-6;
    if (!mesh.visible) return;
    mesh.position.addVectors(from, to).multiplyScalar(0.5);
    mesh.scale.set(1, length, 1);
    mesh.quaternion.setFromUnitVectors(up, along.divideScalar(length));
  };
  return mesh;
}

/// An instrument: a shaft with a coloured sleeve and tip, and an arrow for the force at the tip. Tip
/// and arrow are drawn over the organ, because the mesh is too coarse for the dent that hides them.
export class Instrument {
  static metresPerNewton = 0.02;
  static longestArrow = 0.08;

  constructor(colour) {
    this.group = new THREE.Group();
    this.paint = new THREE.MeshStandardMaterial({color: colour, roughness: 0.5});
    this.glow = new THREE.MeshBasicMaterial({color: colour, depthTest: false, transparent: true});
    const steel = new THREE.MeshStandardMaterial({color: 0xb8bec6, roughness: 0.35, metalness: 0.2});
    this.shaft = stick(0.0025, steel);
    this.sleeve = stick(0.0036, this.paint);
    this.tip = new THREE.Mesh(new THREE.SphereGeometry(0.003, 20, 14), this.glow);
    this.arrow = new THREE.Group();
    this.arrowBody = stick(0.0011, this.glow);
    this.arrowHead = new THREE.Mesh(new THREE.ConeGeometry(0.0034, 0.009, 20), this.glow);
    this.arrow.add(this.arrowBody, this.arrowHead);
    this.group.add(this.shaft, this.sleeve, this.tip, this.arrow);
    this.group.visible = false;
  }

  recolour(colour) {
    this.paint.color.set(colour);
    this.glow.color.set(colour);
  }

  /// Tip and trocar in the world (m); force at the tip, N.
  set(tip, trocar, force) {
    const p = new THREE.Vector3(...tip), q = new THREE.Vector3(...trocar);
    const f = new THREE.Vector3(...force);
    this.group.visible = [...tip, ...trocar].every(Number.isFinite);
    this.tip.position.copy(p);
    this.shaft.between(p, q);
    this.sleeve.between(q.clone().lerp(p, 0.4), q);
    const length = Math.min(f.length() * Instrument.metresPerNewton, Instrument.longestArrow);
    this.arrow.visible = length > 0.002;
    if (!this.arrow.visible) return;
    const end = p.clone().addScaledVector(f.normalize(), length);
    this.arrowBody.between(p, end);
    this.arrowHead.position.copy(end);
    this.arrowHead.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), f);
  }
}
