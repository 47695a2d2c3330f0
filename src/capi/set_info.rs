//! What an example set holds.

use super::check::{Def, MadeBy, Out, def, finite};
use super::context::{CrumpleContext, exclusive};
use super::memory::{Stream, disjoint};
use super::result::{CrumpleResult, Failure};
use super::set::CrumplePlacement;
use super::types::{CrumpleAabb, CrumpleExampleSet, CrumpleStream, CrumpleVec3};
use crate::Placement;
use std::ffi::c_char;
use std::mem::MaybeUninit;
use std::ops::Range;

/// What an example set holds. Strings live until the set is destroyed.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleExampleSetInfo {
    /// Name of the mesh in its file, UTF-8; empty for a set made from arrays. Never null.
    pub name: *const c_char,
    /// Tells whether two sets are the same, on any machine; saved damage fits sets of one fingerprint.
    pub fingerprint: u64,
    /// Bytes of memory that the set takes.
    pub memory_bytes: u64,
    /// Vertices of the base mesh.
    pub vertex_count: u32,
    /// Triangles of the base mesh.
    pub triangle_count: u32,
    /// Examples.
    pub example_count: u32,
    /// Parts of the mesh with a material of their own; at least 1.
    pub primitive_count: u32,
    /// Positions that several vertices share.
    pub seam_count: u32,
    /// No vertex moves further than this, m.
    pub depth_limit: f32,
    /// Box around the base mesh, m.
    pub bounds: CrumpleAabb,
    /// World matrix of the first node that shows the mesh, column-major; the identity where there is none.
    pub node_transform: [f32; 16],
    /// Whether the mesh has tangents.
    pub has_tangents: bool,
    /// Meshes that show the damage: 1, the base mesh, and those of crumple_example_set_add_lod().
    pub lod_count: u32,
    /// Zero; room for later.
    pub reserved: [u64; 4],
}

/// What an example is. Strings live until the set is destroyed.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleExampleInfo {
    /// Its name, UTF-8. Never null.
    pub name: *const c_char,
    /// The vertex that was hit, or its deepest.
    pub contact_vertex: u32,
    /// Vertices that it moves. 0: the example does nothing.
    pub moved_vertices: u32,
    /// Where it was hit, m.
    pub contact_point: CrumpleVec3,
    /// The surface's outward unit normal there; zero where it is not known.
    pub contact_normal: CrumpleVec3,
    /// How far the contact vertex moves, m.
    pub depth: f32,
    /// How far its deepest vertex moves, m.
    pub max_depth: f32,
    /// Distance from the contact to the furthest vertex that moves noticeably, m.
    pub support_radius: f32,
    /// Whether it may be carried.
    pub placement: MaybeUninit<CrumplePlacement>,
    /// Zero; room for later.
    pub reserved: [u64; 2],
}

/// A part of the mesh with a material of its own.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumplePrimitive {
    /// Name of its material, UTF-8; null where it has none. Lives until the set is destroyed.
    pub material: *const c_char,
    /// First vertex.
    pub first_vertex: u32,
    /// Number of vertices.
    pub vertex_count: u32,
    /// First triangle; its first index is 3 times that.
    pub first_triangle: u32,
    /// Number of triangles.
    pub triangle_count: u32,
}

// SAFETY: the pointer is to a string that lives beside it.
unsafe impl Send for CrumplePrimitive {}

impl CrumplePrimitive {
    pub(super) fn new(vertices: Range<u32>, triangles: Range<u32>) -> Self {
        Self {
            material: std::ptr::null(),
            first_vertex: vertices.start,
            vertex_count: vertices.len() as u32,
            first_triangle: triangles.start,
            triangle_count: triangles.len() as u32,
        }
    }
}

/// Where a set's mesh is copied to. Absent streams are left out.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleMeshCopyDef {
    /// Bytes of this struct, from crumple_mesh_copy_def_default().
    pub struct_size: u32,
    /// Which mesh: 0 the base mesh, else a number from crumple_example_set_add_lod(). Default 0.
    pub lod: u32,
    /// Positions: 3 floats a vertex, m.
    pub positions: CrumpleStream,
    /// Unit normals: 3 floats a vertex.
    pub normals: CrumpleStream,
    /// Tangents: 4 floats a vertex, xyz of unit length, w +1 or -1.
    pub tangents: CrumpleStream,
    /// Triangles: 3 times triangle_count uint32_t.
    pub indices: CrumpleStream,
}

