//! Records a frame: copies, barriers and dispatches for what changed.

use super::device::{Device, VulkanDevice};
use super::frames::FrameSlot;
use super::host::{BufferId, HostBuffers, Target};
use crate::Error;
use crate::gpu::{self, Call, FrameReport, Job, Plan, PlanTarget, TargetState, WorkOffsets};
use ash::vk::{self, Handle};
use std::ops::Range;
use std::ptr::null;

/// A target to bring up to date.
/// <!--
/// cbindgen:ignore
/// -->
pub type RecordJob<'a> = Job<'a, Target>;

/// What was recorded.
pub type RecordReport = FrameReport;

/// The part of a host's buffer that a dispatch writes. Ids of one VkBuffer lie side by side.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct TargetBinding {
    handle: vk::Buffer,
    buffer: BufferId,
    window: usize,
}

impl PlanTarget for Target {
    type Binding = TargetBinding;

    fn binding(&self) -> TargetBinding {
        TargetBinding { handle: self.handle, buffer: self.buffer, window: self.window }
    }

    fn state(&self) -> &TargetState {
        &self.state
    }

    fn state_mut(&mut self) -> &mut TargetState {
        &mut self.state
    }
}

/// The lists of a recording. They are reused.
#[derive(Default)]
pub(super) struct Recording {
    plan: Plan<TargetBinding>,
    /// Buffers that another queue family owns.
    foreign: Vec<BufferId>,
    before: Vec<vk::BufferMemoryBarrier<'static>>,
    after: Vec<vk::BufferMemoryBarrier<'static>>,
}

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
    /// **Changed state of the command buffer**: the compute pipeline, the compute descriptor sets 0 to 2, and the first 24 bytes
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
        jobs: &mut [RecordJob<'_>],
    ) -> Result<RecordReport, Error> {
        if commands.is_null() {
            return Err(Error::invalid("the VkCommandBuffer", "null", "a valid handle"));
        }
        if frame <= self.completed || frame < self.recorded {
            let expected = format!("above {}, the last completed, and no less than {}", self.completed, self.recorded);
            return Err(Error::invalid("frame", frame, &expected));
        }
        let mut recording = std::mem::take(&mut self.recording);
        let recorded = self.record_jobs(&mut recording, (commands, frame), jobs);
        self.recording = recording;
        recorded
    }

    fn record_jobs(
        &mut self,
        r: &mut Recording,
        (commands, frame): (vk::CommandBuffer, u64),
        jobs: &mut [RecordJob<'_>],
    ) -> Result<RecordReport, Error> {
        gpu::check(jobs, self.id)?;
        r.foreign.clear();
        for (j, job) in jobs.iter_mut().enumerate() {
            let host = self.hosts.get(job.target.buffer).map_err(|e| of_job(e, j))?;
            if self.gpu.foreign(&host.def) {
                r.foreign.push(job.target.buffer);
            }
            self.add_state(job)?;
        }
        r.foreign.sort_unstable();
        r.foreign.dedup();
        let mut report = r.plan.fill(jobs)?;
        if report.blocks_written > 0 {
            let offsets = r.plan.offsets()?;
            let slot = self.fill(&r.plan, &offsets)?;
            report.bytes_copied = self.commands(r, (commands, frame), (slot, &offsets), jobs)?;
        } else if !r.foreign.is_empty() {
            self.pass_on(r, (commands, frame))?;
        }
        report.vertices_written = r.plan.commit(jobs, |target| {
            target.state.mesh.used_in(frame);
            target.written_in = frame;
        });
        Ok(report)
    }

    /// Takes a slot, writes the frame's data into it, and adds the descriptor sets that it lacks.
    fn fill(&mut self, plan: &Plan<TargetBinding>, offsets: &WorkOffsets) -> Result<usize, Error> {
        let slot = self.slot(offsets.bytes())?;
        for dispatch in plan.dispatches() {
            self.add_slot_set(slot, dispatch.chunk())?;
        }
        self.gpu.write(&mut self.slots[slot].staging, offsets.words(), |to| plan.write(to))?;
        Ok(slot)
    }

    /// Records the commands of a frame that writes something. Returns the number of bytes that are copied. Everything that can
    /// fail was done before, except for look-ups that were checked.
    fn commands(
        &mut self,
        r: &mut Recording,
        (commands, frame): (vk::CommandBuffer, u64),
        (slot, offsets): (usize, &WorkOffsets),
        jobs: &[RecordJob<'_>],
    ) -> Result<u64, Error> {
        self.slots[slot].frame = frame;
        self.recorded = frame;
        r.before.clear();
        r.after.clear();
        let bytes_copied = self.copies(r, (commands, frame), (slot, offsets.bytes()));
        let (mut from, mut to) = (COMPUTE | vk::PipelineStageFlags::TRANSFER, vk::PipelineStageFlags::empty());
        let mut previous = None;
        for dispatch in r.plan.dispatches() {
            let binding = dispatch.binding();
            let host = self.hosts.get_mut(binding.buffer)?;
            host.used = frame;
            if self.gpu.foreign(&host.def) || previous.replace(binding) == Some(binding) {
                continue;
            }
            // The barrier covers everything that is bound: the kernel decides what of it is written. It also orders writes of
            // earlier recordings before these.
            let bytes = &host.windows[binding.window].range;
            let access = host.def.before.access | SHADER_WRITE;
            r.before.push(barrier(binding.handle, bytes.clone(), access, SHADER_WRITE));
            r.after.push(barrier(binding.handle, bytes.clone(), SHADER_WRITE, host.def.after.access));
            from |= host.def.before.stages;
            to |= host.def.after.stages;
        }
        let (first, last) = acquire_and_release(&mut self.hosts, &self.gpu, r, frame)?;
        (from, to) = (from | first, to | last);
        for dispatch in r.plan.dispatches().iter().filter(|d| d.classic()) {
            let Some(state) = &jobs[dispatch.job].target.classic else { continue };
            state.used_in(frame);
            let (read, write) = (vk::AccessFlags::SHADER_READ, SHADER_WRITE);
            r.before.push(barrier(state.handle(), 0..vk::WHOLE_SIZE, write, read | write));
        }
        cmd_barrier(&self.gpu, commands, (from, COMPUTE), &r.before);
        self.dispatches(&r.plan, commands, (&self.slots[slot], offsets), jobs)?;
        cmd_barrier(&self.gpu, commands, (COMPUTE, to), &r.after);
        Ok(bytes_copied)
    }

    /// Records the copies of new meshes and of the frame's data, and adds their barriers. Returns the number of bytes.
    fn copies(
        &mut self,
        r: &mut Recording,
        (commands, frame): (vk::CommandBuffer, u64),
        (slot, bytes): (usize, u64),
    ) -> u64 {
        let (f, slot) = (&self.gpu.functions, &self.slots[slot]);
        let mut total = 0;
        let mut copy = |from: vk::Buffer, to: vk::Buffer, at: u64, size: u64| {
            let region = vk::BufferCopy { src_offset: 0, dst_offset: at, size };
            // SAFETY: the command buffer is recording, as `record` demands. So everywhere in this file. The ranges lie within
            // both buffers.
            unsafe { (f.cmd_copy_buffer)(commands, from, to, 1, &region) };
            total += size;
            let (write, read) = (vk::AccessFlags::TRANSFER_WRITE, vk::AccessFlags::SHADER_READ);
            r.before.push(barrier(to, at..at + size, write, read));
        };
        self.arena.record(frame, |staging, chunk, at, size| copy(staging.handle, chunk.handle, at, size));
        copy(slot.staging.handle, slot.storage.handle, 0, bytes);
        total
    }

    fn dispatches(
        &self,
        plan: &Plan<TargetBinding>,
        commands: vk::CommandBuffer,
        (slot, offsets): (&FrameSlot, &WorkOffsets),
        jobs: &[RecordJob<'_>],
    ) -> Result<(), Error> {
        let (f, pipelines) = (&self.gpu.functions, &self.pipelines);
        let most = self.gpu.limits.max_compute_work_group_count[0];
        let (mut bound, mut previous) = (None, None);
        for d in plan.dispatches() {
            let binding = d.binding();
            if previous.replace(binding.handle) == Some(binding.handle) {
                // These are other vertices of the same buffer. Validation layers cannot know that, and it is rare.
                let all = [barrier(binding.handle, 0..vk::WHOLE_SIZE, SHADER_WRITE, SHADER_WRITE)];
                cmd_barrier(&self.gpu, commands, (COMPUTE, COMPUTE), &all);
            }
            let (call, [across, rows]) = offsets.call((&d.blocks, d.classic()), self.workgroup, most);
            let window = self.hosts.get(binding.buffer)?.windows[binding.window].set.handle;
            let state = jobs[d.job].target.classic.as_ref().filter(|_| d.classic());
            let sets = [slot.set(d.chunk()).handle, window, state.map_or(window, |s| s.set())];
            let count = if d.classic() { 3 } else { 2 };
            let pipeline = pipelines.get(d.kernel, d.classic());
            let (point, compute) = (vk::PipelineBindPoint::COMPUTE, vk::ShaderStageFlags::COMPUTE);
            // SAFETY: as above. The handles are alive until the frame is done.
            unsafe {
                if bound.replace(pipeline) != Some(pipeline) {
                    (f.cmd_bind_pipeline)(commands, point, pipeline);
                }
                let layout = pipelines.layout;
                (f.cmd_bind_descriptor_sets)(commands, point, layout, 0, count, sets.as_ptr(), 0, null());
                let size = size_of::<Call>() as u32;
                (f.cmd_push_constants)(commands, layout, compute, 0, size, (&raw const call).cast());
                (f.cmd_dispatch)(commands, across, rows, 1);
            }
        }
        Ok(())
    }

    /// Records the acquire and the release of buffers that another queue family owns, for a frame that writes nothing.
    fn pass_on(&mut self, r: &mut Recording, (commands, frame): (vk::CommandBuffer, u64)) -> Result<(), Error> {
        r.before.clear();
        r.after.clear();
        let (from, to) = acquire_and_release(&mut self.hosts, &self.gpu, r, frame)?;
        self.recorded = frame;
        cmd_barrier(&self.gpu, commands, (from, COMPUTE), &r.before);
        cmd_barrier(&self.gpu, commands, (COMPUTE, to), &r.after);
        Ok(())
    }
}

/// Adds barriers that acquire and release the buffers of other queue families. Returns the stages before and after.
fn acquire_and_release(
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

fn cmd_barrier(
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

/// The error, naming the job.
fn of_job(error: Error, job: usize) -> Error {
    match error {
        Error::InvalidArgument { name, value, expected } => {
            Error::InvalidArgument { name: format!("{name} of job {job}"), value, expected }
        }
        other => other,
    }
}
