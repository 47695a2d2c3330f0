//! A frame: what changed, as commands.

use super::device::Device;
use super::target::Target;
use crate::gpu::{Frame, Kernel, Shown};
use crate::mesh::vertex_blocks;
use crate::{Aabb, Error, Instance};
use std::ops::Range;
use std::sync::Arc;

/// Invocations a block: its vertices.
const BLOCK: u64 = vertex_blocks::BLOCK as u64;

/// One target to bring up to date.
#[derive(Debug)]
pub struct EncodeJob<'a> {
    /// The instance; hits must have been folded ([`Instance::fold`]), others wait for the next time.
    pub instance: &'a Instance,
    /// Where its vertices go.
    pub target: &'a mut Target,
}

/// What was encoded.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct EncodeReport {
    /// Vertices that will be written, over all targets.
    pub vertices_written: u64,
    /// Blocks of 128 vertices that will be written.
    pub blocks_written: u64,
    /// Blocks that were up to date.
    pub blocks_skipped: u64,
    /// Examples of marks that the instances' tolerances left out of blocks written.
    pub parts_skipped: u64,
    /// Dispatches: one for each buffer, times the pieces that it or the examples on the device must be cut into; and one for
    /// each target of an instance with a classic rule.
    pub dispatches: u32,
    /// Bytes that are copied to the device for this frame.
    pub bytes_copied: u64,
}

/// What an encoding works with, used over and over.
#[derive(Default)]
pub(super) struct Scratch {
    frame: Frame,
    /// Jobs with something to write, those of one dispatch side by side.
    order: Vec<(Key, u32)>,
    /// Of each of these a box that will hold its vertices, and the places of its blocks in the frame.
    shown: Vec<(Aabb, Range<usize>)>,
    dispatches: Vec<Dispatch>,
    /// The frame, and behind it a call for each dispatch.
    words: Vec<u32>,
}

/// What one dispatch has in common.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Key {
    window: u64,
    /// Of the arena.
    chunk: u32,
    /// Of an instance with a classic rule the job itself, which alone has its state.
    classic: Option<u32>,
}

struct Dispatch {
    key: Key,
    /// Any of its jobs.
    job: u32,
    kernel: Kernel,
    blocks: Range<usize>,
    /// Workgroups in a row, and rows.
    groups: [u32; 2],
    /// Bytes in front of its call.
    call: u32,
}

impl Device {
    /// Encodes what brings the targets up to date: the blocks that changed since each was last written, and those only. Where
    /// nothing changed, nothing is encoded. The encoder is of this device; a copy and a compute pass are added to it.
    ///
    /// Command buffers are submitted once, in the order of encoding. Of one that is never submitted its targets must be told by
    /// [`Target::invalidate`].
    ///
    /// Buffers and bind groups are only made while more encodings are in flight, or more changes in a frame, than ever before
    /// ([`Device::objects_made`]). Staging memory comes back when wgpu is polled, which every submission does.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a target of another device or set; [`Error::WrongRule`] for an instance with a classic
    /// rule at another level of detail than 0, whose state is the base mesh's; [`Error::Unsupported`] for more work than the
    /// device can bind; [`Error::OutOfMemory`], [`Error::DeviceLost`], [`Error::Wgpu`]. Nothing is encoded then, and targets
    /// hold what they held.
    pub fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        jobs: &mut [EncodeJob<'_>],
    ) -> Result<EncodeReport, Error> {
        self.heard()?;
        let mut scratch = std::mem::take(&mut self.scratch);
        let mut encoded = self.prepare(&mut scratch, jobs).and_then(|mut report| {
            if report.blocks_written > 0 {
                self.provide(&scratch, jobs)?;
                self.belt.copy(&self.gpu, encoder, &scratch.words)?;
                report.bytes_copied = 4 * scratch.words.len() as u64;
                self.dispatch(encoder, &scratch, jobs);
            }
            Ok(report)
        });
        if let Ok(report) = &mut encoded {
            report.vertices_written = written(&scratch, jobs);
        }
        self.scratch = scratch;
        encoded
    }

