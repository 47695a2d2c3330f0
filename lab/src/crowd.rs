//! 200 cars in one frame: two columns meet, and each frame says how long Crumple took for all of them.
//! Writes a PNG for each frame, of which lab/python/film.py makes an animation, and what the frames cost.

use std::time::Instant;

use anyhow::{Result, ensure};
use crumple::import::PartKind;
use crumple::{ContactOptions, DeformJob, InstanceOptions, ThreadPool, Tracker, VertexMemory, deform, fold_all};
use glam::{Quat, Vec2, Vec3};
use rapier3d::prelude::PhysicsWorld;

use crate::Options;
use crate::car::{Car, GLASS_HOLDS, Model, Shown, UP, corners, frames, pose, world, write_frame};
use crate::machine::Machine;
use crate::metric::{median, quantile};
use crate::peers::VERSION;
use crate::peers::rapier_contacts::RapierContacts;
use crate::pictures::picture::{Camera, Coat, Finish, Image, View, legend, photograph};
use crate::stability::Dice;
use crate::table::{Table, num};

/// Size of the frames, pixels.
const SIZE: [usize; 2] = [1280, 560];
/// Frames of the game a second, each with a step of the physics, and of how many the film shows one.
const HZ: usize = 60;
const SHOWN: usize = 2;
/// Length of the film, s.
const SECONDS: f32 = 3.0;
/// The scene plays so often before it is drawn. What a frame costs is the least of these: other work on the machine does not count.
const RUNS: usize = 8;
/// Cars abreast, and rows on each side.
const ABREAST: usize = 20;
const ROWS: usize = 5;
/// Distances between cars abreast, between rows, and between the fronts at first, m.
const APART: [f32; 3] = [2.45, 6.4, 11.5];
/// How fast the cars drive, m/s.
const SPEED: f64 = 11.5;
/// Cell sizes of the levels of detail, m.
const CELLS: [f32; 3] = [0.03, 0.05, 0.08];
/// What is off on the screen, pixels, for `Instance::set_view`.
const PIXELS: f32 = 0.15;
/// Radius of a sphere around a car, m.
const RADIUS: f32 = 2.45;
/// What the scene has room for, m.
const STAGE: [Vec3; 2] = [Vec3::new(-38.0, 0.0, -28.0), Vec3::new(38.0, 1.5, 28.0)];
/// Tangent of half the camera's vertical field of view.
const FIELD: f32 = 0.28;
/// Where it is, and where it looks, m.
const EYE: Vec3 = Vec3::new(21.0, 23.0, 48.0);
const TARGET: Vec3 = Vec3::new(0.0, 0.0, 6.6);
/// How broken glass looks from afar.
const CRAZED: Coat = Coat { paint: Vec3::new(0.33, 0.36, 0.37), flakes: Vec3::ZERO, gloss: 0.05 };
/// Paints of the cars, linear.
const PAINTS: [[f32; 3]; 8] = [
    [0.008, 0.075, 0.25],
    [0.33, 0.012, 0.01],
    [0.60, 0.61, 0.63],
    [0.75, 0.74, 0.70],
    [0.06, 0.065, 0.07],
    [0.55, 0.30, 0.01],
    [0.02, 0.16, 0.09],
    [0.42, 0.09, 0.01],
];
/// The hulls of the physics have a vertex in each of so many directions.
const DIRECTIONS: usize = 96;

/// What a frame cost.
#[derive(Default, Clone, Copy)]
struct Cost {
    /// Rapier's steps, ms.
    physics: f64,
    /// Crumple: reading the contacts and submitting hits; folding them; deforming. ms
    contacts: f64,
    fold: f64,
    deform: f64,
    hits: u64,
    refused: u64,
    marks: usize,
    vertices: u64,
}

impl Cost {
    fn least(&mut self, other: &Cost) {
        self.physics = self.physics.min(other.physics);
        self.contacts = self.contacts.min(other.contacts);
        self.fold = self.fold.min(other.fold);
        self.deform = self.deform.min(other.deform);
    }

    fn crumple(&self) -> f64 {
        self.contacts + self.fold + self.deform
    }
}

