"""The context: the start of everything."""

from __future__ import annotations

import ctypes
import os
from collections.abc import Callable, Iterable, Sequence
from types import TracebackType
from typing import Any, Self
from weakref import WeakValueDictionary

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native as native
from ._arrays import Vector, elements, given, vector, vector3
from ._library import check, library
from .example_set import ExampleSet
from .instance import Buffer, Instance, _hit_result
from .types import ContactHit, ContactPoint, ContactReport, DeformReport, Example, SetOptions

_OPTIONS = (
    "depth_limit", "drop_below", "vertex_mass", "basis_tolerance", "bake_tolerance", "bake_normal_tolerance",
    "mirror", "held_rims", "whole_examples",
)  # fmt: skip


class Context:
    """Holds example sets, instances and buffers. Use it in a ``with`` statement, or call ``close()``.

    Only one thread at a time may use a context and what belongs to it, except for the hits and the transform of instances,
    which any thread may give at any time.
    """

    def __init__(self, threads: int = 0, log: Callable[[str, bool], None] | None = None) -> None:
        """`threads` deform; 0 is one per core. `log` gets each message and whether it is a warning."""
        self._handle: ctypes.c_void_p | None = None
        definition = library.crumple_context_def_default()
        definition.threads = _natural(threads, "threads")
        self._log = native.CrumpleLog()
        if log is not None:
            self._log = native.CrumpleLog(lambda level, text, _: log(text.decode(), level == native.CrumpleLogLevel.WARNING))
        definition.log = self._log
        handle = ctypes.c_void_p()
        check(library.crumple_context_create(ctypes.byref(definition), ctypes.byref(handle)))
        self._handle = handle
        # Memory that the library writes, by buffer: it must live as long as the buffer.
        self._memory: dict[tuple[int, int], tuple[Any, ...]] = {}
        # The instances of contact points, by id.
        self._touched: WeakValueDictionary[tuple[int, int], Instance] = WeakValueDictionary()

    def close(self) -> None:
        """Destroys everything in the context. Calling it again does nothing."""
        if self._handle is not None:
            check(library.crumple_context_destroy(self._handle))
            self._handle = None
            self._memory.clear()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    def __del__(self) -> None:
        if getattr(self, "_handle", None) is not None:
            library.crumple_context_destroy(self._handle)

    @property
    def handle(self) -> ctypes.c_void_p:
        """The CrumpleContext pointer, for functions of crumple.h that this package does not wrap."""
        if self._handle is None:
            raise ValueError("the context is closed")
        return self._handle

    def example_set(
        self,
        positions: ArrayLike,
        triangles: ArrayLike,
        examples: Iterable[Example],
        normals: ArrayLike | None = None,
        tangents: ArrayLike | None = None,
        options: SetOptions | None = None,
        depth_limits: ArrayLike | None = None,
        stiffness: ArrayLike | None = None,
    ) -> ExampleSet:
        """Builds a set from arrays: `positions` (vertices, 3) in m, `triangles` (n, 3), unit `normals`, glTF `tangents`.

        `depth_limits` in m (see keep_out()) and `stiffness` from 0 to 1 are numbers for each vertex.
        """
        definition = library.crumple_example_set_def_default()
        mesh = library.crumple_mesh_def_default()
        alive = fill_mesh(mesh, positions, triangles, normals, tangents, depth_limits, stiffness)
        definition.mesh, count = ctypes.pointer(mesh), mesh.vertex_count
        examples = list(examples)
        array = (native.CrumpleExampleDef * len(examples))()
        for one, example in zip(array, examples, strict=True):
            alive += _fill_example(one, example, count)
        definition.examples, definition.example_count = array, len(examples)
        _fill_options(definition.options, options)
        out = native.CrumpleExampleSet()
        check(library.crumple_example_set_create(self.handle, ctypes.byref(definition), ctypes.byref(out)))
        return ExampleSet(self, out)

    def load(
        self,
        path: str | os.PathLike[str],
        mesh: str | int | None = None,
        options: SetOptions | None = None,
        *,
        nodes: str | Iterable[str] = (),
        targets: str | Iterable[str] = (),
        rigid: str | Iterable[str] = (),
        glass: str | Iterable[str] = (),
        moving: str | Iterable[str] = (),
        unit: float = 1.0,
    ) -> ExampleSet:
        """Loads a .glb, .gltf or .crumple file. `mesh` is the name or index of a glTF mesh; None is the first with examples.

        The other arguments are for glTF: patterns of names (``*``, ``?``, ``!`` to take names out), and the length of the file's unit
        in m. `nodes` joins the meshes of these nodes to one body with a part for each: ``"*"`` joins all. `targets` are the morph
        targets that are dents. Nodes or materials that are `rigid` never move, those of `glass` follow; `moving` nodes are no part.
        """
        name = os.fsdecode(path)
        out = native.CrumpleExampleSet()
        if name.endswith(".crumple"):
            if mesh is not None or options is not None or nodes or targets or rigid or glass or moving or unit != 1.0:
                raise ValueError(f"{name} is a baked set, which has one mesh and its own options; give the path alone")
            check(library.crumple_example_set_load_baked(self.handle, name.encode(), ctypes.byref(out)))
            return ExampleSet(self, out)
        definition = library.crumple_gltf_def_default()
        definition.path = name.encode()
        if isinstance(mesh, str):
            definition.mesh_name = mesh.encode()
        elif mesh is not None:
            definition.mesh_index = _natural(mesh, "mesh")
        definition.unit = unit
        chosen = {"nodes": nodes, "targets": targets, "rigid": rigid, "glass": glass, "moving": moving}
        for field, patterns in chosen.items():
            lines = [patterns] if isinstance(patterns, str) else list(patterns)
            if lines:
                setattr(definition, field, "\n".join(lines).encode())
        _fill_options(definition.options, options)
        check(library.crumple_example_set_load_gltf(self.handle, ctypes.byref(definition), ctypes.byref(out)))
        return ExampleSet(self, out)

    def load_baked(self, data: bytes | bytearray | memoryview) -> ExampleSet:
        """Loads the bytes of a .crumple file, which are copied."""
        out = native.CrumpleExampleSet()
        data = bytes(data)
        copy = native.CrumpleBytes.COPY
        check(library.crumple_example_set_load_baked_memory(self.handle, data, len(data), copy, ctypes.byref(out)))
        return ExampleSet(self, out)

    def load_obj(
        self, base: str | os.PathLike[str], examples: Iterable[str | os.PathLike[str]], options: SetOptions | None = None
    ) -> ExampleSet:
        """Builds a set from a base OBJ file and one OBJ file per example."""
        definition = library.crumple_obj_def_default()
        paths = [os.fsencode(path) for path in examples]
        definition.base_path, definition.example_count = os.fsencode(base), len(paths)
        definition.example_paths = (ctypes.c_char_p * len(paths))(*paths)
        _fill_options(definition.options, options)
        out = native.CrumpleExampleSet()
        check(library.crumple_example_set_load_obj(self.handle, ctypes.byref(definition), ctypes.byref(out)))
        return ExampleSet(self, out)

    def report_contacts(self, points: Sequence[ContactPoint]) -> None:
        """Takes contact points of the current step of the physics: all or none. Any thread."""
        definitions = (native.CrumpleContactPointDef * len(points))(*map(_contact_point, points))
        self._touched.update((_key(body.id), body) for point in points for body in point.bodies if body is not None)
        check(library.crumple_context_report_contacts(self.handle, definitions, len(points)))

    def step_contacts(self, seconds: float) -> ContactReport:
        """Makes hits of the points of a step that lasted `seconds`. Call it once after each step. Any thread."""
        report = native.CrumpleContactReport()
        check(library.crumple_context_step_contacts(self.handle, seconds, ctypes.byref(report)))
        return _contact_report(report)

    @property
    def contact_hits(self) -> list[ContactHit]:
        """The hits that the last step brought to instances. Any thread."""
        count = ctypes.c_uint32()
        call = library.crumple_context_get_contact_hits
        check(call(self.handle, None, 0, ctypes.byref(count)))
        hits = (native.CrumpleContactHit * count.value)()
        check(call(self.handle, hits, len(hits), ctypes.byref(count)))
        return [
            ContactHit(
                hit.pair, hit.contact_id, self._touched.get(_key(hit.instance)), vector3(hit.point), vector3(hit.impulse),
                _hit_result(hit.result),
            )
            for hit in hits[: count.value]
        ]  # fmt: skip

    def set_contact_options(self, **options: Any) -> None:
        """Sets the options of contacts: fields of ``CrumpleContactOptionsDef`` in crumple.h. Those not given get their defaults."""
        definition = library.crumple_contact_options_def_default()
        for name, value in options.items():
            if name == "struct_size" or not hasattr(definition, name):
                raise TypeError(f"there is no option of contacts {name!r}")
            setattr(definition, name, value)
        check(library.crumple_context_set_contact_options(self.handle, ctypes.byref(definition)))

    @property
    def contact_totals(self) -> ContactReport:
        """The sums of all steps' reports; ``open`` is that of the last step."""
        report = native.CrumpleContactReport()
        check(library.crumple_context_get_contact_totals(self.handle, ctypes.byref(report)))
        return _contact_report(report)

    def clear_contacts(self) -> None:
        """Ends all touches and forgets the points that wait, as after loading a saved game. Dents stay."""
        check(library.crumple_context_clear_contacts(self.handle))

    def deform(self, buffers: Iterable[Buffer] | None = None) -> DeformReport:
        """Writes the deformed vertices of `buffers`, or of all buffers of the context, as far as they changed."""
        report = native.CrumpleDeformReport()
        if buffers is None:
            check(library.crumple_context_deform(self.handle, None, 0, ctypes.byref(report)))
        else:
            ids = [buffer.id for buffer in buffers]
            array = (native.CrumpleBuffer * len(ids))(*ids)
            if ids:
                check(library.crumple_context_deform(self.handle, array, len(ids), ctypes.byref(report)))
        return DeformReport(
            report.vertices_written, report.blocks_written, report.blocks_skipped, report.vertices_waiting
        )


