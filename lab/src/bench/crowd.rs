//! Many bodies in one frame: two hundred hoods of four parts that ten contacts hit, and two hundred drums just after loading.

use std::sync::Arc;
use std::time::Instant;

use anyhow::Result;
use crumple::{
    DeformJob, ExampleSet, Hit, Instance, InstanceOptions, MeshData, Serial, TaskSystem, Tracker, VertexMemory, deform,
    fold_all, load_all, save_all,
};

use super::Bench;
use super::measure::Times;
use super::nodes::{blows, hits, made, set};
use super::report::{Aim, Row};

const BODIES: usize = 200;
const PARTS: usize = 4;
const HITS_A_FRAME: usize = 10;
const FRAMES: usize = 300;
const MARKS: usize = 16;

/// Frames of ten blows on two hundred hoods, each drawn as four meshes, after as many frames that nothing is measured of.
pub fn hoods(bench: &Bench) -> Result<()> {
    let mut whole = set(bench, "hood", 12)?;
    for part in quarters(whole.mesh().positions(), whole.mesh().triangles()) {
        whole.add_lod(part, bench.tasks(2))?;
    }
    let whole = Arc::new(whole);
    let blows = blows(&whole, 2 * FRAMES * HITS_A_FRAME);
    let mut crowd = Crowd::new(&whole, BODIES, 1..PARTS + 1)?;
    let frames = blows.chunks(HITS_A_FRAME).enumerate().map(|(i, hits)| crowd.frame(i, hits));
    let times: Vec<f64> = frames.skip(FRAMES).collect();
    let (mean, times) = (times.iter().sum::<f64>() / FRAMES as f64, Times::new(times));
    bench.add(Row::new("crowd_hood", 1e3 * mean, "ms").aim(Aim::Value(3.0)));
    bench.add(Row::new("crowd_hood_p99", 1e3 * times.quantile(0.99), "ms").aim(Aim::Value(5.0)));
    let bytes = crowd.instances.iter().map(Instance::memory_bytes).sum::<usize>() as f64 / BODIES as f64;
    bench.add(Row::new("crowd_hood_bytes", bytes / 1e3, "kB/instance").aim(Aim::Value(60.0)));
    Ok(())
}

/// The first frame of two hundred drums with sixteen marks each, from saved bytes to all vertices with normals.
pub fn drums(bench: &Bench) -> Result<()> {
    let drum = Arc::new(set(bench, "drum", 8)?);
    let hits = hits(&drum, BODIES + MARKS);
    let mut saved = Crowd::new(&drum, BODIES, 0..0)?;
    for (body, instance) in saved.instances.iter_mut().enumerate() {
        instance.set_marks(&made(&drum, InstanceOptions::default(), &hits[body..][..MARKS])?)?;
    }
    let saved = save_all(&mut saved.instances);
    for (name, threads) in [("restore_200", 1), ("restore_200_t2", 2)] {
        if !bench.wanted(name) {
            continue;
        }
        let restore = |_| {
            let mut crowd = Crowd::new(&drum, BODIES, 0..1)?;
            let tasks = bench.tasks(threads);
            let start = Instant::now();
            load_all(&mut crowd.instances.iter_mut().collect::<Vec<_>>(), &saved, tasks)?;
            crowd.deform(tasks);
            Ok(start.elapsed().as_secs_f64())
        };
        let runs = if bench.quick { 2 } else { 7 };
        let times = Times::new((0..runs).map(restore).collect::<Result<_>>()?);
        bench.add(Row::time(name, &times, "ms").aim(Aim::Value(150.0)));
    }
    Ok(())
}

/// The mesh cut in four by its triangles' centres along its longest side.
fn quarters(positions: &[glam::Vec3], triangles: &[[u32; 3]]) -> Vec<MeshData> {
    let along = |t: &[u32; 3]| t.iter().map(|v| positions[*v as usize].x).sum::<f32>();
    let mut sorted = triangles.to_vec();
    sorted.sort_by(|a, b| along(a).total_cmp(&along(b)));
    let part = |own: &[[u32; 3]]| {
        let mut used: Vec<u32> = own.iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        let place = |v: u32| used.partition_point(|u| *u < v) as u32;
        MeshData {
            positions: used.iter().map(|v| positions[*v as usize].to_array()).collect(),
            triangles: own.iter().map(|t| t.map(place)).collect(),
            ..MeshData::default()
        }
    };
    sorted.chunks(sorted.len().div_ceil(PARTS)).map(part).collect()
}

/// Bodies and their outputs: positions and normals of some of the set's meshes.
pub struct Crowd {
    pub instances: Vec<Instance>,
    /// Of each body in turn, one for each mesh.
    outputs: Vec<Output>,
    meshes: usize,
}

struct Output {
    lod: usize,
    tracker: Tracker,
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
}

impl Crowd {
    /// All at rest and written.
    pub fn new(set: &Arc<ExampleSet>, bodies: usize, lods: std::ops::Range<usize>) -> Result<Self> {
        let instance = |_| Instance::new(set.clone(), InstanceOptions::default());
        let instances = (0..bodies).map(instance).collect::<Result<Vec<_>, _>>()?;
        let output = |lod| -> Result<Output> {
            let rest = vec![[0.0; 3]; set.lod_mesh(lod)?.positions().len()];
            Ok(Output { lod, tracker: Tracker::new(), positions: rest.clone(), normals: rest })
        };
        let meshes = lods.len();
        let outputs = (0..bodies).flat_map(|_| lods.clone().map(output)).collect::<Result<_>>()?;
        let mut crowd = Self { instances, outputs, meshes };
        crowd.deform(&Serial);
        Ok(crowd)
    }

    /// Hits one body after another, and writes what changed. Returns the seconds that it took.
    fn frame(&mut self, number: usize, hits: &[Hit]) -> f64 {
        let start = Instant::now();
        for (i, hit) in hits.iter().enumerate() {
            let body = (number * hits.len() + i) * 7 % BODIES;
            self.instances[body].submit(hit).unwrap_or_else(|e| panic!("{e}"));
        }
        fold_all(&mut self.instances, &Serial);
        self.deform(&Serial);
        start.elapsed().as_secs_f64()
    }

    pub fn positions(&self) -> Vec<[f32; 3]> {
        self.outputs.iter().flat_map(|output| output.positions.iter().copied()).collect()
    }

    pub fn deform(&mut self, tasks: &dyn TaskSystem) {
        let mut jobs = Vec::with_capacity(self.outputs.len());
        for (i, Output { lod, tracker, positions, normals }) in self.outputs.iter_mut().enumerate() {
            let memory = VertexMemory::separate(positions, Some(normals), None).unwrap_or_else(|e| panic!("{e}"));
            jobs.push(DeformJob { lod: *lod, instance: &self.instances[i / self.meshes], tracker, memory });
        }
        deform(&mut jobs, tasks).unwrap_or_else(|e| panic!("{e}"));
    }
}
