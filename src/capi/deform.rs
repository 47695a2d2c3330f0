//! Deformation: marks become vertices.

use super::buffer::{CrumpleBufferInfo, info};
use super::jobs::with_jobs;
use super::prelude::*;
use super::store::BufferEntry;
use super::types::{CrumpleAabb, CrumpleRange};
use crate::base::error::reserve;
use crate::base::math::Aabb;
use crate::instance::deform::deform_within;
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
        let out = Out::optional(out_report, "out_report")?;
        let State { instances, buffers: entries, host_jobs, vertex_budget, .. } = state;
        let report = with_jobs(&context.tasks, (instances, entries), host_jobs, (buffers, count), |jobs| {
            Ok(deform_within(jobs, *vertex_budget, &context.tasks)?)
        })?;
        out.answer(CrumpleDeformReport {
            vertices_written: report.vertices_written,
            blocks_written: report.blocks_written,
            blocks_skipped: report.blocks_skipped,
            vertices_waiting: report.vertices_waiting,
            reserved: [0; 3],
        })
    })
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
        let changed = |entry: &BufferEntry| entry.included && !entry.memory.tracker().changed().is_empty();
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
        let tracker = entry.memory.tracker();
        let found = c_ranges(tracker.changed())?;
        let at_rest = || -> Result<Aabb, Failure> {
            let set = state.instances.get(entry.owner, "instance")?.instance.example_set();
            Ok(set.lod_mesh(entry.lod)?.bounds())
        };
        let bounds = tracker.bounds().map_or_else(at_rest, Ok)?;
        write_array(&found, ranges, capacity as usize, "ranges", outs.0)?;
        outs.1.answer(bounds.into())
    })
}
