//! The contact layer behind a real engine: rapier's contacts as it reports them.

mod scenes;

use std::collections::HashMap;
use std::sync::Arc;

use crumple::{
    Blow, ContactLayer, ContactOptions, ContactPoint, ContactReport, ExampleSet, Instance, SetOptions, Striker,
};
use rapier3d::prelude::*;
use scenes::{Dice, build, displacements, new};

const MASS: f32 = 8.0;
const UP: Vector = Vector::Z;

/// A sheet of 1 m whose examples are blows of 8 kg at 3 to 6 m/s.
fn set() -> Arc<ExampleSet> {
    let mesh = scenes::sheet(24);
    let mut dice = Dice::new(3);
    let places = [[0.0, 0.0], [-0.25, 0.2], [0.25, -0.2], [-0.2, -0.25], [0.2, 0.25]];
    let examples = places.map(|[x, y]| {
        let depth = dice.between(0.03, 0.06);
        let mut example = scenes::bowl(&mesh, scenes::nearest(&mesh, [x, y, 0.0]), depth, 0.25);
        let striker = Striker { mass: Some(MASS), velocity: Some([0.0, 0.0, -100.0 * depth]), radius: None };
        example.blow = Blow { normal: Some([0.0, 0.0, 1.0]), ..Blow::of_striker(striker) };
        example
    });
    build(mesh, examples.to_vec(), SetOptions { depth_limit: Some(1.0), ..SetOptions::default() })
}

/// A world in which one collider dents, and the layer that hears of its contacts.
struct World {
    physics: PhysicsWorld,
    plate: ColliderHandle,
    body: Instance,
    contacts: ContactLayer,
    before: HashMap<RigidBodyHandle, (Vector, Vector, Vector)>,
}

impl World {
    /// The sheet is the top of a fixed block.
    fn new(hz: f32, gravity: f32) -> Self {
        let mut physics = PhysicsWorld { gravity: UP * -gravity, ..PhysicsWorld::default() };
        physics.integration_parameters.dt = 1.0 / hz;
        let block = ColliderBuilder::cuboid(30.0, 30.0, 0.5).translation(UP * -0.5).friction(0.6);
        let (_, plate) = physics.insert(RigidBodyBuilder::fixed(), block);
        let contacts = ContactLayer::new(ContactOptions::default()).unwrap();
        World { physics, plate, body: new(&set()), contacts, before: HashMap::new() }
    }

    fn add(&mut self, body: RigidBodyBuilder, shape: ColliderBuilder) -> RigidBodyHandle {
        self.physics.insert(body.can_sleep(false).ccd_enabled(true), shape.mass(MASS).friction(0.6)).0
    }

    /// Velocity of a body at a point, before the step.
    fn velocity(&self, body: Option<RigidBodyHandle>, point: Vector) -> Vector {
        let Some((linear, angular, centre)) = body.and_then(|body| self.before.get(&body)) else { return Vector::ZERO };
        *linear + angular.cross(point - *centre)
    }

    /// One step of the physics: notes velocities, steps, and reports each point with an impulse.
    fn step(&mut self) -> ContactReport {
        self.before.clear();
        for (handle, body) in self.physics.rigid_bodies() {
            self.before.insert(handle, (body.linvel(), body.angvel(), body.center_of_mass()));
        }
        self.physics.step();
        for (number, pair) in self.physics.contact_pairs().enumerate() {
            let colliders = [pair.collider1, pair.collider2].map(|c| &self.physics.colliders[c]);
            let bodies = colliders.map(|c| c.parent());
            let masses = bodies.map(|b| {
                let body = b.map(|b| &self.physics.bodies[b]).filter(|b| b.is_dynamic());
                Some(body.map_or(f32::INFINITY, |b| b.mass()))
            });
            if pair.collider1 != self.plate && pair.collider2 != self.plate {
                continue;
            }
            let dents = [pair.collider1, pair.collider2].map(|c| (c == self.plate).then(|| self.body.inbox().clone()));
            let (a, b) = (pair.collider1.into_raw_parts().0, pair.collider2.into_raw_parts().0);
            for manifold in pair.solver_manifolds() {
                for contact in manifold.points.iter().filter(|contact| contact.data.impulse > 0.0) {
                    let point = colliders[0].position() * contact.local_p1;
                    let velocity = self.velocity(bodies[1], point) - self.velocity(bodies[0], point);
                    let normal = manifold.data.normal.to_array();
                    let mut p =
                        ContactPoint::new(u64::from(a) << 32 | u64::from(b), dents.clone(), point.to_array(), normal);
                    p.impulse = Some(contact.data.impulse);
                    p.velocity = Some(velocity.to_array());
                    p.masses = masses;
                    self.contacts.report(&[p]).unwrap_or_else(|error| panic!("pair {number}: {error}"));
                }
            }
        }
        let report = self.contacts.step(self.physics.integration_parameters.dt).unwrap();
        assert_eq!(report.refusal, None);
        report
    }

