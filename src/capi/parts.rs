//! Bodies of parts: taken off and put on again, rigid, measured. Points that follow the surface: lamps, decals, collision vertices.
//! Buffers that colliders use.

use super::check::read;
use super::context::{add_instance, reserve_instance};
use super::deform::c_ranges;
use super::prelude::*;
use super::store::{InstanceEntry, Memory};
use super::types::{CrumpleAabb, CrumpleRange};
use crate::instance::attach::Attachment;
use bytemuck::{Pod, Zeroable};

/// Takes a part off a body. part is the number of a mesh of the set (crumple_example_set_add_lod()) whose vertices lie at
/// positions of base vertices; the base mesh is the whole body. out_part receives a new instance with the same options,
/// transform and damage. The body's buffers of that mesh become the new instance's. Hits on the new instance reach only
/// the part, and hits on the body only what is left of it. The call indexes the base mesh. Errors:
/// CRUMPLE_ERROR_INVALID_ARGUMENT (0, a part that is off already, the last part, a mesh without base vertices of its own),
/// CRUMPLE_ERROR_WRONG_RULE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_release_part(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    part: u32,
    out_part: *mut CrumpleInstance,
) -> CrumpleResult {
    exclusive("crumple_instance_release_part", context, |context, state| {
        let out = Out::new(out_part, "out_part")?;
        let mut inboxes = context.no_hits();
        reserve_instance(state, &mut inboxes)?;
        let body = state.instances.get_mut(instance, "instance")?;
        let released = body.instance.release(part as usize)?;
        let is_of_part =
            |buffer: &CrumpleBuffer| state.buffers.get(*buffer, "buffer").is_ok_and(|entry| entry.lod == part as usize);
        let (moved, kept) = body.buffers.iter().partition(|buffer| is_of_part(buffer));
        body.buffers = kept;
        let entry = InstanceEntry { instance: released, buffers: moved, ..*body };
        let id = add_instance(state, &mut inboxes, entry);
        for buffer in &state.instances.get(id, "part")?.buffers {
            state.buffers.get_mut(*buffer, "buffer")?.owner = id;
        }
        out.answer(id)
    })
}

/// Puts a released part on its body again, or with false takes it off. It keeps its damage, instance and buffers. Hits on
/// the body, and the ends of their contacts, also reach the parts that are on it; other changes of damage do not. The call
/// indexes the base mesh. CRUMPLE_ERROR_INVALID_ARGUMENT: not a part of this body, or one that is on, or off, already.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_mount_part(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    part: CrumpleInstance,
    mounted: MaybeUninit<bool>,
) -> CrumpleResult {
    exclusive("crumple_instance_mount_part", context, |context, state| {
        let mounted = boolean(mounted);
        let _no_hits = context.no_hits();
        let (body, part) = state.instances.get_two_mut((instance, "instance"), (part, "part"))?;
        let (body, part) = (&mut body.instance, &mut part.instance);
        Ok(if mounted { body.mount(part) } else { body.unmount(part) }?)
    })
}

/// Makes a part rigid, such as glass, or no longer. Hits on it leave no mark; their status is CRUMPLE_HIT_STATUS_RIGID. To
/// keep its vertices in place too, register no buffer for it. Errors as for crumple_instance_release_part().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_set_part_rigid(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    part: u32,
    rigid: MaybeUninit<bool>,
) -> CrumpleResult {
    exclusive("crumple_instance_set_part_rigid", context, |_, state| {
        Ok(state.body(instance)?.set_rigid(part as usize, boolean(rigid))?)
    })
}

/// Measures how far the vertices of mesh lod have moved, m: the furthest, and their mean. out_equivalent_depth receives the
/// depth of the single hit that does as much damage as all marks whose contact is on the mesh, m; it grows with every hit.
/// Growing dents count in full, so the results are equal on all machines. The call computes every vertex of the mesh. Any
/// output may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_measure_part(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    lod: u32,
    out_deepest: *mut f32,
    out_mean: *mut f32,
    out_equivalent_depth: *mut f32,
) -> CrumpleResult {
    exclusive("crumple_instance_measure_part", context, |_, state| {
        let outs = (Out::optional(out_deepest, "out_deepest")?, Out::optional(out_mean, "out_mean")?);
        let equivalent = Out::optional(out_equivalent_depth, "out_equivalent_depth")?;
        let damage = state.body(instance)?.measure(lod as usize)?;
        outs.0.write(damage.deepest);
        outs.1.write(damage.mean);
        equivalent.answer(damage.energy)
    })
}

/// A rotation as a unit quaternion.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
pub struct CrumpleQuat {
    pub x: f32,
    pub y: f32,
    pub z: f32,
    pub w: f32,
}

/// A point bound to the nearest surface. Plain data: you may copy or save it. It works with every instance of its set.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
pub struct CrumpleAttachment {
    /// Vertices of the triangle. All three are equal if the mesh has no triangles.
    pub vertices: [u32; 3],
    /// Barycentric weights of the surface point; they sum to 1.
    pub weights: [f32; 3],
    /// The attached point on the undamaged mesh, m, in the mesh's space.
    pub point: CrumpleVec3,
    pub reserved: [u32; 3],
}

