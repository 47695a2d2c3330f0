//! A street after the crash: 1000 dented bodies from 1 m to 200 m before a camera. What levels of detail cost and
//! save, and how far off what is seen is, in pixels. And what a vertex budget does for frames with more hits than time.

mod raster;
pub mod simplify;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use anyhow::Result;
use crumple::import::{MeshChoice, gltf_file};
use crumple::{
    Attachment, DeformJob, DeformReport, Deltas, ExampleData, ExampleSet, Hit, Instance, InstanceOptions, MeshData,
    Serial, SetOptions, Tracker, VertexMemory, deform_within,
};
use glam::{Mat3, Vec3};
use raster::{FOV, HEIGHT, Place, Raster};

use crate::Options;
use crate::metric::{median, quantile};
use crate::stability::Dice;
use crate::table::{Table, num};

/// What is off on the screen may be so many pixels, for `Instance::set_view`.
const VIEWS: [f32; 6] = [0.125, 0.25, 0.5, 1.0, 2.0, 4.0];
/// Cells of the levels of detail, in edges of the base mesh.
const CELLS: [f32; 4] = [2.0, 4.0, 8.0, 16.0];
/// A pixel is dented where its surface point has moved by as many pixels.
const DENTED: f64 = 0.1;
/// The share of bodies that a frame hits.
const HIT_EACH_FRAME: usize = 10;
/// More hits than a frame has time for: on how many of the nearest bodies, and how many hits in each of how many frames.
const OVERLOAD: (usize, usize, usize) = (50, 440, 12);
/// Vertices a frame; the last is no limit.
const BUDGETS: [u64; 4] = [50_000, 100_000, 200_000, u64::MAX];

/// How bodies are shown.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Shown {
    /// The base mesh.
    Base,
    /// The level that [`Instance::set_view`] chooses for so many pixels.
    View(f32),
}

/// A body of which several stand in the scene.
struct Kind {
    set: Arc<ExampleSet>,
    /// Of each level from 1 on, where its surface is nearest to each base vertex.
    nearest: Vec<Vec<Attachment>>,
    radius: f32,
    centre: Vec3,
}

struct Body {
    kind: usize,
    place: Place,
    /// From the camera to the nearest point of its bounding sphere, m.
    distance: f32,
}

/// What one choice did.
#[derive(Default)]
struct Outcome {
    ms: Vec<f64>,
    vertices: u64,
    written: u64,
    bytes: usize,
    lods: Vec<usize>,
    /// Positions at the end, body by body.
    positions: Vec<Vec<Vec3>>,
}

pub fn run(options: &Options) -> Result<()> {
    let (count, frames) = if options.quick { (60, 4) } else { (1000, 20) };
    let kinds = kinds()?;
    let bodies = bodies(&kinds, count);
    seen(options, &kinds, &bodies, frames)?;
    overload(options, &kinds, &bodies)
}

fn seen(options: &Options, kinds: &[Kind], bodies: &[Body], frames: usize) -> Result<()> {
    let hits = hits(kinds, bodies, frames);
    let mut table = Table::new(&[
        "shown",
        "pixels",
        "ms_per_frame",
        "ms_p90",
        "vertices_per_frame",
        "blocks_per_frame",
        "bytes_bodies",
        "error_px_median",
        "error_px_p99",
        "error_px_max",
        "dent_error_px_p99",
        "dent_error_px_max",
    ]);
    let count = bodies.len();
    table.comment(
        "what",
        format!("{count} bodies from 1 m to 200 m, {frames} frames, a tenth of the bodies hit in each"),
    );
    table.comment(
        "cost",
        "submitting the hits and deforming all outputs, positions and normals, on one thread, median of the frames",
    );
    table.comment("error", "how far the surface point that covers a pixel is off on the screen, against the base mesh; 1920 x 1080, 60 degrees");
    table.comment(
        "dent_error",
        "the same without what a level's shape is off at rest, of pixels that dents move by a tenth of a pixel or more",
    );
    for (i, kind) in kinds.iter().enumerate() {
        let vertices: Vec<String> = (0..kind.set.lod_count())
            .map(|l| Ok(kind.set.lod_mesh(l)?.positions().len().to_string()))
            .collect::<Result<_>>()?;
        table.comment("levels", format!("{} vertices {}", NAMES[i], vertices.join(" ")));
    }
    // The first run warms and is the reference; what is measured then is the same again.
    let exact = play(kinds, bodies, &hits, Shown::Base)?;
    let mut raster = Raster::new();
    for (b, body) in bodies.iter().enumerate() {
        raster.draw(b as u32, &body.place, &exact.positions[b], kinds[body.kind].set.mesh().triangles());
    }
    for shown in std::iter::once(Shown::Base).chain(VIEWS.map(Shown::View)) {
        let got = play(kinds, bodies, &hits, shown)?;
        let e = Errors::measure(kinds, bodies, &raster, &exact, &got);
        let per_frame = |n: u64| num(n as f64 / frames as f64);
        let (name, pixels) = match shown {
            Shown::Base => ("base mesh", 0.0),
            Shown::View(pixels) => ("view", pixels),
        };
        table.row([
            name.to_owned(),
            num(pixels.into()),
            num(median(&got.ms)),
            num(quantile(&got.ms, 0.9)),
            per_frame(got.vertices),
            per_frame(got.written),
            got.bytes.to_string(),
            num(median(&e.all)),
            num(quantile(&e.all, 0.99)),
            num(quantile(&e.all, 1.0)),
            num(quantile(&e.dent, 0.99)),
            num(quantile(&e.dent, 1.0)),
        ])?;
    }
    table.write(&options.out, "scene.csv").map(drop)
}

