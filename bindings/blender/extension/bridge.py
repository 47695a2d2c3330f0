"""Between Blender and the library: a mesh as an example set, its custom properties, its dents as shape keys, its files.

Everything is in the object's own space, with z up as in Blender. Only the custom properties have y up, as the glTF file has.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

import crumple

DAMAGE = "Crumple damage"
"""The shape key of the dents. Keys whose names begin so are dents, not examples."""
REPORT = "Crumple report"
"""The text that shows what the library last said."""

LIMIT, STIFFNESS, HELD = "Crumple depth limit", "Crumple stiffness", "Crumple held"
"""The vertex groups that are painted."""
HELD_ATTRIBUTE = "_HELD"
"""What the solver reads of the last one: above a half, a vertex does not move."""
ATTRIBUTES = ("_DEPTH_LIMIT", "_STIFFNESS")
"""What the file has of both, as attributes of the vertices, and what the mesh may have from an import or from solids inside."""
NO_LIMIT = 1e6
"""A depth limit, m, of vertices without one: glTF allows no infinite numbers."""

Floats = NDArray[np.float32]


class Trouble(Exception):
    """What is wrong, for the artist."""


def y_up(v: Iterable[float]) -> list[float]:
    x, y, z = (float(f"{value:.7g}") for value in v)
    return [x, z, -y]


def z_up(v: Iterable[float]) -> list[float]:
    x, y, z = v
    return [x, -z, y]


def metre() -> float:
    """Metres in one unit of the scene."""
    settings = bpy.context.scene.unit_settings
    return 1.0 if settings.system == "NONE" else settings.scale_length


def say(lines: Iterable[str]) -> None:
    text = bpy.data.texts.get(REPORT) or bpy.data.texts.new(REPORT)
    text.from_string("\n".join(lines))


def coordinates(key: bpy.types.ShapeKey) -> Floats:
    out = np.empty(3 * len(key.points), np.float32)
    key.points.foreach_get("co", out)
    return out.reshape(-1, 3)


def triangles(mesh: bpy.types.Mesh) -> NDArray[np.uint32]:
    mesh.calc_loop_triangles()
    out = np.empty(3 * len(mesh.loop_triangles), np.int32)
    mesh.loop_triangles.foreach_get("vertices", out)
    return out.reshape(-1, 3).astype(np.uint32)


def example_keys(obj: bpy.types.Object) -> list[bpy.types.ShapeKey]:
    """The keys that are examples: all but the basis, the dents and those that are switched off."""
    keys = obj.data.shape_keys
    return [] if keys is None else [key for key in keys.key_blocks[1:] if not key.mute and not key.name.startswith(DAMAGE)]


def _property(mesh: bpy.types.Mesh, name: str) -> Any:
    """A custom property as plain data. It may be a JSON text, or what the glTF importer made of it."""
    value = mesh.get(name)
    if isinstance(value, str) and value.lstrip()[:1] in ("[", "{"):
        try:
            return json.loads(value)
        except ValueError as error:
            raise Trouble(f"the custom property {name} of {mesh.name} is no JSON: {error}") from error
    if isinstance(value, list) or hasattr(value, "to_list"):
        return [one.to_dict() if hasattr(one, "to_dict") else one for one in value]
    return value


def impacts(obj: bpy.types.Object) -> dict[str, dict[str, Any]]:
    """The custom property `impacts`, by the names of the examples. An entry without a name belongs to the example at its place."""
    entries = _property(obj.data, "impacts") or []
    if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
        raise Trouble(f"the custom property impacts of {obj.data.name} must be a list of objects")
    names = [entry.get("name") for entry in entries]
    if None in names or len(set(names)) < len(names):
        names = [key.name for key in example_keys(obj)]
        if len(entries) > len(names):
            raise Trouble(f"the custom property impacts has {len(entries)} entries for {len(names)} examples")
    return {name: {**entry, "name": name} for name, entry in zip(names, entries, strict=False)}


def describe(obj: bpy.types.Object, told: dict[str, dict[str, Any]]) -> None:
    """Writes the custom property `impacts`. Entries of shape keys that are gone are dropped."""
    keys = obj.data.shape_keys.key_blocks
    if told:
        obj.data["impacts"] = json.dumps([entry for entry in told.values() if entry["name"] in keys])
    elif "impacts" in obj.data:
        del obj.data["impacts"]


def attribute(mesh: bpy.types.Mesh, name: str) -> Floats | None:
    """A number for each vertex, or None if the mesh has no such attribute."""
    found = mesh.attributes.get(name)
    if found is None:
        return None
    if found.domain != "POINT" or found.data_type != "FLOAT":
        raise Trouble(f"the attribute {name} of {mesh.name} must have the domain Vertex and the type Float; remove it")
    out = np.empty(len(mesh.vertices), np.float32)
    found.data.foreach_get("value", out)
    return out


def set_attribute(mesh: bpy.types.Mesh, name: str, values: Floats | None) -> None:
    """Writes a number for each vertex. None removes the attribute."""
    found = mesh.attributes.get(name)
    if found is not None:
        mesh.attributes.remove(found)
    if values is not None:
        mesh.attributes.new(name, "FLOAT", "POINT").data.foreach_set("value", np.ascontiguousarray(values, np.float32))


def painted(obj: bpy.types.Object, name: str) -> Floats:
    """The weight of each vertex in a vertex group, 0 where nothing is painted."""
    out, group = np.zeros(len(obj.data.vertices), np.float32), obj.vertex_groups.get(name)
    if group is not None:
        for vertex in obj.data.vertices:
            for one in vertex.groups:
                if one.group == group.index:
                    out[vertex.index] = one.weight
    return out


def limits(obj: bpy.types.Object) -> Floats | None:
    """How far each vertex may move, m: the less of the attribute and of what is painted. None: as far as any."""
    own, weight = attribute(obj.data, ATTRIBUTES[0]), painted(obj, LIMIT)
    if own is None and not weight.any():
        return None
    whole = np.full(len(weight), NO_LIMIT, np.float32) if own is None else own
    return np.where(weight > 0, np.minimum(whole, (1 - weight) * obj.crumple_deepest), whole).astype(np.float32)


def stiffness(obj: bpy.types.Object) -> Floats | None:
    """From 0 to 1 for each vertex: the more of the attribute and of what is painted. None: 0."""
    own, weight = attribute(obj.data, ATTRIBUTES[1]), painted(obj, STIFFNESS)
    if own is None:
        return weight if weight.any() else None
    return np.maximum(own, weight)


def keep_out(obj: bpy.types.Object, solids: list[bpy.types.Object]) -> Floats:
    """The depth limits that keep dents out of other objects, with their modifiers, in the object's own space."""
    back, graph, meshes = np.array(obj.matrix_world.inverted()), bpy.context.evaluated_depsgraph_get(), []
    for solid in solids:
        shown = solid.evaluated_get(graph)
        mesh = shown.to_mesh()
        try:
            points = np.empty(3 * len(mesh.vertices), np.float32)
            mesh.vertices.foreach_get("co", points)
            placed = back @ np.array(solid.matrix_world)
            points = (points.reshape(-1, 3) @ placed[:3, :3].T + placed[:3, 3]).astype(np.float32)
            faces = triangles(mesh)
            faces = faces[:, ::-1] if np.linalg.det(placed[:3, :3]) < 0 else faces
            try:
                crumple.keep_out(np.zeros((1, 3), np.float32), meshes=[(points, faces)])
            except crumple.CrumpleError as error:
                raise Trouble(f"{solid.name} is no closed solid: {error}") from error
            meshes.append((points, faces))
        finally:
            shown.to_mesh_clear()
    return crumple.keep_out(base_of(obj), meshes=meshes)


