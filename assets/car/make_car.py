"""Makes a passenger car (numpy): panels, glass, lamps, wheels and an inner structure.

    python3 make_car.py OUT_FOLDER

It writes
  car.glb           the car: a node for each part, every part a mesh of its own with folded borders
  car_coarse.glb    the same parts with under a third of the vertices
  car_body.glb      the skin as one closed mesh, from which examples of dents are made
  car_inner.glb     the inner structure: closed solids that dents may not enter
  car_collider.glb  two closed solids for a physics engine
  car.json          what was measured

The same versions of Python and numpy write the same bytes. Nothing is taken from elsewhere, and nothing is random."""

import json
import sys
from pathlib import Path

import numpy as np

import components
import glb
import inner
import panels
import shape as s
from panels import left_half, mirrored, sheet, whole
from solids import blob, joined

FINE, COARSE = 0.0256, 0.07  # metres between vertices
# Labels of the skin's faces, and the materials that they have in car_body.glb.
SKIN = {
    "paint": ["hood", "trunk", "bumper_front", "bumper_rear", "body_rear", "skin", "fuel_cap", "fender", "door", "door_front"],
    "paint_second": ["roof"],
    "glass": ["glass_side", "glass_screen"],
    "trim_gloss": ["pillar_trim", "screen", "headlamp"],
    "trim": ["gap", "window", "cowl", "underbody", "lip", "diffuser", "grille", "intake", "fog"],
    "chrome": ["belt_trim", "grille_frame"],
    "lamp_red": ["taillamp", "tail_bar"],
    "lamp_glow": ["tail_glow"],
    "lamp_white": ["drl"],
}


class Parts:
    """Nodes by name; each has a mesh for each material."""

    def __init__(self):
        self.nodes = {}

    def add(self, name, material, mesh):
        self.nodes.setdefault(name, {}).setdefault(material, []).append(mesh)

    def sides(self, name, material, mesh):
        self.add(name + "_left", material, mesh)
        self.add(name + "_right", material, mirrored(*mesh))

    def middle(self, name, material, mesh):
        self.add(name, material, whole(*mesh))

    def list(self):
        return [(name, primitives(meshes)) for name, meshes in self.nodes.items()]


def primitives(meshes):
    """(material, vertices, normals, texture coordinates, triangles) of each material."""
    whole_part = joined(*[mesh for some in meshes.values() for mesh in some])
    frame = texture_frame(*whole_part[:2])
    out = []
    for material, some in meshes.items():
        v, n, t = joined(*some)
        out.append((material, v, n, texture(v, frame), t))
    return out


def texture_frame(v, n):
    """The axis that a part faces most, and where it begins and how large it is across that axis."""
    axis = int(np.abs(n).mean(0).argmax())
    uv = np.delete(v, axis, 1)
    return axis, uv.min(0), (uv.max(0) - uv.min(0)).max()


def texture(v, frame):
    """Texture coordinates: the part seen along an axis, fitted into the unit square."""
    axis, low, size = frame
    return np.clip((np.delete(v, axis, 1) - low) / size, 0, 1)


