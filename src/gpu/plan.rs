//! A frame's plan: which jobs have something to write, in which dispatches, and with which data.

use super::BLOCK_VERTICES;
use super::kernel::{Case, Kernel, Variant};
use super::target::TargetState;
use super::work::{FrameWork, Shown, WorkOffsets};
use crate::base::error::Error;
use crate::base::math::Aabb;
use crate::deform::budget::{Due, waiting};
use crate::deform::view::{DamageView, Shape};
use crate::instance::Instance;
use std::ops::Range;
use std::sync::Arc;

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

/// A backend's target, as the plan sees it.
pub(crate) trait PlanTarget {
    /// The part of a host's buffer that a dispatch binds. Targets with equal bindings share dispatches.
    type Binding: Copy + Ord;
    fn binding(&self) -> Self::Binding;
    fn state(&self) -> &TargetState;
    fn state_mut(&mut self) -> &mut TargetState;
}

/// What the targets of one dispatch have in common. (A dispatch for targets with packed and unpacked outputs would
/// need a variant that none of them has.)
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct DispatchKey<B> {
    binding: B,
    /// The arena's chunk.
    chunk: u32,
    packed: bool,
    /// The job, for an instance with a classic rule: no other has its state.
    classic: Option<u32>,
}

/// A dispatch.
#[derive(Debug)]
pub(crate) struct Dispatch<B> {
    key: DispatchKey<B>,
    /// The first of its jobs.
    pub job: usize,
    pub variant: Variant,
    pub blocks: Range<usize>,
}

impl<B: Copy> Dispatch<B> {
    #[cfg(feature = "vulkan")]
    pub(crate) fn binding(&self) -> B {
        self.key.binding
    }

    /// Id of the arena's chunk that it reads.
    pub(crate) fn chunk(&self) -> u32 {
        self.key.chunk
    }

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
    /// The most vertices to write in a frame; see [`crate::deform_within`].
    pub budget: u64,
    work: FrameWork,
    waiting: Vec<Due>,
    jobs: Vec<PlannedJob<B>>,
    dispatches: Vec<Dispatch<B>>,
}

impl<B> Default for Plan<B> {
    fn default() -> Self {
        let work = FrameWork::default();
        Plan { budget: u64::MAX, work, waiting: Vec::new(), jobs: Vec::new(), dispatches: Vec::new() }
    }
}

/// The size in bytes of the state that a target needs on the device and does not have. `None` if it needs none.
pub(crate) fn missing_state<T: PlanTarget>(job: &Job<'_, T>, has_state: bool) -> Option<u64> {
    let needed = job.instance.classic_state().is_some() && !has_state;
    needed.then(|| job.instance.example_set().vertex_count() as u64 * job.target.state().kernel.state_bytes())
}