/// Hits the nearest bodies far more often than there is time for, then waits until all is shown.
fn overload(options: &Options, kinds: &[Kind], bodies: &[Body]) -> Result<()> {
    let (near, each, frames) = OVERLOAD;
    let bodies = &bodies[..near.min(bodies.len())];
    let mut dice = Dice::new(440);
    let all: Vec<Vec<(usize, Hit)>> = (0..frames)
        .map(|_| (0..each).map(|_| one_hit(kinds, bodies, dice.index(bodies.len()), &mut dice)).collect())
        .collect();
    let mut table = Table::new(&[
        "budget",
        "hits_ms",
        "deform_ms",
        "deform_ms_max",
        "vertices_per_frame",
        "waiting_per_frame",
        "frames_after",
        "same_bits",
    ]);
    let what = format!("{each} hits in each of {frames} frames on the {} nearest bodies; then none", bodies.len());
    table.comment("what", what);
    table.comment(
        "cost",
        "submitting and folding the hits; deforming, positions and normals; one thread; median of the frames with hits",
    );
    let mut wanted: Option<Vec<Vec<[f32; 3]>>> = None;
    for budget in BUDGETS.into_iter().rev() {
        let mut street = Street::new(kinds, bodies, Shown::View(0.5))?;
        street.deform(u64::MAX)?;
        let (mut folding, mut deforming, mut vertices, mut waiting, mut after) = (Vec::new(), Vec::new(), 0, 0, 0);
        for hits in &all {
            let start = Instant::now();
            street.hit(hits)?;
            folding.push(start.elapsed().as_secs_f64() * 1e3);
            let start = Instant::now();
            let report = street.deform(budget)?;
            deforming.push(start.elapsed().as_secs_f64() * 1e3);
            (vertices, waiting) = (vertices + report.vertices_written, waiting + report.vertices_waiting);
        }
        let mut left = waiting;
        while left > 0 {
            left = street.deform(budget)?.vertices_waiting;
            after += 1;
        }
        let same = wanted.get_or_insert_with(|| street.positions.clone()) == &street.positions;
        let per_frame = |n: u64| num(n as f64 / frames as f64);
        table.row([
            if budget == u64::MAX { "none".to_owned() } else { budget.to_string() },
            num(median(&folding)),
            num(median(&deforming)),
            num(quantile(&deforming, 1.0)),
            per_frame(vertices),
            per_frame(waiting),
            after.to_string(),
            same.to_string(),
        ])?;
    }
    table.write(&options.out, "scene_budget.csv").map(drop)
}

const NAMES: [&str; 4] = ["demo hood", "demo drum", "solver panel", "solver tube"];

fn kinds() -> Result<Vec<Kind>> {
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets");
    let files = ["demo/hood.glb", "demo/drum.glb", "solver/panel.glb", "solver/tube.glb"];
    files.iter().map(|file| kind(assets.join(file))).collect()
}

