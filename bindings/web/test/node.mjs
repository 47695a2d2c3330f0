// Compares the module with the native library: node node.mjs CRUMPLE.WASM SET.crumple IMPACTS.json DENTED.glb
// DENTED.glb is what `crumple apply SET.crumple --impacts IMPACTS.json` wrote. The vertices must have the same bits.
import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";

import { start } from "../crumple.js";

const [wasm, file, impacts, dented] = await Promise.all(process.argv.slice(2).map((path) => readFile(path)));
const crumple = await start(wasm);
const set = crumple.load(file);
const body = set.body();
const given = JSON.parse(impacts);
let marked = 0;
for (const { point, displacement, normal, impulse, duration, striker } of given) {
  const status = displacement
    ? body.hitDisplacement(point, displacement)
    : body.hit(point, {
        normal,
        impulse,
        duration,
        strikerMass: striker?.mass,
        strikerVelocity: striker?.velocity,
        strikerRadius: striker?.radius,
        strikerShape: striker?.shape,
      });
  // A hailstone may be too weak to leave anything.
  assert.ok(status === "marked" || status === "below yield", status);
  marked += status === "marked";
}
assert.ok(marked > 0.9 * given.length, `${marked} of ${given.length} hits left a mark`);
assert.deepEqual(body.deform(), [{ first: 0, count: set.vertexCount }], "the first time all vertices are written");

const expected = glb(dented);
assert.deepEqual(new Uint32Array(body.positions.slice().buffer), expected.POSITION, "positions have other bits");
assert.deepEqual(new Uint32Array(body.normals.slice().buffer), expected.NORMAL, "normals have other bits");
assert.deepEqual(body.deform(), [], "nothing changed since");

// Saved damage makes the same vertices, and repair brings the body back.
const other = set.body();
set.free();
other.load(body.save());
other.deform();
assert.deepEqual(other.positions, body.positions);
body.repair(0);
assert.ok(body.deform().length > 0);
assert.notDeepEqual(other.positions, body.positions);
assert.equal(body.hitDisplacement([0, 0, 0], [0, 0, 0]), "below yield");

// Errors say what is wrong and change nothing.
assert.throws(() => crumple.load(new Uint8Array(100)), /crumple/i);
assert.throws(() => other.repair(2), /keep is 2/);
assert.throws(() => other.hit([0, 0, 0], {}), /impulse/);
assert.throws(() => other.hit([0, 0, 0], { strikerShape: "cone" }), /strikerShape is cone/);
assert.throws(() => other.hitDisplacement([0, 0], [0, 0, 0]), /point must be three numbers/);
assert.throws(() => other.load(new Uint8Array(3)), /damage/);
assert.throws(() => set.body(), /freed/);
assert.deepEqual(other.deform(), []);
body.free();
other.free();
assert.throws(() => body.deform(), /freed/);
console.log(`${given.length} hits on ${set.vertexCount} vertices: the same bits as the native library`);

/** The bits of the first primitive's attributes. */
function glb(bytes) {
  const length = bytes.readUInt32LE(12);
  const { meshes, accessors, bufferViews } = JSON.parse(bytes.toString("utf8", 20, 20 + length));
  const binary = bytes.subarray(20 + length + 8);
  const attribute = (name) => {
    const { bufferView, byteOffset = 0, count } = accessors[meshes[0].primitives[0].attributes[name]];
    const at = (bufferViews[bufferView].byteOffset ?? 0) + byteOffset;
    assert.equal(bufferViews[bufferView].byteStride ?? 12, 12);
    return new Uint32Array(Uint8Array.prototype.slice.call(binary, at, at + 12 * count).buffer);
  };
  return { POSITION: attribute("POSITION"), NORMAL: attribute("NORMAL") };
}
