//! From the physics server to the contact layer. After each step, before the game's `_physics_process`, the points that the
//! watched bodies touch are reported. After the game's `_physics_process`, the velocities are noted for the next step, so that
//! velocities set by the game are no hits.
//!
//! Neither of Godot's physics engines reports usable impulses of single points: Jolt reports the whole impulse at every
//! point, and Godot Physics reports 0 in the step of the impact. So the impulse of a pair is its change of momentum.

use crate::node::{CrumpleMeshInstance3D, array};
use crate::sight::Sight;
use crumple::{ContactLayer, ContactOptions, ContactPoint, Inbox, Outcome};
use godot::builtin::Rid;
use godot::classes::physics_server_3d::BodyMode;
use godot::classes::{
    CharacterBody3D, PhysicsBody3D, PhysicsDirectBodyState3D, PhysicsServer3D, RigidBody3D, SceneTree,
};
use godot::prelude::*;
use std::cell::RefCell;
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

/// Points of contact that watched bodies report.
const POINTS: i32 = 16;
/// A body that does not move sees others within this distance of its mesh, m. A striker must be seen two steps before it
/// touches.
const SIGHT: f32 = 4.0;
/// Each body is looked at once in so many steps, for whether and where it moves.
const PAUSE: u64 = 8;
/// Bodies that are gone are forgotten once in so many steps.
const CLEANED: u64 = 64;
/// Seconds that a moving body is watched after it was near.
const WATCHED: f64 = 0.5;

/// A body whose nodes dent.
struct Owner {
    body: InstanceId,
    nodes: Vec<InstanceId>,
    /// Whether no step has looked at it yet.
    new: bool,
    character: bool,
    /// Where it looks for strikers, if it does not move.
    sight: Option<Sight>,
}

/// A rigid body whose momentum is watched.
struct Mover {
    /// The body's node.
    body: InstanceId,
    /// How it moved before the step. `None`: not known yet.
    before: Option<Motion>,
    /// Until when it is watched, s. Bodies with nodes of their own are watched always.
    until: f64,
    /// The bodies that see it, each with the part that it sees.
    near: HashSet<(Rid, i64)>,
    /// What it reported before it was watched.
    reported: i32,
}

/// How a body moves.
#[derive(Clone, Copy)]
struct Motion {
    linear: Vector3,
    angular: Vector3,
    centre: Vector3,
}

impl Motion {
    fn of(state: &Gd<PhysicsDirectBodyState3D>) -> Self {
        let centre = state.get_transform().origin + state.get_center_of_mass();
        Self { linear: state.get_linear_velocity(), angular: state.get_angular_velocity(), centre }
    }

    fn at(&self, point: Vector3) -> Vector3 {
        self.linear + self.angular.cross(point - self.centre)
    }
}

/// A point that a body touches.
struct Touch {
    other: Rid,
    /// Whether the other's velocity before the step is known.
    known: bool,
    /// Out of the other body.
    out: Vector3,
    place: Vector3,
    /// Of the other relative to the body before the step, m/s.
    velocity: Vector3,
    /// kg. `None` if nothing moves it.
    other_mass: Option<f32>,
}

impl Touch {
    fn comes(&self) -> bool {
        self.velocity.dot(self.out) > 0.0
    }
}

#[derive(Default)]
struct Physics {
    tree: Option<InstanceId>,
    owners: HashMap<Rid, Owner>,
    movers: HashMap<Rid, Mover>,
    /// The velocities of characters before the step.
    characters: HashMap<Rid, Vector3>,
    /// Time of the physics, s.
    now: f64,
    steps: u64,
    /// Whether it was said that a contact was not taken.
    warned: bool,
}

thread_local! {
    static PHYSICS: RefCell<Physics> = RefCell::default();
    static LAYER: ContactLayer = ContactLayer::new(ContactOptions::default()).expect("the defaults are right");
}

/// What one step leaves.
#[derive(Default)]
struct Report {
    points: Vec<ContactPoint>,
    /// The nodes of the points' bodies.
    nodes: Vec<(Arc<Inbox>, Gd<CrumpleMeshInstance3D>)>,
    /// How long the step was, s.
    seconds: f32,
}

impl Report {
    /// The inbox of the node of a body that is nearest to a place.
    fn dented(&mut self, nodes: &[InstanceId], place: Vector3) -> Option<Arc<Inbox>> {
        let node = nearest(nodes, place)?;
        let inbox = CrumpleMeshInstance3D::touched(&node)?;
        if !self.nodes.iter().any(|(known, _)| Arc::ptr_eq(known, &inbox)) {
            self.nodes.push((inbox.clone(), node));
        }
        Some(inbox)
    }

