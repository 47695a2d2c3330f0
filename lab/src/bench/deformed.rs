//! The library at work: an instance, its output, and what is done to it before each run.

use std::sync::Arc;
use std::time::Duration;

use anyhow::Result;
use crumple::{DeformJob, ExampleSet, Hit, Instance, InstanceOptions, Mark, TaskSystem, Tracker, VertexMemory};
use xxhash_rust::xxh3::xxh3_64;

use super::measure::timed;

/// xxh3 of the bits of positions, as this machine stores them.
pub fn hash(positions: &[[f32; 3]]) -> u64 {
    xxh3_64(bytemuck::cast_slice(positions))
}

/// An instance with an output of contiguous positions, and normals, in floats or octahedral.
pub struct Deformed<'t> {
    instance: Instance,
    tracker: Tracker,
    lod: usize,
    positions: Vec<[f32; 3]>,
    normals: Option<Vec<[f32; 3]>>,
    octahedral_normals: Vec<[u16; 2]>,
    tasks: &'t dyn TaskSystem,
    /// Two damages of the same reach, taken in turn: each run evaluates all vertices that the marks touch.
    damages: [Vec<Mark>; 2],
    turn: usize,
    blocks_written: u64,
}

impl<'t> Deformed<'t> {
    /// `marks` are taken in two strengths, neither the whole (which need not be multiplied).
    pub fn new(
        set: &Arc<ExampleSet>,
        options: InstanceOptions,
        marks: &[Mark],
        normals: bool,
        tasks: &'t dyn TaskSystem,
    ) -> Result<Self> {
        let count = set.vertex_count();
        let damage = |strength: f64| {
            // The library's law: energy goes with strength to the power 2.4.
            let energy = (strength.powf(2.4) * Mark::ONE as f64) as u64;
            marks.iter().map(|m| Mark { energy, ..*m }).collect()
        };
        let mut it = Self {
            instance: Instance::new(set.clone(), options)?,
            tracker: Tracker::new(),
            lod: 0,
            positions: vec![[0.0; 3]; count],
            normals: normals.then(|| vec![[0.0; 3]; count]),
            octahedral_normals: Vec::new(),
            tasks,
            damages: [damage(0.9), damage(0.8)],
            turn: 0,
            blocks_written: 0,
        };
        // What no mark touches is written once, here.
        it.deform()?;
        Ok(it)
    }

    /// The same with the positions of a level of detail alone.
    pub fn on_level(mut self, lod: usize) -> Result<Self> {
        let count = self.instance.example_set().lod_mesh(lod)?.positions().len();
        (self.lod, self.positions, self.normals) = (lod, vec![[0.0; 3]; count], None);
        self.deform()?;
        Ok(self)
    }

    /// The same with octahedral normals in place of others.
    pub fn with_octahedral_normals(mut self) -> Result<Self> {
        self.octahedral_normals = vec![[0; 2]; self.positions.len()];
        self.tracker.invalidate();
        self.deform()?;
        Ok(self)
    }

    /// Changes the damage, then times what brings the output up to date.
    pub fn run(&mut self) -> Duration {
        self.turn ^= 1;
        let set = self.instance.set_marks(&self.damages[self.turn]);
        timed(|| set.and_then(|()| self.deform()).unwrap_or_else(|e| panic!("{e}")))
    }

    /// Times what writes all vertices again, without a change of the damage.
    pub fn again(&mut self) -> Duration {
        self.tracker.invalidate();
        timed(|| self.deform().unwrap_or_else(|e| panic!("{e}")))
    }

    /// Puts the damage back to `before` and brings the output up to date, then times these hits from submission to vertices.
    pub fn hit(&mut self, before: &[Mark], hits: &[Hit]) -> Duration {
        let set = self.instance.set_marks(before);
        set.and_then(|()| self.deform()).unwrap_or_else(|e| panic!("{e}"));
        timed(|| {
            for hit in hits {
                self.instance.submit(hit).unwrap_or_else(|e| panic!("{e}"));
            }
            self.instance.fold();
            self.deform().unwrap_or_else(|e| panic!("{e}"));
        })
    }

    fn deform(&mut self) -> Result<(), crumple::Error> {
        let mut memory = VertexMemory::separate(&mut self.positions, self.normals.as_deref_mut(), None)?;
        if !self.octahedral_normals.is_empty() {
            memory = memory.with_octahedral_normals(&mut self.octahedral_normals);
        }
        let job = DeformJob { lod: self.lod, instance: &self.instance, tracker: &mut self.tracker, memory };
        self.blocks_written = crumple::deform(&mut [job], self.tasks)?.blocks_written;
        Ok(())
    }

    /// Hash of the positions with the first damage, or as they are where there is none.
    pub fn hash(&mut self) -> u64 {
        if !self.damages[0].is_empty() {
            self.turn = 1;
            self.run();
        }
        hash(&self.positions)
    }

    /// Blocks that the last run wrote.
    pub fn blocks_written(&self) -> u64 {
        self.blocks_written
    }

    pub fn positions(&self) -> &[[f32; 3]] {
        &self.positions
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::sheet::{Dent, Reach, Sheet, own_marks};
    use crumple::Serial;

    #[test]
    fn every_run_changes_every_vertex_that_the_marks_move() {
        let dent = Dent { reach: Reach::FIFTH, ..Dent::whole([0.5; 2]) };
        let set = &Sheet::new(4096).set(&[dent], &Serial).unwrap();
        let mut ours =
            Deformed::new(set, InstanceOptions::default(), &own_marks(set).unwrap(), false, &Serial).unwrap();
        let first = ours.hash();
        let before = ours.positions().to_vec();
        ours.run();
        let changed = ours.positions().iter().zip(&before).filter(|(a, b)| a != b).count();
        let base = set.mesh().positions();
        let moved = before.iter().zip(base).filter(|(p, b)| **p != b.to_array()).count();
        // All but a few at the rim, where a tenth of the displacement may be lost in rounding.
        assert!(changed * 100 > 98 * moved && moved > 750, "{changed} of {moved}");
        assert_eq!(ours.hash(), first);
    }
}
