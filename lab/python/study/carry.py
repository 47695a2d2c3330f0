"""Examples carried to where a body was hit, and what is left of them: the moments from which errors follow.

The relative L2 error of a weighted sum of carried images needs only their inner products with each other and with the
truth, so rules are compared without ever building a field again.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from study.body import Array, Body, across, length, smallest_rotation


@dataclass(frozen=True)
class Carry:
    """How an example comes to the contact."""

    stretch: float = 0.5  # exponent of the ratio of depths
    share: float = 1.0  # of the way from where it was made: 0 leaves it anchored
    turn: str = "none"  # about the normal, after the smallest rotation: none, tangents, curvature


@dataclass(frozen=True)
class Window:
    """Falls to zero towards a rim that examples hold still."""

    width: float  # of the diagonal
    ramp: str = "smoothstep"
    still: float = 0.05  # a rim vertex is, when no example moves it by more than this share of its own depth


RAMPS: dict[str, Callable[[Array], Array]] = {"linear": lambda x: x, "smoothstep": lambda x: x * x * (3 - 2 * x)}


@dataclass
class Moments:
    """Inner products of carried and scaled images, for each row as the truth."""

    gram: Array  # [rows, images, images]
    cross: Array  # [rows, images], with the truth
    truth: Array  # [rows]
    contact: Array  # [rows, images, 3], displacements at the contact, per depth asked for
    unit: Array  # [rows, 3], the truth's there


class Volume:
    """Fields of a body's rows in the space around its surface: a grid, read with linear interpolation."""

    def __init__(self, body: Body, spacing: float = 0.7) -> None:
        """Inverse-distance weights of the four nearest vertices; fades to zero between 3 and 4.5 edge lengths off."""
        step = spacing * body.edge_length
        self.origin = body.vertices.min(0) - 4.5 * body.edge_length
        size = np.ceil((np.ptp(body.vertices, axis=0) + 9 * body.edge_length) / step).astype(int) + 2
        self.step, self.size = step, size
        grid = np.stack(np.meshgrid(*map(np.arange, size), indexing="ij"), -1).reshape(-1, 3) * step + self.origin
        distance, nearest = body.tree.query(grid, k=4, distance_upper_bound=4.5 * body.edge_length)
        near = np.flatnonzero(np.isfinite(distance[:, 0]))
        distance, nearest = distance[near], nearest[near]
        weights = 1 / np.maximum(distance, 1e-6) ** 2
        weights /= weights.sum(1, keepdims=True)
        weights *= np.clip(3 - distance[:, :1] / (1.5 * body.edge_length), 0, 1)
        nearest[weights == 0] = 0
        self.values = np.zeros((len(body), len(grid), 3), np.float32)
        for row, field in enumerate(body.fields):
            self.values[row][near] = (weights[..., None] * field[nearest]).sum(1)

    def at(self, row: int, points: Array) -> Array:
        """The row's displacement at points [n, 3]; outside the grid, what is at its border: nothing."""
        places = np.clip((points - self.origin) / self.step, 0, self.size - 1.001).astype(np.float32)
        corner = places.astype(np.int32)
        x, y, z = (places - corner).T[..., None]
        dx, dy = self.size[1] * self.size[2], self.size[2]
        first = corner[:, 0] * dx + corner[:, 1] * dy + corner[:, 2]
        values = self.values[row]

        def between(low: Array, high: Array, t: Array) -> Array:
            high -= low
            high *= t
            return np.add(low, high, out=high)

        def line(offset: int) -> Array:
            return between(values.take(first + offset, 0), values.take(first + offset + 1, 0), z)

        return between(between(line(0), line(dy), y), between(line(dx), line(dx + dy), y), x)


def about(normal: Array, angle: Array) -> Array:
    """Rotations about unit normals [..., 3] by angles [...]."""
    n = np.broadcast_to(normal, (*angle.shape, 3))
    c, s = np.cos(angle)[..., None, None], np.sin(angle)[..., None, None]
    k = np.zeros((*n.shape, 3))
    k[..., 0, 1], k[..., 0, 2], k[..., 1, 2] = -n[..., 2], n[..., 1], -n[..., 0]
    k -= np.swapaxes(k, -1, -2)
    return np.eye(3) * c + s * k + (1 - c) * n[..., :, None] * n[..., None, :]


