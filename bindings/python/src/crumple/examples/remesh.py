"""A surface of triangles of one size, with the creases of the body."""

from __future__ import annotations

from itertools import chain

import numpy as np
from scipy.sparse import coo_matrix, csgraph
from scipy.spatial import cKDTree

from . import Failure
from .body import Body, Floats, Ints, face_normals

CREASE = 15.0
"""Degrees: edges of the mesh that are sharper stay edges of the surface. A crease that is cut off dents like smooth sheet."""
_SHORT, _FLAT = 0.4, 0.25
"""Shares of the wanted edge. Slivers have a shorter edge, or are less high above their longest one. The remesher leaves them in narrow strips.
The solver's steps are too long for them: they creep, and the shell never comes to rest."""
_BENT, _TURNED = 0.5, 0.7
"""Cosines of the largest angles by which a triangle may bend when an edge is collapsed, and when an edge is turned."""
_ROUNDS = 8
_FOLDED = 0.94
"""Cosine of the angle between triangles of one edge that lie on each other: 20 degrees."""


def remesh(body: Body, triangles: Ints, edge: float) -> tuple[Floats, Ints]:
    """The surface of these triangles of the body with edges of about this length, m."""
    import pymeshlab

    own, corners = compact(body.points, triangles)
    # MeshLab's own limits are absolute: the body gets the size of 1.
    scale = 1.0 / body.size
    meshes = pymeshlab.MeshSet(verbose=False)
    meshes.add_mesh(pymeshlab.Mesh(own * scale, corners))
    try:
        meshes.meshing_remove_null_faces()
        length = pymeshlab.PureValue(edge * scale)
        meshes.meshing_isotropic_explicit_remeshing(iterations=8, targetlen=length, featuredeg=CREASE)
        meshes.meshing_remove_unreferenced_vertices()
    except pymeshlab.PyMeshLabException as error:
        raise Failure(f"{body.name} cannot be remeshed: {error}; merge its vertices by distance and export it again") from error
    mesh = meshes.current_mesh()
    points, triangles = mesh.vertex_matrix() / scale, mesh.face_matrix().astype(np.int64)
    # Surfaces that were apart only because three of them meet in one edge become one again.
    near = cKDTree(points).query_pairs(0.05 * edge, output_type="ndarray")
    if len(near):
        label = connected(near, len(points))
        first = np.full(label.max() + 1, len(points))
        np.minimum.at(first, label, np.arange(len(points)))
        points, triangles = points[first], label[triangles]
    a, b, c = triangles.T
    whole = (a != b) & (b != c) & (c != a)
    whole &= np.linalg.norm(face_normals(points, triangles), axis=1) > 1e-4 * edge**2
    points, triangles = compact(points, triangles[whole])
    if len(points) < 50:
        raise Failure(f"{body.name} became a shell of only {len(points)} points; raise --detail")
    return compact(points, _Slivers(points, triangles, edge).removed())


