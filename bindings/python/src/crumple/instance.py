"""Instances: hits, damage, and the vertices that show it."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native as native
from ._arrays import directions, matrix, stream, vector, vector3
from ._library import check, filled, library, needed
from .types import MARK, Attachment, Changes, HitResult, HitStatus, InstanceInfo, Mesh, Pose, Space, Striker

if TYPE_CHECKING:
    from .context import Context
    from .example_set import ExampleSet


class Instance:
    """A body in the scene. ExampleSet.instance makes it."""

    def __init__(self, context: Context, of: ExampleSet, id: native.CrumpleInstance) -> None:
        self._context, self.set, self.id = context, of, id
        self._own: tuple[Mesh, Buffer] | None = None

    def destroy(self) -> None:
        """Destroys the instance and unregisters its buffers."""
        check(library.crumple_instance_destroy(self._context.handle, self.id))

    @property
    def info(self) -> InstanceInfo:
        """The state, pending hits included."""
        raw = native.CrumpleInstanceInfo()
        check(library.crumple_instance_get_info(self._context.handle, self.id, ctypes.byref(raw)))
        return InstanceInfo(raw.memory_bytes, raw.mark_count, raw.buffer_count, raw.depth_limit, raw.contact_count)

    def set_transform(self, transform: ArrayLike) -> None:
        """(4, 4), from the mesh's space to the world; for hits in world space. Any thread."""
        array = matrix(transform)
        pointer = array.ctypes.data_as(ctypes.POINTER(ctypes.c_float))
        check(library.crumple_instance_set_transform(self._context.handle, self.id, pointer))

    def set_depth_limit(self, depth_limit: float) -> None:
        """Limits how far a vertex moves, m. 0: the set's limit."""
        check(library.crumple_instance_set_depth_limit(self._context.handle, self.id, depth_limit))

    def hit(
        self,
        point: ArrayLike,
        impulse: ArrayLike = (0.0, 0.0, 0.0),
        duration: float = 0.0,
        *,
        mass: float = 0.0,
        normal: ArrayLike = (0.0, 0.0, 0.0),
        striker: Striker | None = None,
        space: Space = Space.LOCAL,
        contact_id: int = 0,
        preview: bool = False,
    ) -> HitResult:
        """Submits a blow: where, its impulse on the body (N s), how long it acted (s), and the striker, as far as known.

        `preview` leaves no mark. Any thread. CrumpleHitDef in crumple.h says more about each.
        """
        from .context import fill_striker

        definition = library.crumple_hit_def_default()
        definition.point, definition.impulse = vector(point, "point"), vector(impulse, "impulse")
        definition.normal, definition.duration, definition.mass = vector(normal, "normal"), duration, mass
        definition.space, definition.contact_id = int(space), contact_id
        if striker is not None:
            fill_striker(definition.striker, striker)
        return self._submit(definition, preview)

    def hit_displacement(
        self,
        point: ArrayLike,
        displacement: ArrayLike,
        *,
        space: Space = Space.LOCAL,
        contact_id: int = 0,
        preview: bool = False,
    ) -> HitResult:
        """Submits a hit given as the desired displacement of the contact, m."""
        definition = library.crumple_hit_def_default()
        definition.kind = native.CrumpleHitKind.DISPLACEMENT
        definition.point, definition.displacement = vector(point, "point"), vector(displacement, "displacement")
        definition.space, definition.contact_id = int(space), contact_id
        return self._submit(definition, preview)

    def _submit(self, definition: Any, preview: bool) -> HitResult:
        call = library.crumple_instance_preview_hit if preview else library.crumple_instance_submit_hit
        raw = native.CrumpleHitResult()
        check(call(self._context.handle, self.id, ctypes.byref(definition), ctypes.byref(raw)))
        return _hit_result(raw)

    def end_contact(self, contact_id: int) -> None:
        """Ends a contact: its dent stays, and later hits with this number begin a new one. Any other number is an error. Any thread."""
        check(library.crumple_instance_end_contact(self._context.handle, self.id, contact_id))

    def contact(self, contact_id: int) -> HitResult:
        """The result of a contact that is open, or among the 256 that ended last: all its hits taken as one."""
        raw = native.CrumpleHitResult()
        check(library.crumple_instance_get_contact(self._context.handle, self.id, contact_id, ctypes.byref(raw)))
        return _hit_result(raw)

    @property
    def marks(self) -> NDArray[Any]:
        """The marks, an array of type MARK. Assigning to it replaces the damage."""
        count = ctypes.c_uint32()
        get, pointer = library.crumple_instance_get_marks, ctypes.POINTER(native.CrumpleMark)
        marks = np.zeros(needed(get, self._context.handle, self.id, size=count), MARK)
        check(get(self._context.handle, self.id, marks.ctypes.data_as(pointer), len(marks), ctypes.byref(count)))
        return marks[: count.value]

    @marks.setter
    def marks(self, marks: NDArray[Any]) -> None:
        array = np.ascontiguousarray(marks)
        if array.dtype != MARK or array.ndim != 1:
            raise TypeError(f"marks are {array.dtype} of shape {array.shape}; they must be one row of crumple.MARK")
        pointer = array.ctypes.data_as(ctypes.POINTER(native.CrumpleMark))
        check(library.crumple_instance_set_marks(self._context.handle, self.id, pointer, len(array)))

    def save_damage(self) -> bytes:
        """The damage as bytes that are equal on all machines."""
        return filled(library.crumple_instance_save_damage, self._context.handle, self.id)

    def load_damage(self, data: bytes | bytearray | memoryview) -> None:
        """Replaces the damage with saved damage of an instance of an equal set."""
        data = bytes(data)
        check(library.crumple_instance_load_damage(self._context.handle, self.id, data, len(data)))

    def repair(self, keep: float = 0.0) -> None:
        """Every dent keeps this share of its depth: 0 (as new) to 1."""
        check(library.crumple_instance_repair_damage(self._context.handle, self.id, keep))

    def reset(self) -> None:
        """Removes all damage, pending hits included."""
        check(library.crumple_instance_reset_damage(self._context.handle, self.id))

    def copy_damage(self, source: Instance) -> None:
        """Replaces the damage with that of another instance of an equal set."""
        check(library.crumple_instance_copy_damage(self._context.handle, self.id, source.id))

    def attached(self, attachment: Attachment) -> Pose:
        """Where an attached point is now."""
        raw = native.CrumpleAttachment(attachment.vertices, attachment.weights, native.CrumpleVec3(*attachment.point))
        out = native.CrumplePose()
        get = library.crumple_instance_get_attached_pose
        check(get(self._context.handle, self.id, ctypes.byref(raw), ctypes.byref(out)))
        turn = out.rotation
        return Pose(vector3(out.position), np.array((turn.x, turn.y, turn.z, turn.w), np.float32))

    def buffer(
        self,
        positions: NDArray[np.float32],
        normals: NDArray[np.float32] | NDArray[np.uint16] | None = None,
        tangents: NDArray[np.float32] | NDArray[np.uint16] | None = None,
        lod: int = 0,
    ) -> Buffer:
        """Registers your arrays for the deformed vertices. Context.deform writes into them, without a copy.

        They are float32 of the shape (vertices, 3), tangents (vertices, 4), and may be columns of one interleaved array.
        Normals and tangents of uint16 with the shape (vertices, 2) are written octahedral, see
        CRUMPLE_DIRECTION_FORMAT_OCTAHEDRAL in crumple.h. The package keeps the arrays alive until the buffer is unregistered.
        """
        definition = library.crumple_host_buffer_def_default()
        definition.lod = lod
        count = len(positions) if isinstance(positions, np.ndarray) else 0
        definition.positions = stream(positions, "positions", count, 3)
        definition.normals, definition.normal_format = directions(normals, "normals", count, 3)
        definition.tangents, definition.tangent_format = directions(tangents, "tangents", count, 4)
        out = native.CrumpleBuffer()
        register = library.crumple_buffer_register_host
        check(register(self._context.handle, self.id, ctypes.byref(definition), ctypes.byref(out)))
        self._context._memory[out.index, out.generation] = (positions, normals, tangents)
        return Buffer(self._context, out)

    def deformed(self) -> Mesh:
        """The deformed mesh, pending hits included. The next call writes into the same arrays."""
        if self._own is None:
            mesh = self.set.mesh()
            self._own = mesh, self.buffer(mesh.positions, mesh.normals, mesh.tangents)
        mesh, buffer = self._own
        self._context.deform([buffer])
        return mesh


