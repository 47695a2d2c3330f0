//! Damage: read, replaced, saved, repaired, copied.

use super::prelude::*;
use crate::base::error::reserve;
use crate::base::tasks::map;
use crate::damage::mark::Mark;
use crate::instance::archive::{of, pack, unpack};
use std::collections::BTreeMap;

/// Copies an instance's marks, sorted, so that the order of hits does not matter. CRUMPLE_ERROR_WRONG_RULE: classic
/// rules have no marks.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_get_marks(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    marks: *mut Mark,
    capacity: u32,
    out_count: *mut u32,
) -> CrumpleResult {
    exclusive("crumple_instance_get_marks", context, |_, state| {
        let out = Out::new(out_count, "out_count")?;
        write_array(state.body(instance)?.marks()?, marks, capacity as usize, "marks", out)
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
    exclusive("crumple_instance_set_marks", context, |_, state| {
        let marks = array(marks, count as usize, "marks")?;
        Ok(state.body(instance)?.set_marks(marks)?)
    })
}

/// Saves an instance's damage as bytes that are equal on all machines, with a version and the set's fingerprint.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_save_damage(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    data: *mut c_void,
    capacity: usize,
    out_size: *mut usize,
) -> CrumpleResult {
    exclusive("crumple_instance_save_damage", context, |_, state| {
        let out = Out::new(out_size, "out_size")?;
        write_array(&state.body(instance)?.save(), data.cast::<u8>(), capacity, "data", out)
    })
}

/// Replaces an instance's damage with the size bytes of saved damage at data. Discards pending hits and ends contacts.
/// Errors: CRUMPLE_ERROR_DAMAGE_MISMATCH (another set, version or rule, cut short, or with a changed bit: it has a
/// checksum), CRUMPLE_ERROR_INVALID_ARGUMENT (a mark that the set cannot have).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_load_damage(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    data: *const c_void,
    size: usize,
) -> CrumpleResult {
    exclusive("crumple_instance_load_damage", context, |_, state| {
        let bytes = array(data.cast::<u8>(), size, "data")?;
        let instance = state.body(instance)?;
        let saved = instance.read(bytes)?;
        granted()?;
        instance.become_saved(saved);
        Ok(())
    })
}

/// Saves the damage of count instances together, or of all instances of the context by increasing index if instances is
/// null and count 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_context_save_damage(
    context: *mut CrumpleContext,
    instances: *const CrumpleInstance,
    count: u32,
    data: *mut c_void,
    capacity: usize,
    out_size: *mut usize,
) -> CrumpleResult {
    exclusive("crumple_context_save_damage", context, |_, state| {
        let out = Out::new(out_size, "out_size")?;
        let ids = listed(state, instances, count)?;
        let mut each = reserve(ids.len(), "the instances")?;
        for (i, id) in ids.into_iter().enumerate() {
            each.push(state.instances.get_mut(id, &format!("instances[{i}]"))?.instance.save());
        }
        write_array(&pack(each.into_iter()), data.cast::<u8>(), capacity, "data", out)
    })
}

/// Replaces the damage of count instances, or of all, with bytes of crumple_context_save_damage() for instances of the same
/// sets in the same order. Otherwise like crumple_instance_load_damage() for each of them. After an error no instance has
/// changed. CRUMPLE_ERROR_DAMAGE_MISMATCH: also another number of instances.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_context_load_damage(
    context: *mut CrumpleContext,
    instances: *const CrumpleInstance,
    count: u32,
    data: *const c_void,
    size: usize,
) -> CrumpleResult {
    exclusive("crumple_context_load_damage", context, |context, state| {
        let bytes = array(data.cast::<u8>(), size, "data")?;
        let ids = listed(state, instances, count)?;
        let mut read = BTreeMap::new();
        for (i, (id, bytes)) in ids.iter().zip(unpack(bytes, Some(ids.len()))?).enumerate() {
            let instance = &state.instances.get(*id, &format!("instances[{i}]"))?.instance;
            read.insert(id.index, instance.read(bytes).map_err(|error| of(i, error))?);
        }
        granted()?;
        let instances = state.instances.iter_mut();
        let changes = instances.filter_map(|(id, entry)| Some((&mut entry.instance, read.remove(&id.index)?)));
        map(&context.tasks, changes, |(instance, saved)| instance.become_saved(saved));
        Ok(())
    })
}

/// The instances that a call names: those given, or all.
unsafe fn listed(
    state: &State,
    instances: *const CrumpleInstance,
    count: u32,
) -> Result<Vec<CrumpleInstance>, Failure> {
    let given = array(instances, count as usize, "instances")?;
    for (i, id) in given.iter().enumerate() {
        state.instances.get(*id, &format!("instances[{i}]"))?;
    }
    let all = instances.is_null();
    Ok(if all { state.instances.iter().map(|(id, _)| id).collect() } else { given.to_vec() })
}

/// Repairs an instance. Every dent keeps a share of its depth, keep: 0 (as new) to 1 (unchanged). Ends contacts.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_repair_damage(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    keep: f32,
) -> CrumpleResult {
    exclusive("crumple_instance_repair_damage", context, |_, state| {
        let [keep] = finite([keep], "keep")?;
        Ok(state.body(instance)?.repair(keep)?)
    })
}

/// Repairs an instance around a point of the mesh's space, m, as with a hammer. A dent whose contact is at the point keeps
/// a share of its depth, keep (0 to 1). Dents further away keep more, and those at radius, m, all of it. A dent is
/// repaired as a whole, also where it reaches beyond the radius. Ends contacts. CRUMPLE_ERROR_WRONG_RULE: a classic rule.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_repair_around(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    point: CrumpleVec3,
    radius: f32,
    keep: f32,
) -> CrumpleResult {
    exclusive("crumple_instance_repair_around", context, |_, state| {
        let (point, [radius]) = (finite(point.array(), "point")?, finite([radius], "radius")?);
        let [keep] = finite([keep], "keep")?;
        Ok(state.body(instance)?.repair_around(point, radius, keep)?)
    })
}

/// Removes all damage of an instance. Discards pending hits and ends contacts.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_reset_damage(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
) -> CrumpleResult {
    exclusive("crumple_instance_reset_damage", context, |_, state| {
        state.body(instance)?.reset();
        Ok(())
    })
}

/// Replaces an instance's damage with that of source, which needs an equal set and the same kind of rule. Discards
/// pending hits and ends contacts. If source is the instance itself, nothing happens. CRUMPLE_ERROR_DAMAGE_MISMATCH:
/// another set or rule.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_copy_damage(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    source: CrumpleInstance,
) -> CrumpleResult {
    exclusive("crumple_instance_copy_damage", context, |_, state| {
        state.instances.get(instance, "instance")?;
        let bytes = state.instances.get_mut(source, "source")?.instance.save();
        if instance == source {
            return Ok(());
        }
        Ok(state.body(instance)?.load(&bytes)?)
    })
}
