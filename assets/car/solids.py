"""Meshes that are not cut from the skin: bodies of revolution, boxes, bars and nets of small shapes."""

import numpy as np

from mesher import net, project, relax, slope, unit
from shape import gradient, smax


def creased(v, t, angle=38):
    """Normals for a mesh: smooth where faces meet at less than `angle` degrees. Vertices on sharp edges become several."""
    f = np.cross(v[t[:, 1]] - v[t[:, 0]], v[t[:, 2]] - v[t[:, 0]])
    u = unit(f)
    corner, face = t.ravel(), np.repeat(np.arange(len(t)), 3)
    order = np.argsort(corner, kind="stable")
    start = np.searchsorted(corner[order], np.arange(len(v)))
    size = np.bincount(corner, minlength=len(v))
    n = np.zeros((len(corner), 3))
    limit = np.cos(np.radians(angle))
    for k in range(size.max()):
        has = size[corner] > k
        other = face[order[np.minimum(start[corner] + k, len(order) - 1)]]
        near = has & ((u[face] * u[other]).sum(1) > limit)
        n[near] += f[other[near]]
    n = unit(n)
    key = np.concatenate([corner[:, None], np.round(n * 1e4).astype(int)], 1)
    _, first, index = np.unique(key, axis=0, return_index=True, return_inverse=True)
    return v[corner[first]], n[first], index.reshape(-1, 3)


def moved(mesh, at=(0, 0, 0), turn=None):
    v, n, t = mesh
    if turn is not None:
        v, n = v @ np.asarray(turn).T, n @ np.asarray(turn).T
    return v + np.asarray(at, float), n, t


def joined(*meshes):
    v, n, t, first = [], [], [], 0
    for a, b, c in meshes:
        v.append(a)
        n.append(b)
        t.append(c + first)
        first += len(a)
    return np.concatenate(v), np.concatenate(n), np.concatenate(t)


def grid(rows, columns, wraps):
    """Triangles of a grid of vertices whose columns may wrap around."""
    i, j = np.meshgrid(np.arange(rows - 1), np.arange(columns if wraps else columns - 1), indexing="ij")
    a, b = i * columns + j, i * columns + (j + 1) % columns
    a, b = a.ravel(), b.ravel()
    return np.concatenate([np.stack([a, b, b + columns], 1), np.stack([a, b + columns, a + columns], 1)])


def lathe(profile, segments, angle=38):
    """Turns (radius, height) around the y axis. The profile runs so that the outside lies to its left: from the inner end outwards."""
    a = 2 * np.pi * np.arange(segments) / segments
    v = np.concatenate([np.stack([r * np.sin(a), np.full(segments, y), r * np.cos(a)], 1) for r, y in profile])
    return creased(v, clean(v, grid(len(profile), segments, True)), angle)


def clean(v, t):
    """Without triangles that have no area."""
    area = np.linalg.norm(np.cross(v[t[:, 1]] - v[t[:, 0]], v[t[:, 2]] - v[t[:, 0]]), axis=1)
    return t[area > 1e-10]


def loft(sections, angle=38):
    """A closed bar through sections of equally many points, which run around it."""
    sections = np.asarray(sections, float)
    rows, columns = sections.shape[:2]
    v = sections.reshape(-1, 3)
    t = [grid(rows, columns, True)]
    for first, flip in ((0, False), ((rows - 1) * columns, True)):
        fan = np.array([[first, first + k + 1, first + k] for k in range(1, columns - 1)])
        t.append(fan[:, ::-1] if flip else fan)
    t = clean(v, np.concatenate(t))
    p = v[t]
    if np.einsum("ij,ij->i", p[:, 0], np.cross(p[:, 1], p[:, 2])).sum() < 0:
        t = t[:, ::-1]
    return creased(v, t, angle)


def box_distance(p, at, half, r):
    """A box with edges rounded by r."""
    q = np.abs(p - np.asarray(at)) - (np.asarray(half) - r)
    return np.linalg.norm(np.maximum(q, 0), axis=-1) + np.minimum(q.max(-1), 0) - r


def blob(f, low, high, h, rounds=3, own=True):
    """The net of a small shape, with the shape's own normals or those of the triangles."""
    v, t = net(f, np.asarray(low, float) - 1.63 * h, np.asarray(high, float) + 1.57 * h, h)
    v = project(f, relax(f, project(f, v, 4), t, rounds), 4)
    t = clean(v, t)
    return (v, unit(gradient(f, v, 1e-4)), t) if own else creased(v, t, 50)


def rounded_box(at, half, r, h):
    at, half = np.asarray(at, float), np.asarray(half, float)
    return blob(lambda p: box_distance(p, at, half, r), at - half, at + half, h)


def bar(points, up, width, height, angle=50):
    """A bar of a rounded section along points; `up` is the direction of its height."""
    points, up = np.asarray(points, float), np.asarray(up, float)
    d = unit(np.gradient(points, axis=0))
    across = unit(np.cross(d, up))
    high = np.cross(across, d)
    a = 2 * np.pi * (np.arange(8) + 0.5) / 8
    ring = np.sign(np.cos(a)) * np.abs(np.cos(a)) ** 0.6, np.sign(np.sin(a)) * np.abs(np.sin(a)) ** 0.6
    sections = points[:, None] + 0.5 * width * ring[0][None, :, None] * across[:, None] + 0.5 * height * ring[1][None, :, None] * high[:, None]
    return loft(sections, angle)