fn kind(path: PathBuf) -> Result<Kind> {
    let imported = gltf_file(&path, MeshChoice::First)?;
    let (mesh, examples) = (MeshData { tangents: None, ..imported.mesh }, imported.examples);
    let base = simplify::edge(&mesh);
    let levels: Vec<MeshData> = CELLS.iter().map(|c| simplify::clustered(&mesh, base * c)).collect();
    let depth = SetOptions { tolerance: Some(5e-5), ..SetOptions::default() };
    let positions = mesh.positions.clone();
    let mut set = ExampleSet::build(mesh, examples, depth, &Serial)?;
    let mut nearest = Vec::new();
    for level in levels {
        // Only to find places on its surface.
        let one = ExampleData::new("", Deltas::Sparse { indices: vec![0], values: vec![[0.0, 0.0, 1.0]] });
        let finder = ExampleSet::build(
            level.clone(),
            vec![one],
            SetOptions { mirror: false, ..SetOptions::default() },
            &Serial,
        )?;
        nearest.push(positions.iter().map(|p| finder.attach(*p)).collect::<Result<_, _>>()?);
        set.add_lod(level, &Serial)?;
    }
    let bounds = set.mesh().bounds();
    let (radius, centre) = (bounds.diagonal() / 2.0, (bounds.min + bounds.max) / 2.0);
    Ok(Kind { set: Arc::new(set), nearest, radius, centre })
}

fn between(dice: &mut Dice, low: f64, high: f64) -> f32 {
    dice.between(low, high) as f32
}

fn bodies(kinds: &[Kind], count: usize) -> Vec<Body> {
    let mut dice = Dice::new(200);
    (0..count)
        .map(|i| {
            let kind = i % kinds.len();
            let far = 1.0 + 199.0 * (i as f32 / (count - 1) as f32).powf(1.5) + kinds[kind].radius;
            let turn = Mat3::from_rotation_y(between(&mut dice, 0.0, std::f64::consts::TAU))
                * Mat3::from_rotation_x(between(&mut dice, -1.8, -0.6));
            // Within the middle nine tenths of the view.
            let high = 0.9 * (FOV / 2.0).tan();
            let ray =
                Vec3::new(between(&mut dice, -1.0, 1.0) * high * 16.0 / 9.0, between(&mut dice, -1.0, 1.0) * high, 1.0)
                    .normalize();
            let place = Place { turn, at: ray * far - turn * kinds[kind].centre };
            Body { kind, place, distance: far - kinds[kind].radius }
        })
        .collect()
}

fn one_hit(kinds: &[Kind], bodies: &[Body], body: usize, dice: &mut Dice) -> (usize, Hit) {
    let set = &kinds[bodies[body].kind].set;
    let v = dice.index(set.vertex_count());
    let normal = set.mesh().contact_normal(v as u32).unwrap_or(Vec3::Z);
    let depth = set.depth_limit() * between(dice, 0.1, 0.8);
    (body, Hit::displacement(set.mesh().positions()[v].to_array(), (normal * -depth).to_array()))
}

/// Body and hit, frame by frame.
fn hits(kinds: &[Kind], bodies: &[Body], frames: usize) -> Vec<Vec<(usize, Hit)>> {
    let mut dice = Dice::new(7);
    let frame = |dice: &mut Dice| {
        let one = |_| one_hit(kinds, bodies, dice.index(bodies.len()), dice);
        (0..bodies.len() / HIT_EACH_FRAME).map(one).collect()
    };
    (0..frames).map(|_| frame(&mut dice)).collect()
}

/// Bodies and their vertices.
struct Street {
    instances: Vec<Instance>,
    lods: Vec<usize>,
    trackers: Vec<Tracker>,
    positions: Vec<Vec<[f32; 3]>>,
    normals: Vec<Vec<[f32; 3]>>,
}

impl Street {
    fn new(kinds: &[Kind], bodies: &[Body], shown: Shown) -> Result<Self> {
        let (mut instances, mut lods, mut positions) = (Vec::new(), Vec::new(), Vec::new());
        for body in bodies {
            let set = &kinds[body.kind].set;
            let mut instance = Instance::new(set.clone(), InstanceOptions::default())?;
            let lod = match shown {
                Shown::Base => 0,
                Shown::View(pixels) => instance.set_view(pixels, body.distance, FOV, HEIGHT as f32)?,
            };
            instances.push(instance);
            positions.push(vec![[0.0; 3]; set.lod_mesh(lod)?.positions().len()]);
            lods.push(lod);
        }
        let trackers = vec![Tracker::new(); bodies.len()];
        Ok(Street { instances, lods, trackers, normals: positions.clone(), positions })
    }

