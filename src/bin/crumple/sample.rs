//! `crumple sample`: writes a list of impacts to start from.

use crate::{impacts, output::Output, picture::millimetres, source::Input, table::count};
use anyhow::{Result, bail};
use clap::Args;
use crumple::{ExampleSet, Mesh, ThreadPool, glam::Vec3};
use std::path::PathBuf;

/// Number of candidates for each impact. The one furthest from the impacts so far is kept (Mitchell's best candidate,
/// 1991).
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
    let impacts = sample(&source.set, arguments.count as usize, arguments.seed)?;
    file.fill(impacts::format(&impacts)?.as_bytes())?;
    file.commit()?;
    let depths = impacts.iter().map(|(_, u)| Vec3::from(*u).length());
    let (low, high) = depths.fold((f32::MAX, 0f32), |(l, h), d| (l.min(d), h.max(d)));
    Ok(format!(
        "{}: {}, {} to {} mm deep, seed {}\n",
        arguments.output.display(),
        count(impacts.len(), "impact", "impacts"),
        millimetres(low),
        millimetres(high),
        arguments.seed
    ))
}

/// Points spread over the surface, each with a displacement (m) into the body along the normal, as deep as the
/// examples.
fn sample(set: &ExampleSet, count: usize, seed: u64) -> Result<Vec<([f32; 3], [f32; 3])>> {
    let depths = set.examples().iter().filter(|e| !e.is_empty()).map(|e| e.depth());
    let (low, high) = depths.fold((f32::MAX, 0f32), |(l, h), d| (l.min(d), h.max(d)));
    if high <= 0.0 {
        bail!("no example moves a vertex, so there is no depth to sample; check the morph targets");
    }
    let mut random = Random(seed);
    let surface = Surface::new(set);
    let mut points: Vec<Vec3> = Vec::with_capacity(count);
    let mut impacts = Vec::with_capacity(count);
    for _ in 0..count {
        let mut best: Option<(f32, Vec3, Vec3)> = None;
        for _ in 0..CANDIDATES {
            let Some((p, normal)) = surface.pick(&mut random) else { continue };
            let distance = points.iter().map(|q| q.distance_squared(p)).fold(f32::MAX, f32::min);
            if best.is_none_or(|(d, ..)| distance > d) {
                best = Some((distance, p, normal));
            }
        }
        let Some((_, p, normal)) = best else {
            bail!(
                "no example moves a triangle that has an area, so there is no place to hit; write the impacts by hand"
            );
        };
        let depth = low + (high - low) * random.unit();
        points.push(p);
        impacts.push((p.to_array(), (-normal * depth).to_array()));
    }
    Ok(impacts)
}

/// Triangles with the running sum of their areas, for picking by area. Triangles that no example moves are left out,
/// because the examples do not show how the body dents there.
struct Surface<'a> {
    mesh: &'a Mesh,
    sums: Vec<f64>,
}

impl<'a> Surface<'a> {
    fn new(set: &'a ExampleSet) -> Surface<'a> {
        let mesh = set.mesh();
        let moved: Vec<bool> =
            (0..set.vertex_count() as u32).map(|v| set.examples().iter().any(|e| e.delta(v) != Vec3::ZERO)).collect();
        let mut sum = 0.0;
        let area = |t: &[u32; 3]| {
            if !t.iter().all(|&i| moved[i as usize]) {
                return sum;
            }
            let [a, b, c] = t.map(|i| mesh.positions()[i as usize].as_dvec3());
            sum += (b - a).cross(c - a).length();
            sum
        };
        Surface { mesh, sums: mesh.triangles().iter().map(area).collect() }
    }

    /// Picks a point. Also returns the outward unit normal of the nearest corner.
    fn pick(&self, random: &mut Random) -> Option<(Vec3, Vec3)> {
        let total = self.sums.last().copied().filter(|&total| total > 0.0)?;
        let at = f64::from(random.unit()) * total;
        let (u, v) = (random.unit().sqrt(), random.unit());
        let t = self.mesh.triangles().get(self.sums.partition_point(|&s| s <= at))?;
        let weights = [1.0 - u, u * (1.0 - v), u * v];
        let corners = t.map(|i| self.mesh.positions()[i as usize]);
        let p = corners.iter().zip(weights).map(|(&c, w)| c * w).sum::<Vec3>();
        let nearest = (0..3).max_by(|&a, &b| weights[a].total_cmp(&weights[b]))?;
        Some((p, self.mesh.contact_normal(t[nearest])?))
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
