//! A real engine's contacts, end to end: each hit again in an engine, with the body rigid and fixed. The engine's contact points
//! go through the contact layer, and what it makes of them is all that Crumple is told. The difference to the blow itself is
//! the error that engine and layer add.

use std::path::Path;
use std::sync::Arc;

use anyhow::{Context, Result, ensure};
use crumple::{ContactOptions, ExampleSet, Hit, Instance, InstanceOptions};
use rapier3d::prelude::*;

use super::rapier_contacts::RapierContacts;
use crate::Options;
use crate::metric::{deepest, dot64, median, quantile, relative_l2, sub};
use crate::scene;
use crate::table::{Table, num};
use crate::truth::{self, Body, Field, Impact, Truth};

/// The truths that know their blows.
const TRUTHS: [Truth; 4] = [Truth::Shots, Truth::Structure, Truth::Steel, Truth::Dense];
const RATES: [f32; 3] = [30.0, 60.0, 240.0];
/// Numbers of examples; the second is cut to what a body has.
const EXAMPLES: [usize; 2] = [24, 100];
const FRICTION: f32 = 0.4;
/// The striker's way before the touch, m, beside a part of a step that differs from hit to hit.
const RUN_UP: f32 = 0.1;
/// Half of a box's edge, as a share of the ball's radius: its face is a touch of four points.
const HALF: f32 = 0.5;
/// How long a throw goes on after the striker must have touched, s.
const AFTER: f32 = 0.2;
/// Above every dent, m.
const DEEP: f32 = 1.0;
/// A dent that moves nothing this far is none, m. Its depth is not compared among rates.
const LEAST: f64 = 0.001;

/// The aims: how far the median error may be from that of being told the blow, and the dents of the rates from each other.
const WITHIN: f64 = 0.03;
const APART: f64 = 0.05;
/// What engines reach of them, for `--check`: the median error's distance, and that of the rates. A solver decides how it spreads a box's
/// impulse over its points, and Bullet's pushes bodies apart that sank into a mesh. Bullet's continuous collision detection sweeps a ball, also
/// for a box: the first contact is then at the ball's place, and at a crease with a normal that is not the surface's. Jolt's ends at the
/// first triangle, so that a box which lands flat begins to turn there, and reports near triangles that a ball does not touch.
const FLOORS: [(&str, Shape, f64, f64); 6] = [
    ("rapier", Shape::Ball, 0.05, 0.03),
    ("rapier", Shape::Box, 0.08, 0.05),
    ("bullet", Shape::Ball, 0.07, 0.04),
    ("bullet", Shape::Box, 0.11, 0.07),
    ("jolt", Shape::Ball, 0.16, 0.06),
    ("jolt", Shape::Box, 0.13, 0.17),
];
/// rapier, and the programs of lab/throws.
const ENGINES: [&str; 3] = ["rapier", "bullet", "jolt"];

const COLUMNS: [&str; 15] = [
    "engine",
    "truth",
    "body",
    "examples",
    "striker",
    "hz",
    "rel_l2_median",
    "rel_l2_p90",
    "told_blow_median",
    "told_blow_p90",
    "point_off_mm_median",
    "rates_apart_median",
    "rates_apart_p90",
    "missed",
    "n",
];

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Shape {
    Ball,
    Box,
}

/// A hit thrown at a rate of steps.
struct Throw<'a> {
    impact: &'a Impact,
    blow: truth::Blow,
    shape: Shape,
    hz: f32,
    /// The touch falls into another part of the step at each hit.
    phase: f32,
}

/// What a throw left.
struct Left {
    field: Field,
    /// The vertex that the first mark names. `None` if there is no mark.
    contact: Option<u32>,
}