def keep_out(
    positions: ArrayLike,
    capsules: Iterable[tuple[Vector, Vector, float]] = (),
    meshes: Iterable[tuple[ArrayLike, ArrayLike]] = (),
    depth_limits: ArrayLike | None = None,
) -> NDArray[np.float32]:
    """Depth limits of a mesh, so that no dent moves a vertex into a solid: its distance from the nearest, 0 inside, m.

    A capsule is two points and a radius in m, a mesh the positions and triangles of a closed surface. Limits of your own
    are only made less.
    """
    mesh = library.crumple_mesh_def_default()
    alive = fill_mesh(mesh, positions, None, None, None, depth_limits)
    bars = [native.CrumpleCapsule(vector(a, "a"), vector(b, "b"), radius) for a, b, radius in capsules]
    solids = []
    for points, triangles in meshes:
        solids.append(library.crumple_mesh_def_default())
        alive += fill_mesh(solids[-1], points, triangles, None, None)
    limits = np.empty(mesh.vertex_count, np.float32)
    given_bars, given_solids = (native.CrumpleCapsule * len(bars))(*bars), (native.CrumpleMeshDef * len(solids))(*solids)
    data = limits.ctypes.data_as(ctypes.POINTER(ctypes.c_float))
    check(library.crumple_mesh_keep_out(ctypes.byref(mesh), given_bars, len(bars), given_solids, len(solids), data))
    del alive
    return limits


