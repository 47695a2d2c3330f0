//! Two cars and a post: Rapier moves them, the contact layer tells of their contacts, and Crumple writes the vertices that are drawn.
//! Writes a PNG for each frame; lab/python/film.py makes an animation of them.

use std::sync::Arc;

use anyhow::{Context, Result, ensure};
use crumple::import::PartKind;
use crumple::{Aabb, ContactOptions, InstanceOptions, ThreadPool, Tracker};
use glam::{Mat4, Quat, Vec3};
use rapier3d::prelude::{ColliderBuilder, Group, InteractionGroups, InteractionTestMode, PhysicsWorld};

use crate::Options;
use crate::car::{
    self, Car, Dented, GLASS_HOLDS, Shown, UP, corners, frames, moving, pose, vector, world, write_frame,
};
use crate::peers::rapier_contacts::RapierContacts;
use crate::pictures::picture::{Camera, Coat, Finish, Margins, View, photograph};

/// Size of the frames, pixels.
const SIZE: [usize; 2] = [1280, 560];
/// Steps of the physics a second, and steps a frame.
const HZ: usize = 240;
const STEPS: usize = 8;
/// Length of the film, s.
const SECONDS: f32 = 4.0;
/// How fast a car drives into the post, and another into its side, m/s.
const SPEEDS: [f32; 2] = [4.6, 5.5];
/// A bumper falls off when a part of it has moved this far, m.
const BUMPER_HOLDS: f32 = 0.1;
/// What falls off meets the ground, which gives way too and so lies higher, m.
const FALLEN: InteractionGroups = InteractionGroups::new(Group::GROUP_2, Group::GROUP_2, InteractionTestMode::And);
const SINKS: f32 = 0.03;
/// Where the post stands, its radius and its height, m.
const PLACE: Vec3 = Vec3::new(-0.12, 0.0, 0.0);
const POST: f32 = 0.13;
const HEIGHT: f32 = 0.95;
/// So long after its crash the second car backs off, s, and how fast, m/s.
const BACK_OFF: (f32, f32) = (0.7, 1.5);
/// Broken glass, its cracks, their width and the size of the pieces where it broke, m.
const DULL: Coat = Coat { paint: Vec3::new(0.07, 0.08, 0.085), flakes: Vec3::ZERO, gloss: 0.35 };
const CRACK: Coat = Coat { paint: Vec3::new(0.42, 0.46, 0.48), flakes: Vec3::ZERO, gloss: 0.0 };
const CRACK_WIDTH: f32 = 0.006;
const PIECE: f32 = 0.05;
/// What the film has room for, m: the floor, the light and the shadows are the same in all frames.
const STAGE: [Vec3; 2] = [Vec3::new(-3.0, 0.0, -9.0), Vec3::new(12.8, 1.7, 0.8)];
/// What the camera sees, m.
const SEEN: [Vec3; 2] = [Vec3::new(-1.0, 0.0, -5.0), Vec3::new(1.9, 1.4, 0.45)];
const MARGINS: Margins = Margins { side: 0.02, top: 0.02, bottom: 0.04 };

pub fn run(options: &Options) -> Result<()> {
    let pool = ThreadPool::new(0)?;
    let model = Arc::new(Model::load(&pool)?);
    let mut scene = Scene::new(&model)?;
    let (size, every) = if options.quick { ([640, 280], 10) } else { (SIZE, 1) };
    let folder = frames("crash")?;
    let view = View { up: UP, toward: Vec3::new(0.6, 0.42, 0.68).normalize() };
    let camera = Camera::framing(&corners(SEEN), view, size[0] as f32 / size[1] as f32, MARGINS);
    for frame in 0..(SECONDS * HZ as f32) as usize / STEPS {
        for _ in 0..STEPS {
            scene.step()?;
        }
        if frame % every == 0 {
            let shown = scene.shown(&pool)?;
            let image = photograph(shown.body(), &camera, view, size, &Finish::Coats(&shown.coats), None);
            write_frame(&folder, frame, &image)?;
        }
    }
    ensure!(scene.cars[0].bumper.is_some(), "the first car must lose its bumper at the post");
    println!("{}: frames, {} a second", folder.display(), HZ / STEPS);
    Ok(())
}

/// The car, and its parts that are meshes of the set.
struct Model {
    car: car::Model,
    /// Meshes of the set with the indices of their parts.
    bumper: (usize, usize),
    glass: Vec<(usize, usize)>,
}

