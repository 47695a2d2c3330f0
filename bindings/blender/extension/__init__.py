"""Crumple for Blender: dents by example, and the examples themselves."""

from . import make, operators, panel


def register() -> None:
    operators.register()
    make.register()
    panel.register()


def unregister() -> None:
    panel.unregister()
    make.unregister()
    operators.unregister()