/// The position of an attached point, and its rotation relative to the undamaged mesh.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
pub struct CrumplePose {
    /// Position, m, in the mesh's space.
    pub position: CrumpleVec3,
    pub rotation: CrumpleQuat,
    pub reserved: [u32; 5],
}

/// Binds a point in the mesh's space, m, to the nearest surface. The point keeps its distance from the surface and
/// rotates with it. CRUMPLE_ERROR_INVALID_ARGUMENT: the point is further away than 1e9 m.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_example_set_attach_point(
    context: *mut CrumpleContext,
    set: CrumpleExampleSet,
    point: CrumpleVec3,
    out_attachment: *mut CrumpleAttachment,
) -> CrumpleResult {
    exclusive("crumple_example_set_attach_point", context, |_, state| {
        let out = Out::new(out_attachment, "out_attachment")?;
        let point = finite(point.array(), "point")?;
        let Attachment { vertices, weights, point } = state.sets.get(set, "set")?.set.attach(point)?;
        out.answer(CrumpleAttachment { vertices, weights, point: point.into(), reserved: [0; 3] })
    })
}

/// Returns the pose of an attached point on the dented instance, pending hits included. It needs no buffer. Errors:
/// CRUMPLE_ERROR_INDEX_OUT_OF_RANGE or CRUMPLE_ERROR_INVALID_ARGUMENT (an attachment of another set, or one not from
/// crumple_example_set_attach_point()).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_get_attached_pose(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    attachment: *const CrumpleAttachment,
    out_pose: *mut CrumplePose,
) -> CrumpleResult {
    exclusive("crumple_instance_get_attached_pose", context, |_, state| {
        let (given, out) = (read(attachment, "attachment")?, Out::new(out_pose, "out_pose")?);
        let instance = state.body(instance)?;
        let CrumpleAttachment { vertices, weights, point, .. } = given;
        let sum: f32 = finite(weights, "attachment.weights")?.iter().sum();
        if (sum - 1.0).abs() > 1e-3 {
            let made_by = "take attachments from crumple_example_set_attach_point()";
            return Err(Failure::invalid(format!("attachment.weights sum to {sum}; they must sum to 1: {made_by}")));
        }
        instance.fold();
        let pose = instance.attached_pose(&Attachment { vertices, weights, point: point.array() })?;
        let [x, y, z, w] = pose.rotation;
        let rotation = CrumpleQuat { x, y, z, w };
        out.answer(CrumplePose { position: pose.position.into(), rotation, reserved: [0; 5] })
    })
}

/// Finds the vertex of the base mesh nearest to a point in the mesh's space, m. The lowest index wins a tie. Either
/// output may be null. out_distance is in m.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_example_set_find_nearest_vertex(
    context: *mut CrumpleContext,
    set: CrumpleExampleSet,
    point: CrumpleVec3,
    out_vertex: *mut u32,
    out_distance: *mut f32,
) -> CrumpleResult {
    exclusive("crumple_example_set_find_nearest_vertex", context, |_, state| {
        let outs = (Out::optional(out_vertex, "out_vertex")?, Out::optional(out_distance, "out_distance")?);
        let point = finite(point.array(), "point")?;
        let nearest = state.sets.get(set, "set")?.set.nearest_vertex(point)?;
        outs.0.write(nearest.vertex);
        outs.1.answer(nearest.distance)
    })
}

/// Returns the triangles with a vertex that crumple_buffer_get_changes() returns, as increasing ranges that do not
/// overlap, in the order of the mesh's indices. out_bounds, which may be null, receives a box around those vertices
/// before and now, m, for the partial refit of a collider; zeros without changes.
/// Errors: CRUMPLE_ERROR_INVALID_ARGUMENT (not a host buffer), CRUMPLE_ERROR_MESH (a mesh without indices).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_buffer_get_changed_triangles(
    context: *mut CrumpleContext,
    buffer: CrumpleBuffer,
    ranges: *mut CrumpleRange,
    capacity: u32,
    out_count: *mut u32,
    out_bounds: *mut CrumpleAabb,
) -> CrumpleResult {
    exclusive("crumple_buffer_get_changed_triangles", context, |_, state| {
        let outs = (Out::new(out_count, "out_count")?, Out::optional(out_bounds, "out_bounds")?);
        let entry = state.buffers.get(buffer, "buffer")?;
        let Memory::Host(_, tracker) = &entry.memory else {
            let what = "buffer is not a host buffer; register one of the collider's level of detail";
            return Err(Failure::invalid(what));
        };
        let set = state.instances.get(entry.owner, "instance")?.instance.example_set();
        let triangles = set.lod_mesh(entry.lod)?.triangles();
        if triangles.is_empty() {
            let message = format!("the mesh of level of detail {} has no triangles; give it indices", entry.lod);
            return Err(Failure::new(CrumpleResult::CrumpleErrorMesh, message));
        }
        let found = c_ranges(&tracker.changed_triangles(triangles))?;
        write_array(&found, ranges, capacity as usize, "ranges", outs.0)?;
        outs.1.answer(tracker.changed_bounds().map_or_else(CrumpleAabb::default, CrumpleAabb::from))
    })
}
