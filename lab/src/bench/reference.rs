//! What every timing is held against: copying as many positions, and the literature's own kernel, well compiled.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use anyhow::{Result, ensure};
use crumple::{Example, ExampleSet, Hit, Instance, InstanceOptions, Rule, Selection, Serial, SetOptions, TaskSystem};
use glam::Vec3;

use super::deformed::hash;
use super::measure::timed;
use super::sheet::{Dent, Reach, Sheet};

/// Ranges of vertices that tasks work on: one a thread is too coarse where something else runs too.
fn chunk(vertices: usize, tasks: &dyn TaskSystem) -> usize {
    let chunks = if tasks.workers() == 1 { 1 } else { 4 * tasks.workers() };
    vertices.div_ceil(chunks).max(1)
}

/// Runs `work` on pieces of `out`, each beside its number.
fn in_pieces<T: Send>(out: &mut [T], piece: usize, tasks: &dyn TaskSystem, work: impl Fn(usize, &mut [T]) + Sync) {
    let pieces: Vec<Mutex<&mut [T]>> = out.chunks_mut(piece).map(Mutex::new).collect();
    tasks.parallel_for(pieces.len(), &|i| work(i, &mut pieces[i].lock().unwrap_or_else(|e| e.into_inner())));
}

/// Copies positions, 12 bytes a vertex.
pub struct Memcpy<'t> {
    from: Vec<[f32; 3]>,
    to: Vec<[f32; 3]>,
    tasks: &'t dyn TaskSystem,
}

impl<'t> Memcpy<'t> {
    /// Of the first `count` of these positions.
    pub fn new(positions: &[Vec3], count: usize, tasks: &'t dyn TaskSystem) -> Self {
        Self { from: positions[..count].iter().map(|p| p.to_array()).collect(), to: vec![[0.0; 3]; count], tasks }
    }

    pub fn run(&mut self) -> Duration {
        let Self { from, to, tasks } = self;
        let piece = chunk(from.len(), *tasks);
        timed(|| in_pieces(to, piece, *tasks, |i, to| to.copy_from_slice(&from[i * piece..i * piece + to.len()])))
    }

    pub fn hash(&self) -> u64 {
        hash(&self.to)
    }
}

/// A vertex that an example moves: 16 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
struct Entry {
    vertex: u32,
    /// Where the example has it, m.
    target: Vec3,
}

/// An example as the literature stores it, cut where the tasks' ranges of vertices begin.
struct Entries {
    entries: Vec<Entry>,
    /// For each range of vertices, where its entries begin; and their end.
    cuts: Vec<usize>,
}

/// The classic rule ("the most displaced", Figure 4.3 of the thesis): sparse example, state and base a vertex, 52 bytes
/// of traffic for each vertex that moves.
pub struct Classic<'t> {
    base: Vec<Vec3>,
    current: Vec<Vec3>,
    examples: Vec<Entries>,
    weight: f32,
    tasks: &'t dyn TaskSystem,
}

impl<'t> Classic<'t> {
    /// Applies each of these displacement fields (pairs of vertex and displacement, vertices increasing) in turn.
    pub fn new(base: &[Vec3], fields: &[Vec<(u32, Vec3)>], tasks: &'t dyn TaskSystem) -> Self {
        let piece = chunk(base.len(), tasks);
        let examples = fields.iter().map(|field| {
            let target = |(v, d): &(u32, Vec3)| Entry { vertex: *v, target: base[*v as usize] + *d };
            let entries: Vec<Entry> = field.iter().map(target).collect();
            let ranges = base.len().div_ceil(piece);
            let cuts = (0..=ranges).map(|i| entries.partition_point(|e| (e.vertex as usize) < i * piece)).collect();
            Entries { entries, cuts }
        });
        Self { base: base.to_vec(), current: base.to_vec(), examples: examples.collect(), weight: 0.9, tasks }
    }

    /// Of a set's examples.
    pub fn of_set(set: &ExampleSet, tasks: &'t dyn TaskSystem) -> Self {
        let fields: Vec<Vec<(u32, Vec3)>> = set.examples().iter().map(|e| field(set, e)).collect();
        Self::new(set.mesh().positions(), &fields, tasks)
    }

    /// From the body at rest, so that every entry is written, whatever ran before.
    pub fn run(&mut self) -> Duration {
        self.current.copy_from_slice(&self.base);
        timed(|| self.apply())
    }

    fn apply(&mut self) {
        let Self { base, current, examples, weight, tasks } = self;
        let piece = chunk(base.len(), *tasks);
        for e in examples.iter() {
            in_pieces(current, piece, *tasks, |i, current| {
                let entries = &e.entries[e.cuts[i]..e.cuts[i + 1]];
                most_displaced(entries, i * piece, &base[i * piece..], current, *weight);
            });
        }
    }

