//! The plain case, at any size and on any threads: examples of the sheet, all active, positions only.

use std::sync::Arc;
use std::time::Duration;

use anyhow::Result;
use crumple::{ExampleSet, InstanceOptions, TaskSystem};

use super::Bench;
use super::deformed::Deformed;
use super::measure::{Contender, Times, interleaved};
use super::reference::{Classic, Memcpy};
use super::sheet::{Dent, Sheet, own_marks};

/// The set of a sheet.
pub struct Sheets {
    set: Arc<ExampleSet>,
    /// Vertices that any example moves.
    pub moved: usize,
}

/// What was measured of one method.
pub struct Measured {
    /// `crumple`, `classic` or `memcpy`.
    pub method: &'static str,
    pub threads: usize,
    pub times: Times,
    pub hash: u64,
}

impl Measured {
    /// Whether it is the library, not a reference.
    pub fn is_ours(&self) -> bool {
        self.method == "crumple"
    }
}

/// One of the methods at work.
enum Method<'t> {
    Ours(Box<Deformed<'t>>),
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
        let set = Sheet::new(vertices).set(dents, tasks)?;
        let moved = set.examples().iter().map(|e| e.moved_vertices()).max().unwrap_or(0);
        Ok(Self { set, moved })
    }

    pub fn vertices(&self) -> usize {
        self.set.vertex_count()
    }

    /// On each of these numbers of threads, all in turn: the library, the classic kernel, and a copy of as many positions
    /// as move.
    pub fn measure(&self, bench: &Bench, threads: &[usize]) -> Result<Vec<Measured>> {
        let mut methods: Vec<(&'static str, usize, Method)> = Vec::new();
        for &count in threads {
            let tasks = bench.tasks(count);
            let set = &self.set;
            let ours = Deformed::new(set, InstanceOptions::default(), &own_marks(set)?, false, tasks)?;
            methods.push(("crumple", count, Method::Ours(ours.into())));
            methods.push(("classic", count, Method::Classic(Classic::of_set(set, tasks))));
            let memcpy = Memcpy::new(set.mesh().positions(), self.moved, tasks);
            methods.push(("memcpy", count, Method::Memcpy(memcpy)));
        }
        let mut contenders: Vec<Contender> =
            methods.iter_mut().map(|(.., method)| Contender::new(|| method.run())).collect();
        let times = interleaved(&bench.plan, &mut contenders);
        drop(contenders);
        let hashes: Vec<u64> = methods.iter_mut().map(|(.., method)| method.hash()).collect();
        let results = methods.iter().zip(hashes).zip(times);
        let measured = results.map(|(((method, threads, _), hash), times)| {
            let (method, threads) = (*method, *threads);
            Measured { method, threads, times, hash }
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
