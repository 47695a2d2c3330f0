//! What there is when a recording begins, as the calls that would make it.

use super::super::buffer::{BufferEntry, Memory};
use super::super::context::State;
use super::super::instance::{CrumpleRule, CrumpleSelection, InstanceEntry};
use super::super::result::Failure;
use super::super::types::{CrumpleBuffer, CrumpleExampleSet, CrumpleInstance};
use super::calls::{Bytes, Call, Number};
use super::file::{Ended, Event, Writer};
use crate::{Error, ExampleSet, Rule, Selection};
use std::collections::HashSet;

/// Refuses what no call could make again.
pub(super) fn check(state: &mut State) -> Result<(), Failure> {
    for (id, entry) in state.instances.iter_mut::<CrumpleInstance>() {
        let open = if entry.instance.options().rule == Rule::Marks { entry.instance.contact_count() } else { 0 };
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

/// Writes sets, instances and buffers, and invalidates the buffers, so that replays and what is recorded write the same vertices.
pub(super) fn write(state: &mut State, writer: &mut Writer) -> Result<(), Failure> {
    let none = Number(0);
    let mut call = |call: Call, made: Number| {
        writer.write(&Event::Call(call));
        writer.write(&Event::Ended(Ended { result: 0, value: made.0 }));
    };
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
    Ok(Call::Set { set: Number::of(id), bytes: Bytes(set.save()?) })
}

/// An instance as it was made.
pub(super) fn create(entry: &InstanceEntry) -> Call {
    let o = entry.instance.options();
    let (rule, blend_constant) = match o.rule {
        Rule::Marks => (CrumpleRule::Marks, 0.0),
        Rule::MostDisplaced => (CrumpleRule::MostDisplaced, 0.0),
        Rule::Blend(constant) => (CrumpleRule::Blend, constant),
    };
    let selection = match o.selection {
        Selection::Nearest => CrumpleSelection::Nearest,
        Selection::Classic => CrumpleSelection::Classic,
        Selection::ClassicUnclamped => CrumpleSelection::ClassicUnclamped,
    };
    Call::CreateInstance {
        set: Number::of(entry.set),
        rule: rule as u32,
        selection: selection as u32,
        examples_per_hit: o.examples_per_hit,
        mark_capacity: o.capacity,
        depth_limit: o.depth_limit.unwrap_or(0.0),
        yield_impulse: o.yield_impulse,
        yield_displacement: o.yield_displacement,
        max_contact_distance: o.max_contact_distance.unwrap_or(0.0),
        blend_constant,
        tolerance: o.tolerance,
        local_to_world: entry.local_to_world,
    }
}

/// A buffer's registration.
pub(super) fn register(entry: &BufferEntry, set: &ExampleSet) -> Call {
    let (normals, tangents) = written(entry);
    // Its level of detail was found when it was registered.
    let vertices = set.lod_mesh(entry.lod).map_or(0, |mesh| mesh.positions().len() as u32);
    Call::RegisterBuffer { instance: Number::of(entry.owner), lod: entry.lod as u32, vertices, normals, tangents }
}

/// Whether normals and tangents are written.
fn written(entry: &BufferEntry) -> (bool, bool) {
    match &entry.memory {
        Memory::Host(memory, _) => memory.written(),
        Memory::Vulkan(memory) => memory.written(),
    }
}
