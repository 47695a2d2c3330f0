"""Writes meshes as a glTF 2.0 binary file, the same bytes for the same meshes."""

import json
import struct

import numpy as np

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


def write(path, nodes, extras=None, targets=None, kinds=None):
    """nodes: (name, primitives); a primitive is (material or None, vertices, normals, texture coordinates or None, triangles).

    targets: for each name of a node a list of (name, impact, displacements of each primitive in glTF's axes), morph targets of 16-bit numbers.
    kinds: what Crumple is to make of nodes and materials that are no plain sheet, by name: moving or glass.
    """
    names = sorted({p[0] for _, primitives in nodes for p in primitives if p[0]})
    data, views, accessors = bytearray(), [], []

    def add(array, target, kind, bounds=False):
        while len(data) % 4:
            data.append(0)
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": array.nbytes, "target": target})
        data.extend(array.tobytes())
        component = {"f": 5126, "H": 5123, "I": 5125}[array.dtype.char if array.dtype.char != "L" else "I"]
        a = {"bufferView": len(views) - 1, "componentType": component, "count": len(array), "type": kind}
        if bounds:
            a["min"], a["max"] = [float(x) for x in array.min(0)], [float(x) for x in array.max(0)]
        accessors.append(a)
        return len(accessors) - 1

    def sparse(moves):
        """A morph target's accessor; displacements are up to a metre."""
        steps = np.round(np.clip(moves, -1, 1) * 32767).astype(np.int16)
        which = np.flatnonzero(steps.any(1))
        which = which if len(which) else np.zeros(1, np.int64)
        add(which.astype(np.uint16 if len(moves) <= 65536 else np.uint32), None, "SCALAR")
        index = accessors.pop()
        views[-1].pop("target")
        while len(data) % 4:
            data.append(0)
        packed = np.ascontiguousarray(steps[which])
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": packed.nbytes})
        data.extend(packed.tobytes())
        accessors.append({
            "componentType": 5122, "normalized": True, "count": len(moves), "type": "VEC3", "min": steps.min(0).tolist(), "max": steps.max(0).tolist(),
            "sparse": {"count": len(which), "indices": {"bufferView": len(views) - 2, "componentType": index["componentType"]}, "values": {"bufferView": len(views) - 1}},
        })  # fmt: skip
        return len(accessors) - 1

    meshes = []
    for name, primitives in nodes:
        out, moving = [], (targets or {}).get(name, [])
        for k, (mat, v, n, uv, t) in enumerate(primitives):
            a = {"POSITION": add(to_gltf(v), 34962, "VEC3", True)}
            if n is not None:
                a["NORMAL"] = add(to_gltf(n), 34962, "VEC3")
            if uv is not None:
                a["TEXCOORD_0"] = add(np.ascontiguousarray(uv, np.float32), 34962, "VEC2")
            kind = np.uint16 if len(v) < 65535 else np.uint32
            p = {"attributes": a, "indices": add(np.ascontiguousarray(t.reshape(-1), kind), 34963, "SCALAR")}
            if mat:
                p["material"] = names.index(mat)
            if moving:
                p["targets"] = [{"POSITION": sparse(pieces[k])} for _, _, pieces in moving]
            out.append(p)
        meshes.append({"name": name, "primitives": out})
        if moving:
            meshes[-1]["weights"] = [0.0] * len(moving)
            meshes[-1]["extras"] = {"targetNames": [one[0] for one in moving], "impacts": [one[1] for one in moving]}
    g = {
        "asset": {"version": "2.0", "generator": "make_car.py", "copyright": "Crumple contributors, MIT OR Apache-2.0"},
        "scene": 0,
        "scenes": [{"name": "car", "nodes": list(range(len(nodes)))}],
        "nodes": [{"name": name, "mesh": i} for i, (name, _) in enumerate(nodes)],
        "meshes": meshes,
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(data)}],
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
    if targets:
        g["scenes"][0]["extras"] = {"targets": "joined"}
        g["extensionsUsed"] = [*g.get("extensionsUsed", []), "KHR_mesh_quantization"]
        g["extensionsRequired"] = ["KHR_mesh_quantization"]
    if extras:
        g["asset"]["extras"] = extras
    while len(data) % 4:
        data.append(0)
    g["buffers"][0]["byteLength"] = len(data)
    text = json.dumps(g, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    body = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(data), 0x004E4942) + bytes(data)
    path.write_bytes(struct.pack("<III", 0x46546C67, 2, 12 + len(body)) + body)
