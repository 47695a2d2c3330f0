//! Deformation: marks become vertices.

use super::buffer::{CrumpleBufferInfo, info};
use super::check::{Out, array, write_array};
use super::context::{CrumpleContext, exclusive};
use super::host_memory::HostMemory;
use super::ids::Slots;
use super::job_lists::recycled;
use super::result::{CrumpleResult, Failure};
use super::store::{BufferEntry, InstanceEntry, Memory, State};
use super::tasks::Quiet;
use super::types::{CrumpleAabb, CrumpleBuffer, CrumpleInstance, CrumpleRange};
use crate::base::error::reserve;
use crate::base::math::Aabb;
use crate::base::memory::may_fail;
use crate::base::tasks::TaskSystem;
use crate::instance::deform::{DeformJob, deform_within, fold_all};
use std::ops::Range;

/// The work done by a deform. A block is a run of up to 128 consecutive vertices.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct CrumpleDeformReport {
    pub vertices_written: u64,
    pub blocks_written: u64,
    /// Blocks that were up to date.
    pub blocks_skipped: u64,
    /// Vertices that wait for a later call; see crumple_context_set_vertex_budget().
    pub vertices_waiting: u64,
    pub reserved: [u64; 3],
}

/// Writes what changed since the last write of count host buffers, or of all host buffers of the context if buffers is
/// null and count 0, in parallel. With null and 0 it also applies the pending hits of instances without a buffer, so that
/// damage does not depend on which bodies are visible. Nobody else may read or write the memory during the call. out_report may be null. CRUMPLE_ERROR_INVALID_ARGUMENT (no vertex was written): a
/// buffer twice, not a host buffer, or overlapping memory in debug builds.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_context_deform(
    context: *mut CrumpleContext,
    buffers: *const CrumpleBuffer,
    count: u32,
    out_report: *mut CrumpleDeformReport,
) -> CrumpleResult {
    exclusive("crumple_context_deform", context, |context, state| {
        let (out, given) = (Out::optional(out_report, "out_report")?, array(buffers, count as usize, "buffers")?);
        let budget = state.vertex_budget();
        let State { instances, buffers: entries, jobs: kept, .. } = state;
        let mut sorted = Vec::new();
        let chosen = Chosen::new(buffers, given, &mut sorted, |id, name| {
            let memory = &entries.get(id, name)?.memory;
            if matches!(memory, Memory::Host(..)) { Ok(()) } else { Err(memory.written_elsewhere(name)) }
        })?;
        let of_host =
            |(id, entry): &(CrumpleBuffer, &BufferEntry)| chosen.names(*id) && matches!(entry.memory, Memory::Host(..));
        if cfg!(debug_assertions) {
            apart(entries.iter::<CrumpleBuffer>().filter(of_host))?;
        }
        chosen.fold(instances, entries.iter::<CrumpleBuffer>().filter(of_host), context.tasks())?;
        let mut jobs = recycled(std::mem::take(kept));
        may_fail(|| jobs.try_reserve(chosen.most(entries.len())))
            .map_err(|_| Failure::out_of_memory("the list of jobs"))?;
        for (_, entry) in entries.iter_mut::<CrumpleBuffer>().filter(|(id, _)| chosen.names(*id)) {
            let Memory::Host(memory, tracker) = &mut entry.memory else { continue };
            jobs.push(DeformJob {
                lod: entry.lod,
                instance: &instances.get(entry.owner, "instance")?.instance,
                tracker,
                memory: memory.vertices()?,
            });
        }
        let report = deform_within(&mut jobs, budget, &Quiet(context.tasks()));
        *kept = recycled(jobs);
        let report = report?;
        for (id, entry) in entries.iter_mut::<CrumpleBuffer>() {
            if matches!(entry.memory, Memory::Host(..)) {
                entry.included = chosen.names(id);
            }
        }
        out.write(CrumpleDeformReport {
            vertices_written: report.vertices_written,
            blocks_written: report.blocks_written,
            blocks_skipped: report.blocks_skipped,
            vertices_waiting: report.vertices_waiting,
            reserved: [0; 3],
        });
        Ok(())
    })
}

/// The buffers that a call names: those given, or all.
pub(super) struct Chosen<'a> {
    /// By index.
    sorted: &'a [CrumpleBuffer],
    pub(super) all: bool,
}

