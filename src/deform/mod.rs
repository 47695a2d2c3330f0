//! Deformation on the CPU: dirty blocks of any number of outputs, evaluated in parallel, written into the caller's memory.

pub(crate) mod evaluate;
pub(crate) mod kernel;
mod levels;
mod memory;
mod tracker;

pub use memory::{Attribute, RawStream, VertexMemory};
pub use tracker::Tracker;

pub(crate) use levels::longest;

use crate::anchored::{BLOCK, block_range};
use crate::skin::Skin;
use crate::tasks::run_each;
use crate::{Aabb, Error, Instance, TaskSystem};
use glam::Vec3;
use memory::Scattered;
use std::sync::atomic::{AtomicU64, Ordering};

/// Blocks a task evaluates, at most …
const BLOCKS_A_TASK: usize = 64;
/// … and tasks a worker gets, at least, where there are so many blocks.
const PIECES: usize = 8;

/// One output to bring up to date.
#[derive(Debug)]
pub struct DeformJob<'a, 'm> {
    /// The mesh: 0 is the set's own, then its levels of detail in the order they were added ([`crate::ExampleSet::add_lod`]).
    pub lod: usize,
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
    /// Examples of marks that the instances' tolerances left out of blocks written, over all of these.
    pub parts_skipped: u64,
}

/// Brings outputs up to date: evaluates the blocks that changed since each was last written, and writes those only. Work
/// is balanced by blocks over all outputs; an output that is up to date costs a comparison.
///
/// # Errors
/// [`Error::IndexOutOfRange`] for a level of detail that the set does not have; [`Error::WrongRule`] for one of an instance with
/// a classic rule, whose state is the base mesh's; [`Error::BufferTooSmall`], or [`Error::Unsupported`] for normals or tangents
/// that the mesh does not have. They name the output; nothing is written then.
pub fn deform(jobs: &mut [DeformJob<'_, '_>], tasks: &dyn TaskSystem) -> Result<DeformReport, Error> {
    for job in jobs.iter() {
        check(job)?;
    }
    // Job and block of each piece of work, job by job.
    let mut items: Vec<(u32, u32)> = Vec::new();
    for (j, job) in jobs.iter().enumerate() {
        let dirty = job.tracker.dirty(job.instance.changes(), job.lod);
        items.extend(dirty.map(|block| (j as u32, block as u32)));
    }
    let total = items.len();
    let mut bounds = vec![Aabb::EMPTY; total];
    let parts_skipped = AtomicU64::new(0);
    {
        let slots = Scattered::new(&mut bounds);
        let jobs = &*jobs;
        let chunk = total.div_ceil(tasks.workers().max(1) * PIECES).clamp(1, BLOCKS_A_TASK);
        run_each(tasks, total.div_ceil(chunk), &|t| {
            let from = t * chunk;
            let mut room =
                Room { evaluate: evaluate::Room::new(), positions: [0.0; 3 * BLOCK], normals: [0.0; 3 * BLOCK] };
            for (i, (job, block)) in items[from..(from + chunk).min(total)].iter().enumerate() {
                let job = &jobs[*job as usize];
                // `check` has passed: there is one.
                let Ok(skin) = job.skin() else { continue };
                let block = evaluate::Job { instance: job.instance, skin, block: *block as usize };
                // SAFETY: item `from + i` belongs to this task alone, and `run_each` runs a task once.
                let bounds = unsafe { slots.at(from + i) };
                write_block(job, block, &mut room, bounds);
            }
            parts_skipped.fetch_add(room.evaluate.left_out.into(), Ordering::Relaxed);
        });
    }
    let mut report = DeformReport { parts_skipped: parts_skipped.into_inner(), ..DeformReport::default() };
    let mut at = 0;
    for (j, job) in jobs.iter_mut().enumerate() {
        let count = items[at..].iter().take_while(|(job, _)| *job as usize == j).count();
        let written = at..at + count;
        at += count;
        let skin = job.skin()?;
        let (vertices, blocks) = (skin.vertex_count(), skin.blocks());
        job.tracker.written((job.instance, job.lod, vertices), &items[written.clone()], &bounds[written]);
        report.blocks_written += count as u64;
        report.blocks_skipped += (blocks - count) as u64;
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
        deform(&mut [DeformJob { lod: 0, instance: self, tracker, memory }], tasks)
    }
}

impl DeformJob<'_, '_> {
    fn skin(&self) -> Result<&Skin, Error> {
        self.instance.example_set().lod(self.lod)
    }
}

fn check(job: &DeformJob<'_, '_>) -> Result<(), Error> {
    let mesh = &job.skin()?.mesh;
    if job.lod > 0 && job.instance.classic_state().is_some() {
        return Err(job.instance.needs_marks("a deform of another level of detail than 0"));
    }
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

/// What a task needs of memory, used over and over.
struct Room<'a> {
    evaluate: evaluate::Room<'a>,
    positions: evaluate::Flat,
    normals: evaluate::Flat,
}

fn write_block<'a>(job: &'a DeformJob<'_, '_>, block: evaluate::Job<'a>, room: &mut Room<'a>, bounds: &mut Aabb) {
    let (skin, b) = (block.skin, block.block);
    let range = block_range(b, skin.vertex_count());
    let with_tangents = job.memory.has_tangents() && skin.mesh.normals().is_some();
    let n = 3 * range.len();
    let Room { evaluate: room, positions, normals } = room;
    let (positions, normals) = (&mut positions[..n], &mut normals[..n]);
    let wanted = (job.memory.has_normals() || with_tangents).then_some(&mut *normals);
    // SAFETY: `check` passed for all vertices; the blocks of an output are distinct and outputs do not overlap.
    match unsafe { job.memory.positions(range.clone()) } {
        Some(positions) => evaluate::block(block, room, positions, wanted, bounds),
        None => {
            evaluate::block(block, room, positions, wanted, bounds);
            // SAFETY: the same.
            unsafe { job.memory.write_positions(range.start, positions) };
        }
    }
    if job.memory.has_normals() {
        // SAFETY: the same.
        unsafe { job.memory.write_normals(range.start, normals) };
    }
    if job.memory.has_tangents() {
        for (i, n) in normals.chunks_exact(3).enumerate() {
            let tangent = evaluate::tangent(skin, range.start + i, Vec3::from_slice(n));
            // SAFETY: the same.
            unsafe { job.memory.write_tangent(range.start + i, tangent) };
        }
    }
}

/// Position (m) and unit normal of one vertex as deformed.
pub(crate) fn displaced(instance: &Instance, v: usize) -> (Vec3, Option<Vec3>) {
    evaluate::vertex(instance, instance.example_set().skin(), v)
}
