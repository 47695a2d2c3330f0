//! The displacements of an instance's nodes, which its vertices follow ([`crate::basis`]).

use super::view::{DamageView, NodeSteps, NodeView};
use super::{Output, Tracker, VertexMemory, write_outputs};
use crate::base::error::{Error, reserve};
use crate::base::tasks::Serial;
use crate::basis::FREE;
use crate::example::mesh_lod::MeshLod;
use crate::mesh::vertex_blocks::BLOCK;
use glam::Vec3;

/// The displacements of all nodes, as of the last update.
#[derive(Debug)]
pub(crate) struct NodeState {
    tracker: Tracker,
    /// m.
    positions: Vec<[f32; 3]>,
    /// What predicted dents add to nodes, m; empty if there never was one.
    predicted: Vec<Vec3>,
    steps: Vec<NodeSteps>,
    /// m; a power of two.
    step: f32,
    /// Nodes whose steps the last update changed.
    changed: Vec<u32>,
}

impl NodeState {
    /// As many nodes, none of them displaced.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`].
    pub(crate) fn new(nodes: usize) -> Result<Self, Error> {
        let (mut positions, mut steps) = (reserve(nodes, "nodes")?, reserve(nodes, "nodes")?);
        positions.resize(nodes, [0.0; 3]);
        steps.resize(nodes, [0; 4]);
        let predicted = Vec::new();
        Ok(Self { tracker: Tracker::new(), positions, predicted, steps, step: 0.0, changed: reserve(nodes, "nodes")? })
    }

    pub(crate) fn view(&self) -> NodeView<'_> {
        NodeView { steps: &self.steps, step: self.step }
    }

    /// Computes the nodes that the damage changed; `lod` is their number among the meshes of `view.changes`. Returns those whose
    /// steps changed.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`]. Then the nodes are computed by the next update.
    pub(crate) fn update(&mut self, view: &DamageView<'_>, nodes: &MeshLod, lod: usize) -> Result<&[u32], Error> {
        let memory = VertexMemory::separate(&mut self.positions, None, None)?;
        let tracker = &mut self.tracker;
        let unlimited = DamageView { depth_limit: f32::MAX, ..*view };
        write_outputs(
            &mut [Output { view: unlimited, lod, mesh: nodes, tracker, memory: &memory }],
            u64::MAX,
            &Serial,
        )?;
        self.changed.clear();
        self.add_predicted(view);
        let limit = view.depth_limit.min(MOST_LIMITS * view.set.depth_limit());
        let step = step(limit);
        let before = std::mem::replace(&mut self.step, step);
        // The steps of the first update replace zeros.
        let all = before != step && before != 0.0;
        let every = 0..self.positions.len() as u32;
        for v in if all { std::slice::from_ref(&every) } else { self.tracker.changed() }.iter().cloned().flatten() {
            let at = v as usize;
            let predicted = self.predicted.get(at).copied().unwrap_or_default();
            let moved = Vec3::from(self.positions[at]) - nodes.mesh.positions()[at] + predicted;
            let [x, y, z] = (soft(moved, limit) / step).to_array().map(|x| libm::roundf(x.clamp(-MOST, MOST)) as i16);
            if all || self.steps[at] != [x, y, z, 0] {
                self.steps[at] = [x, y, z, 0];
                self.changed.push(v);
            }
        }
        Ok(&self.changed)
    }

    /// Sums what predicted dents move, for the nodes of the blocks that changed; in the order of the marks, so that the sums have the
    /// same bits on every machine.
    fn add_predicted(&mut self, view: &DamageView<'_>) {
        let dents = || view.damage.dents().iter().filter(|dent| dent.predicted().next().is_some());
        if self.predicted.is_empty() && dents().next().is_none() {
            return;
        }
        let nodes = self.positions.len();
        self.predicted.resize(nodes, Vec3::ZERO);
        let mut summed = vec![false; nodes.div_ceil(BLOCK)];
        for range in self.tracker.changed() {
            let blocks = range.start as usize / BLOCK..(range.end as usize).div_ceil(BLOCK);
            self.predicted[blocks.start * BLOCK..(blocks.end * BLOCK).min(nodes)].fill(Vec3::ZERO);
            summed[blocks].fill(true);
        }
        for dent in dents() {
            for (node, u) in dent.predicted().filter(|(node, _)| summed[*node as usize / BLOCK]) {
                self.predicted[node as usize] += u;
            }
        }
    }

    /// Memory used, bytes.
    pub(crate) fn memory_bytes(&self) -> usize {
        self.predicted.capacity() * 12
            + self.positions.capacity() * 12
            + self.steps.capacity() * 8
            + self.changed.capacity() * 4
    }
}

/// A displacement that approaches the depth limit instead of being cut to it, so that many dents leave no plateau: up to [`FREE`] of
/// the limit it is `u`, beyond it grows ever more slowly. Only IEEE operations.
fn soft(u: Vec3, limit: f32) -> Vec3 {
    let (length, free) = (u.length(), FREE * limit);
    // A length that overflows is cut.
    if length <= free || !length.is_finite() {
        return u;
    }
    let (rest, beyond) = (limit - free, length - free);
    u * ((free + rest * (beyond / (rest + beyond))) / length)
}

/// Nodes move no further than this many times the set's own depth limit, whatever that of the instance: so that steps stay fine.
const MOST_LIMITS: f32 = 16.0;
/// The most steps.
const MOST: f32 = 32767.0;

/// The step for displacements up to `limit`, m: a power of two.
fn step(limit: f32) -> f32 {
    let least = (limit / 32000.0).clamp(f32::MIN_POSITIVE, 1e30);
    let power = f32::from_bits(least.to_bits() & 0x7F80_0000);
    if power < least { 2.0 * power } else { power }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_is_the_least_power_of_two_that_holds_the_limit() {
        for limit in [1e-6, 0.03, 0.25, 1.0, 77.0] {
            let step = step(limit);
            assert_eq!(step.to_bits() & 0x007F_FFFF, 0);
            assert!(limit / step <= 32000.0 && limit / step > 15999.0, "{limit} {step}");
        }
    }
}
