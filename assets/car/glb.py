"""Writes meshes as a glTF 2.0 binary file, the same bytes for the same meshes."""

import json
import struct

import numpy as np
import packing

# Name: base colour, metallic, roughness, further properties.
MATERIALS = {
    "paint": ((0.008, 0.075, 0.25, 1), 0.5, 0.28, {"clearcoat": 1.0}),
    "paint_second": ((0.012, 0.013, 0.015, 1), 0.2, 0.25, {"clearcoat": 1.0}),
    "glass": ((0.015, 0.02, 0.022, 0.72), 0.0, 0.03, {"blend": True}),
    "glass_clear": ((0.9, 0.93, 0.95, 0.12), 0.0, 0.02, {"blend": True}),
    "trim_gloss": ((0.008, 0.008, 0.009, 1), 0.0, 0.12, {}),
    "trim": ((0.018, 0.018, 0.019, 1), 0.0, 0.55, {}),
    "chrome": ((0.82, 0.83, 0.85, 1), 1.0, 0.12, {}),
    "alloy": ((0.60, 0.61, 0.63, 1), 0.9, 0.28, {}),
    "tyre": ((0.012, 0.012, 0.013, 1), 0.0, 0.75, {}),
    "steel": ((0.25, 0.25, 0.26, 1), 0.9, 0.45, {}),
    "lamp_red": ((0.45, 0.006, 0.008, 1), 0.0, 0.06, {"emissive": (0.10, 0.001, 0.001), "clearcoat": 1.0}),
    "lamp_glow": ((0.7, 0.02, 0.02, 1), 0.0, 0.06, {"emissive": (0.75, 0.02, 0.015), "clearcoat": 1.0}),
    "lamp_white": ((0.95, 0.95, 0.95, 1), 0.0, 0.2, {"emissive": (0.18, 0.19, 0.2)}),
    "plate": ((0.75, 0.75, 0.73, 1), 0.0, 0.5, {}),
    "seat": ((0.035, 0.034, 0.036, 1), 0.0, 0.8, {}),
    "inner": ((0.3, 0.32, 0.35, 1), 0.5, 0.6, {}),
}


def material(name):
    colour, metallic, roughness, more = MATERIALS[name]
    m = {"name": name, "pbrMetallicRoughness": {"baseColorFactor": list(colour), "metallicFactor": metallic, "roughnessFactor": roughness}}
    if more.get("blend"):
        m["alphaMode"] = "BLEND"
    if "emissive" in more:
        m["emissiveFactor"] = list(more["emissive"])
    if "clearcoat" in more:
        m["extensions"] = {"KHR_materials_clearcoat": {"clearcoatFactor": more["clearcoat"], "clearcoatRoughnessFactor": 0.03}}
    return m


def to_gltf(v):
    """From x forward, y left, z up to glTF's x left, y up, z forward."""
    return np.ascontiguousarray(v[:, [1, 2, 0]], np.float32)


# Powers of two of what packed numbers are multiples of: 0.03 and 0.06 mm, and a 4096th of a texture.
PLACE, MOVE, TEXEL = -15, -14, -12
NORMAL_BITS = 13


class Store:
    """The buffer of a file, its views and accessors."""

    def __init__(self, packs):
        self.packs, self.data, self.views, self.accessors, self.unpacked = packs, bytearray(), [], [], 0
        self.which, self.moved = [], []

    def _append(self, content):
        while len(self.data) % 4:
            self.data.append(0)
        self.data.extend(content)
        return len(self.data) - len(content)

    def plain(self, array, target):
        at = self._append(array.tobytes())
        self.views.append({"buffer": 0, "byteOffset": at, "byteLength": array.nbytes, "target": target})
        return len(self.views) - 1

    def packed(self, array, mode, filtered="NONE"):
        """A view of packed bytes. The second buffer stands for those that a reader unpacks, and is not in the file."""
        content = packing.rows(array) if mode == "ATTRIBUTES" else packing.sequence(array)
        stride = array.nbytes // len(array)
        extension = {"buffer": 0, "byteOffset": self._append(content), "byteLength": len(content), "byteStride": stride, "mode": mode, "count": len(array)}
        if filtered != "NONE":
            extension["filter"] = filtered
        self.views.append({"buffer": 1, "byteOffset": self.unpacked, "byteLength": array.nbytes, "extensions": {packing.EXTENSION: extension}})
        self.unpacked += (array.nbytes + 3) // 4 * 4
        return len(self.views) - 1

    def accessor(self, view, component, count, kind, **more):
        self.accessors.append({"bufferView": view, "componentType": component, "count": count, "type": kind, **more})
        return len(self.accessors) - 1

    def floats(self, array, kind, exponent, bounds=False):
        array = np.ascontiguousarray(array, np.float32)
        if self.packs:
            stepped = packing.steps(array, exponent)
            array = (np.round(array.astype(float) / 2.0**exponent) * 2.0**exponent).astype(np.float32)
            view = self.packed(stepped, "ATTRIBUTES", "EXPONENTIAL")
        else:
            view = self.plain(array, ARRAY)
        more = {"min": [float(x) for x in array.min(0)], "max": [float(x) for x in array.max(0)]} if bounds else {}
        return self.accessor(view, FLOAT, len(array), kind, **more)

    def normals(self, array):
        if not self.packs:
            return self.floats(array, "VEC3", PLACE)
        view = self.packed(packing.octahedral(array, NORMAL_BITS), "ATTRIBUTES", "OCTAHEDRAL")
        self.views[view]["byteStride"] = 8
        return self.accessor(view, SHORT, len(array), "VEC3", normalized=True)

    def indices(self, triangles, vertices):
        array = np.ascontiguousarray(triangles.reshape(-1), np.uint16 if vertices < 65535 else np.uint32)
        view = self.packed(array, "INDICES") if self.packs else self.plain(array, INDICES)
        return self.accessor(view, U16 if array.dtype == np.uint16 else U32, len(array), "SCALAR")

    def moves(self, moves):
        """A morph target, with the vertices that move. Those of all targets are packed together, by `finish`."""
        whole = np.round(moves / 2.0**MOVE)
        which = np.flatnonzero(whole.any(1))
        bounds = {"min": (whole.min(0) * 2.0**MOVE).tolist(), "max": (whole.max(0) * 2.0**MOVE).tolist()}
        one = {"componentType": FLOAT, "count": len(moves), "type": "VEC3", **bounds}
        if len(which) == 0:
            # An accessor without data is zero.
            return self.shared(one)
        first = sum(len(part) for part in self.which)
        one["sparse"] = {"count": len(which), "indices": {"byteOffset": 4 * first, "componentType": U32}, "values": {"byteOffset": 12 * first}}
        self.which.append(which)
        self.moved.append(moves[which])
        self.accessors.append(one)
        return len(self.accessors) - 1

    def shared(self, one):
        if one not in self.accessors:
            self.accessors.append(one)
        return self.accessors.index(one)

    def finish(self):
        if self.which:
            index = self.packed(np.concatenate(self.which).astype(np.uint32), "INDICES")
            values = self.packed(packing.steps(np.concatenate(self.moved), MOVE), "ATTRIBUTES", "EXPONENTIAL")
            for sparse in (one["sparse"] for one in self.accessors if "sparse" in one):
                sparse["indices"]["bufferView"], sparse["values"]["bufferView"] = index, values
        self.data.extend(bytes(-len(self.data) % 4))


