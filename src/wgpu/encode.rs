//! Encodes a frame: a copy, and a compute pass with dispatches for what changed.

use super::device::Device;
use super::target::Target;
use crate::base::error::Error;
use crate::gpu::{Call, FrameReport, Job, Plan, Variant};
use bytemuck::cast_ref;

const CALL_WORDS: usize = size_of::<Call>() / 4;

impl Device {
    /// Encodes what brings the targets up to date: only the blocks that changed since each was last written. If nothing changed,
    /// nothing is encoded. The encoder is of this device; a copy and a compute pass are added to it.
    ///
    /// Each command buffer is submitted once, in the order of encoding. If one is never submitted, call [`Target::invalidate`] on
    /// its targets.
    ///
    /// Buffers and bind groups are only made when more encodings are in flight, or more changes in a frame, than ever before
    /// ([`Device::objects_made`]). Staging memory comes back when wgpu is polled, which every submission does.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a target of another device or set; [`Error::WrongRule`] for an instance with a classic
    /// rule at another level of detail than 0; [`Error::Unsupported`] for more work than the device can bind;
    /// [`Error::OutOfMemory`], [`Error::DeviceLost`], [`Error::Wgpu`]. After an error nothing is encoded, and targets hold what
    /// they held.
    pub fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        jobs: &mut [Job<'_, Target>],
    ) -> Result<FrameReport, Error> {
        self.gpu.reported_error()?;
        self.plan.check(jobs)?;
        self.free_meshes();
        let (gpu, one) = (&self.gpu, &self.pipelines.one);
        Plan::add_states(jobs, &gpu.binding_limits(), |_, bytes| {
            let buffer = gpu.buffer("a classic rule's state", bytes, wgpu::BufferUsages::STORAGE)?;
            gpu.bind_group(one, &[wgpu::BufferBinding { buffer: &buffer, offset: 0, size: None }])
        })?;
        let mut report = self.plan.fill(jobs)?;
        if report.blocks_written > 0 {
            self.write_words(jobs);
            report.bytes_copied = 4 * self.words.len() as u64;
            self.belt.reserve(&self.gpu, report.bytes_copied)?;
            for dispatch in &self.plan.dispatches {
                self.pipelines.add(&self.gpu, dispatch.variant)?;
                let chunk = dispatch.key.chunk;
                self.belt.add_group((&self.gpu, &self.pipelines), chunk, self.arena.buffer(chunk))?;
            }
            self.belt.copy(&self.gpu, encoder, &self.words)?;
            self.dispatch(encoder, jobs);
        }
        report.vertices_written = self.plan.commit(jobs, 0);
        Ok(report)
    }

    /// Encodes into a command buffer of its own and submits it. Nothing waits for the device; what is submitted later sees the
    /// vertices.
    ///
    /// # Errors
    /// As [`Device::encode`]. After [`Error::Wgpu`] from the submission (a buffer was destroyed or is mapped), all targets are
    /// written anew next time.
    pub fn submit(&mut self, jobs: &mut [Job<'_, Target>]) -> Result<FrameReport, Error> {
        let descriptor = wgpu::CommandEncoderDescriptor { label: Some("crumple") };
        let mut encoder =
            self.gpu.checked("making a command encoder", 0, || self.gpu.device.create_command_encoder(&descriptor))?;
        let report = self.encode(&mut encoder, jobs)?;
        if report.dispatches > 0 {
            let submitted = self.gpu.checked("submitting", 0, || self.gpu.queue.submit([encoder.finish()]));
            if submitted.is_err() {
                jobs.iter_mut().for_each(|j| j.target.invalidate());
            }
            submitted?;
        }
        Ok(report)
    }

    /// Words of the frame's data before the call of a dispatch.
    fn call_at(&self, dispatch: usize) -> usize {
        let align = self.gpu.limits.min_uniform_buffer_offset_alignment.max(4) as usize / 4;
        self.plan.words.next_multiple_of(align) + dispatch * CALL_WORDS.next_multiple_of(align)
    }

    /// Writes the frame's data and behind it the calls of its dispatches, of which there are some.
    fn write_words(&mut self, jobs: &[Job<'_, Target>]) {
        let last = self.call_at(self.plan.dispatches.len() - 1);
        let mut words = std::mem::take(&mut self.words);
        words.clear();
        words.resize(last + CALL_WORDS, 0);
        self.plan.write(jobs, &mut words);
        for (i, d) in self.plan.dispatches.iter().enumerate() {
            words[self.call_at(i)..][..CALL_WORDS].copy_from_slice(cast_ref::<Call, [u32; CALL_WORDS]>(&d.call));
        }
        self.words = words;
    }

    /// Encodes the compute pass. Nothing here fails.
    fn dispatch(&self, encoder: &mut wgpu::CommandEncoder, jobs: &[Job<'_, Target>]) {
        let descriptor = wgpu::ComputePassDescriptor { label: Some("crumple"), timestamp_writes: None };
        let mut pass = encoder.begin_compute_pass(&descriptor);
        let mut bound: Option<Variant> = None;
        for (i, d) in self.plan.dispatches.iter().enumerate() {
            if bound.replace(d.variant) != Some(d.variant) {
                pass.set_pipeline(&self.pipelines.pipelines[&d.variant]);
            }
            let target = &*jobs[d.job].target;
            pass.set_bind_group(0, &self.belt.groups[&d.key.chunk], &[4 * self.call_at(i) as u32]);
            pass.set_bind_group(1, &target.own.group, &[]);
            if let Some(state) = target.classic.as_ref().filter(|_| d.classic()) {
                pass.set_bind_group(2, state, &[]);
            }
            pass.dispatch_workgroups(d.groups[0], d.groups[1], 1);
        }
    }
}
