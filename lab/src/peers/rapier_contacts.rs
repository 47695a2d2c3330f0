//! Gives every contact of a rapier world to Crumple. Copy this file into your game.

use std::collections::HashMap;
use std::sync::Arc;

use crumple::{ContactLayer, ContactOptions, ContactPoint, ContactReport, Error, Inbox, StrikerShape};
use rapier3d::prelude::*;

pub struct RapierContacts {
    pub layer: ContactLayer,
    dented: HashMap<ColliderHandle, Arc<Inbox>>,
    /// Velocities and centre of mass of the bodies before the step.
    before: HashMap<RigidBodyHandle, (Vector, Vector, Vector)>,
    points: Vec<ContactPoint>,
}

impl RapierContacts {
    pub fn new(options: ContactOptions) -> Result<Self, Error> {
        let layer = ContactLayer::new(options)?;
        Ok(Self { layer, dented: HashMap::new(), before: HashMap::new(), points: Vec::new() })
    }

    /// Lets a collider dent. One that moves needs `Instance::set_transform` before each step of the world.
    pub fn dent(&mut self, collider: ColliderHandle, inbox: Arc<Inbox>) {
        self.dented.insert(collider, inbox);
    }

    /// Call it before each step: rapier's contacts come with the velocities after the solver, and a blow needs those before it.
    pub fn before_step(&mut self, bodies: &RigidBodySet) {
        self.before.clear();
        let motion = |body: &RigidBody| (body.linvel(), body.angvel(), body.center_of_mass());
        self.before.extend(bodies.iter().map(|(handle, body)| (handle, motion(body))));
    }

    /// Call it after each step, with `NarrowPhase::contact_pairs` or `PhysicsWorld::contact_pairs`.
    pub fn after_step<'a>(
        &mut self,
        bodies: &RigidBodySet,
        colliders: &ColliderSet,
        pairs: impl Iterator<Item = &'a ContactPair>,
        seconds: f32,
    ) -> Result<ContactReport, Error> {
        self.points.clear();
        for pair in pairs {
            self.add(bodies, colliders, pair);
        }
        self.layer.report(&self.points)?;
        self.layer.step(seconds)
    }

    fn add(&mut self, bodies: &RigidBodySet, colliders: &ColliderSet, pair: &ContactPair) {
        let handles = [pair.collider1, pair.collider2];
        let dented = handles.map(|handle| self.dented.get(&handle).cloned());
        if dented.iter().all(Option::is_none) {
            return;
        }
        let both = handles.map(|handle| &colliders[handle]);
        let parents = both.map(|collider| collider.parent());
        let mass = |parent: Option<RigidBodyHandle>| {
            let body = parent.map(|handle| &bodies[handle]).filter(|body| body.is_dynamic());
            Some(body.map_or(f32::INFINITY, RigidBody::mass))
        };
        let number = handles.map(|handle| u64::from(handle.into_raw_parts().0));
        for manifold in pair.solver_manifolds() {
            for contact in manifold.points.iter().filter(|contact| contact.data.impulse > 0.0) {
                let place = both[0].position() * contact.local_p1;
                let velocity = self.velocity(parents[1], place) - self.velocity(parents[0], place);
                let normal = manifold.data.normal.to_array();
                let pair = number[0] << 32 | number[1];
                let mut point = ContactPoint::new(pair, dented.clone(), place.to_array(), normal);
                point.impulse = Some(contact.data.impulse);
                point.velocity = Some(velocity.to_array());
                point.masses = parents.map(mass);
                // Examples tell what struck them, and a set predicts better if hits do, too.
                let balls = both.map(|collider| collider.shape().as_ball());
                point.radii = balls.map(|ball| ball.map(|ball| ball.radius));
                point.shapes = balls.map(|ball| ball.map_or(StrikerShape::Unknown, |_| StrikerShape::Ball));
                self.points.push(point);
            }
        }
    }

    /// Velocity of a body at a place, before the step.
    fn velocity(&self, body: Option<RigidBodyHandle>, place: Vector) -> Vector {
        let Some((linear, angular, centre)) = body.and_then(|body| self.before.get(&body)) else { return Vector::ZERO };
        *linear + angular.cross(place - *centre)
    }
}
