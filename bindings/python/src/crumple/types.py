"""What goes into the library and what comes out: plain data."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._native import (
    CrumpleHitStatus as HitStatus,
)
from ._native import (
    CrumpleResult as Result,
)
from ._native import (
    CrumpleRule as Rule,
)
from ._native import (
    CrumpleSelection as Selection,
)
from ._native import (
    CrumpleSpace as Space,
)
from ._native import (
    CrumpleStrikerShape as StrikerShape,
)

__all__ = [
    "Attachment", "Changes", "DeformReport", "Example", "ExampleInfo", "HitResult", "HitStatus",
    "InstanceInfo", "MARK", "Mesh", "Pose", "Primitive", "Result", "Rule", "Selection", "SetInfo", "SetOptions", "Space",
    "Striker", "StrikerShape",
]  # fmt: skip

Floats = NDArray[np.float32]

MARK = np.dtype(
    [
        ("contact", "<u4"), ("depth", "<f4"), ("hits", "<u8"), ("told", "<u2"), ("striker", "<u2"), ("direction", "<u2", 2),
        ("strength", "<u2"), ("mass", "<u2"), ("radius", "<u2"), ("reserved", "<u2"),
    ]
)  # fmt: skip
"""A mark, 32 bytes; CrumpleMark in crumple.h. Arrays of marks have this type; save or send them as they are."""


@dataclass
class Striker:
    """What struck a body, as far as it is known. 0 is unknown, which costs accuracy."""

    mass: float = 0.0
    """kg."""
    radius: float = 0.0
    """Radius of its surface at the contact, m: small for a corner, large for a flat face."""
    velocity: ArrayLike = (0.0, 0.0, 0.0)
    """Relative to the struck body before the touch, m/s."""
    shape: StrikerShape = StrikerShape.UNKNOWN
    """Its shape at the contact: BALL or anything round, POLE or an edge, CORNER, WALL or any flat face."""


@dataclass
class Example:
    """The base mesh after a collision."""

    positions: ArrayLike
    """The new position of every vertex, (vertices, 3), m; or with `indices` the displacements of these vertices."""
    indices: ArrayLike | None = None
    """The vertices that moved, strictly increasing."""
    normals: ArrayLike | None = None
    """The new unit normals, (vertices, 3); or with `indices` the changes of the normals. None: computed."""
    name: str = ""
    contact: int | ArrayLike | None = None
    """The vertex or the point (three numbers, m) that was hit. None: the deepest vertex."""
    normal: ArrayLike | None = None
    """The outward direction of the surface at the contact. None: the mesh's normal."""
    impulse: ArrayLike = (0.0, 0.0, 0.0)
    """On the body, N s. 0: unknown."""
    duration: float = 0.0
    """How long the impulse acted, s. 0: unknown."""
    striker: Striker = field(default_factory=Striker)


@dataclass
class SetOptions:
    """How an example set is built. CrumpleExampleSetOptions in crumple.h says more about each."""

    depth_limit: float = 0.0
    """No vertex moves further than this, m. 0: three times the depth of the deepest example."""
    drop_below: float = 0.0
    """Displacements of an example up to this length are dropped, m."""
    vertex_mass: float = 0.0
    """The calibration mass in impulse * duration / mass, kg. 0: unknown."""
    basis_tolerance: float = 0.0
    """How far a vertex may be from where dents would put it, m. Less takes more memory and time. 0: what fits all bodies well."""
    bake_tolerance: float = 0.0
    """Largest position error from quantisation, m. 0: exact floats."""
    bake_normal_tolerance: float = 1.0
    """Largest error of a normal, degrees. Unused if bake_tolerance is 0."""
    mirror: bool = True
    """Examples also count mirrored unless they contradict it, if the body is symmetric."""
    held_rims: bool = True
    """Dents fade to zero at boundary edges that no example moves."""
    whole_examples: bool = False
    """Keep the examples whole in baked bytes too, as the classic rules need them. On large bodies an example then takes ten times the memory."""


@dataclass(frozen=True)
class Mesh:
    """A copy of a set's mesh."""

    positions: Floats
    normals: Floats
    tangents: Floats | None
    triangles: NDArray[np.uint32]


@dataclass(frozen=True)
class SetInfo:
    """Facts about an example set; CrumpleExampleSetInfo in crumple.h."""

    name: str
    fingerprint: int
    memory_bytes: int
    vertex_count: int
    triangle_count: int
    example_count: int
    primitive_count: int
    seam_count: int
    depth_limit: float
    bounds: Floats
    """Two rows: the smallest and the largest coordinates, m."""
    node_transform: Floats
    """(4, 4), transforms columns."""
    has_tangents: bool
    lod_count: int
    blow_count: int
    """Number of examples that know their blow."""
    field_error: float
    """Median of the examples' field_error."""


