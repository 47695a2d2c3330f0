//! What a recording collects: its plan and its barriers.

use super::host_buffers::{BufferId, HostBuffers};
use super::target::TargetBinding;
use super::vulkan_device::VulkanDevice;
use crate::base::error::Error;
use crate::gpu::Plan;
use ash::vk;
use std::ops::Range;
use std::ptr::null;

/// The lists of a recording. They are reused.
#[derive(Default)]
pub(super) struct Recording {
    pub plan: Plan<TargetBinding>,
    /// Buffers that another queue family owns.
    pub foreign: Vec<BufferId>,
    /// Barriers before the dispatches.
    pub before: Vec<vk::BufferMemoryBarrier<'static>>,
    /// Barriers after the dispatches.
    pub after: Vec<vk::BufferMemoryBarrier<'static>>,
}

/// The access of a kernel to a buffer that it writes.
pub(super) const SHADER_WRITE: vk::AccessFlags = vk::AccessFlags::SHADER_WRITE;
/// The stage of the kernels.
pub(super) const COMPUTE: vk::PipelineStageFlags = vk::PipelineStageFlags::COMPUTE_SHADER;

/// Adds barriers that acquire and release the buffers of other queue families. Returns the stages before and after.
pub(super) fn acquire_and_release(
    hosts: &mut HostBuffers,
    gpu: &VulkanDevice,
    r: &mut Recording,
    frame: u64,
) -> Result<(vk::PipelineStageFlags, vk::PipelineStageFlags), Error> {
    let (mut from, mut to) = (vk::PipelineStageFlags::empty(), vk::PipelineStageFlags::empty());
    for buffer in &r.foreign {
        let host = hosts.get_mut(*buffer)?;
        host.used = frame;
        let (def, ours, none) = (host.def, gpu.family, vk::AccessFlags::empty());
        let transfer = |(from, from_family), (to, to_family)| {
            barrier(def.buffer, 0..vk::WHOLE_SIZE, from, to)
                .src_queue_family_index(from_family)
                .dst_queue_family_index(to_family)
        };
        // The other family makes its own accesses available and visible.
        r.before.push(transfer((none, def.queue_family), (SHADER_WRITE, ours)));
        r.after.push(transfer((SHADER_WRITE, ours), (none, def.queue_family)));
        (from, to) = (from | def.before.stages, to | def.after.stages);
    }
    Ok((from, to))
}

/// A barrier for these bytes of a buffer that stays with its queue family.
pub(super) fn barrier(
    buffer: vk::Buffer,
    bytes: Range<u64>,
    from: vk::AccessFlags,
    to: vk::AccessFlags,
) -> vk::BufferMemoryBarrier<'static> {
    vk::BufferMemoryBarrier::default()
        .src_access_mask(from)
        .dst_access_mask(to)
        .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .buffer(buffer)
        .offset(bytes.start)
        .size(if bytes.end == vk::WHOLE_SIZE { bytes.end } else { bytes.end - bytes.start })
}

/// Records the barriers between two sets of stages.
pub(super) fn cmd_barrier(
    gpu: &VulkanDevice,
    commands: vk::CommandBuffer,
    (from, to): (vk::PipelineStageFlags, vk::PipelineStageFlags),
    barriers: &[vk::BufferMemoryBarrier<'_>],
) {
    let (none, count) = (vk::DependencyFlags::empty(), barriers.len() as u32);
    let f = gpu.functions.cmd_pipeline_barrier;
    // SAFETY: the command buffer is recording.
    unsafe { f(commands, from, to, none, 0, null(), count, barriers.as_ptr(), 0, null()) };
}
