//! A frame's plan: which jobs have something to write, in which dispatches, and with which data.

use super::BLOCK_VERTICES;
use super::kernel::{Case, Kernel, Variant};
use super::layout::Call;
use super::limits::BindingLimits;
use super::target::{Target, TargetState};
use super::work::{FrameWork, Shown};
use crate::base::error::Error;
use crate::base::math::Aabb;
use crate::deform::budget::{Due, waiting};
use crate::deform::view::{DamageView, Shape};
use crate::instance::Instance;
use bytemuck::Zeroable;
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

/// A target to bring up to date. `T` is the backend's target.
#[derive(Debug)]
pub struct Job<'a, T> {
    /// The instance. Hits must have been folded ([`Instance::fold`]); others wait for the next time.
    pub instance: &'a Instance,
    /// Where its vertices go.
    pub target: &'a mut T,
}

/// What a frame writes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct FrameReport {
    /// Vertices that will be written, over all targets.
    pub vertices_written: u64,
    /// Blocks of 128 vertices that will be written.
    pub blocks_written: u64,
    /// Blocks that were up to date.
    pub blocks_skipped: u64,
    /// Dispatches. There is one for each buffer, or more if the device cannot bind the buffer or all examples at once, and one
    /// for each target of an instance with a classic rule.
    pub dispatches: u32,
    /// Bytes that are copied to the device for this frame. Recording also counts those of new meshes.
    pub bytes_copied: u64,
    /// Vertices that wait for a later frame because of the device's vertex budget.
    pub vertices_waiting: u64,
}

/// What the targets of one dispatch have in common. (A dispatch for targets with packed and unpacked outputs would
/// need a variant that none of them has.)
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct DispatchKey<B> {
    pub binding: B,
    /// The arena's chunk that it reads.
    pub chunk: u32,
    packed: bool,
    /// The job, for an instance with a classic rule: no other has its state.
    classic: Option<u32>,
}

/// A dispatch.
#[derive(Debug)]
pub(crate) struct Dispatch<B> {
    pub key: DispatchKey<B>,
    /// The first of its jobs.
    pub job: usize,
    pub variant: Variant,
    blocks: Range<usize>,
    pub call: Call,
    /// Workgroups in a row, and rows.
    pub groups: [u32; 2],
}

impl<B> Dispatch<B> {
    pub(crate) fn classic(&self) -> bool {
        self.variant.case == Case::Classic
    }
}

/// A job whose instance changed since its target was written.
#[derive(Debug)]
struct PlannedJob<B> {
    key: DispatchKey<B>,
    job: usize,
    /// A box that will hold its vertices.
    bounds: Aabb,
    /// The blocks to write, among those of the frame.
    blocks: Range<usize>,
}

/// The plan of a frame. Its lists are reused from frame to frame.
#[derive(Debug)]
pub(crate) struct Plan<B> {
    /// Distinguishes its targets from those of other plans.
    pub id: u64,
    /// The most vertices to write in a frame; see [`crate::deform_within`].
    pub budget: u64,
    /// Invocations a workgroup that the host asks for, and the most workgroups in a row.
    workgroup: u32,
    most_groups: u32,
    work: FrameWork,
    /// Size of the frame's data in words.
    pub words: usize,
    waiting: Vec<Due>,
    jobs: Vec<PlannedJob<B>>,
    /// Those with one binding lie side by side.
    pub dispatches: Vec<Dispatch<B>>,
}

