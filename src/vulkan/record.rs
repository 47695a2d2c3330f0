//! Records a frame: copies, barriers and dispatches for what changed.

use super::classic::ClassicBuffer;
use super::device::Device;
use super::frames::{FrameSlot, free_slot};
use super::recording::{COMPUTE, Recording, SHADER_WRITE, acquire_and_release, barrier, cmd_barrier};
use super::target::{Target, TargetBinding};
use crate::base::error::Error;
use crate::gpu::{Call, Case, FrameReport, Job, Plan, WorkOffsets, missing_state};
use ash::vk::{self, Handle};
use std::ptr::null;
use std::sync::Arc;

/// A target to bring up to date.
/// <!--
/// cbindgen:ignore
/// -->
pub type RecordJob<'a> = Job<'a, Target>;

/// What was recorded.
pub type RecordReport = FrameReport;

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
        Plan::check(jobs, self.id)?;
        r.foreign.clear();
        for (j, job) in jobs.iter_mut().enumerate() {
            let host = self.hosts.get(job.target.buffer).map_err(|e| of_job(e, j))?;
            if self.gpu.foreign(host.def.queue_family) {
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

    /// Makes the state and the pipeline that a target of an instance with a classic rule lacks.
    fn add_state(&mut self, job: &mut RecordJob<'_>) -> Result<(), Error> {
        let Some(bytes) = missing_state(job, job.target.classic.is_some()) else { return Ok(()) };
        self.gpu.add_pipeline(&mut self.pipelines, job.target.state.variant(Case::Classic))?;
        let state = Arc::new(ClassicBuffer::new(&self.gpu, &self.pipelines, bytes)?);
        self.states.push(state.clone());
        job.target.classic = Some(state);
        // The new buffer holds no state, whatever the vertices show.
        job.target.state.tracker.invalidate();
        Ok(())
    }

    /// Takes a slot, writes the frame's data into it, and adds the descriptor sets that it lacks.
    fn fill(&mut self, plan: &Plan<TargetBinding>, offsets: &WorkOffsets) -> Result<usize, Error> {
        let index = free_slot(&mut self.slots, &self.gpu, self.completed, offsets.bytes())?;
        let slot = &mut self.slots[index];
        for dispatch in plan.dispatches() {
            let chunk = dispatch.chunk();
            slot.add_set((&self.gpu, &self.pipelines), chunk, self.arena.buffer(chunk))?;
        }
        self.gpu.write(&mut slot.staging, offsets.words(), |to| plan.write(to))?;
        Ok(index)
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
            if self.gpu.foreign(host.def.queue_family) || previous.replace(binding) == Some(binding) {
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
            let (call, [across, rows]) = offsets.call(&d.blocks, d.variant.vertices(self.workgroup), most);
            let window = self.hosts.get(binding.buffer)?.windows[binding.window].set.handle;
            let state = jobs[d.job].target.classic.as_ref().filter(|_| d.classic());
            let sets = [slot.set(d.chunk()).handle, window, state.map_or(window, |s| s.set())];
            let count = if d.classic() { 3 } else { 2 };
            let pipeline = pipelines.get(d.variant);
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

/// The error, naming the job.
fn of_job(error: Error, job: usize) -> Error {
    match error {
        Error::InvalidArgument { name, value, expected } => {
            Error::InvalidArgument { name: format!("{name} of job {job}"), value, expected }
        }
        other => other,
    }
}