def base_of(obj: bpy.types.Object) -> Floats:
    """The undamaged positions, also of a mesh without shape keys."""
    if obj.data.shape_keys:
        return coordinates(obj.data.shape_keys.reference_key)
    out = np.empty(3 * len(obj.data.vertices), np.float32)
    obj.data.vertices.foreach_get("co", out)
    return out.reshape(-1, 3)


@dataclass
class Model:
    """An object's example set, and the arrays that it was made from."""

    set: crumple.ExampleSet
    base: Floats
    names: list[str]
    fields: list[Floats]
    """The displacements of each example."""


_context: crumple.Context | None = None
_models: dict[bytes, Model] = {}


def close() -> None:
    """Frees the library's memory."""
    global _context
    _models.clear()
    if _context is not None:
        _context.close()
        _context = None


def model(obj: bpy.types.Object) -> Model:
    """The object's example set. It is built again if the mesh, a shape key or a custom property changed."""
    global _context
    keys = example_keys(obj)
    if not keys:
        raise Trouble(f"{obj.name} has no examples; sculpt some as shape keys, or press Make Examples")
    told = impacts(obj)
    base, faces = coordinates(obj.data.shape_keys.reference_key), triangles(obj.data)
    fields = [coordinates(key) - coordinates(key.relative_key) for key in keys]
    names = [key.name for key in keys]
    limit, stiff = limits(obj), stiffness(obj)
    about = json.dumps([names, told, limit is None, stiff is None], default=str).encode()
    arrays = [base, faces, *fields, *(one for one in (limit, stiff) if one is not None)]
    digest = hashlib.blake2b(b"".join([about, *(one.tobytes() for one in arrays)])).digest()
    if digest not in _models:
        examples = [_example(name, base + field, told.get(name)) for name, field in zip(names, fields, strict=True)]
        close()
        _context = crumple.Context()
        _models[digest] = Model(_context.example_set(base, faces, examples, depth_limits=limit, stiffness=stiff), base, names, fields)
    return _models[digest]


