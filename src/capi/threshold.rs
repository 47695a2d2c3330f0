//! Thresholds: what passed which since it was last asked.

use super::attach::{CrumpleAttachment, attachment};
use super::c_enum::c_enums;
use super::check::{Out, def, defs, enumerator, usable, write_array, zeroed};
use super::context::{CrumpleContext, exclusive};
use super::result::CrumpleResult;
use super::types::CrumpleInstance;
use crate::instance::threshold_state::{Measure, Passed};
use std::mem::MaybeUninit;

/// What a threshold is compared with; see crumple_instance_measure_part().
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(dead_code)] // made by C
pub enum CrumpleMeasure {
    Deepest = 0,
    Mean = 1,
    Energy = 2,
    /// Distance of an attached point from its place at rest.
    Displacement = 3,
}

c_enums!(CrumpleMeasure::Displacement);

/// A threshold on a mesh of the set, or on an attached point.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleThresholdDef {
    pub struct_size: u32,
    /// Your number for it. It replaces the instance's threshold of this number.
    pub number: u32,
    pub measure: MaybeUninit<CrumpleMeasure>,
    /// The mesh; a part's number from crumple_example_set_add_lod(). Default 0.
    pub lod: u32,
    /// The point of CRUMPLE_MEASURE_DISPLACEMENT, which has no lod.
    pub attachment: CrumpleAttachment,
    /// m, above 0. Infinity is never reached and costs nothing. Required.
    pub limit: f32,
}

defs!(CrumpleThresholdDef);

/// A threshold that an instance's damage passed.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CrumplePassed {
    pub instance: CrumpleInstance,
    pub number: u32,
    /// What was measured, m: the limit or more.
    pub value: f32,
}

/// Returns a def for the deepest dent of the base mesh. Set number and limit.
#[unsafe(no_mangle)]
pub extern "C" fn crumple_threshold_def_default() -> CrumpleThresholdDef {
    zeroed()
}

/// Sets a threshold. Thresholds are not saved, loaded or repaired. Those on a part, or on points of its surface, go with it
/// when it is released. Errors: CRUMPLE_ERROR_INVALID_ARGUMENT (the limit), CRUMPLE_ERROR_INDEX_OUT_OF_RANGE,
/// CRUMPLE_ERROR_WRONG_RULE (a classic rule, which has only base meshes and no energies).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_set_threshold(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    def: *const CrumpleThresholdDef,
) -> CrumpleResult {
    exclusive("crumple_instance_set_threshold", context, |_, state| {
        let def = self::def(def, "def")?;
        let kind = enumerator(def.measure, "def.measure")?;
        let CrumpleThresholdDef { number, lod, limit, attachment: at, .. } = def;
        let instance = &mut state.instances.get_mut(instance, "instance")?.instance;
        let lod = lod as usize;
        let measure = match kind {
            CrumpleMeasure::Deepest => Measure::Deepest(lod),
            CrumpleMeasure::Mean => Measure::Mean(lod),
            CrumpleMeasure::Energy => Measure::Energy(lod),
            CrumpleMeasure::Displacement => Measure::Displacement(attachment(at, "def.attachment")?),
        };
        Ok(instance.set_threshold(number, measure, limit)?)
    })
}

/// Returns the thresholds that were passed since the last call, by increasing index of the instance, then by number. The
/// same damage and calls give the same on every machine. A threshold is returned again only after a call that found its
/// measure below the limit, as after a repair. If there are more than capacity, the next calls return the rest; no more
/// wait once *out_count is below capacity. Cheap if no damage changed; otherwise it measures the meshes that have
/// thresholds.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_context_get_passed(
    context: *mut CrumpleContext,
    passed: *mut CrumplePassed,
    capacity: u32,
    out_count: *mut u32,
) -> CrumpleResult {
    exclusive("crumple_context_get_passed", context, |_, state| {
        let out = Out::new(out_count, "out_count")?;
        if capacity > 0 {
            usable(passed, "passed")?;
        }
        let mut found = Vec::new();
        for (instance, entry) in state.instances.iter_mut::<CrumpleInstance>() {
            while found.len() < capacity as usize
                && let Some(Passed { number, value }) = entry.instance.next_passed()?
            {
                found.push(CrumplePassed { instance, number, value });
            }
        }
        write_array(&found, passed, capacity as usize, "passed", out)
    })
}
