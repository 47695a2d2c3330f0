"""Bodies as artists bring them, written as GLB files."""

import numpy as np
import trimesh
from pygltflib import (
    ARRAY_BUFFER,
    FLOAT,
    GLTF2,
    UNSIGNED_INT,
    Accessor,
    Attributes,
    Buffer,
    BufferView,
    Material,
    Mesh,
    Node,
    Primitive,
    Scene,
)


def write(path, parts, scale=None, name="body", colours=None):
    """A mesh with one primitive and material for each of `parts`, pairs of positions and triangles. Returns the path."""
    blob, gltf = bytearray(), GLTF2(scenes=[Scene(nodes=[0])], scene=0)

    def accessor(array, kind, component, target=None, **bounds):
        gltf.bufferViews.append(BufferView(buffer=0, byteOffset=len(blob), byteLength=array.nbytes, target=target))
        blob.extend(array.tobytes())
        gltf.accessors.append(
            Accessor(bufferView=len(gltf.bufferViews) - 1, componentType=component, count=len(array), type=kind, **bounds)
        )
        return len(gltf.accessors) - 1

    primitives = []
    for number, (points, triangles) in enumerate(parts):
        points = np.ascontiguousarray(points, np.float32)
        normals = trimesh.Trimesh(points, triangles, process=False).vertex_normals.astype(np.float32)
        attributes = Attributes(
            POSITION=accessor(points, "VEC3", FLOAT, ARRAY_BUFFER, min=np.nanmin(points, 0).tolist(), max=np.nanmax(points, 0).tolist()),
            NORMAL=accessor(np.ascontiguousarray(normals), "VEC3", FLOAT, ARRAY_BUFFER),
            TEXCOORD_0=accessor(np.ascontiguousarray(points[:, :2]), "VEC2", FLOAT, ARRAY_BUFFER),
        )
        if colours is not None:
            attributes.COLOR_0 = accessor(np.ascontiguousarray(colours, np.float32), "VEC4", FLOAT, ARRAY_BUFFER)
        indices = accessor(np.ascontiguousarray(triangles, np.uint32).reshape(-1), "SCALAR", UNSIGNED_INT)
        primitives.append(Primitive(attributes=attributes, indices=indices, material=number))
        gltf.materials.append(Material(name=f"paint {number}"))
    gltf.meshes = [Mesh(name=name, primitives=primitives)]
    gltf.nodes = [Node(mesh=0, scale=scale)]
    gltf.buffers = [Buffer(byteLength=len(blob))]
    gltf.set_binary_blob(bytes(blob))
    gltf.save_binary(str(path))
    return path


def panel(side=31, size=1.0):
    """A bowed sheet with open edges."""
    x, z = np.meshgrid(*2 * [np.linspace(-0.5, 0.5, side)], indexing="ij")
    points = np.stack([x, 0.3 * (0.25 - x**2) + 0.2 * (0.25 - z**2), z], -1).reshape(-1, 3) * size
    a = np.arange(side * side).reshape(side, side)[:-1, :-1].reshape(-1, 1)
    return points, np.concatenate([a + [0, side + 1, side], a + [0, 1, side + 1]])


def split_box():
    """A closed box: each face has its own vertices and material, so every edge is a seam."""
    box = trimesh.creation.box((0.6, 0.4, 0.8)).subdivide_loop(0).subdivide().subdivide().subdivide()
    facets = [np.flatnonzero(box.face_normals @ axis > 0.99) for axis in np.vstack([np.eye(3), -np.eye(3)])]
    parts = []
    for faces in facets:
        used, corners = np.unique(box.faces[faces], return_inverse=True)
        parts.append((box.vertices[used], corners.reshape(-1, 3)))
    return parts


def crossed():
    """Two sheets that share the edges of their crossing, each of which belongs to four triangles."""
    side = 21
    points, triangles = panel(side)
    flat = points * [1, 0, 1]
    upright = flat[:, [1, 0, 2]]
    both = np.vstack([flat, upright])
    _, first, inverse = np.unique(both.round(6), axis=0, return_index=True, return_inverse=True)
    return both[first], inverse.reshape(-1)[np.vstack([triangles, triangles + side * side])]
