//! The contact layer behind a real engine: rapier's contacts as it reports them.

use std::sync::Arc;

use crumple::glam::{Mat4, Quat, Vec3};
use crumple::{Blow, ContactOptions, ContactReport, ExampleSet, Instance, SetOptions, Striker};
use rapier3d::prelude::*;

use crate::rapier_contacts::RapierContacts;
use crate::scenes::{self, Dice, build, displacements, new};

const MASS: f32 = 8.0;
const UP: Vector = Vector::Z;

/// A sheet of 1 m whose examples are blows of 8 kg at 3 to 6 m/s; softer ones at less.
fn set_of(softness: f32) -> Arc<ExampleSet> {
    let mesh = scenes::sheet(24);
    let mut dice = Dice::new(3);
    let places = [[0.0, 0.0], [-0.25, 0.2], [0.25, -0.2], [-0.2, -0.25], [0.2, 0.25]];
    let examples = places.map(|[x, y]| {
        let depth = dice.between(0.03, 0.06);
        let mut example = scenes::bowl(&mesh, scenes::nearest(&mesh, [x, y, 0.0]), depth, 0.25);
        let striker = Striker {
            mass: Some(MASS),
            velocity: Some([0.0, 0.0, -100.0 * depth / softness]),
            radius: None,
            ..Default::default()
        };
        example.blow = Blow { normal: Some([0.0, 0.0, 1.0]), ..Blow::of_striker(striker) };
        example
    });
    build(mesh, examples.to_vec(), SetOptions { depth_limit: Some(1.0), ..SetOptions::default() })
}

fn set() -> Arc<ExampleSet> {
    set_of(1.0)
}

/// A body that moves, with a sheet as its front.
struct Car {
    handle: RigidBodyHandle,
    body: Instance,
}

/// A world in which a plate dents, and cars do.
struct World {
    physics: PhysicsWorld,
    body: Instance,
    cars: Vec<Car>,
    contacts: RapierContacts,
    steps: u32,
}

impl World {
    /// The sheet is the top of a fixed block.
    fn new(hz: f32, gravity: f32) -> Self {
        let mut world = World::empty(hz, gravity);
        let block = ColliderBuilder::cuboid(30.0, 30.0, 0.5).translation(UP * -0.5).friction(0.6);
        let (_, plate) = world.physics.insert(RigidBodyBuilder::fixed(), block);
        world.contacts.dent(plate, world.body.inbox().clone());
        world
    }

    fn empty(hz: f32, gravity: f32) -> Self {
        let mut physics = PhysicsWorld { gravity: UP * -gravity, ..PhysicsWorld::default() };
        physics.integration_parameters.dt = 1.0 / hz;
        let contacts = RapierContacts::new(ContactOptions::default()).unwrap();
        World { physics, body: new(&set()), cars: Vec::new(), contacts, steps: 0 }
    }

    fn add(&mut self, body: RigidBodyBuilder, shape: ColliderBuilder) -> RigidBodyHandle {
        self.physics.insert(body.can_sleep(false).ccd_enabled(true), shape.mass(MASS).friction(0.6)).0
    }

    /// Adds a block of 1 m by 1 m by 2 m. The sheet is its end along its own z.
    fn add_car(&mut self, body: RigidBodyBuilder, mass: f32, set: &Arc<ExampleSet>) -> usize {
        let shape = ColliderBuilder::cuboid(0.5, 0.5, 1.0).mass(mass).friction(0.3);
        let (handle, collider) = self.physics.insert(body.can_sleep(false), shape);
        let body = new(set);
        self.contacts.dent(collider, body.inbox().clone());
        self.cars.push(Car { handle, body });
        self.cars.len() - 1
    }

    fn step(&mut self) -> ContactReport {
        for car in &self.cars {
            let body = &self.physics.bodies[car.handle];
            let (at, turn) = (body.translation().to_array(), body.rotation().to_array());
            let pose = Mat4::from_rotation_translation(Quat::from_array(turn), Vec3::from_array(at));
            car.body.set_transform(pose * Mat4::from_translation(Vec3::Z)).unwrap();
        }
        self.contacts.before_step(&self.physics.bodies);
        self.physics.step();
        let (world, seconds) = (&self.physics, self.physics.integration_parameters.dt);
        let report = self.contacts.after_step(&world.bodies, &world.colliders, world.contact_pairs(), seconds).unwrap();
        assert_eq!(report.refusal, None);
        self.steps += 1;
        report
    }

    fn run(&mut self, seconds: f32) {
        let steps = (seconds / self.physics.integration_parameters.dt).round() as usize;
        (0..steps).for_each(|_| _ = self.step());
    }

    fn depth(&mut self) -> f32 {
        deepest(&mut self.body)
    }
}

fn deepest(body: &mut Instance) -> f32 {
    displacements(body).iter().map(|d| d.length()).fold(0.0, f32::max)
}

