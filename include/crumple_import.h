// Crumple: builds example sets from glTF and OBJ files.
//
// This file is generated from the library's source by `cargo xtask header`; do not edit it.

#ifndef CRUMPLE_IMPORT_H
#define CRUMPLE_IMPORT_H

#include "crumple_build.h"

/// What a part of a body does when it is hit.
typedef enum CrumplePartKind {
    /// It dents.
    CRUMPLE_PART_KIND_DENTS = 0,
    /// It never moves, such as a wheel.
    CRUMPLE_PART_KIND_RIGID = 1,
    /// It follows dents around it. See crumple_instance_set_part_rigid().
    CRUMPLE_PART_KIND_GLASS = 2,
} CrumplePartKind;

/// Which mesh of a glTF file to load, and the options of the set.
typedef struct CrumpleGltfDef {
    uint32_t struct_size;
    /// Index of the mesh in the file, used if mesh_name is null. Default UINT32_MAX: the first mesh whose morph targets move it.
    uint32_t mesh_index;
    /// Name of the mesh, UTF-8. Default null: mesh_index decides.
    const char *mesh_name;
    /// Path of the .glb or .gltf file, UTF-8. For crumple_example_set_load_gltf_memory(): the folder of other files
    /// that the glTF refers to. If it is null there, a glTF that refers to files is an error.
    const char *path;
    /// Whether to join the meshes of all nodes, but those of other scenes, to one body, each where its node places it. Default
    /// false. Each node with a mesh then is a part: lods 1 and up, in the order of the nodes; see
    /// crumple_example_set_get_part(). If there are more than 63, the smallest belong to the part of a node above them. Behind
    /// these come the panes: a primitive with a glass material is a part too, a piece of its node's, named after the material.
    /// Morph targets of the same name are one example if they lie near each other. mesh_index and mesh_name are not used.
    bool join_nodes;
    /// Length of the file's unit, m. Default 1.
    float unit;
    /// Patterns of names, UTF-8, one a line: * stands for any text, ? for any character, upper and lower case are the same,
    /// and ! at the start takes names out. The nodes to join; a name above a node's counts too. Default null: join_nodes
    /// decides.
    const char *nodes;
    /// Patterns of the morph targets that are dents. Default null: mesh.extras.dents, or else all.
    const char *targets;
    /// Patterns of nodes or materials that never move. Hits on them leave no mark.
    const char *rigid;
    /// Patterns of nodes or materials that are glass: parts that follow dents around them. Hits on them leave marks until
    /// crumple_instance_set_part_rigid() is called for the part.
    const char *glass;
    /// Patterns of nodes that move on their own, such as wheels: they are no part of a joined body.
    const char *moving;
    CrumpleExampleSetOptions options;
} CrumpleGltfDef;

/// A base OBJ file, its example files, and the options of the set.
typedef struct CrumpleObjDef {
    uint32_t struct_size;
    /// Number of example_paths, at least 1.
    uint32_t example_count;
    /// Path of the base mesh, UTF-8. Required.
    const char *base_path;
    /// Paths of the examples, UTF-8. Each has the v lines of the base mesh in the same order.
    const char *const *example_paths;
    CrumpleExampleSetOptions options;
} CrumpleObjDef;

/// A stretch of the mesh with one material. material is its name (UTF-8, valid until the set is destroyed) or null.
typedef struct CrumplePrimitive {
    const char *material;
    uint32_t first_vertex;
    uint32_t vertex_count;
    /// First triangle. Its first index is 3 * first_triangle.
    uint32_t first_triangle;
    uint32_t triangle_count;
    uint32_t reserved[2];
} CrumplePrimitive;

/// A part of a body that was loaded with join_nodes. It is a mesh of its own, and a stretch of the base mesh with the same
/// vertices and triangles in the same order.
typedef struct CrumplePart {
    /// As crumple_example_set_find_part() takes it, UTF-8, valid until the set is destroyed. Never null.
    const char *name;
    CrumplePartKind kind;
    uint32_t first_vertex;
    uint32_t vertex_count;
    /// First triangle. Its first index is 3 * first_triangle.
    uint32_t first_triangle;
    uint32_t triangle_count;
    uint32_t reserved[3];
} CrumplePart;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

CrumpleGltfDef crumple_gltf_def_default(void);
/// Builds an example set from a glTF 2.0 or GLB file: a mesh with its morph targets. Primitives are joined in their
/// order; see crumple_example_set_get_primitive(). mesh.extras has the examples' names (targetNames), contacts
/// (impacts) and placements. Coordinates are in the mesh's own space, and node transforms are not applied, unless nodes
/// are joined. What is odd in the file is logged as warnings. Errors: CRUMPLE_ERROR_IO, CRUMPLE_ERROR_FORMAT (malformed,
/// or no such mesh), CRUMPLE_ERROR_UNSUPPORTED (Draco's compression, or a build without CRUMPLE_FEATURE_GLTF),
/// CRUMPLE_ERROR_EXAMPLE_MISMATCH (no morph targets), and those of crumple_example_set_create().
CrumpleResult crumple_example_set_load_gltf(CrumpleContext *context, const CrumpleGltfDef *def,
                                            CrumpleExampleSet *out_set);

/// Like crumple_example_set_load_gltf(), but reads the file from the size bytes at data, of any alignment.
CrumpleResult crumple_example_set_load_gltf_memory(CrumpleContext *context, const void *data, size_t size,
                                                   const CrumpleGltfDef *def, CrumpleExampleSet *out_set);

CrumpleObjDef crumple_obj_def_default(void);
/// Builds an example set from a base OBJ file and one OBJ file per example. Examples are named after their files. Each
/// must have the base's v lines in the base's order. The set's vertices are the distinct corners of the base's faces, in the
/// order in which they are used, or its v lines if it has no faces. Polygons are triangulated. What is odd in the files is
/// logged as warnings. Errors: CRUMPLE_ERROR_IO, CRUMPLE_ERROR_FORMAT, CRUMPLE_ERROR_UNSUPPORTED (a build without
/// CRUMPLE_FEATURE_OBJ), and those of crumple_example_set_create().
CrumpleResult crumple_example_set_load_obj(CrumpleContext *context, const CrumpleObjDef *def,
                                           CrumpleExampleSet *out_set);

/// Returns the vertices and triangles of the primitive with an index below primitive_count.
CrumpleResult crumple_example_set_get_primitive(CrumpleContext *context, CrumpleExampleSet set, uint32_t primitive,
                                                CrumplePrimitive *out_primitive);

/// Returns the number of a part by its name, that of its node, or of the node's mesh if the node has none: a lod, 1 and up. The
/// first of that name. Only for sets that were loaded with join_nodes; baked sets keep the numbers, not the names.
/// CRUMPLE_ERROR_INVALID_ARGUMENT: no such part.
CrumpleResult crumple_example_set_find_part(CrumpleContext *context, CrumpleExampleSet set, const char *name,
                                            uint32_t *out_lod);

/// Returns the name, the kind and the sizes of a part: a lod from 1 to lod_count - 1. Only for sets that were loaded with
/// join_nodes. CRUMPLE_ERROR_INVALID_ARGUMENT: no such part.
CrumpleResult crumple_example_set_get_part(CrumpleContext *context, CrumpleExampleSet set, uint32_t part,
                                           CrumplePart *out_part);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* CRUMPLE_IMPORT_H */