impl<'a> Chosen<'a> {
    /// Of an array that C gave; `room` is filled and kept, `check` sees each id with its name.
    pub(super) fn new(
        pointer: *const CrumpleBuffer,
        given: &[CrumpleBuffer],
        room: &'a mut Vec<CrumpleBuffer>,
        check: impl Fn(CrumpleBuffer, &str) -> Result<(), Failure>,
    ) -> Result<Self, Failure> {
        room.clear();
        may_fail(|| room.try_reserve(given.len())).map_err(|_| Failure::out_of_memory("the list of buffers"))?;
        for (i, &id) in given.iter().enumerate() {
            check(id, &format!("buffers[{i}]"))?;
            room.push(id);
        }
        room.sort_unstable_by_key(|id| id.index);
        if let Some([twice, _]) = room.array_windows().find(|[a, b]| a == b) {
            return Err(Failure::invalid(format!("buffers names buffer {} twice; name each once", twice.index)));
        }
        Ok(Chosen { sorted: room, all: pointer.is_null() })
    }

    /// Turns waiting hits into damage: of all instances where all buffers are named, so that the damage of a body does not
    /// depend on whether it has a buffer; else of the instances that own these buffers.
    pub(super) fn fold<'b>(
        &self,
        instances: &mut Slots<InstanceEntry>,
        named: impl Iterator<Item = (CrumpleBuffer, &'b BufferEntry)>,
        tasks: &dyn TaskSystem,
    ) -> Result<(), Failure> {
        if self.all {
            fold_all(instances.iter_mut::<CrumpleInstance>().map(|(_, entry)| &mut entry.instance), &Quiet(tasks));
            return Ok(());
        }
        for (_, entry) in named {
            instances.get_mut(entry.owner, "instance")?.instance.fold();
        }
        Ok(())
    }

    /// Of an id that is not stale.
    pub(super) fn names(&self, id: CrumpleBuffer) -> bool {
        self.all || self.sorted.binary_search_by_key(&id.index, |c| c.index).is_ok()
    }

    /// How many at most, where there are so many in all.
    pub(super) fn most(&self, there_are: usize) -> usize {
        if self.all { there_are } else { self.sorted.len() }
    }
}

/// Refuses buffers that share memory.
fn apart<'a>(entries: impl Iterator<Item = (CrumpleBuffer, &'a BufferEntry)>) -> Result<(), Failure> {
    let of_host = |(id, entry): (CrumpleBuffer, &'a BufferEntry)| {
        if let Memory::Host(memory, _) = &entry.memory { Some((id, memory)) } else { None }
    };
    let hosts = entries.filter_map(of_host);
    let streams = |(id, memory): (CrumpleBuffer, &'a HostMemory)| memory.streams().map(move |s| (s.layout, id.index));
    let mut layouts: Vec<_> = hosts.flat_map(streams).collect();
    layouts.sort_unstable_by_key(|(layout, _)| layout.first);
    for (i, (a, x)) in layouts.iter().enumerate() {
        for (b, y) in layouts[i + 1..].iter().take_while(|(b, _)| b.first < a.span().end) {
            if x != y && a.overlaps(b) {
                return Err(Failure::invalid(format!(
                    "the memory of buffers {x} and {y} overlaps; each needs its own"
                )));
            }
        }
    }
    Ok(())
}

/// Returns the buffers that the last crumple_context_deform() and the last recording or submit wrote to, by increasing
/// index, and whose they are.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_context_get_changed_buffers(
    context: *mut CrumpleContext,
    buffers: *mut CrumpleBufferInfo,
    capacity: u32,
    out_count: *mut u32,
) -> CrumpleResult {
    exclusive("crumple_context_get_changed_buffers", context, |_, state| {
        let out = Out::new(out_count, "out_count")?;
        let changed = |entry: &BufferEntry| entry.included && !entry.changed().is_empty();
        let written = state.buffers.iter().filter(|(_, entry)| changed(entry));
        let found = written.map(|(id, entry)| info(id, entry, state)).collect::<Result<Vec<_>, _>>()?;
        write_array(&found, buffers, capacity as usize, "buffers", out)
    })
}

pub(super) fn c_ranges(ranges: &[Range<u32>]) -> Result<Vec<CrumpleRange>, Failure> {
    let mut found = reserve(ranges.len(), "ranges")?;
    found.extend(ranges.iter().map(|r| CrumpleRange { first: r.start, count: r.end - r.start }));
    Ok(found)
}