class Buffer:
    """Registered memory that receives an instance's deformed vertices. Instance.buffer makes it."""

    def __init__(self, context: Context, id: native.CrumpleBuffer) -> None:
        self._context, self.id = context, id

    def unregister(self) -> None:
        """Crumple no longer touches the arrays."""
        check(library.crumple_buffer_unregister(self._context.handle, self.id))
        self._context._memory.pop((self.id.index, self.id.generation), None)

    def invalidate(self) -> None:
        """Declares the contents lost: the next deform writes every vertex."""
        check(library.crumple_buffer_invalidate(self._context.handle, self.id))

    def changes(self) -> Changes:
        """What the last deform that included the buffer wrote, and the bounds of all vertices."""
        return self._changes(library.crumple_buffer_get_changes)

    def changed_triangles(self) -> Changes:
        """The triangles with a vertex that the last deform wrote, and the bounds of these vertices before and now."""
        return self._changes(library.crumple_buffer_get_changed_triangles)

    def _changes(self, get: Any) -> Changes:
        count, bounds = ctypes.c_uint32(), native.CrumpleAabb()
        pointer = ctypes.POINTER(native.CrumpleRange)
        result = get(self._context.handle, self.id, None, 0, ctypes.byref(count), None)
        if result != native.CrumpleResult.ERROR_BUFFER_TOO_SMALL:
            check(result)
        ranges = np.zeros((count.value, 2), np.uint32)
        data = ranges.ctypes.data_as(pointer)
        check(get(self._context.handle, self.id, data, len(ranges), ctypes.byref(count), ctypes.byref(bounds)))
        return Changes(ranges, np.stack([vector3(bounds.min), vector3(bounds.max)]))


def _hit_result(raw: native.CrumpleHitResult) -> HitResult:
    mark = np.frombuffer(bytes(raw.mark), MARK)
    return HitResult(
        HitStatus(raw.status), raw.contact_vertex, raw.contact_distance, vector3(raw.target), vector3(raw.achieved),
        raw.expected_error, raw.clamped, mark,
    )  # fmt: skip
