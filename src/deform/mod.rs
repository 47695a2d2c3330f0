//! Deformation on the CPU: computes vertices from nodes. Evaluates the dirty blocks of any number of outputs in
//! parallel and writes them into the caller's memory. Knows neither instances nor hits.

pub(crate) mod budget;
mod encoding;
pub(crate) mod evaluate;
pub(crate) mod follow;
pub(crate) mod kernel;
mod levels;
mod memory;
pub(crate) mod nodes;
pub(crate) mod simd;
mod tracker;
pub(crate) mod view;

pub use encoding::Encoding;
pub use memory::{Attribute, RawStream, VertexMemory};
pub use tracker::Tracker;

use crate::base::error::{Error, reserve};
use crate::base::math::Aabb;
use crate::base::tasks::{Serial, TaskSystem, map};
use crate::example::mesh_lod::MeshLod;
use crate::mesh::vertex_blocks::{BLOCK, block_range};
use glam::Vec3;
use view::DamageView;

/// The most blocks that one task evaluates.
const BLOCKS_A_TASK: usize = 64;
/// The fewest tasks per worker, if there are enough blocks.
const TASKS_A_WORKER: usize = 8;
/// Blocks below this, about 60 microseconds, are written on the caller's thread: waking another can take as long.
const SMALL: usize = 256;

/// What a deform did.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct DeformReport {
    /// Vertices written, over all outputs.
    pub vertices_written: u64,
    /// Blocks of 128 vertices written.
    pub blocks_written: u64,
    /// Blocks that were up to date.
    pub blocks_skipped: u64,
    /// Vertices that wait for a later call because of the budget.
    pub vertices_waiting: u64,
}

/// One output to bring up to date.
pub(crate) struct Output<'a, 'm> {
    pub view: DamageView<'a>,
    /// Index of the level of detail.
    pub lod: usize,
    pub mesh: &'a MeshLod,
    pub tracker: &'a mut Tracker,
    pub memory: &'a VertexMemory<'m>,
}

impl Output<'_, '_> {
    /// # Errors
    /// [`Error::BufferTooSmall`]; [`Error::Unsupported`] for normals or tangents that the mesh does not have.
    pub(crate) fn check(&self) -> Result<(), Error> {
        let mesh = &self.mesh.mesh;
        if self.memory.has_normals() && mesh.normals().is_none() {
            return Err(Error::Unsupported {
                what: "a normal output: the mesh has neither normals nor triangles to compute them from".into(),
            });
        }
        if self.memory.has_tangents() && mesh.tangents().is_none() {
            return Err(Error::Unsupported { what: "a tangent output: the mesh has no tangents".into() });
        }
        self.memory.check_size(mesh.positions().len())
    }

    /// Whether there are blocks to write.
    pub(crate) fn is_dirty(&self) -> bool {
        self.dirty().next().is_some()
    }

    /// The blocks to write.
    fn dirty(&self) -> impl Iterator<Item = usize> {
        self.tracker.dirty(self.view.changes, self.lod)
    }

    /// Whether normals are evaluated: they are wanted, or needed for something else that is.
    fn with_normals(&self) -> bool {
        let memory = self.memory;
        memory.has_normals() || memory.has_tangents() && self.mesh.mesh.normals().is_some()
    }

    /// Notes that nothing changed. Returns the number of blocks.
    pub(crate) fn skip(&mut self) -> u64 {
        self.tracker.written((self.view.changes, self.lod, self.mesh.vertex_count()), &[], &[]);
        self.mesh.blocks() as u64
    }
}

