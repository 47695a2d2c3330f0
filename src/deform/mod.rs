//! Deformation on the CPU: dirty blocks of any number of outputs, evaluated in parallel, written into the caller's memory.

mod evaluate;
mod memory;
mod tracker;

pub use memory::{Attribute, RawStream, VertexMemory};
pub use tracker::Tracker;

use crate::anchored::block_range;
use crate::tasks::run_each;
use crate::{Aabb, Error, Instance, TaskSystem};
use glam::Vec3;
use memory::Scattered;

/// Blocks a task evaluates, at most.
const BLOCKS_A_TASK: usize = 8;

/// One output to bring up to date.
#[derive(Debug)]
pub struct DeformJob<'a, 'm> {
    /// The instance; hits must have been folded ([`Instance::fold`]), others wait for the next time.
    pub instance: &'a Instance,
    /// What the memory holds already.
    pub tracker: &'a mut Tracker,
    /// Where to write.
    pub memory: VertexMemory<'m>,
}

/// What a deform did.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct DeformReport {
    /// Vertices written, over all outputs.
    pub vertices_written: u64,
    /// Blocks of 128 vertices written.
    pub blocks_written: u64,
    /// Blocks that were up to date.
    pub blocks_skipped: u64,
}

/// Brings outputs up to date: evaluates the blocks that changed since each was last written, and writes those only. Work
/// is balanced by blocks over all outputs.
///
/// # Errors
/// [`Error::BufferTooSmall`], or [`Error::Unsupported`] for normals or tangents that the mesh does not have. They name the
/// output; nothing is written then.
pub fn deform(jobs: &mut [DeformJob<'_, '_>], tasks: &dyn TaskSystem) -> Result<DeformReport, Error> {
    for job in jobs.iter() {
        check(job)?;
    }
    let dirty: Vec<Vec<usize>> = jobs.iter().map(|j| j.tracker.dirty(j.instance.changes()).collect()).collect();
    let total: usize = dirty.iter().map(Vec::len).sum();
    let mut report = DeformReport::default();
    let items: Vec<(usize, usize)> =
        dirty.iter().enumerate().flat_map(|(j, blocks)| blocks.iter().map(move |b| (j, *b))).collect();
    let mut bounds = vec![Aabb::EMPTY; total];
    {
        let slots = Scattered::new(&mut bounds);
        let jobs = &*jobs;
        let chunk = total.div_ceil(tasks.workers().max(1) * 4).clamp(1, BLOCKS_A_TASK);
        run_each(tasks, total.div_ceil(chunk), &|t| {
            for (i, (job, block)) in items.iter().enumerate().skip(t * chunk).take(chunk) {
                let b = write_block(&jobs[*job], *block);
                // SAFETY: item `i` belongs to this task alone, and `run_each` runs a task once.
                unsafe { slots.set(i, b) };
            }
        });
    }
    let mut at = 0;
    for (job, blocks) in jobs.iter_mut().zip(&dirty) {
        job.tracker.written(job.instance, blocks, &bounds[at..at + blocks.len()]);
        at += blocks.len();
        report.blocks_written += blocks.len() as u64;
        report.blocks_skipped += (job.instance.changes().blocks.len() - blocks.len()) as u64;
        report.vertices_written += job.tracker.changed().iter().map(|r| u64::from(r.end - r.start)).sum::<u64>();
    }
    Ok(report)
}

impl Instance {
    /// Folds the hits that have arrived and brings one output up to date.
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
        deform(&mut [DeformJob { instance: self, tracker, memory }], tasks)
    }
}

fn check(job: &DeformJob<'_, '_>) -> Result<(), Error> {
    let mesh = job.instance.example_set().mesh();
    if job.memory.has_normals() && mesh.normals().is_none() {
        return Err(Error::Unsupported {
            what: "a normal output: the mesh has neither normals nor triangles to compute them from".into(),
        });
    }
    if job.memory.has_tangents() && mesh.tangents().is_none() {
        return Err(Error::Unsupported { what: "a tangent output: the mesh has no tangents".into() });
    }
    job.memory.check_size(mesh.positions().len())
}

fn write_block(job: &DeformJob<'_, '_>, b: usize) -> Aabb {
    let set = job.instance.example_set();
    let tangents = job.memory.has_tangents() && set.mesh().normals().is_some();
    let block = evaluate::block(job.instance, b, job.memory.has_normals() || tangents);
    let first = block_range(b, set.vertex_count()).start;
    for i in 0..block.len {
        let (p, n) = (block.positions[i], block.normals[i]);
        let t = job.memory.has_tangents().then(|| evaluate::tangent(set, first + i, n));
        // SAFETY: `check` passed for all vertices; the blocks of an output are distinct and outputs do not overlap.
        unsafe { job.memory.write(first + i, p, n, t) };
    }
    Aabb::of(&block.positions[..block.len])
}

/// Position (m) and unit normal of one vertex as deformed.
pub(crate) fn displaced(instance: &Instance, v: usize) -> (Vec3, Option<Vec3>) {
    evaluate::vertex(instance, v)
}
