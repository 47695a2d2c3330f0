"""Example sets: a base mesh with its examples."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from . import _native as native
from ._arrays import matrix, stream, vector, vector3
from ._library import check, filled, library
from .types import Attachment, ExampleInfo, Mesh, Primitive, Rule, Selection, SetInfo

if TYPE_CHECKING:
    from .context import Context
    from .instance import Instance


class ExampleSet:
    """A base mesh with its examples: immutable, shared by any number of instances. A Context makes it."""

    def __init__(self, context: Context, id: native.CrumpleExampleSet) -> None:
        self._context, self.id = context, id

    def destroy(self) -> None:
        """Destroys the set. Its instances keep its memory and still work."""
        check(library.crumple_example_set_destroy(self._context.handle, self.id))

    @property
    def info(self) -> SetInfo:
        raw = native.CrumpleExampleSetInfo()
        check(library.crumple_example_set_get_info(self._context.handle, self.id, ctypes.byref(raw)))
        return SetInfo(
            raw.name.decode(), raw.fingerprint, raw.memory_bytes, raw.vertex_count, raw.triangle_count, raw.example_count,
            raw.primitive_count, raw.seam_count, raw.depth_limit, np.stack([vector3(raw.bounds.min), vector3(raw.bounds.max)]),
            np.array(raw.node_transform, np.float32).reshape(4, 4).T, raw.has_tangents, raw.lod_count, raw.blow_count,
            raw.field_error,
        )  # fmt: skip

    @property
    def examples(self) -> list[ExampleInfo]:
        found = []
        for index in range(self.info.example_count):
            raw = native.CrumpleExampleInfo()
            check(library.crumple_example_set_get_example(self._context.handle, self.id, index, ctypes.byref(raw)))
            found.append(
                ExampleInfo(
                    raw.name.decode(), raw.contact_vertex, raw.moved_vertices, vector3(raw.contact_point),
                    vector3(raw.contact_normal), raw.depth, raw.max_depth, raw.support_radius, raw.field_error,
                )
            )  # fmt: skip
        return found

    @property
    def primitives(self) -> list[Primitive]:
        found = []
        for index in range(self.info.primitive_count):
            raw = native.CrumplePrimitive()
            check(library.crumple_example_set_get_primitive(self._context.handle, self.id, index, ctypes.byref(raw)))
            material = raw.material.decode() if raw.material is not None else None
            found.append(Primitive(material, raw.first_vertex, raw.vertex_count, raw.first_triangle, raw.triangle_count))
        return found

    def mesh(self) -> Mesh:
        """A copy of the base mesh."""
        info = self.info
        positions, normals = (np.empty((info.vertex_count, 3), np.float32) for _ in range(2))
        tangents = np.empty((info.vertex_count, 4), np.float32) if info.has_tangents else None
        indices = np.empty(3 * info.triangle_count, np.uint32)
        definition = library.crumple_mesh_copy_def_default()
        definition.positions = stream(positions, "positions", info.vertex_count, 3)
        definition.normals = stream(normals, "normals", info.vertex_count, 3)
        definition.tangents = stream(tangents, "tangents", info.vertex_count, 4)
        if indices.size:
            definition.indices = native.CrumpleStream(indices.ctypes.data, indices.nbytes, 0, 4)
        check(library.crumple_example_set_copy_mesh(self._context.handle, self.id, ctypes.byref(definition)))
        return Mesh(positions, normals, tangents, indices.reshape(-1, 3))

    def add_lod(
        self, positions: ArrayLike, triangles: ArrayLike, normals: ArrayLike | None = None, tangents: ArrayLike | None = None
    ) -> int:
        """Adds a mesh that shows the same damage and returns its number. Call it before the first instance is made."""
        from .context import fill_mesh

        mesh = library.crumple_mesh_def_default()
        alive = fill_mesh(mesh, positions, triangles, normals, tangents)
        lod = ctypes.c_uint32()
        check(library.crumple_example_set_add_lod(self._context.handle, self.id, ctypes.byref(mesh), ctypes.byref(lod)))
        del alive
        return lod.value

    def bake(self) -> bytes:
        """The set as the bytes of a .crumple file."""
        return filled(library.crumple_example_set_save_baked, self._context.handle, self.id)

    def map_damage(
        self, data: bytes | bytearray | memoryview, old_set: ExampleSet, max_distance: float = float("inf")
    ) -> tuple[bytes, native.CrumpleDamageMapping]:
        """Maps damage that was saved with another revision of this set, and says what became of the marks.

        A mark goes to the nearest vertex, at most max_distance away, m.
        """
        data, done = bytes(data), native.CrumpleDamageMapping()
        size, call = ctypes.c_size_t(), library.crumple_example_set_map_damage
        # A mapped mark takes as many bytes as before.
        out = ctypes.create_string_buffer(max(len(data), 1))
        ids = (self._context.handle, self.id, old_set.id)
        check(call(*ids, data, len(data), max_distance, out, len(data), ctypes.byref(size), ctypes.byref(done)))
        return out.raw[: size.value], done

    def nearest_vertex(self, point: ArrayLike) -> tuple[int, float]:
        """The vertex of the base mesh nearest to a point, and its distance, m."""
        vertex, distance = ctypes.c_uint32(), ctypes.c_float()
        find = library.crumple_example_set_find_nearest_vertex
        place = vector(point, "point")
        check(find(self._context.handle, self.id, place, ctypes.byref(vertex), ctypes.byref(distance)))
        return vertex.value, distance.value

    def attach(self, point: ArrayLike) -> Attachment:
        """Binds a point to the nearest surface; Instance.attached says where it is."""
        raw = native.CrumpleAttachment()
        bind = library.crumple_example_set_attach_point
        check(bind(self._context.handle, self.id, vector(point, "point"), ctypes.byref(raw)))
        return Attachment(tuple(raw.vertices), tuple(raw.weights), (raw.point.x, raw.point.y, raw.point.z))

    def instance(
        self,
        *,
        transform: ArrayLike | None = None,
        mark_capacity: int = 64,
        depth_limit: float = 0.0,
        yield_impulse: float = 0.0,
        yield_displacement: float = 0.0,
        max_contact_distance: float = 0.0,
        rule: Rule = Rule.MARKS,
        selection: Selection = Selection.CLASSIC,
        blend_constant: float = 0.0,
    ) -> Instance:
        """A body in the scene. CrumpleInstanceDef in crumple.h says more about each option."""
        from .instance import Instance

        definition = library.crumple_instance_def_default()
        definition.set, definition.rule, definition.selection = self.id, int(rule), int(selection)
        definition.mark_capacity, definition.depth_limit = mark_capacity, depth_limit
        definition.yield_impulse, definition.yield_displacement = yield_impulse, yield_displacement
        definition.max_contact_distance, definition.blend_constant = max_contact_distance, blend_constant
        if transform is not None:
            definition.local_to_world[:] = matrix(transform).tolist()
        out = native.CrumpleInstance()
        check(library.crumple_instance_create(self._context.handle, ctypes.byref(definition), ctypes.byref(out)))
        return Instance(self._context, self, out)
