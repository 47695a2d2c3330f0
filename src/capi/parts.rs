//! Bodies of parts: taken off and put on again, rigid, measured.

use super::check::{Out, boolean};
use super::context::{CrumpleContext, exclusive};
use super::result::CrumpleResult;
use super::store::InstanceEntry;
use super::types::{CrumpleBuffer, CrumpleInstance};
use std::mem::MaybeUninit;
use std::sync::PoisonError;

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
        let mut inboxes = context.inboxes.write().unwrap_or_else(PoisonError::into_inner);
        state.instances.reserve::<CrumpleInstance>()?;
        inboxes.reserve::<CrumpleInstance>()?;
        let body = state.instances.get_mut(instance, "instance")?;
        let released = body.instance.release(part as usize)?;
        let is_of_part =
            |buffer: &CrumpleBuffer| state.buffers.get(*buffer, "buffer").is_ok_and(|entry| entry.lod == part as usize);
        let (moved, kept) = body.buffers.iter().partition(|buffer| is_of_part(buffer));
        body.buffers = kept;
        let (set, user_data) = (body.set, body.user_data);
        let inbox: CrumpleInstance = inboxes.insert(released.inbox().clone());
        let id = state.instances.insert(InstanceEntry { instance: released, set, buffers: moved, user_data });
        assert_eq!(inbox, id, "the two lists of instances went apart");
        for buffer in &state.instances.get(id, "part")?.buffers {
            state.buffers.get_mut(*buffer, "buffer")?.owner = id;
        }
        out.write(id);
        Ok(())
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
        // Hits that were selected for the body as it is have arrived, and no other arrives meanwhile.
        let _no_hits = context.inboxes.write().unwrap_or_else(PoisonError::into_inner);
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
        let rigid = boolean(rigid);
        Ok(state.instances.get_mut(instance, "instance")?.instance.set_rigid(part as usize, rigid)?)
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
        let damage = state.instances.get_mut(instance, "instance")?.instance.measure(lod as usize)?;
        outs.0.write(damage.deepest);
        outs.1.write(damage.mean);
        equivalent.write(damage.energy);
        Ok(())
    })
}
