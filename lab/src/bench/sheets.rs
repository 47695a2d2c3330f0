//! The plain case, at any size and on any threads: anchored examples of the sheet, all active, positions only.

use std::sync::Arc;
use std::time::Duration;

use anyhow::Result;
use crumple::{ExampleSet, InstanceOptions, TaskSystem};

use super::Bench;
use super::deformed::Deformed;
use super::measure::{Contender, Times, interleaved};
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
    pub threads: usize,
    pub times: Times,
    pub hash: u64,
}

impl Measured {
    /// Whether it is the library, not a reference.
    pub fn is_ours(&self) -> bool {
        self.method != "classic" && self.method != "memcpy"
    }
}

/// One of the methods at work.
enum Method<'t> {
    Ours(Deformed<'t>),
    Classic(Classic<'t>),
    Memcpy(Memcpy<'t>),
}

impl Method<'_> {
    fn run(&mut self) -> Duration {
        match self {
            Method::Ours(m) => m.run(),
            Method::Classic(m) => m.run(),
            Method::Memcpy(m) => m.run(),
        }
    }

    fn hash(&mut self) -> u64 {
        match self {
            Method::Ours(m) => m.hash(),
            Method::Classic(m) => m.hash(),
            Method::Memcpy(m) => m.hash(),
        }
    }
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

    /// On each of these numbers of threads, all in turn: each width, the literature's kernel, and a copy of as many positions
    /// as move.
    pub fn measure(&self, bench: &Bench, threads: &[usize]) -> Result<Vec<Measured>> {
        let mut methods: Vec<(&'static str, usize, Method)> = Vec::new();
        for &count in threads {
            let tasks = bench.tasks(count);
            for (width, set) in &self.sets {
                let ours = Deformed::new(set, InstanceOptions::default(), &own_marks(set), false, tasks)?;
                methods.push((width.name(), count, Method::Ours(ours)));
            }
            let set = &self.sets[0].1;
            methods.push(("classic", count, Method::Classic(Classic::of_set(set, tasks))));
            let memcpy = Memcpy::new(set.mesh().positions(), self.moved, tasks);
            methods.push(("memcpy", count, Method::Memcpy(memcpy)));
        }
        let mut contenders: Vec<Contender> =
            methods.iter_mut().map(|(name, _, method)| Contender::new(*name, || method.run())).collect();
        let times = interleaved(&bench.plan, &mut contenders);
        drop(contenders);
        let measured = methods.into_iter().zip(times).map(|((method, threads, mut at_work), times)| Measured {
            method,
            threads,
            times,
            hash: at_work.hash(),
        });
        Ok(measured.collect())
    }
}

/// The times of `method` on so many threads.
///
/// # Panics
/// Where it was not measured: `classic` and `memcpy` always are.
pub fn of<'m>(measured: &'m [Measured], method: &str, threads: usize) -> &'m Times {
    let found = measured.iter().find(|m| m.method == method && m.threads == threads);
    &found.unwrap_or_else(|| panic!("{method} was not measured on {threads} threads")).times
}
