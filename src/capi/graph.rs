//! Deformation in the host's render graph: Crumple returns what to upload and to dispatch.
#![cfg_attr(not(feature = "vulkan"), allow(unused_imports, unused_variables))]

use super::boundary::boundary;
use super::buffer::add_buffer;
use super::check::{Out, array, def, write_array};
use super::context::{CrumpleContext, exclusive};
#[cfg(feature = "vulkan")]
use super::graph_types::GraphState;
use super::graph_types::{CrumpleGraphDispatch, CrumpleGraphPlan, CrumpleGraphUpload};
#[cfg(feature = "vulkan")]
use super::jobs::{c_report, with_jobs};
use super::result::{CrumpleResult, Failure};
use super::store::{BufferEntry, Memory, State};
use super::types::{CrumpleBuffer, CrumpleInstance};
use super::vulkan::vulkan;
use super::vulkan_types::{CrumpleRecordReport, CrumpleVulkanBufferDef};
#[cfg(feature = "vulkan")]
use crate::graph::{self, GraphBuffer};
use std::ffi::c_void;

/// Returns a compute shader for a render graph that takes SPIR-V, such as Godot's RenderingDevice. It is SPIR-V 1.3
/// with the entry point "main". Make a pipeline of it when a dispatch first names its number.
///
/// All kernels have 32 bytes of push constants and three storage buffers: a storage (set 0, binding 0, read), the work
/// (set 0, binding 1, read) and your vertex buffer from its first byte on (set 1, binding 0, read and written). Errors:
/// CRUMPLE_ERROR_INVALID_ARGUMENT (a kernel that no dispatch names), CRUMPLE_ERROR_UNSUPPORTED (a build without
/// CRUMPLE_FEATURE_VULKAN).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_graph_get_kernel(
    kernel: u32,
    data: *mut c_void,
    capacity: usize,
    out_size: *mut usize,
) -> CrumpleResult {
    vulkan!("crumple_graph_get_kernel", {
        boundary("crumple_graph_get_kernel", || {
            let out = Out::new(out_size, "out_size")?;
            let words = graph::kernel(kernel)
                .ok_or_else(|| Failure::invalid(format!("kernel is {kernel}; it must be one of a dispatch")))?;
            write_array(bytemuck::cast_slice::<u32, u8>(&words), data.cast::<u8>(), capacity, "data", out)
        })
    })
}

/// Registers a range of a vertex buffer of your render graph, like crumple_buffer_register_vulkan() but without a Vulkan
/// device. def->buffer is any number of yours, which dispatches name. usage, queue_family, stages and accesses are
/// ignored. The first range of a mesh adds uploads to the next plan. Errors: those of crumple_buffer_register_vulkan(),
/// and CRUMPLE_ERROR_WRONG_RULE (a classic rule).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_buffer_register_graph(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    def: *const CrumpleVulkanBufferDef,
    out_buffer: *mut CrumpleBuffer,
) -> CrumpleResult {
    vulkan!("crumple_buffer_register_graph", {
        exclusive("crumple_buffer_register_graph", context, |_, state| {
            let (def, out) = (self::def(def, "def")?, Out::new(out_buffer, "out_buffer")?);
            let owner = &state.instances.get(instance, "instance")?.instance;
            if owner.classic_state().is_some() {
                return Err(owner.needs_marks("a buffer of a render graph").into());
            }
            let target = def.target(GraphBuffer { number: def.buffer, size: def.buffer_size })?;
            let memory = Memory::Graph(state.graph.graph.add_target(owner.example_set(), &target)?);
            add_buffer(state, BufferEntry::new(instance, def.lod, memory, def.user_data), out)
        })
    })
}

/// Plans the passes that write the deformed vertices of count buffers of crumple_buffer_register_graph(), or of all of
/// them if buffers is null and count 0: for the blocks that changed, one dispatch per vertex buffer. Call it once a
/// frame, do the uploads, bind and dispatch. If you drop the dispatches, call crumple_buffer_invalidate() for their
/// buffers. out_report may be null. CRUMPLE_ERROR_INVALID_ARGUMENT: a buffer twice, or another kind of buffer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_graph_plan(
    context: *mut CrumpleContext,
    buffers: *const CrumpleBuffer,
    count: u32,
    out_plan: *mut CrumpleGraphPlan,
    out_report: *mut CrumpleRecordReport,
) -> CrumpleResult {
    vulkan!("crumple_graph_plan", {
        exclusive("crumple_graph_plan", context, |context, state| {
            let outs = (Out::new(out_plan, "out_plan")?, Out::optional(out_report, "out_report")?);
            let given = array(buffers, count as usize, "buffers")?;
            let budget = state.vertex_budget();
            let State { instances, buffers: entries, graph, .. } = state;
            let GraphState { graph, lists, uploads, dispatches } = graph;
            graph.set_vertex_budget(budget);
            with_jobs(context.tasks(), (instances, entries), lists, (buffers, given), |jobs| {
                let (report, passes) = graph.plan(jobs)?;
                uploads.clear();
                uploads.extend(passes.uploads.iter().map(|upload| CrumpleGraphUpload {
                    storage: upload.storage,
                    reserved: 0,
                    storage_size: upload.storage_size,
                    offset: upload.offset,
                    data: upload.words.as_ptr().cast(),
                    size: 4 * upload.words.len(),
                }));
                dispatches.clear();
                dispatches.extend(passes.dispatches.iter().map(|dispatch| CrumpleGraphDispatch {
                    kernel: dispatch.kernel,
                    storage: dispatch.storage,
                    buffer: dispatch.buffer,
                    groups: dispatch.groups,
                    constants: dispatch.constants,
                }));
                outs.0.write(CrumpleGraphPlan {
                    freed: passes.freed.as_ptr(),
                    uploads: uploads.as_ptr(),
                    dispatches: dispatches.as_ptr(),
                    work: passes.work.as_ptr().cast(),
                    work_size: 4 * passes.work.len(),
                    freed_count: passes.freed.len() as u32,
                    upload_count: uploads.len() as u32,
                    dispatch_count: dispatches.len() as u32,
                    reserved: 0,
                });
                outs.1.write(c_report(report));
                Ok(())
            })
        })
    })
}