    /// What is wrong may be so in each step, so it is said once. The layer does not tell whose hit it was.
    fn warn(&self, error: &crumple::Error) {
        if !PHYSICS.with_borrow_mut(|physics| std::mem::replace(&mut physics.warned, true)) {
            let names: Vec<String> = self.nodes.iter().map(|(_, node)| node.get_name().to_string()).collect();
            godot_error!("CrumpleMeshInstance3D: a contact of one of {} was not taken: {error}", names.join(", "));
        }
    }
}

/// Lets collisions of a body dent a node.
pub fn watch(node: &Gd<CrumpleMeshInstance3D>, body: &Gd<PhysicsBody3D>) {
    let Some(mut tree) = node.get_tree_or_null() else { return };
    let new = PHYSICS.with_borrow_mut(|physics| {
        let character = body.clone().try_cast::<CharacterBody3D>().is_ok();
        let new = Owner { body: body.instance_id(), nodes: Vec::new(), new: true, character, sight: None };
        physics.owners.entry(body.get_rid()).or_insert(new).nodes.push(node.instance_id());
        physics.tree.replace(tree.instance_id()) != Some(tree.instance_id())
    });
    if new {
        tree.connect("physics_frame", &Callable::from_fn("crumple_physics", |_| stepped()));
    }
}

/// A node leaves.
pub fn forget(node: InstanceId) {
    PHYSICS.with_borrow_mut(|physics| {
        physics.owners.values_mut().for_each(|owner| owner.nodes.retain(|id| *id != node));
        physics.clean();
    });
}

/// A body that does not move sees a part of another body come or go.
pub fn seen(by: (Rid, i64), rid: Rid, id: i64, entered: bool) {
    let body = InstanceId::try_from_i64(id).filter(|id| Gd::<RigidBody3D>::try_from_instance_id(*id).is_ok());
    PHYSICS.with_borrow_mut(|physics| {
        if let (true, Some(body)) = (entered, body) {
            let until = physics.now + WATCHED;
            physics.follow(rid, body, until);
        }
        if let Some(mover) = physics.movers.get_mut(&rid) {
            if entered {
                mover.near.insert(by);
            } else {
                mover.near.remove(&by);
                mover.until = mover.until.max(physics.now + WATCHED);
            }
        }
    });
}

/// After a step: hits. No reference into the node or into this file is held while nodes are told, so that their signals
/// may do anything.
fn stepped() {
    let tree = PHYSICS.with_borrow(|physics| physics.tree);
    let tree = tree.and_then(|id| Gd::<SceneTree>::try_from_instance_id(id).ok());
    // A paused tree does not step.
    if tree.is_none_or(|tree| tree.is_paused()) {
        return;
    }
    let Some(report) = PHYSICS.with_borrow_mut(Physics::step) else { return };
    let mut hits: Vec<(Arc<Inbox>, Outcome)> = Vec::new();
    let told = LAYER.with(|layer| {
        layer.report(&report.points)?;
        let told = layer.step_each(report.seconds, |hit| hits.push((hit.inbox.clone(), *hit.outcome)))?;
        told.refusal.map_or(Ok(()), Err)
    });
    if let Err(error) = told {
        report.warn(&error);
    }
    for (inbox, outcome) in hits {
        if let Some((_, node)) = report.nodes.iter().find(|(own, _)| Arc::ptr_eq(own, &inbox)) {
            CrumpleMeshInstance3D::took(node, &outcome);
        }
    }
    // Runs after every `_physics_process` of this step.
    Callable::from_fn("crumple_note", |_| PHYSICS.with_borrow_mut(Physics::note)).call_deferred(&[]);
}

/// The node that was hit: of a body with several meshes, the nearest.
fn nearest(nodes: &[InstanceId], place: Vector3) -> Option<Gd<CrumpleMeshInstance3D>> {
    let mut nodes: Vec<_> = nodes.iter().filter_map(|id| Gd::try_from_instance_id(*id).ok()).collect();
    if nodes.len() < 2 {
        return nodes.pop();
    }
    let distance =
        |node: &Gd<CrumpleMeshInstance3D>| CrumpleMeshInstance3D::distance(node, place).unwrap_or(f32::INFINITY);
    nodes.into_iter().min_by(|a, b| distance(a).total_cmp(&distance(b)))
}

