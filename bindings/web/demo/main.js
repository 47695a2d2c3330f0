// A steel hood in three.js. A click dents it where the pointer is; dragging turns the camera.
import { start } from "crumple";
import * as THREE from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { RoomEnvironment } from "three/addons/environments/RoomEnvironment.js";

const element = (id) => document.getElementById(id);
const [depth, shown, status, repair] = ["depth", "shown", "status", "repair"].map(element);

const [crumple, file] = await Promise.all([start(), fetch("hood.crumple").then((r) => r.arrayBuffer())]);
const set = crumple.load(file);
const body = set.body();
body.deform();

// The page keeps a copy of the vertices: the module's memory may move when it grows.
const geometry = new THREE.BufferGeometry();
geometry.setIndex(new THREE.BufferAttribute(set.indices, 1));
const attributes = { position: () => body.positions, normal: () => body.normals };
for (const [name, vertices] of Object.entries(attributes)) {
  geometry.setAttribute(name, new THREE.BufferAttribute(vertices().slice(), 3));
}
geometry.computeBoundingSphere();

const renderer = new THREE.WebGLRenderer({ antialias: true });
document.body.prepend(renderer.domElement);
const scene = new THREE.Scene();
scene.background = new THREE.Color(0x20242a);
scene.environment = new THREE.PMREMGenerator(renderer).fromScene(new RoomEnvironment(), 0.04).texture;
const paint = { color: 0xb3202a, metalness: 0.4, roughness: 0.35, clearcoat: 1, clearcoatRoughness: 0.1 };
const hood = new THREE.Mesh(geometry, new THREE.MeshPhysicalMaterial({ ...paint, side: THREE.DoubleSide }));
// The hood's z points up; three.js' y does.
hood.rotation.x = -Math.PI / 2;
scene.add(hood);
const { center, radius } = geometry.boundingSphere;
hood.position.copy(center.clone().applyEuler(hood.rotation).negate());
const camera = new THREE.PerspectiveCamera(40, 1, radius / 100, radius * 20);
camera.position.set(radius * 0.6, radius * 1.1, radius * 1.3);
const controls = new OrbitControls(camera, renderer.domElement);
controls.minDistance = radius;
controls.maxDistance = radius * 6;

const draw = () => renderer.render(scene, camera);
const resize = () => {
  renderer.setPixelRatio(devicePixelRatio);
  renderer.setSize(innerWidth, innerHeight);
  camera.aspect = innerWidth / innerHeight;
  camera.updateProjectionMatrix();
  draw();
};
addEventListener("resize", resize);
controls.addEventListener("change", draw);
depth.addEventListener("input", () => (shown.textContent = depth.value));

/** Deforms, and uploads only the vertices that changed. */
function update() {
  const began = performance.now();
  const ranges = body.deform();
  const took = performance.now() - began;
  for (const [name, vertices] of Object.entries(attributes)) {
    const attribute = geometry.attributes[name];
    const from = vertices();
    attribute.clearUpdateRanges();
    for (const { first, count } of ranges) {
      attribute.array.set(from.subarray(3 * first, 3 * (first + count)), 3 * first);
      attribute.addUpdateRange(3 * first, 3 * count);
    }
    attribute.needsUpdate = true;
  }
  draw();
  return `${ranges.reduce((all, r) => all + r.count, 0)} vertices in ${took.toFixed(2)} ms`;
}

const ray = new THREE.Raycaster();
let pressed = null;
renderer.domElement.addEventListener("pointerdown", (event) => (pressed = [event.clientX, event.clientY]));
renderer.domElement.addEventListener("pointerup", (event) => {
  if (!pressed || Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) > 4) return;
  const at = new THREE.Vector2((event.clientX / innerWidth) * 2 - 1, 1 - (event.clientY / innerHeight) * 2);
  ray.setFromCamera(at, camera);
  const [hit] = ray.intersectObject(hood);
  if (!hit) return;
  // In the mesh's space. Which way the triangle faces does not matter: the push goes away from the camera.
  const push = hit.face.normal.clone();
  const away = ray.ray.direction.clone().transformDirection(hood.matrixWorld.clone().invert());
  push.multiplyScalar((Math.sign(push.dot(away)) * depth.value) / 1000);
  const told = body.hitDisplacement(hood.worldToLocal(hit.point.clone()), push);
  status.textContent = told === "marked" ? `Dented: ${update()}` : `No dent: ${told}`;
});
repair.addEventListener("click", () => {
  body.repair(0);
  status.textContent = `Repaired: ${update()}`;
});

resize();
status.textContent = `Click the hood: ${set.vertexCount} vertices. Drag to turn it.`;