    /// Encodes into a command buffer of its own and submits it. Nothing waits for the device; what is submitted later sees the
    /// vertices.
    ///
    /// # Errors
    /// As [`Device::encode`]; after [`Error::Wgpu`] from the submission (a buffer that was destroyed or is mapped), targets are
    /// to be written anew.
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

    /// Checks all jobs and packs what they have to write.
    fn prepare(&mut self, s: &mut Scratch, jobs: &mut [EncodeJob<'_>]) -> Result<EncodeReport, Error> {
        let mut report = EncodeReport::default();
        s.frame.clear();
        s.order.clear();
        s.shown.clear();
        s.dispatches.clear();
        for (j, job) in jobs.iter().enumerate() {
            self.check(job, j)?;
        }
        for (j, job) in jobs.iter_mut().enumerate() {
            self.add_state(job.instance, job.target)?;
            let (target, changes) = (&job.target, job.instance.view().changes);
            if target.tracker.dirty(changes, target.lod).next().is_some() {
                let classic = job.instance.classic_state().map(|_| j as u32);
                let key = Key { window: target.window.id, chunk: target.home.chunk.id, classic };
                s.order.push((key, j as u32));
            } else {
                report.blocks_skipped += changes.blocks[target.lod].len() as u64;
            }
        }
        s.order.sort_unstable();
        for (key, j) in &s.order {
            let EncodeJob { instance, target } = &jobs[*j as usize];
            let skin = instance.example_set().lod(target.lod)?;
            let (place, normals) = (&target.home.place, target.kernel > Kernel::Positions);
            if s.dispatches.last().is_none_or(|d| d.key != *key) {
                let blocks = s.frame.blocks()..s.frame.blocks();
                let kernel = Kernel::Positions;
                s.dispatches.push(Dispatch { key: *key, job: *j, kernel, blocks, groups: [0; 2], call: 0 });
            }
            let shown = Shown { view: instance.view(), skin, place, layout: &target.layout, first: target.first };
            let bounds = match instance.classic_state() {
                Some(state) => {
                    let since = target.tracker.since(instance.view().changes, target.lod);
                    s.frame.classic_target(&shown, (state, instance.blend_constant()), normals, since)
                }
                None => s.frame.target(&shown),
            };
            let blocks = s.frame.add_blocks(target.tracker.dirty(instance.view().changes, target.lod));
            report.blocks_written += blocks.len() as u64;
            report.blocks_skipped += (skin.blocks() - blocks.len()) as u64;
            s.shown.push((bounds, blocks));
            if let Some(dispatch) = s.dispatches.last_mut() {
                dispatch.blocks.end = s.frame.blocks();
                dispatch.kernel = dispatch.kernel.max(target.kernel);
            }
        }
        report.parts_skipped = s.frame.left_out.into();
        report.dispatches = s.dispatches.len() as u32;
        if report.blocks_written > 0 {
            self.write(s, report.blocks_written * BLOCK)?;
        }
        Ok(report)
    }

    fn check(&self, job: &EncodeJob<'_>, j: usize) -> Result<(), Error> {
        let EncodeJob { instance, target } = job;
        if target.device != self.id {
            let expected = "a target of this device";
            return Err(Error::invalid(&format!("target of job {j}"), "of another device", expected));
        }
        if !std::ptr::eq(target.set.as_ptr(), Arc::as_ptr(instance.example_set())) {
            let expected = "an instance of the target's set";
            return Err(Error::invalid(&format!("instance of job {j}"), "of another example set", expected));
        }
        if target.lod > 0 && instance.classic_state().is_some() {
            return Err(instance.needs_marks("an encoding of another level of detail than 0"));
        }
        Ok(())
    }

    /// Makes sure that a target of an instance with a classic rule has a state.
    fn add_state(&mut self, instance: &Instance, target: &mut Target) -> Result<(), Error> {
        if instance.classic_state().is_none() || target.state.is_some() {
            return Ok(());
        }
        let vertices = instance.example_set().vertex_count() as u64;
        let bytes = vertices * target.kernel.state_bytes();
        let most = self.gpu.most_bound();
        if bytes > most {
            let what = format!(
                "a classic rule's state of {bytes} bytes; max_storage_buffer_binding_size is {most} on this device"
            );
            return Err(Error::Unsupported { what });
        }
        let buffer = self.gpu.buffer("a classic rule's state", bytes, wgpu::BufferUsages::STORAGE)?;
        let whole = wgpu::BufferBinding { buffer: &buffer, offset: 0, size: None };
        target.state = Some(self.gpu.bind_group(&self.kernels.one, &[whole])?);
        // What the memory may hold already says nothing about the state.
        target.tracker.invalidate();
        Ok(())
    }

    /// Lays the frame out in words, a call for each dispatch behind it.
    fn write(&self, s: &mut Scratch, invocations: u64) -> Result<(), Error> {
        if invocations > u64::from(u32::MAX) {
            let what = format!("{invocations} vertices in one encoding; at most 4294967295");
            return Err(Error::Unsupported { what });
        }
        let offsets = s.frame.offsets()?;
        let align = self.gpu.limits.min_uniform_buffer_offset_alignment.max(4) as usize / 4;
        let most = self.gpu.limits.max_compute_workgroups_per_dimension;
        s.words.clear();
        s.words.resize(offsets.total, 0);
        s.frame.write(&mut s.words);
        for d in &mut s.dispatches {
            let (call, groups) = offsets.call(&d.blocks, self.workgroup, most);
            d.groups = groups;
            s.words.resize(s.words.len().next_multiple_of(align), 0);
            d.call = (4 * s.words.len()) as u32;
            s.words.extend(call);
        }
        Ok(())
    }

    /// Makes what the dispatches need and is not there yet.
    fn provide(&mut self, s: &Scratch, jobs: &[EncodeJob<'_>]) -> Result<(), Error> {
        self.belt.reserve(&self.gpu, 4 * s.words.len() as u64)?;
        for d in &s.dispatches {
            self.kernels.add_pipeline(&self.gpu, d.kernel, d.key.classic.is_some())?;
            let chunk = &jobs[d.job as usize].target.home.chunk;
            self.belt.add_group((&self.gpu, &self.kernels, &self.arena), chunk)?;
        }
        Ok(())
    }

    /// The commands themselves: nothing here fails.
    fn dispatch(&self, encoder: &mut wgpu::CommandEncoder, s: &Scratch, jobs: &[EncodeJob<'_>]) {
        let descriptor = wgpu::ComputePassDescriptor { label: Some("crumple"), timestamp_writes: None };
        let mut pass = encoder.begin_compute_pass(&descriptor);
        let mut bound = None;
        for d in &s.dispatches {
            let target = &*jobs[d.job as usize].target;
            let classic = target.state.as_ref().filter(|_| d.key.classic.is_some());
            let pipeline = (d.kernel, classic.is_some());
            let (Some(kernel), Some(group)) = (self.kernels.pipeline(pipeline), self.belt.group(d.key.chunk)) else {
                continue;
            };
            if bound.replace(pipeline) != Some(pipeline) {
                pass.set_pipeline(kernel);
            }
            pass.set_bind_group(0, group, &[d.call]);
            pass.set_bind_group(1, &target.window.group, &[]);
            if let Some(state) = classic {
                pass.set_bind_group(2, state, &[]);
            }
            let [across, rows] = d.groups;
            pass.dispatch_workgroups(across, rows, 1);
        }
    }
}

/// Notes what each target will hold; answers how many vertices are written.
fn written(s: &Scratch, jobs: &mut [EncodeJob<'_>]) -> u64 {
    let mut vertices = 0;
    for job in jobs.iter_mut() {
        job.target.tracker.unchanged();
    }
    for ((_, j), (bounds, blocks)) in s.order.iter().zip(&s.shown) {
        let EncodeJob { instance, target } = &mut jobs[*j as usize];
        let Ok(skin) = instance.example_set().lod(target.lod) else { continue };
        let of = (instance.view().changes, target.lod, skin.vertex_count());
        vertices += target.tracker.recorded(of, s.frame.listed(blocks), *bounds);
    }
    vertices
}
