//! What an example set holds.

use super::check::{Out, def, defs, zeroed};
use super::context::{CrumpleContext, exclusive};
use super::memory::{Stream, disjoint};
use super::result::{CrumpleResult, Failure};
use super::types::{CrumpleAabb, CrumpleExampleSet, CrumpleStream};
use std::ffi::c_char;

/// Facts about an example set. Counts and bounds are the base mesh's. Strings are valid until the set is destroyed.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleExampleSetInfo {
    /// Name of the mesh in its file, UTF-8; empty for a set built from arrays. Never null.
    pub name: *const c_char,
    /// Equal for equal sets, on any machine. Saved damage fits only sets with the same fingerprint.
    pub fingerprint: u64,
    pub memory_bytes: u64,
    pub vertex_count: u32,
    pub triangle_count: u32,
    pub example_count: u32,
    /// Stretches of the mesh with a material of their own, at least 1; see crumple_import.h.
    pub primitive_count: u32,
    /// Number of positions that several vertices share.
    pub seam_count: u32,
    /// No vertex moves further than this, m.
    pub depth_limit: f32,
    pub bounds: CrumpleAabb,
    /// World matrix of the first glTF node that shows the mesh, column-major; the identity if there is none.
    pub node_transform: [f32; 16],
    pub has_tangents: bool,
    /// Number of meshes: 1 + added levels of detail.
    pub lod_count: u32,
    /// Number of examples whose impulse or striker is known. From 1 on, the set predicts what a blow leaves.
    pub blow_count: u32,
    /// Median of the examples' field_error.
    pub field_error: f32,
    pub reserved: [u64; 2],
}

/// Where to copy a mesh: positions (m), unit normals, tangents, 3 * triangle_count indices. Absent ones are skipped.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleMeshCopyDef {
    pub struct_size: u32,
    /// Which mesh: 0 for the base mesh, or a number from crumple_example_set_add_lod(). Default 0.
    pub lod: u32,
    pub positions: CrumpleStream,
    pub normals: CrumpleStream,
    pub tangents: CrumpleStream,
    pub indices: CrumpleStream,
}

defs!(CrumpleMeshCopyDef);

const IDENTITY: [f32; 16] = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];

fn median(mut errors: Vec<f32>) -> f32 {
    errors.sort_by(f32::total_cmp);
    errors[errors.len() / 2]
}

/// Returns facts about a set.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_example_set_get_info(
    context: *mut CrumpleContext,
    set: CrumpleExampleSet,
    out_info: *mut CrumpleExampleSetInfo,
) -> CrumpleResult {
    exclusive("crumple_example_set_get_info", context, |_, state| {
        let out = Out::new(out_info, "out_info")?;
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
            blow_count: set.examples().iter().filter(|e| e.blow().total_impulse().is_some()).count() as u32,
            field_error: median(set.example_errors()),
            reserved: [0; 2],
        });
        Ok(())
    })
}

#[unsafe(no_mangle)]
pub extern "C" fn crumple_mesh_copy_def_default() -> CrumpleMeshCopyDef {
    zeroed()
}

/// Copies the base mesh or a level of detail into your memory, for your vertex and index buffers. If the set was built
/// without normals, they are the computed ones. CRUMPLE_ERROR_MESH: the mesh lacks the requested normals or tangents.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_example_set_copy_mesh(
    context: *mut CrumpleContext,
    set: CrumpleExampleSet,
    def: *const CrumpleMeshCopyDef,
) -> CrumpleResult {
    exclusive("crumple_example_set_copy_mesh", context, |_, state| {
        let def = self::def(def, "def")?;
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
        let lacks =
            |what: &str| -> Failure { crate::base::error::Error::Mesh { what: format!("it has no {what}") }.into() };
        let normals = match normals {
            Some(stream) => Some((stream, mesh.normals().ok_or_else(|| lacks("normals"))?)),
            None => None,
        };
        let tangents = match tangents {
            Some(stream) => Some((stream, mesh.tangents().ok_or_else(|| lacks("tangents"))?)),
            None => None,
        };
        positions.inspect(|s| s.write(mesh.positions()));
        normals.inspect(|(s, values)| s.write(values));
        tangents.inspect(|(s, values)| s.write(values));
        indices.inspect(|s| s.write(mesh.triangles().as_flattened()));
        Ok(())
    })
}
