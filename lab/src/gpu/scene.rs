//! What is dented: sheets with examples, and bodies whose damage changes from run to run.

use std::sync::Arc;
use std::time::Duration;

use anyhow::Result;
use crumple::{ExampleSet, Mark, SetOptions, TaskSystem};

use super::recorded::{Cost, Recorded};
use crate::bench::baked;
use crate::bench::sheet::{Dent, Sheet};

/// Strengths of marks, neither nothing nor the whole (which need not be multiplied), as the CPU path's benchmark has them …
pub const STRENGTHS: [f64; 2] = [0.9, 0.8];
/// … and of the paper's hits.
pub const WEIGHT: f32 = 0.9;

/// Examples of a sheet of about so many vertices, with normals or without.
pub fn sheet(vertices: usize, dents: &[Dent], normals: bool, tasks: &dyn TaskSystem) -> Result<Arc<ExampleSet>> {
    let sheet = Sheet::new(vertices);
    let examples = dents.iter().map(|d| sheet.example(d)).collect();
    let mesh = if normals { sheet.surface() } else { sheet.points() };
    let options = SetOptions { mirror: false, ..baked() };
    Ok(Arc::new(ExampleSet::build(mesh, examples, options, tasks)?))
}

/// Marks of this share of their strength.
pub fn at_strength(marks: &[Mark], share: f64) -> Vec<Mark> {
    // The library's law: energy goes with strength to the power 2.4.
    let energy = share.powf(2.4) * Mark::ONE as f64;
    marks.iter().map(|m| Mark { energy: energy as u64, ..*m }).collect()
}

/// Bytes a vertex that the library must move, whatever the number of marks: base and result, the weights of the nodes that the vertex
/// follows and, of its tile, their numbers; of its block its place in the list, its limits and its bounds.
pub fn bytes(set: &ExampleSet, normals: bool) -> f64 {
    let nodes = f64::from(set.basis_report().map_or(0.0, |report| report.nodes_a_vertex));
    let (vectors, weights, unit) = if normals { (48.0, 3.0, 4.0) } else { (24.0, 1.0, 0.0) };
    vectors + weights * nodes + unit + 4.0 * nodes / TILE + OF_BLOCKS
}

/// Vertices that follow the same nodes.
const TILE: f64 = 16.0;
/// Bytes of a block's entry in the list, and of its limits and bounds, for each of its 128 vertices.
const OF_BLOCKS: f64 = (8.0 + 4.0 + 24.0) / 128.0;

/// Bodies of which some change their damage in every run, in turn between two strengths.
pub struct Toggled<'g> {
    pub recorded: Recorded<'g>,
    damages: [Vec<Mark>; 2],
    /// Every so many-th body changes.
    step: usize,
    turn: usize,
}

impl<'g> Toggled<'g> {
    /// All bodies show the first of these two damages; every `step`-th will change.
    pub fn new(mut recorded: Recorded<'g>, damages: [Vec<Mark>; 2], step: usize) -> Result<Self> {
        for instance in &mut recorded.instances {
            instance.set_marks(&damages[0])?;
        }
        recorded.frame()?;
        Ok(Toggled { recorded, damages, step, turn: 0 })
    }

    /// Of these marks, in both strengths.
    pub fn marks(recorded: Recorded<'g>, marks: &[Mark], step: usize) -> Result<Self> {
        Self::new(recorded, STRENGTHS.map(|share| at_strength(marks, share)), step)
    }

    /// Changes the damage and brings the vertices up to date.
    pub fn frame(&mut self) -> Result<Cost> {
        self.turn ^= 1;
        for instance in self.recorded.instances.iter_mut().step_by(self.step) {
            instance.set_marks(&self.damages[self.turn])?;
        }
        self.recorded.frame()
    }

    /// What bringing them up to date takes on the device.
    pub fn run(&mut self) -> Duration {
        self.frame().unwrap_or_else(|e| panic!("{e:#}")).device
    }

    /// The vertices on the device after one more run, and what the CPU makes of them: each of the two damages once.
    pub fn vertices(&mut self, tasks: &dyn TaskSystem) -> Result<(Vec<f32>, Vec<f32>)> {
        self.frame()?;
        let got = self.recorded.vertices()?;
        let mut wanted = Vec::with_capacity(got.len());
        // Bodies that change show this run's damage, the others the first.
        let of = |i: usize| super::recorded::on_the_cpu(&self.recorded.instances[i], self.recorded.output, tasks);
        let changed = of(0)?;
        let still = if self.step > 1 && self.recorded.instances.len() > 1 { of(1)? } else { Vec::new() };
        for i in 0..self.recorded.instances.len() {
            wanted.extend_from_slice(if i % self.step == 0 { &changed } else { &still });
        }
        Ok((got, wanted))
    }
}