def _example(name: str, positions: Floats, told: dict[str, Any] | None) -> crumple.Example:
    example = crumple.Example(positions, name=name)
    if told is not None:
        if "point" not in told:
            raise Trouble(f"the entry of {name} in the custom property impacts has no point; mark the example again")
        vector = {key: z_up(told[key]) for key in ("point", "normal", "impulse") if told.get(key) is not None}
        striker = told.get("striker") or {}
        example.contact, example.normal, example.impulse = vector["point"], vector.get("normal"), vector.get("impulse", (0, 0, 0))
        example.duration = told.get("duration") or 0.0
        velocity = z_up(striker.get("velocity") or (0, 0, 0))
        shape = crumple.StrikerShape.__members__.get(str(striker.get("shape")).upper(), crumple.StrikerShape.UNKNOWN)
        example.striker = crumple.Striker(striker.get("mass") or 0.0, striker.get("radius") or 0.0, velocity, shape)
    return example


def submit(body: crumple.Instance, hit: Any, preview: bool = False) -> crumple.HitResult:
    """Gives a stored hit to an instance."""
    if hit.by == "DEPTH":
        return body.hit_displacement(tuple(hit.point), tuple(hit.vector), preview=preview)
    if body.set.info.blow_count == 0:
        raise Trouble("the examples do not know their blows: hit by depth, or make Simulated Dents, or mark the examples with their strikers")
    striker = crumple.Striker(hit.mass, hit.radius * metre(), tuple(hit.vector))
    return body.hit(tuple(hit.point), striker=striker, preview=preview)


def dented(obj: bpy.types.Object, hits: Iterable[Any]) -> Iterator[tuple[crumple.HitResult, Floats]]:
    """The result of each hit, and the positions after it and those before."""
    hits = list(hits)
    body = model(obj).set.instance(mark_capacity=max(64, len(hits)))
    try:
        for hit in hits:
            result = submit(body, hit)
            yield result, body.deformed().positions
    finally:
        body.destroy()


def show(obj: bpy.types.Object) -> crumple.HitResult | None:
    """Writes the dents of all hits into the shape key. Returns the result of the last hit."""
    result = None
    positions = None
    for result, positions in dented(obj, obj.crumple_hits):  # noqa: B007
        pass
    remove_damage(obj, keep_live=positions is not None)
    if positions is not None:
        key = obj.data.shape_keys.key_blocks.get(DAMAGE) or obj.shape_key_add(name=DAMAGE, from_mix=False)
        key.value, key.mute = 1.0, False
        key.points.foreach_set("co", positions.ravel())
    obj.data.update()
    return result


def remove_damage(obj: bpy.types.Object, keep_live: bool = False) -> None:
    """Removes the shape keys of dents, with their animation."""
    active = obj.active_shape_key.name if obj.active_shape_key else ""
    for key in list(obj.data.shape_keys.key_blocks if obj.data.shape_keys else ()):
        if key.name.startswith(DAMAGE) and not (keep_live and key.name == DAMAGE):
            frame = key.name[len(DAMAGE) :].strip()
            animation = obj.data.shape_keys.animation_data
            if frame.lstrip("-").isdigit() and animation is not None and animation.action is not None:
                for at in (int(frame) - 1, int(frame)):
                    key.keyframe_delete("value", frame=at)
            obj.shape_key_remove(key)
    if obj.data.shape_keys:
        obj.active_shape_key_index = max(obj.data.shape_keys.key_blocks.find(active), 0)


def bake(obj: bpy.types.Object) -> int:
    """Makes one keyed shape key for each frame with hits, which moves the mesh from the dents before it. Returns how many."""
    hits = sorted(obj.crumple_hits, key=lambda hit: hit.frame)
    base = model(obj).base
    steps: dict[int, Floats] = {}
    before = base
    for hit, (_, positions) in zip(hits, dented(obj, hits), strict=True):
        steps[hit.frame] = positions.copy()
    remove_damage(obj)
    for frame, after in steps.items():
        key = obj.shape_key_add(name=f"{DAMAGE} {frame}", from_mix=False)
        key.points.foreach_set("co", (base + (after - before)).ravel())
        for value, at in ((0.0, frame - 1), (1.0, frame)):
            key.value = value
            key.keyframe_insert("value", frame=at)
        before = after
    obj.data.update()
    return len(steps)


