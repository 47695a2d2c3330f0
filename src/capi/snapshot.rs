//! What there is when a recording begins, as the calls that would make it.

use super::record_call::{Bytes, Call, Number, Written};
use super::record_file::{Ended, Event, Writer};
use super::result::Failure;
use super::store::{BufferEntry, InstanceEntry, State};
use super::types::{CrumpleBuffer, CrumpleExampleSet, CrumpleInstance, CrumpleRule, CrumpleSelection};
use crate::base::error::{Error, headroom};
use crate::example::set::ExampleSet;
use crate::instance::options::Rule;
use std::collections::HashSet;
use std::sync::PoisonError;

/// Refuses what no call could make again.
pub(super) fn check(state: &mut State) -> Result<(), Failure> {
    for (id, entry) in state.instances.iter_mut::<CrumpleInstance>() {
        let open = if entry.instance.options().rule == Rule::Marks { entry.instance.contact_count() } else { 0 };
        if entry.instance.has_parts() {
            return Err(Failure::invalid(format!(
                "instance {} has parts that were released or made rigid, or is one; begin the recording before that",
                id.index
            )));
        }
        if entry.instance.has_thresholds() {
            return Err(Failure::invalid(format!(
                "instance {} has thresholds, of which a recording would not know which were passed; begin the recording before",
                id.index
            )));
        }
        if open > 0 {
            return Err(Failure::invalid(format!(
                "instance {} has {open} open contacts, of which a recording would know only what is yet to come; begin while no \
                 contact is open, or end them first",
                id.index
            )));
        }
    }
    Ok(())
}

/// Writes sets, instances and buffers. Invalidates the buffers, shows dents that grow in full and forgets contacts that ended,
/// so that a replay gives what is recorded.
pub(super) fn write(state: &mut State, writer: &mut Writer) -> Result<(), Failure> {
    let none = Number(0);
    let mut call = |call: Call, made: Number| {
        writer.write(&Event::Call(call));
        writer.write(&Event::Ended(Ended { result: 0, value: made.0 }));
    };
    if state.vertex_budget > 0 {
        call(Call::SetVertexBudget { vertices: state.vertex_budget }, none);
    }
    if state.time != 0.0 {
        call(Call::SetTime { time: state.time }, none);
    }
    let mut known = HashSet::new();
    for (id, entry) in state.sets.iter::<CrumpleExampleSet>() {
        known.insert(Number::of(id));
        call(set(id, &entry.set)?, Number::of(id));
    }
    // Instances outlive the ids of their sets.
    let mut ended = Vec::new();
    for (_, entry) in state.instances.iter::<CrumpleInstance>() {
        let number = Number::of(entry.set);
        if known.insert(number) {
            call(set(entry.set, entry.instance.example_set())?, number);
            ended.push(number);
        }
    }
    for (id, entry) in state.instances.iter_mut::<CrumpleInstance>() {
        let instance = Number::of(id);
        entry.instance.finish_growth();
        entry.instance.forget_ended_contacts();
        call(create(entry), instance);
        call(Call::SetDepthLimit { instance, depth_limit: entry.instance.depth_limit() }, none);
        call(Call::SetTolerance { instance, tolerance: entry.instance.tolerance() }, none);
        call(Call::LoadDamage { instance, bytes: Bytes(entry.instance.save()) }, none);
    }
    ended.into_iter().for_each(|set| call(Call::DestroySet { set }, none));
    for (id, entry) in state.buffers.iter_mut::<CrumpleBuffer>() {
        entry.invalidate();
        let set = state.instances.get(entry.owner, "instance")?.instance.example_set();
        call(register(entry, set), Number::of(id));
    }
    Ok(())
}

/// A set as it is now.
pub(super) fn set(id: CrumpleExampleSet, set: &ExampleSet) -> Result<Call, Error> {
    let bytes = Bytes(set.save()?);
    // The message that the recording writes doubles its memory until the bytes fit.
    headroom(bytes.0.len().saturating_mul(2), "the recording of a set")?;
    Ok(Call::Set { set: Number::of(id), bytes })
}

/// An instance as it was made.
pub(super) fn create(entry: &InstanceEntry) -> Call {
    let o = entry.instance.options();
    let blend_constant = if let Rule::Blend(constant) = o.rule { constant } else { 0.0 };
    Call::CreateInstance {
        set: Number::of(entry.set),
        rule: CrumpleRule::from(o.rule) as u32,
        selection: CrumpleSelection::from(o.selection) as u32,
        examples_per_hit: o.examples_per_hit,
        mark_capacity: o.capacity,
        depth_limit: o.depth_limit.unwrap_or(0.0),
        yield_impulse: o.yield_impulse,
        yield_displacement: o.yield_displacement,
        max_contact_distance: o.max_contact_distance.unwrap_or(0.0),
        blend_constant,
        tolerance: o.tolerance,
        grow_time: o.grow_time,
        compliance: o.compliance.unwrap_or(0.0),
        local_to_world: *entry.local_to_world.lock().unwrap_or_else(PoisonError::into_inner),
    }
}

/// A buffer's registration.
pub(super) fn register(entry: &BufferEntry, set: &ExampleSet) -> Call {
    let written = entry.written();
    // Its level of detail was found when it was registered.
    let vertices = set.lod_mesh(entry.lod).map_or(0, |mesh| mesh.positions().len() as u32);
    let (instance, lod) = (Number::of(entry.owner), entry.lod as u32);
    let Written { normals, tangents, wear, .. } = written;
    if !written.is_floats() {
        return Call::RegisterPackedBuffer { instance, lod, vertices, written };
    }
    if wear {
        return Call::RegisterWornBuffer { instance, lod, vertices, normals, tangents };
    }
    Call::RegisterBuffer { instance, lod, vertices, normals, tangents }
}
