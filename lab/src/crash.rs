//! Two cars and a post: Rapier moves them, the contact layer tells of their contacts, and Crumple writes the vertices that are drawn.
//! Writes a PNG for each frame; lab/python/film.py makes an animation of them.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use anyhow::{Context, Result, ensure};
use crumple::import::{MeshChoice, Part, PartKind, Patterns, Reading, gltf_slice};
use crumple::{
    Aabb, Attachment, BasisOptions, ContactOptions, ExampleSet, Instance, InstanceOptions, SetOptions, ThreadPool,
    Tracker, VertexMemory,
};
use glam::{Mat4, Quat, Vec3};
use rapier3d::prelude::{
    ColliderBuilder, Group, InteractionGroups, InteractionTestMode, PhysicsWorld, RigidBodyBuilder, RigidBodyHandle,
    SpringCoefficients, Vector,
};

use crate::Options;
use crate::peers::rapier_contacts::RapierContacts;
use crate::pictures::picture::{Body, Camera, Coat, Finish, Margins, View, coats, photograph};

const CAR: &str = "assets/car/car_dents.glb";
/// Where the frames go, and their size, pixels.
const FRAMES: &str = "out/crash";
const SIZE: [usize; 2] = [1280, 560];
/// How far vertices may be from the examples where nodes are added, m.
const TOLERANCE: f32 = 0.01;
/// Steps of the physics a second, and steps a frame.
const HZ: usize = 240;
const STEPS: usize = 8;
/// Length of the film, s.
const SECONDS: f32 = 4.0;
/// kg
const MASS: f32 = 1200.0;
/// How fast a car drives into the post, and another into its side, m/s.
const SPEEDS: [f32; 2] = [4.6, 5.5];
/// Bodies give way in a contact, as a spring and a damper with this frequency (Hz) for the mass would: crumple zones.
const GIVE: SpringCoefficients<f32> = SpringCoefficients { natural_frequency: 3.0, damping_ratio: 0.7 };
/// A bumper falls off when a part of it has moved this far, and glass breaks, m.
const BUMPER_HOLDS: f32 = 0.1;
const GLASS_HOLDS: f32 = 0.012;
/// What drives meets the post, and what falls off meets the post and the ground, which gives way too and so lies higher, m.
const DRIVES: InteractionGroups = InteractionGroups::new(Group::GROUP_1, Group::GROUP_1, InteractionTestMode::And);
const FALLEN: InteractionGroups = InteractionGroups::new(Group::GROUP_2, Group::GROUP_2, InteractionTestMode::And);
const SINKS: f32 = 0.03;
/// Where the post stands, its radius and its height, m.
const PLACE: Vec3 = Vec3::new(-0.12, 0.0, 0.0);
const POST: f32 = 0.13;
const HEIGHT: f32 = 0.95;
/// So long after its crash the second car backs off, s, and how fast, m/s.
const BACK_OFF: (f32, f32) = (0.7, 1.5);
/// Radius of a wheel, m.
const WHEEL: f32 = 0.335;
/// Vertices above this height are the greenhouse's, m.
const BELT: f32 = 0.92;
/// What the film has room for, m: the floor, the light and the shadows are the same in all frames.
const STAGE: [Vec3; 2] = [Vec3::new(-3.0, 0.0, -9.0), Vec3::new(12.8, 1.7, 0.8)];
/// What the camera sees, m.
const SEEN: [Vec3; 2] = [Vec3::new(-1.0, 0.0, -5.0), Vec3::new(1.9, 1.4, 0.45)];
const MARGINS: Margins = Margins { side: 0.02, top: 0.02, bottom: 0.04 };
const UP: Vec3 = Vec3::Y;

