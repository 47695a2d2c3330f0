"""Drives the packed extension in Blender's own window and photographs it: blender --python window.py -- EXTENSION.zip HOOD.glb PICTURE.png

It exits with 1 if anything fails.
"""

import sys
import traceback
import zipfile
from types import SimpleNamespace

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
    from bl_ext.user_default.crumple import operators

    bpy.ops.crumple.check()
    bpy.ops.crumple.coverage(kind="ERROR")
    bpy.ops.wm.tool_set_by_id(name="crumple.hit_tool")
    centre = view()["area"].spaces.active.region_3d.view_location
    # A click on the surface: the operator's own way from the mouse to the mesh, which is not dented yet, and then dented.
    region, data = view()["region"], view()["area"].spaces.active.region_3d
    for shift in ((0, 0, 0), (0.2, 0.15, 0), (0.2, 0.15, 0)):
        spot = location_3d_to_region_2d(region, data, centre + Vector(shift))
        context = SimpleNamespace(
            active_object=body, region=region, region_data=data, evaluated_depsgraph_get=bpy.context.evaluated_depsgraph_get
        )
        event = SimpleNamespace(mouse_region_x=spot.x, mouse_region_y=spot.y)
        place = operators.under_mouse(context, event)
        assert place is not None, f"nothing is under the mouse at {spot}"
        found = location_3d_to_region_2d(region, data, place)
        print("off the mouse:", (found - spot).length, "pixels")
        bpy.ops.crumple.hit(location=place, by="BLOW", mass=20, speed=8, radius=0.1)
    assert len(body.crumple_hits) == 3 and "Crumple damage" in body.data.shape_keys.key_blocks
    # The sidebar's tab.
    for region in view()["area"].regions:
        if region.type == "UI":
            region.active_panel_category = "Crumple"


def photograph():
    with bpy.context.temp_override(**view()):
        bpy.ops.wm.redraw_timer(type="DRAW_WIN_SWAP", iterations=3)
        bpy.ops.screen.screenshot(filepath=picture)


state = {}
bpy.context.preferences.view.show_splash = False


def step():
    at = state.setdefault("at", 0)
    try:
        with bpy.context.temp_override(**view()):
            if at == 0:
                state["body"] = prepare()
            elif at == 1:
                act(state["body"])
            elif at == 3:
                photograph()
                print("the window works")
                bpy.ops.wm.quit_blender()
                return None
    except Exception:
        traceback.print_exc()
        sys.stdout.flush()
        sys.stderr.flush()
        import os

        os._exit(1)
    state["at"] += 1
    return 1.0


bpy.app.timers.register(step, first_interval=1.0)