class _Slivers:
    """Triangles by number, and those around each point, while edges are collapsed and turned."""

    def __init__(self, points: Floats, triangles: Ints, edge: float) -> None:
        self.points, self.short, self.flat = points, _SHORT * edge, _FLAT * edge
        self.faces = dict(enumerate(map(tuple, triangles.tolist())))
        self.around: dict[int, set[int]] = {}
        for face, corners in self.faces.items():
            for corner in corners:
                self.around.setdefault(corner, set()).add(face)

    def removed(self) -> Ints:
        """The triangles without slivers, as far as the surface stays as it is."""
        for _ in range(_ROUNDS):
            # Not any(): all of them are to be tried.
            if not sum(face in self.faces and (self._collapse(face) or self._turn(face)) for face in self._found()):
                break
        return np.array(list(self.faces.values()), np.int64)

    def _found(self) -> list[int]:
        """The slivers, flattest first."""
        faces, corners = np.array(list(self.faces)), np.array(list(self.faces.values()))
        sides = np.linalg.norm(self.points[corners] - self.points[np.roll(corners, 1, axis=1)], axis=2)
        heights = np.linalg.norm(face_normals(self.points, corners), axis=1) / sides.max(1)
        order = heights.argsort(kind="stable")
        found: list[int] = faces[order][((sides.min(1) < self.short) | (heights < self.flat))[order]].tolist()
        return found

    def _sides(self, face: int) -> list[tuple[float, int, int]]:
        """Lengths and ends, shortest first. The ends are as the corners go round."""
        a, b, c = self.faces[face]
        return sorted((float(np.linalg.norm(self.points[i] - self.points[j])), i, j) for i, j in ((a, b), (b, c), (c, a)))

    def _height(self, face: int) -> float:
        """Above the longest side, m."""
        return float(np.linalg.norm(self._normal(self.faces[face])) / self._sides(face)[-1][0])

    def _normal(self, corners: tuple[int, ...]) -> Floats:
        return face_normals(self.points, np.array([corners]))[0]

    def _alike(self, a: Floats, b: Floats, cosine: float) -> bool:
        return bool(a @ b > cosine * np.linalg.norm(a) * np.linalg.norm(b))

    def _ring(self, point: int) -> set[int]:
        return set(chain.from_iterable(self.faces[face] for face in self.around[point])) - {point}

    def _on_border(self, point: int) -> bool:
        return len(self._ring(point)) != len(self.around[point])

    def _sharpness(self, point: int) -> tuple[bool, float]:
        """Of two points of an edge the one with the larger value stays: one on a border, or on the sharper crease."""
        normals = face_normals(self.points, np.array([self.faces[face] for face in self.around[point]]))
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
        return self._on_border(point), -float((normals @ normals.T).min())

    def _collapse(self, face: int) -> bool:
        """Collapses the shortest side, if it is short or half the longest one, and if the surface stays one."""
        (length, a, b), *_, (longest, _, _) = self._sides(face)
        if length >= max(self.short, 0.5 * longest):
            return False
        beside = self.around[a] & self.around[b]
        if len(beside) > 2 or len(self._ring(a) & self._ring(b)) != len(beside):
            return False
        if len(beside) == 2 and self._on_border(a) and self._on_border(b):
            return False
        kept, gone = sorted((a, b), key=self._sharpness, reverse=True)
        moved = {other: tuple(kept if corner == gone else corner for corner in self.faces[other]) for other in self.around[gone] - beside}
        # The normals of flat triangles say nothing.
        told = {other: corners for other, corners in moved.items() if self._height(other) >= self.flat}
        if not all(self._alike(self._normal(self.faces[other]), self._normal(corners), _BENT) for other, corners in told.items()):
            return False
        for other in beside:
            for corner in self.faces.pop(other):
                self.around[corner].discard(other)
        self.faces |= moved
        self.around[kept] |= self.around.pop(gone)
        return True

    def _turn(self, face: int) -> bool:
        """Of two triangles that share the longest side, turns this side to their other corners, if they lie almost in one plane."""
        _, a, b = self._sides(face)[-1]
        beside = self.around[a] & self.around[b]
        if len(beside) != 2:
            return False
        (other,) = beside - {face}
        (c,), (d,) = set(self.faces[face]) - {a, b}, set(self.faces[other]) - {a, b}
        new = {face: (a, d, c), other: (d, b, c)}
        one, two = map(self._normal, new.values())
        plane = self._normal(self.faces[other]) if self._height(other) >= self.flat else one
        if d in self._ring(c) or not all(self._alike(*pair, _TURNED) for pair in ((one, two), (one, plane), (two, plane))):
            return False
        self.faces |= new
        self.around[a].discard(other)
        self.around[b].discard(face)
        self.around[c].add(other)
        self.around[d].add(face)
        return True


def unfolded(points: Floats, triangles: Ints) -> tuple[Ints, int]:
    """Without the smaller one of two triangles that lie on each other at an edge of more than two, and how many those were."""
    before = len(triangles)
    for _ in range(4):
        sides = np.concatenate([triangles[:, [0, 1, 2]], triangles[:, [1, 2, 0]], triangles[:, [2, 0, 1]]])
        of = np.tile(np.arange(len(triangles)), 3)
        key = np.sort(sides[:, :2], axis=1)
        _, number, uses = np.unique(key, axis=0, return_inverse=True, return_counts=True)
        number = number.reshape(-1)
        area = np.linalg.norm(face_normals(points, triangles), axis=1)
        drop: set[int] = set()
        for bad in np.flatnonzero(uses > 2):
            rows = np.flatnonzero(number == bad)
            a, b = points[key[rows[0], 0]], points[key[rows[0], 1]]
            along = (b - a) / max(float(np.linalg.norm(b - a)), 1e-30)
            away = points[sides[rows, 2]] - a
            away -= (away @ along)[:, None] * along
            away /= np.maximum(np.linalg.norm(away, axis=1, keepdims=True), 1e-30)
            for i in range(len(rows)):
                for j in range(i):
                    if away[i] @ away[j] > _FOLDED:
                        drop.add(int(min(of[rows[i]], of[rows[j]], key=lambda t: area[t])))
        if not drop:
            break
        triangles = np.delete(triangles, sorted(drop), axis=0)
    return triangles, before - len(triangles)


def connected(cells: Ints, count: int) -> Ints:
    """The connected part of each of `count` points, by edges or triangles."""
    a, b = cells.reshape(-1), np.roll(cells, -1, axis=1).reshape(-1)
    label: Ints = csgraph.connected_components(coo_matrix((np.ones(len(a), bool), (a, b)), (count, count)), directed=False)[1]
    return label


def edges_of(triangles: Ints) -> tuple[Ints, Ints]:
    """The edges, and how many triangles have each."""
    pairs = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    return np.unique(pairs, axis=0, return_counts=True)


def compact(points: Floats, triangles: Ints) -> tuple[Floats, Ints]:
    """Without points that no triangle uses."""
    used, corners = np.unique(triangles, return_inverse=True)
    return points[used], corners.reshape(-1, 3)