/// Returns the vertices written by the last deform or recording that named the buffer or all buffers, as increasing ranges
/// that do not overlap. out_bounds, which may be null, receives the bounds of all vertices, m; they may be too large for a
/// buffer on a device. Use both for uploads, refits and culling.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_buffer_get_changes(
    context: *mut CrumpleContext,
    buffer: CrumpleBuffer,
    ranges: *mut CrumpleRange,
    capacity: u32,
    out_count: *mut u32,
    out_bounds: *mut CrumpleAabb,
) -> CrumpleResult {
    exclusive("crumple_buffer_get_changes", context, |_, state| {
        let outs = (Out::new(out_count, "out_count")?, Out::optional(out_bounds, "out_bounds")?);
        let entry = state.buffers.get(buffer, "buffer")?;
        let found = c_ranges(entry.changed())?;
        let at_rest = || -> Result<Aabb, Failure> {
            let set = state.instances.get(entry.owner, "instance")?.instance.example_set();
            Ok(set.lod_mesh(entry.lod)?.bounds())
        };
        let bounds = entry.bounds().map_or_else(at_rest, Ok)?;
        write_array(&found, ranges, capacity as usize, "ranges", outs.0)?;
        outs.1.write(bounds.into());
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::super::{buffer::*, build::*, context::*, host_memory::*, instance::*, memory::*, types::*};
    use super::*;

    fn stream(memory: &mut [f32], first: usize) -> CrumpleStream {
        CrumpleStream { data: memory.as_mut_ptr().cast(), size: size_of_val(memory), offset: first * 4, stride: 12 }
    }

    fn ok(result: CrumpleResult) {
        assert_eq!(result, CrumpleResult::CrumpleOk);
    }

    #[test]
    fn memory_of_two_buffers_must_not_overlap_in_debug_builds() {
        let base = [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        let target = [0.0f32, 0.0, -0.1, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        let input = |a: &[f32]| CrumpleInput { data: a.as_ptr().cast(), size: size_of_val(a), stride: 12 };
        let example = CrumpleExampleDef { target_positions: input(&target), ..crumple_example_def_default() };
        let def = CrumpleExampleSetDef {
            mesh: &CrumpleMeshDef { vertex_count: 3, positions: input(&base), ..crumple_mesh_def_default() },
            examples: &example,
            example_count: 1,
            ..crumple_example_set_def_default()
        };
        let mut context = std::ptr::null_mut();
        let (mut set, mut instance) = (CrumpleExampleSet::default(), CrumpleInstance::default());
        let mut memory = [0.0f32; 24];
        // SAFETY: every pointer is to something that lives until the context is destroyed.
        unsafe {
            let single = CrumpleContextDef { threads: 1, ..crumple_context_def_default() };
            ok(crumple_context_create(&single, &mut context));
            ok(crumple_example_set_create(context, &def, &mut set));
            ok(crumple_instance_create(
                context,
                &CrumpleInstanceDef { set, ..crumple_instance_def_default() },
                &mut instance,
            ));
            let mut register = |first: usize| {
                let positions = stream(&mut memory, first);
                let def = CrumpleHostBufferDef { positions, ..crumple_host_buffer_def_default() };
                let mut buffer = CrumpleBuffer::default();
                ok(crumple_buffer_register_host(context, instance, &def, &mut buffer));
                buffer
            };
            let (first, beside, across) = (register(0), register(9), register(6));
            ok(crumple_context_deform(context, [first, beside].as_ptr(), 2, std::ptr::null_mut()));
            let expected = if cfg!(debug_assertions) {
                CrumpleResult::CrumpleErrorInvalidArgument
            } else {
                CrumpleResult::CrumpleOk
            };
            assert_eq!(crumple_context_deform(context, std::ptr::null(), 0, std::ptr::null_mut()), expected);
            ok(crumple_buffer_unregister(context, across));
            ok(crumple_context_deform(context, std::ptr::null(), 0, std::ptr::null_mut()));
            ok(crumple_context_destroy(context));
        }
        // Where overlap is not looked for, the last buffer wrote over the first.
        assert!(memory[..9] == base || !cfg!(debug_assertions));
    }
}