fn ball() -> ColliderBuilder {
    ColliderBuilder::ball(0.05)
}

fn box_() -> ColliderBuilder {
    ColliderBuilder::cuboid(0.05, 0.05, 0.05)
}

/// How long a scene lasts, s: `short` in a test run, ten minutes in a soak run, where `CRUMPLE_SOAK` is above 1.
fn seconds(short: f32) -> f32 {
    let soak = std::env::var("CRUMPLE_SOAK").ok().and_then(|s| s.parse().ok()).unwrap_or(1);
    if soak > 1 { 600.0 } else { short }
}

/// The dent of something thrown down at 5 m/s, from a height that puts the touch at `phase` of a step.
fn thrown(shape: ColliderBuilder, hz: f32, phase: f32) -> f32 {
    let mut world = World::new(hz, 0.0);
    let height = 0.05 + 0.2 + phase * 5.0 / hz;
    world.add(RigidBodyBuilder::dynamic().translation(UP * height).linvel(UP * -5.0), shape);
    world.run(0.5);
    assert_eq!(world.body.marks().unwrap().len(), 1, "{hz} Hz, phase {phase}");
    world.depth()
}

#[test]
fn a_ball_and_a_box_leave_the_same_dent_at_any_rate() {
    let mut told = new(&set());
    let striker = Striker { mass: Some(MASS), velocity: Some([0.0, 0.0, -5.0]), radius: None, ..Default::default() };
    told.submit(&crumple::Hit::blow([0.0; 3], Blow { normal: Some([0.0, 0.0, 1.0]), ..Blow::of_striker(striker) }))
        .unwrap();
    let told = displacements(&mut told).iter().map(|d| d.length()).fold(0.0, f32::max);
    for hz in [30.0, 60.0, 240.0] {
        for phase in [0.0, 0.3, 0.7] {
            for (name, shape) in [("ball", ball()), ("box", box_())] {
                let got = thrown(shape, hz, phase);
                println!("{name}, {hz} Hz, phase {phase}: {got} m of {told} m");
                assert!((got / told - 1.0).abs() < 0.05, "{name}, {hz} Hz, phase {phase}: {got} m instead of {told} m");
            }
        }
    }
}

fn whole(world: &mut World, what: &str) {
    let totals = world.contacts.layer.totals();
    assert!(world.body.marks().unwrap().is_empty(), "{what} left a mark: {totals:?}");
    assert!(totals.slow > 100, "{what} touched the plate: {totals:?}");
    println!("{what}: no mark after {:.0} s: {totals:?}", world.physics.integration_parameters.dt * world.steps as f32);
}

#[test]
fn a_box_that_rests_leaves_no_mark() {
    for hz in [30.0, 60.0] {
        let mut world = World::new(hz, 9.81);
        world.add(RigidBodyBuilder::dynamic().translation(UP * 0.0501), box_());
        world.run(seconds(60.0));
        whole(&mut world, "a box");
    }
}

#[test]
fn a_stack_of_ten_leaves_no_mark() {
    let mut world = World::new(60.0, 9.81);
    for i in 0..10 {
        world.add(RigidBodyBuilder::dynamic().translation(UP * (0.0501 + 0.1001 * i as f32)), box_());
    }
    world.run(seconds(30.0));
    whole(&mut world, "a stack");
}

#[test]
fn a_wheel_that_rolls_leaves_no_mark() {
    let mut world = World::new(60.0, 9.81);
    let start = Vector::new(-20.0, 0.0, 0.2);
    let wheel = RigidBodyBuilder::dynamic().translation(start).linvel(Vector::X * 5.0).angvel(Vector::Y * 25.0);
    let wheel = world.add(wheel, ColliderBuilder::ball(0.2));
    for _ in 0..(seconds(60.0) * 60.0) as usize {
        let body = world.physics.rigid_bodies_mut().find(|(handle, _)| *handle == wheel).unwrap().1;
        let at = body.translation();
        if at.x > 20.0 {
            body.set_translation(at - Vector::X * 40.0, true);
        }
        body.set_linvel(Vector::new(5.0, 0.0, body.linvel().z), true);
        world.step();
    }
    whole(&mut world, "a wheel");
}

#[test]
fn a_jammed_body_that_jitters_leaves_no_mark() {
    let mut world = World::new(30.0, 9.81);
    // The gap under the lid is 5 mm too low for the box.
    let lid = ColliderBuilder::cuboid(1.0, 1.0, 0.5).translation(UP * 0.595);
    world.physics.insert(RigidBodyBuilder::fixed(), lid);
    let jammed = world.add(RigidBodyBuilder::dynamic().translation(UP * 0.05), box_());
    let mut dice = Dice::new(1);
    for _ in 0..(seconds(60.0) * 30.0) as usize {
        let push = Vector::from_array(dice.vector(0.3 * MASS));
        let body = world.physics.rigid_bodies_mut().find(|(handle, _)| *handle == jammed).unwrap().1;
        body.apply_impulse(push, true);
        world.step();
    }
    whole(&mut world, "a jammed box");
}