impl Model {
    fn load(pool: &ThreadPool) -> Result<Self> {
        let (mut car, meshes) = car::Model::load(pool)?;
        let (mut bumper, mut glass) = (None, Vec::new());
        for (i, mesh) in meshes.into_iter().enumerate() {
            let part = &car.levels[0].parts[i];
            let (is_glass, is_bumper) = (part.kind == PartKind::Glass, part.name == "bumper_front");
            if is_glass {
                glass.push((car.set_mut()?.add_lod(mesh, pool)?, i));
            } else if is_bumper {
                bumper = Some((car.set_mut()?.add_lod(mesh, pool)?, i));
            }
        }
        Ok(Model { car, bumper: bumper.context("the car has no bumper_front")?, glass })
    }

    /// The vertices of a part before the crash.
    fn at_rest(&self, part: usize) -> &[Vec3] {
        &self.car.set.mesh().positions()[self.car.levels[0].parts[part].vertices.clone()]
    }

    /// Whether a pane looks ahead or back.
    fn is_windscreen(&self, part: usize) -> bool {
        let Aabb { min, max } = Aabb::of(self.at_rest(part));
        min.x < 0.0 && max.x > 0.0
    }

    /// Where the vertex of a part was that has moved furthest.
    fn most_moved(&self, part: usize, dented: &Dented) -> Option<Vec3> {
        let now = &dented.positions[self.car.levels[0].parts[part].vertices.clone()];
        let moved = |(was, now): (&Vec3, &[f32; 3])| (*was, was.distance(Vec3::from(*now)));
        let all = self.at_rest(part).iter().zip(now).map(moved);
        all.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(was, _)| was)
    }
}

/// A bumper that has come off.
struct Bumper {
    dented: Dented,
    /// Of its box, in the car's space, m.
    centre: Vec3,
}

struct Crashed {
    car: Car,
    /// When it first was hit, s.
    at: f32,
    bumper: Option<Bumper>,
    /// Meshes of the set that are broken, and where.
    broken: Vec<(usize, Vec3)>,
}

struct Scene {
    model: Arc<Model>,
    world: PhysicsWorld,
    contacts: RapierContacts,
    cars: Vec<Crashed>,
    time: f64,
}

impl Scene {
    fn new(model: &Arc<Model>) -> Result<Self> {
        let world = world(1.0 / HZ as f32);
        let contacts = RapierContacts::new(ContactOptions::default())?;
        let mut scene = Scene { model: model.clone(), world, contacts, cars: Vec::new(), time: 0.0 };
        let red = Coat::of(Vec3::new(0.33, 0.012, 0.01), 0.5, 0.28);
        scene.add(Vec3::new(0.0, 0.0, -6.6), Quat::IDENTITY, SPEEDS[0], model.car.coats[model.car.paint])?;
        scene.add(Vec3::new(10.4, 0.0, -2.7), Quat::from_rotation_y(-std::f32::consts::FRAC_PI_2), SPEEDS[1], red)?;
        let post = ColliderBuilder::cylinder(0.5 * HEIGHT, POST).translation(vector(&(PLACE + 0.5 * HEIGHT * UP)));
        scene.world.insert_collider(post.friction(0.5), None);
        let ground = ColliderBuilder::cuboid(50.0, 1.0, 50.0).translation(vector(&(UP * (SINKS - 1.0))));
        scene.world.insert_collider(ground.collision_groups(FALLEN), None);
        Ok(scene)
    }

    fn add(&mut self, at: Vec3, turn: Quat, speed: f32, paint: Coat) -> Result<()> {
        let options = InstanceOptions { grow_time: 0.04, ..Default::default() };
        let car = Car::add(&mut self.world, &mut self.contacts, &self.model.car, (at, turn, speed), paint, options)?;
        self.cars.push(Crashed { car, at: f32::INFINITY, bumper: None, broken: Vec::new() });
        Ok(())
    }