    pub fn hash(&self) -> u64 {
        hash(plain(&self.current))
    }
}

/// The kernel. `base` and `current` begin at vertex `first`. Written plainly, since nothing else was faster: four-wide vectors, a
/// select instead of the branch, eight entries at a time in lanes, each with and without AVX2 (3.3 ns a vertex in cache).
fn most_displaced(entries: &[Entry], first: usize, base: &[Vec3], current: &mut [Vec3], weight: f32) {
    let base = &base[..current.len()];
    for e in entries {
        let v = e.vertex as usize - first;
        let (rest, now) = (base[v], current[v]);
        let result = now + (e.target - now) * weight;
        if (result - rest).length_squared() >= (now - rest).length_squared() {
            current[v] = result;
        }
    }
}

fn plain(positions: &[Vec3]) -> &[[f32; 3]] {
    bytemuck::cast_slice(positions)
}

/// What an example moves by more than the set's tolerance: less is dropped where examples are stored whole.
pub fn field(set: &ExampleSet, example: &Example) -> Vec<(u32, Vec3)> {
    let (delta, least) = (|v: u32| (v, example.delta(v)), set.options().tolerance.unwrap_or(0.0));
    (0..set.vertex_count() as u32).map(delta).filter(|(_, d)| d.length() > least).collect()
}

/// Holds the kernel against the library's own rule, hit by hit.
///
/// # Errors
/// Where a vertex is further than 1e-6 m away.
pub fn verify() -> Result<()> {
    let dents = [Dent { reach: Reach::Disc(0.4), ..Dent::whole([0.4, 0.5]) }, Dent::whole([0.7, 0.6])];
    // So few that every vertex is a node, and shows what was given.
    let sheet = Sheet::new(2000);
    let examples = dents.iter().map(|d| sheet.example(d)).collect();
    let exact = SetOptions { mirror: false, ..SetOptions::default() };
    let set = &Arc::new(ExampleSet::build(sheet.points(), examples, exact, &Serial)?);
    let options =
        InstanceOptions { selection: Selection::ClassicUnclamped, ..InstanceOptions::classic(Rule::MostDisplaced) };
    let mut library = Instance::new(set.clone(), options)?;
    let mut kernel = Classic::of_set(set, &Serial);
    let all = std::mem::take(&mut kernel.examples);
    // Weaker hits after harder ones as well, so that both outcomes of the comparison occur.
    for (hit, weight) in [(0, 0.7f32), (1, 0.9), (0, 0.3), (1, 0.5), (0, 1.0)] {
        let example = &set.examples()[hit];
        // Of the examples that move the contact the literature takes the one that points most like the target: its own.
        let target = example.contact_displacement() * weight;
        let outcome = library.submit(&Hit::displacement(example.contact_point().to_array(), target.to_array()))?;
        let chosen = outcome.classic.map(|c| c.example);
        ensure!(chosen == Some(hit as u32), "the library took example {chosen:?} for a hit on the contact of {hit}");
        library.fold();
        let piece = [Entries { entries: all[hit].entries.clone(), cuts: all[hit].cuts.clone() }];
        kernel.examples = Vec::from(piece);
        kernel.weight = weight;
        kernel.apply();
        for v in 0..set.vertex_count() {
            let (a, b) = (library.displaced(v as u32)?, kernel.current[v]);
            ensure!((a - b).abs().max_element() <= 1e-6, "vertex {v}: the kernel has {b}, the library's rule {a}");
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crumple::ThreadPool;

    #[test]
    fn the_kernel_is_the_librarys_rule() {
        verify().unwrap();
    }

    #[test]
    fn threads_change_no_bit() {
        let set = &Sheet::new(2000).set(&[Dent { reach: Reach::FIFTH, ..Dent::whole([0.5; 2]) }], &Serial).unwrap();
        let pool = ThreadPool::new(3).unwrap();
        let (mut one, mut three) = (Classic::of_set(set, &Serial), Classic::of_set(set, &pool));
        one.run();
        three.run();
        assert_eq!(one.hash(), three.hash());
        assert_eq!(one.examples[0].entries.len(), set.examples()[0].moved_vertices());
        let mut copies = [&Serial as &dyn TaskSystem, &pool].map(|t| Memcpy::new(set.mesh().positions(), 1600, t));
        copies.iter_mut().for_each(|c| _ = c.run());
        assert_eq!(copies[0].hash(), copies[1].hash());
    }
}
