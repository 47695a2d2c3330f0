// A car in three.js. A click throws something at it from where the camera is, and dragging turns the camera. The address keeps the damage.
import { start } from "crumple";
import * as THREE from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { RoomEnvironment } from "three/addons/environments/RoomEnvironment.js";
import { MeshoptDecoder } from "three/addons/libs/meshopt_decoder.module.js";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";

/** What can be thrown: kg, m, and the shape where it strikes. The car's examples are such blows. */
const THINGS = {
  "a lamp post": { mass: 280, radius: 0.13, shape: "pole" },
  "a wall's corner": { mass: 110, radius: 0.05, shape: "corner" },
  "a heavy ball": { mass: 20, radius: 0.2, shape: "ball" },
  "a stone": { mass: 4, radius: 0.06, shape: "ball" },
};
const HAIL = { mass: 1.2, radius: 0.03, shape: "ball" };
const HAIL_SPEED = 4; // m/s
const FLIGHT = 150; // ms that a throw takes to be seen

const element = (id) => document.getElementById(id);
const [thing, speed, shown, status] = ["thing", "speed", "shown", "status"].map(element);
thing.append(...Object.keys(THINGS).map((name) => new Option(name)));
speed.addEventListener("input", () => (shown.textContent = speed.value));

const loader = new GLTFLoader().setMeshoptDecoder(MeshoptDecoder);
const [crumple, file, model] = await Promise.all([
  start(),
  fetch("car.crumple").then((response) => response.arrayBuffer()),
  loader.loadAsync("car.glb"),
]);
const set = crumple.load(file);
const body = set.body();
body.deform();

// The set is one body: the vertices of all meshes in the order of the file, without those of meshes that move on their own. The page keeps
// copies of its vertices, since the module's memory may move when it grows.
const attributes = { position: () => body.positions, normal: () => body.normals };
const parts = [];
let vertices = 0;
const moves = (node) => node !== null && (node.userData.crumple === "moving" || moves(node.parent));
model.scene.traverse((mesh) => {
  if (!mesh.isMesh || moves(mesh)) return;
  const { geometry, material } = mesh;
  const [first, count] = [vertices, geometry.attributes.position.count];
  for (const [name, all] of Object.entries(attributes)) {
    geometry.setAttribute(name, new THREE.BufferAttribute(all().slice(3 * first, 3 * (first + count)), 3));
  }
  if (material.name.startsWith("paint")) {
    mesh.material = new THREE.MeshPhysicalMaterial({ color: material.color, metalness: 0.5, roughness: 0.4, clearcoat: 1, clearcoatRoughness: 0.05 });
  }
  parts.push({ mesh, first, count, glass: material.name.startsWith("glass") });
  vertices += count;
});
if (vertices !== set.vertexCount) throw new Error(`car.glb has ${vertices} vertices that dent, car.crumple ${set.vertexCount}`);

const renderer = new THREE.WebGLRenderer({ antialias: true });
document.body.prepend(renderer.domElement);
const scene = new THREE.Scene();
scene.background = new THREE.Color(0xd9dde2);
scene.environment = new THREE.PMREMGenerator(renderer).fromScene(new RoomEnvironment(), 0.02).texture;
scene.add(model.scene, shadow());
const flying = new THREE.Mesh(new THREE.SphereGeometry(1, 24, 16), new THREE.MeshStandardMaterial({ color: 0x555048, roughness: 0.9 }));
flying.visible = false;
scene.add(flying);
const camera = new THREE.PerspectiveCamera(29, 1, 0.1, 60);
camera.position.set(3.6, 2.3, 5.4);
const controls = new OrbitControls(camera, renderer.domElement);
controls.target.set(0, 0.65, 0);
controls.minDistance = 3;
controls.maxDistance = 14;
controls.maxPolarAngle = 1.55;
controls.update();

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

/** The shadow below the car. */
function shadow() {
  const canvas = new OffscreenCanvas(128, 128);
  const context = canvas.getContext("2d");
  const fade = context.createRadialGradient(64, 64, 20, 64, 64, 64);
  fade.addColorStop(0, "#2a3036c0");
  fade.addColorStop(1, "#2a303600");
  context.fillStyle = fade;
  context.fillRect(0, 0, 128, 128);
  const material = new THREE.MeshBasicMaterial({ map: new THREE.CanvasTexture(canvas), transparent: true, depthWrite: false });
  const ground = new THREE.Mesh(new THREE.PlaneGeometry(2.9, 6.2), material);
  ground.rotation.x = -Math.PI / 2;
  return ground;
}