impl Throw<'_> {
    fn half(&self) -> f32 {
        if self.shape == Shape::Ball { self.blow.radius } else { HALF * self.blow.radius }
    }

    fn start(&self) -> Vector {
        let before = RUN_UP + self.phase * self.speed() / self.hz;
        vector(self.impact.point) + vector(self.blow.normal) * self.half() - vector(self.impact.direction) * before
    }

    fn speed(&self) -> f32 {
        vector(self.blow.velocity).length()
    }

    fn seconds(&self) -> f32 {
        AFTER + (2.0 * RUN_UP + self.blow.radius) / self.speed() + 2.0 / self.hz
    }

    /// Turns z to the contact normal.
    fn turn(&self) -> Rotation {
        Rotation::from_rotation_arc(Vector::Z, vector(self.blow.normal).normalize())
    }
}

pub fn run(options: &Options, programs: Option<&Path>, check: bool) -> Result<()> {
    let program = |engine: &str| programs.map(|folder| folder.join(engine)).filter(|program| program.exists());
    let mut table = Table::new(&COLUMNS);
    table.comment("command", "cargo xtask lab --only contacts");
    table.comment("rapier", format!("rapier3d {}, continuous collision detection", super::VERSION));
    for engine in ENGINES.iter().filter(|engine| program(engine).is_some()) {
        table.comment(engine, format!("lab/throws/{engine}.cpp, continuous collision detection"));
    }
    table.comment(
        "rel_l2",
        "Crumple is told what the contact layer makes of the engine's points; a hit that it misses counts as no dent",
    );
    table.comment("told_blow", "Crumple is told the blow itself");
    table.comment("rates_apart", "deepest of a hit's dents at the three rates over the shallowest, less 1");
    let mut over = 0;
    for (truth, name) in TRUTHS.iter().flat_map(|truth| truth.bodies().iter().map(|name| (*truth, *name))) {
        let body = Body::read(truth, name)?.with_free();
        let most = if options.quick { 4 } else { usize::MAX };
        // Poles are none of the strikers here.
        let hits = body.heldout.iter().chain(&body.play).filter_map(|i| Some((i, i.blow?.in_engine())));
        let hits: Vec<(&Impact, truth::Blow)> = hits.filter(|(_, blow)| !blow.pole).take(most).collect();
        let shape = mesh(&body)?;
        // A check is done with the smaller sets, which learn sooner.
        let counts = if check { &EXAMPLES[..1] } else { &EXAMPLES[..] };
        for examples in counts.iter().map(|n| (*n).min(body.train.len())) {
            let set = scene::with_nodes(&body, examples)?;
            let ours = InstanceOptions { depth_limit: Some(DEEP), ..Default::default() };
            let told = |(i, b): &(&Impact, truth::Blow)| -> Result<f64> {
                Ok(relative_l2(&scene::field_after(&set, &ours, &[Hit::blow(i.point, scene::blow(b))])?, &i.field))
            };
            let told: Vec<f64> = hits.iter().map(told).collect::<Result<_>>()?;
            for (engine, striker) in ENGINES.into_iter().flat_map(|e| [(e, Shape::Ball), (e, Shape::Box)]) {
                let throws = |hz: f32| -> Vec<Throw<'_>> {
                    let phase = |index: usize| (0.618 * index as f32).fract();
                    let hits = hits.iter().enumerate();
                    hits.map(|(i, (impact, blow))| Throw { impact, blow: *blow, shape: striker, hz, phase: phase(i) })
                        .collect()
                };
                let left: Vec<Vec<Left>> = match program(engine) {
                    Some(program) => in_program(&program, &set, &RATES.map(throws))?,
                    None if engine == "rapier" => RATES
                        .iter()
                        .map(|hz| throws(*hz).iter().map(|t| strike(&set, &ours, &shape, t)).collect())
                        .collect::<Result<_>>()?,
                    None => continue,
                };
                let apart: Vec<f64> = (0..hits.len())
                    .filter_map(|i| {
                        let depths = left.iter().map(|at_rate| deepest(&at_rate[i].field));
                        let (low, high) = depths.fold((f64::INFINITY, 0.0f64), |(l, h), d| (l.min(d), h.max(d)));
                        (low > LEAST).then(|| high / low - 1.0)
                    })
                    .collect();
                for (hz, left) in RATES.iter().zip(&left) {
                    let errors: Vec<f64> =
                        hits.iter().zip(left).map(|((i, _), l)| relative_l2(&l.field, &i.field)).collect();
                    let off: Vec<f64> = hits
                        .iter()
                        .zip(left)
                        .filter_map(|((i, _), l)| {
                            let d = sub(body.vertices[l.contact? as usize], body.vertices[i.contact_vertex as usize]);
                            Some(1e3 * dot64(d, d).sqrt())
                        })
                        .collect();
                    let numbers = [
                        median(&errors),
                        quantile(&errors, 0.9),
                        median(&told),
                        quantile(&told, 0.9),
                        median(&off),
                        median(&apart),
                        quantile(&apart, 0.9),
                    ];
                    let (off, spread) = ((numbers[0] - numbers[2]).abs(), numbers[5]);
                    if off > WITHIN || spread > APART {
                        let (truth, told) = (truth.name(), numbers[2]);
                        println!(
                            "aim missed: {engine}, {truth} {name}, {examples} examples, {striker:?}, {hz} Hz: the median error \
                             is {:.3}, told the blow {told:.3}; the rates are {spread:.3} apart",
                            numbers[0]
                        );
                    }
                    let floor = FLOORS.iter().find(|floor| floor.0 == engine && floor.1 == striker);
                    over += usize::from(floor.is_some_and(|floor| off > floor.2 || spread > floor.3));
                    let missed = left.iter().filter(|l| l.contact.is_none()).count();
                    let striker = if striker == Shape::Ball { "ball" } else { "box" };
                    let head = [engine, truth.name(), name].map(str::to_owned).into_iter();
                    let head = head.chain([examples.to_string(), striker.into(), num((*hz).into())]);
                    table.row(head.chain(numbers.map(num)).chain([missed.to_string(), hits.len().to_string()]))?;
                }
            }
        }
        println!("contacts: {} {name}", truth.name());
    }
    println!("{}", table.write(&options.out, "told_engine.csv")?.display());
    ensure!(!check || over == 0, "{over} rows are further off than what the engines reach");
    Ok(())
}