def fill_mesh(
    mesh: Any,
    positions: ArrayLike,
    triangles: ArrayLike | None,
    normals: ArrayLike | None,
    tangents: ArrayLike | None,
    depth_limits: ArrayLike | None = None,
    stiffness: ArrayLike | None = None,
) -> list[Any]:
    """Fills a CrumpleMeshDef and returns the arrays that must live during the call."""
    points = elements(positions, "positions", 3)
    mesh.vertex_count, mesh.positions = len(points), given(points)
    alive = [points]
    of_vertices = (("normals", normals, 3), ("tangents", tangents, 4), ("depth_limits", depth_limits, 1), ("stiffness", stiffness, 1))
    for name, values, components in of_vertices:
        if values is not None:
            array = elements(values, name, components)
            setattr(mesh, name, given(array))
            alive.append(array)
    if triangles is not None:
        array = np.asarray(triangles)
        if array.size and (array.dtype.kind not in "iu" or array.min() < 0 or array.max() > 0xFFFFFFFF):
            raise ValueError("triangles must be whole numbers, each the index of a vertex")
        array = np.ascontiguousarray(elements(array, "triangles", 3, np.uint32)).reshape(-1)
        mesh.index_count, mesh.indices = array.size, given(array)
        alive.append(array)
    return alive


