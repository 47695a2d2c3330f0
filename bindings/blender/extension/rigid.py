"""The blows that a mesh gets in the scene's rigid-body simulation.

Blender's Python tells no contacts. They are found from the motion: where another body would enter the mesh if both went on for a frame as
they move, it hits. How much of its mass takes part follows from what the simulation then does to its velocity.
"""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np
from mathutils.bvhtree import BVHTree
from numpy.typing import NDArray

from . import bridge
from .bridge import Trouble

POINTS = 2000
"""Most points of each body that are tried for a contact."""
STEPS = 8
"""Tries between two frames."""

Array = NDArray[np.float64]


@dataclass
class Blow:
    """In the scene, but the point is in the mesh's own space."""

    frame: int
    point: Array
    velocity: Array
    """Of the striker against the mesh, at the contact, m/s."""
    mass: float
    """The share of the striker's mass that acts, kg: less than all of it if it hits off its centre, or if the mesh gives way."""
    radius: float
    """0: unknown."""


@dataclass
class Contact:
    """In the scene."""

    point: Array
    normal: Array
    """Out of the mesh."""
    time: float
    """Frames after the last one before the contact."""


class Body:
    """The shape of a mesh, and where it is in each frame."""

    def __init__(self, obj: bpy.types.Object) -> None:
        own = obj.rigid_body
        self.free = own is not None and own.type == "ACTIVE" and not own.kinematic
        self.mass = own.mass if own else 0.0
        self.margin = own.collision_margin if own and own.collision_shape not in {"SPHERE", "BOX"} else 0.0
        self.radius = max(obj.dimensions) / 2 if own and own.collision_shape == "SPHERE" else 0.0
        base = bridge.base_of(obj).astype(float)
        self.tree = BVHTree.FromPolygons(base.tolist(), bridge.triangles(obj.data).tolist())
        self.points = base[np.unique(np.linspace(0, len(base) - 1, POINTS).astype(int))]
        low, high = base.min(axis=0), base.max(axis=0)
        self.middle, self.half = (low + high) / 2, (high - low) / 2
        self.places: list[Array] = []

    def ahead(self, frame: int, time: float, falls: Array) -> Array:
        """Its place at `time` frames after `frame` if nothing stops it. `falls` is gravity's displacement, m in a frame squared."""
        out = self.places[frame] + time * (self.places[frame] - self.places[frame - 1])
        if self.free:
            out[:3, 3] += (time + time * time) / 2 * falls
        return out

    def centre(self, frame: int) -> Array:
        return (self.places[frame] @ [*self.middle, 1.0])[:3]

    def size(self, frame: int) -> float:
        """The radius of a ball around it."""
        return float(np.linalg.norm(np.abs(self.places[frame][:3, :3]) @ self.half))

    def travel(self, frame: int, falls: Array) -> float:
        """How far some of its points come within a frame, at most."""
        moved = self.ahead(frame, 1.0, falls) - self.places[frame]
        return float(np.linalg.norm(moved[:3] @ [*self.middle, 1.0]) + np.linalg.norm(np.abs(moved[:3, :3]) @ self.half))

    def speed(self, frame: int, time: float, point: Array, falls: Array) -> Array:
        """Where it would carry a point of the scene, m in a frame, then."""
        now = self.places[frame]
        out = point - (self.places[frame - 1] @ np.linalg.inv(now) @ [*point, 1.0])[:3]
        return out + (time + 0.5) * falls if self.free else out


def blows(scene: bpy.types.Scene, obj: bpy.types.Object, slowest: float) -> list[Blow]:
    """The blows on `obj` that are at least as fast as `slowest`, m/s, against its surface. In the order of their frames."""
    world = scene.rigidbody_world
    if world is None or world.collection is None:
        raise Trouble("the scene has no rigid bodies; add some (Object > Rigid Body)")
    others = [one for one in world.collection.all_objects if one.type == "MESH" and one.rigid_body and one != obj and one.data.polygons]
    if not others:
        raise Trouble(f"nothing can hit {obj.name}: no other mesh is a rigid body")
    mesh, strikers = Body(obj), [Body(one) for one in others]
    first, last, now = scene.frame_start, scene.frame_end, scene.frame_current
    try:
        for frame in range(first, last + 1):
            scene.frame_set(frame)
            graph = bpy.context.evaluated_depsgraph_get()
            for body, one in zip([mesh, *strikers], [obj, *others], strict=True):
                body.places.append(np.array(one.evaluated_get(graph).matrix_world))
    finally:
        scene.frame_set(now)
    if min(abs(np.linalg.det(place)) for body in [mesh, *strikers] for place in body.places) < 1e-12:
        raise Trouble(f"{obj.name}, or what could hit it, is scaled to nothing")
    rate = scene.render.fps / scene.render.fps_base
    falls = np.array(scene.gravity) * world.effector_weights.gravity / rate**2 if scene.use_gravity else np.zeros(3)
    found = [blow for striker in strikers for blow in _of(mesh, striker, falls, rate, slowest)]
    for blow in found:
        blow.frame += first
    return sorted(found, key=lambda blow: blow.frame)