fn mesh(body: &Body) -> Result<SharedShape> {
    let vertices: Vec<Vector> = body.vertices.iter().map(|p| vector(*p)).collect();
    Ok(SharedShape::trimesh_with_flags(vertices, body.triangles.clone(), TriMeshFlags::FIX_INTERNAL_EDGES)?)
}

/// Lets the striker fly at the fixed body in rapier.
fn strike(set: &Arc<ExampleSet>, options: &InstanceOptions, mesh: &SharedShape, throw: &Throw<'_>) -> Result<Left> {
    let mut world = PhysicsWorld::new();
    world.gravity = Vector::ZERO;
    world.integration_parameters.dt = 1.0 / throw.hz;
    let mesh = ColliderBuilder::new(mesh.clone()).friction(FRICTION).restitution(0.0);
    let (_, mesh) = world.insert(RigidBodyBuilder::fixed(), mesh);
    let body = RigidBodyBuilder::dynamic().ccd_enabled(true).can_sleep(false);
    let body = body.pose(Pose::from_parts(throw.start(), throw.turn())).linvel(vector(throw.blow.velocity));
    let half = throw.half();
    let striker = match throw.shape {
        Shape::Ball => ColliderBuilder::ball(half),
        Shape::Box => ColliderBuilder::cuboid(half, half, half),
    };
    world.insert(body, striker.mass(throw.blow.mass).friction(FRICTION).restitution(0.0));
    let mut dented = Instance::new(set.clone(), *options)?;
    let mut contacts = RapierContacts::new(ContactOptions::default())?;
    contacts.dent(mesh, dented.inbox().clone());
    for _ in 0..(throw.seconds() * throw.hz).ceil() as usize {
        contacts.before_step(&world.bodies);
        world.step();
        let seconds = world.integration_parameters.dt;
        let report = contacts.after_step(&world.bodies, &world.colliders, world.contact_pairs(), seconds)?;
        ensure!(report.refusal.is_none(), "a hit was refused: {report:?}");
    }
    let contact = dented.marks()?.first().map(|mark| mark.contact);
    Ok(Left { field: scene::displacements(&mut dented)?, contact })
}