    fn step(&mut self) -> Result<()> {
        self.time += 1.0 / HZ as f64;
        for Crashed { car, .. } in &mut self.cars {
            car.dented.instance.set_time(self.time)?;
            car.before_step(&self.world)?;
        }
        self.contacts.before_step(&self.world.bodies);
        self.world.step();
        let (world, seconds) = (&self.world, 1.0 / HZ as f32);
        let report = self.contacts.after_step(&world.bodies, &world.colliders, world.contact_pairs(), seconds)?;
        ensure!(report.refusal.is_none(), "a body refuses a hit: {:?}", report.refusal);
        for (i, Crashed { car, at, .. }) in self.cars.iter_mut().enumerate() {
            car.roll(&self.world, seconds);
            if car.brake(&mut self.world)? {
                *at = self.time as f32;
            }
            if i == 1 && self.time as f32 > *at + BACK_OFF.0 {
                let back = car.ahead(&self.world) * -BACK_OFF.1;
                self.world.bodies[car.dented.body].set_linvel(vector(&back), true);
            }
        }
        Ok(())
    }

    /// What the dents do to the cars, and the vertices of all that is to be seen.
    fn shown(&mut self, pool: &ThreadPool) -> Result<Shown> {
        let mut shown = Shown { coats: self.model.car.coats.clone(), ..Shown::default() };
        let model = self.model.clone();
        let steel = Coat { paint: Vec3::splat(0.2), flakes: Vec3::splat(0.05), gloss: 0.2 };
        shown.coats.extend([steel, DULL, CRACK]);
        let steel = shown.coats.len() - 3;
        for crashed in &mut self.cars {
            let dented = &mut crashed.car.dented;
            dented.deform(pool)?;
            for (lod, part) in &model.glass {
                let is_broken = crashed.broken.iter().any(|(broken, _)| broken == lod);
                if !is_broken && dented.instance.measure(*lod)?.deepest > GLASS_HOLDS {
                    crashed.broken.extend(model.most_moved(*part, dented).map(|at| (*lod, at)));
                }
            }
            if crashed.bumper.is_none() && dented.instance.measure(model.bumper.0)?.deepest > BUMPER_HOLDS {
                crashed.bumper = Some(Bumper::of(dented, &model, &mut self.world)?);
            }
            if let Some(Bumper { dented, .. }) = &mut crashed.bumper {
                dented.instance.set_time(self.time)?;
                dented.deform(pool)?;
            }
            let own = shown.coats.len() as f32;
            shown.coats.push(crashed.car.paint);
            let place = pose(&self.world, crashed.car.dented.body);
            for i in 0..model.car.levels[0].parts.len() {
                let glass = model.glass.iter().find(|(_, of)| *of == i);
                let broken = glass.and_then(|(lod, _)| crashed.broken.iter().find(|(broken, _)| broken == lod));
                let coat = |coat: f32| match coat {
                    coat if coat == model.car.paint as f32 => own,
                    coat => coat,
                };
                let car = &crashed.car;
                let (dented, at) = match (model.car.wheel(i), &crashed.bumper) {
                    (Some(wheel), _) => (&car.dented, place * car.rolled(wheel)?),
                    (None, Some(Bumper { dented, centre })) if i == model.bumper.1 => {
                        (dented, pose(&self.world, dented.body) * Mat4::from_translation(-*centre))
                    }
                    _ => (&car.dented, place),
                };
                let first = shown.triangles.len();
                shown.add((&model.car, 0, i), dented, at, coat)?;
                if let Some((_, broke)) = broken {
                    // Side windows fall out, and windscreens hold together.
                    let pane = shown.triangles.split_off(first);
                    if model.is_windscreen(i) {
                        shown.cracked(&pane, model.at_rest(i), *broke, steel + 1);
                    }
                }
            }
        }
        shown.post(steel as f32);
        shown.reach(&corners(STAGE));
        Ok(shown)
    }
}

impl Bumper {
    /// Takes the bumper off: a box for the physics, which falls.
    fn of(car: &mut Dented, model: &Model, world: &mut PhysicsWorld) -> Result<Self> {
        let instance = car.instance.release(model.bumper.0)?;
        let Dented { positions, normals, .. } = &*car;
        let own =
            positions[model.car.levels[0].parts[model.bumper.1].vertices.clone()].iter().map(|p| Vec3::from_array(*p));
        let Aabb { min, max } = Aabb::of(&own.collect::<Vec<_>>());
        let (centre, half) = ((min + max) * 0.5, (max - min) * 0.5);
        let place = pose(world, car.body);
        let (_, turn, _) = place.to_scale_rotation_translation();
        let body = moving(place.transform_point3(centre), turn, turn * Vec3::new(0.5, 0.4, -0.3))
            .angvel(vector(&(turn * Vec3::new(0.5, 0.3, -1.1))))
            .angular_damping(1.0);
        let shape = ColliderBuilder::cuboid(half.x, half.y, half.z).mass(12.0).collision_groups(FALLEN);
        let (body, _) = world.insert(body, shape);
        let (positions, normals) = (positions.clone(), normals.clone());
        Ok(Bumper { dented: Dented { body, instance, tracker: Tracker::new(), positions, normals }, centre })
    }
}

