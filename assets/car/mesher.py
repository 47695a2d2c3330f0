"""Meshes of shapes that are given as functions: nets of equal triangles, cuts along curves, folded borders."""

import numpy as np

from shape import gradient


def unit(v):
    return v / np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), 1e-30)


def net(f, low, high, h):
    """Quads around the cells in which f changes its sign (surface nets), as vertices and triangles that face outwards."""
    low, high = np.asarray(low, float), np.asarray(high, float)
    n = np.ceil((high - low) / h).astype(int) + 1
    axes = [low[k] + h * np.arange(n[k]) for k in range(3)]
    value = np.empty(n)
    for i, x in enumerate(axes[0]):
        p = np.stack(np.meshgrid([x], axes[1], axes[2], indexing="ij"), -1)
        value[i] = f(p)[0]
    inside = value < 0
    corners = [inside[i : n[0] - 1 + i, j : n[1] - 1 + j, k : n[2] - 1 + k] for i in (0, 1) for j in (0, 1) for k in (0, 1)]
    count = sum(c.astype(int) for c in corners)
    cells = (count > 0) & (count < 8)
    index = np.full(cells.shape, -1)
    index[cells] = np.arange(cells.sum())
    vertices = low + h * (np.argwhere(cells) + 0.5)
    triangles = []
    for k in range(3):
        a, b = (k + 1) % 3, (k + 2) % 3
        lower = np.take(inside, range(n[k] - 1), k)
        upper = np.take(inside, range(1, n[k]), k)
        for flip, change in ((False, lower & ~upper), (True, ~lower & upper)):
            at = np.argwhere(change)
            at = at[(at[:, a] > 0) & (at[:, b] > 0) & (at[:, a] < n[a] - 1) & (at[:, b] < n[b] - 1)]
            quad = []
            for da, db in ((1, 1), (0, 1), (0, 0), (1, 0)):
                cell = at.copy()
                cell[:, a] -= da
                cell[:, b] -= db
                quad.append(index[tuple(cell.T)])
            quad = np.stack(quad, 1)
            if flip:
                quad = quad[:, ::-1]
            triangles += [quad[:, [0, 1, 2]], quad[:, [0, 2, 3]]]
    return vertices, np.concatenate(triangles)


def slope(f, p, h=1e-5):
    """f and its gradient by forward differences."""
    value = f(p)
    g = np.empty_like(p)
    for k in range(3):
        q = p.copy()
        q[:, k] += h
        g[:, k] = (f(q) - value) / h
    return value, g


def project(f, p, rounds=6, plane=None):
    """Moves points onto f = 0. Points of `plane` stay in y = 0."""
    for _ in range(rounds):
        value, g = slope(f, p)
        if plane is not None:
            g[plane, 1] = 0
        p = p - (value / np.maximum((g * g).sum(1), 1e-9))[:, None] * g
    return p