impl<B: Copy + Ord> Plan<B> {
    /// Fails if a job's target is another device's or another set's, or if its classic rule cannot be shown on its mesh.
    pub(crate) fn check<T: PlanTarget<Binding = B>>(jobs: &[Job<'_, T>], device: u64) -> Result<(), Error> {
        for (j, Job { instance, target }) in jobs.iter().enumerate() {
            let target = target.state();
            if target.device != device {
                let expected = "a target of this device";
                return Err(Error::invalid(&format!("target of job {j}"), "of another device", expected));
            }
            if !std::ptr::eq(target.set.as_ptr(), Arc::as_ptr(instance.example_set())) {
                let expected = "an instance of the target's set";
                return Err(Error::invalid(&format!("instance of job {j}"), "of another example set", expected));
            }
            if target.lod > 0 && instance.classic_state().is_some() {
                return Err(instance.needs_marks("a target of another level of detail than 0"));
            }
        }
        Ok(())
    }

    /// Plans jobs that were checked. Every target of an instance with a classic rule has its state.
    pub(crate) fn fill<T: PlanTarget<Binding = B>>(&mut self, jobs: &[Job<'_, T>]) -> Result<FrameReport, Error> {
        let mut report = FrameReport::default();
        self.work.clear();
        self.jobs.clear();
        self.dispatches.clear();
        self.find_waiting(jobs);
        report.vertices_waiting = self.waiting.iter().map(|due| due.vertices).sum();
        let waits = |job: usize| self.waiting.binary_search_by_key(&job, |due| due.output).is_ok();
        for (job, Job { instance, target }) in jobs.iter().enumerate().filter(|(job, _)| !waits(*job)) {
            let (state, changes) = (target.state(), instance.view().changes);
            if state.tracker.since(changes, state.lod) != Some(changes.epoch) {
                let classic = instance.classic_state().map(|_| job as u32);
                let (chunk, packed) = (state.mesh.chunk, state.layout.packed());
                let key = DispatchKey { binding: target.binding(), chunk, packed, classic };
                self.jobs.push(PlannedJob { key, job, bounds: Aabb::EMPTY, blocks: 0..0 });
            } else {
                report.blocks_skipped += changes.blocks[state.lod].len() as u64;
            }
        }
        self.jobs.sort_unstable_by_key(|p| (p.key, p.job));
        for planned in &mut self.jobs {
            let Job { instance, target } = &jobs[planned.job];
            let target = target.state();
            let mesh = instance.example_set().lod(target.lod)?;
            let view = instance.view();
            planned.blocks = self.work.add_blocks(target.tracker.dirty(view.changes, target.lod));
            report.blocks_written += planned.blocks.len() as u64;
            report.blocks_skipped += (mesh.blocks() - planned.blocks.len()) as u64;
            if planned.blocks.is_empty() {
                continue;
            }
            let shown = Shown { view, mesh, target };
            let case = if planned.key.classic.is_some() { Case::Classic } else { Case::Nodes };
            planned.bounds = match (view.shape, instance.classic_state()) {
                (Shape::Nodes(nodes), _) => self.work.add_nodes(shown, &nodes, &planned.blocks),
                (_, Some(state)) => {
                    let since = target.tracker.since(view.changes, target.lod);
                    let with_normals = target.kernel > Kernel::Positions;
                    self.work.add_classic(shown, (state, instance.blend_constant()), with_normals, since)
                }
                (Shape::Vertices(_), None) => Aabb::EMPTY,
            };
            match self.dispatches.last_mut().filter(|d| d.key == planned.key) {
                Some(dispatch) => {
                    dispatch.blocks.end = planned.blocks.end;
                    dispatch.variant.kernel = dispatch.variant.kernel.max(target.kernel);
                }
                None => {
                    let (key, job) = (planned.key, planned.job);
                    let variant = target.variant(case);
                    self.dispatches.push(Dispatch { key, job, variant, blocks: planned.blocks.clone() });
                }
            }
        }
        report.dispatches = self.dispatches.len() as u32;
        let vertices = report.blocks_written * u64::from(BLOCK_VERTICES);
        if vertices > u64::from(u32::MAX) {
            let what = format!("{vertices} vertices in one frame; at most 4294967295");
            return Err(Error::Unsupported { what });
        }
        Ok(report)
    }

    /// Finds the jobs that wait, if there are more vertices to write than the budget has.
    fn find_waiting<T: PlanTarget<Binding = B>>(&mut self, jobs: &[Job<'_, T>]) {
        let views: Vec<DamageView<'_>> =
            if self.budget == u64::MAX { Vec::new() } else { jobs.iter().map(|j| j.instance.view()).collect() };
        let states = jobs.iter().map(|j| j.target.state());
        self.waiting = waiting(self.budget, states.zip(&views).map(|(state, view)| (&state.tracker, view, state.lod)));
    }

    /// The dispatches. Those with one binding lie side by side.
    pub(crate) fn dispatches(&self) -> &[Dispatch<B>] {
        &self.dispatches
    }

    /// Where the frame's data will lie.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if it is too large.
    pub(crate) fn offsets(&self) -> Result<WorkOffsets, Error> {
        self.work.offsets()
    }

    /// Writes the frame's data: [`WorkOffsets::words`] words.
    pub(crate) fn write(&self, to: &mut [u32]) {
        self.work.write(to);
    }

    /// Notes what each target will hold once the frame has run, and calls `written` with each target that it writes. Returns the
    /// number of vertices.
    pub(crate) fn commit<T: PlanTarget>(&self, jobs: &mut [Job<'_, T>], mut written: impl FnMut(&mut T)) -> u64 {
        let mut vertices = 0;
        for job in jobs.iter_mut() {
            job.target.state_mut().tracker.unchanged();
        }
        for due in &self.waiting {
            jobs[due.output].target.state_mut().tracker.waits();
        }
        for planned in self.jobs.iter().filter(|p| !p.blocks.is_empty()) {
            let Job { instance, target } = &mut jobs[planned.job];
            let TargetState { lod, tracker, .. } = target.state_mut();
            let Ok(mesh) = instance.example_set().lod(*lod) else { continue };
            let of = (instance.view().changes, *lod, mesh.vertex_count());
            vertices += tracker.recorded(of, self.work.listed(&planned.blocks), planned.bounds);
            written(target);
        }
        vertices
    }
}
