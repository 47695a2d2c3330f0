//! Deforms instances into the caller's memory.

use super::{Instance, ShapeState};
use crate::base::error::{Error, reserve};
use crate::base::tasks::{TaskSystem, map};
use crate::deform::view::{DamageView, Shape};
use crate::deform::{DeformReport, Output, Tracker, VertexMemory, evaluate, write_outputs};
use glam::Vec3;

/// One output to bring up to date.
#[derive(Debug)]
pub struct DeformJob<'a, 'm> {
    /// The mesh: 0 is the set's own; its levels of detail follow in the order in which they were added
    /// ([`crate::ExampleSet::add_lod`]).
    pub lod: usize,
    /// The instance. Only folded hits count ([`Instance::fold`]).
    pub instance: &'a Instance,
    /// Records what the memory holds.
    pub tracker: &'a mut Tracker,
    /// The memory to write to.
    pub memory: VertexMemory<'m>,
}

/// Turns the hits that have arrived at these instances into damage, several instances at a time: the same as [`Instance::fold`] of
/// each.
pub fn fold_all<'a>(instances: impl IntoIterator<Item = &'a mut Instance>, tasks: &dyn TaskSystem) {
    let mut waiting = instances.into_iter().filter(|instance| !instance.inbox.queue().pending.is_empty());
    let Some(first) = waiting.next() else { return };
    match waiting.next() {
        Some(second) => drop(map(tasks, [first, second].into_iter().chain(waiting), Instance::fold)),
        None => first.fold(),
    }
}

/// Evaluates the blocks that changed since each output was last written, and writes only those. Work is balanced by
/// blocks over all outputs. An output that is up to date costs one comparison.
///
/// # Errors
/// [`Error::IndexOutOfRange`] for a level of detail that the set does not have; [`Error::WrongRule`] for a level of
/// detail of an instance with a classic rule, whose state exists for the base mesh only; [`Error::BufferTooSmall`];
/// [`Error::Unsupported`] for normals or tangents that the mesh does not have. Errors name the output. Memory that is up to
/// date is not checked. After an error nothing has been written.
pub fn deform(jobs: &mut [DeformJob<'_, '_>], tasks: &dyn TaskSystem) -> Result<DeformReport, Error> {
    deform_within(jobs, u64::MAX, tasks)
}

/// The same as [`deform`] for a frame that has time for `budget` vertices. Outputs are written whole or not at all: first
/// those whose waiting would be seen most, by the vertices to write, the calls that they have waited, and how near they
/// are ([`Instance::set_view`]). Others wait for later calls and get the same vertices then. Does
/// not let wait what holds nothing of its instance yet, and always writes at least one output.
///
/// # Errors
/// Those of [`deform`].
pub fn deform_within(
    jobs: &mut [DeformJob<'_, '_>],
    budget: u64,
    tasks: &dyn TaskSystem,
) -> Result<DeformReport, Error> {
    let mut changed = 0;
    for job in jobs.iter_mut().filter(|job| !is_current(job)) {
        let output = output(job)?;
        output.check()?;
        changed += usize::from(output.is_dirty());
    }
    // Outputs without changes need no memory, so a frame without changes allocates nothing.
    let mut outputs = reserve(changed, "deform jobs")?;
    let mut skipped = 0;
    for job in jobs.iter_mut() {
        if is_current(job) {
            job.tracker.unchanged();
            skipped += job.instance.example_set().lod(job.lod)?.blocks() as u64;
            continue;
        }
        let mut output = output(job)?;
        if output.is_dirty() {
            outputs.push(output);
        } else {
            skipped += output.skip();
        }
    }
    let mut report = write_outputs(&mut outputs, budget, tasks)?;
    report.blocks_skipped += skipped;
    Ok(report)
}

/// Whether the memory holds the instance's vertices: most of those of a frame do.
fn is_current(job: &DeformJob<'_, '_>) -> bool {
    let changes = &job.instance.changes;
    job.tracker.since(changes, job.lod) == Some(changes.epoch)
}

fn output<'j>(job: &'j mut DeformJob<'_, '_>) -> Result<Output<'j, 'j>, Error> {
    let mesh = job.instance.example_set().lod(job.lod)?;
    if job.lod > 0 {
        job.instance.only_marks("a deform of another level of detail than 0")?;
    }
    Ok(Output { view: job.instance.view(), lod: job.lod, mesh, tracker: job.tracker, memory: &job.memory })
}

impl Instance {
    /// Folds the hits that have arrived and updates one output.
    ///
    /// # Errors
    /// Those of [`deform`].
    pub fn deform(
        &mut self,
        tracker: &mut Tracker,
        memory: VertexMemory<'_>,
        tasks: &dyn TaskSystem,
    ) -> Result<DeformReport, Error> {
        self.fold();
        deform(&mut [DeformJob { lod: 0, instance: self, tracker, memory }], tasks)
    }

    /// Returns the deformed position of vertex `v`, m, as [`Instance::deform`] would write it. Hits that have not been
    /// folded yet do not count.
    ///
    /// # Errors
    /// [`Error::IndexOutOfRange`].
    pub fn displaced(&self, v: u32) -> Result<Vec3, Error> {
        let vertices = self.example_set().vertex_count();
        if v as usize >= vertices {
            return Err(Error::IndexOutOfRange { name: "vertex".into(), index: v.into(), len: vertices as u64 });
        }
        Ok(self.vertex(v).0)
    }

    /// Deformed position (m) and unit normal of vertex `v`, which must exist.
    pub(crate) fn vertex(&self, v: u32) -> (Vec3, Option<Vec3>) {
        evaluate::vertex(&self.view(), self.example_set().base_lod(), v as usize)
    }

    /// What evaluation needs of the instance.
    pub(crate) fn view(&self) -> DamageView<'_> {
        let shape = match &self.shape {
            ShapeState::Nodes(nodes) => Shape::Nodes(nodes.view()),
            ShapeState::Classic(state) => Shape::Vertices(state.vertices()),
        };
        DamageView { set: &self.set, depth_limit: self.limit, unseen: self.unseen, changes: &self.changes, shape }
    }
}
