// Reads a glTF with three.js and writes it with its exporter.
//
// node three.mjs NODE_MODULES IN.glb FOLDER

import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { pathToFileURL } from "node:url";

const [modules, input, folder] = process.argv.slice(2);
const three = (path) => import(pathToFileURL(join(modules, "three", path)));

// What a browser has and the exporter uses.
globalThis.FileReader = class {
    read(blob, turn) {
        blob.arrayBuffer().then((bytes) => {
            this.result = turn(bytes);
            this.onloadend();
        });
    }
    readAsArrayBuffer(blob) {
        this.read(blob, (bytes) => bytes);
    }
    readAsDataURL(blob) {
        this.read(blob, (bytes) => `data:application/octet-stream;base64,${Buffer.from(bytes).toString("base64")}`);
    }
};

await three("build/three.module.js");
const { GLTFLoader } = await three("examples/jsm/loaders/GLTFLoader.js");
const { GLTFExporter } = await three("examples/jsm/exporters/GLTFExporter.js");

// Textures need a canvas, which Node does not have.
const loader = new GLTFLoader();
loader.register(() => ({ name: "no textures", loadTexture: async () => null }));
const bytes = readFileSync(input);
const { scene } = await loader.parseAsync(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length), "");
mkdirSync(folder, { recursive: true });
for (const [name, options] of [
    ["plain.glb", { binary: true }],
    ["plain.gltf", { binary: false }],
    ["matrices.glb", { binary: true, trs: false }],
]) {
    const written = await new GLTFExporter().parseAsync(scene, options);
    writeFileSync(join(folder, name), written instanceof ArrayBuffer ? Buffer.from(written) : JSON.stringify(written));
}