pub fn run(options: &Options) -> Result<()> {
    let pool = ThreadPool::new(0)?;
    let (mut model, _) = Model::load(&pool)?;
    for cell in CELLS {
        model.add_level(cell, &pool)?;
    }
    model.set_hulls(DIRECTIONS)?;
    let (size, every, runs) = if options.quick { (SIZE.map(|n| n / 2), 10 * SHOWN, 1) } else { (SIZE, SHOWN, RUNS) };
    let camera = camera(size);
    let count = (SECONDS * HZ as f32) as usize;
    let mut costs: Vec<Cost> = Vec::new();
    for run in 0..runs {
        let mut scene = Scene::new(&model, &camera, &pool)?;
        for frame in 0..count {
            let cost = scene.frame(&camera, &pool)?;
            if run == 0 {
                costs.push(cost);
            }
            costs[frame].least(&cost);
        }
    }
    write(options, &costs, runs, &model)?;

    let folder = frames("crowd")?;
    let mut scene = Scene::new(&model, &camera, &pool)?;
    let mut hits = 0;
    for (frame, cost) in costs.iter().enumerate() {
        scene.frame(&camera, &pool)?;
        hits += cost.hits;
        if frame % every == 0 {
            let mut image = scene.draw(&camera, size)?;
            let (count, ms) = (scene.cars.len(), cost.crumple());
            let title = format!("{count} cars, {} dents. Crumple: {ms:.1} ms in this frame", cost.marks);
            let detail =
                format!("{hits} hits so far; {} vertices written; Rapier {:.1} ms", cost.vertices, cost.physics);
            legend::caption(&mut image, 24, &title, &detail);
            write_frame(&folder, frame / SHOWN, &image)?;
        }
    }
    println!("{}: frames, {} a second", folder.display(), HZ / SHOWN);
    Ok(())
}

fn write(options: &Options, costs: &[Cost], runs: usize, model: &Model) -> Result<()> {
    let mut table = Table::threaded(&[
        "frame",
        "crumple_ms",
        "contacts_ms",
        "fold_ms",
        "deform_ms",
        "physics_ms",
        "hits",
        "marks",
        "vertices",
    ]);
    let cars = 2 * ROWS * ABREAST;
    table.comment(
        "what",
        format!("{cars} cars in two columns that meet, {HZ} frames a second, each with one step of rapier3d {VERSION}"),
    );
    let threads = Machine::here().cores;
    table.comment("threads", format!("contacts on one thread; fold and deform on {threads}; physics on one"));
    table.comment(
        "cost",
        format!("crumple is contacts (transforms, reading the contacts, submitting hits), fold and deform (positions and normals); each the least of {runs} runs of the scene"),
    );
    if let Some(load) = Machine::load() {
        table.comment("load", format!("{load} tasks were running or waiting, on the mean of the last minute"));
    }
    let vertices = (0..model.set.lod_count()).map(|lod| Ok(model.set.lod_mesh(lod)?.positions().len().to_string()));
    let vertices = vertices.collect::<Result<Vec<_>>>()?.join(" ");
    table.comment("levels", format!("vertices {vertices}; shown by set_view of {PIXELS} pixels"));
    for (frame, cost) in costs.iter().enumerate() {
        let times = [cost.crumple(), cost.contacts, cost.fold, cost.deform, cost.physics].map(num);
        let counts = [cost.hits, cost.marks as u64, cost.vertices].map(|n| n.to_string());
        table.row([frame.to_string()].into_iter().chain(times).chain(counts))?;
    }
    println!("{}", table.write(&options.out, "crowd.csv")?.display());
    let struck: Vec<f64> = costs.iter().filter(|cost| cost.hits > 0).map(Cost::crumple).collect();
    let (median, worst) = (median(&struck), quantile(&struck, 1.0));
    println!("Crumple: median {median:.1} ms, worst {worst:.1}, of {} frames with hits", struck.len());
    let sum = |of: fn(&Cost) -> u64| costs.iter().map(of).sum::<u64>();
    // Rapier's contact points may lie metres beside a car.
    let (hits, refused) = (sum(|cost| cost.hits), sum(|cost| cost.refused));
    ensure!(100 * refused <= hits, "cars refuse {refused} of {hits} hits");
    Ok(())
}

fn camera(size: [usize; 2]) -> Camera {
    let back = (EYE - TARGET).normalize();
    let right = UP.cross(back).normalize();
    let tan = Vec2::new(FIELD * size[0] as f32 / size[1] as f32, FIELD);
    Camera { eye: EYE, right, up: back.cross(right), back, tan, near: 2.0, far: 200.0 }
}

/// A car, and the level of detail that is shown.
struct Driver {
    car: Car,
    lod: usize,
}

struct Scene<'a> {
    model: &'a Model,
    world: PhysicsWorld,
    contacts: RapierContacts,
    cars: Vec<Driver>,
}

