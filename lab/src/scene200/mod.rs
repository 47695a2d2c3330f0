//! A street after the crash: 200 dented bodies from 1 m to 300 m before a camera. What run-time tolerances and levels of detail
//! cost and save, and how far off what is seen is, in pixels.

mod raster;
mod simplify;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use anyhow::Result;
use crumple::import::{MeshChoice, gltf_file};
use crumple::{
    Attachment, DeformJob, Deltas, ExampleData, ExampleSet, Hit, Instance, InstanceOptions, MeshData, Serial,
    SetOptions, Tracker, VertexMemory, deform, pixel_tolerance,
};
use glam::{Mat3, Vec3};
use raster::{FOV, HEIGHT, Place, Raster};

use crate::Options;
use crate::metric::{median, quantile};
use crate::stability::Dice;
use crate::table::{Table, num};

/// Tolerances, pixels.
const PIXELS: [f32; 6] = [0.0, 0.125, 0.25, 0.5, 1.0, 2.0];
/// Cells of the levels of detail, in edges of the base mesh.
const CELLS: [f32; 4] = [2.0, 4.0, 8.0, 16.0];
/// The coarsest level whose edges cover no more pixels than this is shown; 0: always the base mesh.
const EDGES: [f32; 4] = [0.0, 4.0, 8.0, 16.0];
/// A pixel is dented where its surface point has moved by as many pixels.
const DENTED: f64 = 0.1;
/// The share of bodies that a frame hits.
const HIT_EACH_FRAME: usize = 10;

