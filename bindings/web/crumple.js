/** Crumple in WebAssembly: see crumple.d.ts for what each part does. */

const STATUS = ["marked", "below yield", "nothing reaches", "accumulated", "rigid"];
const SHAPES = ["unknown", "ball", "pole", "corner", "wall"];

/** Starts the module. `source` is where crumple.wasm is, or its bytes. */
export async function start(source = new URL("crumple.wasm", import.meta.url)) {
  const bytes = source instanceof URL || typeof source === "string" ? await fetched(source) : source;
  const { instance } = await WebAssembly.instantiate(bytes, {});
  return new Crumple(instance.exports);
}

async function fetched(url) {
  const response = await fetch(url);
  if (!response.ok) throw new Error(`${url}: ${response.status} ${response.statusText}`);
  return response.arrayBuffer();
}

// Memory that grows has another buffer, so views of it are made anew each time.
class Crumple {
  #exports;

  constructor(exports) {
    this.#exports = exports;
  }

  /** Makes a set from the bytes of a .crumple file. */
  load(file) {
    const e = this.#exports;
    const bytes = file instanceof Uint8Array ? file : new Uint8Array(file);
    const at = e.alloc(bytes.length);
    new Uint8Array(e.memory.buffer).set(bytes, at);
    const set = e.set_load(at, bytes.length);
    if (set === 0) throw this.#error();
    return new ExampleSet(e, set, () => this.#error());
  }

  #error() {
    const e = this.#exports;
    return new Error(new TextDecoder().decode(new Uint8Array(e.memory.buffer, e.error(), e.error_bytes()).slice()));
  }
}

class ExampleSet {
  #exports;
  #set;
  #error;

  constructor(exports, set, error) {
    [this.#exports, this.#set, this.#error] = [exports, set, error];
    this.vertexCount = exports.set_vertices(set);
    this.depthLimit = exports.set_depth_limit(set);
    const triangles = exports.set_triangle_count(set);
    this.indices = new Uint32Array(exports.memory.buffer, exports.set_triangles(set), 3 * triangles).slice();
  }

  body() {
    const body = this.#exports.body_new(this.#given());
    if (body === 0) throw this.#error();
    return new Body(this.#exports, body, this.vertexCount, this.#error);
  }

  free() {
    if (this.#set !== 0) this.#exports.set_free(this.#set);
    this.#set = 0;
  }

  #given() {
    if (this.#set === 0) throw new Error("the set was freed");
    return this.#set;
  }
}

class Body {
  #exports;
  #body;
  #error;
  #count;
  #numbers;

  constructor(exports, body, count, error) {
    [this.#exports, this.#body, this.#count, this.#error] = [exports, body, count, error];
    this.#numbers = exports.alloc(64);
  }

  get positions() {
    return this.#vertices(this.#exports.body_positions(this.#given()));
  }

  get normals() {
    const at = this.#exports.body_normals(this.#given());
    return at === 0 ? null : this.#vertices(at);
  }

  hitDisplacement(point, displacement) {
    return this.#hit(this.#exports.body_displace, [...three(point, "point"), ...three(displacement, "displacement")]);
  }

  hit(point, { normal, impulse, duration, strikerMass, strikerVelocity, strikerRadius, strikerShape = "unknown" } = {}) {
    const shape = SHAPES.indexOf(strikerShape);
    if (shape < 0) throw new TypeError(`strikerShape is ${strikerShape}; it must be one of ${SHAPES.join(", ")}`);
    const vector = (v, name) => (v === undefined ? [NaN, NaN, NaN] : three(v, name));
    return this.#hit(this.#exports.body_blow, [
      ...three(point, "point"),
      ...vector(normal, "normal"),
      ...vector(impulse, "impulse"),
      duration ?? NaN,
      strikerMass ?? NaN,
      ...vector(strikerVelocity, "strikerVelocity"),
      strikerRadius ?? NaN,
      shape,
    ]);
  }

  deform() {
    const e = this.#exports;
    const count = this.#checked(e.body_deform(this.#given()));
    const pairs = new Uint32Array(e.memory.buffer, e.body_changed(this.#body), 2 * count);
    return Array.from({ length: count }, (_, i) => ({ first: pairs[2 * i], count: pairs[2 * i + 1] }));
  }

  repair(keep = 0) {
    this.#checked(this.#exports.body_repair(this.#given(), keep));
  }

  save() {
    const e = this.#exports;
    const bytes = e.body_save(this.#given());
    return new Uint8Array(e.memory.buffer, e.body_saved(this.#body), bytes).slice();
  }

  load(saved) {
    const e = this.#exports;
    const body = this.#given();
    const at = e.alloc(saved.length);
    new Uint8Array(e.memory.buffer).set(saved, at);
    const result = e.body_load(body, at, saved.length);
    e.free(at, saved.length);
    this.#checked(result);
  }

  free() {
    if (this.#body === 0) return;
    this.#exports.body_free(this.#body);
    this.#exports.free(this.#numbers, 64);
    this.#body = 0;
  }

  #hit(call, numbers) {
    const body = this.#given();
    new Float32Array(this.#exports.memory.buffer, this.#numbers, numbers.length).set(numbers);
    return STATUS[this.#checked(call(body, this.#numbers))];
  }

  #vertices(at) {
    return new Float32Array(this.#exports.memory.buffer, at, 3 * this.#count);
  }

  #checked(result) {
    if (result < 0) throw this.#error();
    return result;
  }

  #given() {
    if (this.#body === 0) throw new Error("the body was freed");
    return this.#body;
  }
}

function three(v, name) {
  const [x, y, z, ...more] = v;
  if (z === undefined || more.length > 0) throw new TypeError(`${name} must be three numbers`);
  return [x, y, z];
}
