//! Depth limits from the solids that dents must not enter.

use super::boundary::boundary;
use super::build::{CrumpleMeshDef, read_mesh};
use super::check::{array, usable};
use super::result::CrumpleResult;
use super::types::CrumpleVec3;
use crate::base::error::reserve;
use crate::base::tasks::Serial;
use crate::mesh::keep_out::Solid;

/// Everything within radius, m, of the segment between two points, m. Equal points make a ball.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleCapsule {
    pub a: CrumpleVec3,
    pub b: CrumpleVec3,
    pub radius: f32,
}

/// Computes depth limits for a mesh, so that no dent moves a vertex into a solid, such as a roll cage or an engine: the
/// distance from the nearest of the capsules and closed meshes, 0 inside one, and at most the mesh's own limits. Of solids
/// the positions and indices are read. out_limits receives vertex_count floats, m; give them to the def as depth_limits.
/// Call it for each level of detail too. Error messages number the capsules before the meshes. CRUMPLE_ERROR_MESH: a solid
/// is not closed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_mesh_keep_out(
    mesh: *const CrumpleMeshDef,
    capsules: *const CrumpleCapsule,
    capsule_count: u32,
    meshes: *const CrumpleMeshDef,
    mesh_count: u32,
    out_limits: *mut f32,
) -> CrumpleResult {
    boundary("crumple_mesh_keep_out", || {
        usable(out_limits, "out_limits")?;
        let mut mesh = read_mesh(mesh, "mesh")?;
        let capsules = array(capsules, capsule_count as usize, "capsules")?;
        let meshes: &[CrumpleMeshDef] = array(meshes, mesh_count as usize, "meshes")?;
        let mut solids = reserve(capsules.len() + meshes.len(), "solids")?;
        solids.extend(capsules.iter().map(|c| Solid::Capsule { a: c.a.array(), b: c.b.array(), radius: c.radius }));
        for (i, solid) in meshes.iter().enumerate() {
            let solid = read_mesh(solid, &format!("meshes[{i}]"))?;
            solids.push(Solid::Mesh { positions: solid.positions, triangles: solid.triangles });
        }
        mesh.keep_out(&solids, &Serial)?;
        let limits = mesh.depth_limits.unwrap_or_default();
        std::ptr::copy_nonoverlapping(limits.as_ptr(), out_limits, limits.len());
        Ok(())
    })
}