def signed_angle(a: Array, b: Array, normal: Array) -> Array:
    """From `a` to `b` about `normal`, all across it."""
    return np.arctan2((np.cross(a, b) * normal).sum(-1), (a * b).sum(-1))


def rotations(body: Body, row: int, turn: str) -> Array:
    """What takes each image's frame to that of the row's contact, [images, 3, 3]."""
    i, normal = body.images, body.normals[body.contact[row]]
    smallest = smallest_rotation(i.normal, normal)
    if turn == "none":
        return smallest
    if turn == "tangents":
        carried = across(np.einsum("kab,kb->ka", smallest, i.tangent), normal)
        # Tangential parts under two hundredths of the depth have no direction worth following.
        clear = (length(carried) > 0.02) & (length(body.tangent[row]) > 0.02)
        angle = signed_angle(carried, body.tangent[row], normal)
    else:
        here, clear_here = body.curvature_direction(body.contact[row : row + 1])
        there, clear_there = body.curvature_direction(i.vertex)
        carried = across(np.einsum("kab,kb->ka", smallest, there), normal)
        angle = signed_angle(carried, here[0], normal)
        angle = (angle + np.pi / 2) % np.pi - np.pi / 2  # a direction has no sign
        clear = clear_there & clear_here[0]
    return about(normal, np.where(clear, angle, 0)) @ smallest


def carried(body: Body, volume: Volume, row: int, carry: Carry) -> Array:
    """All images carried to the row's contact and scaled to its depth there, [images, vertices judged + contact, 3]."""
    i = body.images
    contact = body.contact[row]
    places = body.vertices[np.append(body.judged, contact)]
    turns = rotations(body, row, carry.turn)
    ratio = body.depth[row] / i.depth
    stretch = np.clip(ratio ** (carry.stretch * carry.share), 0.25, 4)
    out = np.zeros((len(i), len(places), 3), np.float32)
    for k in range(len(i)):
        local = (places - body.vertices[contact]) @ turns[k]
        height = (local @ i.normal[k])[:, None] * i.normal[k]
        points = i.point[k] + (local - height) / stretch[k] + height
        if carry.share < 1:
            points = places + carry.share * (points - places)
        field = volume.at(i.row[k], body.mirrored(points, i.signs[k])) * i.signs[k]
        if carry.share > 0:
            field = field @ turns[k].T
            # Where a partly carried example hardly moves the contact it is not blown up.
            out[k] = field * (body.depth[row] / max(length(field[-1]), 0.3 * i.depth[k]))
        else:
            out[k] = field * ratio[k]
    return out


def window_weights(body: Body, row: int, window: Window | None) -> Array:
    """The window at the vertices judged. Which rim is still, all simulations say but that of the row."""
    if window is None:
        return np.ones(len(body.judged))
    others = body.source != body.source[row]
    moved = (length(body.fields[others][:, body.rim]) / body.depth[others, None]).max(0)
    still = body.rim[moved < window.still]
    if len(still) == 0:
        return np.ones(len(body.judged))
    distance = cKDTree(body.vertices[still]).query(body.vertices[body.judged])[0]
    return RAMPS[window.ramp](np.clip(distance / (window.width * body.diagonal), 0, 1))


def moments(body: Body, volume: Volume, carry: Carry, windows: list[Window | None]) -> dict[Window | None, Moments]:
    """Moments of all images at all rows, for one way to carry and several windows."""
    n, m = len(body), len(body.images)
    found = {w: Moments(np.zeros((n, m, m), np.float32), np.zeros((n, m)), np.zeros(n), np.zeros((n, m, 3)), body.unit) for w in windows}
    for row in range(n):
        fields = carried(body, volume, row, carry)
        truth = body.fields[row][body.judged].astype(np.float32)
        for w, all_rows in found.items():
            weighted = (fields[:, :-1] * window_weights(body, row, w)[:, None].astype(np.float32)).reshape(m, -1)
            all_rows.gram[row] = weighted @ weighted.T
            all_rows.cross[row] = weighted @ truth.ravel()
            all_rows.truth[row] = (truth.astype(float) ** 2).sum()
            all_rows.contact[row] = fields[:, -1] / body.depth[row]
    return found