#[test]
fn a_box_that_slides_along_leaves_no_mark() {
    let mut world = World::new(60.0, 9.81);
    let sliding = world.add(RigidBodyBuilder::dynamic().translation(Vector::new(-20.0, 0.0, 0.0501)), box_());
    for _ in 0..(seconds(6.0) * 60.0) as usize {
        let body = world.physics.rigid_bodies_mut().find(|(handle, _)| *handle == sliding).unwrap().1;
        let x = if body.translation().x > 20.0 { -20.0 } else { body.translation().x };
        let at = body.translation();
        body.set_translation(Vector::new(x, 0.0, at.z), true);
        body.set_linvel(Vector::new(6.0, 0.0, body.linvel().z), true);
        world.step();
    }
    whole(&mut world, "a sliding box");
}

/// Drives two cars into each other at 5 m/s each, and returns how deep they are dented.
fn head_on(hz: f32, masses: [f32; 2], sets: [&Arc<ExampleSet>; 2]) -> [f32; 2] {
    let mut world = World::empty(hz, 0.0);
    for side in [0, 1] {
        let sign = [1.0, -1.0][side];
        let turn = Vector::X * if side == 0 { 0.0 } else { std::f32::consts::PI };
        let body = RigidBodyBuilder::dynamic().translation(UP * (-1.3 * sign)).rotation(turn).linvel(UP * (5.0 * sign));
        world.add_car(body, masses[side], sets[side]);
    }
    world.run(0.5);
    [0, 1].map(|side| deepest(&mut world.cars[side].body))
}

#[test]
fn two_equal_cars_head_on_get_equal_dents() {
    let set = set();
    for hz in [30.0, 60.0, 240.0] {
        let [a, b] = head_on(hz, [MASS; 2], [&set, &set]);
        println!("{hz} Hz: {a} m and {b} m");
        assert!(a > 0.01 && (a / b - 1.0).abs() < 0.02, "{hz} Hz: {a} m and {b} m");
    }
}

#[test]
fn of_a_car_and_a_heavier_gate_the_softer_one_gives_way() {
    let (soft, hard) = (set_of(2.0), set_of(0.5));
    for hz in [30.0, 60.0, 240.0] {
        let [car, gate] = head_on(hz, [MASS, 20.0 * MASS], [&soft, &hard]);
        println!("{hz} Hz: a soft car {car} m, its gate {gate} m");
        assert!(car > 3.0 * gate, "{hz} Hz: {car} m and {gate} m");
        let [car, gate] = head_on(hz, [MASS, 20.0 * MASS], [&hard, &soft]);
        println!("{hz} Hz: a hard car {car} m, its gate {gate} m");
        assert!(gate > 3.0 * car, "{hz} Hz: {car} m and {gate} m");
    }
}

/// The car runs into a wall at 2 m/s while it drives along at 8 m/s, and is pressed against it by twice its weight.
#[test]
fn a_car_that_grinds_along_a_wall_keeps_the_dent_of_its_first_hit() {
    for hz in [30.0, 60.0] {
        let mut world = World::empty(hz, 0.0);
        let wall = ColliderBuilder::cuboid(2000.0, 30.0, 0.5).translation(UP * 1.7).friction(0.3);
        world.physics.insert(RigidBodyBuilder::fixed(), wall);
        let start = RigidBodyBuilder::dynamic().linvel(Vector::new(8.0, 0.0, 2.0));
        let car = world.add_car(start.enabled_rotations(false, false, false), MASS, &set());
        let mut dice = Dice::new(1);
        let mut first = 0.0;
        for step in 0..(seconds(60.0) * hz) as usize {
            let handle = world.cars[car].handle;
            let body = &mut world.physics.bodies[handle];
            let velocity = body.linvel();
            body.set_linvel(Vector::new(8.0, 0.0, velocity.z), true);
            if body.translation().x > 1000.0 {
                body.set_translation(body.translation() - Vector::X * 2000.0, true);
            }
            // The road shakes it.
            body.apply_impulse(UP * (MASS * (2.0 * 9.81 / hz + dice.between(-0.2, 0.2))), true);
            world.step();
            if step == hz as usize / 2 {
                first = deepest(&mut world.cars[car].body);
            }
        }
        let last = deepest(&mut world.cars[car].body);
        println!("{hz} Hz: {first} m at first, {last} m at last, {:?}", world.contacts.layer.totals());
        assert!(first > 0.002, "{hz} Hz: the first hit left {first} m");
        assert!(last <= first, "{hz} Hz: {last} m instead of {first} m");
    }
}
