// A 3-D view (three.js) that turns with the mouse. World frame and metres as in the engine.
import * as THREE from 'three';
import {OrbitControls} from 'three/examples/jsm/controls/OrbitControls.js';

/// A canvas in `element`; add objects to `scene`, then call render().
export function makeView(element, {height = 420} = {}) {
  const renderer = new THREE.WebGLRenderer({antialias: true, preserveDrawingBuffer: true});
  element.append(renderer.domElement);
  const scene = new THREE.Scene();
  const camera = new THREE.PerspectiveCamera(40, 1, 0.005, 10);
  camera.up.set(0, 0, 1);
  const controls = new OrbitControls(camera, renderer.domElement);
  scene.add(new THREE.HemisphereLight(0xffffff, 0x605050, 2.2));
  const lamp = new THREE.DirectionalLight(0xffffff, 1.2);
  scene.add(lamp);
  const render = () => {
    lamp.position.copy(camera.position);
    renderer.render(scene, camera);
  };
  const resize = () => {
    const width = Math.max(element.clientWidth, 1);
    renderer.setSize(width, height);
    camera.aspect = width / height;
    camera.updateProjectionMatrix();
    render();
  };
  new ResizeObserver(resize).observe(element);
  resize();
  controls.addEventListener('change', render);
  return {THREE, scene, camera, controls, render};
}
