"""Reads glTF 2.0 files."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import Failure

_TYPES = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_COMPONENTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
_TRIANGLES, _FLOAT = 4, 5126
_COMPRESSED = ("KHR_draco_mesh_compression", "EXT_meshopt_compression")


class File:
    """A file with its data, all in one buffer."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.gltf = _read(path)

    def accessor(self, index: int) -> NDArray[Any]:
        """The elements of an accessor, one a row."""
        accessor = self.gltf.accessors[index]
        kind, components = np.dtype(_TYPES[accessor.componentType]), _COMPONENTS[accessor.type]
        rows = np.zeros((accessor.count, components), kind)
        if accessor.bufferView is not None:
            rows = self._view(accessor.bufferView, accessor.byteOffset or 0, kind, components, accessor.count).copy()
        if accessor.sparse is not None:
            sparse = accessor.sparse
            where = np.dtype(_TYPES[sparse.indices.componentType])
            at = self._view(sparse.indices.bufferView, sparse.indices.byteOffset or 0, where, 1, sparse.count)[:, 0]
            rows[at] = self._view(sparse.values.bufferView, sparse.values.byteOffset or 0, kind, components, sparse.count)
        return rows

    def _view(self, index: int, offset: int, kind: np.dtype, components: int, count: int) -> NDArray[Any]:
        view = self.gltf.bufferViews[index]
        blob = self.gltf.binary_blob()
        start, packed = (view.byteOffset or 0) + offset, kind.itemsize * components
        step = view.byteStride or packed
        if count and start + (count - 1) * step + packed > len(blob):
            raise Failure(f"{self.path}: an accessor reaches beyond its buffer; export the file again")
        return np.ndarray((count, components), kind, blob, start, (step, kind.itemsize)) if count else np.zeros((0, components), kind)

    def surface(self, primitive: Any, name: str, first: int = 0) -> tuple[NDArray[np.float32], NDArray[np.int64] | None]:
        """The positions and triangles of a primitive; None for points and lines. `name` and `first` are for messages."""
        position = primitive.attributes.POSITION
        if self.gltf.accessors[position].componentType != _FLOAT:
            raise Failure(f"{self.path}: the vertices of {name} are quantised; export it without quantisation")
        points = self.accessor(position).astype(np.float32)
        if not np.isfinite(points).all():
            raise Failure(f"vertex {first + int(np.argwhere(~np.isfinite(points))[0, 0])} of {name} is not finite; export it again")
        if primitive.mode not in (None, _TRIANGLES):
            return points, None
        indices = primitive.indices
        corners = np.arange(len(points)) if indices is None else self.accessor(indices)[:, 0].astype(np.int64)
        if corners.size and corners.max() >= len(points):
            raise Failure(f"a triangle of {name} uses vertex {corners.max()} of {len(points)}; export it again")
        return points, corners[: len(corners) // 3 * 3].reshape(-1, 3)

    def nodes(self, mesh: int) -> list[int]:
        """The nodes that show a mesh."""
        return [index for index, node in enumerate(self.gltf.nodes or []) if node.mesh == mesh]

    def world(self, mesh: int) -> NDArray[np.float64]:
        """The matrix of the first node that shows the mesh."""
        shown = self.nodes(mesh)
        return self.placed(shown[0]) if shown else np.eye(4)

    def placed(self, node: int) -> NDArray[np.float64]:
        """The matrix of a node, from its space to the scene's."""
        nodes = self.gltf.nodes
        parent = {child: index for index, one in enumerate(nodes) for child in one.children or []}
        matrix, seen = _local(nodes[node]), {node}
        while node in parent and parent[node] not in seen:
            node = parent[node]
            seen.add(node)
            matrix = _local(nodes[node]) @ matrix
        return matrix


def _local(node: Any) -> NDArray[np.float64]:
    if node.matrix is not None:
        return np.array(node.matrix, float).reshape(4, 4).T
    out = np.eye(4)
    x, y, z, w = node.rotation or (0, 0, 0, 1)
    out[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    out[:3, :3] *= np.array(node.scale or (1, 1, 1), float)
    out[:3, 3] = node.translation or (0, 0, 0)
    return out


def _read(path: Path) -> Any:
    from pygltflib import GLTF2, BufferFormat, ImageFormat

    if not path.is_file():
        raise Failure(f"there is no file {path}")
    if path.suffix.lower() not in (".glb", ".gltf"):
        raise Failure(f"{path} is no .glb or .gltf file; export the mesh as glTF 2.0")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            gltf = GLTF2().load(str(path))
            if gltf is None:
                raise ValueError("it is no glTF 2.0")
            compressed = [name for name in gltf.extensionsRequired or [] if name in _COMPRESSED]
            if compressed:
                raise Failure(f"{path} needs {compressed[0]}; export it without compression")
            if path.suffix.lower() == ".gltf":
                gltf.convert_images(ImageFormat.DATAURI)
            gltf.convert_buffers(BufferFormat.BINARYBLOB)
    except Failure:
        raise
    except Exception as error:
        raise Failure(f"{path} cannot be read as glTF 2.0: {error}") from error
    if not gltf.meshes or gltf.binary_blob() is None:
        raise Failure(f"{path} has no mesh")
    return gltf
