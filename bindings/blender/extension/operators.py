"""What the artist does. Every operator also works from scripts, without a window."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from bpy.props import BoolProperty, CollectionProperty, EnumProperty, FloatProperty, FloatVectorProperty, IntProperty, PointerProperty, StringProperty
from bpy_extras.io_utils import ExportHelper
from bpy_extras.view3d_utils import region_2d_to_origin_3d, region_2d_to_vector_3d
from mathutils import Vector
from mathutils.interpolate import poly_3d_calc
from mathutils.kdtree import KDTree

import crumple

from . import bridge, rigid
from .bridge import Trouble

PATTERNS = "Names with commas between them; * is any text, ? any character, ! takes names out"
COVERAGE = "Crumple coverage"
"""The colour attribute of the heat map."""
SAMPLES = 5000
"""Most vertices at which the library is asked for an expected error; the others take that of the nearest."""
BY = [
    ("DEPTH", "Depth", "The contact moves by this depth"),
    ("BLOW", "Blow", "A striker of this mass, speed and radius. The examples must know their blows"),
]


class Hit(bpy.types.PropertyGroup):
    """A stored hit, in the object's own space."""

    by: EnumProperty(items=BY)
    point: FloatVectorProperty()
    vector: FloatVectorProperty(description="The displacement of the contact, m, or the velocity of the striker, m/s")
    mass: FloatProperty(unit="MASS")
    radius: FloatProperty(unit="LENGTH")
    frame: IntProperty(name="Frame", description="The frame in which the dent appears when the hits are baked")


class Solid(bpy.types.PropertyGroup):
    """An object that dents of another do not enter."""

    object: PointerProperty(type=bpy.types.Object)


class Preferences(bpy.types.AddonPreferences):
    bl_idname = __package__
    program: StringProperty(
        name="Solver", subtype="FILE_PATH",
        description="The program `crumple` of a Python environment with crumple[examples]. If empty, the one on PATH",
    )  # fmt: skip

    def draw(self, context: bpy.types.Context) -> None:
        self.layout.prop(self, "program")


class MeshOperator:
    """An operator of the active mesh in Object Mode. Its troubles become messages."""

    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        obj = context.active_object
        if obj is None or obj.type != "MESH" or obj.mode != "OBJECT":
            cls.poll_message_set("Select a mesh in Object Mode")
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        return self.safely(lambda: self.run(context, context.active_object))

    def safely(self, work: Callable[[], None]) -> set[str]:
        try:
            work()
        except (Trouble, crumple.CrumpleError, OSError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}

    def tell(self, lines: list[str]) -> None:
        bridge.say(lines)
        self.report({"INFO"}, lines[0])


