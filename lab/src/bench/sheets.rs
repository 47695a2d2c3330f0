//! The plain case, at any size and on any threads: anchored examples of the sheet, all active, positions only.

use std::sync::Arc;

use anyhow::Result;
use crumple::{ExampleSet, InstanceOptions, TaskSystem};

use super::deformed::Deformed;
use super::measure::{Contender, Plan, Times, interleaved};
use super::reference::{Classic, Memcpy};
use super::sheet::{Dent, Sheet, own_marks};
use super::width::Width;

/// Sets of one sheet in each width that there is.
pub struct Sheets {
    pub sets: Vec<(Width, Arc<ExampleSet>)>,
    /// Vertices that any example moves.
    pub moved: usize,
}

/// What was measured of one method.
pub struct Measured {
    /// A width's name, `classic` or `memcpy`.
    pub method: &'static str,
    pub times: Times,
    pub hash: u64,
}

impl Sheets {
    pub fn build(vertices: usize, dents: &[Dent], tasks: &dyn TaskSystem) -> Result<Self> {
        let sets = Sheet::new(vertices).sets(dents, tasks)?;
        let moved = sets[0].1.examples().iter().map(|e| e.moved_vertices()).max().unwrap_or(0);
        Ok(Self { sets, moved })
    }

    pub fn vertices(&self) -> usize {
        self.sets[0].1.vertex_count()
    }

    /// Each width, then the literature's kernel and a copy of as many positions as move.
    pub fn measure(&self, plan: &Plan, tasks: &dyn TaskSystem) -> Result<Vec<Measured>> {
        let mut ours = Vec::new();
        for (width, set) in &self.sets {
            let marks = own_marks(set);
            ours.push((width.name(), Deformed::new(set, InstanceOptions::default(), &marks, false, tasks)?));
        }
        let set = &self.sets[0].1;
        let mut classic = Classic::of_set(set, tasks);
        let mut memcpy = Memcpy::new(set.mesh().positions(), self.moved, tasks);
        let mut contenders: Vec<Contender> =
            ours.iter_mut().map(|(name, d)| Contender::new(*name, || d.run())).collect();
        contenders.push(Contender::new("classic", || classic.run()));
        contenders.push(Contender::new("memcpy", || memcpy.run()));
        let mut times = interleaved(plan, &mut contenders).into_iter();
        drop(contenders);
        let mut measured = Vec::new();
        for ((method, deformed), times) in ours.iter_mut().zip(times.by_ref()) {
            measured.push(Measured { method, times, hash: deformed.hash() });
        }
        for ((method, hash), times) in [("classic", classic.hash()), ("memcpy", memcpy.hash())].into_iter().zip(times) {
            measured.push(Measured { method, times, hash });
        }
        Ok(measured)
    }
}

/// The times of `method`.
///
/// # Panics
/// Where it was not measured: `classic` and `memcpy` always are.
pub fn of<'m>(measured: &'m [Measured], method: &str) -> &'m Times {
    let found = measured.iter().find(|m| m.method == method);
    &found.unwrap_or_else(|| panic!("{method} was not measured")).times
}