pub fn run(options: &Options) -> Result<()> {
    let pool = ThreadPool::new(0)?;
    let model = Arc::new(Model::load(Path::new(CAR), &pool)?);
    let mut scene = Scene::new(&model)?;
    let (size, every) = if options.quick { ([640, 280], 10) } else { (SIZE, 1) };
    // Older frames would be part of the film.
    let _ = fs::remove_dir_all(FRAMES);
    fs::create_dir_all(FRAMES).with_context(|| format!("making {FRAMES}"))?;
    let view = View { up: UP, toward: Vec3::new(0.6, 0.42, 0.68).normalize() };
    let camera = Camera::framing(&corners(SEEN), view, size[0] as f32 / size[1] as f32, MARGINS);
    for frame in 0..(SECONDS * HZ as f32) as usize / STEPS {
        for _ in 0..STEPS {
            scene.step()?;
        }
        if frame % every == 0 {
            let shown = scene.shown(&pool)?;
            let body = Body {
                positions: &shown.positions,
                normals: &shown.normals,
                triangles: &shown.triangles,
                values: &shown.coat_of,
            };
            let image = photograph(body, &camera, view, size, &Finish::Coats(&shown.coats));
            let path = Path::new(FRAMES).join(format!("frame_{frame:03}.png"));
            fs::write(&path, image.to_png("a crash")?).with_context(|| format!("writing {}", path.display()))?;
        }
    }
    ensure!(scene.cars[0].bumper.is_some(), "the first car must lose its bumper at the post");
    println!("{FRAMES}: frames, {} a second", HZ / STEPS);
    Ok(())
}

/// The corners of a box.
fn corners([low, high]: [Vec3; 2]) -> [Vec3; 8] {
    std::array::from_fn(|i| Vec3::select(glam::BVec3::new(i & 1 == 0, i & 2 == 0, i & 4 == 0), low, high))
}

/// A wheel of the car, and where it is mounted.
struct Wheel {
    part: usize,
    centre: Vec3,
    mount: Attachment,
}

/// What all cars share.
struct Model {
    set: Arc<ExampleSet>,
    parts: Vec<Part>,
    /// Parts of the set with their indices in `parts`.
    bumper: (usize, usize),
    glass: Vec<(usize, usize)>,
    wheels: Vec<Wheel>,
    coats: Vec<Coat>,
    coat_of: Vec<f32>,
    /// Index of the coat that differs from car to car.
    paint: usize,
    hulls: [ColliderBuilder; 2],
}

impl Model {
    fn load(path: &Path, pool: &ThreadPool) -> Result<Self> {
        let bytes = fs::read(path).with_context(|| format!("reading {}", path.display()))?;
        let all = Patterns::default();
        let imported = gltf_slice(&bytes, None, Reading { mesh: MeshChoice::Nodes(&all), ..Reading::default() })?;
        let (meshes, parts) = (imported.part_meshes(), imported.parts);
        let (coats, coat_of) = coats(&bytes, &imported.primitives, imported.mesh.positions.len());
        let paint = imported.primitives.iter().find(|range| range.material.as_deref() == Some("paint"));
        let paint = coat_of[paint.context("the car has no paint")?.first_vertex as usize] as usize;
        let options = SetOptions { basis: Some(BasisOptions::new(TOLERANCE)), ..SetOptions::default() };
        let mut set = ExampleSet::build(imported.mesh, imported.examples, options, pool)?;
        let (mut bumper, mut glass) = (None, Vec::new());
        for (i, (part, mesh)) in parts.iter().zip(meshes).enumerate() {
            if part.kind == PartKind::Glass {
                glass.push((set.add_lod(mesh, pool)?, i));
            } else if part.name == "bumper_front" {
                bumper = Some((set.add_lod(mesh, pool)?, i));
            }
        }
        let wheel = |(part, of): (usize, &Part)| -> Result<Wheel> {
            let Aabb { min, max } = Aabb::of(&set.mesh().positions()[of.vertices()]);
            let centre = (min + max) * 0.5;
            // What holds it is the chassis in its middle.
            let mount = set.attach((centre * Vec3::new(0.5, 1.0, 1.0)).to_array())?;
            Ok(Wheel { part, centre, mount })
        };
        let wheels = parts.iter().enumerate().filter(|(_, part)| part.name.starts_with("wheel_"));
        let wheels = wheels.map(wheel).collect::<Result<Vec<_>>>()?;
        let bumper = bumper.context("the car has no bumper_front")?;
        let hulls = hulls(&set, &parts)?;
        Ok(Model { set: Arc::new(set), parts, bumper, glass, wheels, coats, coat_of, paint, hulls })
    }
}