class CRUMPLE_OT_hit(MeshOperator, bpy.types.Operator):
    """Dent the mesh. In the viewport: click the place, and drag to the right for a deeper dent"""

    bl_idname = "crumple.hit"
    bl_label = "Hit"

    location: FloatVectorProperty(name="Location", subtype="XYZ_LENGTH", description="In the scene. The nearest vertex is the contact")
    direction: FloatVectorProperty(name="Direction", subtype="XYZ", description="In the scene. Zero: against the surface")
    by: EnumProperty(name="Told", items=BY)
    depth: FloatProperty(name="Depth", default=0.02, min=0, unit="LENGTH", description="How far the contact moves")
    mass: FloatProperty(name="Mass", default=5, min=0, unit="MASS", description="Of the striker")
    speed: FloatProperty(name="Speed", default=5, min=0, unit="VELOCITY", description="Of the striker")
    radius: FloatProperty(name="Radius", default=0.1, min=0, unit="LENGTH", description="Of the striker at the contact. 0: unknown")

    def draw(self, context: bpy.types.Context) -> None:
        draw_hit(self.layout, self)
        self.layout.prop(self, "location")
        self.layout.prop(self, "direction")

    def run(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        hit = obj.crumple_hits.add()
        hit.frame = context.scene.frame_current
        try:
            self.fill(hit, obj)
            result = bridge.show(obj)
            assert result is not None
            if result.status != crumple.HitStatus.MARKED:
                raise Trouble(f"the hit leaves no dent: {result.status.name.lower().replace('_', ' ')}")
        except Exception:
            obj.crumple_hits.remove(len(obj.crumple_hits) - 1)
            if bridge.example_keys(obj):
                bridge.show(obj)
            raise
        cut = ", cut to the depth limit" if result.clamped else ""
        depth = 1000 * bridge.metre() * np.linalg.norm(result.achieved)
        self.report({"INFO"}, f"Dented by {depth:.1f} mm{cut}; expected error {result.expected_error:.2f}")

    def fill(self, hit: Hit, obj: bpy.types.Object) -> None:
        if abs(obj.matrix_world.determinant()) < 1e-12:
            raise Trouble(f"{obj.name} is scaled to nothing")
        back = obj.matrix_world.inverted()
        model = bridge.model(obj)
        hit.by, hit.mass, hit.radius = self.by, self.mass, self.radius
        hit.point = back @ Vector(self.location)
        towards = Vector(self.direction)
        if towards.length == 0:
            vertex, _ = model.set.nearest_vertex(tuple(hit.point))
            towards = -(back.to_3x3().transposed() @ Vector(model.set.mesh().normals[vertex]))
        hit.vector = back.to_3x3() @ (towards.normalized() * (self.depth if self.by == "DEPTH" else self.speed))

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        place = under_mouse(context, event)
        if place is None:
            return {"PASS_THROUGH"}
        self.location, self.direction = place, (0, 0, 0)
        self.began = event.mouse_x
        self.first = (self.depth, self.speed)
        if self.execute(context) == {"CANCELLED"}:
            return {"CANCELLED"}
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        obj = context.active_object
        if event.type == "MOUSEMOVE":
            factor = 2 ** ((event.mouse_x - self.began) / 100)
            self.depth, self.speed = (factor * value for value in self.first)
            self.safely(lambda: (self.fill(obj.crumple_hits[-1], obj), bridge.show(obj)))
        elif event.type in {"LEFTMOUSE", "RET"} and event.value in {"RELEASE", "PRESS"}:
            return {"FINISHED"}
        elif event.type in {"ESC", "RIGHTMOUSE"}:
            obj.crumple_hits.remove(len(obj.crumple_hits) - 1)
            self.safely(lambda: bridge.show(obj))
            return {"CANCELLED"}
        return {"RUNNING_MODAL"}


def draw_hit(layout: bpy.types.UILayout, hit: Any) -> None:
    layout.row().prop(hit, "by", expand=True)
    for name in ("depth",) if hit.by == "DEPTH" else ("mass", "speed", "radius"):
        layout.prop(hit, name)


def under_mouse(context: bpy.types.Context, event: bpy.types.Event) -> Vector | None:
    """Where the mouse points at the active object: the place on the undamaged mesh, in the scene."""
    obj, at = context.active_object, (event.mouse_region_x, event.mouse_region_y)
    view = context.region, context.region_data, at
    shown = obj.evaluated_get(context.evaluated_depsgraph_get())
    back = obj.matrix_world.inverted()
    origin = back @ region_2d_to_origin_3d(*view)
    found, place, _, face = shown.ray_cast(origin, back.to_3x3() @ region_2d_to_vector_3d(*view))
    if not found:
        return None
    polygons = obj.data.polygons
    if len(shown.data.polygons) == len(polygons) and obj.data.shape_keys:
        corners = polygons[face].vertices
        weights = poly_3d_calc([shown.data.vertices[v].co for v in corners], place)
        base = obj.data.shape_keys.reference_key.points
        place = sum((weight * base[v].co for weight, v in zip(weights, corners, strict=True)), Vector())
    return obj.matrix_world @ place


class CRUMPLE_OT_clear(MeshOperator, bpy.types.Operator):
    """Remove one hit, or all hits with their dents"""

    bl_idname = "crumple.clear"
    bl_label = "Clear Hits"
    index: IntProperty(default=-1, min=-1, description="The hit to remove. -1: all")

    def run(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        if self.index >= len(obj.crumple_hits):
            raise Trouble(f"there is no hit {self.index}; {obj.name} has {len(obj.crumple_hits)}")
        if self.index < 0:
            obj.crumple_hits.clear()
            bridge.remove_damage(obj)
        else:
            obj.crumple_hits.remove(self.index)
            bridge.show(obj)


class CRUMPLE_OT_rigid_bodies(MeshOperator, bpy.types.Operator):
    """Play the scene's rigid-body simulation, and hit the mesh where and when other bodies hit it. Replaces its hits"""

    bl_idname = "crumple.rigid_bodies"
    bl_label = "Hits from Rigid Bodies"
    slowest: FloatProperty(name="Slowest", default=1.0, min=0.01, unit="VELOCITY", description="Slower blows leave no dent")

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        return context.window_manager.invoke_props_dialog(self)

    def run(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        if bridge.model(obj).set.info.blow_count == 0:
            raise Trouble(f"the examples of {obj.name} do not know their blows; simulate some (Make Examples), or mark them with their strikers")
        found = rigid.blows(context.scene, obj, self.slowest)
        if not found:
            raise Trouble(f"nothing hits {obj.name} at {self.slowest:.3g} m/s or faster; its hits stay as they were")
        back = obj.matrix_world.inverted().to_3x3()
        obj.crumple_hits.clear()
        for blow in found:
            hit = obj.crumple_hits.add()
            hit.by, hit.point, hit.frame = "BLOW", blow.point, blow.frame
            hit.vector, hit.mass, hit.radius = back @ Vector(blow.velocity), blow.mass, blow.radius
        bridge.show(obj)
        self.report({"INFO"}, f"{len(found)} hits, in the frames {found[0].frame} to {found[-1].frame}")


class CRUMPLE_OT_bake(MeshOperator, bpy.types.Operator):
    """Make keyed shape keys of the hits: each dent appears in its hit's frame, and any exporter writes the animation"""

    bl_idname = "crumple.bake"
    bl_label = "Bake Hits to Frames"

    def run(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        if not obj.crumple_hits:
            raise Trouble(f"{obj.name} has no hits")
        self.report({"INFO"}, f"{bridge.bake(obj)} keyed shape keys")


class CRUMPLE_OT_mark(MeshOperator, bpy.types.Operator):
    """Say where the active shape key was hit, and by what. It is stored in the mesh's custom properties, and exported"""

    bl_idname = "crumple.mark"
    bl_label = "Mark Example"

    at: EnumProperty(
        name="Contact",
        items=[("DEEPEST", "Deepest Vertex", "The vertex that moves furthest"), ("CURSOR", "3D Cursor", "The vertex nearest to the 3D cursor")],
    )
    impulse: FloatProperty(name="Impulse (N s)", min=0, description="Of the blow, on the body. 0: mass times speed, or unknown")
    mass: FloatProperty(name="Mass", min=0, unit="MASS", description="Of the striker. 0: unknown")
    speed: FloatProperty(name="Speed", min=0, unit="VELOCITY", description="Of the striker. 0: unknown")
    radius: FloatProperty(name="Radius", min=0, unit="LENGTH", description="Of the striker at the contact. 0: unknown")

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        return context.window_manager.invoke_props_dialog(self)

    def run(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        key = obj.active_shape_key
        if key is None or key not in bridge.example_keys(obj):
            raise Trouble("choose a shape key that is an example: not the basis, not a dent, and not switched off")
        base = bridge.coordinates(obj.data.shape_keys.reference_key)
        moved = np.linalg.norm(bridge.coordinates(key) - bridge.coordinates(key.relative_key), axis=1)
        if moved.max() == 0:
            raise Trouble(f"{key.name} moves no vertex; sculpt its dent first")
        if self.at == "DEEPEST":
            vertex = int(moved.argmax())
        else:
            cursor = obj.matrix_world.inverted() @ context.scene.cursor.location
            vertex = int(np.linalg.norm(base - np.array(cursor, np.float32), axis=1).argmin())
            if moved[vertex] < 0.01 * moved.max():
                raise Trouble(f"{key.name} does not move the vertex at the 3D cursor; put the cursor into the dent (Shift + right click)")
        normal = np.array(obj.data.shape_keys.reference_key.normals_vertex_get()[3 * vertex : 3 * vertex + 3])
        entry: dict[str, Any] = {"name": key.name, "point": bridge.y_up(base[vertex]), "normal": bridge.y_up(normal)}
        impulse = self.impulse or self.mass * self.speed
        if impulse:
            entry["impulse"] = bridge.y_up(-impulse * normal)
        told = {"mass": self.mass, "radius": self.radius * bridge.metre()}
        striker: dict[str, Any] = {name: value for name, value in told.items() if value}
        if self.speed:
            striker["velocity"] = bridge.y_up(-self.speed * normal)
        if striker:
            entry["striker"] = striker
        bridge.describe(obj, bridge.impacts(obj) | {key.name: entry})
        self.report({"INFO"}, f"{key.name} was hit at vertex {vertex}, {1000 * bridge.metre() * moved[vertex]:.1f} mm deep")


class CRUMPLE_OT_paint(MeshOperator, bpy.types.Operator):
    """Paint where the mesh dents less. What is painted is a vertex group, which hits respect and the export writes"""

    bl_idname = "crumple.paint"
    bl_label = "Paint"

    what: EnumProperty(
        name="Paint",
        items=[
            ("LIMIT", "Depth Limit", "Red does not move at all, blue up to nearly the limit, and what is not painted as far as any dent"),
            ("STIFFNESS", "Stiffness", "Red does not move at all, green half as far as elsewhere"),
            ("HELD", "Held", "Where the solver of Make Examples holds the mesh: what is redder than green. Choose Hold: Marked, or Automatic"),
        ],
    )

    def run(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        name = {"LIMIT": bridge.LIMIT, "STIFFNESS": bridge.STIFFNESS, "HELD": bridge.HELD}[self.what]
        group = obj.vertex_groups.get(name) or obj.vertex_groups.new(name=name)
        obj.vertex_groups.active_index = group.index
        bpy.ops.object.mode_set(mode="WEIGHT_PAINT")


class CRUMPLE_OT_keep_out(MeshOperator, bpy.types.Operator):
    """Keep the dents of the active mesh out of the other selected meshes, which are closed solids. Repeat it when one has moved"""

    bl_idname = "crumple.keep_out"
    bl_label = "Keep Out of Selected"
    clear: BoolProperty(name="Clear", description="Let dents go everywhere again. Painted limits stay")

    def run(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        if self.clear:
            obj.crumple_solids.clear()
            bridge.set_attribute(obj.data, bridge.ATTRIBUTES[0], None)
        else:
            solids = [one for one in context.selected_objects if one.type == "MESH" and one != obj]
            if not solids:
                raise Trouble(f"select the solids too: first the objects inside, then {obj.name} with Shift")
            if abs(obj.matrix_world.determinant()) < 1e-12:
                raise Trouble(f"{obj.name} is scaled to nothing")
            limits = bridge.keep_out(obj, solids)
            bridge.set_attribute(obj.data, bridge.ATTRIBUTES[0], limits)
            obj.crumple_solids.clear()
            for one in solids:
                obj.crumple_solids.add().object = one
            inside = int((limits == 0).sum())
            self.report({"INFO"}, f"Dents keep out of {', '.join(one.name for one in solids)}; {inside} vertices begin inside and do not move")
        if obj.crumple_hits:
            bridge.show(obj)


class CRUMPLE_OT_check(MeshOperator, bpy.types.Operator):
    """Look for what makes examples bad, and show what the library says of them"""

    bl_idname = "crumple.check"
    bl_label = "Check Examples"
    bl_options = {"REGISTER"}

    def run(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        found = troubles(obj)
        model = bridge.model(obj)
        lines = [f"{len(found)} things to look at" if found else "Nothing wrong was found", *found, *bridge.report(model.set.info, model.set.examples)]
        bridge.say(lines)
        self.report({"WARNING"} if found else {"INFO"}, "; ".join([lines[0], *found]))


def troubles(obj: bpy.types.Object) -> list[str]:
    """What an artist should change."""
    model, told = bridge.model(obj), bridge.impacts(obj)
    found = []
    if (obj.matrix_world.to_scale() - Vector((1, 1, 1))).length > 1e-4:
        found.append("the object is scaled: apply its scale, or depths are not in metres")
    found += [f"modifier {one.name}: apply it first, the exporter leaves it out" for one in obj.modifiers if one.type != "ARMATURE"]
    found += [f"the custom property impacts names {name}, which is no example" for name in told if name not in model.names]
    for number, (one, field) in enumerate(zip(model.set.examples, model.fields, strict=True)):
        if one.moved_vertices == 0:
            found.append(f"{one.name} moves no vertex: sculpt it, or delete it")
            continue
        if one.name not in told:
            found.append(f"{one.name} has no contact: mark it, or its deepest vertex counts")
        if one.moved_vertices > 0.75 * len(model.base):
            share = one.moved_vertices / len(model.base)
            found.append(f"{one.name} reaches beyond its dent, over {share:.0%} of the mesh: undo what its blow would not reach")
        if one.depth < 0.1 * one.max_depth:
            found.append(f"{one.name} hardly moves its contact: mark it again, inside the dent")
        elif field[one.contact_vertex] @ one.contact_normal > 0:
            found.append(f"{one.name} moves its contact outwards: flip the mesh's normals, or sculpt inwards")
        for name, other in zip(model.names[:number], model.fields, strict=False):
            if np.linalg.norm(field - other) < 0.01 * np.linalg.norm(field):
                found.append(f"{one.name} repeats {name}: delete one")
        if one.field_error > 1:
            found.append(f"{one.name} is unlike the others (error {one.field_error:.2f}): one more example near it helps most")
    return found


class CRUMPLE_OT_coverage(MeshOperator, bpy.types.Operator):
    """Paint a heat map: blue is good, red needs an example. The 3D cursor goes to the worst place"""

    bl_idname = "crumple.coverage"
    bl_label = "Show Coverage"

    kind: EnumProperty(
        name="Show",
        items=[
            ("ERROR", "Expected Error", "Of a dent at each place. Red: 1, as bad as no dent"),
            ("REACH", "Reach", "How deep some example moves each place. Red: not at all. Blue: as deep as the deepest"),
        ],
    )

    def run(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        model = bridge.model(obj)
        if self.kind == "REACH":
            deepest = np.max([np.linalg.norm(field, axis=1) for field in model.fields], axis=0)
            bad = 1 - deepest / max(float(deepest.max()), 1e-30)
            line = f"Some example moves {(deepest > 0).mean():.0%} of the vertices"
        else:
            bad = expected_errors(model)
            line = f"Expected error: {np.median(bad):.2f}; {bad.max():.2f} at cursor"
        paint(obj.data, np.clip(bad, 0, 1))
        context.scene.cursor.location = obj.matrix_world @ Vector(model.base[int(bad.argmax())])
        for area in context.screen.areas if context.screen else ():
            if area.type == "VIEW_3D" and area.spaces.active.shading.type == "SOLID":
                area.spaces.active.shading.color_type = "VERTEX"
        self.tell([line, *bridge.report(model.set.info, model.set.examples)])


def expected_errors(model: bridge.Model) -> np.ndarray:
    """For each vertex: the expected error of a dent of middling depth there; 1 where there is none."""
    mesh = model.set.mesh()
    depth = float(np.median([one.depth for one in model.set.examples]))
    body = model.set.instance()
    try:
        asked = np.unique(np.linspace(0, len(model.base) - 1, SAMPLES).astype(int))
        errors, tree = [], KDTree(len(asked))
        for index, vertex in enumerate(asked):
            tree.insert(model.base[vertex], index)
            result = body.hit_displacement(model.base[vertex], -depth * mesh.normals[vertex], preview=True)
            errors.append(result.expected_error if result.status == crumple.HitStatus.MARKED else 1.0)
    finally:
        body.destroy()
    tree.balance()
    return np.array(errors)[[tree.find(point)[1] for point in model.base]]


def paint(mesh: bpy.types.Mesh, bad: np.ndarray) -> None:
    """Colours from blue (0) over green to red (1)."""
    colours = np.ones((len(bad), 4), np.float32)
    colours[:, :3] = np.clip(np.stack([2 * bad - 0.5, 1.2 - 2 * np.abs(bad - 0.5), 1.5 - 2 * bad], -1), 0.03, 1)
    layer = mesh.color_attributes.get(COVERAGE)
    if layer is not None:
        mesh.color_attributes.remove(layer)
    layer = mesh.color_attributes.new(COVERAGE, "FLOAT_COLOR", "POINT")
    layer.data.foreach_set("color", colours.ravel())
    mesh.color_attributes.active_color = layer


class CRUMPLE_OT_export(MeshOperator, ExportHelper, bpy.types.Operator):
    """Write the mesh with its examples: a .glb file, or a .crumple file, which loads without being built again"""

    bl_idname = "crumple.export"
    bl_label = "Export for Crumple"
    bl_options = {"REGISTER"}
    filename_ext = ".glb"
    check_extension = None
    filter_glob: StringProperty(default="*.glb;*.crumple", options={"HIDDEN"})
    tolerance: FloatProperty(
        name="Tolerance (mm)", default=0.1, min=0, description="Largest position error of a .crumple file, in millimetres. 0: exact floats"
    )
    parts: BoolProperty(name="Selected as One Body", description="Write all selected meshes as one body, with a part for each object")
    targets: StringProperty(name="Dents", description=f"Shape keys that are dents, of a .crumple file. {PATTERNS}. Empty: all")
    rigid: StringProperty(name="Rigid", description=f"Objects or materials that never move, of a .crumple file. {PATTERNS}")
    glass: StringProperty(name="Glass", description=f"Objects or materials that follow the dents around them, of a .crumple file. {PATTERNS}")
    moving: StringProperty(name="Moving", description=f"Objects that are no part of a .crumple file's body, such as wheels. {PATTERNS}")
    unit: FloatProperty(name="Unit (m)", default=1.0, min=1e-6, description="Length of the scene's unit in a .crumple file, in metres")

    def run(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        path = Path(bpy.path.abspath(self.filepath))
        if path.suffix not in (".glb", ".crumple"):
            raise Trouble(f"the file is {path.name}; its name must end in .glb or .crumple")
        chosen = {name: [word.strip() for word in getattr(self, name).split(",") if word.strip()] for name in ("targets", "rigid", "glass", "moving")}
        told = [name for name, words in chosen.items() if words] + (["unit"] if self.unit != 1.0 else [])
        if told and path.suffix == ".glb":
            raise Trouble(f"{told[0]} is of .crumple files; in a .glb file the custom properties dents (of a mesh) and crumple (rigid, glass or moving) say it")
        objects = [obj] + [one for one in context.selected_objects if self.parts and one.type == "MESH" and one != obj]
        names = bridge.model(obj).names
        written = path if path.suffix == ".glb" else Path(bpy.app.tempdir) / "crumple_bake.glb"
        part = written.with_name(f"{written.stem}.part.glb")
        bridge.export_gltf(objects, part)
        with crumple.Context() as library:
            try:
                options = crumple.SetOptions(bake_tolerance=1e-3 * self.tolerance) if path.suffix == ".crumple" else None
                loaded = library.load(part, None if self.parts else obj.data.name, options, nodes="*" if self.parts else (), unit=self.unit, **chosen)
                if not self.parts and not chosen["targets"] and [one.name for one in loaded.examples] != names:
                    raise Trouble(f"the exporter wrote {loaded.info.example_count} examples of {len(names)}; nothing was kept")
                if path.suffix == ".crumple":
                    # A file of the old name is replaced when the new one is whole.
                    whole = path.with_name(f"{path.name}.part")
                    whole.write_bytes(loaded.bake())
                    whole.replace(path)
                    loaded = library.load(path)
                else:
                    part.replace(path)
            finally:
                part.unlink(missing_ok=True)
            self.tell([f"{path.name}: {path.stat().st_size / 1e6:.2f} MB", *bridge.report(loaded.info, loaded.examples)])


CLASSES = (
    Hit, Solid, Preferences, CRUMPLE_OT_hit, CRUMPLE_OT_clear, CRUMPLE_OT_rigid_bodies, CRUMPLE_OT_bake, CRUMPLE_OT_mark, CRUMPLE_OT_paint,
    CRUMPLE_OT_keep_out, CRUMPLE_OT_check, CRUMPLE_OT_coverage, CRUMPLE_OT_export,
)  # fmt: skip


def register() -> None:
    for one in CLASSES:
        bpy.utils.register_class(one)
    bpy.types.Object.crumple_hits = CollectionProperty(type=Hit)
    bpy.types.Object.crumple_hit = IntProperty(description="The hit that is chosen in the list")
    bpy.types.Object.crumple_solids = CollectionProperty(type=Solid)
    bpy.types.Object.crumple_deepest = FloatProperty(
        name="Limit", default=0.1, min=0, unit="LENGTH",
        description="A painted depth limit of weight w lets vertices move by 1 - w of this",
    )  # fmt: skip


def unregister() -> None:
    del bpy.types.Object.crumple_hits, bpy.types.Object.crumple_hit, bpy.types.Object.crumple_solids, bpy.types.Object.crumple_deepest
    for one in reversed(CLASSES):
        bpy.utils.unregister_class(one)
    bridge.close()
