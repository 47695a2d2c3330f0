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


def write(path, parts, scale=None, name="body", colours=None, translation=None, more=(), rotation=None):
    """A mesh with one primitive and material for each of `parts`, pairs of positions and triangles. `more` are the names, parts and
    translations of further nodes. Returns the path."""
    blob, gltf = bytearray(), GLTF2(scenes=[Scene(nodes=[0])], scene=0)

    def accessor(array, kind, component, target=None, **bounds):
        gltf.bufferViews.append(BufferView(buffer=0, byteOffset=len(blob), byteLength=array.nbytes, target=target))
        blob.extend(array.tobytes())
        gltf.accessors.append(
            Accessor(bufferView=len(gltf.bufferViews) - 1, componentType=component, count=len(array), type=kind, **bounds)
        )
        return len(gltf.accessors) - 1

    def mesh(name, parts, colours=None):
        gltf.meshes.append(Mesh(name=name, primitives=[primitive(number, *part, colours) for number, part in enumerate(parts)]))
        return len(gltf.meshes) - 1

    def primitive(number, points, triangles, colours):
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
        gltf.materials.append(Material(name=f"paint {number}"))
        return Primitive(attributes=attributes, indices=indices, material=len(gltf.materials) - 1)

    gltf.nodes.append(Node(name=name, mesh=mesh(name, parts, colours), scale=scale, translation=translation, rotation=rotation))
    for other, sides, where in more:
        gltf.nodes.append(Node(name=other, mesh=mesh(other, sides), translation=where))
    gltf.scenes[0].nodes = list(range(len(gltf.nodes)))
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


def grooved():
    """A bowed sheet with two narrow grooves that meet at a slant, as the gaps between a car's panels do."""
    points, triangles = panel(201)
    across = np.minimum(abs(points[:, 0] - 0.3 * points[:, 2]), abs(points[:, 2] - 0.15 * points[:, 0] - 0.1))
    points[:, 1] -= 0.008 * (across < 0.006)
    return points, triangles


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


def _grid(corner, along, across, edge):
    """A flat sheet from a corner, with edges of about `edge`."""
    corner, along, across = (np.asarray(one, float) for one in (corner, along, across))
    sides = [max(1, round(float(np.linalg.norm(one)) / edge)) for one in (along, across)]
    u, v = np.meshgrid(*(np.linspace(0, 1, side + 1) for side in sides), indexing="ij")
    points = corner + u.reshape(-1, 1) * along + v.reshape(-1, 1) * across
    a = np.arange(len(points)).reshape(u.shape)[:-1, :-1].reshape(-1, 1)
    row = sides[1] + 1
    return points, np.concatenate([a + [0, row, row + 1], a + [0, row + 1, 1]])


def can(edge=0.015):
    """A closed can that stands: 0.5 m wide and 0.7 m high, with two beads around it like an oil drum's."""
    sides = round(2 * np.pi * 0.25 / edge)
    wall = np.linspace(0, 0.7, round(0.7 / edge) + 1)
    bead = 0.012 * np.exp(-(((wall[:, None] - [0.235, 0.465]) / 0.02) ** 2)).sum(1)
    flat = 0.25 * np.arange(1, round(0.25 / edge)) / round(0.25 / edge)
    rings = [*((r, 0.0) for r in flat), *zip(0.25 + bead, wall, strict=True), *((r, 0.7) for r in flat[::-1])]
    angle = 2 * np.pi * np.arange(sides) / sides
    points = np.concatenate([[[r * np.cos(a), y, r * np.sin(a)] for a in angle] for r, y in rings] + [[[0, 0, 0], [0, 0.7, 0]]])
    low = np.arange(sides * (len(rings) - 1)).reshape(len(rings) - 1, sides)
    a, b = low.reshape(-1, 1), np.roll(low, -1, axis=1).reshape(-1, 1)
    last, bottom = low[-1] + sides, len(points) - 2
    caps = [np.stack([low[0], np.roll(low[0], -1), np.full(sides, bottom)], 1), np.stack([np.roll(last, -1), last, np.full(sides, bottom + 1)], 1)]
    return points, np.concatenate([np.hstack([a, a + sides, b]), np.hstack([b, a + sides, b + sides]), *caps])


def framed(edge=0.012):
    """A door's panel of 0.9 m by 0.6 m, bowed by 3 cm, on a frame of ribs that stand 4 cm behind it. Returns also colours: the rim is red."""
    skin, triangles = _grid((-0.45, -0.3, 0), (0.9, 0, 0), (0, 0.6, 0), edge)
    parts, corners, count = [skin], [triangles], len(skin)
    for start, along in [((-0.15, -0.3), (0, 0.6)), ((0.15, -0.3), (0, 0.6)), ((-0.45, 0.06), (0.9, 0))]:
        points, triangles = _grid((*start, -0.04), (*along, 0), (0, 0, 0.04), edge)
        parts.append(points)
        corners.append(triangles + count)
        count += len(points)
    points = np.vstack(parts)
    points[:, 2] += 0.03 * (1 - (points[:, 0] / 0.45) ** 2) * (1 - 0.5 * (points[:, 1] / 0.3) ** 2)
    _, first, inverse = np.unique(points.round(6), axis=0, return_index=True, return_inverse=True)
    points = points[first]
    rim = (np.abs(points[:, 0]) > 0.4499) | (np.abs(points[:, 1]) > 0.2999)
    colours = np.where(rim[:, None], [1.0, 0, 0, 1], [1.0, 1, 1, 1])
    return points, inverse.reshape(-1)[np.concatenate(corners)], colours