/// The convex hulls of the lower body and of the greenhouse.
fn hulls(set: &ExampleSet, parts: &[Part]) -> Result<[ColliderBuilder; 2]> {
    let own = |part: &&Part| !["wheel_", "mirror_", "antenna"].iter().any(|start| part.name.starts_with(start));
    let points = parts.iter().filter(own).flat_map(|part| &set.mesh().positions()[part.vertices()]);
    let (upper, lower): (Vec<Vec3>, Vec<Vec3>) = points.partition(|p| p.y > BELT);
    let hull = |points: Vec<Vec3>| {
        let points: Vec<Vector> = points.iter().map(vector).collect();
        ColliderBuilder::convex_hull(&points).context("the car has no hull")
    };
    Ok([hull(lower)?.mass(0.8 * MASS), hull(upper)?.mass(0.2 * MASS)])
}

/// A body that moves, m/s.
fn moving(at: Vec3, turn: Quat, speed: Vec3) -> RigidBodyBuilder {
    let rotation = Vector::from_array(turn.to_scaled_axis().to_array());
    RigidBodyBuilder::dynamic().translation(vector(&at)).rotation(rotation).linvel(vector(&speed))
}

fn vector(v: &Vec3) -> Vector {
    Vector::from_array(v.to_array())
}

/// A body of the physics, and the vertices that Crumple writes for it.
struct Dented {
    body: RigidBodyHandle,
    instance: Instance,
    tracker: Tracker,
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
}

impl Dented {
    fn deform(&mut self, pool: &ThreadPool) -> Result<()> {
        let memory = VertexMemory::separate(&mut self.positions, Some(&mut self.normals), None)?;
        self.instance.deform(&mut self.tracker, memory, pool)?;
        Ok(())
    }
}

/// A bumper that has come off.
struct Bumper {
    dented: Dented,
    /// Of its box, in the car's space, m.
    centre: Vec3,
}

struct Car {
    dented: Dented,
    paint: Coat,
    /// How far it has rolled, m.
    way: f32,
    /// When it first was hit, s.
    crashed: f32,
    bumper: Option<Bumper>,
    /// Parts of the set that are broken.
    broken: Vec<usize>,
}

/// The vertices of a frame.
#[derive(Default)]
struct Shown {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    coat_of: Vec<f32>,
    coats: Vec<Coat>,
}

struct Scene {
    model: Arc<Model>,
    world: PhysicsWorld,
    contacts: RapierContacts,
    cars: Vec<Car>,
    time: f64,
}

impl Scene {
    fn new(model: &Arc<Model>) -> Result<Self> {
        let mut world = PhysicsWorld::default();
        world.integration_parameters.dt = 1.0 / HZ as f32;
        world.integration_parameters.contact_softness = GIVE;
        world.integration_parameters.static_contact_softness = GIVE;
        let contacts = RapierContacts::new(ContactOptions::default())?;
        let mut scene = Scene { model: model.clone(), world, contacts, cars: Vec::new(), time: 0.0 };
        let red = Coat::of(Vec3::new(0.33, 0.012, 0.01), 0.5, 0.28);
        scene.add(Vec3::new(0.0, 0.0, -6.6), Quat::IDENTITY, SPEEDS[0], model.coats[model.paint])?;
        scene.add(Vec3::new(10.4, 0.0, -2.7), Quat::from_rotation_y(-std::f32::consts::FRAC_PI_2), SPEEDS[1], red)?;
        let post = ColliderBuilder::cylinder(0.5 * HEIGHT, POST).translation(vector(&(PLACE + 0.5 * HEIGHT * UP)));
        scene.world.insert_collider(post.friction(0.5), None);
        let ground = ColliderBuilder::cuboid(50.0, 1.0, 50.0).translation(vector(&(UP * (SINKS - 1.0))));
        scene.world.insert_collider(ground.collision_groups(FALLEN), None);
        Ok(scene)
    }

