"""A body of one truth: its mesh, its training impacts, and the images that they give.

An image is an impact as it was computed, or mirrored in a plane that maps the mesh onto itself.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import product
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

Array = NDArray[np.floating]
Ints = NDArray[np.integer]
Bools = NDArray[np.bool_]

# Impacts that leave less than this at the contact sprang back, metres.
SPRANG_BACK = 0.005
# Two images coincide within this many edge lengths, this much of ln depth, and this much of the unit displacement.
SAME_PLACE, SAME_DEPTH, SAME_DIRECTION = 0.5, 0.02, 0.01


def length(vectors: Array) -> Array:
    """Euclidean length along the last axis."""
    return np.sqrt((vectors * vectors).sum(-1))


def smallest_rotation(a: Array, b: Array) -> Array:
    """The smallest rotations that take unit vectors `a` [..., 3] to `b`; half a turn about z or x where they are opposite."""
    a, b = np.broadcast_arrays(a, b)
    v, c = np.cross(a, b), (a * b).sum(-1)[..., None, None]
    k = np.zeros((*v.shape, 3))
    k[..., 0, 1], k[..., 0, 2], k[..., 1, 2] = -v[..., 2], v[..., 1], -v[..., 0]
    k -= np.swapaxes(k, -1, -2)
    opposite = c < -0.9999
    rotation = np.eye(3) + k + k @ k / np.where(opposite, 1, 1 + c)
    # An axis across a: z where that is nearly across, else x.
    axis = np.where(np.abs(a[..., 2:]) < 0.7, np.array([0.0, 0, 1]), np.array([1.0, 0, 0]))
    axis = axis - (axis * a).sum(-1, keepdims=True) * a
    axis /= length(axis)[..., None]
    return np.where(opposite, 2 * axis[..., :, None] * axis[..., None, :] - np.eye(3), rotation)


def across(vectors: Array, normals: Array) -> Array:
    """The parts of `vectors` across unit `normals`."""
    return vectors - (vectors * normals).sum(-1, keepdims=True) * normals


@dataclass
class Images:
    """All distinct images of all impacts; the impacts themselves come first, in their order."""

    row: Ints
    signs: Array  # of the mirroring, [images, 3]
    vertex: Ints  # where the contact comes to lie
    point: Array
    normal: Array
    depth: Array
    tangent: Array  # tangential part of the contact's unit displacement
    # Which images each row gives, [rows, images], by what may be mirrored.
    given: dict[str, Bools]

    def __len__(self) -> int:
        return len(self.row)


class Body:
    """Mesh, training impacts (those that did not spring back) and their images."""

    def __init__(self, directory: Path, thin: int = 1) -> None:
        """Reads base and training impacts. Errors are taken over every `thin`-th vertex."""
        base = np.load(directory / "base.npz")
        self.vertices = base["vertices"].astype(float)
        self.normals = base["normals"].astype(float)
        self.normals /= length(self.normals)[:, None]
        self.triangles = base["triangles"].astype(int)
        self.diagonal = float(length(np.ptp(self.vertices, axis=0)))
        self.centre = (self.vertices.min(0) + self.vertices.max(0)) / 2
        self.tree = cKDTree(self.vertices)
        edges = np.sort(self.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        self.edges, uses = np.unique(edges, axis=0, return_counts=True)
        self.rim = np.unique(self.edges[uses == 1])
        self.edge_length = float(length(np.diff(self.vertices[self.edges], axis=1)[:, 0]).mean())
        self.judged = np.arange(0, len(self.vertices), thin)

        train = np.load(directory / "train.npz")
        contact = train["contact_vertex"].astype(int)
        depth = length(train["fields"][np.arange(len(contact)), contact].astype(float))
        kept = np.flatnonzero(depth > SPRANG_BACK)
        self.fields = train["fields"][kept].astype(float)
        self.contact, self.depth = contact[kept], depth[kept]
        self.source = np.unique(train["source"], return_inverse=True)[1][kept] if "source" in train else kept
        self.unit = self.fields[np.arange(len(kept)), self.contact] / self.depth[:, None]
        self.tangent = across(self.unit, self.normals[self.contact])
        radius = train["radius"] if "radius" in train else train["punch_radius"]
        self.log_radius = np.log(radius[kept].astype(float))
        self.tilt = across(train["direction"][kept].astype(float), self.normals[self.contact])
        self.images = self._images()

    def __len__(self) -> int:
        return len(self.contact)

    def mirrored(self, points: Array, signs: Array) -> Array:
        """Points mirrored in the planes through the bounds' centre whose sign is -1."""
        return self.centre + signs * (points - self.centre)

    @cached_property
    def mirror_axes(self) -> list[int]:
        """Axes across which the vertices map onto themselves."""
        flips = [1 - 2 * np.eye(3)[axis] for axis in range(3)]
        return [a for a, s in enumerate(flips) if self.tree.query(self.mirrored(self.vertices, s))[0].max() < 1e-4 * self.diagonal]

    def _images(self) -> Images:
        """Every composition of the mirrorings of every row, less those that repeat one of the same simulation."""
        choices = [(1, -1) if axis in self.mirror_axes else (1,) for axis in range(3)]
        compositions = sorted(product(*choices), key=lambda s: s.count(-1))
        n = len(self)
        row = np.tile(np.arange(n), len(compositions))
        signs = np.repeat(np.array(compositions, float), n, axis=0)
        vertex = self.tree.query(self.mirrored(self.vertices[self.contact[row]], signs))[1]
        point, normal = self.vertices[vertex], self.normals[self.contact[row]] * signs
        unit = self.unit[row] * signs
        same = length(point[:, None] - point) < SAME_PLACE * self.edge_length
        same &= np.abs(np.log(self.depth[row][:, None] / self.depth[row])) < SAME_DEPTH
        same &= length(unit[:, None] - unit) < SAME_DIRECTION
        same &= self.source[row][:, None] == self.source[row]
        first = same.argmax(1)  # of those that coincide
        first[:n] = np.arange(n)
        distinct, stands_for = np.unique(first, return_inverse=True)
        flipped = (signs < 0).sum(1)
        given = {}
        for name, most in (("none", 0), ("planes", 1), ("all", 3)):
            given[name] = np.zeros((n, len(distinct)), bool)
            allowed = flipped <= most
            given[name][row[allowed], stands_for[allowed]] = True
        d = distinct
        return Images(row[d], signs[d], vertex[d], point[d], normal[d], self.depth[row[d]], across(unit[d], normal[d]), given)

    def straight(self) -> tuple[Array, Array]:
        """Distances of images' contacts from rows' contacts and from each other, in diagonals."""
        p = self.images.point
        d = length(p[:, None] - p) / self.diagonal
        return d[:, : len(self)], d

    def geodesic(self) -> tuple[Array, Array]:
        """The same along the mesh's edges."""
        a, b = self.edges.T
        weights = length(self.vertices[a] - self.vertices[b])
        graph = coo_matrix((weights, (a, b)), shape=(len(self.vertices),) * 2).tocsr()
        ends, inverse = np.unique(self.images.vertex, return_inverse=True)
        d = dijkstra(graph, directed=False, indices=ends)[:, ends][np.ix_(inverse, inverse)] / self.diagonal
        return d[:, : len(self)], d

    def tangential(self) -> tuple[Array, Array]:
        """How far the tangential parts of unit displacements are apart once carried to rows' contacts, and to each other."""
        i = self.images
        turned = np.einsum("jkab,jb->jka", smallest_rotation(i.normal[:, None], i.normal), i.tangent)
        d = length(turned - i.tangent)
        return d[:, : len(self)], (d + d.T) / 2

    def hidden(self) -> tuple[Array, Array]:
        """Squared differences in what a hit does not tell: tilt of the flight, radius of the ball."""
        i = self.images
        tilt = self.tilt[i.row] * i.signs
        turned = np.einsum("jkab,jb->jka", smallest_rotation(i.normal[:, None], i.normal), tilt)
        radius = self.log_radius[i.row]
        d = ((turned - tilt) ** 2).sum(-1) + ((radius[:, None] - radius) / 0.5) ** 2
        return d[:, : len(self)], (d + d.T) / 2

    def curvature_direction(self, vertices: Ints, rings: float = 4.0) -> tuple[Array, Bools]:
        """Direction of largest curvature at vertices by a fitted quadric, and whether it stands out."""
        directions, clear = np.zeros((len(vertices), 3)), np.zeros(len(vertices), bool)
        for k, v in enumerate(vertices):
            n = self.normals[v]
            x = across(np.eye(3)[np.abs(n).argmin()], n)
            x /= length(x)
            y = np.cross(n, x)
            p = self.vertices[self.tree.query_ball_point(self.vertices[v], rings * self.edge_length)] - self.vertices[v]
            a, b = p @ x, p @ y
            fit = np.linalg.lstsq(np.stack([a * a / 2, a * b, b * b / 2, a, b], 1), p @ n, rcond=None)[0]
            values, vectors = np.linalg.eigh(np.array([[fit[0], fit[1]], [fit[1], fit[2]]]))
            largest = np.abs(values).argmax()
            directions[k] = vectors[0, largest] * x + vectors[1, largest] * y
            clear[k] = np.ptp(values) > 0.25 * np.abs(values).max()
        return directions, clear