def _fill_example(one: Any, example: Example, count: int) -> list[Any]:
    default = library.crumple_example_def_default()
    ctypes.memmove(ctypes.byref(one), ctypes.byref(default), ctypes.sizeof(default))
    name = example.name.encode()
    one.name = name
    positions = elements(example.positions, "positions of an example", 3)
    normals = None if example.normals is None else elements(example.normals, "normals of an example", 3)
    alive = [name, positions, normals]
    if example.indices is None:
        one.target_positions, one.target_normals = given(positions), given(normals)
    else:
        indices = np.ascontiguousarray(elements(example.indices, "indices of an example", 1, np.uint32))
        if len(indices) != len(positions):
            raise ValueError(f"an example has {len(indices)} indices and {len(positions)} displacements; they must be as many")
        one.delta_count, one.delta_indices = len(indices), given(indices)
        one.position_deltas, one.normal_deltas = given(positions), given(normals)
        alive.append(indices)
    if example.contact is not None:
        if isinstance(example.contact, int):
            one.contact_kind, one.contact_vertex = native.CrumpleContactKind.VERTEX, _natural(example.contact, "contact")
        else:
            one.contact_kind, one.contact_point = native.CrumpleContactKind.POINT, vector(example.contact, "contact")
    if example.normal is not None:
        one.has_contact_normal, one.contact_normal = True, vector(example.normal, "normal")
    one.impulse, one.duration = vector(example.impulse, "impulse"), example.duration
    fill_striker(one.striker, example.striker)
    return alive


def fill_striker(striker: Any, values: Any) -> None:
    from ._arrays import vector

    striker.mass, striker.radius, striker.shape = values.mass, values.radius, values.shape
    striker.velocity = vector(values.velocity, "striker.velocity")


def _fill_options(definition: Any, options: SetOptions | None) -> None:
    if options is not None:
        for name in _OPTIONS:
            setattr(definition, name, getattr(options, name))


def _contact_point(point: ContactPoint) -> native.CrumpleContactPointDef:
    definition = library.crumple_contact_point_def_default()
    definition.pair, definition.gain = point.pair, point.gain
    definition.point, definition.normal = vector(point.point, "point"), vector(point.normal, "normal")
    definition.impulse = -1.0 if point.impulse is None else point.impulse
    for name in ("velocity", "velocity_after"):
        value = getattr(point, name)
        if value is not None:
            setattr(definition, name, vector(value, name))
            setattr(definition, f"has_{name}", True)
    definition.inverse_mass = point.inverse_mass or 0.0
    for side in range(2):
        body = point.bodies[side]
        if body is not None:
            definition.bodies[side] = body.id
        definition.masses[side] = point.masses[side] or 0.0
        definition.radii[side] = point.radii[side] or 0.0
        definition.shapes[side] = point.shapes[side]
    return definition


def _key(id: native.CrumpleInstance) -> tuple[int, int]:
    return id.index, id.generation


def _contact_report(report: native.CrumpleContactReport) -> ContactReport:
    return ContactReport(**{name: getattr(report, name) for name in ContactReport.__dataclass_fields__})


def _natural(value: int, name: str) -> int:
    if not 0 <= value <= 0xFFFFFFFF:
        raise ValueError(f"{name} is {value}; it must be a whole number from 0 to 4294967295")
    return value