    fn add(&mut self, at: Vec3, turn: Quat, speed: f32, paint: Coat) -> Result<()> {
        let body = moving(at, turn, turn * Vec3::Z * speed)
            // On its wheels.
            .gravity_scale(0.0)
            .enabled_translations(true, false, true)
            .enabled_rotations(false, true, false)
            .can_sleep(false);
        let body = self.world.insert_body(body);
        let instance =
            Instance::new(self.model.set.clone(), InstanceOptions { grow_time: 0.04, ..Default::default() })?;
        for hull in self.model.hulls.clone() {
            let collider = self.world.insert_collider(hull.friction(0.3).collision_groups(DRIVES), Some(body));
            self.contacts.dent(collider, instance.inbox().clone());
        }
        let mesh = self.model.set.mesh();
        let bare = |v: &[Vec3]| v.iter().map(Vec3::to_array).collect::<Vec<_>>();
        let (positions, normals) = (bare(mesh.positions()), bare(mesh.normals().context("the car has no normals")?));
        let dented = Dented { body, instance, tracker: Tracker::new(), positions, normals };
        self.cars.push(Car { dented, paint, way: 0.0, crashed: f32::INFINITY, bumper: None, broken: Vec::new() });
        Ok(())
    }

    fn step(&mut self) -> Result<()> {
        self.time += 1.0 / HZ as f64;
        for Car { dented, .. } in &mut self.cars {
            dented.instance.set_time(self.time)?;
            dented.instance.set_transform(pose(&self.world, dented.body))?;
        }
        self.contacts.before_step(&self.world.bodies);
        self.world.step();
        let (world, seconds) = (&self.world, 1.0 / HZ as f32);
        let report = self.contacts.after_step(&world.bodies, &world.colliders, world.contact_pairs(), seconds)?;
        ensure!(report.refusal.is_none(), "a body refuses a hit: {:?}", report.refusal);
        for (i, car) in self.cars.iter_mut().enumerate() {
            let body = &mut self.world.bodies[car.dented.body];
            let ahead = Quat::from_array(body.rotation().to_array()) * Vec3::Z;
            car.way += Vec3::from(body.linvel().to_array()).dot(ahead) * seconds;
            // Who has crashed brakes.
            if !car.dented.instance.marks()?.is_empty() && body.linear_damping() == 0.0 {
                body.set_linear_damping(1.2);
                body.set_angular_damping(1.5);
                car.crashed = self.time as f32;
            }
            if i == 1 && self.time as f32 > car.crashed + BACK_OFF.0 {
                body.set_linvel(vector(&(ahead * -BACK_OFF.1)), true);
            }
        }
        Ok(())
    }