/// A body of which several stand in the scene.
struct Kind {
    set: Arc<ExampleSet>,
    /// Root mean square edge of each level, m.
    edges: Vec<f32>,
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
struct Outcome {
    ms: Vec<f64>,
    vertices: u64,
    written: u64,
    skipped: u64,
    parts: u64,
    bytes: usize,
    lods: Vec<usize>,
    /// Positions at the end, body by body.
    positions: Vec<Vec<Vec3>>,
}

pub fn run(options: &Options) -> Result<()> {
    let (count, frames) = if options.quick { (40, 6) } else { (200, 30) };
    let kinds = kinds()?;
    let bodies = bodies(&kinds, count);
    let hits = hits(&kinds, &bodies, frames);
    let mut table = Table::new(&[
        "outputs",
        "lod_edge_px",
        "tolerance_px",
        "ms_per_frame",
        "ms_p90",
        "vertices_per_frame",
        "blocks_per_frame",
        "blocks_up_to_date",
        "parts_skipped",
        "bytes_sets",
        "bytes_bodies",
        "error_px_median",
        "error_px_p99",
        "error_px_max",
        "tolerance_error_px_p99",
        "tolerance_error_px_max",
        "lod_error_px_p99",
        "lod_error_px_max",
        "lod_dent_error_px_p99",
        "lod_dent_error_px_max",
        "covered_pixels",
        "dented_pixels",
    ]);
    table.comment(
        "what",
        format!("{count} bodies from 1 m to 300 m, {} frames, a tenth of the bodies hit in each", frames),
    );
    table.comment("cost", "submitting the hits and deforming all outputs on one thread, median of the frames");
    table.comment("dented", "pixels whose surface point the dents move by a tenth of a pixel or more: those that tolerance and lod_dent errors are of");
    table.comment("error", "how far the surface point that covers a pixel is off on the screen, against the base mesh without tolerance; 1920 x 1080, 60 degrees");
    for (i, kind) in kinds.iter().enumerate() {
        let vertices: Vec<String> = (0..kind.set.lod_count())
            .map(|l| Ok(kind.set.lod_mesh(l)?.positions().len().to_string()))
            .collect::<Result<_>>()?;
        table.comment(
            "levels",
            format!("{} vertices {}, set {} bytes", NAMES[i], vertices.join(" "), kind.set.memory_bytes()),
        );
    }
    let set_bytes: usize = kinds.iter().map(|k| k.set.memory_bytes()).sum();
    // The first run warms and is the reference; what is measured then is the same again.
    let exact = play(&kinds, &bodies, &hits, 0.0, 0.0, true)?;
    let mut seen = Raster::new();
    for (b, body) in bodies.iter().enumerate() {
        seen.draw(b as u32, &body.place, &exact.positions[b], kinds[body.kind].set.mesh().triangles());
    }
    // Positions alone for comparison of the cost; what they are off is the same.
    for (normals, edges) in [(true, &EDGES[..]), (false, &EDGES[..1])] {
        for edge in edges.iter().copied() {
            let mut plain: Option<Outcome> = None;
            for pixels in PIXELS {
                let got = play(&kinds, &bodies, &hits, pixels, edge, normals)?;
                let base = plain.as_ref().unwrap_or(&got);
                let e = match normals {
                    true => Errors::measure(&kinds, &bodies, &seen, &exact, base, &got),
                    false => Errors::default(),
                };
                let per_frame = |n: u64| num(n as f64 / frames as f64);
                table.row([
                    (if normals { "positions and normals" } else { "positions" }).to_owned(),
                    num(edge.into()),
                    num(pixels.into()),
                    num(median(&got.ms)),
                    num(quantile(&got.ms, 0.9)),
                    per_frame(got.vertices),
                    per_frame(got.written),
                    per_frame(got.skipped),
                    per_frame(got.parts),
                    set_bytes.to_string(),
                    got.bytes.to_string(),
                    num(median(&e.all)),
                    num(quantile(&e.all, 0.99)),
                    num(quantile(&e.all, 1.0)),
                    num(quantile(&e.tolerance, 0.99)),
                    num(quantile(&e.tolerance, 1.0)),
                    num(quantile(&e.lod, 0.99)),
                    num(quantile(&e.lod, 1.0)),
                    num(quantile(&e.dent, 0.99)),
                    num(quantile(&e.dent, 1.0)),
                    e.all.len().to_string(),
                    e.tolerance.len().to_string(),
                ])?;
                if pixels == 0.0 {
                    plain = Some(got);
                }
            }
        }
    }
    table.write(&options.out, "scene.csv").map(drop)
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
    let mut edges = vec![base];
    edges.extend(levels.iter().map(simplify::edge));
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
    Ok(Kind { set: Arc::new(set), edges, nearest, radius, centre })
}

fn between(dice: &mut Dice, low: f64, high: f64) -> f32 {
    dice.between(low, high) as f32
}

fn bodies(kinds: &[Kind], count: usize) -> Vec<Body> {
    let mut dice = Dice::new(200);
    (0..count)
        .map(|i| {
            let kind = i % kinds.len();
            let far = 1.0 + 299.0 * (i as f32 / (count - 1) as f32).powf(1.5) + kinds[kind].radius;
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

/// Body and hit, frame by frame.
fn hits(kinds: &[Kind], bodies: &[Body], frames: usize) -> Vec<Vec<(usize, Hit)>> {
    let mut dice = Dice::new(7);
    let one = |body: usize, dice: &mut Dice| {
        let set = &kinds[bodies[body].kind].set;
        let v = dice.index(set.vertex_count());
        let normal = set.mesh().contact_normal(v as u32).unwrap_or(Vec3::Z);
        let depth = set.depth_limit() * between(dice, 0.1, 0.8);
        (body, Hit::displacement(set.mesh().positions()[v].to_array(), (normal * -depth).to_array()))
    };
    (0..frames)
        .map(|_| (0..bodies.len() / HIT_EACH_FRAME).map(|_| one(dice.index(bodies.len()), &mut dice)).collect())
        .collect()
}

/// The coarsest level whose edges cover at most so many pixels.
fn level(kind: &Kind, distance: f32, edge: f32) -> usize {
    let allowed = pixel_tolerance(edge, distance.max(0.1), FOV, HEIGHT as f32);
    (1..kind.edges.len()).rev().find(|l| kind.edges[*l] <= allowed).unwrap_or(0)
}

fn play(
    kinds: &[Kind],
    bodies: &[Body],
    hits: &[Vec<(usize, Hit)>],
    pixels: f32,
    edge: f32,
    normals: bool,
) -> Result<Outcome> {
    let mut instances = Vec::new();
    let mut lods = Vec::new();
    for body in bodies {
        let tolerance = pixel_tolerance(pixels, body.distance, FOV, HEIGHT as f32);
        let options = InstanceOptions { tolerance, ..InstanceOptions::default() };
        instances.push(Instance::new(kinds[body.kind].set.clone(), options)?);
        lods.push(level(&kinds[body.kind], body.distance, edge));
    }
    let mesh = |b: usize| kinds[bodies[b].kind].set.lod_mesh(lods[b]);
    let mut positions: Vec<Vec<[f32; 3]>> =
        (0..bodies.len()).map(|b| Ok(vec![[0.0; 3]; mesh(b)?.positions().len()])).collect::<Result<_>>()?;
    let mut turned: Vec<Vec<[f32; 3]>> = if normals { positions.clone() } else { vec![Vec::new(); bodies.len()] };
    let mut trackers = vec![Tracker::new(); bodies.len()];
    let mut out = Outcome {
        ms: Vec::new(),
        vertices: 0,
        written: 0,
        skipped: 0,
        parts: 0,
        bytes: 0,
        lods,
        positions: Vec::new(),
    };
    // At first everything is written, at rest: that is loading, not the frames.
    let nothing = Vec::new();
    for (frame, hits) in std::iter::once(&nothing).chain(hits).enumerate() {
        let start = Instant::now();
        for (body, hit) in hits {
            instances[*body].submit(hit)?;
            instances[*body].fold();
        }
        let mut jobs = Vec::with_capacity(bodies.len());
        for ((((instance, tracker), p), n), lod) in
            instances.iter().zip(&mut trackers).zip(&mut positions).zip(&mut turned).zip(&out.lods)
        {
            let memory = VertexMemory::separate(p, normals.then_some(n.as_mut_slice()), None)?;
            jobs.push(DeformJob { lod: *lod, instance, tracker, memory });
        }
        let report = deform(&mut jobs, &Serial)?;
        if frame > 0 {
            out.ms.push(start.elapsed().as_secs_f64() * 1e3);
            out.vertices += report.vertices_written;
            out.written += report.blocks_written;
            out.skipped += report.blocks_skipped;
            out.parts += report.parts_skipped;
        }
    }
    let floats = |all: &[Vec<[f32; 3]>]| all.iter().map(|v| v.len() * 12).sum::<usize>();
    out.bytes = instances.iter().map(Instance::memory_bytes).sum::<usize>() + floats(&positions) + floats(&turned);
    out.positions = positions.into_iter().map(|p| p.into_iter().map(Vec3::from).collect()).collect();
    Ok(out)
}

/// Errors on the screen of all covered pixels, pixels.
#[derive(Default)]
struct Errors {
    all: Vec<f64>,
    /// Against the same level without tolerance.
    tolerance: Vec<f64>,
    /// Of the level without tolerance.
    lod: Vec<f64>,
    /// The same, of displacements alone: without what the level's shape is off at rest.
    dent: Vec<f64>,
}

impl Errors {
    fn measure(
        kinds: &[Kind],
        bodies: &[Body],
        seen: &Raster,
        exact: &Outcome,
        plain: &Outcome,
        got: &Outcome,
    ) -> Self {
        let mut e = Errors::default();
        // Where the base mesh's vertices are on what is shown.
        let on = |o: &Outcome, b: usize| -> Vec<Vec3> {
            let kind = &kinds[bodies[b].kind];
            match o.lods[b] {
                0 => o.positions[b].clone(),
                l => kind.nearest[l - 1].iter().map(|a| mix(&o.positions[b], a)).collect(),
            }
        };
        let at_rest = |b: usize| -> Vec<Vec3> {
            let kind = &kinds[bodies[b].kind];
            let base = kind.set.mesh().positions();
            match plain.lods[b] {
                0 => base.to_vec(),
                l => {
                    let level = kind.set.lod_mesh(l).map_or(base, |m| m.positions());
                    kind.nearest[l - 1].iter().map(|a| mix(level, a)).collect()
                }
            }
        };
        let all = |o: &Outcome| -> Vec<Vec<Vec3>> { (0..bodies.len()).map(|b| on(o, b)).collect() };
        let (of_plain, of_got) = (all(plain), all(got));
        let rest: Vec<Vec<Vec3>> = (0..bodies.len()).map(at_rest).collect();
        for hit in seen.hits() {
            let (b, w) = (hit.body as usize, hit.weights);
            let (body, set) = (&bodies[b], &kinds[bodies[b].kind].set);
            let t = set.mesh().triangles()[hit.triangle as usize];
            let point = |p: &[Vec3]| p[t[0] as usize] * w[0] + p[t[1] as usize] * w[1] + p[t[2] as usize] * w[2];
            let (truth, plain, got) = (point(&exact.positions[b]), point(&of_plain[b]), point(&of_got[b]));
            let dented = point(set.mesh().positions()) + (plain - point(&rest[b]));
            let off = |a: Vec3, b: Vec3| match (body.place.project(a), body.place.project(b)) {
                (Some(a), Some(b)) => f64::from((a - b).truncate().length()),
                _ => f64::NAN,
            };
            e.all.push(off(truth, got));
            e.lod.push(off(truth, plain));
            if off(truth, point(set.mesh().positions())) >= DENTED {
                e.tolerance.push(off(plain, got));
                e.dent.push(off(truth, dented));
            }
        }
        e
    }
}

fn mix(p: &[Vec3], a: &Attachment) -> Vec3 {
    (0..3).map(|k| p[a.vertices[k] as usize] * a.weights[k]).sum()
}