@contextmanager
def _alone(objects: list[bpy.types.Object]) -> Iterator[None]:
    """Shows and selects these objects and no others, for an exporter, and puts everything back."""
    layer = bpy.context.view_layer
    selected, active = [one for one in layer.objects if one.select_get()], layer.objects.active
    hidden = [one for one in objects if one.hide_get()]
    try:
        for one in selected:
            one.select_set(False)
        for one in objects:
            one.hide_set(False)
            one.select_set(True)
        layer.objects.active = objects[0]
        yield
    finally:
        for one in objects:
            one.select_set(False)
        for one in selected:
            one.select_set(True)
        for one in hidden:
            one.hide_set(True)
        layer.objects.active = active


@contextmanager
def _copy(obj: bpy.types.Object, examples: bool) -> Iterator[bpy.types.Object]:
    """A copy for the exporter: at its place, selected alone, without dents, modifiers and what is switched off."""
    scene, name, own_name = bpy.context.scene, obj.data.name, obj.name
    keep = {key.name for key in example_keys(obj)} if examples else set()
    told = impacts(obj)
    numbers = (limits(obj), stiffness(obj)) if examples else (None, None)
    copy = obj.copy()
    copy.data = mesh = obj.data.copy()
    try:
        obj.data.name, mesh.name = f"{name}.original", name
        obj.name, copy.name = f"{own_name}.original", own_name
        copy.parent, copy.matrix_world = None, obj.matrix_world
        copy.modifiers.clear()
        copy.animation_data_clear()
        if mesh.shape_keys:
            mesh.shape_keys.animation_data_clear()
        for key in list(mesh.shape_keys.key_blocks[1:] if mesh.shape_keys else ()):
            if key.name not in keep:
                copy.shape_key_remove(key)
            else:
                key.value = 0.0
        if mesh.shape_keys:
            describe(copy, {k: v for k, v in told.items() if k in keep})
            if not keep:
                copy.shape_key_clear()
        for attribute_name, values in zip(ATTRIBUTES, numbers, strict=True):
            set_attribute(mesh, attribute_name, values)
        held = painted(obj, HELD)
        if not examples and held.any():
            set_attribute(mesh, HELD_ATTRIBUTE, held)
        scene.collection.objects.link(copy)
        with _alone([copy]):
            yield copy
    finally:
        bpy.data.objects.remove(copy)
        bpy.data.meshes.remove(mesh)
        obj.data.name, obj.name = name, own_name


def export_gltf(objects: list[bpy.types.Object], path: Path, examples: bool = True) -> None:
    """Writes objects as .glb with their examples and custom properties; without them for the solver, and without materials."""
    with ExitStack() as stack:
        stack.enter_context(_alone([stack.enter_context(_copy(obj, examples)) for obj in objects]))
        bpy.ops.export_scene.gltf(
            filepath=str(path), export_format="GLB", use_selection=True, export_extras=True, export_apply=False, export_yup=True,
            export_normals=True, export_morph=examples, export_morph_normal=True, export_morph_tangent=False,
            export_try_sparse_sk=True, export_try_omit_sparse_sk=False, export_attributes=True, export_animations=False, export_skins=False,
            export_draco_mesh_compression_enable=False, export_materials="EXPORT" if examples else "NONE",
        )  # fmt: skip


def export_solids(obj: bpy.types.Object, path: Path) -> bool:
    """Writes the solids inside an object as .glb for the solver. Returns whether there are any."""
    solids = [one.object for one in obj.crumple_solids if one.object is not None]
    if solids:
        with _alone(solids):
            bpy.ops.export_scene.gltf(
                filepath=str(path), export_format="GLB", use_selection=True, export_apply=True, export_yup=True, export_morph=False,
                export_animations=False, export_skins=False, export_materials="NONE",
            )  # fmt: skip
    return bool(solids)


def report(info: crumple.SetInfo, examples: list[crumple.ExampleInfo]) -> list[str]:
    """What the library says of a set, as `crumple info` does."""
    millimetres = 1000 * metre()
    lines = [
        f"{info.vertex_count} vertices, {info.triangle_count} triangles, {info.example_count} examples",
        f"Memory: {info.memory_bytes / 1e6:.1f} MB for all copies",
        f"Depth limit: {millimetres * info.depth_limit:.1f} mm",
        f"Error of a dent: {info.field_error:.2f} (no dent: 1)",
        f"{info.blow_count} know their blow",
    ]
    lines += [f"  {one.name}: {millimetres * one.depth:.1f} mm, moves {one.moved_vertices}, error {one.field_error:.2f}" for one in examples]
    return lines