    fn hit(&mut self, hits: &[(usize, Hit)]) -> Result<()> {
        for (body, hit) in hits {
            self.instances[*body].submit(hit)?;
        }
        self.instances.iter_mut().for_each(Instance::fold);
        Ok(())
    }

    fn deform(&mut self, budget: u64) -> Result<DeformReport> {
        let memory = self.positions.iter_mut().zip(&mut self.normals);
        let outputs = self.instances.iter().zip(&mut self.trackers).zip(&self.lods).zip(memory);
        let mut jobs = Vec::with_capacity(self.lods.len());
        for (((instance, tracker), lod), (p, n)) in outputs {
            jobs.push(DeformJob { lod: *lod, instance, tracker, memory: VertexMemory::separate(p, Some(n), None)? });
        }
        Ok(deform_within(&mut jobs, budget, &Serial)?)
    }
}

fn play(kinds: &[Kind], bodies: &[Body], hits: &[Vec<(usize, Hit)>], shown: Shown) -> Result<Outcome> {
    let mut street = Street::new(kinds, bodies, shown)?;
    // At first everything is written, at rest: that is loading, not the frames.
    street.deform(u64::MAX)?;
    let mut out = Outcome::default();
    for hits in hits {
        let start = Instant::now();
        street.hit(hits)?;
        let report = street.deform(u64::MAX)?;
        out.ms.push(start.elapsed().as_secs_f64() * 1e3);
        out.vertices += report.vertices_written;
        out.written += report.blocks_written;
    }
    let floats = |all: &[Vec<[f32; 3]>]| all.iter().map(|v| v.len() * 12).sum::<usize>();
    let marks = street.instances.iter().map(Instance::memory_bytes).sum::<usize>();
    out.bytes = marks + floats(&street.positions) + floats(&street.normals);
    out.positions = street.positions.into_iter().map(|p| p.into_iter().map(Vec3::from).collect()).collect();
    out.lods = street.lods;
    Ok(out)
}

/// Errors on the screen, pixels.
#[derive(Default)]
struct Errors {
    /// Of all covered pixels.
    all: Vec<f64>,
    /// Of dented pixels, without what the level's shape is off at rest.
    dent: Vec<f64>,
}

impl Errors {
    fn measure(kinds: &[Kind], bodies: &[Body], seen: &Raster, exact: &Outcome, got: &Outcome) -> Self {
        let mut e = Errors::default();
        // Where the base mesh's vertices are on a level with these vertices.
        let on = |b: usize, level: &[Vec3]| -> Vec<Vec3> {
            match got.lods[b] {
                0 => level.to_vec(),
                l => kinds[bodies[b].kind].nearest[l - 1].iter().map(|a| mix(level, a)).collect(),
            }
        };
        let of_got: Vec<Vec<Vec3>> = (0..bodies.len()).map(|b| on(b, &got.positions[b])).collect();
        let at_rest = |b: usize| {
            let set = &kinds[bodies[b].kind].set;
            on(b, set.lod_mesh(got.lods[b]).map_or(&[][..], |m| m.positions()))
        };
        let rest: Vec<Vec<Vec3>> = (0..bodies.len()).map(at_rest).collect();
        for hit in seen.hits() {
            let (b, w) = (hit.body as usize, hit.weights);
            let (body, mesh) = (&bodies[b], kinds[bodies[b].kind].set.mesh());
            let t = mesh.triangles()[hit.triangle as usize];
            let point = |p: &[Vec3]| p[t[0] as usize] * w[0] + p[t[1] as usize] * w[1] + p[t[2] as usize] * w[2];
            let (truth, got, base) = (point(&exact.positions[b]), point(&of_got[b]), point(mesh.positions()));
            let off = |a: Vec3, b: Vec3| match (body.place.project(a), body.place.project(b)) {
                (Some(a), Some(b)) => f64::from((a - b).truncate().length()),
                _ => f64::NAN,
            };
            e.all.push(off(truth, got));
            if off(truth, base) >= DENTED {
                e.dent.push(off(truth, base + (got - point(&rest[b]))));
            }
        }
        e
    }
}

fn mix(p: &[Vec3], a: &Attachment) -> Vec3 {
    (0..3).map(|k| p[a.vertices[k] as usize] * a.weights[k]).sum()
}
