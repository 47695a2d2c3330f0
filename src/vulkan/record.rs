//! A frame: what changed, as commands.

use super::device::{Device, Gpu};
use super::host::{BufferId, Hosts, Target};
use crate::gpu::{Call, Frame, Kernel, Offsets, Shown};
use crate::{Aabb, Error, Instance};
use ash::vk::{self, Handle};
use std::ops::Range;
use std::ptr::null;
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// Invocations a block: its vertices.
const BLOCK: u64 = crate::mesh::vertex_blocks::BLOCK as u64;

/// One target to bring up to date.
#[derive(Debug)]
pub struct RecordJob<'a> {
    /// The instance; hits must have been folded ([`Instance::fold`]), others wait for the next time.
    pub instance: &'a Instance,
    /// Where its vertices go.
    pub target: &'a mut Target,
}

/// What was recorded.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct RecordReport {
    /// Vertices that will be written, over all targets.
    pub vertices_written: u64,
    /// Blocks of 128 vertices that will be written.
    pub blocks_written: u64,
    /// Blocks that were up to date.
    pub blocks_skipped: u64,
    /// Examples of marks that the instances' tolerances left out of blocks written.
    pub parts_skipped: u64,
    /// Dispatches: one for each VkBuffer, times the pieces that it or the examples on the device must be cut into; and one for
    /// each target of an instance with a classic rule.
    pub dispatches: u32,
    /// Bytes that are copied to the device for this frame, those of new meshes among them.
    pub bytes_copied: u64,
}

/// What a recording works with, used over and over.
#[derive(Default)]
pub(super) struct Scratch {
    frame: Frame,
    /// Jobs with something to write, those of one dispatch side by side.
    order: Vec<(Key, u32)>,
    /// Of each of these a box that will hold its vertices, and the places of its blocks in the frame.
    shown: Vec<(Aabb, Range<usize>)>,
    dispatches: Vec<Dispatch>,
    /// Windows that are written.
    writes: Vec<(BufferId, usize)>,
    /// Buffers that another queue family owns.
    transfers: Vec<BufferId>,
    before: Vec<vk::BufferMemoryBarrier<'static>>,
    after: Vec<vk::BufferMemoryBarrier<'static>>,
}

/// What one dispatch has in common.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Key {
    handle: vk::Buffer,
    buffer: BufferId,
    window: usize,
    /// Of the arena.
    chunk: u32,
    /// Of an instance with a classic rule the job itself, which alone has its state.
    classic: Option<u32>,
}

struct Dispatch {
    key: Key,
    kernel: Kernel,
    blocks: Range<usize>,
}

