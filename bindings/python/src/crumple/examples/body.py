"""The body of a glTF file: read with its welded surface, and written with its examples."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import Failure
from .gltf import File

_QUANTISED = "KHR_mesh_quantization"
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

MANY = 50
"""From so many examples on, their displacements are written as 16-bit numbers, which need KHR_mesh_quantization."""
SHORT = 32767
INVISIBLE = 3e-5
"""Steps of 16-bit displacements are at most this share of the diagonal; else they stay floats."""


@dataclass
class Made:
    """An example: displacements of the body's points, and the blow, all in metres and the world's axes."""

    name: str
    field: Floats
    """(points, 3), m."""
    point: Floats
    normal: Floats
    impulse: Floats | None = None
    """On the body, N s. None: the blow is unknown."""
    duration: float = 0.0
    mass: float = 0.0
    radius: float = 0.0
    velocity: Floats | None = None
    shape: str = ""


class Body:
    """One mesh of a glTF file. `points` are its distinct positions, in metres, in the axes of the world (y up)."""

    def __init__(self, path: Path, mesh: str | None = None, unit: float = 1.0, replace: bool = False) -> None:
        self.path, self._file = path, File(path)
        self.gltf = self._file.gltf
        self.index = _choose(self.gltf, mesh, path)
        self.mesh = self.gltf.meshes[self.index]
        self.name = self.mesh.name or path.stem
        if any(primitive.targets for primitive in self.mesh.primitives):
            if not replace:
                raise Failure(f"the mesh {self.name} has morph targets already; choose another mesh with --mesh, or add --replace")
            for primitive in self.mesh.primitives:
                primitive.targets = []
        positions, triangles, normals, held, start = [], [], [], [], 0
        material: list[int] = []
        self._parts: list[tuple[Any, slice]] = []
        for primitive in self.mesh.primitives:
            points, corners = self._file.surface(primitive, self.name, start)
            self._parts.append((primitive, slice(start, start + len(points))))
            positions.append(points)
            if corners is not None:
                triangles.append(start + corners)
                material += [-1 if primitive.material is None else primitive.material] * len(corners)
            normal = primitive.attributes.NORMAL
            normals.append(np.zeros((0, 3)) if normal is None else self._file.accessor(normal).astype(np.float32))
            held.append(self._held(primitive, len(points)))
            start += len(points)
        self.vertices = np.concatenate(positions)
        if not triangles:
            raise Failure(f"the mesh {self.name} has no triangles; only points or lines")
        self.normals = np.concatenate(normals) if all(map(len, normals)) else None
        self.marked = np.concatenate(held)
        """Vertices whose colour is red or whose attribute _HELD is above a half: those that the body is held by."""
        placed = self._file.world(self.index) * unit
        self.limits = self._numbers("_DEPTH_LIMIT")
        """How far each vertex may move, in the units of the mesh's own space; None if the file does not say."""
        self.world, self.origin = placed[:3, :3], placed[:3, 3]
        """Of the mesh's own space: the axes, m, and where its origin stands in the scene, m. `points` are relative to the origin."""
        self.scale = float(np.cbrt(abs(np.linalg.det(self.world))))
        """Metres in one unit of the mesh's own space; the mean if the node stretches it."""
        scales = np.linalg.svd(self.world, compute_uv=False)
        if scales[-1] <= 1e-9 * scales[0]:
            raise Failure(f"the node of {self.name} scales it to nothing; apply its scale and export it again")
        distinct, inverse = np.unique(self.vertices, axis=0, return_inverse=True)
        self.of_vertex: Ints = inverse.reshape(-1)
        self.points: Floats = distinct.astype(np.float64) @ self.world.T
        corners = self.of_vertex[np.concatenate(triangles)]
        whole = (corners[:, 0] != corners[:, 1]) & (corners[:, 1] != corners[:, 2]) & (corners[:, 2] != corners[:, 0])
        corners, materials = corners[whole], np.array(material)[whole]
        if np.linalg.det(self.world) < 0:
            corners = corners[:, ::-1]
        # Of triangles on the same corners, one: two-sided faces are often exported twice.
        _, first = np.unique(np.sort(corners, axis=1), axis=0, return_index=True)
        self.triangles: Ints = corners[np.sort(first)]
        self._materials = materials[np.sort(first)]
        if len(self.triangles) == 0:
            raise Failure(f"all triangles of {self.name} have no area")
        used = self.points[np.unique(self.triangles)]
        self.size = float(np.linalg.norm(used.max(0) - used.min(0)))
        """Diagonal of the bounds, m."""
        self.step = min(self.scale / SHORT, INVISIBLE * self.size)
        """Written displacements are multiples of this, or exact, m."""

    def nearest(self, point: Floats) -> int:
        """The index of the point that is nearest to a place."""
        return int(np.linalg.norm(self.points - point, axis=1).argmin())

    def place(self, point: Floats) -> str:
        """A point of `points` in the file's own space and units, for messages."""
        x, y, z = np.linalg.inv(self.world) @ point
        return f"({x:.3g}, {y:.3g}, {z:.3g})"

    def where(self, which: NDArray[np.bool_]) -> str:
        """What some of the triangles are: their materials and place, for messages."""
        used = self.points[np.unique(self.triangles[which])]
        names = [self.gltf.materials[one].name for one in np.unique(self._materials[which]) if one >= 0 and self.gltf.materials[one].name]
        return f"{which.sum()} triangles{' of ' + ', '.join(names) if names else ''} near {self.place(used.mean(0))}"

    def _numbers(self, name: str) -> NDArray[np.float32] | None:
        """A number for each vertex, if all primitives have it."""
        found = [getattr(primitive.attributes, name, None) for primitive, _ in self._parts]
        if any(one is None for one in found):
            return None
        return np.concatenate([self._file.accessor(one)[:, 0].astype(np.float32) for one in found])

    def _held(self, primitive: Any, count: int) -> NDArray[np.bool_]:
        marked = np.zeros(count, bool)
        colour, own = primitive.attributes.COLOR_0, getattr(primitive.attributes, "_HELD", None)
        if colour is not None:
            values = self._file.accessor(colour).astype(float)
            full = {5121: 255.0, 5123: 65535.0}.get(self.gltf.accessors[colour].componentType, 1.0)
            marked |= (values[:, 0] > 0.5 * full) & (values[:, 1] < 0.5 * full) & (values[:, 2] < 0.5 * full)
        if own is not None:
            marked |= self._file.accessor(own)[:, 0].astype(float) > 0.5
        return marked

    def write(self, path: Path, examples: list[Made], notes: dict[str, Any], limits: NDArray[np.float32] | None = None) -> None:
        """Writes the file with these examples as morph targets, and with depth limits; everything else of it is kept."""
        back = np.linalg.inv(self.world)
        blob = bytearray(self.gltf.binary_blob())
        turned = _point_normals(self.points, self.triangles)
        for primitive, _ in self._parts:
            primitive.targets = []
        exact = len(examples) < MANY or self.scale / SHORT > self.step
        for made in examples:
            local = (made.field @ back.T).astype(np.float32)
            turn = _rotations(turned, _point_normals(self.points + made.field, self.triangles))
            for primitive, part in self._parts:
                of = self.of_vertex[part]
                values = {"POSITION": local[of]}
                if self.normals is not None:
                    values["NORMAL"] = self._normal_change(self.normals[part], turn[of])
                primitive.targets.append(self._target(blob, values, exact))
        for primitive, part in self._parts if limits is not None else ():
            setattr(primitive.attributes, "_DEPTH_LIMIT", self._attribute(blob, limits[part]))  # noqa: B010
        self.mesh.weights = [0.0] * len(examples)
        extras = dict(self.mesh.extras or {})
        extras["targetNames"] = [made.name for made in examples]
        extras["impacts"] = [self._impact(made, back) for made in examples]
        self.mesh.extras = extras | {"crumple": notes}
        for accessor in self.gltf.accessors:
            if accessor.bufferView is None:
                # pygltflib writes 0, which the format allows only beside a buffer view.
                accessor.byteOffset = None
        self.gltf.buffers[0].byteLength = len(blob)
        self.gltf.set_binary_blob(bytes(blob))
        temporary = path.with_name(path.name + ".part")
        self.gltf.save_binary(str(temporary))
        temporary.replace(path)

    def _normal_change(self, normals: NDArray[Any], turn: Floats) -> NDArray[np.float32]:
        """Turns the render normals, which may differ at a seam, like the surface around their point."""
        cofactor = np.linalg.inv(self.world)
        world = normals @ cofactor
        back = np.einsum("nij,nj->ni", turn, world) @ self.world
        back /= np.maximum(np.linalg.norm(back, axis=1, keepdims=True), 1e-30)
        return np.where(np.abs(turn - np.eye(3)).max((1, 2))[:, None] > 0, back - normals, 0).astype(np.float32)

    def _target(self, blob: bytearray, values: dict[str, NDArray[np.float32]], exact: bool) -> dict[str, int]:
        """Appends displacements of vertices as sparse accessors, which share their indices, and returns the accessors' indices.

        They are floats if they must be exact, or if one is longer than the 16-bit numbers reach.
        """
        from pygltflib import Accessor, AccessorSparseIndices, AccessorSparseValues, Sparse

        count = len(values["POSITION"])
        moved = np.flatnonzero(np.any([one.any(1) for one in values.values()], axis=0))
        if len(moved) == 0:
            moved = np.zeros(1, np.int64)
        short = count <= 65536
        view = self._append(blob, moved.astype(np.uint16 if short else np.uint32))
        target = {}
        for name, all_values in values.items():
            quantised = not exact and (name == "NORMAL" or bool(np.abs(all_values).max() <= 1))
            if quantised:
                all_values = np.round(np.clip(all_values, -1, 1) * SHORT).astype(np.int16)
                for extensions in (self.gltf.extensionsUsed, self.gltf.extensionsRequired):
                    if _QUANTISED not in extensions:
                        extensions.append(_QUANTISED)
            sparse = Sparse(
                count=len(moved),
                indices=AccessorSparseIndices(bufferView=view, componentType=5123 if short else 5125),
                values=AccessorSparseValues(bufferView=self._append(blob, all_values[moved])),
            )
            low, high = all_values.min(0).tolist(), all_values.max(0).tolist()
            kind = 5122 if quantised else 5126
            accessor = Accessor(componentType=kind, normalized=quantised, count=count, type="VEC3", min=low, max=high, sparse=sparse)
            self.gltf.accessors.append(accessor)
            target[name] = len(self.gltf.accessors) - 1
        return target

    def _attribute(self, blob: bytearray, values: NDArray[np.float32]) -> int:
        """Appends a number for each vertex and returns the index of its accessor."""
        from pygltflib import Accessor

        view = self._append(blob, values)
        self.gltf.bufferViews[view].target = 34962
        self.gltf.accessors.append(Accessor(bufferView=view, byteOffset=0, componentType=5126, count=len(values), type="SCALAR"))
        return len(self.gltf.accessors) - 1

    def _append(self, blob: bytearray, array: NDArray[Any]) -> int:
        """Appends an array and returns the index of its buffer view."""
        from pygltflib import BufferView

        blob.extend(b"\0" * (-len(blob) % 4))
        self.gltf.bufferViews.append(BufferView(buffer=0, byteOffset=len(blob), byteLength=array.nbytes))
        blob.extend(array.tobytes())
        return len(self.gltf.bufferViews) - 1

    def _impact(self, made: Made, back: NDArray[Any]) -> dict[str, Any]:
        """The entry of extras.impacts, in the mesh's own space, as docs/impacts.md describes it."""
        normal = self.world.T @ made.normal
        entry: dict[str, Any] = {
            "name": made.name,
            "point": _numbers(back @ made.point),
            "normal": _numbers(normal / np.linalg.norm(normal)),
        }
        if made.impulse is not None and made.velocity is not None:
            striker = {"mass": made.mass, "radius": made.radius, "velocity": _numbers(back @ made.velocity), "shape": made.shape}
            entry |= {"impulse": _numbers(back @ made.impulse), "duration": made.duration, "striker": striker}
        return entry


