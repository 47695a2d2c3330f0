//! The plain case, at any size and on any threads: anchored examples of the sheet, all active, positions only.

use std::sync::Arc;
use std::time::Duration;

use anyhow::{Result, ensure};
use crumple::{ExampleSet, InstanceOptions, TaskSystem};
use glam::Vec3;

use super::Bench;
use super::deformed::Deformed;
use super::measure::{Contender, Times, interleaved};
use super::reference::{Classic, Memcpy};
use super::sheet::{Dent, Sheet, own_marks};
use super::width::{Width, tolerance};

/// Sets of one sheet in each width that there is.
pub struct Sheets {
    pub sets: Vec<(Width, Arc<ExampleSet>)>,
    /// Vertices that any example moves.
    pub moved: usize,
    /// The largest component of any displacement, m.
    largest: f32,
    examples: usize,
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
        let sets = Sheet::new(vertices).sets(dents, tasks)?;
        let moved = sets[0].1.examples().iter().map(|e| e.moved_vertices()).max().unwrap_or(0);
        let largest = dents.iter().map(|d| d.depth).fold(0.0, f32::max);
        Ok(Self { sets, moved, largest, examples: dents.len() })
    }

    pub fn vertices(&self) -> usize {
        self.sets[0].1.vertex_count()
    }

    /// On each of these numbers of threads, all in turn: each width, the classic kernel, and a copy of as many positions
    /// as move.
    pub fn measure(&self, bench: &Bench, threads: &[usize]) -> Result<Vec<Measured>> {
        let mut methods: Vec<(&'static str, usize, Method)> = Vec::new();
        for &count in threads {
            let tasks = bench.tasks(count);
            for (width, set) in &self.sets {
                let ours = Deformed::new(set, InstanceOptions::default(), &own_marks(set), false, tasks)?;
                methods.push((width.name(), count, Method::Ours(ours.into())));
            }
            let set = &self.sets[0].1;
            methods.push(("classic", count, Method::Classic(Classic::of_set(set, tasks))));
            let memcpy = Memcpy::new(set.mesh().positions(), self.moved, tasks);
            methods.push(("memcpy", count, Method::Memcpy(memcpy)));
        }
        let mut contenders: Vec<Contender> =
            methods.iter_mut().map(|(.., method)| Contender::new(|| method.run())).collect();
        let times = interleaved(&bench.plan, &mut contenders);
        drop(contenders);
        let hashes: Vec<u64> = methods.iter_mut().map(|(.., method)| method.hash()).collect();
        self.check(&methods)?;
        let results = methods.iter().zip(hashes).zip(times);
        let measured = results.map(|(((method, threads, _), hash), times)| {
            let (method, threads) = (*method, *threads);
            Measured { method, threads, times, hash }
        });
        Ok(measured.collect())
    }

    /// Every width must come as near to exact f32 as its tolerance says: a fast wrong answer is none.
    fn check(&self, methods: &[(&'static str, usize, Method)]) -> Result<()> {
        let ours = |width: Width| {
            let of_width = methods.iter().filter(move |(name, ..)| *name == width.name());
            of_width.filter_map(|(.., m)| if let Method::Ours(m) = m { Some(m.positions()) } else { None })
        };
        let Some(exact) = ours(Width::F32).next() else { return Ok(()) };
        for width in self.sets.iter().map(|(width, _)| *width) {
            // Each example is off by as much at most; strengths and scales are below 1. Nodes are learned from other numbers, and where a
            // disc ends they are off by some hundredths.
            let allowed = self.examples as f32 * tolerance(width, self.largest).unwrap_or(0.0) + 0.03 * self.largest;
            for positions in ours(width) {
                let apart = |(a, b): (&[f32; 3], &[f32; 3])| Vec3::from_array(*a).distance(Vec3::from_array(*b));
                let worst = positions.iter().zip(exact).map(apart).fold(0.0, f32::max);
                ensure!(worst <= allowed, "{} is {worst} m off; {allowed} m are allowed", width.name());
            }
        }
        Ok(())
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