// SAFETY: `repr(C)`, starts with its size, and any bytes are a value of it.
unsafe impl Def for CrumpleMeshCopyDef {
    const DEFAULT: MadeBy<Self> = ("crumple_mesh_copy_def_default", crumple_mesh_copy_def_default);
}

/// Copies nothing; set the streams that you want. Never fails; any thread.
#[unsafe(no_mangle)]
pub extern "C" fn crumple_mesh_copy_def_default() -> CrumpleMeshCopyDef {
    CrumpleMeshCopyDef {
        struct_size: size_of::<CrumpleMeshCopyDef>() as u32,
        lod: 0,
        positions: CrumpleStream::ABSENT,
        normals: CrumpleStream::ABSENT,
        tangents: CrumpleStream::ABSENT,
        indices: CrumpleStream::ABSENT,
    }
}

const IDENTITY: [f32; 16] = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];

/// Tells what a set holds.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED, CRUMPLE_ERROR_INVALID_ID,
/// CRUMPLE_ERROR_CONCURRENT_USE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_example_set_get_info(
    context: *mut CrumpleContext,
    set: CrumpleExampleSet,
    out_info: *mut CrumpleExampleSetInfo,
) -> CrumpleResult {
    exclusive("crumple_example_set_get_info", context, |_, state| {
        // SAFETY: the caller's.
        let out = unsafe { Out::new(out_info, "out_info") }?;
        let entry = state.sets.get(set, "set")?;
        let (set, mesh) = (&*entry.set, entry.set.mesh());
        out.write(CrumpleExampleSetInfo {
            name: entry.name.as_ptr(),
            fingerprint: set.fingerprint(),
            memory_bytes: set.memory_bytes() as u64,
            vertex_count: set.vertex_count() as u32,
            triangle_count: mesh.triangles().len() as u32,
            example_count: set.examples().len() as u32,
            primitive_count: entry.primitives.len() as u32,
            seam_count: mesh.seam_count() as u32,
            depth_limit: set.depth_limit(),
            bounds: mesh.bounds().into(),
            node_transform: entry.node_transform.unwrap_or(IDENTITY),
            has_tangents: mesh.tangents().is_some(),
            lod_count: set.lod_count() as u32,
            reserved: [0; 4],
        });
        Ok(())
    })
}

/// Tells what an example is; example is below example_count.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED, CRUMPLE_ERROR_INVALID_ID,
/// CRUMPLE_ERROR_INDEX_OUT_OF_RANGE, CRUMPLE_ERROR_CONCURRENT_USE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_example_set_get_example(
    context: *mut CrumpleContext,
    set: CrumpleExampleSet,
    example: u32,
    out_info: *mut CrumpleExampleInfo,
) -> CrumpleResult {
    exclusive("crumple_example_set_get_example", context, |_, state| {
        // SAFETY: the caller's.
        let out = unsafe { Out::new(out_info, "out_info") }?;
        let entry = state.sets.get(set, "set")?;
        let name = item(&entry.names, example, "example")?.as_ptr();
        let example = &entry.set.examples()[example as usize];
        out.write(CrumpleExampleInfo {
            name,
            contact_vertex: example.contact_vertex(),
            moved_vertices: example.moved_vertices() as u32,
            contact_point: example.contact_point().into(),
            contact_normal: example.contact_normal().map(CrumpleVec3::from).unwrap_or_default(),
            depth: example.depth(),
            max_depth: example.max_depth(),
            support_radius: example.support_radius(),
            placement: MaybeUninit::new(match example.placement() {
                Placement::Automatic => CrumplePlacement::Automatic,
                Placement::Anchored => CrumplePlacement::Anchored,
                Placement::Carried => CrumplePlacement::Carried,
            }),
            reserved: [0; 2],
        });
        Ok(())
    })
}

/// Tells which vertices and triangles a part of the mesh has; primitive is below primitive_count.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED, CRUMPLE_ERROR_INVALID_ID,
/// CRUMPLE_ERROR_INDEX_OUT_OF_RANGE, CRUMPLE_ERROR_CONCURRENT_USE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_example_set_get_primitive(
    context: *mut CrumpleContext,
    set: CrumpleExampleSet,
    primitive: u32,
    out_primitive: *mut CrumplePrimitive,
) -> CrumpleResult {
    exclusive("crumple_example_set_get_primitive", context, |_, state| {
        // SAFETY: the caller's.
        let out = unsafe { Out::new(out_primitive, "out_primitive") }?;
        out.write(*item(&state.sets.get(set, "set")?.primitives, primitive, "primitive")?);
        Ok(())
    })
}