def _numbers(values: NDArray[Any]) -> list[float]:
    return [float(f"{value:.7g}") for value in values]


def _choose(gltf: Any, name: str | None, path: Path) -> int:
    if name is not None:
        named = [i for i, mesh in enumerate(gltf.meshes) if mesh.name == name]
        if not named:
            names = ", ".join(str(mesh.name) for mesh in gltf.meshes)
            raise Failure(f"{path} has no mesh {name}; it has: {names}")
        return named[0]

    def triangles(mesh: Any) -> int:
        which = [p.attributes.POSITION if p.indices is None else p.indices for p in mesh.primitives]
        return sum(gltf.accessors[index].count for index in which if index is not None)

    counts = [triangles(mesh) for mesh in gltf.meshes]
    return int(np.argmax(counts))


def face_normals(points: Floats, triangles: Ints) -> Floats:
    """Normals of triangles, as long as twice their area."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return np.cross(b - a, c - a)


def _point_normals(points: Floats, triangles: Ints) -> Floats:
    faces = face_normals(points, triangles)
    out = np.zeros_like(points)
    for corner in range(3):
        for axis in range(3):
            out[:, axis] += np.bincount(triangles[:, corner], faces[:, axis], len(points))
    return out / np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1e-30)


point_normals = _point_normals


def _rotations(a: Floats, b: Floats) -> Floats:
    """The shortest turns from the unit vectors `a` to `b`."""
    v, c = np.cross(a, b), (a * b).sum(1)
    cross = np.zeros((len(a), 3, 3))
    cross[:, 0, 1], cross[:, 0, 2], cross[:, 1, 2] = -v[:, 2], v[:, 1], -v[:, 0]
    cross -= cross.transpose(0, 2, 1)
    turn = np.eye(3) + cross + cross @ cross / np.maximum(1 + c, 1e-6)[:, None, None]
    # Vectors that did not move, and opposite ones, which have no shortest turn.
    turn[(np.abs(v).max(1) < 1e-12) | (c < -0.999)] = np.eye(3)
    return turn