@dataclass(frozen=True)
class ExampleInfo:
    """Facts about an example; CrumpleExampleInfo in crumple.h."""

    name: str
    contact_vertex: int
    moved_vertices: int
    contact_point: Floats
    contact_normal: Floats
    depth: float
    max_depth: float
    support_radius: float
    field_error: float
    """Relative L2 error when the other examples predict it: 0 is exact, 1 is no dent at all. Where it is large, one more example helps most."""


@dataclass(frozen=True)
class Primitive:
    """A part of the mesh with its own material."""

    material: str | None
    first_vertex: int
    vertex_count: int
    first_triangle: int
    triangle_count: int


@dataclass(frozen=True)
class InstanceInfo:
    memory_bytes: int
    mark_count: int
    buffer_count: int
    depth_limit: float
    contact_count: int


@dataclass(frozen=True)
class HitResult:
    """The effect of a hit. Unless its status is HitStatus.MARKED, `achieved`, `expected_error` and `mark` are zero."""

    status: HitStatus
    contact_vertex: int
    contact_distance: float
    target: Floats
    """Target displacement of the contact before it is clamped, m, in the mesh's space."""
    achieved: Floats
    expected_error: float
    """The relative L2 error that is expected of the dent; 1 is no dent at all."""
    clamped: bool
    mark: NDArray[Any]
    """One element of type MARK."""


@dataclass(frozen=True)
class ContactPoint:
    """A point at which two bodies touch in a step of the physics, in world space. ``None`` is unknown. Give the impulse, or the
    velocity and what the bodies weigh; best all of them. See ``CrumpleContactPointDef`` in crumple.h."""

    pair: int
    """The two bodies as one number, the same in every step in which they touch."""
    bodies: tuple[Any, Any]
    """The instances a and b; ``None`` for a body that does not dent."""
    point: ArrayLike
    normal: ArrayLike
    """From a to b: out of a."""
    impulse: float | None = None
    """Length of the normal impulse of the step, N s."""
    velocity: ArrayLike | None = None
    """Velocity of b relative to a at the point, before the step, m/s."""
    velocity_after: ArrayLike | None = None
    masses: tuple[float | None, float | None] = (None, None)
    """kg; ``math.inf`` for a static or kinematic body."""
    inverse_mass: float | None = None
    """How easily the two move at the point along the normal, 1/kg."""
    radii: tuple[float | None, float | None] = (None, None)
    shapes: tuple[StrikerShape, StrikerShape] = (StrikerShape.UNKNOWN, StrikerShape.UNKNOWN)
    """As those of `Striker`."""
    gain: float = 1.0


@dataclass(frozen=True)
class ContactReport:
    """What steps of contacts did. See ``CrumpleContactReport`` in crumple.h."""

    points: int
    hits: int
    begun: int
    ended: int
    open: int
    slow: int
    separating: int
    weak: int
    crowded: int
    refused: int


@dataclass(frozen=True)
class ContactHit:
    """A hit that the last step of contacts brought to an instance. See ``CrumpleContactHit`` in crumple.h."""

    pair: int
    contact_id: int
    """The touch that the hit is a part of, for ``Instance.contact``."""
    instance: Any
    """The instance that was hit; ``None`` if you no longer hold it."""
    point: Floats
    """m, in world space."""
    impulse: Floats
    """On the instance, N s, in world space."""
    result: HitResult
    """The effect of this hit alone."""


@dataclass(frozen=True)
class DeformReport:
    vertices_written: int
    blocks_written: int
    blocks_skipped: int
    vertices_waiting: int


@dataclass(frozen=True)
class Changes:
    """What the last deform wrote."""

    ranges: NDArray[np.uint32]
    """Rows of first vertex, or first triangle, and count."""
    bounds: Floats
    """Two rows, the smallest and the largest coordinates, m."""


@dataclass(frozen=True)
class Attachment:
    """A point that follows the surface. It works with every instance of its set."""

    vertices: tuple[int, int, int]
    weights: tuple[float, float, float]
    point: tuple[float, float, float]


@dataclass(frozen=True)
class Pose:
    """Where an attached point is."""

    position: Floats
    rotation: Floats
    """A unit quaternion, x y z w, relative to the undamaged mesh."""