def edges_of(triangles):
    e = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), 1).astype(np.int64)
    wide = e.max() + 1
    key, count = np.unique(e[:, 0] * wide + e[:, 1], return_counts=True)
    return np.stack([key // wide, key % wide], 1), count


def relax(f, p, triangles, rounds, fixed=None):
    """Evens the net out: each vertex goes towards the mean of its neighbours and back onto f = 0."""
    e, _ = edges_of(triangles)
    degree = np.maximum(np.bincount(e.ravel(), minlength=len(p)), 1)[:, None]
    for _ in range(rounds):
        mean = np.zeros_like(p)
        for k in range(3):
            mean[:, k] = np.bincount(e[:, 0], p[e[:, 1], k], len(p)) + np.bincount(e[:, 1], p[e[:, 0], k], len(p))
        new = project(f, p + 0.5 * (mean / degree - p), 2)
        p = new if fixed is None else np.where(fixed[:, None], p, new)
    return p


class Skin:
    """A triangle mesh on f = 0 whose faces have labels. Cuts put vertices exactly onto curves."""

    def __init__(self, f, vertices, triangles, size):
        self.f, self.v, self.t, self.size = f, vertices, triangles, size
        self.label = np.full(len(triangles), "", dtype="U24")
        self.locked = np.zeros(len(vertices), bool)

    def settle(self, p, c, target, plane, rounds=4):
        """Moves points onto both f = 0 and c = target."""
        for _ in range(rounds):
            rf, gf = slope(self.f, p)
            rc, gc = slope(c, p)
            rc = rc - target
            gf[plane, 1] = gc[plane, 1] = 0
            a, b, d = (gf * gf).sum(1), (gf * gc).sum(1), (gc * gc).sum(1)
            det = np.maximum(a * d - b * b, 1e-9)
            s, t = (d * rf - b * rc) / det, (a * rc - b * rf) / det
            move = s[:, None] * gf + t[:, None] * gc
            length = np.linalg.norm(move, axis=1, keepdims=True)
            p = p - move * np.minimum(1, self.size / np.maximum(length, 1e-12))
        return p

    def steepness(self, c, p):
        """How fast c changes along the surface."""
        n = unit(slope(self.f, p)[1])
        g = slope(c, p)[1]
        return np.clip(np.linalg.norm(g - (g * n).sum(1, keepdims=True) * n, axis=1), 0.2, 5)

    def distance(self, c, p, offset=0.0):
        """c as a distance along the surface, where it is small, less `offset`."""
        value = c(p)
        near = np.abs(value) < 3 * self.size
        if near.any():
            value[near] /= self.steepness(c, p[near])
        return value - offset

    def cut(self, c, labels, offset=0.0):
        """Splits the faces with these labels along the curve that lies `offset` metres from c = 0 on the surface."""
        chosen = np.isin(self.label, labels)
        used = np.unique(self.t[chosen])
        value = np.full(len(self.v), np.inf)
        value[used] = self.distance(c, self.v[used], offset)
        plane = self.v[:, 1] == 0
        # Vertices that are close to the curve move onto it.
        near = used[(np.abs(value[used]) < 0.3 * self.size) & ~self.locked[used]]
        if len(near):
            p = self.v[near]
            target = offset * self.steepness(c, p) if offset else 0.0
            to = self.settle(p, c, target, plane[near])
            good = np.linalg.norm(to - p, axis=1) < 0.4 * self.size
            good &= (np.abs(c(to) - target) < 1e-5) & (np.abs(self.f(to)) < 1e-5)
            self.v[near[good]] = to[good]
            value[near[good]] = 0
            self.locked[near[good]] = True
        value[np.abs(value) < 2e-5] = 0
        t = self.t[chosen]
        e = np.sort(np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]]), 1)
        e = np.unique(e[value[e[:, 0]] * value[e[:, 1]] < 0], axis=0)
        if len(e):
            va, vb = value[e[:, 0]], value[e[:, 1]]
            s = np.clip(va / (va - vb), 0.05, 0.95)[:, None]
            m = self.v[e[:, 0]] * (1 - s) + self.v[e[:, 1]] * s
            on = plane[e].all(1)
            new = self.settle(m, c, offset * self.steepness(c, m) if offset else 0.0, on)
            far = np.linalg.norm(new - m, axis=1) > 0.5 * self.size
            if far.any():
                new[far] = project(self.f, m[far], plane=on[far])
            first = len(self.v)
            self.v = np.concatenate([self.v, new])
            self.locked = np.concatenate([self.locked, np.ones(len(new), bool)])
            value = np.concatenate([value, np.zeros(len(new))])
        lookup = {(int(i), int(j)): first + k for k, (i, j) in enumerate(e)} if len(e) else {}
        sign = np.sign(value[t])
        split = (sign.min(1) < 0) & (sign.max(1) > 0)
        # Faces with other labels whose edge gets a vertex are divided too, so that the mesh stays closed.
        other = np.flatnonzero(~chosen)
        if len(e):
            o = np.sort(np.stack([self.t[other], np.roll(self.t[other], -1, 1)], -1), -1)
            wide = np.int64(len(self.v))
            touched = np.isin(o[..., 0] * wide + o[..., 1], e[:, 0] * wide + e[:, 1]).any(1)
        else:
            touched = np.zeros(len(other), bool)
        out_t, out_l = [self.t[other[~touched]], t[~split]], [self.label[other[~touched]], self.label[chosen][~split]]
        pieces, labels_of = [], []

        def add(polygon, label):
            if len(polygon) == 3:
                pieces.append(polygon)
            else:
                a, b, c, d = self.v[polygon]
                i, j, k, m = polygon
                straight = np.linalg.norm(a - c) < np.linalg.norm(b - d)
                pieces.extend([[i, j, k], [i, k, m]] if straight else [[i, j, m], [j, k, m]])
                labels_of.append(label)
            labels_of.append(label)

        for tri, sg, label in zip(t[split], sign[split], self.label[chosen][split]):
            polygon = []
            for k in range(3):
                i, j = int(tri[k]), int(tri[(k + 1) % 3])
                polygon.append((i, sg[k]))
                if sg[k] * sg[(k + 1) % 3] < 0:
                    polygon.append((lookup[min(i, j), max(i, j)], 0))
            for want in (-1, 1):
                add([i for i, s in polygon if s == want or s == 0], label)
        for tri, label in zip(self.t[other[touched]], self.label[other[touched]]):
            polygon = []
            for k in range(3):
                i, j = int(tri[k]), int(tri[(k + 1) % 3])
                polygon += [i, lookup.get((min(i, j), max(i, j)))]
            new = [k for k in range(6) if k % 2 and polygon[k] is not None]
            ring = [i for i in polygon[new[0] :] + polygon[: new[0]] if i is not None]
            if len(ring) == 6:  # all three edges
                pieces.append([ring[0], ring[2], ring[4]])
                pieces.extend([[ring[k], ring[(k + 1) % 6], ring[(k + 2) % 6]] for k in (0, 2, 4)])
                labels_of.extend([label] * 4)
            else:  # a fan from the first new vertex
                pieces.extend([[ring[0], ring[k], ring[k + 1]] for k in range(1, len(ring) - 1)])
                labels_of.extend([label] * (len(ring) - 2))
        if pieces:
            out_t.append(np.array(pieces))
            out_l.append(np.array(labels_of, dtype="U24"))
        self.t, self.label = np.concatenate(out_t), np.concatenate(out_l)

    def part(self, c, labels, name, gap=0.0):
        """Faces with these labels where c < 0 become `name`. Between them and the others `gap` metres go."""
        labels = [labels] if isinstance(labels, str) else list(labels)
        for offset in ([0.0, -gap / 2, gap / 2] if gap else [0.0]):
            self.cut(c, labels, offset)
        chosen = np.isin(self.label, labels)
        value = np.full(len(self.t), np.inf)
        value[chosen] = self.distance(c, self.v[self.t[chosen]].mean(1))
        self.label[value < -gap / 2] = name
        self.label[np.abs(value) < gap / 2] = "gap"

    def extract(self, *labels):
        """Vertices and triangles of the faces with these labels."""
        t = self.t[np.isin(self.label, labels)]
        used, index = np.unique(t, return_inverse=True)
        return self.v[used], index.reshape(-1, 3)


