//! Deformation in the host's render graph: Crumple returns what to upload and to dispatch.

use super::boundary::boundary;
use super::buffer::add_buffer;
use super::graph_types::GraphState;
use super::graph_types::{CrumpleGraphDispatch, CrumpleGraphPlan, CrumpleGraphUpload};
use super::jobs::with_jobs;
use super::prelude::*;
use super::store::Memory;
use super::vulkan_types::{CrumpleRecordReport, CrumpleVulkanBufferDef};
use crate::graph::{self, GraphBuffer};

/// Returns a compute shader for a render graph that takes SPIR-V, such as Godot's RenderingDevice. It is SPIR-V 1.3
/// with the entry point "main". Make a pipeline of it when a dispatch first names its number.
///
/// All kernels have 32 bytes of push constants and three storage buffers: a storage (set 0, binding 0, read), the work
/// (set 0, binding 1, read) and your vertex buffer from its first byte on (set 1, binding 0, read and written). Errors:
/// CRUMPLE_ERROR_INVALID_ARGUMENT (a kernel that no dispatch names).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_graph_get_kernel(
    kernel: u32,
    data: *mut c_void,
    capacity: usize,
    out_size: *mut usize,
) -> CrumpleResult {
    boundary("crumple_graph_get_kernel", || {
        let out = Out::new(out_size, "out_size")?;
        let words = graph::kernel(kernel)
            .ok_or_else(|| Failure::invalid(format!("kernel is {kernel}; it must be one of a dispatch")))?;
        write_array(bytemuck::cast_slice::<u32, u8>(&words), data.cast::<u8>(), capacity, "data", out)
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
    exclusive("crumple_buffer_register_graph", context, |_, state| {
        let (def, out) = (self::def(def, "def")?, Out::new(out_buffer, "out_buffer")?);
        let owner = &state.instances.get(instance, "instance")?.instance;
        owner.only_marks("a buffer of a render graph")?;
        let target = def.target(GraphBuffer { number: def.buffer, size: def.buffer_size })?;
        let memory = Memory::Graph(state.graph.graph.add_target(owner.example_set(), &target)?);
        add_buffer(state, instance, (def.lod, def.user_data), memory, out)
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
    exclusive("crumple_graph_plan", context, |context, state| {
        let outs = (Out::new(out_plan, "out_plan")?, Out::optional(out_report, "out_report")?);
        let State { instances, buffers: entries, graph, graph_jobs, vertex_budget, .. } = state;
        let GraphState { graph, uploads, dispatches } = graph;
        graph.set_vertex_budget(*vertex_budget);
        with_jobs(&context.tasks, (instances, entries), graph_jobs, (buffers, count), |jobs| {
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
            outs.1.answer(report.into())
        })
    })
}
