//! What authors of examples ask for: limits that solids set, facts about examples, damage for a changed set.

use super::boundary::boundary;
use super::build::{CrumpleMeshDef, read_mesh};
use super::check::{item, usable};
use super::prelude::*;
use crate::base::error::reserve;
use crate::base::tasks::Serial;
use crate::instance::mapped::map_damage;
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

/// Facts about an example. name is UTF-8, never null, and valid until the set is destroyed.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleExampleInfo {
    pub name: *const c_char,
    /// The vertex that was hit. If the example has no contact, the deepest vertex.
    pub contact_vertex: u32,
    /// Number of vertices that the example moves. 0: it has no effect.
    pub moved_vertices: u32,
    /// Where the example was hit, m.
    pub contact_point: CrumpleVec3,
    /// Outward unit normal at the contact; zero if unknown.
    pub contact_normal: CrumpleVec3,
    /// Displacement of the contact vertex, m.
    pub depth: f32,
    /// Displacement of the deepest vertex, m.
    pub max_depth: f32,
    /// Distance from the contact to the furthest vertex that moves noticeably, m.
    pub support_radius: f32,
    /// How well the others predict its displacements from its blow, or its contact's displacement: relative L2 error, 0 exact,
    /// 1 as wrong as no dent. Where it is large, one more example helps most.
    pub field_error: f32,
    pub reserved: u64,
}

/// Returns facts about the example with an index below example_count.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_example_set_get_example(
    context: *mut CrumpleContext,
    set: CrumpleExampleSet,
    example: u32,
    out_info: *mut CrumpleExampleInfo,
) -> CrumpleResult {
    exclusive("crumple_example_set_get_example", context, |_, state| {
        let out = Out::new(out_info, "out_info")?;
        let entry = state.sets.get(set, "set")?;
        let (name, index) = (item(&entry.names, example, "example")?.as_ptr(), example as usize);
        let example = &entry.set.examples()[index];
        out.answer(CrumpleExampleInfo {
            name,
            contact_vertex: example.contact_vertex(),
            moved_vertices: example.moved_vertices() as u32,
            contact_point: example.contact_point().into(),
            contact_normal: example.contact_normal().map(CrumpleVec3::from).unwrap_or_default(),
            depth: example.depth(),
            max_depth: example.max_depth(),
            support_radius: example.support_radius(),
            field_error: entry.set.example_errors()[index],
            reserved: 0,
        })
    })
}

/// What crumple_example_set_map_damage() did with the marks.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleDamageMapping {
    /// Marks whose contact has a vertex at the same position in the new set.
    pub kept: u32,
    /// Marks that are now at another position, the nearest vertex.
    pub moved: u32,
    /// Marks left out because the nearest vertex is further than max_distance.
    pub too_far: u32,
    /// Marks left out because they tell a blow, and no example of the new set knows its own.
    pub without_blows: u32,
    /// The furthest that a mark moved, m.
    pub distance: f32,
    pub reserved: [u32; 3],
}

/// Maps damage that was saved with old_set to set, another revision of it: a changed mesh, other examples. Each mark
/// goes to the nearest vertex, at most max_distance away, m (0 to infinity). A mark that does not fit is left out. data is
/// what crumple_instance_save_damage() or crumple_context_save_damage() gave; in the latter, damage of other sets stays
/// as it is. out_mapping may be null. Errors: CRUMPLE_ERROR_DAMAGE_MISMATCH (not old_set's, or another version, a
/// classic rule, or cut short), CRUMPLE_ERROR_INVALID_ARGUMENT (a mark that old_set cannot have, or max_distance).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_example_set_map_damage(
    context: *mut CrumpleContext,
    set: CrumpleExampleSet,
    old_set: CrumpleExampleSet,
    data: *const c_void,
    size: usize,
    max_distance: f32,
    mapped: *mut c_void,
    capacity: usize,
    out_size: *mut usize,
    out_mapping: *mut CrumpleDamageMapping,
) -> CrumpleResult {
    exclusive("crumple_example_set_map_damage", context, |_, state| {
        let (out, mapping) = (Out::new(out_size, "out_size")?, Out::optional(out_mapping, "out_mapping")?);
        let bytes = array(data.cast::<u8>(), size, "data")?;
        let (to, from) = (&state.sets.get(set, "set")?.set, &state.sets.get(old_set, "old_set")?.set);
        let (new, done) = map_damage(from, to, bytes, max_distance)?;
        write_array(&new, mapped.cast::<u8>(), capacity, "mapped", out)?;
        mapping.answer(CrumpleDamageMapping {
            kept: done.kept as u32,
            moved: done.moved as u32,
            too_far: done.too_far as u32,
            without_blows: done.without_blows as u32,
            distance: done.distance,
            reserved: [0; 3],
        })
    })
}