impl<B: Copy + Ord> Plan<B> {
    /// Dispatches have at most `most_groups` workgroups in a row, of as many invocations as `workgroup` says.
    pub(crate) fn new(workgroup: u32, most_groups: u32) -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(1);
        Plan {
            id: NEXT.fetch_add(1, Ordering::Relaxed),
            budget: u64::MAX,
            workgroup,
            most_groups,
            work: FrameWork::default(),
            words: 0,
            waiting: Vec::new(),
            jobs: Vec::new(),
            dispatches: Vec::new(),
        }
    }

    /// Fails if a job's target is another device's or another set's, or if its classic rule cannot be shown on its mesh.
    pub(crate) fn check<S, X>(&self, jobs: &[Job<'_, Target<B, S, X>>]) -> Result<(), Error> {
        for (j, Job { instance, target }) in jobs.iter().enumerate() {
            let target = &target.state;
            if target.device != self.id {
                let expected = "a target of this device";
                return Err(Error::invalid(&format!("target of job {j}"), "of another device", expected));
            }
            if !target.mesh.is_of(instance.example_set()) {
                let expected = "an instance of the target's set";
                return Err(Error::invalid(&format!("instance of job {j}"), "of another example set", expected));
            }
            if target.mesh.lod > 0 {
                instance.only_marks("a target of another level of detail than 0")?;
            }
        }
        Ok(())
    }

    /// Gives targets of instances with a classic rule the states that they lack. `make` makes one of a size in bytes.
    #[cfg(any(feature = "vulkan", feature = "wgpu"))]
    pub(crate) fn add_states<S, X>(
        jobs: &mut [Job<'_, Target<B, S, X>>],
        limits: &BindingLimits,
        mut make: impl FnMut(&TargetState, u64) -> Result<S, Error>,
    ) -> Result<(), Error> {
        for Job { instance, target } in jobs {
            if instance.classic_state().is_some() && target.classic.is_none() {
                let vertices = instance.example_set().vertex_count() as u64;
                let bytes = vertices * target.state.layout.kernel().state_bytes();
                limits.check("a classic rule's state", bytes)?;
                target.classic = Some(make(&target.state, bytes)?);
                // The new buffer holds no state, whatever the vertices show.
                target.state.tracker.invalidate();
            }
        }
        Ok(())
    }

    /// Plans jobs that were checked. Every target of an instance with a classic rule has its state.
    ///
    /// # Errors
    /// [`Error::Unsupported`] for more work than the kernels can address.
    pub(crate) fn fill<S, X>(&mut self, jobs: &[Job<'_, Target<B, S, X>>]) -> Result<FrameReport, Error> {
        let mut report = FrameReport::default();
        self.work.clear();
        self.jobs.clear();
        self.dispatches.clear();
        self.find_waiting(jobs);
        report.vertices_waiting = self.waiting.iter().map(|due| due.vertices).sum();
        let waits = |job: usize| self.waiting.binary_search_by_key(&job, |due| due.output).is_ok();
        for (job, Job { instance, target }) in jobs.iter().enumerate().filter(|(job, _)| !waits(*job)) {
            let (state, changes) = (&target.state, instance.view().changes);
            let lod = state.mesh.lod;
            if state.tracker.since(changes, lod) != Some(changes.epoch) {
                let classic = instance.classic_state().map(|_| job as u32);
                let (chunk, packed) = (state.mesh.chunk, state.layout.packed());
                let key = DispatchKey { binding: target.binding, chunk, packed, classic };
                self.jobs.push(PlannedJob { key, job, bounds: Aabb::EMPTY, blocks: 0..0 });
            } else {
                report.blocks_skipped += changes.blocks[lod].len() as u64;
            }
        }
        self.jobs.sort_unstable_by_key(|p| (p.key, p.job));
        for planned in &mut self.jobs {
            let Job { instance, target } = &jobs[planned.job];
            let target = &target.state;
            let lod = target.mesh.lod;
            let mesh = instance.example_set().lod(lod)?;
            let view = instance.view();
            planned.blocks = self.work.add_blocks(target.tracker.dirty(view.changes, lod));
            report.blocks_written += planned.blocks.len() as u64;
            report.blocks_skipped += (mesh.blocks() - planned.blocks.len()) as u64;
            if planned.blocks.is_empty() {
                continue;
            }
            let shown = Shown { view, mesh, target };
            let case = if planned.key.classic.is_some() { Case::Classic } else { Case::Nodes };
            planned.bounds = match (view.shape, instance.classic_state()) {
                (Shape::Nodes(nodes), _) => self.work.add_nodes(shown, planned.job, &nodes, &planned.blocks),
                (_, Some(state)) => {
                    let since = target.tracker.since(view.changes, lod);
                    let with_normals = target.layout.kernel() > Kernel::Positions;
                    self.work.add_classic(shown, (state, instance.blend_constant()), with_normals, since)
                }
                (Shape::Vertices(_), None) => Aabb::EMPTY,
            };
            match self.dispatches.last_mut().filter(|d| d.key == planned.key) {
                Some(dispatch) => {
                    dispatch.blocks.end = planned.blocks.end;
                    dispatch.variant.kernel = dispatch.variant.kernel.max(target.layout.kernel());
                }
                None => {
                    let (key, job, blocks) = (planned.key, planned.job, planned.blocks.clone());
                    let (variant, call, groups) = (target.layout.variant(case), Call::zeroed(), [0; 2]);
                    self.dispatches.push(Dispatch { key, job, variant, blocks, call, groups });
                }
            }
        }
        report.dispatches = self.dispatches.len() as u32;
        let vertices = report.blocks_written * u64::from(BLOCK_VERTICES);
        if vertices > u64::from(u32::MAX) {
            let what = format!("{vertices} vertices in one frame; at most 4294967295");
            return Err(Error::Unsupported { what });
        }
        let (words, [nodes, classic]) = self.work.layout()?;
        self.words = words;
        for d in &mut self.dispatches {
            let call = if d.classic() { classic } else { nodes };
            (d.call, d.groups) = call.of(&d.blocks, d.variant.vertices(self.workgroup), self.most_groups);
        }
        Ok(report)
    }

    /// Finds the jobs that wait, if there are more vertices to write than the budget has.
    fn find_waiting<S, X>(&mut self, jobs: &[Job<'_, Target<B, S, X>>]) {
        let views: Vec<DamageView<'_>> =
            if self.budget == u64::MAX { Vec::new() } else { jobs.iter().map(|j| j.instance.view()).collect() };
        let states = jobs.iter().map(|j| &j.target.state);
        self.waiting = waiting(self.budget, states.zip(&views).map(|(s, view)| (&s.tracker, view, s.mesh.lod)));
    }

    /// Writes the frame's data. The jobs are those that were planned.
    pub(crate) fn write<S, X>(&self, jobs: &[Job<'_, Target<B, S, X>>], to: &mut [u32]) {
        let steps = |job: usize| match jobs[job].instance.view().shape {
            Shape::Nodes(nodes) => nodes.steps,
            Shape::Vertices(_) => &[],
        };
        self.work.write(steps, to);
    }

    /// Notes what each target will hold once the frame has run. Returns the number of vertices. `frame` is 0 on backends that do not
    /// number frames.
    pub(crate) fn commit<S, X>(&self, jobs: &mut [Job<'_, Target<B, S, X>>], frame: u64) -> u64 {
        let mut vertices = 0;
        for job in jobs.iter_mut() {
            job.target.state.tracker.unchanged();
        }
        for due in &self.waiting {
            jobs[due.output].target.state.tracker.waits();
        }
        for planned in self.jobs.iter().filter(|p| !p.blocks.is_empty()) {
            let Job { instance, target } = &mut jobs[planned.job];
            let TargetState { mesh, tracker, written_in, .. } = &mut target.state;
            let Ok(lod) = instance.example_set().lod(mesh.lod) else { continue };
            let of = (instance.view().changes, mesh.lod, lod.vertex_count());
            vertices += tracker.recorded(of, self.work.listed(&planned.blocks), planned.bounds);
            mesh.used_in(frame);
            *written_in = frame;
        }
        vertices
    }
}