def border(triangles):
    """The directed edges that belong to one triangle only."""
    e = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    key = np.sort(e, 1)
    _, index, count = np.unique(key, axis=0, return_inverse=True, return_counts=True)
    return e[count[index.ravel()] == 1]


def border_frame(v, n, edges):
    """Border vertices, and for each the direction that leads out of the surface along it."""
    d = unit(v[edges[:, 1]] - v[edges[:, 0]])
    out = np.zeros_like(v)
    for k in (0, 1):
        np.add.at(out, edges[:, k], unit(np.cross(d, n[edges[:, k]])))
    ids = np.unique(edges)
    b = out[ids] - (out[ids] * n[ids]).sum(1, keepdims=True) * n[ids]
    return ids, unit(b)


def fold(v, n, t, depth, radius=0.0022, keep=None):
    """Folds the borders inwards, round by `radius` and then straight to `depth`. `keep(v)` says which border vertices to leave."""
    edges = border(t)
    edges = edges[~((v[edges[:, 0], 1] == 0) & (v[edges[:, 1], 1] == 0))]
    if keep is not None:
        left = keep(v)
        edges = edges[~(left[edges[:, 0]] & left[edges[:, 1]])]
    if not len(edges):
        return v, n, t
    ids, b = border_frame(v, n, edges)
    flat = v[ids, 1] == 0
    b[flat, 1] = 0
    b = unit(b)
    m = n[ids]
    rings = [(radius * np.sin(a), -radius * (1 - np.cos(a)), a) for a in (np.pi / 4, np.pi / 2)]
    rings.append((radius, -depth, np.pi / 2))
    vs, ns, ts = [v], [n], [t]
    previous = np.full(len(v), -1)
    previous[ids] = ids
    total = len(v)
    for out, down, angle in rings:
        vs.append(v[ids] + out * b + down * m)
        ns.append(unit(np.cos(angle) * m + np.sin(angle) * b))
        now = np.full(len(v), -1)
        now[ids] = total + np.arange(len(ids))
        total += len(ids)
        i, j = edges.T
        ts.append(np.stack([previous[j], previous[i], now[i]], 1))
        ts.append(np.stack([previous[j], now[i], now[j]], 1))
        previous = now
    return np.concatenate(vs), np.concatenate(ns), np.concatenate(ts)
