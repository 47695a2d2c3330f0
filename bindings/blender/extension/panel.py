"""The sidebar's panel and the toolbar's tool."""

from __future__ import annotations

from typing import Any

import bpy
from mathutils import Vector

from . import bridge
from .operators import CRUMPLE_OT_hit, draw_hit

TOOL = "crumple.hit_tool"


class CRUMPLE_UL_examples(bpy.types.UIList):
    def draw_item(self, context: bpy.types.Context, layout: Any, data: Any, item: Any, icon: int, active_data: Any, active: str, index: int) -> None:
        layout.prop(item, "name", text="", emboss=False, icon="SHAPEKEY_DATA")
        if index > 0:
            layout.prop(item, "value", text="", emboss=False)
            layout.prop(item, "mute", text="", emboss=False, icon="HIDE_ON" if item.mute else "HIDE_OFF")


class CRUMPLE_UL_hits(bpy.types.UIList):
    def draw_item(self, context: bpy.types.Context, layout: Any, data: Any, item: Any, icon: int, active_data: Any, active: str, index: int) -> None:
        size = Vector(item.vector).length
        layout.label(text=f"{1000 * bridge.metre() * size:.0f} mm" if item.by == "DEPTH" else f"{item.mass:.3g} kg, {size:.3g} m/s")
        layout.prop(item, "frame", emboss=False)
        layout.operator("crumple.clear", text="", icon="X", emboss=False).index = index


class CRUMPLE_PT_main(bpy.types.Panel):
    bl_label = "Crumple"
    bl_category = "Crumple"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"

    def draw(self, context: bpy.types.Context) -> None:
        layout, obj = self.layout, context.active_object
        if obj is None or obj.type != "MESH":
            layout.label(text="Select a mesh")
            return
        box = layout.column(align=True)
        box.label(text="Examples: shape keys")
        if obj.data.shape_keys:
            box.template_list("CRUMPLE_UL_examples", "", obj.data.shape_keys, "key_blocks", obj, "active_shape_key_index", rows=4)
        box.operator("crumple.make_examples")
        box.operator("crumple.mark")
        box.operator("crumple.check")
        box.operator_menu_enum("crumple.coverage", "kind")
        box = layout.column(align=True)
        box.label(text="Limits")
        box.operator_menu_enum("crumple.paint", "what")
        if bridge.LIMIT in obj.vertex_groups:
            box.prop(obj, "crumple_deepest")
        row = box.row(align=True)
        row.operator("crumple.keep_out").clear = False
        if obj.crumple_solids:
            row.operator("crumple.keep_out", text="", icon="X").clear = True
        box = layout.column(align=True)
        box.label(text="Hits")
        box.operator("wm.tool_set_by_id", text="Click to Hit", icon="MOD_SOFT").name = TOOL
        box.operator("crumple.rigid_bodies")
        if obj.crumple_hits:
            box.template_list("CRUMPLE_UL_hits", "", obj, "crumple_hits", obj, "crumple_hit", rows=3)
            box.operator("crumple.bake")
            box.operator("crumple.clear")
        layout.operator("crumple.export", icon="EXPORT")
        said = bpy.data.texts.get(bridge.REPORT)
        if said is not None:
            box = layout.box().column(align=True)
            for line in said.lines[:6]:
                box.label(text=line.body)
            if len(said.lines) > 6:
                box.label(text=f"More: text {bridge.REPORT}")


class HitTool(bpy.types.WorkSpaceTool):
    bl_space_type = "VIEW_3D"
    bl_context_mode = "OBJECT"
    bl_idname = TOOL
    bl_label = "Crumple Hit"
    bl_description = CRUMPLE_OT_hit.__doc__
    bl_icon = "ops.transform.shrink_fatten"
    bl_keymap = ((CRUMPLE_OT_hit.bl_idname, {"type": "LEFTMOUSE", "value": "PRESS"}, None),)

    def draw_settings(context: bpy.types.Context, layout: Any, tool: Any) -> None:  # noqa: N805
        draw_hit(layout, tool.operator_properties(CRUMPLE_OT_hit.bl_idname))


CLASSES = (CRUMPLE_UL_examples, CRUMPLE_UL_hits, CRUMPLE_PT_main)


def register() -> None:
    for one in CLASSES:
        bpy.utils.register_class(one)
    bpy.utils.register_tool(HitTool, separator=True)


def unregister() -> None:
    bpy.utils.unregister_tool(HitTool)
    for one in reversed(CLASSES):
        bpy.utils.unregister_class(one)