impl Physics {
    fn step(&mut self) -> Option<Report> {
        let mut server = PhysicsServer3D::singleton();
        if self.steps.is_multiple_of(CLEANED) {
            self.clean();
        }
        if self.owners.is_empty() {
            self.release();
            return None;
        }
        let step = 1.0 / godot::classes::Engine::singleton().get_physics_ticks_per_second().max(1) as f64;
        self.now += step;
        let mut report = Report { seconds: step as f32, ..Report::default() };
        self.steps += 1;
        let turn = self.steps % PAUSE;
        let due = self.owners.iter_mut().filter_map(|(rid, owner)| {
            let due = std::mem::take(&mut owner.new) || owner.character || rid.to_u64() % PAUSE == turn;
            due.then_some((*rid, owner.body, owner.character))
        });
        for (rid, body, character) in due.collect::<Vec<_>>() {
            if character {
                if let Ok(character) = Gd::<CharacterBody3D>::try_from_instance_id(body) {
                    self.character(rid, &character, &mut report);
                }
            } else if Gd::<PhysicsBody3D>::try_from_instance_id(body).is_err() {
                // It is gone; the next cleaning finds that.
            } else if matches!(server.body_get_mode(rid), BodyMode::RIGID | BodyMode::RIGID_LINEAR) {
                self.follow(rid, body, f64::INFINITY);
            } else {
                self.look_around(rid, &server);
            }
        }
        let movers: Vec<Rid> = self.movers.keys().copied().collect();
        for rid in movers {
            self.mover(rid, &mut server, &mut report);
        }
        Some(report)
    }

    /// Watches a mover until some time.
    fn follow(&mut self, rid: Rid, body: InstanceId, until: f64) {
        self.movers.entry(rid).and_modify(|mover| mover.until = until).or_insert_with(|| {
            let mut server = PhysicsServer3D::singleton();
            let reported = server.body_get_max_contacts_reported(rid);
            if reported < POINTS {
                server.body_set_max_contacts_reported(rid, POINTS);
            }
            Mover { body, before: None, until, near: HashSet::new(), reported }
        });
    }

    /// Stops watching everything.
    fn release(&mut self) {
        for (rid, mover) in self.movers.drain() {
            unfollow(rid, &mover);
        }
        self.characters.clear();
        LAYER.with(ContactLayer::clear);
    }

    /// Keeps the area around a body that does not move where the body is.
    fn look_around(&mut self, rid: Rid, server: &Gd<PhysicsServer3D>) {
        let Some(owner) = self.owners.get_mut(&rid) else { return };
        let nodes = owner.nodes.iter().filter_map(|id| Gd::<CrumpleMeshInstance3D>::try_from_instance_id(*id).ok());
        let Some(bounds) = nodes.map(|n| n.get_global_transform() * n.get_aabb()).reduce(|a, b| a.merge(b)) else {
            return;
        };
        let sight = owner.sight.get_or_insert_with(|| Sight::new(rid));
        sight.follow(bounds.grow(SIGHT), server.body_get_space(rid));
    }

    /// Forgets bodies whose nodes are gone.
    fn clean(&mut self) {
        let here =
            |owner: &Owner| !owner.nodes.is_empty() && Gd::<PhysicsBody3D>::try_from_instance_id(owner.body).is_ok();
        let gone: Vec<Rid> = self.owners.iter().filter(|(_, owner)| !here(owner)).map(|(rid, _)| *rid).collect();
        for rid in gone {
            if let Some(sight) = self.owners.remove(&rid).and_then(|owner| owner.sight) {
                sight.end();
                self.movers.values_mut().for_each(|mover| mover.near.retain(|(owner, _)| *owner != rid));
            }
        }
    }

    /// The contacts of a rigid body in the last step.
    fn mover(&mut self, rid: Rid, server: &mut Gd<PhysicsServer3D>, report: &mut Report) {
        let Some(mover) = self.movers.get(&rid) else { return };
        let watched = self.owners.contains_key(&rid) || !mover.near.is_empty() || mover.until > self.now;
        match (state_of(rid, mover.body, server).filter(|_| watched), mover.before) {
            (Some(state), Some(before)) if !state.is_sleeping() => self.contacts(rid, &state, before, report),
            (Some(_), _) => (),
            (None, _) => {
                if let Some(mover) = self.movers.remove(&rid) {
                    unfollow(rid, &mover);
                }
            }
        }
    }

    fn contacts(&self, rid: Rid, state: &Gd<PhysicsDirectBodyState3D>, before: Motion, report: &mut Report) {
        let (count, inverse) = (state.get_contact_count(), state.get_inverse_mass());
        if count == 0 || inverse <= 0.0 {
            return;
        }
        let mass = 1.0 / inverse;
        let changed = (state.get_linear_velocity() - before.linear) * mass;
        let touches: Vec<Touch> = (0..count).map(|i| self.touch(state, before, changed, i)).collect();
        for touch in &touches {
            // Of two watched bodies, one reports the pair.
            if touch.known && touch.other < rid {
                continue;
            }
            let Touch { other, out, place, velocity, other_mass, .. } = *touch;
            let struck = if self.characters.contains_key(&other) { Vec::new() } else { self.nodes_of(other) };
            let bodies = [report.dented(&self.nodes_of(rid), place), report.dented(&struck, place)];
            if bodies.iter().all(Option::is_none) {
                continue;
            }
            // The change of momentum belongs to all points that push the same way.
            let pushing = touches.iter().filter(|t| t.comes() && t.out.dot(out) > 0.5).count() as f32;
            let impulse = if touch.comes() { changed.dot(out).max(0.0) / pushing } else { 0.0 };
            let mut point = ContactPoint::new(pair(rid, other), bodies, array(place), array(-out));
            point.impulse = Some(impulse);
            point.velocity = Some(array(velocity));
            point.masses = [Some(mass), Some(other_mass.unwrap_or(f32::INFINITY))];
            report.points.push(point);
        }
    }

