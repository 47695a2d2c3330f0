//! Damage: read, replaced, saved, repaired, copied.

use super::check::{Out, array, finite, write_array};
use super::context::{CrumpleContext, recorded};
use super::recording::{Bytes, Call, Number, digest};
use super::result::{CrumpleResult, Failure};
use super::types::CrumpleInstance;
use crate::{Mark, Pair};
use bytemuck::{Pod, Zeroable};
use std::ffi::c_void;

/// An example, how it is placed, and its share of a dent.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Pod, Zeroable)]
pub struct CrumplePair {
    /// Index of the example; 0xFFFF in an unused pair.
    pub example: u16,
    /// Low 12 bits: share of the dent, two's complement, 1024 being the whole. Bits 12, 13 and 14: the example is mirrored in
    /// x, y, z. Bit 15: it stays where it was made.
    pub share: u16,
}

/// One dent: where, how deep, and made of which examples. Plain data of 32 bytes, the same on every machine: send it
/// over the network as it is (little-endian) to show the same dent there.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
pub struct CrumpleMark {
    /// The vertex that was hit.
    pub contact: u32,
    /// Depth asked for at the contact, m; above 0.
    pub depth: f32,
    /// Strength squared, in units of 2^-32: 4294967296 for one hit; each hit that repeats the mark adds as much.
    pub energy: u64,
    /// One to four examples, the used ones first.
    pub pairs: [CrumplePair; 4],
}

const _: () = {
    assert!(size_of::<CrumpleMark>() == size_of::<Mark>() && size_of::<CrumplePair>() == size_of::<Pair>());
    assert!(std::mem::offset_of!(CrumpleMark, energy) == std::mem::offset_of!(Mark, energy));
    assert!(std::mem::offset_of!(CrumpleMark, depth) == std::mem::offset_of!(Mark, depth));
    assert!(std::mem::offset_of!(CrumpleMark, pairs) == std::mem::offset_of!(Mark, pairs));
};

/// Copies an instance's marks, sorted: the same hits give the same marks whatever their order. marks has room for
/// capacity of them; with null and 0 only their number is told.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED, CRUMPLE_ERROR_INVALID_ID,
/// CRUMPLE_ERROR_BUFFER_TOO_SMALL (capacity is smaller than the number of marks), CRUMPLE_ERROR_WRONG_RULE (the
/// literature's rules have no marks), CRUMPLE_ERROR_CONCURRENT_USE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_get_marks(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    marks: *mut CrumpleMark,
    capacity: u32,
    out_count: *mut u32,
) -> CrumpleResult {
    recorded("crumple_instance_get_marks", context, |_, state, log| {
        // SAFETY: the caller's.
        let out = unsafe { Out::new(out_count, "out_count") }?;
        log.call(|| Call::GetMarks { instance: Number::of(instance) });
        let found = state.instances.get_mut(instance, "instance")?.instance.marks()?;
        // SAFETY: the caller's.
        unsafe { write_array(found, marks.cast::<Mark>(), capacity as usize, "marks") }?;
        log.gave(|| digest(bytemuck::cast_slice(found)));
        out.write(found.len() as u32);
        Ok(())
    })
}

/// Replaces an instance's marks by count others, of the same set, forgets hits that wait and ends contacts. Null and
/// 0: none.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED, CRUMPLE_ERROR_INVALID_ID,
/// CRUMPLE_ERROR_INVALID_ARGUMENT (a mark that the set cannot have), CRUMPLE_ERROR_WRONG_RULE,
/// CRUMPLE_ERROR_OUT_OF_MEMORY, CRUMPLE_ERROR_CONCURRENT_USE. Nothing changes then.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_set_marks(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    marks: *const CrumpleMark,
    count: u32,
) -> CrumpleResult {
    recorded("crumple_instance_set_marks", context, |_, state, log| {
        // SAFETY: the caller's; any bytes are a mark.
        let marks = unsafe { array(marks.cast::<Mark>(), count as usize, "marks") }?;
        let bytes = || Bytes(bytemuck::cast_slice(marks).to_vec());
        log.call(|| Call::SetMarks { instance: Number::of(instance), marks: bytes() });
        Ok(state.instances.get_mut(instance, "instance")?.instance.set_marks(marks)?)
    })
}

/// Saves an instance's damage as bytes, with a version and the set's fingerprint; the same bytes for the same damage
/// on every machine. data has room for capacity bytes, of any alignment; with null and 0 only their number is told.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED, CRUMPLE_ERROR_INVALID_ID,
/// CRUMPLE_ERROR_BUFFER_TOO_SMALL, CRUMPLE_ERROR_CONCURRENT_USE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_save_damage(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    data: *mut c_void,
    capacity: usize,
    out_size: *mut usize,
) -> CrumpleResult {
    recorded("crumple_instance_save_damage", context, |_, state, log| {
        // SAFETY: the caller's.
        let out = unsafe { Out::new(out_size, "out_size") }?;
        log.call(|| Call::SaveDamage { instance: Number::of(instance) });
        let bytes = state.instances.get_mut(instance, "instance")?.instance.save();
        // SAFETY: the caller's.
        unsafe { write_array(&bytes, data.cast::<u8>(), capacity, "data") }?;
        log.gave(|| digest(&bytes));
        out.write(bytes.len());
        Ok(())
    })
}

/// Replaces an instance's damage by size saved bytes, of any alignment, forgets hits that wait and ends contacts.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_INVALID_ID,
/// CRUMPLE_ERROR_DAMAGE_MISMATCH (of another set, version or rule, or cut short), CRUMPLE_ERROR_INVALID_ARGUMENT (a
/// mark that the set cannot have), CRUMPLE_ERROR_CONCURRENT_USE. Nothing changes then.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_load_damage(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    data: *const c_void,
    size: usize,
) -> CrumpleResult {
    recorded("crumple_instance_load_damage", context, |_, state, log| {
        // SAFETY: the caller's.
        let bytes = unsafe { array(data.cast::<u8>(), size, "data") }?;
        log.call(|| Call::LoadDamage { instance: Number::of(instance), bytes: Bytes(bytes.to_vec()) });
        Ok(state.instances.get_mut(instance, "instance")?.instance.load(bytes)?)
    })
}

/// Repairs an instance: every dent keeps this share of its depth, 0 (as new) to 1 (nothing repaired). Ends contacts.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_INVALID_ID, CRUMPLE_ERROR_NOT_FINITE,
/// CRUMPLE_ERROR_INVALID_ARGUMENT, CRUMPLE_ERROR_CONCURRENT_USE.
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

/// Makes an instance as new, forgets hits that wait and ends contacts.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_INVALID_ID,
/// CRUMPLE_ERROR_CONCURRENT_USE.
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

/// Replaces the damage of instance by that of source, another instance with an equal set and the same kind of rule,
/// forgets hits that wait for instance and ends its contacts. From itself: nothing happens.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_INVALID_ID,
/// CRUMPLE_ERROR_DAMAGE_MISMATCH, CRUMPLE_ERROR_CONCURRENT_USE. Nothing changes then.
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
