"""Makes drum.glb and hood.glb, the demo's bodies, from the solver's meshes in ../solver (numpy, scipy).

    python3 make_demo.py

The solver's grid is refined three times (bicubic on its parameters), the first eight dents become sparse morph targets,
and what a scene would have is added: texture coordinates with a seam, two materials, lids on the drum. The lids stand on
the drum's rings, which the solver held fixed, so no example moves them."""
import json, struct
from pathlib import Path
import numpy as np
from scipy.interpolate import RectBivariateSpline

HERE = Path(__file__).parent
FACTOR, EXAMPLES, KEEP = 3, 8, 1e-4  # refinement, morph targets, displacements dropped below (m)


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


def refine(field, shape, wraps):
    """A field over the solver's grid (n, 3) on the finer grid. A wrapping grid gets its first column again at the end."""
    nx, ny = shape
    f = field.reshape(nx, ny, 3).astype(float)
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

    def primitive(self, v, n, uv, t, material, dents):
        targets = []
        for d, dn in dents:
            at = np.nonzero(np.linalg.norm(d, axis=1) > KEEP)[0].astype(np.uint32)
            i = self.view(at) if len(at) else None
            targets.append({k: self.sparse(i, x[at].astype(np.float32), len(at), len(v)) for k, x in (("POSITION", d), ("NORMAL", dn))})
        attributes = dict(POSITION=self.accessor(v.astype(np.float32), bounds=True), NORMAL=self.accessor(n.astype(np.float32)), TEXCOORD_0=self.accessor(uv.astype(np.float32)))
        return dict(attributes=attributes, indices=self.accessor(t.astype(np.uint32).ravel(), 34963), material=material, targets=targets)

    def write(self, path, name, primitives, materials, extras):
        up = [-(0.5**0.5), 0, 0, 0.5**0.5]  # the arrays are z up, glTF is y up
        g = dict(
            asset=dict(version="2.0", generator="crumple assets/demo/make_demo.py"), scene=0, scenes=[dict(nodes=[0])],
            nodes=[dict(name=name, rotation=up, children=[1]), dict(name=name + "_mesh", mesh=0)], materials=materials,
            meshes=[dict(name=name, primitives=primitives, weights=[0.0] * EXAMPLES, extras=extras)],
            accessors=self.accessors, bufferViews=self.views, buffers=[dict(byteLength=len(self.bin) + -len(self.bin) % 4)],
        )
        j = json.dumps(g, separators=(",", ":")).encode()
        j += b" " * (-len(j) % 4)
        self.bin += b"\0" * (-len(self.bin) % 4)
        path.write_bytes(struct.pack("<IIIII", 0x46546C67, 2, 28 + len(j) + len(self.bin), len(j), 0x4E4F534A) + j + struct.pack("<II", len(self.bin), 0x4E4942) + self.bin)
        print(path.name, f"{path.stat().st_size / 1e6:.2f} MB")


def material(name, colour, metallic, roughness):
    return dict(name=name, doubleSided=True, pbrMetallicRoughness=dict(baseColorFactor=[*colour, 1], metallicFactor=metallic, roughnessFactor=roughness))


def body(name, source, shape, wraps, materials):
    base, dents, extras = read(HERE.parent / "solver" / source)
    fine = refine(base, shape, wraps)
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
    for d in dents[:EXAMPLES]:
        d = refine(d, shape, wraps).reshape(-1, 3)
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
    primitives = [g.primitive(v, n, u, t, 0, ready)]
    if wraps:
        for end, sign in ((0, -1.0), (ny - 1, 1.0)):
            ring = v[np.arange(nx) * ny + end]
            lid = np.vstack([ring, [[0, 0, ring[0, 2]]]])
            k = np.arange(nx - 1)
            fan = np.stack([np.full(nx - 1, nx), k, k + 1] if sign > 0 else [np.full(nx - 1, nx), k + 1, k], 1)
            if np.cross(lid[fan[0, 1]] - lid[nx], lid[fan[0, 2]] - lid[nx])[2] * sign < 0:
                fan = fan[:, ::-1]
            still = [(np.zeros_like(lid), np.zeros_like(lid))] * EXAMPLES
            primitives.append(g.primitive(lid, np.tile([0, 0, sign], (nx + 1, 1)), 0.5 + lid[:, :2] / 0.6, fan, 1, still))
    impacts = []
    for i in extras["impacts"][:EXAMPLES]:
        impacts.append({k: i[k] for k in ("name", "point", "direction", "displacement")})
    g.write(HERE / f"{name}.glb", name, primitives, materials, dict(targetNames=extras["targetNames"][:EXAMPLES], impacts=impacts, units="m"))


body("drum", "tube.glb", (68, 33), True, [material("wall", [0.05, 0.22, 0.42], 0.1, 0.45), material("lid", [0.35, 0.36, 0.38], 0.8, 0.4)])
body("hood", "panel.glb", (53, 41), False, [material("paint", [0.55, 0.05, 0.05], 0.3, 0.3)])