/// Lets a program of lab/throws throw. It reads a baked set and a line for each throw, and writes for each throw the contact's vertex
/// and the displacements of all vertices.
fn in_program(program: &Path, set: &ExampleSet, throws: &[Vec<Throw<'_>>]) -> Result<Vec<Vec<Left>>> {
    let folder = std::env::temp_dir().join(format!("crumple-throws-{}", std::process::id()));
    std::fs::create_dir_all(&folder)?;
    let [baked, list, out] = ["set.crumple", "throws.txt", "left.bin"].map(|name| folder.join(name));
    std::fs::write(&baked, set.save()?)?;
    let mut text = String::new();
    for t in throws.iter().flatten() {
        let shape = if t.shape == Shape::Ball { "ball" } else { "box" };
        let (at, v, q) = (t.start(), t.blow.velocity, t.turn());
        let numbers = [t.half(), t.blow.mass, t.hz, t.seconds(), FRICTION, DEEP, at.x, at.y, at.z, v[0], v[1], v[2]];
        let numbers = numbers.into_iter().chain([q.x, q.y, q.z, q.w]).map(|x| x.to_string());
        text += &format!("{shape} {}\n", numbers.collect::<Vec<_>>().join(" "));
    }
    std::fs::write(&list, text)?;
    let status = std::process::Command::new(program).args([&baked, &list, &out]).status();
    let status = status.with_context(|| format!("starting {}", program.display()))?;
    ensure!(status.success(), "{} ends with {status}", program.display());
    let bytes = std::fs::read(&out)?;
    std::fs::remove_dir_all(&folder)?;
    let one = 4 + 12 * set.vertex_count();
    ensure!(bytes.len() == one * throws.iter().map(Vec::len).sum::<usize>(), "{} bytes were left", bytes.len());
    let word = |b: &[u8]| [b[0], b[1], b[2], b[3]];
    let left = |bytes: &[u8]| Left {
        contact: Some(u32::from_ne_bytes(word(bytes))).filter(|v| *v != u32::MAX),
        field: bytes[4..].chunks_exact(12).map(|v| [0, 4, 8].map(|k| f32::from_ne_bytes(word(&v[k..])))).collect(),
    };
    let mut all = bytes.chunks_exact(one).map(left);
    Ok(throws.iter().map(|at_rate| all.by_ref().take(at_rate.len()).collect()).collect())
}

fn vector(v: [f32; 3]) -> Vector {
    Vector::new(v[0], v[1], v[2])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crumple::SetOptions;

    #[test]
    fn a_thrown_striker_leaves_what_its_blow_leaves() {
        let body = Body::read(Truth::Shots, "panel").unwrap();
        let set = scene::set(&body, 8, SetOptions::default()).unwrap();
        let ours = InstanceOptions { depth_limit: Some(DEEP), ..Default::default() };
        let mesh = mesh(&body).unwrap();
        for (index, impact) in body.train.iter().take(4).enumerate() {
            let blow = impact.blow.unwrap().in_engine();
            let told = scene::field_after(&set, &ours, &[Hit::blow(impact.point, scene::blow(&blow))]).unwrap();
            for hz in RATES {
                for shape in [Shape::Ball, Shape::Box] {
                    let throw = Throw { impact, blow, shape, hz, phase: 0.3 * index as f32 };
                    let left = strike(&set, &ours, &mesh, &throw).unwrap();
                    let (got, expected) = (deepest(&left.field), deepest(&told));
                    assert!(left.contact.is_some());
                    assert!(
                        (got / expected - 1.0).abs() < 0.2,
                        "{shape:?} at {hz} Hz: {got} m instead of {expected} m"
                    );
                }
            }
        }
    }
}