/// Evaluates the blocks that changed since each output was last written, and writes only those, of as many outputs as the
/// budget allows. [`Output::check`] must have passed for each output.
pub(crate) fn write_outputs(
    outputs: &mut [Output<'_, '_>],
    budget: u64,
    tasks: &dyn TaskSystem,
) -> Result<DeformReport, Error> {
    let waiting = budget::waiting(budget, outputs.iter().map(|o| (&*o.tracker, &o.view, o.lod)));
    let waits = |output: usize| waiting.binary_search_by_key(&output, |due| due.output).is_ok();
    // (output, block) of each work item, in the order of outputs.
    let most: usize = outputs.iter().map(|output| output.dirty().count()).sum();
    let mut items: Vec<(u32, u32)> = reserve(most, "the blocks to deform")?;
    for (o, output) in outputs.iter().enumerate().filter(|(o, _)| !waits(*o)) {
        items.extend(output.dirty().map(|block| (o as u32, block as u32)));
    }
    let total = items.len();
    let tasks = if total < SMALL && tasks.sleeps() { &Serial } else { tasks };
    let mut bounds = reserve(total, "the bounds of blocks")?;
    bounds.resize(total, Aabb::EMPTY);
    let chunk = match tasks.workers() {
        0 | 1 => total.max(1),
        workers => total.div_ceil(workers * TASKS_A_WORKER).clamp(1, BLOCKS_A_TASK),
    };
    map(tasks, items.chunks(chunk).zip(bounds.chunks_mut(chunk)), |(items, bounds)| {
        let mut scratch =
            Scratch { evaluate: evaluate::Scratch::new(), positions: [0.0; 3 * BLOCK], normals: [0.0; 3 * BLOCK] };
        for ((output, block), bounds) in items.iter().zip(bounds) {
            *bounds = write_block(&outputs[*output as usize], *block as usize, &mut scratch);
        }
    });
    let mut report = DeformReport::default();
    for due in &waiting {
        outputs[due.output].tracker.waits();
        report.vertices_waiting += due.vertices;
    }
    let mut at = 0;
    for (o, output) in outputs.iter_mut().enumerate().filter(|(o, _)| !waits(*o)) {
        let count = items[at..].iter().take_while(|(item, _)| *item as usize == o).count();
        let written = at..at + count;
        at += count;
        let (vertices, blocks) = (output.mesh.vertex_count(), output.mesh.blocks());
        let changes = output.view.changes;
        output.tracker.written((changes, output.lod, vertices), &items[written.clone()], &bounds[written]);
        report.blocks_written += count as u64;
        report.blocks_skipped += (blocks - count) as u64;
        report.vertices_written += output.tracker.changed().iter().map(|r| u64::from(r.end - r.start)).sum::<u64>();
    }
    Ok(report)
}

/// Memory that a task reuses from block to block.
struct Scratch {
    evaluate: evaluate::Scratch,
    positions: kernel::Flat,
    normals: kernel::Flat,
}

/// Writes a block and returns the bounds of its positions.
fn write_block(output: &Output<'_, '_>, block: usize, scratch: &mut Scratch) -> Aabb {
    let (mesh, memory) = (output.mesh, output.memory);
    let job = evaluate::BlockJob { view: &output.view, lod: mesh, block };
    let range = block_range(block, mesh.vertex_count());
    let n = 3 * range.len();
    let Scratch { evaluate: scratch, positions, normals } = scratch;
    // SAFETY: `check` passed for all vertices; the blocks of an output are distinct and outputs do not overlap.
    let direct = unsafe { memory.normals(range.clone()) }.and_then(|to| to.first_chunk_mut());
    let (is_direct, normals) = (direct.is_some(), direct.unwrap_or(normals));
    let wanted = output.with_normals().then_some(&mut *normals);
    // SAFETY: the same.
    let bounds = match unsafe { memory.positions(range.clone()) }.and_then(|to| to.first_chunk_mut()) {
        Some(positions) => evaluate::block(job, scratch, positions, wanted),
        None => {
            let bounds = evaluate::block(job, scratch, positions, wanted);
            // SAFETY: the same.
            unsafe { memory.write_positions(range.start, &positions[..n]) };
            bounds
        }
    };
    let normals = &normals[..n];
    if memory.has_normals() && !is_direct {
        // SAFETY: the same.
        unsafe { memory.write_normals(range.start, normals) };
    }
    if memory.has_tangents() {
        for (i, n) in normals.chunks_exact(3).enumerate() {
            let tangent = evaluate::tangent(mesh, range.start + i, Vec3::from_slice(n));
            // SAFETY: the same.
            unsafe { memory.write_tangent(range.start + i, tangent) };
        }
    }
    bounds
}