impl Shown {
    /// Adds a pane with cracks around the point where it broke. `at_rest` are the last vertices that were added, before the crash.
    /// `dull` is the index of broken glass among the coats, and that of the cracks is the next.
    fn cracked(&mut self, pane: &[[u32; 3]], at_rest: &[Vec3], broke: Vec3, dull: usize) {
        let before = self.positions.len() - at_rest.len();
        for t in pane {
            let rest = t.map(|v| at_rest[v as usize - before]);
            let longest = (0..3).map(|k| rest[k].distance(rest[(k + 1) % 3])).fold(0.0, f32::max);
            let n = (longest / (0.7 * CRACK_WIDTH)).ceil().clamp(1.0, 400.0) as u32;
            let first = self.positions.len() as u32;
            // Rows of 1, 2, … n + 1 vertices.
            for (i, j) in (0..=n).flat_map(|i| (0..=i).map(move |j| (i, j))) {
                let share = Vec3::new((n - i) as f32, (i - j) as f32, j as f32) / n as f32;
                let mix = |of: [Vec3; 3]| of[0] * share.x + of[1] * share.y + of[2] * share.z;
                let position = mix(t.map(|v| self.positions[v as usize]));
                let normal = mix(t.map(|v| self.normals[v as usize]));
                self.positions.push(position);
                self.normals.push(normal);
                self.coat_of.push((dull + usize::from(is_crack(mix(rest) - broke))) as f32);
            }
            let at = |i: u32, j: u32| first + i * (i + 1) / 2 + j;
            for (i, j) in (0..n).flat_map(|i| (0..=i).map(move |j| (i, j))) {
                self.triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
                if j < i {
                    self.triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
                }
            }
        }
    }

    /// Adds the post.
    fn post(&mut self, coat: f32) {
        const AROUND: u32 = 48;
        let first = self.positions.len() as u32;
        for i in 0..=AROUND {
            let side = Quat::from_rotation_y(i as f32 * std::f32::consts::TAU / AROUND as f32) * Vec3::Z;
            // The side, and the lid.
            for (height, normal, radius) in
                [(0.0, side, POST), (HEIGHT, side, POST), (HEIGHT, UP, POST), (HEIGHT, UP, 0.0)]
            {
                self.positions.push(PLACE + side * radius + UP * height);
                self.normals.push(normal);
                self.coat_of.push(coat);
            }
        }
        for i in (0..4 * AROUND).step_by(4).map(|i| first + i) {
            self.triangles.extend([[i, i + 4, i + 1], [i + 1, i + 4, i + 5], [i + 2, i + 6, i + 3]]);
        }
    }
}

/// Whether a point, seen from where the pane broke, lies on the border of two pieces. They are the cells of points strewn over space
/// (Worley 1996), and wider further away.
fn is_crack(p: Vec3) -> bool {
    let away = p.length().max(1e-6);
    let narrower = 3.0 * PIECE * (away / (3.0 * PIECE)).ln_1p() / away;
    let p = p * narrower;
    let cell = (p / PIECE).floor();
    let mut nearest = [f32::INFINITY; 2];
    for k in 0..27 {
        let there = cell + Vec3::new((k % 3) as f32, (k / 3 % 3) as f32, (k / 9) as f32) - 1.0;
        let random = |salt: u32| {
            let mix = |h: u32, x: &f32| (h ^ (*x as i32 as u32)).wrapping_mul(0x9E37_79B1).rotate_left(13);
            let mixed = there.to_array().iter().fold(salt, mix);
            (mixed.wrapping_mul(0x85EB_CA6B) >> 8) as f32 / (1 << 24) as f32
        };
        let d = p.distance((there + Vec3::new(random(1), random(2), random(3))) * PIECE);
        if d < nearest[0] {
            nearest = [d, nearest[0]];
        } else if d < nearest[1] {
            nearest[1] = d;
        }
    }
    nearest[1] - nearest[0] < CRACK_WIDTH * narrower
}
