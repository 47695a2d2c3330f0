//! Points that follow the surface: lamps, decals, collision vertices.

use super::check::{Out, finite, read};
use super::context::{CrumpleContext, exclusive};
use super::result::{CrumpleResult, Failure};
use super::types::{CrumpleExampleSet, CrumpleInstance, CrumpleVec3};
use crate::instance::attachment::Attachment;
use bytemuck::{Pod, Zeroable};

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
        out.write(CrumpleAttachment { vertices, weights, point: point.into(), reserved: [0; 3] });
        Ok(())
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
        let instance = &mut state.instances.get_mut(instance, "instance")?.instance;
        let attachment = self::attachment(given, "attachment")?;
        instance.fold();
        let pose = instance.attached_pose(&attachment)?;
        let [x, y, z, w] = pose.rotation;
        let rotation = CrumpleQuat { x, y, z, w };
        out.write(CrumplePose { position: pose.position.into(), rotation, reserved: [0; 5] });
        Ok(())
    })
}

/// Checks what the library's own attachments have.
fn attachment(given: CrumpleAttachment, name: &str) -> Result<Attachment, Failure> {
    let CrumpleAttachment { vertices, weights, point, .. } = given;
    let sum: f32 = finite(weights, &format!("{name}.weights"))?.iter().sum();
    if (sum - 1.0).abs() > 1e-3 {
        let made_by = "take attachments from crumple_example_set_attach_point()";
        return Err(Failure::invalid(format!("{name}.weights sum to {sum}; they must sum to 1: {made_by}")));
    }
    Ok(Attachment { vertices, weights, point: point.array() })
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
        outs.1.write(nearest.distance);
        Ok(())
    })
}
