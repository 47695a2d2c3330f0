"""Drives the packed extension in Blender's own window and photographs it: blender --enable-event-simulate --python window.py -- EXTENSION.zip HOOD.glb PICTURE.png

It exits with 1 if anything fails.
"""

import os
import sys
import tempfile
import traceback
import zipfile
from pathlib import Path

import addon_utils
import bpy
from bpy_extras.view3d_utils import location_3d_to_region_2d
from mathutils import Euler, Vector

extension, hood, picture = sys.argv[sys.argv.index("--") + 1 :]


def view():
    window = bpy.context.window_manager.windows[0]
    area = next(one for one in window.screen.areas if one.type == "VIEW_3D")
    region = next(one for one in area.regions if one.type == "WINDOW")
    return {"window": window, "area": area, "region": region}


def prepare():
    # What the preferences' "Install from Disk" does, which needs a Python program beside Blender's.
    with zipfile.ZipFile(extension) as archive:
        archive.extractall(bpy.utils.user_resource("EXTENSIONS", path="user_default", create=True))
    addon_utils.modules_refresh()
    addon_utils.extensions_refresh(ensure_wheels=True, addon_modules_pending=["bl_ext.user_default.crumple"])
    assert addon_utils.enable("bl_ext.user_default.crumple", default_set=True)
    for one in list(bpy.data.objects):
        bpy.data.objects.remove(one)
    bpy.ops.import_scene.gltf(filepath=hood)
    body = next(one for one in bpy.data.objects if one.type == "MESH" and one.data.shape_keys)
    for one in bpy.data.objects:
        one.select_set(one == body)
    bpy.context.view_layer.objects.active = body
    for key in body.data.shape_keys.key_blocks[1:]:
        key.value = 0
    space = view()["area"].spaces.active
    space.show_region_ui = True
    space.overlay.show_floor = space.overlay.show_axis_x = space.overlay.show_axis_y = False
    space.shading.show_cavity = True
    space.region_3d.view_perspective = "PERSP"
    space.region_3d.view_rotation = Euler((0.8, 0, 0.5)).to_quaternion()
    corners = [body.matrix_world @ Vector(corner) for corner in body.bound_box]
    space.region_3d.view_location = sum(corners, Vector()) / 8
    space.region_3d.view_distance = 1.3 * max((a - b).length for a in corners for b in corners)
    return body


def act(body):
    bpy.ops.crumple.check()
    bpy.ops.crumple.coverage(kind="ERROR")
    bpy.ops.wm.tool_set_by_id(name="crumple.hit_tool")
    for region in view()["area"].regions:
        if region.type == "UI":
            region.active_panel_category = "Crumple"


def mouse(shift, type, value, drag=0):
    """One event of the mouse, at a place of the view beside its centre."""
    window, region = view()["window"], view()["region"]
    data = view()["area"].spaces.active.region_3d
    spot = location_3d_to_region_2d(region, data, data.view_location + Vector(shift))
    window.event_simulate(type, value, x=round(region.x + spot.x) + drag, y=round(region.y + spot.y))


def depth(body):
    keys = body.data.shape_keys.key_blocks
    return max((keys["Crumple damage"].points[v].co - keys[0].points[v].co).length for v in range(len(keys[0].points)))


def dragged(body):
    """A click and a drag to the right by 30 pixels: 2 cm times 2 ** 0.3."""
    assert len(body.crumple_hits) == 1, len(body.crumple_hits)
    assert abs(depth(body) - 0.02 * 2**0.3) < 0.002, depth(body)


def escaped(body):
    assert len(body.crumple_hits) == 1, len(body.crumple_hits)


class Solver:
    """A program that stands for `crumple examples`: it says that one example is made, and goes on until it is stopped."""

    folder = Path(tempfile.mkdtemp())

    @classmethod
    def start(cls, body):
        program, cls.keys = cls.folder / "crumple", len(body.data.shape_keys.key_blocks)
        program.write_text(f'#!/bin/sh\necho $$ > {cls.folder}/process\necho "1 of 8: 12 mm"\nexec sleep 600\n')
        program.chmod(0o755)
        bpy.context.preferences.addons["bl_ext.user_default.crumple"].preferences.program = str(program)
        window, region = view()["window"], view()["region"]
        window.event_simulate("MOUSEMOVE", "NOTHING", x=region.x + region.width // 2, y=region.y + region.height // 2)
        assert bpy.ops.crumple.make_examples("INVOKE_DEFAULT", method="SOLVER", count=8) == {"RUNNING_MODAL"}

    @classmethod
    def runs(cls):
        process = int((cls.folder / "process").read_text())
        try:
            os.kill(process, 0)
        except ProcessLookupError:
            return False
        return True

    @classmethod
    def working(cls, body):
        assert cls.runs() and "crumple.make_examples" in cls.modal(), cls.modal()

    @classmethod
    def stopped(cls, body):
        assert not cls.runs() and "crumple.make_examples" not in cls.modal(), cls.modal()
        assert len(body.data.shape_keys.key_blocks) == cls.keys and len(body.crumple_hits) == 1

    @staticmethod
    def modal():
        return [one.bl_idname.lower().replace("_ot_", ".") for one in view()["window"].modal_operators]


def key(type, value):
    window, region = view()["window"], view()["region"]
    window.event_simulate(type, value, x=region.x + region.width // 2, y=region.y + region.height // 2)


LEFT, RIGHT = (-0.2, -0.1, 0), (0.2, 0.15, 0)
STEPS = [
    act,
    lambda body: mouse(LEFT, "MOUSEMOVE", "NOTHING"),
    lambda body: mouse(LEFT, "LEFTMOUSE", "PRESS"),
    lambda body: mouse(LEFT, "MOUSEMOVE", "NOTHING", drag=30),
    lambda body: mouse(LEFT, "LEFTMOUSE", "RELEASE", drag=30),
    dragged,
    lambda body: mouse(RIGHT, "MOUSEMOVE", "NOTHING"),
    lambda body: mouse(RIGHT, "LEFTMOUSE", "PRESS"),
    lambda body: mouse(RIGHT, "ESC", "PRESS"),
    lambda body: mouse(RIGHT, "ESC", "RELEASE"),
    lambda body: mouse(RIGHT, "LEFTMOUSE", "RELEASE"),
    escaped,
    Solver.start,
    # The dialogue's OK.
    lambda body: key("RET", "PRESS"),
    lambda body: key("RET", "RELEASE"),
    Solver.working,
    lambda body: key("ESC", "PRESS"),
    lambda body: key("ESC", "RELEASE"),
    Solver.stopped,
    lambda body: bpy.ops.crumple.hit(location=body.matrix_world @ body.data.vertices[9000].co, by="BLOW", mass=20, speed=8, radius=0.1),
    lambda body: photograph(),
]


def photograph():
    with bpy.context.temp_override(**view()):
        bpy.ops.wm.redraw_timer(type="DRAW_WIN_SWAP", iterations=3)
        bpy.ops.screen.screenshot(filepath=picture)


bpy.context.preferences.view.show_splash = False
state = {"at": 0, "body": None}


def step():
    try:
        with bpy.context.temp_override(**view()):
            if state["body"] is None:
                state["body"] = prepare()
            elif state["at"] < len(STEPS):
                STEPS[state["at"]](state["body"])
                state["at"] += 1
            else:
                print("the window works")
                bpy.ops.wm.quit_blender()
                return None
    except Exception:
        traceback.print_exc()
        sys.stderr.flush()
        os._exit(1)
    return 0.5


bpy.app.timers.register(step, first_interval=1.0)