    /// A point that a body touches, whose momentum has changed.
    fn touch(&self, state: &Gd<PhysicsDirectBodyState3D>, before: Motion, changed: Vector3, i: i32) -> Touch {
        let (other, out) = (state.get_contact_collider(i), state.get_contact_local_normal(i));
        let place = state.get_contact_local_position(i);
        let other_mass = mass_of(other, state.get_contact_collider_object(i));
        // A body that was frozen since reports nothing.
        let known = other_mass.and_then(|_| self.movers.get(&other)?.before);
        let others = known.map_or_else(
            || {
                // What it is now, less what this body did.
                let gained = other_mass.map_or(0.0, |mass| changed.dot(out).max(0.0) / mass);
                state.get_contact_collider_velocity_at_position(i) + out * gained
            },
            |motion| motion.at(place),
        );
        Touch { other, known: known.is_some(), out, place, velocity: others - before.at(place), other_mass }
    }

    /// A character has no momentum. Its contacts are the stops of its last `move_and_slide`.
    fn character(&mut self, rid: Rid, body: &Gd<CharacterBody3D>, report: &mut Report) {
        let now = body.get_real_velocity();
        let Some(before) = self.characters.insert(rid, now) else { return };
        let nodes = self.nodes_of(rid);
        let Some(mass) = nodes.iter().find_map(|id| character_mass(*id)) else { return };
        for i in 0..body.get_slide_collision_count() {
            let Some(slide) = body.clone().get_slide_collision(i) else { continue };
            let (out, place, other) = (slide.get_normal(), slide.get_position(), slide.get_collider_rid());
            let inbox = report.dented(&nodes, place);
            // What the other body gets, it reports itself.
            let mut point = ContactPoint::new(!pair(rid, other), [inbox, None], array(place), array(-out));
            point.velocity = Some(array(slide.get_collider_velocity() - before));
            point.masses = [Some(mass), Some(f32::INFINITY)];
            report.points.push(point);
        }
    }

    fn nodes_of(&self, rid: Rid) -> Vec<InstanceId> {
        self.owners.get(&rid).map_or_else(Vec::new, |owner| owner.nodes.clone())
    }

    /// Before a step: velocities.
    fn note(&mut self) {
        let mut server = PhysicsServer3D::singleton();
        for (rid, mover) in &mut self.movers {
            mover.before = state_of(*rid, mover.body, &mut server).map(|state| Motion::of(&state));
        }
    }
}

/// The state of a body that is in the tree. The server prints an error for others.
fn state_of(rid: Rid, body: InstanceId, server: &mut Gd<PhysicsServer3D>) -> Option<Gd<PhysicsDirectBodyState3D>> {
    let body = Gd::<PhysicsBody3D>::try_from_instance_id(body).ok()?;
    if body.is_inside_tree() { server.body_get_direct_state(rid) } else { None }
}

/// The mass of a body, kg. `None` if nothing moves it.
fn mass_of(rid: Rid, body: Option<Gd<Object>>) -> Option<f32> {
    let body = body?.try_cast::<PhysicsBody3D>().ok()?;
    let mut server = PhysicsServer3D::singleton();
    if !matches!(server.body_get_mode(rid), BodyMode::RIGID | BodyMode::RIGID_LINEAR) {
        return None;
    }
    let inverse = state_of(rid, body.instance_id(), &mut server)?.get_inverse_mass();
    (inverse > 0.0).then_some(1.0 / inverse)
}

/// A number for two bodies, whichever is first. The lower half of a body's id is its place in the server's list.
fn pair(a: Rid, b: Rid) -> u64 {
    let [a, b] = [a, b].map(|rid| rid.to_u64() & u64::from(u32::MAX));
    a.min(b) << 32 | a.max(b)
}

fn unfollow(rid: Rid, mover: &Mover) {
    let mut server = PhysicsServer3D::singleton();
    if mover.reported < POINTS && Gd::<PhysicsBody3D>::try_from_instance_id(mover.body).is_ok() {
        server.body_set_max_contacts_reported(rid, mover.reported);
    }
}

fn character_mass(node: InstanceId) -> Option<f32> {
    let node = Gd::<CrumpleMeshInstance3D>::try_from_instance_id(node).ok()?;
    let mass = node.bind().character_mass();
    Some(mass)
}
