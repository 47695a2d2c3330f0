"""Makes the examples of a bare mesh: round dents at once, or simulated ones by another program in the background."""

from __future__ import annotations

import json
import operator
import os
import queue
import re
import shutil
import subprocess
import threading
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import bpy
import numpy as np
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty

from . import bridge
from .bridge import Trouble
from .operators import MeshOperator

MADE = "crumple_made"
"""The custom property with the names of the shape keys that were made here, which the next ones replace."""
ROUND = 8
"""Round dents, if the artist gives no number."""
_ROUND_OPTIONS = ("count", "shallowest", "deepest")
_SOLVER_OPTIONS = (
    "quality", "count", "until_error", "go_on", "material", "thickness", "hold", "strikers", "lightest", "heaviest", "smallest", "largest", "tilt",
    "shallowest", "deepest", "detail", "jobs", "report_page",
)  # fmt: skip


class CRUMPLE_OT_make_examples(MeshOperator, bpy.types.Operator):
    """Make examples for a bare mesh: round dents at once, or simulated ones in the background. They replace those that it made before"""

    bl_idname = "crumple.make_examples"
    bl_label = "Make Examples"

    method: EnumProperty(
        name="Method",
        items=[
            ("PROFILE", "Round Dents", "At once. They do not know their blows"),
            ("SOLVER", "Simulated Dents", "By MuJoCo, in the background. Needs the Python package crumple with what its examples need"),
        ],
    )
    quality: EnumProperty(
        name="Quality", default="good",
        items=[
            ("draft", "Draft", "24 hits, about a minute"),
            ("good", "Good", "Up to 300 hits, 10 to 50 minutes on two cores"),
            ("best", "Best", "Up to 1000 hits on a finer shell, hours"),
        ],
    )  # fmt: skip
    count: IntProperty(name="Count", min=0, max=2000, description=f"Most examples. 0: as the quality says; {ROUND} round dents")
    until_error: FloatProperty(name="Until Error", min=0, max=1, description="Stop earlier, at this expected error of a hit. 0: do not")
    go_on: BoolProperty(name="Go On", description="Make all examples, also when more of them no longer lower the error")
    material: EnumProperty(name="Material", items=[(one, one.capitalize(), "") for one in ("steel", "aluminium", "tin", "plastic")])
    thickness: FloatProperty(name="Thickness", min=0, unit="LENGTH", precision=4, description="Of the sheet. 0: the material's own")
    hold: EnumProperty(
        name="Hold",
        items=[
            ("auto", "Automatic", "What is painted (Paint, Held), else the open edges, else the lowest points"),
            ("edges", "Open Edges", ""),
            ("marked", "Painted", "The vertex group of Paint, Held"),
            ("lowest", "Lowest Points", "What the body stands on"),
            ("free", "Nothing", "The body is free; dents are what remains when its motion is taken away"),
        ],
    )
    strikers: EnumProperty(
        name="Strikers", options={"ENUM_FLAG"}, default={"ball"},
        items=[
            ("ball", "Ball", ""),
            ("stone", "Stone", "A small ball"),
            ("pole", "Pole", "It stands upright"),
            ("wall", "Wall", "A flat plate as large as the mesh"),
            ("corner", "Corner", "Of a box"),
        ],
    )  # fmt: skip
    lightest: FloatProperty(name="Lightest", min=0, description="Striker, kg. 0: what dents need at 2 to 10 m/s")
    heaviest: FloatProperty(name="Heaviest", min=0, description="Striker, kg. 0: what dents need at 2 to 10 m/s")
    smallest: FloatProperty(name="Smallest", min=0, unit="LENGTH", description="Radius of a striker. 0: a share of the diagonal")
    largest: FloatProperty(name="Largest", min=0, unit="LENGTH", description="Radius of a striker. 0: a share of the diagonal")
    tilt: FloatProperty(name="Tilt", default=30, min=0, max=60, description="Largest angle between flight and surface normal, degrees")
    shallowest: FloatProperty(name="Shallowest", min=0, unit="LENGTH", description="Of usual dents. 0: a share of the diagonal")
    deepest: FloatProperty(name="Deepest", min=0, unit="LENGTH", description="Of usual dents. 0: a share of the diagonal")
    detail: IntProperty(name="Detail", min=0, max=50000, description="Points of the simulated shell, 200 or more. 0: as strikers and quality need")
    jobs: IntProperty(name="Jobs", min=0, max=1000, description="Simulations at a time. 0: one for each core")
    report_page: BoolProperty(name="Report", default=True, description="Write a page with pictures, a table and the learning curve")

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        self.window = True
        return context.window_manager.invoke_props_dialog(self)

    def draw(self, context: bpy.types.Context) -> None:
        self.layout.prop(self, "method")
        for name in _SOLVER_OPTIONS if self.method == "SOLVER" else _ROUND_OPTIONS:
            self.layout.prop(self, name)

    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = context.active_object
        changing = [one.name for one in obj.modifiers if one.type != "ARMATURE" and one.show_viewport]
        if changing:
            self.report({"WARNING"}, f"Examples are of the mesh without its modifiers ({', '.join(changing)}): apply them first")
        if self.method == "PROFILE":
            return self.safely(lambda: self.round(obj))
        if self.safely(lambda: self.start(context, obj)) == {"CANCELLED"}:
            return {"CANCELLED"}
        if getattr(self, "window", False):
            self.timer = context.window_manager.event_timer_add(0.2, window=context.window)
            context.window_manager.progress_begin(0, 100)
            context.window_manager.modal_handler_add(self)
            return {"RUNNING_MODAL"}
        self.process.wait()
        self.reader.join()
        return self.safely(lambda: self.finish(obj))

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if event.type == "ESC":
            self.process.terminate()
            try:
                # It finishes the hits that are running, without us.
                self.process.wait(0.5)
            except subprocess.TimeoutExpired:
                pass
            self.end(context)
            self.report({"WARNING"}, f"Stopped. Every finished hit is in {self.out.parent}; the same button goes on")
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        while not self.lines.empty():
            self.said.append(self.lines.get())
            done = re.match(r"(\d+) of (\d+): ", self.said[-1])
            if done:
                context.window_manager.progress_update(100 * int(done[1]) // max(int(done[2]), 1))
                context.workspace.status_text_set(f"Crumple's solver: {self.said[-1]}. Escape stops it")
        if self.process.poll() is None or self.reader.is_alive():
            return {"PASS_THROUGH"}
        self.end(context)
        obj = bpy.data.objects.get(self.of)
        if obj is None:
            self.report({"ERROR"}, f"{self.of} is gone; its examples are in {self.out}")
            return {"CANCELLED"}
        return self.safely(lambda: self.finish(obj))

    def end(self, context: bpy.types.Context) -> None:
        context.window_manager.event_timer_remove(self.timer)
        context.window_manager.progress_end()
        context.workspace.status_text_set(None)

    def depths(self, size: float) -> tuple[float, float]:
        """Of round dents, in units of the scene."""
        low, high = self.shallowest or 0.005 * size, self.deepest or 0.03 * size
        if not 0 < low < high <= 0.3 * size:
            raise Trouble(f"depths are {low:.3g} to {high:.3g} m; they must rise, up to {0.3 * size:.3g} m, 0.3 of the diagonal")
        return low, high

    def round(self, obj: bpy.types.Object) -> None:
        from crumple.examples import Failure, profile

        points = bridge.base_of(obj)
        corners = bridge.triangles(obj.data).astype(np.int64)
        if len(corners) == 0:
            raise Trouble(f"{obj.name} has no faces")
        # The profile's radius grows with the root of the depth, so it needs metres.
        metre = bridge.metre()
        distinct, of_vertex = np.unique(points, axis=0, return_inverse=True)
        of_vertex = of_vertex.reshape(-1)
        size = float(np.linalg.norm(np.ptp(points, axis=0)))
        body = SimpleNamespace(
            name=obj.name, points=distinct.astype(float) * metre, triangles=of_vertex[corners], of_vertex=of_vertex, size=size * metre,
            marked=bridge.painted(obj, bridge.HELD) > 0.5,
        )  # fmt: skip
        low, high = self.depths(size)
        try:
            made = profile.make(body, self.count or ROUND, (low * metre, high * metre))
        except Failure as failure:
            raise Trouble(str(failure)) from failure
        entries = {one.name: {"name": one.name, "point": bridge.y_up(one.point / metre), "normal": bridge.y_up(one.normal)} for one in made}
        self.add(obj, {one.name: points + one.field[of_vertex] / metre for one in made}, entries, [])

    def add(self, obj: bpy.types.Object, positions: dict[str, np.ndarray], entries: dict[str, Any], said: list[str]) -> None:
        """Adds shape keys in place of those that were made here before. The artist's own stay."""
        before = json.loads(obj.data.get(MADE, "[]"))
        for name in before:
            key = obj.data.shape_keys.key_blocks.get(name) if obj.data.shape_keys else None
            if key is not None:
                obj.shape_key_remove(key)
        told = {name: entry for name, entry in bridge.impacts(obj).items() if name not in before}
        if obj.data.shape_keys is None:
            obj.shape_key_add(name="Basis", from_mix=False)
        made = []
        for name, moved in positions.items():
            key = obj.shape_key_add(name=name, from_mix=False)
            key.value = 0.0
            key.points.foreach_set("co", np.ascontiguousarray(moved, np.float32).ravel())
            made.append(key.name)
            if name in entries:
                told[key.name] = {**entries[name], "name": key.name}
        obj.data[MADE] = json.dumps(made)
        bridge.describe(obj, told)
        model = bridge.model(obj)
        if obj.crumple_hits:
            bridge.show(obj)
        self.tell([f"{len(positions)} examples made", *said, *bridge.report(model.set.info, model.set.examples)])

    def folder(self, obj: bpy.types.Object) -> Path:
        """Beside the .blend file, so that another session goes on; of an unsaved scene in the session's own."""
        beside = Path(bpy.data.filepath).parent / "crumple" if bpy.data.filepath else Path(bpy.app.tempdir)
        folder = beside / bpy.path.clean_name(obj.name)
        folder.mkdir(parents=True, exist_ok=True)
        return folder

    def start(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        named = context.preferences.addons[__package__].preferences.program
        program = bpy.path.abspath(named) if named else shutil.which("crumple")
        if not program or not Path(program).is_file():
            wheel = next(Path(__file__).parent.glob("wheels/crumple-*.whl"), "crumple-VERSION-py3-none-PLATFORM.whl")
            raise Trouble(
                f"the solver is not installed: type pip install '{wheel}[examples]' in a Python environment, and name its program `crumple` in the "
                "preferences"
            )
        if not obj.data.polygons:
            raise Trouble(f"{obj.name} has no faces")
        if self.hold == "marked" and not (bridge.painted(obj, bridge.HELD) > 0.5).any():
            raise Trouble(f"nothing of {obj.name} is painted as held: choose Paint, Held first")
        folder = self.folder(obj)
        self.of, self.out, body = obj.name, folder / "examples.glb", folder / "body.glb"
        bridge.export_gltf([obj], body, examples=False)
        inner = folder / "solids.glb"
        self.out.unlink(missing_ok=True)
        command = [program, *self.arguments(body, inner if bridge.export_solids(obj, inner) else None)]
        # The solver's Python is another than Blender's.
        clean = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=clean)
        self.lines: queue.Queue[str] = queue.Queue()
        self.said: list[str] = []
        self.reader = threading.Thread(target=lambda: [self.lines.put(line.strip()) for line in self.process.stdout], daemon=True)
        self.reader.start()

    def arguments(self, body: Path, inner: Path | None) -> list[str]:
        """Of `crumple`."""
        metre = bridge.metre()
        out = ["examples", str(body), "-o", str(self.out), "--quality", self.quality, "--material", self.material, "--hold", self.hold]
        out += ["--strikers", *sorted(self.strikers or {"ball"}), "--tilt", f"{self.tilt:g}"]
        if metre != 1.0:
            out += ["--unit", f"{metre:.9g}"]
        given = {"--count": self.count, "--until-error": self.until_error, "--detail": self.detail, "--jobs": self.jobs}
        given["--thickness"] = 1000 * metre * self.thickness
        for name, value in given.items():
            out += [name, f"{value:.7g}"] if value else []
        for name, what, low, high, unit, rise in (
            ("--depth", "depths, the shallowest and the deepest", self.shallowest, self.deepest, 1000 * metre, operator.lt),
            ("--mass", "masses, of the lightest and the heaviest striker", self.lightest, self.heaviest, 1.0, operator.le),
            ("--radius", "radii, of the smallest and the largest striker", self.smallest, self.largest, 1000 * metre, operator.le),
        ):
            if low or high:
                if not (0 < low and rise(low, high)):
                    raise Trouble(f"give both {what}, or neither; they must rise")
                out += [name, f"{unit * low:.7g}", f"{unit * high:.7g}"]
        out += ["--go-on"] if self.go_on else []
        out += [] if self.report_page else ["--no-report"]
        return out + (["--inner", str(inner)] if inner else [])

    def finish(self, obj: bpy.types.Object) -> None:
        while not self.lines.empty():
            self.said.append(self.lines.get())
        if self.process.returncode != 0:
            raise Trouble(next((line for line in reversed(self.said) if "error: " in line), f"the solver ends with {self.process.returncode}"))
        points = bridge.base_of(obj)
        before = {kind: set(getattr(bpy.data, kind)) for kind in ("objects", "meshes", "collections")}
        active, selected = bpy.context.view_layer.objects.active, bpy.context.selected_objects
        # The importer takes units for metres, and the exporter does not: both are kept from that.
        units = bpy.context.scene.unit_settings
        length, units.scale_length = units.scale_length, 1.0
        try:
            bpy.ops.import_scene.gltf(filepath=str(self.out))
        finally:
            units.scale_length = length
        try:
            new = next(one for one in set(bpy.data.objects) - before["objects"] if one.type == "MESH" and one.data.shape_keys)
            keys = new.data.shape_keys.key_blocks
            # The file has vertices of its own, at the same positions. Adding 0 makes -0 and 0 equal.
            place = {row.tobytes(): index for index, row in enumerate(bridge.coordinates(keys[0]) + np.float32(0))}
            try:
                vertices = [place[row.tobytes()] for row in points + np.float32(0)]
            except KeyError as error:
                raise Trouble(f"{obj.name} changed while its examples were made; make them again") from error
            positions = {key.name: bridge.coordinates(key)[vertices] for key in keys[1:]}
            entries = bridge.impacts(new)
        finally:
            for kind in before:
                for one in set(getattr(bpy.data, kind)) - before[kind]:
                    getattr(bpy.data, kind).remove(one)
            for one in selected:
                one.select_set(True)
            bpy.context.view_layer.objects.active = active
        told = [line for line in self.said if line.startswith(("Warning: ", "Expected error", "report: "))]
        self.add(obj, positions, entries, told)
        for line in told:
            if line.startswith("Warning: "):
                self.report({"WARNING"}, line)


def register() -> None:
    bpy.utils.register_class(CRUMPLE_OT_make_examples)


def unregister() -> None:
    bpy.utils.unregister_class(CRUMPLE_OT_make_examples)
