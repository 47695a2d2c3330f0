"""Crumple for Blender: dents by example, and the examples themselves."""

from . import operators, panel


def register() -> None:
    operators.register()
    panel.register()


def unregister() -> None:
    panel.unregister()
    operators.unregister()