    /// What the dents do to the cars, and the vertices of all that is to be seen.
    fn shown(&mut self, pool: &ThreadPool) -> Result<Shown> {
        let mut shown = Shown { coats: self.model.coats.clone(), ..Shown::default() };
        let model = self.model.clone();
        let steel = Coat { paint: Vec3::splat(0.2), flakes: Vec3::splat(0.05), gloss: 0.2 };
        let crazed = Coat { paint: Vec3::new(0.33, 0.36, 0.37), flakes: Vec3::ZERO, gloss: 0.05 };
        shown.coats.extend([steel, crazed]);
        let (steel, crazed) = (model.coats.len(), model.coats.len() + 1);
        for car in &mut self.cars {
            car.dented.deform(pool)?;
            for (part, _) in &model.glass {
                if !car.broken.contains(part) && car.dented.instance.measure(*part)?.deepest > GLASS_HOLDS {
                    car.broken.push(*part);
                }
            }
            if car.bumper.is_none() && car.dented.instance.measure(model.bumper.0)?.deepest > BUMPER_HOLDS {
                car.bumper = Some(Bumper::of(car, &model, &mut self.world)?);
            }
            if let Some(Bumper { dented, .. }) = &mut car.bumper {
                dented.instance.set_time(self.time)?;
                dented.deform(pool)?;
            }
            let own = shown.coats.len() as f32;
            shown.coats.push(car.paint);
            let place = pose(&self.world, car.dented.body);
            for (i, part) in model.parts.iter().enumerate() {
                let glass = model.glass.iter().find(|(_, of)| *of == i);
                let is_broken = glass.is_some_and(|(lod, _)| car.broken.contains(lod));
                let coat = |v: usize| match model.coat_of[v] {
                    _ if is_broken => crazed as f32,
                    coat if coat == model.paint as f32 => own,
                    coat => coat,
                };
                let wheel = model.wheels.iter().find(|wheel| wheel.part == i);
                let (dented, at) = match (wheel, &car.bumper) {
                    (Some(wheel), _) => (&car.dented, place * car.rolled(wheel)?),
                    (None, Some(Bumper { dented, centre })) if i == model.bumper.1 => {
                        (dented, pose(&self.world, dented.body) * Mat4::from_translation(-*centre))
                    }
                    _ => (&car.dented, place),
                };
                shown.add(&model, part, dented, at, coat);
            }
        }
        shown.post(steel as f32);
        // No triangle has these.
        shown.positions.extend(corners(STAGE));
        shown.normals.extend([UP; 8]);
        shown.coat_of.extend([0.0; 8]);
        Ok(shown)
    }
}

fn pose(world: &PhysicsWorld, body: RigidBodyHandle) -> Mat4 {
    let body = &world.bodies[body];
    let turn = Quat::from_array(body.rotation().to_array());
    Mat4::from_rotation_translation(turn, Vec3::from_array(body.translation().to_array()))
}

impl Car {
    /// Where a wheel is on the car: it rolls, and moves and turns as what holds it does.
    fn rolled(&self, wheel: &Wheel) -> Result<Mat4> {
        let held = self.dented.instance.attached_pose(&wheel.mount)?;
        let turn = Quat::from_array(held.rotation);
        let moved = Vec3::from(held.position) - Vec3::from(wheel.mount.point);
        let roll = Quat::from_rotation_x(self.way / WHEEL);
        Ok(Mat4::from_rotation_translation(turn * roll, wheel.centre + moved) * Mat4::from_translation(-wheel.centre))
    }
}

impl Bumper {
    /// Takes the bumper off: a box for the physics, which falls.
    fn of(car: &mut Car, model: &Model, world: &mut PhysicsWorld) -> Result<Self> {
        let instance = car.dented.instance.release(model.bumper.0)?;
        let Dented { positions, normals, .. } = &car.dented;
        let own = positions[model.parts[model.bumper.1].vertices()].iter().map(|p| Vec3::from_array(*p));
        let Aabb { min, max } = Aabb::of(&own.collect::<Vec<_>>());
        let (centre, half) = ((min + max) * 0.5, (max - min) * 0.5);
        let place = pose(world, car.dented.body);
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
    /// Adds a part of a car.
    fn add(&mut self, model: &Model, part: &Part, dented: &Dented, at: Mat4, coat: impl Fn(usize) -> f32) {
        let Dented { positions, normals, .. } = dented;
        let (own, first) = (part.vertices(), self.positions.len() as u32);
        self.positions.extend(positions[own.clone()].iter().map(|p| at.transform_point3(Vec3::from_array(*p))));
        self.normals.extend(normals[own.clone()].iter().map(|n| at.transform_vector3(Vec3::from_array(*n))));
        self.coat_of.extend(own.clone().map(coat));
        let triangles = &model.set.mesh().triangles()[part.first_triangle as usize..][..part.triangle_count as usize];
        self.triangles.extend(triangles.iter().map(|t| t.map(|v| v - part.first_vertex + first)));
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