def _of(mesh: Body, striker: Body, falls: Array, rate: float, slowest: float) -> list[Blow]:
    found, entering = [], False
    for frame in range(1, len(mesh.places) - 1):
        before, contact = entering, _contact(mesh, striker, frame, falls)
        entering = False
        if contact is not None:
            speed = striker.speed(frame, contact.time, contact.point, falls) - mesh.speed(frame, contact.time, contact.point, falls)
            approach = -float(speed @ contact.normal)
            entering = rate * approach >= slowest
            # A body that stays in the mesh for some frames hits it once.
            if entering and not before:
                point = np.linalg.inv(mesh.ahead(frame, contact.time, falls)) @ [*contact.point, 1.0]
                mass = _mass(mesh, striker, frame, contact, approach, falls)
                found.append(Blow(frame + 1, point[:3], rate * speed, mass, striker.radius))
    return [blow for blow in found if blow.mass > 0]


def _contact(mesh: Body, striker: Body, frame: int, falls: Array) -> Contact | None:
    """Where the striker enters the mesh within a frame after `frame`."""
    reach, step = mesh.margin + striker.margin, (mesh.travel(frame, falls) + striker.travel(frame, falls)) / STEPS + 1e-6
    if np.linalg.norm(mesh.centre(frame) - striker.centre(frame)) > mesh.size(frame) + striker.size(frame) + reach + STEPS * step:
        return None
    near = 2 * max(reach, step)
    for time in np.linspace(0, 1, STEPS + 1):
        ours, theirs = mesh.ahead(frame, time, falls), striker.ahead(frame, time, falls)
        of_theirs = _deepest(striker.points, theirs, mesh.tree, ours, near)
        of_ours = _deepest(mesh.points, ours, striker.tree, theirs, near)
        best = min((one for one in (of_theirs, of_ours) if one is not None), key=lambda one: one[0], default=None)
        if best is not None and best[0] <= reach:
            _, point, on, outward = best
            # The contact is on the mesh.
            return Contact(on, outward, float(time)) if best is of_theirs else Contact(point, -outward, float(time))
    return None


def _deepest(points: Array, place: Array, tree: BVHTree, target: Array, near: float) -> tuple[float, Array, Array, Array] | None:
    """Of the points within `near` of a surface, the one furthest inside: its gap, itself, the surface's point and normal. In the scene."""
    back, best = np.linalg.inv(target), None
    scene = points @ place[:3, :3].T + place[:3, 3]
    away = near / np.cbrt(abs(np.linalg.det(target[:3, :3])))
    for point, local in zip(scene, scene @ back[:3, :3].T + back[:3, 3], strict=True):
        on, normal, _, _ = tree.find_nearest(local, away)
        if on is not None:
            outward = back[:3, :3].T @ np.array(normal)
            outward /= np.linalg.norm(outward)
            there = (target @ [*on, 1.0])[:3]
            gap = float((point - there) @ outward)
            if best is None or gap < best[0]:
                best = (gap, point, there, outward)
    return best


def _mass(mesh: Body, striker: Body, frame: int, contact: Contact, approach: float, falls: Array) -> float:
    """The mass that a striker of this speed needs for the impulse that the simulation gave, at most what the lighter body has."""
    body, sign = (striker, 1) if striker.free else (mesh, -1)
    masses = [one.mass for one in (mesh, striker) if one.free]
    if not masses:
        return striker.mass
    # It ends in the frame after the contact: bodies that overlap are moved apart there.
    after = min(frame + 2, len(body.places) - 1)
    change = body.speed(after, -0.5, body.centre(after), falls) - body.speed(frame, -0.5, body.centre(frame), falls) - (after - frame) * falls * body.free
    impulse = sign * body.mass * float(change @ contact.normal)
    return float(np.clip(impulse / approach, 0.0, min(masses)))
