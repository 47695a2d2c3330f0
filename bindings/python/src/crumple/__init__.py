"""Crumple dents meshes by example.

A ``Context`` loads or builds an ``ExampleSet``; the set makes ``Instance``s; hits dent them; ``Context.deform`` writes the deformed
vertices into your numpy arrays. Metres, seconds, kilograms, newton seconds. The names follow include/crumple.h, which says more
about each; what the package does not wrap (Vulkan, allocators, an engine's job system) is there as ``crumple.native`` and
``crumple.library``.
"""

from . import _native as native
from ._library import CrumpleError, library
from .context import Context, keep_out
from .example_set import ExampleSet
from .instance import Buffer, Instance
from .types import (
    MARK,
    Attachment,
    Changes,
    ContactHit,
    ContactPoint,
    ContactReport,
    DeformReport,
    Example,
    ExampleInfo,
    HitResult,
    HitStatus,
    InstanceInfo,
    Mesh,
    Pose,
    Primitive,
    Result,
    Rule,
    Selection,
    SetInfo,
    SetOptions,
    Space,
    Striker,
    StrikerShape,
)

__version__: str = library.crumple_version_string().decode()
"""The version of the library."""

__all__ = [
    "MARK", "Attachment", "Buffer", "Changes", "ContactHit", "ContactPoint", "ContactReport", "Context", "CrumpleError",
    "DeformReport", "Example", "ExampleInfo", "ExampleSet", "HitResult", "HitStatus", "Instance", "InstanceInfo", "Mesh", "Pose", "Primitive", "Result",
    "Rule", "Selection", "SetInfo", "SetOptions", "Space", "Striker", "StrikerShape", "keep_out", "library", "native",
]  # fmt: skip