def skin_parts(parts, skin):
    """The panels, the glass and the lamps' lenses."""
    for name in ("hood", "trunk"):
        parts.middle(name, "paint", sheet(skin, name))
    parts.middle("trunk", "lamp_red", sheet(skin, "tail_bar", folded=False))
    parts.middle("trunk", "lamp_glow", sheet(skin, "tail_glow", folded=False))
    parts.middle("roof", "paint_second", sheet(skin, "roof"))
    for name in ("bumper_front", "bumper_rear"):
        parts.middle(name, "paint", sheet(skin, name, depth=0.03))
    parts.middle("bumper_front", "trim", sheet(skin, "lip"))
    parts.middle("bumper_rear", "trim", sheet(skin, "diffuser", inset=0.004))
    parts.middle("grille", "chrome", sheet(skin, "grille_frame", depth=0.03))
    for name in ("grille", "intake"):
        parts.middle("grille", "trim", sheet(skin, name, inset=0.05, folded=False))
    parts.middle("cowl", "trim", sheet(skin, "cowl"))
    for where, front in (("windscreen", True), ("rear_window", False)):
        for label, material, inset in (("glass_screen", "glass", 0.004), ("screen", "trim_gloss", 0.003)):
            v, n, t = sheet(skin, label, inset=inset, folded=False)
            t = t[(v[t].mean(1)[:, 0] > 0) == front]
            used, index = np.unique(t, return_inverse=True)
            parts.middle(where, material, (v[used], n[used], index.reshape(-1, 3)))
    parts.sides("body", "paint", sheet(skin, "body_rear", "skin", depth=0.03))
    parts.sides("body", "paint", sheet(skin, "fuel_cap"))
    parts.sides("fender", "paint", sheet(skin, "fender", depth=0.03))
    parts.sides("door_front", "paint", sheet(skin, "door_front"))
    parts.sides("door_rear", "paint", sheet(skin, "door"))
    for label, material, inset in (("glass_side", "glass", 0.004), ("pillar_trim", "trim_gloss", 0.001), ("window", "trim", 0.002), ("belt_trim", "chrome", 0.0)):
        parts.sides("window", material, sheet(skin, label, inset=inset, folded=False))
    for label, material, inset in (("headlamp", "glass_clear", 0), ("drl", "glass_clear", 0), ("headlamp", "trim_gloss", 0.045), ("drl", "lamp_white", 0.012)):
        parts.sides("headlamp", material, sheet(skin, label, inset=inset, folded=False))
    parts.sides("taillamp", "lamp_red", sheet(skin, "taillamp", folded=False))
    parts.sides("foglamp", "trim", sheet(skin, "fog", inset=0.045, folded=False))


def left_of(v, n, t):
    """The left half of a mesh, closed at the middle when it is mirrored."""
    left = v[t].mean(1)[:, 1] > 0
    v = v.copy()
    v[np.intersect1d(t[left], t[~left]), 1] = 0
    t = t[left]
    area = np.linalg.norm(np.cross(v[t[:, 1]] - v[t[:, 0]], v[t[:, 2]] - v[t[:, 0]]), axis=1) / 2
    used, index = np.unique(t[area > 1e-7], return_inverse=True)
    return v[used], n[used], index.reshape(-1, 3)


def mounted_parts(parts, fine):
    """What is not cut from the skin."""
    for y, z in ((0.60, 0.664), (0.715, 0.684)):
        for material, mesh in components.projector(y, z, 0.033, 0.016, fine):
            parts.sides("headlamp", material, mesh)
    for material, mesh in components.projector(0.735, 0.405, 0.030, 0.028, fine):
        parts.sides("foglamp", material, mesh)
    parts.add("grille", "trim_gloss", components.grille_bars(panels.grille, np.linspace(0.512, 0.622, 5), 0.022, (0.030, 0.011), fine))
    parts.add("grille", "trim", components.grille_bars(panels.intake, np.linspace(0.285, 0.365, 3), 0.025, (0.030, 0.010), fine))
    parts.add("plate_front", "plate", components.plate(False))
    parts.add("plate_rear", "plate", components.plate(True))
    parts.add("interior", "seat", components.interior(fine))
    parts.middle("chassis", "trim", left_of(*blob(components.chassis, (-2.3, -1, 0.15), (2.2, 1, 1.05), 0.06 if fine else 0.12)))
    parts.add("antenna", "paint_second", components.antenna(fine))
    parts.sides("exhaust", "chrome", components.exhaust(fine))
    for material, mesh in components.mirror(fine):
        parts.sides("mirror", material, mesh)
    for end, x in zip(("front", "rear"), s.HANDLES):
        parts.sides("handle_" + end, "chrome", components.handle(x, fine))
    for y0, y1 in ((-0.05, 0.52), (-0.60, -0.08)):
        parts.add("wipers", "trim", components.wiper(y0, y1))
    for name, some in components.wheels(fine).items():
        for material, mesh in some:
            parts.add(name, material, mesh)