/** Deforms, and uploads only the vertices that changed. */
function update(said) {
  const began = performance.now();
  const ranges = body.deform();
  const took = performance.now() - began;
  for (const { mesh, first, count } of parts) {
    const last = first + count;
    const changed = ranges.map((r) => [Math.max(r.first, first), Math.min(r.first + r.count, last)]).filter(([from, to]) => from < to);
    if (changed.length === 0) continue;
    for (const [name, all] of Object.entries(attributes)) {
      const attribute = mesh.geometry.attributes[name];
      attribute.clearUpdateRanges();
      for (const [from, to] of changed) {
        attribute.array.set(all().subarray(3 * from, 3 * to), 3 * (from - first));
        attribute.addUpdateRange(3 * (from - first), 3 * (to - from));
      }
      attribute.needsUpdate = true;
    }
  }
  draw();
  status.textContent = `${said}: ${ranges.reduce((all, r) => all + r.count, 0)} vertices in ${took.toFixed(1)} ms`;
}

// The damage as text: the library's bytes, and which panes are broken.
const broken = () => parts.flatMap(({ mesh, glass }, i) => (glass && !mesh.visible ? [i] : []));
function keep() {
  const bytes = btoa(String.fromCharCode(...body.save())).replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "");
  history.replaceState(null, "", `#${[bytes, ...broken()].join(".")}`);
}
function restore() {
  const [bytes, ...panes] = location.hash.slice(1).split(".");
  if (!bytes) return false;
  body.load(Uint8Array.from(atob(bytes.replaceAll("-", "+").replaceAll("_", "/")), (letter) => letter.charCodeAt(0)));
  parts.forEach(({ mesh }, i) => (mesh.visible = !panes.includes(String(i))));
  update("As the address says");
  return true;
}

/** Strikes the car at a place with a unit normal. Returns what became of it. */
function strike({ mass, radius, shape }, point, normal, velocity) {
  return body.hit(point, { normal, strikerMass: mass, strikerRadius: radius, strikerShape: shape, strikerVelocity: velocity });
}

/** The nearest part that a ray meets, where, and the unit normal there. */
function met(ray) {
  const meshes = parts.filter(({ mesh }) => mesh.visible).map(({ mesh }) => mesh);
  const [hit] = ray.intersectObjects(meshes, false);
  if (!hit) return null;
  // Out of the car, whichever way the triangle faces.
  const normal = hit.face.normal.clone();
  normal.multiplyScalar(-Math.sign(normal.dot(ray.ray.direction)) || 1);
  return { point: hit.point, normal, part: parts.find(({ mesh }) => mesh === hit.object) };
}

/** Shows the thing on its way, and strikes. */
async function throwAt(hit, direction) {
  const one = THINGS[thing.value];
  flying.scale.setScalar(one.radius);
  flying.visible = true;
  const began = performance.now();
  for (let t = 0; t < 1; t = (performance.now() - began) / FLIGHT) {
    flying.position.lerpVectors(camera.position, hit.point, t);
    draw();
    await new Promise(requestAnimationFrame);
  }
  flying.visible = false;
  if (hit.part.glass) {
    hit.part.mesh.visible = false;
    update("Glass broke");
  } else {
    const told = strike(one, hit.point, hit.normal, direction.clone().multiplyScalar(speed.value));
    if (told === "marked") update("Dented");
    else [draw(), (status.textContent = `No dent: ${told}`)];
  }
  keep();
}

const ray = new THREE.Raycaster();
let pressed = null;
renderer.domElement.addEventListener("pointerdown", (event) => (pressed = [event.clientX, event.clientY]));
renderer.domElement.addEventListener("pointerup", (event) => {
  if (!pressed || flying.visible || Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) > 4) return;
  ray.setFromCamera(new THREE.Vector2((event.clientX / innerWidth) * 2 - 1, 1 - (event.clientY / innerHeight) * 2), camera);
  const hit = met(ray);
  if (hit) throwAt(hit, ray.ray.direction);
});
element("rain").addEventListener("click", () => {
  const down = new THREE.Vector3(0, -1, 0);
  for (let stones = 0, tries = 0; stones < 12 && tries < 60; tries++) {
    ray.set(new THREE.Vector3(1.6 * Math.random() - 0.8, 3, 4.2 * Math.random() - 2.1), down);
    const hit = met(ray);
    if (hit && !hit.part.glass && strike(HAIL, hit.point, hit.normal, [0, -HAIL_SPEED, 0]) === "marked") stones++;
  }
  update("Hail");
  keep();
});
element("repair").addEventListener("click", () => {
  body.repair(0);
  parts.forEach(({ mesh }) => (mesh.visible = true));
  update("Repaired");
  history.replaceState(null, "", location.pathname);
});
addEventListener("hashchange", restore);

resize();
if (!restore()) status.textContent = `Click the car: ${set.vertexCount} vertices. Drag to turn it.`;
// When the first picture was drawn, ms after the page was asked for.
document.body.dataset.drawn = performance.now().toFixed(0);
