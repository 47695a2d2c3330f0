//! Encodes a frame: a copy, and a compute pass with dispatches for what changed.

use super::device::Device;
use super::frame_encoding::FrameEncoding;
use super::target::Target;
use crate::base::error::Error;
use crate::gpu::{FrameReport, Job, Plan, Variant, missing_state};

/// A target to bring up to date.
/// <!--
/// cbindgen:ignore
/// -->
pub type EncodeJob<'a> = Job<'a, Target>;

/// What was encoded.
pub type EncodeReport = FrameReport;

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
        jobs: &mut [EncodeJob<'_>],
    ) -> Result<EncodeReport, Error> {
        self.reported_error()?;
        let mut encoding = std::mem::take(&mut self.encoding);
        let encoded = self.encode_jobs(&mut encoding, encoder, jobs);
        self.encoding = encoding;
        encoded
    }

    /// Encodes into a command buffer of its own and submits it. Nothing waits for the device; what is submitted later sees the
    /// vertices.
    ///
    /// # Errors
    /// As [`Device::encode`]. After [`Error::Wgpu`] from the submission (a buffer was destroyed or is mapped), all targets are
    /// written anew next time.
    pub fn submit(&mut self, jobs: &mut [EncodeJob<'_>]) -> Result<EncodeReport, Error> {
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

    fn encode_jobs(
        &mut self,
        e: &mut FrameEncoding,
        encoder: &mut wgpu::CommandEncoder,
        jobs: &mut [EncodeJob<'_>],
    ) -> Result<EncodeReport, Error> {
        Plan::check(jobs, self.id)?;
        self.free_meshes();
        for job in jobs.iter_mut() {
            self.add_state(job)?;
        }
        let mut report = e.plan.fill(jobs)?;
        if report.blocks_written > 0 {
            e.write(&self.gpu, self.workgroup)?;
            self.belt.reserve(&self.gpu, 4 * e.words.len() as u64)?;
            for dispatch in e.plan.dispatches() {
                self.pipelines.add(&self.gpu, dispatch.variant)?;
                let chunk = dispatch.chunk();
                self.belt.add_group((&self.gpu, &self.pipelines), chunk, self.arena.buffer(chunk))?;
            }
            self.belt.copy(&self.gpu, encoder, &e.words)?;
            report.bytes_copied = 4 * e.words.len() as u64;
            self.dispatch(encoder, e, jobs);
        }
        report.vertices_written = e.plan.commit(jobs, |_| ());
        Ok(report)
    }

    /// Makes the state that a target of an instance with a classic rule lacks.
    fn add_state(&mut self, job: &mut EncodeJob<'_>) -> Result<(), Error> {
        let Some(bytes) = missing_state(job, job.target.classic.is_some()) else { return Ok(()) };
        self.gpu.binding_limits().check("a classic rule's state", bytes)?;
        let buffer = self.gpu.buffer("a classic rule's state", bytes, wgpu::BufferUsages::STORAGE)?;
        let whole = wgpu::BufferBinding { buffer: &buffer, offset: 0, size: None };
        job.target.classic = Some(self.gpu.bind_group(&self.pipelines.one, &[whole])?);
        // The new buffer holds no state, whatever the vertices show.
        job.target.state.tracker.invalidate();
        Ok(())
    }

    /// Encodes the compute pass. Nothing here fails.
    fn dispatch(&self, encoder: &mut wgpu::CommandEncoder, e: &FrameEncoding, jobs: &[EncodeJob<'_>]) {
        let descriptor = wgpu::ComputePassDescriptor { label: Some("crumple"), timestamp_writes: None };
        let mut pass = encoder.begin_compute_pass(&descriptor);
        let mut bound: Option<Variant> = None;
        for (d, call) in e.plan.dispatches().iter().zip(&e.calls) {
            let target = &*jobs[d.job].target;
            let wanted = d.variant;
            let (Some(pipeline), Some(group)) = (self.pipelines.get(wanted), self.belt.group(d.chunk())) else {
                continue;
            };
            if bound.replace(wanted) != Some(wanted) {
                pass.set_pipeline(pipeline);
            }
            pass.set_bind_group(0, group, &[call.at]);
            pass.set_bind_group(1, &target.bound.group, &[]);
            if let Some(state) = target.classic.as_ref().filter(|_| d.classic()) {
                pass.set_bind_group(2, state, &[]);
            }
            let [across, rows] = call.groups;
            pass.dispatch_workgroups(across, rows, 1);
        }
    }
}
