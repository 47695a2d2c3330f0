"""Makes the demo's bodies from solvers' meshes (numpy, scipy): drum.glb, hood.glb, the hood's hits, hood.json, and engine.glb, a
box under the hood that dents must not enter.

    python3 make_demo.py

The solver's grid is refined three times (bicubic on its parameters), its first dents become sparse morph targets, and
what a scene would have is added: normals, texture coordinates, materials.

The drum is the tube of ../solver with eight dents. Its texture coordinates have a seam, and it gets lids of a second
material. The lids stand on the drum's rings, which the solver held fixed, so no example moves them.

The hood is the steel hood of ../../lab/data/steel with twelve dents and the blows that made them. The two sides of its
character line are refined separately, so the line stays sharp. hood.json has five of its held-out blows, as a rigid-body
engine would report them."""
import json, struct
from pathlib import Path
import numpy as np
from scipy.interpolate import RectBivariateSpline

HERE = Path(__file__).parent
STEEL = HERE.parent.parent / "lab/data/steel/hood"
FACTOR = 3  # refinement
CREASE = 30  # row of the steel hood's character line


def read(path):
    d = path.read_bytes()
    n = struct.unpack("<I", d[12:16])[0]
    g = json.loads(d[20 : 20 + n])
    b = d[28 + n :]

    def view(i, dtype, width):
        v = g["bufferViews"][i]
        return np.frombuffer(b, dtype, v["byteLength"] // 4, v["byteOffset"]).reshape(-1, width)

    def accessor(i):
        a = g["accessors"][i]
        w = {"VEC3": 3, "SCALAR": 1}[a["type"]]
        x = view(a["bufferView"], np.float32 if a["componentType"] == 5126 else np.uint32, w).copy() if "bufferView" in a else np.zeros((a["count"], w), np.float32)
        if "sparse" in a:
            s = a["sparse"]
            x[view(s["indices"]["bufferView"], np.uint32, 1).ravel()] = view(s["values"]["bufferView"], np.float32, 3)
        return x

    m = g["meshes"][0]
    p = m["primitives"][0]
    return accessor(p["attributes"]["POSITION"]), [accessor(t["POSITION"]) for t in p["targets"]], m["extras"]


def refine(field, shape, wraps, crease=None):
    """A field over the solver's grid (n, 3) on the finer grid. A wrapping grid gets its first column again at the end.
    No spline crosses the row `crease`."""
    nx, ny = shape
    f = field.reshape(nx, ny, 3).astype(float)
    if crease is not None:
        low, high = (refine(part, part.shape[:2], wraps) for part in (f[:, : crease + 1], f[:, crease:]))
        return np.concatenate([low, high[:, 1:]], 1)
    pad = 8 if wraps else 0
    f = np.concatenate([f[-pad:], f, f[: pad + 1]]) if wraps else f
    u = np.arange(nx * FACTOR + 1 if wraps else (nx - 1) * FACTOR + 1) / FACTOR
    v = np.arange((ny - 1) * FACTOR + 1) / FACTOR
    at = np.arange(len(f)) - pad
    return np.stack([RectBivariateSpline(at, np.arange(ny), f[..., k], kx=3, ky=3, s=0)(u, v) for k in range(3)], -1)


def grid_triangles(nx, ny):
    i, j = np.meshgrid(np.arange(nx - 1), np.arange(ny - 1), indexing="ij")
    a = (i * ny + j).ravel()
    return np.concatenate([np.stack([a, a + ny, a + ny + 1], 1), np.stack([a, a + ny + 1, a + 1], 1)])


def normals(v, t, seam=None):
    f = np.cross(v[t[:, 1]] - v[t[:, 0]], v[t[:, 2]] - v[t[:, 0]])
    n = np.zeros_like(v)
    for k in range(3):
        np.add.at(n, t[:, k], f)
    if seam is not None:
        a, b = seam
        n[a] = n[b] = n[a] + n[b]
    return n / np.linalg.norm(n, axis=1, keepdims=True)


class Glb:
    def __init__(self):
        self.bin, self.views, self.accessors = bytearray(), [], []

    def view(self, a, target=None):
        self.bin += b"\0" * (-len(self.bin) % 4)
        v = dict(buffer=0, byteOffset=len(self.bin), byteLength=a.nbytes)
        if target:
            v["target"] = target
        self.bin += a.tobytes()
        self.views.append(v)
        return len(self.views) - 1

    def accessor(self, a, target=34962, bounds=False):
        kind = {1: "SCALAR", 2: "VEC2", 3: "VEC3"}[1 if a.ndim == 1 else a.shape[1]]
        x = dict(bufferView=self.view(a, target), componentType=5125 if a.dtype == np.uint32 else 5126, count=len(a), type=kind)
        if bounds:
            x.update(min=a.min(0).tolist(), max=a.max(0).tolist())
        self.accessors.append(x)
        return len(self.accessors) - 1

    def sparse(self, index_view, values, count, n):
        x = dict(componentType=5126, count=n, type="VEC3")
        full = np.vstack([values, np.zeros((1, 3), np.float32)]) if count < n else values
        x.update(min=full.min(0).tolist(), max=full.max(0).tolist())
        if count:
            x["sparse"] = dict(count=count, indices=dict(bufferView=index_view, componentType=5125), values=dict(bufferView=self.view(values)))
        self.accessors.append(x)
        return len(self.accessors) - 1

    def primitive(self, v, n, uv, t, material, dents, keep):
        targets = []
        for d, dn in dents:
            at = np.nonzero(np.linalg.norm(d, axis=1) > keep)[0].astype(np.uint32)
            i = self.view(at) if len(at) else None
            targets.append({k: self.sparse(i, x[at].astype(np.float32), len(at), len(v)) for k, x in (("POSITION", d), ("NORMAL", dn))})
        attributes = dict(POSITION=self.accessor(v.astype(np.float32), bounds=True), NORMAL=self.accessor(n.astype(np.float32)), TEXCOORD_0=self.accessor(uv.astype(np.float32)))
        return dict(attributes=attributes, indices=self.accessor(t.astype(np.uint32).ravel(), 34963), material=material, targets=targets)

    def write(self, name, primitives, materials, impacts):
        path, names = HERE / f"{name}.glb", [i["name"] for i in impacts]
        up = [-(0.5**0.5), 0, 0, 0.5**0.5]  # the arrays are z up, glTF is y up
        g = dict(
            asset=dict(version="2.0", generator="crumple assets/demo/make_demo.py"), scene=0, scenes=[dict(nodes=[0])],
            nodes=[dict(name=name, rotation=up, children=[1]), dict(name=name + "_mesh", mesh=0)], materials=materials,
            meshes=[dict(name=name, primitives=primitives, weights=[0.0] * len(names), extras=dict(targetNames=names, impacts=impacts, units="m"))],
            accessors=self.accessors, bufferViews=self.views, buffers=[dict(byteLength=len(self.bin) + -len(self.bin) % 4)],
        )
        j = json.dumps(g, separators=(",", ":")).encode()
        j += b" " * (-len(j) % 4)
        self.bin += b"\0" * (-len(self.bin) % 4)
        path.write_bytes(struct.pack("<IIIII", 0x46546C67, 2, 28 + len(j) + len(self.bin), len(j), 0x4E4F534A) + j + struct.pack("<II", len(self.bin), 0x4E4942) + self.bin)
        print(path.name, f"{path.stat().st_size / 1e6:.2f} MB")


def material(name, colour, metallic, roughness):
    return dict(name=name, doubleSided=True, pbrMetallicRoughness=dict(baseColorFactor=[*colour, 1], metallicFactor=metallic, roughnessFactor=roughness))


def body(name, base, dents, impacts, shape, materials, keep, wraps=False, crease=None):
    """Writes one body. Displacements below `keep` (m) are dropped."""
    fine = refine(base, shape, wraps, crease)
    nx, ny = fine.shape[:2]
    v = fine.reshape(-1, 3)
    if wraps:  # the refined ring is round, as the solver's was meant to be
        a = np.arctan2(v[:, 1], v[:, 0])
        v[:, :2] = 0.3 * np.stack([np.cos(a), np.sin(a)], 1)
    seam = (np.arange(ny), np.arange(ny) + (nx - 1) * ny) if wraps else None
    if wraps:
        v[seam[1]] = v[seam[0]]
    t = grid_triangles(nx, ny)
    n = normals(v, t, seam)
    if (n * (v if wraps else [0, 0, 1])).sum() < 0:
        t = t[:, ::-1]
        n = -n
    u = np.stack(np.meshgrid(np.linspace(0, 1, nx), np.linspace(0, 1, ny), indexing="ij"), -1).reshape(-1, 2)
    ready = []
    for d in dents:
        d = refine(d, shape, wraps, crease).reshape(-1, 3)
        rim = np.zeros((nx, ny), bool)
        rim[:, [0, -1]] = True
        if not wraps:
            rim[[0, -1]] = True
        d[rim.ravel()] = 0
        if wraps:
            d[seam[1]] = d[seam[0]]
        # As 32-bit numbers from here on, so that what is written is what normals were computed from.
        d = d.astype(np.float32).astype(float)
        ready.append((d, normals(v + d, t, seam) - n))
    g = Glb()
    primitives = [g.primitive(v, n, u, t, 0, ready, keep)]
    if wraps:
        for end, sign in ((0, -1.0), (ny - 1, 1.0)):
            ring = v[np.arange(nx) * ny + end]
            lid = np.vstack([ring, [[0, 0, ring[0, 2]]]])
            k = np.arange(nx - 1)
            fan = np.stack([np.full(nx - 1, nx), k, k + 1] if sign > 0 else [np.full(nx - 1, nx), k + 1, k], 1)
            if np.cross(lid[fan[0, 1]] - lid[nx], lid[fan[0, 2]] - lid[nx])[2] * sign < 0:
                fan = fan[:, ::-1]
            still = [(np.zeros_like(lid), np.zeros_like(lid))] * len(dents)
            primitives.append(g.primitive(lid, np.tile([0, 0, sign], (nx + 1, 1)), 0.5 + lid[:, :2] / 0.6, fan, 1, still, keep))
    g.write(name, primitives, materials, impacts)


def drum(count=8):
    base, dents, extras = read(HERE.parent / "solver/tube.glb")
    impacts = [{k: i[k] for k in ("name", "point", "direction", "displacement")} for i in extras["impacts"][:count]]
    materials = [material("wall", [0.05, 0.22, 0.42], 0.1, 0.45), material("lid", [0.35, 0.36, 0.38], 0.8, 0.4)]
    body("drum", base, dents[:count], impacts, (68, 33), materials, keep=1e-4, wraps=True)


def numbers(x):
    return [float(f"{k:.5g}") for k in x]


def striker(a, i):
    mass, radius = numbers([a["mass"][i], a["radius"][i]])
    return dict(mass=mass, radius=radius, velocity=numbers(a["velocity"][i]), shape=str(a["shape"][i]))


def in_engine(a, i):
    """The impulse that a rigid-body engine reports if the body is fixed: the normal momentum without restitution, and
    friction that is at most 0.4 times as large and at most stops the striker."""
    v, n = a["velocity"][i].astype(float), a["contact_normal"][i].astype(float)
    along = -v @ n
    across = v + along * n
    return a["mass"][i] * (min(1, 0.4 * along / np.linalg.norm(across)) * across - along * n)


def hood(count=12, hits=5):
    base, train, heldout = (np.load(STEEL / f"{f}.npz") for f in ("base", "train", "heldout"))
    dents = train["fields"][:count] * train["step"]
    impacts = []
    for i in range(count):
        vectors = dict(point="contact_point", normal="contact_normal", displacement="contact_displacement", impulse="impulse")
        impacts.append(dict(name=f"blow {i}", **{k: numbers(train[v][i]) for k, v in vectors.items()}, striker=striker(train, i)))
    body("hood", base["vertices"], dents, impacts, tuple(base["grid"]), [material("paint", [0.55, 0.05, 0.05], 0.3, 0.3)], keep=3e-4, crease=CREASE)

    # Held-out blows of middling depth, far apart: the deepest, then always the one that is farthest from those before.
    depth, point = np.linalg.norm(heldout["contact_displacement"], axis=1), heldout["contact_point"]
    left = np.nonzero((depth > 0.008) & (depth < 0.03))[0]
    chosen = [left[np.argmax(depth[left])]]
    while len(chosen) < hits:
        away = np.linalg.norm(point[left, None] - point[chosen], axis=2).min(1)
        chosen.append(left[np.argmax(away)])
    lines = []
    for i in chosen:
        told = dict(point=numbers(point[i]), normal=numbers(heldout["contact_normal"][i]), impulse=numbers(in_engine(heldout, i)))
        lines.append("  " + json.dumps(dict(name=f"held-out {i}", **told, striker=striker(heldout, i))))
    (HERE / "hood.json").write_text("[\n" + ",\n".join(lines) + "\n]\n")


def engine(low, high):
    """A closed box, m, y up."""
    corners = [[(high if i >> k & 1 else low)[k] for k in range(3)] for i in range(8)]
    sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    indices = [i for a, b, c, d in sides for i in (a, b, c, a, c, d)]
    data = struct.pack("<24f", *sum(corners, [])) + struct.pack("<36H", *indices)
    views = [dict(buffer=0, byteOffset=0, byteLength=96), dict(buffer=0, byteOffset=96, byteLength=72)]
    positions = dict(bufferView=0, componentType=5126, count=8, type="VEC3", min=low, max=high)
    triangles = dict(bufferView=1, componentType=5123, count=36, type="SCALAR")
    primitive = dict(attributes=dict(POSITION=0), indices=1)
    gltf = dict(asset=dict(version="2.0"), scene=0, scenes=[dict(nodes=[0])], nodes=[dict(name="engine", mesh=0)],
                meshes=[dict(name="engine", primitives=[primitive])], accessors=[positions, triangles], bufferViews=views,
                buffers=[dict(byteLength=len(data))])
    text = json.dumps(gltf, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data
    (HERE / "engine.glb").write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)


drum()
hood()
engine([-0.12, -0.2, -0.12], [0.22, 0.062, 0.14])
