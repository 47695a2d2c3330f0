//! Damage: read, replaced, saved, repaired, copied.

use super::check::{Out, array, finite, write_array};
use super::context::{CrumpleContext, recorded};
use super::record_call::{Bytes, Call, Number};
use super::recorder::digest;
use super::result::{CrumpleResult, Failure};
use super::types::CrumpleInstance;
use crate::damage::mark::Mark;
use std::ffi::c_void;

/// Copies an instance's marks to an array of capacity marks; see "Arrays" at the top. The marks are sorted, so that the
/// order of hits does not matter. CRUMPLE_ERROR_WRONG_RULE: classic rules have no marks.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_get_marks(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    marks: *mut Mark,
    capacity: u32,
    out_count: *mut u32,
) -> CrumpleResult {
    recorded("crumple_instance_get_marks", context, |_, state, log| {
        let out = Out::new(out_count, "out_count")?;
        log.call(|| Call::GetMarks { instance: Number::of(instance) });
        let found = state.instances.get_mut(instance, "instance")?.instance.marks()?;
        write_array(found, marks, capacity as usize, "marks", out)?;
        log.gave(|| digest(bytemuck::cast_slice(found)));
        Ok(())
    })
}

/// Replaces an instance's marks with count marks of the same set. Discards pending hits and ends contacts. Errors:
/// CRUMPLE_ERROR_INVALID_ARGUMENT (a mark that the set cannot have), CRUMPLE_ERROR_WRONG_RULE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_set_marks(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    marks: *const Mark,
    count: u32,
) -> CrumpleResult {
    recorded("crumple_instance_set_marks", context, |_, state, log| {
        let marks = array(marks, count as usize, "marks")?;
        let bytes = || Bytes(bytemuck::cast_slice(marks).to_vec());
        log.call(|| Call::SetMarks { instance: Number::of(instance), marks: bytes() });
        Ok(state.instances.get_mut(instance, "instance")?.instance.set_marks(marks)?)
    })
}

/// Saves an instance's damage as bytes that are equal on all machines. They include a version and the set's
/// fingerprint. data has capacity bytes of any alignment; see "Arrays" at the top.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_save_damage(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    data: *mut c_void,
    capacity: usize,
    out_size: *mut usize,
) -> CrumpleResult {
    recorded("crumple_instance_save_damage", context, |_, state, log| {
        let out = Out::new(out_size, "out_size")?;
        log.call(|| Call::SaveDamage { instance: Number::of(instance) });
        let bytes = state.instances.get_mut(instance, "instance")?.instance.save();
        write_array(&bytes, data.cast::<u8>(), capacity, "data", out)?;
        log.gave(|| digest(&bytes));
        Ok(())
    })
}

/// Replaces an instance's damage with saved damage: size bytes at data, of any alignment. Discards pending hits and
/// ends contacts. Errors: CRUMPLE_ERROR_DAMAGE_MISMATCH (another set, version or rule, or cut short),
/// CRUMPLE_ERROR_INVALID_ARGUMENT (a mark that the set cannot have).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_load_damage(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    data: *const c_void,
    size: usize,
) -> CrumpleResult {
    recorded("crumple_instance_load_damage", context, |_, state, log| {
        let bytes = array(data.cast::<u8>(), size, "data")?;
        log.call(|| Call::LoadDamage { instance: Number::of(instance), bytes: Bytes(bytes.to_vec()) });
        Ok(state.instances.get_mut(instance, "instance")?.instance.load(bytes)?)
    })
}

/// Repairs an instance. Every dent keeps this share of its depth: 0 (as new) to 1 (unchanged). Ends contacts.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_repair_damage(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    keep: f32,
) -> CrumpleResult {
    recorded("crumple_instance_repair_damage", context, |_, state, log| {
        let [keep] = finite([keep], "keep")?;
        log.call(|| Call::RepairDamage { instance: Number::of(instance), keep });
        Ok(state.instances.get_mut(instance, "instance")?.instance.repair(keep)?)
    })
}

/// Removes all damage of an instance. Discards pending hits and ends contacts.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_reset_damage(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
) -> CrumpleResult {
    recorded("crumple_instance_reset_damage", context, |_, state, log| {
        log.call(|| Call::ResetDamage { instance: Number::of(instance) });
        state.instances.get_mut(instance, "instance")?.instance.reset();
        Ok(())
    })
}

/// Replaces an instance's damage with that of source, which needs an equal set and the same kind of rule. Discards the
/// instance's pending hits and ends its contacts. Copying an instance to itself does nothing.
/// CRUMPLE_ERROR_DAMAGE_MISMATCH: another set or rule.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_copy_damage(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    source: CrumpleInstance,
) -> CrumpleResult {
    recorded("crumple_instance_copy_damage", context, |_, state, log| -> Result<(), Failure> {
        log.call(|| Call::CopyDamage { instance: Number::of(instance), source: Number::of(source) });
        state.instances.get(instance, "instance")?;
        let bytes = state.instances.get_mut(source, "source")?.instance.save();
        if instance == source {
            return Ok(());
        }
        Ok(state.instances.get_mut(instance, "instance")?.instance.load(&bytes)?)
    })
}
