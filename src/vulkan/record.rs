//! Records a frame: copies, barriers and dispatches for what changed.

use super::device::{Barriers, Device};
use super::memory::{BufferUse, OwnBuffer};
use super::staging::FrameSlot;
use super::target::{ClassicState, Target};
use super::vulkan_device::VulkanDevice;
use crate::base::error::Error;
use crate::gpu::{Case, FrameReport, Job, Plan};
use ash::vk::{self, Handle};
use bytemuck::bytes_of;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// The access of a kernel to a buffer that it writes.
const SHADER_WRITE: vk::AccessFlags = vk::AccessFlags::SHADER_WRITE;
/// The stage of the kernels.
const COMPUTE: vk::PipelineStageFlags = vk::PipelineStageFlags::COMPUTE_SHADER;

impl Device {
    /// Records what brings the targets up to date: only the blocks that changed since each was last written. If nothing changed,
    /// nothing is recorded.
    ///
    /// `frame` is the host's number of the frame, from 1 on. It never falls; several recordings may have the same. The command
    /// buffer, primary or secondary, is in the recording state, outside a render pass, and from a pool of the device's queue
    /// family. It is submitted once, before the command buffer of the next recording or together with it.
    ///
    /// **Changed state of the command buffer**: the compute pipeline, the compute descriptor sets 0 to 2, and the first 28 bytes
    /// of the push constants of stage compute. Nothing else.
    ///
    /// Buffers, memory and descriptor sets are only made when more recordings are in flight, or more changes in a frame, than
    /// ever before ([`Device::objects_made`]).
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a null command buffer, a frame that is done or below the last, a target of another device
    /// or set, or a removed buffer; [`Error::WrongRule`] for an instance with a classic rule at another level of detail than 0;
    /// [`Error::Unsupported`] for more work than the device can bind; [`Error::OutOfMemory`], [`Error::Vulkan`],
    /// [`Error::DeviceLost`]. After an error nothing is recorded, and targets hold what they held.
    ///
    /// # Safety
    /// The command buffer is one of this device in the state above. No other thread uses its pool meanwhile.
    pub unsafe fn record(
        &mut self,
        commands: vk::CommandBuffer,
        frame: u64,
        jobs: &mut [Job<'_, Target>],
    ) -> Result<FrameReport, Error> {
        if commands.is_null() {
            return Err(Error::invalid("the VkCommandBuffer", "null", "a valid handle"));
        }
        if frame <= self.completed || frame < self.recorded {
            let expected = format!("above {}, the last completed, and no less than {}", self.completed, self.recorded);
            return Err(Error::invalid("frame", frame, &expected));
        }
        self.plan.check(jobs)?;
        self.find_foreign(jobs)?;
        self.add_states(jobs)?;
        let mut report = self.plan.fill(jobs)?;
        if report.blocks_written > 0 {
            let slot = self.fill_slot(jobs)?;
            report.bytes_copied = self.commands((commands, frame), Some(slot), jobs)?;
        } else if !self.barriers.foreign.is_empty() {
            self.commands((commands, frame), None, jobs)?;
        }
        report.vertices_written = self.plan.commit(jobs, frame);
        Ok(report)
    }

    /// Finds the buffers that another queue family owns.
    fn find_foreign(&mut self, jobs: &[Job<'_, Target>]) -> Result<(), Error> {
        let foreign = &mut self.barriers.foreign;
        foreign.clear();
        for (j, job) in jobs.iter().enumerate() {
            let buffer = job.target.binding.buffer;
            let host = self.hosts.get(buffer).map_err(|e| of_job(e, j))?;
            if self.gpu.foreign(host.def.queue_family) {
                foreign.push(buffer);
            }
        }
        foreign.sort_unstable();
        foreign.dedup();
        Ok(())
    }

    /// Makes the states and pipelines that targets of instances with a classic rule lack.
    fn add_states(&mut self, jobs: &mut [Job<'_, Target>]) -> Result<(), Error> {
        let Device { gpu, pipelines, states, .. } = self;
        Plan::add_states(jobs, &gpu.binding_limits(), |target, bytes| {
            pipelines.add(target.layout.variant(Case::Classic))?;
            let buffer = OwnBuffer::new(gpu, bytes, BufferUse::Storage)?;
            let set = pipelines.set(&[(buffer.handle, 0, bytes)])?;
            let last_frame = AtomicU64::new(0);
            let state = Arc::new(ClassicState { buffer: buffer.handle, set: set.handle, last_frame });
            states.push((state.clone(), buffer, set));
            Ok(state)
        })
    }

    /// Takes a slot, writes the frame's data into it, and adds the descriptor sets that it lacks.
    fn fill_slot(&mut self, jobs: &[Job<'_, Target>]) -> Result<usize, Error> {
        let words = self.plan.words;
        let index = FrameSlot::free(&mut self.slots, &self.gpu, self.completed, 4 * words as u64)?;
        let slot = &mut self.slots[index];
        for dispatch in &self.plan.dispatches {
            let chunk = dispatch.key.chunk;
            slot.add_set(&self.pipelines, chunk, self.arena.buffer(chunk))?;
        }
        slot.staging.write(words, |to| self.plan.write(jobs, to))?;
        Ok(index)
    }

    /// Records the commands of a frame: with its data in a slot, or only the acquire and the release of buffers that another queue
    /// family owns. Returns the number of bytes that are copied. Everything that can fail was done before, except for look-ups that
    /// were checked.
    fn commands(
        &mut self,
        (commands, frame): (vk::CommandBuffer, u64),
        slot: Option<usize>,
        jobs: &[Job<'_, Target>],
    ) -> Result<u64, Error> {
        self.recorded = frame;
        let r = &mut self.barriers;
        r.before.clear();
        r.after.clear();
        (r.from, r.to) = Default::default();
        let mut bytes_copied = 0;
        if let Some(slot) = slot {
            self.slots[slot].frame = frame;
            self.barriers.from = COMPUTE | vk::PipelineStageFlags::TRANSFER;
            bytes_copied = self.copies((commands, frame), slot);
        }
        self.barriers_of_buffers(frame)?;
        for dispatch in self.plan.dispatches.iter().filter(|d| d.classic()) {
            let Some(state) = &jobs[dispatch.job].target.classic else { continue };
            state.last_frame.fetch_max(frame, Ordering::Relaxed);
            let (read, write) = (vk::AccessFlags::SHADER_READ, SHADER_WRITE);
            self.barriers.before.push(barrier(state.buffer, 0..vk::WHOLE_SIZE, write, read | write));
        }
        let Barriers { before, from, after, to, .. } = &self.barriers;
        cmd_barrier(&self.gpu, commands, (*from, COMPUTE), before);
        if let Some(slot) = slot {
            self.dispatches(commands, &self.slots[slot], jobs)?;
        }
        cmd_barrier(&self.gpu, commands, (COMPUTE, *to), after);
        Ok(bytes_copied)
    }

    /// Records the copies of new meshes and of the frame's data, and adds their barriers. Returns the number of bytes.
    fn copies(&mut self, (commands, frame): (vk::CommandBuffer, u64), slot: usize) -> u64 {
        let (device, slot, before) = (&self.gpu.device, &self.slots[slot], &mut self.barriers.before);
        let mut total = 0;
        let mut copy = |from: vk::Buffer, to: vk::Buffer, at: u64, size: u64| {
            let region = vk::BufferCopy { src_offset: 0, dst_offset: at, size };
            // SAFETY: the command buffer is recording, as `record` demands. So everywhere in this file. The ranges lie within
            // both buffers.
            unsafe { device.cmd_copy_buffer(commands, from, to, &[region]) };
            total += size;
            let (write, read) = (vk::AccessFlags::TRANSFER_WRITE, vk::AccessFlags::SHADER_READ);
            before.push(barrier(to, at..at + size, write, read));
        };
        self.arena.record(frame, |staging, chunk, at| copy(staging.handle, chunk.handle, at, staging.size));
        copy(slot.staging.handle, slot.storage.handle, 0, 4 * self.plan.words as u64);
        total
    }

    /// Adds the barriers of the host's buffers.
    fn barriers_of_buffers(&mut self, frame: u64) -> Result<(), Error> {
        let Device { gpu, hosts, plan, barriers: r, .. } = self;
        let mut previous = None;
        for dispatch in &plan.dispatches {
            let binding = dispatch.key.binding;
            let host = hosts.get_mut(binding.buffer)?;
            host.used = frame;
            if gpu.foreign(host.def.queue_family) || previous.replace(binding) == Some(binding) {
                continue;
            }
            // The barrier covers everything that is bound: the kernel decides what of it is written. It also orders writes of
            // earlier recordings before these.
            let (bytes, def) = (&host.windows[binding.window].range, &host.def);
            r.before.push(barrier(binding.handle, bytes.clone(), def.before.access | SHADER_WRITE, SHADER_WRITE));
            r.after.push(barrier(binding.handle, bytes.clone(), SHADER_WRITE, def.after.access));
            (r.from, r.to) = (r.from | def.before.stages, r.to | def.after.stages);
        }
        for buffer in &r.foreign {
            let host = hosts.get_mut(*buffer)?;
            host.used = frame;
            let (def, none) = (&host.def, vk::AccessFlags::empty());
            let transfer = |(from, from_family), (to, to_family)| {
                barrier(def.buffer, 0..vk::WHOLE_SIZE, from, to)
                    .src_queue_family_index(from_family)
                    .dst_queue_family_index(to_family)
            };
            // The other family makes its own accesses available and visible.
            r.before.push(transfer((none, def.queue_family), (SHADER_WRITE, gpu.family)));
            r.after.push(transfer((SHADER_WRITE, gpu.family), (none, def.queue_family)));
            (r.from, r.to) = (r.from | def.before.stages, r.to | def.after.stages);
        }
        Ok(())
    }

    fn dispatches(&self, commands: vk::CommandBuffer, slot: &FrameSlot, jobs: &[Job<'_, Target>]) -> Result<(), Error> {
        let (device, layout) = (&self.gpu.device, self.pipelines.layout);
        let (mut bound, mut previous) = (None, None);
        for d in &self.plan.dispatches {
            let binding = d.key.binding;
            if previous.replace(binding.handle) == Some(binding.handle) {
                // These are other vertices of the same buffer. Validation layers cannot know that, and it is rare.
                let all = [barrier(binding.handle, 0..vk::WHOLE_SIZE, SHADER_WRITE, SHADER_WRITE)];
                cmd_barrier(&self.gpu, commands, (COMPUTE, COMPUTE), &all);
            }
            let window = self.hosts.get(binding.buffer)?.windows[binding.window].set.handle;
            let state = jobs[d.job].target.classic.as_ref().filter(|_| d.classic());
            let sets = [slot.sets[&d.key.chunk].handle, window, state.map_or(window, |s| s.set)];
            let sets = if d.classic() { &sets[..] } else { &sets[..2] };
            let pipeline = self.pipelines.pipelines[&d.variant];
            let (point, compute) = (vk::PipelineBindPoint::COMPUTE, vk::ShaderStageFlags::COMPUTE);
            // SAFETY: as above. The handles are alive until the frame is done.
            unsafe {
                if bound.replace(pipeline) != Some(pipeline) {
                    device.cmd_bind_pipeline(commands, point, pipeline);
                }
                device.cmd_bind_descriptor_sets(commands, point, layout, 0, sets, &[]);
                device.cmd_push_constants(commands, layout, compute, 0, bytes_of(&d.call));
                device.cmd_dispatch(commands, d.groups[0], d.groups[1], 1);
            }
        }
        Ok(())
    }
}

/// A barrier for these bytes of a buffer that stays with its queue family.
fn barrier(
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
fn cmd_barrier(
    gpu: &VulkanDevice,
    commands: vk::CommandBuffer,
    (from, to): (vk::PipelineStageFlags, vk::PipelineStageFlags),
    barriers: &[vk::BufferMemoryBarrier<'_>],
) {
    let none = vk::DependencyFlags::empty();
    // SAFETY: the command buffer is recording.
    unsafe { gpu.device.cmd_pipeline_barrier(commands, from, to, none, &[], barriers, &[]) };
}

/// The error, naming the job.
fn of_job(error: Error, job: usize) -> Error {
    match error {
        Error::InvalidArgument { name, value, expected } => {
            Error::InvalidArgument { name: format!("{name} of job {job}"), value, expected }
        }
        other => other,
    }
}