def body(skin):
    """The skin as one closed mesh: panels, glass and lamps, and dark strips where the gaps are. It is open in the wheel arches."""
    labels = [label for some in SKIN.values() for label in some]
    v, t = skin.extract(*labels)
    material = np.concatenate([np.full(np.isin(skin.label, some).sum(), name, dtype="U16") for name, some in SKIN.items()])
    order = np.concatenate([np.flatnonzero(np.isin(skin.label, some)) for some in SKIN.values()])
    rank = np.empty(len(skin.label), int)
    rank[order] = np.arange(len(order))
    material = material[rank[np.isin(skin.label, labels)]]
    v, n, both = whole(v, panels.normals(v), t)
    frame = texture_frame(v, n)
    out = []
    for name in SKIN:
        chosen = both[np.tile(material == name, 2)]
        used, index = np.unique(chosen, return_inverse=True)
        if len(used):
            out.append((name, v[used], n[used], texture(v[used], frame), index.reshape(-1, 3)))
    return out


def proportions(nodes):
    """Sizes in metres and their ratios, of the parts as they are."""
    def bounds(*names):
        v = np.concatenate([p[1] for name, primitives in nodes if name.startswith(names) for p in primitives])
        return v.min(0), v.max(0)

    low, high = bounds("body", "hood", "trunk", "roof", "bumper", "fender", "door", "headlamp", "taillamp")
    front, rear = bounds("wheel_front_left"), bounds("wheel_rear_left")
    centre = [(b[0][0] + b[1][0]) / 2 for b in (front, rear)]
    length, width = (high - low)[:2]
    height = high[2]
    wheelbase, diameter = centre[0] - centre[1], front[1][2] - front[0][2]
    track = front[0][1] + front[1][1]
    return {
        "length": length, "width": width, "height": height, "wheelbase": wheelbase, "track": track, "wheel_diameter": diameter,
        "ground_clearance": low[2], "front_overhang": high[0] - centre[0], "rear_overhang": centre[1] - low[0],
        "wheelbase_to_length": wheelbase / length, "height_to_length": height / length, "width_to_length": width / length,
        "front_overhang_to_length": (high[0] - centre[0]) / length, "rear_overhang_to_length": (centre[1] - low[0]) / length,
        "wheel_to_height": diameter / height, "track_to_width": track / width,
    }


# Rules of thumb for cars of this class, not measurements of one.
EXPECTED = {
    "length": (4.2, 4.7), "wheelbase_to_length": (0.58, 0.62), "height_to_length": (0.31, 0.36), "width_to_length": (0.38, 0.43),
    "front_overhang_to_length": (0.17, 0.21), "rear_overhang_to_length": (0.18, 0.24), "wheel_to_height": (0.43, 0.49),
    "track_to_width": (0.83, 0.89), "ground_clearance": (0.12, 0.22),
}


def main():
    if len(sys.argv) != 2:
        raise SystemExit(__doc__)
    out = Path(sys.argv[1])
    out.mkdir(parents=True, exist_ok=True)
    facts = {}
    for name, size in (("car", FINE), ("car_coarse", COARSE)):
        skin, parts = left_half(size), Parts()
        skin_parts(parts, skin)
        mounted_parts(parts, size == FINE)
        nodes = parts.list()
        glb.write(out / f"{name}.glb", nodes)
        facts[name] = count(nodes)
        if size == FINE:
            glb.write(out / "car_body.glb", [("body", body(skin))])
            facts["proportions"] = {key: round(float(value), 4) for key, value in proportions(nodes).items()}
    for key, (low, high) in EXPECTED.items():
        if not low <= facts["proportions"][key] <= high:
            raise SystemExit(f"{key} is {facts['proportions'][key]}; a car of this class has {low} to {high}")
    for name, meshes, material in (("car_inner", inner.solids(), "inner"), ("car_collider", inner.collider(), None)):
        nodes = [(part, primitives({material: [mesh]})) for part, mesh in meshes.items()]
        glb.write(out / f"{name}.glb", nodes)
        facts[name] = count(nodes)
    (out / "car.json").write_text(json.dumps(facts, indent=1) + "\n")
    for name in ("car", "car_coarse", "car_inner", "car_collider"):
        print(f"{name}.glb: {len(facts[name])} parts, {sum(facts[name].values())} vertices")


def count(nodes):
    return {name: int(sum(len(p[1]) for p in primitives)) for name, primitives in nodes}


if __name__ == "__main__":
    main()
