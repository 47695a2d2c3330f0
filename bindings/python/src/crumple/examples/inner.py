"""Solids inside a body that its dents must not enter, such as an engine or a roll cage."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial import ConvexHull, QhullError

import crumple

from . import Failure
from .body import Body, Floats, Ints
from .gltf import File
from .remesh import compact, connected

_CAPSULE = "capsule:"
_SIDES = 24
_CONVEX = 1.15
"""Hulls may be larger than their part by this factor without a note."""


@dataclass(frozen=True)
class Solid:
    """A closed surface, in metres, in the space of Body.points."""

    name: str
    points: Floats
    triangles: Ints


def read(texts: Sequence[str], body: Body, unit: float) -> list[Solid]:
    """The solids that --inner names: FILE.glb, FILE.glb/NODE, or capsule:AX,AY,AZ,BX,BY,BZ,RADIUS in the scene of the body."""
    found: list[Solid] = []
    for text in texts:
        found += [_capsule(text, body, unit)] if text.startswith(_CAPSULE) else _meshes(text, body, unit)
    for solid in found:
        try:
            crumple.keep_out(np.zeros((1, 3), np.float32), meshes=[(solid.points.astype(np.float32), solid.triangles)])
        except crumple.CrumpleError as error:
            raise Failure(f"--inner {solid.name}: {error}") from error
    return found


def _capsule(text: str, body: Body, unit: float) -> Solid:
    try:
        numbers = np.array([float(number) for number in text[len(_CAPSULE) :].split(",")]) * unit
    except ValueError:
        numbers = np.zeros(0)
    if len(numbers) != 7 or not np.isfinite(numbers).all() or numbers[6] <= 0:
        raise Failure(f"--inner {text} must be capsule: and seven numbers, two points and a radius above 0, such as capsule:-1,0,0,1,0,0,0.1")
    a, b, radius = numbers[:3], numbers[3:6], numbers[6]
    # A mesh around the capsule, which it exceeds by 2 % of the radius.
    angle, rows = 2 * np.pi * np.arange(_SIDES) / _SIDES, np.pi / _SIDES * 2 * np.arange(1, _SIDES // 2)
    away = (b - a) / np.linalg.norm(b - a) if np.linalg.norm(b - a) > 0 else np.array([0.0, 1.0, 0.0])
    x = np.cross(away, [0.3, 0.5, 0.8])
    x /= np.linalg.norm(x)
    y = np.cross(away, x)
    ring = np.cos(angle)[:, None] * x + np.sin(angle)[:, None] * y
    ball = np.concatenate([-away[None], *(np.sin(t) * ring - np.cos(t) * away for t in rows), away[None]])
    radius = radius / np.cos(np.pi / _SIDES) ** 2
    points = np.concatenate([a + radius * ball, b + radius * ball])
    hull = ConvexHull(points)
    points, corners = compact(points, hull.simplices)
    outward = np.einsum("ij,ij->i", np.cross(*(points[corners[:, k]] - points[corners[:, 0]] for k in (1, 2))), hull.equations[:, :3]) > 0
    corners = np.where(outward[:, None], corners, corners[:, ::-1])
    return Solid(text, points - body.origin, corners)


def _meshes(text: str, body: Body, unit: float) -> list[Solid]:
    path, node = Path(text), None
    if not path.is_file() and path.parent.is_file():
        path, node = path.parent, path.name
    file = File(path)
    nodes = file.gltf.nodes or []
    wanted = set(range(len(nodes)))
    if node is not None:
        named = [index for index, one in enumerate(nodes) if one.name == node]
        if not named:
            raise Failure(f"{path} has no node {node}; it has: {', '.join(str(one.name) for one in nodes)}")
        wanted, more = set(), named
        while more:
            index = more.pop()
            if index not in wanted:
                wanted.add(index)
                more += nodes[index].children or []
    found = []
    for index in sorted(wanted):
        mesh = nodes[index].mesh
        # The body's own file may have them as other meshes.
        if mesh is None or (path.resolve() == body.path.resolve() and mesh == body.index):
            continue
        name, points, triangles, start = nodes[index].name or file.gltf.meshes[mesh].name or path.name, [], [], 0
        for primitive in file.gltf.meshes[mesh].primitives:
            some, corners = file.surface(primitive, name)
            if corners is not None:
                points.append(some.astype(float))
                triangles.append(start + corners)
                start += len(some)
        if points:
            placed = file.placed(index)
            world = (np.concatenate(points) @ placed[:3, :3].T + placed[:3, 3]) * unit - body.origin
            corners = np.concatenate(triangles)
            if np.linalg.det(placed[:3, :3]) < 0:
                corners = corners[:, ::-1]
            distinct, of = np.unique(world.astype(np.float32), axis=0, return_inverse=True)
            found.append(Solid(name, distinct.astype(float), of.reshape(-1)[corners]))
    if not found:
        raise Failure(f"--inner {text} has no triangles")
    return found


def limits(body: Body, solids: Sequence[Solid]) -> np.ndarray:
    """How far each vertex may move, in the units of the mesh's own space."""
    back, turned = np.linalg.inv(body.world).T, np.linalg.det(body.world) < 0
    meshes = [((s.points @ back).astype(np.float32), s.triangles[:, ::-1] if turned else s.triangles) for s in solids]
    return crumple.keep_out(body.vertices, meshes=meshes, depth_limits=body.limits)


def room(points: Floats, solids: Sequence[Solid]) -> Floats:
    """The distance of points to the nearest solid, 0 inside, m."""
    if not solids:
        return np.full(len(points), np.inf)
    return crumple.keep_out(points.astype(np.float32), meshes=[(s.points.astype(np.float32), s.triangles) for s in solids]).astype(float)


def hulls(solids: Sequence[Solid]) -> tuple[list[Floats], list[str]]:
    """The corners of the convex hull of each connected part, for the solver, and what the user should know of them."""
    corners, notes = [], []
    for solid in solids:
        t = solid.triangles
        part = connected(t, len(solid.points))
        for one in np.unique(part[t[:, 0]]):
            own = t[part[t[:, 0]] == one]
            try:
                hull = ConvexHull(solid.points[np.unique(own)])
            except QhullError as error:
                raise Failure(f"--inner {solid.name} has a part without volume; remove it") from error
            a, b, c = (solid.points[own[:, k]] for k in range(3))
            volume = abs(float(np.einsum("ij,ij->", a - a[0, None], np.cross(b - a[0, None], c - a[0, None]))) / 6)
            if hull.volume > _CONVEX * volume:
                notes.append(
                    f"{solid.name} has a part that is not convex; the simulation fills its hollows. Model it as several convex parts if that is too much"
                )
            corners.append(hull.points[hull.vertices])
    return corners, list(dict.fromkeys(notes))


def digest(solids: Sequence[Solid]) -> str:
    """Names the solids in the settings of a run."""
    data = hashlib.sha256(b"".join(one.tobytes() for s in solids for one in (s.points, s.triangles))).hexdigest()[:8]
    return " ".join([*(s.name for s in solids), data]) if solids else "none"