impl Device {
    /// Records what brings the targets up to date: the blocks that changed since each was last written, and those only. Where
    /// nothing changed, nothing is recorded.
    ///
    /// `frame` is the host's number of the frame, from 1 on; it never falls, and several recordings may have the same. The
    /// command buffer, primary or secondary, is in the recording state, outside a render pass, of a pool of the device's queue
    /// family, and is submitted once, before or together with what the next recording goes into.
    ///
    /// **Left changed in the command buffer**: the compute pipeline, the compute descriptor sets 0 to 2, and the first 24 bytes
    /// of the push constants of stage compute. Nothing else.
    ///
    /// Buffers, memory and descriptor sets are only made while more recordings are in flight, or more changes in a frame, than
    /// ever before ([`Device::objects_made`]).
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a null command buffer, a frame that is done or below the last, a target of another device,
    /// set or removed buffer; [`Error::WrongRule`] for an instance with a classic rule at
    /// another level of detail than 0, whose state is the base mesh's; [`Error::Unsupported`] for more work than
    /// the device can bind; [`Error::OutOfMemory`], [`Error::Vulkan`], [`Error::DeviceLost`]. Nothing is recorded then, and
    /// targets hold what they held.
    ///
    /// # Safety
    /// The command buffer is as said above, one of this device, and no other thread uses its pool meanwhile.
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
        let mut scratch = std::mem::take(&mut self.scratch);
        let mut recorded = self.prepare(&mut scratch, jobs).and_then(|mut report| {
            if report.blocks_written > 0 {
                let (slot, offsets) = self.fill(&scratch)?;
                self.commands(&mut scratch, (commands, frame), (slot, offsets), jobs, &mut report)?;
            } else if !scratch.transfers.is_empty() {
                self.pass(&mut scratch, (commands, frame))?;
            }
            Ok(report)
        });
        if let Ok(report) = &mut recorded {
            report.vertices_written = written(&scratch, jobs, frame);
        }
        self.scratch = scratch;
        recorded
    }

    /// Checks all jobs and packs what they have to write.
    fn prepare(&mut self, s: &mut Scratch, jobs: &mut [RecordJob<'_>]) -> Result<RecordReport, Error> {
        let mut report = RecordReport::default();
        s.frame.clear();
        s.order.clear();
        s.shown.clear();
        s.dispatches.clear();
        s.writes.clear();
        s.transfers.clear();
        for (j, job) in jobs.iter().enumerate() {
            self.check(job).map_err(|e| named(e, j))?;
        }
        for (j, job) in jobs.iter_mut().enumerate() {
            self.add_state(job.instance, job.target)?;
            let (target, changes) = (&job.target, job.instance.view().changes);
            let (buffer, window) = (target.buffer, target.window);
            let def = &self.hosts.get(buffer)?.def;
            if self.gpu.foreign(def) {
                s.transfers.push(buffer);
            }
            if target.tracker.dirty(changes, target.lod).next().is_some() {
                let handle = def.buffer;
                let classic = job.instance.classic_state().map(|_| j as u32);
                s.order.push((Key { handle, buffer, window, chunk: target.home.chunk, classic }, j as u32));
            } else {
                report.blocks_skipped += changes.blocks[target.lod].len() as u64;
            }
        }
        s.order.sort_unstable();
        s.transfers.sort_unstable();
        s.transfers.dedup();
        for (key, j) in &s.order {
            let RecordJob { instance, target } = &jobs[*j as usize];
            let skin = instance.example_set().lod(target.lod)?;
            let (place, normals) = (&target.home.place, target.kernel > Kernel::Positions);
            if s.dispatches.last().is_none_or(|d| d.key != *key) {
                let blocks = s.frame.blocks()..s.frame.blocks();
                s.dispatches.push(Dispatch { key: *key, kernel: Kernel::Positions, blocks });
            }
            if s.writes.last() != Some(&(key.buffer, key.window)) {
                s.writes.push((key.buffer, key.window));
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
        let invocations = report.blocks_written * BLOCK;
        if invocations > u64::from(u32::MAX) {
            let what = format!("{invocations} vertices in one recording; at most 4294967295");
            return Err(Error::Unsupported { what });
        }
        Ok(report)
    }

    fn check(&self, job: &RecordJob<'_>) -> Result<(), Error> {
        let RecordJob { instance, target } = job;
        if target.device != self.id {
            return Err(Error::invalid("target", "of another device", "a target of this device"));
        }
        self.hosts.get(target.buffer)?;
        if !std::ptr::eq(target.set.as_ptr(), Arc::as_ptr(instance.example_set())) {
            return Err(Error::invalid("instance", "of another example set", "an instance of the target's set"));
        }
        if target.lod > 0 && instance.classic_state().is_some() {
            return Err(instance.needs_marks("a recording of another level of detail than 0"));
        }
        Ok(())
    }

    /// Takes a slot, writes the frame's words into it, and makes sure that it has its sets.
    fn fill(&mut self, s: &Scratch) -> Result<(usize, Offsets), Error> {
        let offsets = s.frame.offsets()?;
        let slot = self.slot(4 * offsets.total as u64)?;
        for d in &s.dispatches {
            self.add_slot_set(slot, d.key.chunk)?;
        }
        self.gpu.write(&mut self.slots[slot].staging, offsets.total, |to| s.frame.write(to))?;
        Ok((slot, offsets))
    }

    /// The commands themselves: nothing here fails but for what is checked first.
    fn commands(
        &mut self,
        s: &mut Scratch,
        (commands, frame): (vk::CommandBuffer, u64),
        (slot, offsets): (usize, Offsets),
        jobs: &[RecordJob<'_>],
        report: &mut RecordReport,
    ) -> Result<(), Error> {
        let (f, kernels) = (&self.gpu.functions, &self.kernels);
        let slot = &mut self.slots[slot];
        slot.frame = frame;
        self.recorded = frame;
        s.before.clear();
        s.after.clear();
        let copy = |from: vk::Buffer, to: vk::Buffer, (src, dst, size): (u64, u64, u64)| {
            let region = vk::BufferCopy { src_offset: src, dst_offset: dst, size };
            // SAFETY: the command buffer is recording, by the terms of `record`; so everywhere below. The ranges lie within
            // both buffers.
            unsafe { (f.cmd_copy)(commands, from, to, 1, &region) };
            barrier(to, dst..dst + size, vk::AccessFlags::TRANSFER_WRITE, vk::AccessFlags::SHADER_READ)
        };
        self.arena.record(frame, |staging, chunk, copies| {
            for c in copies {
                s.before.push(copy(staging.handle, chunk.handle, *c));
                report.bytes_copied += c.2;
            }
        });
        let bytes = 4 * offsets.total as u64;
        s.before.push(copy(slot.staging.handle, slot.storage.handle, (0, 0, bytes)));
        report.bytes_copied += bytes;

        // What the host did before, our own writes of an earlier recording, and copies.
        let own = vk::PipelineStageFlags::COMPUTE_SHADER;
        let (mut from, mut to) = (own | vk::PipelineStageFlags::TRANSFER, vk::PipelineStageFlags::empty());
        for (buffer, window) in &s.writes {
            let host = self.hosts.get_mut(*buffer)?;
            host.used = frame;
            if self.gpu.foreign(&host.def) {
                continue;
            }
            // All that is bound, since nobody but us knows what of it is written.
            let (handle, bytes) = (host.def.buffer, &host.windows[*window].range);
            let shader = vk::AccessFlags::SHADER_WRITE;
            s.before.push(barrier(handle, bytes.clone(), host.def.before.access | shader, shader));
            s.after.push(barrier(handle, bytes.clone(), shader, host.def.after.access));
            from |= host.def.before.stages;
            to |= host.def.after.stages;
        }
        let (first, last) = transfers(&mut self.hosts, &self.gpu, s, frame)?;
        (from, to) = (from | first, to | last);
        let state = |d: &Dispatch| d.key.classic.and_then(|j| jobs[j as usize].target.state.as_ref());
        for state in s.dispatches.iter().filter_map(state) {
            state.use_in(frame);
            let (read, write) = (vk::AccessFlags::SHADER_READ, vk::AccessFlags::SHADER_WRITE);
            s.before.push(barrier(state.handle(), 0..vk::WHOLE_SIZE, write, read | write));
        }
        cmd_barrier(&self.gpu, commands, (from, own), &s.before);
        let mut bound = None;
        let mut previous: Option<vk::Buffer> = None;
        for d in &s.dispatches {
            let window = &self.hosts.get(d.key.buffer)?.windows[d.key.window];
            if previous == Some(d.key.handle) {
                // Other vertices of the same buffer; no validation layer can know that, and it is rare.
                let access = vk::AccessFlags::SHADER_WRITE;
                cmd_barrier(
                    &self.gpu,
                    commands,
                    (own, own),
                    &[barrier(d.key.handle, 0..vk::WHOLE_SIZE, access, access)],
                );
            }
            previous = Some(d.key.handle);
            let most = self.gpu.limits.max_compute_work_group_count[0];
            let (call, [across, rows]) = offsets.call(&d.blocks, self.workgroup, most);
            let sets =
                [slot.set(d.key.chunk).handle, window.set.handle, state(d).map_or(window.set.handle, |s| s.set())];
            let (count_of_sets, pipeline) = match d.key.classic {
                Some(_) => (3, kernels.pipeline(d.kernel, true)),
                None => (2, kernels.pipeline(d.kernel, false)),
            };
            let (point, compute) = (vk::PipelineBindPoint::COMPUTE, vk::ShaderStageFlags::COMPUTE);
            // SAFETY: as above; handles are alive, and stay so until the frame is done.
            unsafe {
                if bound != Some(pipeline) {
                    (f.cmd_bind_pipeline)(commands, point, pipeline);
                    bound = Some(pipeline);
                }
                (f.cmd_bind_sets)(commands, point, kernels.layout, 0, count_of_sets, sets.as_ptr(), 0, null());
                let size = size_of::<Call>() as u32;
                (f.cmd_push_constants)(commands, kernels.layout, compute, 0, size, call.as_ptr().cast());
                (f.cmd_dispatch)(commands, across, rows, 1);
            }
        }
        cmd_barrier(&self.gpu, commands, (own, to), &s.after);
        Ok(())
    }

    /// Where nothing changed: takes buffers that another queue family owns, and gives them back.
    fn pass(&mut self, s: &mut Scratch, (commands, frame): (vk::CommandBuffer, u64)) -> Result<(), Error> {
        s.before.clear();
        s.after.clear();
        let (from, to) = transfers(&mut self.hosts, &self.gpu, s, frame)?;
        self.recorded = frame;
        let own = vk::PipelineStageFlags::COMPUTE_SHADER;
        cmd_barrier(&self.gpu, commands, (from, own), &s.before);
        cmd_barrier(&self.gpu, commands, (own, to), &s.after);
        Ok(())
    }
}

/// Adds acquires and releases of buffers that another queue family owns; answers the stages before and after.
fn transfers(
    hosts: &mut Hosts,
    gpu: &Gpu,
    s: &mut Scratch,
    frame: u64,
) -> Result<(vk::PipelineStageFlags, vk::PipelineStageFlags), Error> {
    let (mut from, mut to) = (vk::PipelineStageFlags::empty(), vk::PipelineStageFlags::empty());
    for buffer in &s.transfers {
        let host = hosts.get_mut(*buffer)?;
        host.used = frame;
        let (def, ours) = (host.def, gpu.family);
        let (shader, none) = (vk::AccessFlags::SHADER_WRITE, vk::AccessFlags::empty());
        let transfer = |(from, from_family), (to, to_family)| {
            barrier(def.buffer, 0..vk::WHOLE_SIZE, from, to)
                .src_queue_family_index(from_family)
                .dst_queue_family_index(to_family)
        };
        // What the other family did it made available itself, and what it does it makes visible itself.
        s.before.push(transfer((none, def.queue_family), (shader, ours)));
        s.after.push(transfer((shader, ours), (none, def.queue_family)));
        (from, to) = (from | def.before.stages, to | def.after.stages);
    }
    Ok((from, to))
}

/// Notes what each target will hold; answers how many vertices are written.
fn written(s: &Scratch, jobs: &mut [RecordJob<'_>], frame: u64) -> u64 {
    let mut vertices = 0;
    for job in jobs.iter_mut() {
        job.target.tracker.unchanged();
    }
    for ((_, j), (bounds, blocks)) in s.order.iter().zip(&s.shown) {
        let RecordJob { instance, target } = &mut jobs[*j as usize];
        let Ok(skin) = instance.example_set().lod(target.lod) else { continue };
        let of = (instance.view().changes, target.lod, skin.vertex_count());
        vertices += target.tracker.recorded(of, s.frame.listed(blocks), *bounds);
        target.home.used.fetch_max(frame, Ordering::Relaxed);
        target.written_in = frame;
    }
    vertices
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
    gpu: &Gpu,
    commands: vk::CommandBuffer,
    (from, to): (vk::PipelineStageFlags, vk::PipelineStageFlags),
    barriers: &[vk::BufferMemoryBarrier<'_>],
) {
    let (none, count) = (vk::DependencyFlags::empty(), barriers.len() as u32);
    let f = gpu.functions.cmd_barrier;
    // SAFETY: the command buffer is recording.
    unsafe { f(commands, from, to, none, 0, null(), count, barriers.as_ptr(), 0, null()) };
}

/// The error, telling which job.
fn named(error: Error, job: usize) -> Error {
    match error {
        Error::InvalidArgument { name, value, expected } => {
            Error::InvalidArgument { name: format!("{name} of job {job}"), value, expected }
        }
        other => other,
    }
}