fn item<'a, T>(items: &'a [T], index: u32, name: &str) -> Result<&'a T, Failure> {
    let (index, len) = (u64::from(index), items.len() as u64);
    items.get(index as usize).ok_or_else(|| crate::Error::IndexOutOfRange { name: name.into(), index, len }.into())
}

/// Copies the base mesh, or a level of detail, into your memory: the vertex and index buffers to draw with, before the first dent. Normals
/// are computed ones where the set was made without.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED, CRUMPLE_ERROR_STRUCT_SIZE,
/// CRUMPLE_ERROR_INVALID_ID, CRUMPLE_ERROR_INVALID_ARGUMENT (a stride smaller than an element, streams that overlap),
/// CRUMPLE_ERROR_INDEX_OUT_OF_RANGE (def.lod), CRUMPLE_ERROR_BUFFER_TOO_SMALL, CRUMPLE_ERROR_MESH (normals or tangents of a
/// mesh that has none), CRUMPLE_ERROR_CONCURRENT_USE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_example_set_copy_mesh(
    context: *mut CrumpleContext,
    set: CrumpleExampleSet,
    def: *const CrumpleMeshCopyDef,
) -> CrumpleResult {
    exclusive("crumple_example_set_copy_mesh", context, |_, state| {
        // SAFETY: the caller's.
        let def = unsafe { self::def(def, "def") }?;
        let set = &state.sets.get(set, "set")?.set;
        let mesh = set.lod_mesh(def.lod as usize)?;
        let n = mesh.positions().len();
        let positions = Stream::new(def.positions, 12, n, "def.positions")?;
        let normals = Stream::new(def.normals, 12, n, "def.normals")?;
        let tangents = Stream::new(def.tangents, 16, n, "def.tangents")?;
        let indices = Stream::new(def.indices, 4, mesh.triangles().len() * 3, "def.indices")?;
        disjoint(&[
            ("def.positions", positions),
            ("def.normals", normals),
            ("def.tangents", tangents),
            ("def.indices", indices),
        ])?;
        let lacks = |what: &str| -> Failure { crate::Error::Mesh { what: format!("it has no {what}") }.into() };
        let normals = match normals {
            Some(stream) => Some((stream, mesh.normals().ok_or_else(|| lacks("normals"))?)),
            None => None,
        };
        let tangents = match tangents {
            Some(stream) => Some((stream, mesh.tangents().ok_or_else(|| lacks("tangents"))?)),
            None => None,
        };
        // SAFETY: checked above; the caller vouches for the memory, here and below.
        positions.inspect(|s| unsafe { s.write(mesh.positions()) });
        // SAFETY: see above.
        normals.inspect(|(s, values)| unsafe { s.write(values) });
        // SAFETY: see above.
        tangents.inspect(|(s, values)| unsafe { s.write(values) });
        // SAFETY: see above.
        indices.inspect(|s| unsafe { s.write(mesh.triangles().as_flattened()) });
        Ok(())
    })
}

/// Tells the vertex of the base mesh nearest to a point, m, in the mesh's space; of equally near ones the lowest.
/// Either output may be null; the distance is in m.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED, CRUMPLE_ERROR_INVALID_ID,
/// CRUMPLE_ERROR_NOT_FINITE, CRUMPLE_ERROR_CONCURRENT_USE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_example_set_find_nearest_vertex(
    context: *mut CrumpleContext,
    set: CrumpleExampleSet,
    point: CrumpleVec3,
    out_vertex: *mut u32,
    out_distance: *mut f32,
) -> CrumpleResult {
    exclusive("crumple_example_set_find_nearest_vertex", context, |_, state| {
        // SAFETY: the caller's.
        let outs = unsafe { (Out::optional(out_vertex, "out_vertex")?, Out::optional(out_distance, "out_distance")?) };
        let point = finite(point.array(), "point")?;
        let nearest = state.sets.get(set, "set")?.set.nearest_vertex(point)?;
        outs.0.write(nearest.vertex);
        outs.1.write(nearest.distance);
        Ok(())
    })
}
