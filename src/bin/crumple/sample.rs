//! `crumple sample`: writes a list of impacts to start from.

use crate::output::Output;
use crate::picture::millimetres;
use crate::source::{FAR_OFF, Input, Source};
use crate::table::count;
use crate::{impacts, info};
use anyhow::{Result, bail};
use clap::Args;
use crumple::{ExampleSet, Hit, HitStatus, Instance, InstanceOptions, Mesh, ThreadPool, glam::Vec3};
use std::path::PathBuf;

/// Number of candidates for each impact. Of those that take a dent, the one furthest from the impacts so far is kept (Mitchell's best
/// candidate, 1991).
const CANDIDATES: usize = 24;

#[derive(Args)]
pub struct Arguments {
    #[command(flatten)]
    input: Input,
    /// File for the impacts
    #[arg(short, long, value_name = "IMPACTS.json")]
    output: PathBuf,
    /// Number of impacts
    #[arg(long, default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    count: u32,
    /// The same seed gives the same impacts
    #[arg(long, default_value_t = 0)]
    seed: u64,
}

pub fn run(arguments: &Arguments) -> Result<String> {
    let mut file = Output::create_as(&arguments.output, "json", "JSON")?;
    let source = arguments.input.load(&ThreadPool::new(0)?)?;
    let impacts = sample(&source, arguments.count as usize, arguments.seed)?;
    file.fill(impacts::format(&impacts).as_bytes())?;
    file.commit()?;
    let depths = impacts.iter().map(|(_, u)| Vec3::from(*u).length());
    let (low, high) = depths.fold((f32::MAX, 0f32), |(l, h), d| (l.min(d), h.max(d)));
    let (path, all, seed) = (arguments.output.display(), count(impacts.len(), "impact", "impacts"), arguments.seed);
    Ok(format!("{path}: {all}, {} to {} mm deep, seed {seed}\n", millimetres(low), millimetres(high)))
}

/// Points spread over the surface, each with a displacement (m) that dents the mesh there: into the body along the normal, or as the
/// examples do, and as deep as they are.
fn sample(source: &Source, count: usize, seed: u64) -> Result<Vec<([f32; 3], [f32; 3])>> {
    let set = &source.set;
    let depths = set.examples().iter().filter(|e| !e.is_empty()).map(|e| e.depth());
    let (low, high) = depths.fold((f32::MAX, 0f32), |(l, h), d| (l.min(d), h.max(d)));
    if high <= 0.0 {
        bail!("no example moves a vertex, so there is no depth to sample; check the morph targets");
    }
    let mut trial = Instance::new(set.clone(), InstanceOptions::default())?;
    source.spare_glass(&mut trial)?;
    // A depth of exactly the limit may be longer by a rounding.
    let most = high.min(trial.depth_limit()) * 0.999;
    let mut random = Random(seed);
    let surface = Surface::new(set);
    let mut points: Vec<Vec3> = Vec::with_capacity(count);
    let mut impacts = Vec::with_capacity(count);
    for _ in 0..count {
        let depth = low.min(most) + (most - low.min(most)) * random.unit();
        let mut places: Vec<(f32, Vec3, u32)> = Vec::with_capacity(CANDIDATES);
        for _ in 0..CANDIDATES {
            let Some((p, vertex)) = surface.pick(&mut random) else { continue };
            let distance = points.iter().map(|q| q.distance_squared(p)).fold(f32::MAX, f32::min);
            places.push((distance, p, vertex));
        }
        places.sort_by(|a, b| b.0.total_cmp(&a.0));
        let found = places.iter().find_map(|(_, p, vertex)| Some((*p, push(&trial, *p, *vertex, depth)?)));
        let Some((p, displacement)) = found else {
            bail!(
                "none of {CANDIDATES} places that the examples move takes a dent of {} mm; write the impacts by hand",
                millimetres(depth)
            );
        };
        points.push(p);
        impacts.push((p.to_array(), displacement.to_array()));
    }
    Ok(impacts)
}

/// The displacement of length `depth` at `p` that dents the body: the first of those into the body, out of it, and along the examples
/// that leaves at least half as deep a dent.
fn push(trial: &Instance, p: Vec3, vertex: u32, depth: f32) -> Option<Vec3> {
    let set = trial.example_set();
    let normal = set.mesh().contact_normal(vertex);
    let deltas = set.examples().iter().map(|e| e.delta(vertex));
    let deepest = deltas.max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))?;
    let along = deepest.try_normalize();
    [normal.map(|n| -n), normal, along].into_iter().flatten().map(|direction| direction * depth).find(|displacement| {
        let outcome = trial.preview(&Hit::displacement(p.to_array(), displacement.to_array()));
        outcome.is_ok_and(|outcome| {
            let reached = Vec3::from(outcome.achieved).dot(*displacement) / (depth * depth);
            outcome.status == HitStatus::Marked && !outcome.clamped && reached >= 0.5
        })
    })
}

/// Triangles with the running sum of their areas, for picking by area. Triangles that no example moves are left out,
/// because the examples do not show how the body dents there.
struct Surface<'a> {
    mesh: &'a Mesh,
    moved: Vec<bool>,
    sums: Vec<f64>,
    /// A point further than this from its nearest vertex is moved there, m.
    near: f32,
}

impl<'a> Surface<'a> {
    fn new(set: &'a ExampleSet) -> Surface<'a> {
        let mesh = set.mesh();
        let moved = info::moved(set);
        let mut sum = 0.0;
        let area = |t: &[u32; 3]| {
            if t.iter().any(|&i| moved[i as usize]) {
                let [a, b, c] = t.map(|i| mesh.positions()[i as usize].as_dvec3());
                sum += (b - a).cross(c - a).length();
            }
            sum
        };
        let sums = mesh.triangles().iter().map(area).collect();
        let near = 0.5 * FAR_OFF * mesh.bounds().diagonal();
        Surface { mesh, moved, sums, near }
    }

    /// Picks a point near a vertex that an example moves. Without triangles it is the vertex.
    fn pick(&self, random: &mut Random) -> Option<(Vec3, u32)> {
        let at = |vertex: u32| self.mesh.positions()[vertex as usize];
        let Some(total) = self.sums.last().copied().filter(|&total| total > 0.0) else {
            let all: Vec<u32> = (0..self.moved.len() as u32).filter(|v| self.moved[*v as usize]).collect();
            let vertex = *all.get((random.unit() * all.len() as f32) as usize)?;
            return Some((at(vertex), vertex));
        };
        let place = f64::from(random.unit()) * total;
        let (u, v) = (random.unit().sqrt(), random.unit());
        let t = self.mesh.triangles().get(self.sums.partition_point(|&s| s <= place))?;
        let weights = [1.0 - u, u * (1.0 - v), u * v];
        let p = t.iter().zip(weights).map(|(&i, w)| at(i) * w).sum::<Vec3>();
        let nearest = *t.iter().min_by(|a, b| at(**a).distance(p).total_cmp(&at(**b).distance(p)))?;
        let is_moved = |vertex: &u32| self.moved[*vertex as usize];
        let moved = t.iter().copied().filter(is_moved);
        let vertex = moved.min_by(|a, b| at(*a).distance(p).total_cmp(&at(*b).distance(p)))?;
        let is_good = nearest == vertex && at(vertex).distance(p) <= self.near;
        Some((if is_good { p } else { at(vertex) }, vertex))
    }
}

/// SplitMix64 (Steele, Lea and Flood, 2014), which gives the same numbers on every platform.
struct Random(u64);

impl Random {
    /// In [0, 1).
    fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 40) as f32 / (1u64 << 24) as f32
    }
}