ARRAY, INDICES = 34962, 34963
FLOAT, SHORT, U16, U32 = 5126, 5122, 5123, 5125


def write(path, nodes, extras=None, targets=None, kinds=None):
    """nodes: (name, primitives); a primitive is (material or None, vertices, normals, texture coordinates or None, triangles).

    targets: for each name of a node a list of (name, impact or None, displacements of each primitive in glTF's axes), which become morph targets.
    A file with targets is packed, as EXT_meshopt_compression says.
    kinds: what Crumple is to make of nodes and materials that are no plain sheet, by name: moving or glass.
    """
    names = sorted({p[0] for _, primitives in nodes for p in primitives if p[0]})
    store = Store(packs=targets is not None)
    meshes = []
    for name, primitives in nodes:
        out, moving = [], (targets or {}).get(name, [])
        for k, (mat, v, n, uv, t) in enumerate(primitives):
            a = {"POSITION": store.floats(to_gltf(v), "VEC3", PLACE, bounds=True)}
            if n is not None:
                a["NORMAL"] = store.normals(to_gltf(n))
            if uv is not None:
                a["TEXCOORD_0"] = store.floats(uv, "VEC2", TEXEL)
            p = {"attributes": a, "indices": store.indices(t, len(v))}
            if mat:
                p["material"] = names.index(mat)
            if moving:
                p["targets"] = [{"POSITION": store.moves(pieces[k])} for _, _, pieces in moving]
            out.append(p)
        meshes.append({"name": name, "primitives": out})
        if moving:
            meshes[-1]["weights"] = [0.0] * len(moving)
            meshes[-1]["extras"] = {"targetNames": [one[0] for one in moving], "impacts": [one[1] for one in moving if one[1]]}
    store.finish()
    g = {
        "asset": {"version": "2.0", "generator": "make_car.py", "copyright": "Crumple contributors, MIT OR Apache-2.0"},
        "scene": 0,
        "scenes": [{"name": "car", "nodes": list(range(len(nodes)))}],
        "nodes": [{"name": name, "mesh": i} for i, (name, _) in enumerate(nodes)],
        "meshes": meshes,
        "accessors": store.accessors,
        "bufferViews": store.views,
        "buffers": [{"byteLength": len(store.data)}],
    }
    for node in g["nodes"]:
        if node["name"] in (kinds or {}):
            node["extras"] = {"crumple": kinds[node["name"]]}
    if names:
        g["materials"] = [material(name) for name in names]
        for m in g["materials"]:
            if m["name"] in (kinds or {}):
                m["extras"] = {"crumple": kinds[m["name"]]}
        if any("extensions" in m for m in g["materials"]):
            g["extensionsUsed"] = ["KHR_materials_clearcoat"]
    if store.packs:
        g["scenes"][0]["extras"] = {"targets": "joined"}
        g["extensionsUsed"] = [*g.get("extensionsUsed", []), "KHR_mesh_quantization", packing.EXTENSION]
        g["extensionsRequired"] = ["KHR_mesh_quantization", packing.EXTENSION]
        g["buffers"].append({"byteLength": store.unpacked, "extensions": {packing.EXTENSION: {"fallback": True}}})
    if extras:
        g["asset"]["extras"] = extras
    data = store.data
    text = json.dumps(g, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    body = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(data), 0x004E4942) + bytes(data)
    path.write_bytes(struct.pack("<III", 0x46546C67, 2, 12 + len(body)) + body)
