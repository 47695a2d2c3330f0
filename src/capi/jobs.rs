//! The buffers that a recording or a plan writes, as jobs for the graphics device.

use super::deform::Chosen;
use super::ids::Slots;
use super::job_lists::{JobLists, recycled};
use super::result::Failure;
use super::store::{BufferEntry, InstanceEntry, Memory};
use super::types::CrumpleBuffer;
use super::vulkan_types::CrumpleRecordReport;
use crate::base::memory::may_fail;
use crate::base::tasks::TaskSystem;
use crate::gpu::{FrameReport, Job};
use crate::{graph, vulkan};

/// A kind of buffer on a graphics device.
pub(super) trait DeviceTarget: Sized + 'static {
    /// Whether a buffer's memory is of this kind.
    fn is_of(memory: &Memory) -> bool;
    fn of(memory: &mut Memory) -> Option<&mut Self>;
}

impl DeviceTarget for vulkan::Target {
    fn is_of(memory: &Memory) -> bool {
        matches!(memory, Memory::Vulkan(_))
    }

    fn of(memory: &mut Memory) -> Option<&mut Self> {
        if let Memory::Vulkan(memory) = memory { Some(&mut memory.target) } else { None }
    }
}

impl DeviceTarget for graph::Target {
    fn is_of(memory: &Memory) -> bool {
        matches!(memory, Memory::Graph(_))
    }

    fn of(memory: &mut Memory) -> Option<&mut Self> {
        if let Memory::Graph(target) = memory { Some(target) } else { None }
    }
}

/// Folds the hits of the chosen buffers' instances, and calls `f` with a job for each buffer.
pub(super) fn with_jobs<T: DeviceTarget, R>(
    tasks: &dyn TaskSystem,
    (instances, entries): (&mut Slots<InstanceEntry>, &mut Slots<BufferEntry>),
    lists: &mut JobLists<T>,
    (pointer, given): (*const CrumpleBuffer, &[CrumpleBuffer]),
    f: impl FnOnce(&mut [Job<'_, T>]) -> Result<R, Failure>,
) -> Result<R, Failure> {
    let most = if pointer.is_null() { entries.len() } else { given.len() };
    let chosen = Chosen::new(pointer, given, &mut lists.chosen, |id, name| {
        let memory = &entries.get(id, name)?.memory;
        if T::is_of(memory) { Ok(()) } else { Err(memory.written_elsewhere(name)) }
    })?;
    let written = |(id, entry): &(CrumpleBuffer, &BufferEntry)| T::is_of(&entry.memory) && chosen.names(*id);
    chosen.fold(instances, entries.iter::<CrumpleBuffer>().filter(written), tasks)?;
    let mut jobs = recycled(std::mem::take(&mut lists.jobs));
    may_fail(|| jobs.try_reserve(most)).map_err(|_| Failure::out_of_memory("the list of jobs"))?;
    for (id, entry) in entries.iter_mut::<CrumpleBuffer>() {
        let Some(target) = T::of(&mut entry.memory) else { continue };
        if chosen.names(id) {
            jobs.push(Job { instance: &instances.get(entry.owner, "instance")?.instance, target });
        }
    }
    let result = f(&mut jobs);
    lists.jobs = recycled(jobs);
    if result.is_ok() {
        for (id, entry) in entries.iter_mut::<CrumpleBuffer>() {
            if T::is_of(&entry.memory) {
                entry.included = chosen.names(id);
            }
        }
    }
    result
}

pub(super) fn c_report(report: FrameReport) -> CrumpleRecordReport {
    CrumpleRecordReport {
        vertices_written: report.vertices_written,
        blocks_written: report.blocks_written,
        blocks_skipped: report.blocks_skipped,
        bytes_copied: report.bytes_copied,
        dispatches: report.dispatches,
        vertices_waiting: report.vertices_waiting,
        ..CrumpleRecordReport::default()
    }
}
