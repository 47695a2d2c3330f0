//! Attached points: lamps, decals, collision vertices that follow the dents.

use super::check::{Out, finite, read};
use super::context::{CrumpleContext, exclusive, recorded};
use super::recording::{Call, Number, digest};
use super::result::CrumpleResult;
use super::types::{CrumpleExampleSet, CrumpleInstance, CrumpleQuat, CrumpleVec3};
use crate::Attachment;
use bytemuck::{Pod, Zeroable};

/// A point bound to the surface nearest to it. Plain data: keep it, copy it, save it; it fits every instance of its
/// set.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
pub struct CrumpleAttachment {
    /// The triangle's vertices; all the same for a mesh without triangles.
    pub vertices: [u32; 3],
    /// Barycentric weights of the surface point; they sum to 1.
    pub weights: [f32; 3],
    /// The attached point at rest, m, in the mesh's space.
    pub point: CrumpleVec3,
}

/// Where an attached point is.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
pub struct CrumpleFrame {
    /// Position, m, in the mesh's space.
    pub position: CrumpleVec3,
    /// Rotation since rest.
    pub rotation: CrumpleQuat,
}

/// Binds a point, m, in the mesh's space, to the surface nearest to it: it will keep its distance from the surface
/// and turn with it.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED, CRUMPLE_ERROR_INVALID_ID,
/// CRUMPLE_ERROR_NOT_FINITE, CRUMPLE_ERROR_INVALID_ARGUMENT (further off than 1e9 m), CRUMPLE_ERROR_CONCURRENT_USE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_example_set_attach_point(
    context: *mut CrumpleContext,
    set: CrumpleExampleSet,
    point: CrumpleVec3,
    out_attachment: *mut CrumpleAttachment,
) -> CrumpleResult {
    exclusive("crumple_example_set_attach_point", context, |_, state| {
        // SAFETY: the caller's.
        let out = unsafe { Out::new(out_attachment, "out_attachment") }?;
        let point = finite(point.array(), "point")?;
        out.write(bytemuck::cast(state.sets.get(set, "set")?.set.attach(point)?));
        Ok(())
    })
}

/// Tells where an attached point is on a dented instance, hits that wait among them. Touches no buffer and reads
/// none.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED, CRUMPLE_ERROR_INVALID_ID,
/// CRUMPLE_ERROR_INDEX_OUT_OF_RANGE and CRUMPLE_ERROR_NOT_FINITE (an attachment of another set, or none),
/// CRUMPLE_ERROR_CONCURRENT_USE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_get_attached_frame(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    attachment: *const CrumpleAttachment,
    out_frame: *mut CrumpleFrame,
) -> CrumpleResult {
    recorded("crumple_instance_get_attached_frame", context, |_, state, log| {
        // SAFETY: the caller's.
        let (attachment, out) = unsafe { (read(attachment, "attachment")?, Out::new(out_frame, "out_frame")?) };
        log.call(|| Call::AttachedFrame { instance: Number::of(instance), attachment: bytemuck::cast(attachment) });
        let attachment: Attachment = bytemuck::cast(attachment);
        let instance = &mut state.instances.get_mut(instance, "instance")?.instance;
        instance.fold();
        let frame: CrumpleFrame = bytemuck::cast(instance.attached_frame(&attachment)?);
        log.gave(|| digest(bytemuck::bytes_of(&frame)));
        out.write(frame);
        Ok(())
    })
}