    fn run(&mut self, seconds: f32) {
        let steps = (seconds / self.physics.integration_parameters.dt).round() as usize;
        (0..steps).for_each(|_| _ = self.step());
    }

    fn depth(&mut self) -> f32 {
        displacements(&mut self.body).iter().map(|d| d.length()).fold(0.0, f32::max)
    }
}

fn ball() -> ColliderBuilder {
    ColliderBuilder::ball(0.05)
}

fn box_() -> ColliderBuilder {
    ColliderBuilder::cuboid(0.05, 0.05, 0.05)
}

/// Minutes of simulation: ten in a soak run, where `CRUMPLE_SOAK` is above 1.
fn minutes() -> f32 {
    let soak = std::env::var("CRUMPLE_SOAK").ok().and_then(|s| s.parse().ok()).unwrap_or(1);
    if soak > 1 { 600.0 } else { 60.0 }
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
    let striker = Striker { mass: Some(MASS), velocity: Some([0.0, 0.0, -5.0]), radius: None };
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
    let totals = world.contacts.totals();
    assert!(world.body.marks().unwrap().is_empty(), "{what} left a mark: {totals:?}");
    assert!(totals.slow > 100, "{what} touched the plate: {totals:?}");
}

#[test]
fn a_box_that_rests_leaves_no_mark() {
    for hz in [30.0, 60.0] {
        let mut world = World::new(hz, 9.81);
        world.add(RigidBodyBuilder::dynamic().translation(UP * 0.0501), box_());
        world.run(minutes());
        whole(&mut world, "a box");
    }
}

#[test]
fn a_stack_of_ten_leaves_no_mark() {
    let mut world = World::new(60.0, 9.81);
    for i in 0..10 {
        world.add(RigidBodyBuilder::dynamic().translation(UP * (0.0501 + 0.1001 * i as f32)), box_());
    }
    world.run(minutes() / 2.0);
    whole(&mut world, "a stack");
}

#[test]
fn a_wheel_that_rolls_leaves_no_mark() {
    let mut world = World::new(60.0, 9.81);
    let start = Vector::new(-20.0, 0.0, 0.2);
    let wheel = RigidBodyBuilder::dynamic().translation(start).linvel(Vector::X * 5.0).angvel(Vector::Y * 25.0);
    let wheel = world.add(wheel, ColliderBuilder::ball(0.2));
    for _ in 0..(minutes() * 60.0) as usize {
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
    for _ in 0..(minutes() * 30.0) as usize {
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
    for _ in 0..(60.0 * minutes() / 10.0) as usize {
        let body = world.physics.rigid_bodies_mut().find(|(handle, _)| *handle == sliding).unwrap().1;
        let x = if body.translation().x > 20.0 { -20.0 } else { body.translation().x };
        let at = body.translation();
        body.set_translation(Vector::new(x, 0.0, at.z), true);
        body.set_linvel(Vector::new(6.0, 0.0, body.linvel().z), true);
        world.step();
    }
    whole(&mut world, "a sliding box");
}