impl<'a> Scene<'a> {
    fn new(model: &'a Model, camera: &Camera, pool: &ThreadPool) -> Result<Self> {
        let (mut world, mut contacts) = (world(1.0 / HZ as f32), RapierContacts::new(ContactOptions::default())?);
        let mut dice = Dice::new(200);
        let mut cars = Vec::new();
        for (side, row, column) in
            (0..2).flat_map(|s| (0..ROWS).flat_map(move |r| (0..ABREAST).map(move |c| (s, r, c))))
        {
            let mut near = |range: f64| dice.between(-range, range) as f32;
            let ahead = 0.5 * APART[2] + APART[1] * row as f32 + near(1.4);
            let aside = APART[0] * (column as f32 - 0.5 * (ABREAST - 1) as f32) + near(0.3);
            let turn = std::f32::consts::FRAC_PI_2 + near(0.06);
            let (sign, speed) = (if side == 0 { -1.0 } else { 1.0 }, SPEED as f32 + near(0.8));
            let start = (Vec3::new(sign * ahead, 0.0, aside), Quat::from_rotation_y(-sign * turn), speed);
            let paint = Coat::of(PAINTS[dice.index(PAINTS.len())].into(), 0.5, 0.28);
            let car = Car::add(&mut world, &mut contacts, model, start, paint, InstanceOptions::default())?;
            cars.push(Driver { car, lod: 0 });
        }
        let mut scene = Scene { model, world, contacts, cars };
        // At first everything is written, at rest: that is loading, not the frames.
        scene.deform(camera, pool)?;
        Ok(scene)
    }

    fn frame(&mut self, camera: &Camera, pool: &ThreadPool) -> Result<Cost> {
        let mut cost = Cost::default();
        let seconds = 1.0 / HZ as f32;
        let start = Instant::now();
        self.cars.iter().try_for_each(|driver| driver.car.before_step(&self.world))?;
        cost.contacts = ms(start);
        let start = Instant::now();
        self.contacts.before_step(&self.world.bodies);
        self.world.step();
        cost.physics = ms(start);
        let start = Instant::now();
        let (world, pairs) = (&self.world, self.world.contact_pairs());
        let report = self.contacts.after_step(&world.bodies, &world.colliders, pairs, seconds)?;
        cost.contacts += ms(start);
        cost.refused = report.refused;
        cost.hits = report.hits;
        let start = Instant::now();
        fold_all(self.cars.iter_mut().map(|driver| &mut driver.car.dented.instance), pool);
        cost.fold = ms(start);
        let start = Instant::now();
        cost.vertices = self.deform(camera, pool)?;
        cost.deform = ms(start);
        for driver in &mut self.cars {
            driver.car.roll(&self.world, seconds);
            driver.car.brake(&mut self.world)?;
            cost.marks += driver.car.dented.instance.marks()?.len();
        }
        Ok(cost)
    }

    /// Writes what changed, each car at the level of detail that the camera needs. Returns the number of vertices.
    fn deform(&mut self, camera: &Camera, pool: &ThreadPool) -> Result<u64> {
        let mut jobs = Vec::with_capacity(self.cars.len());
        for Driver { car, lod } in &mut self.cars {
            let dented = &mut car.dented;
            let at = Vec3::from(self.world.bodies[dented.body].translation().to_array());
            let distance = (at.distance(camera.eye) - RADIUS).max(0.0);
            let wanted = dented.instance.set_view(PIXELS, distance, 2.0 * camera.tan.y.atan(), SIZE[1] as f32)?;
            let vertices = self.model.set.lod_mesh(wanted)?.positions().len();
            if (wanted, vertices) != (*lod, dented.positions.len()) {
                *lod = wanted;
                dented.tracker = Tracker::new();
                dented.positions.resize(vertices, [0.0; 3]);
                dented.normals.resize(vertices, [0.0; 3]);
            }
            let memory = VertexMemory::separate(&mut dented.positions, Some(&mut dented.normals), None)?;
            jobs.push(DeformJob { lod: *lod, instance: &dented.instance, tracker: &mut dented.tracker, memory });
        }
        Ok(deform(&mut jobs, pool)?.vertices_written)
    }

    fn draw(&self, camera: &Camera, size: [usize; 2]) -> Result<Image> {
        let model = self.model;
        let mut shown = Shown { coats: model.coats.clone(), ..Shown::default() };
        let crazed = shown.coats.len() as f32;
        shown.coats.push(CRAZED);
        for Driver { car, lod } in &self.cars {
            let own = shown.coats.len() as f32;
            shown.coats.push(car.paint);
            let place = pose(&self.world, car.dented.body);
            let at_rest = model.set.lod_mesh(*lod)?.positions();
            for (i, part) in model.levels[*lod].parts.iter().enumerate() {
                let off = |v: usize| at_rest[v].distance(Vec3::from(car.dented.positions[v]));
                let is_broken = part.kind == PartKind::Glass && part.vertices.clone().any(|v| off(v) > GLASS_HOLDS);
                let coat = |coat: f32| match coat as usize {
                    _ if is_broken => crazed,
                    of if [model.paint, model.roof].contains(&of) => own,
                    _ => coat,
                };
                let turn = model.wheel(i).map(|wheel| car.rolled(wheel)).transpose()?;
                shown.add((model, *lod, i), &car.dented, place * turn.unwrap_or_default(), coat)?;
            }
        }
        shown.reach(&corners(STAGE));
        let view = View { up: UP, toward: camera.back };
        Ok(photograph(shown.body(), camera, view, size, &Finish::Coats(&shown.coats), Some(RADIUS)))
    }
}

fn ms(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1e3
}
