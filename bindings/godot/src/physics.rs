//! From the physics server to hits. After each step, before the game's `_physics_process`, the changes of momentum of
//! the watched bodies become impulses at the points that they touched. After the game's `_physics_process`, the
//! velocities are noted for the next step, so that velocities set by the game are no hits.

use crate::node::{CrumpleMeshInstance3D, array};
use crate::share::{self, Point};
use crate::sight::Sight;
use crate::touches::{Seen, Touches};
use crumple::{Blow, Striker};
use godot::builtin::Rid;
use godot::classes::physics_server_3d::BodyMode;
use godot::classes::{
    CharacterBody3D, PhysicsBody3D, PhysicsDirectBodyState3D, PhysicsServer3D, RigidBody3D, SceneTree,
};
use godot::prelude::*;
use std::cell::RefCell;
use std::collections::{HashMap, HashSet};
use std::num::NonZeroU64;

/// Points that touch nearer to each other than this share of the mesh's diagonal make one dent.
const NEAR: f32 = 0.15;
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
    /// The longest diagonal of its meshes, m.
    size: f32,
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
    /// Velocities before the step. `None`: not known yet.
    before: Option<(Vector3, Vector3)>,
    touches: Touches,
    /// Until when it is watched, s. Bodies with nodes of their own are watched always.
    until: f64,
    /// The bodies that see it, each with the part that it sees.
    near: HashSet<(Rid, i64)>,
    /// What it reported before it was watched.
    reported: i32,
}

#[derive(Default)]
struct Physics {
    tree: Option<InstanceId>,
    owners: HashMap<Rid, Owner>,
    movers: HashMap<Rid, Mover>,
    /// Touches of characters.
    characters: HashMap<Rid, Touches>,
    /// Time of the physics, s.
    now: f64,
    steps: u64,
    /// The nodes that know an open contact.
    contacts: HashMap<NonZeroU64, Vec<InstanceId>>,
    last_contact: u64,
}

thread_local! {
    static PHYSICS: RefCell<Physics> = RefCell::default();
}

/// One hit for one of the nodes of a body.
struct Delivery {
    nodes: Vec<InstanceId>,
    point: Vector3,
    blow: Blow,
    contact: NonZeroU64,
}

/// What one step leaves.
#[derive(Default)]
struct Report {
    hits: Vec<Delivery>,
    /// Contacts that end.
    ended: Vec<NonZeroU64>,
}

/// Lets collisions of a body dent a node.
pub fn watch(node: &Gd<CrumpleMeshInstance3D>, body: &Gd<PhysicsBody3D>) {
    let Some(mut tree) = node.get_tree_or_null() else { return };
    let new = PHYSICS.with_borrow_mut(|physics| {
        let character = body.clone().try_cast::<CharacterBody3D>().is_ok();
        let new = Owner { body: body.instance_id(), nodes: Vec::new(), size: 0.0, new: true, character, sight: None };
        let owner = physics.owners.entry(body.get_rid()).or_insert(new);
        owner.nodes.push(node.instance_id());
        owner.size = owner.size.max((node.get_global_transform() * node.get_aabb()).size.length());
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
    let report = PHYSICS.with_borrow_mut(Physics::step);
    let Some(report) = report else { return };
    for hit in report.hits {
        if let Some(node) = struck(&hit) {
            let known = |physics: &mut Physics| {
                let nodes = physics.contacts.entry(hit.contact).or_default();
                if !nodes.contains(&node.instance_id()) {
                    nodes.push(node.instance_id());
                }
            };
            PHYSICS.with_borrow_mut(known);
            CrumpleMeshInstance3D::strike(&node, array(hit.point), hit.blow, Some(hit.contact));
        }
    }
    for contact in report.ended {
        let nodes = PHYSICS.with_borrow_mut(|physics| physics.contacts.remove(&contact)).unwrap_or_default();
        let nodes = nodes.iter().filter_map(|id| Gd::<CrumpleMeshInstance3D>::try_from_instance_id(*id).ok());
        nodes.for_each(|node| CrumpleMeshInstance3D::end_contact(&node, contact));
    }
    // Runs after every `_physics_process` of this step.
    Callable::from_fn("crumple_note", |_| PHYSICS.with_borrow_mut(Physics::note)).call_deferred(&[]);
}

/// The node that was hit: of a body with several meshes, the nearest.
fn struck(hit: &Delivery) -> Option<Gd<CrumpleMeshInstance3D>> {
    let mut nodes: Vec<_> = hit.nodes.iter().filter_map(|id| Gd::try_from_instance_id(*id).ok()).collect();
    if nodes.len() < 2 {
        return nodes.pop();
    }
    let distance =
        |node: &Gd<CrumpleMeshInstance3D>| CrumpleMeshInstance3D::distance(node, hit.point).unwrap_or(f32::INFINITY);
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
        let mut report = Report::default();
        self.steps += 1;
        let turn = self.steps % PAUSE;
        let due = self.owners.iter_mut().filter_map(|(rid, owner)| {
            let due = std::mem::take(&mut owner.new) || owner.character || rid.to_u64() % PAUSE == turn;
            due.then_some((*rid, owner.body, owner.character))
        });
        for (rid, body, character) in due.collect::<Vec<_>>() {
            if character {
                if let Ok(character) = Gd::<CharacterBody3D>::try_from_instance_id(body) {
                    self.character(rid, &character, step as f32, &mut report);
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
            Mover { body, before: None, touches: Touches::default(), until, near: HashSet::new(), reported }
        });
    }

    /// Stops watching everything.
    fn release(&mut self) {
        for (rid, mover) in self.movers.drain() {
            unfollow(rid, &mover);
        }
        self.characters.clear();
        self.contacts.clear();
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

    /// The hits of a rigid body's last step.
    fn mover(&mut self, rid: Rid, server: &mut Gd<PhysicsServer3D>, report: &mut Report) {
        let Some(mover) = self.movers.get_mut(&rid) else { return };
        let owned = self.owners.contains_key(&rid);
        let Some(state) =
            state_of(rid, mover.body, server).filter(|_| owned || !mover.near.is_empty() || mover.until > self.now)
        else {
            if let Some(mut mover) = self.movers.remove(&rid) {
                mover.touches.pass(f64::INFINITY, 0.0, |id| report.ended.push(id));
                unfollow(rid, &mover);
            }
            return;
        };
        if state.is_sleeping() || mover.touches.is_empty() && state.get_contact_count() == 0 {
            return;
        }
        let nodes = self.nodes_of(rid);
        if let Some(before) = mover_before(&self.movers, rid) {
            self.contacts(rid, &state, before, &nodes, report);
        }
        let now = self.now;
        let time = nodes.iter().find_map(|id| settings(*id)).map_or(0.1, |s| s.0);
        let Some(mover) = self.movers.get_mut(&rid) else { return };
        mover.touches.pass(now, f64::from(time), |id| report.ended.push(id));
    }

    fn contacts(
        &mut self,
        rid: Rid,
        state: &Gd<PhysicsDirectBodyState3D>,
        (velocity, spin): (Vector3, Vector3),
        nodes: &[InstanceId],
        report: &mut Report,
    ) {
        let count = state.get_contact_count();
        let inverse = state.get_inverse_mass();
        if count == 0 || inverse <= 0.0 {
            return;
        }
        let (mass, dt) = (1.0 / inverse, state.get_step());
        let gravity = state.get_total_gravity();
        // What the velocities would be without contacts.
        let damp = |rate: f32| (1.0 - rate * dt).max(0.0);
        let free =
            (velocity + (gravity + state.get_constant_force() * inverse) * dt) * damp(state.get_total_linear_damp());
        let linear = (state.get_linear_velocity() - free) * mass;
        // The share of it that changed the velocity. The rest only held the body up against gravity and other forces.
        let changed = (state.get_linear_velocity() - velocity) * mass;
        let length = linear.length_squared();
        let share = if length > 0.0 { (changed.dot(linear) / length).clamp(0.0, 1.0) } else { 0.0 };
        let turned = state.get_angular_velocity() - spin * damp(state.get_total_angular_damp());
        let tensor = state.get_inverse_inertia_tensor();
        let turns = tensor.determinant().abs() > 1e-20;
        let angular = turns.then(|| tensor.inverse() * turned);
        let inertia = state.get_inverse_inertia();
        let gyration = if turns {
            let mean = (1.0 / inertia.x + 1.0 / inertia.y + 1.0 / inertia.z) / 3.0;
            (mean * inverse).max(0.0).sqrt()
        } else {
            0.0
        };

        let transform = state.get_transform();
        let centre = state.get_transform().origin + state.get_center_of_mass();
        let points: Vec<Point> = (0..count)
            .map(|i| Point {
                normal: state.get_contact_local_normal(i),
                arm: state.get_contact_local_position(i) - centre,
            })
            .collect();
        let into = transform.affine_inverse();
        let now = self.now;
        let spots: Vec<(Rid, Vector3, f32)> = (0..count)
            .map(|i| {
                let other = state.get_contact_collider(i);
                (other, into * state.get_contact_local_position(i), self.near(rid, other))
            })
            .collect();
        let Some(mover) = self.movers.get_mut(&rid) else { return };
        // Most bodies that touch something rest.
        let resting =
            spots.iter().filter(|(other, local, near)| mover.touches.rests(*other, *local, *near, now)).count();
        if resting == spots.len() {
            return;
        }
        let impulses = share::impulses(&points, linear, angular, gyration);
        for (i, ((point, impulse), (other, local, near))) in points.iter().zip(impulses).zip(spots).enumerate() {
            let i = i as i32;
            let place = state.get_contact_local_position(i);
            let other_mass = mass_of(other, state.get_contact_collider_object(i));
            // The other's velocity before the step: what it is now, less what this contact did.
            let gained = other_mass.map_or(Vector3::ZERO, |m| impulse / -m);
            let others = state.get_contact_collider_velocity_at_position(i) - gained;
            let relative = velocity + spin.cross(point.arm) - others;
            let seen = Seen { other, local, near, closing: -relative.dot(point.normal) };
            let rest = gravity.length() * dt;
            let Some(mover) = self.movers.get_mut(&rid) else { return };
            let touch = mover.touches.see(seen, now, rest, &mut self.last_contact);
            let Some((contact, struck)) = touch else { continue };
            let impulse = if struck { impulse * share } else { impulse };
            if impulse.dot(point.normal) <= 1e-6 * mass {
                continue;
            }
            mover.touches.strike(contact);
            // A blow's strength is that of a striker that hits a body which is held: the reduced mass.
            let reduced = other_mass.map_or(mass, |m| mass * m / (mass + m));
            let blow = |impulse: Vector3, normal: Vector3, velocity: Vector3| Blow {
                impulse: Some(array(impulse)),
                duration: None,
                normal: Some(array(normal)),
                striker: Striker { mass: Some(reduced), velocity: Some(array(velocity)), radius: None },
            };
            let deliver = |nodes: Vec<InstanceId>, blow: Blow| Delivery { nodes, point: place, blow, contact };
            if !nodes.is_empty() {
                report.hits.push(deliver(nodes.to_vec(), blow(impulse, -point.normal, -relative)));
            }
            // A struck body that moves reports its own contacts, also a character.
            if other_mass.is_none() && self.owners.contains_key(&other) && !self.characters.contains_key(&other) {
                let struck = self.nodes_of(other);
                report.hits.push(deliver(struck, blow(-impulse, point.normal, relative)));
            }
        }
    }

    /// A character has no mass and no momentum. Its hits are the stops of its last `move_and_slide`.
    fn character(&mut self, rid: Rid, body: &Gd<CharacterBody3D>, step: f32, report: &mut Report) {
        let nodes = self.nodes_of(rid);
        let Some((_, mass)) = nodes.iter().find_map(|id| settings(*id)) else { return };
        let into = body.get_global_transform().affine_inverse();
        let near = self.near(rid, rid);
        let touches = self.characters.entry(rid).or_default();
        for i in 0..body.get_slide_collision_count() {
            let Some(slide) = body.clone().get_slide_collision(i) else { continue };
            let motion = slide.get_travel() + slide.get_remainder();
            let (normal, place) = (slide.get_normal(), slide.get_position());
            let relative = motion / step - slide.get_collider_velocity();
            let closing = -relative.dot(normal);
            let seen = Seen { other: slide.get_collider_rid(), local: into * place, near, closing };
            let contact = touches.see(seen, self.now, 9.8 * step, &mut self.last_contact);
            let (Some((contact, _)), true) = (contact, closing > 0.0) else { continue };
            let blow = Blow {
                impulse: Some(array(normal * (mass * closing))),
                duration: None,
                normal: Some(array(-normal)),
                striker: Striker { mass: Some(mass), velocity: Some(array(-relative)), radius: None },
            };
            report.hits.push(Delivery { nodes: nodes.clone(), point: place, blow, contact });
        }
        // The next step repeats the same push.
        touches.pass(self.now, -1.0, |id| report.ended.push(id));
    }

    /// How near points of a body and another are that make one dent, m.
    fn near(&self, body: Rid, other: Rid) -> f32 {
        NEAR * self.owners.get(&body).or_else(|| self.owners.get(&other)).map_or(1.0, |owner| owner.size)
    }

    fn nodes_of(&self, rid: Rid) -> Vec<InstanceId> {
        self.owners.get(&rid).map_or_else(Vec::new, |owner| owner.nodes.clone())
    }

    /// Before a step: velocities.
    fn note(&mut self) {
        let mut server = PhysicsServer3D::singleton();
        for (rid, mover) in &mut self.movers {
            let state = state_of(*rid, mover.body, &mut server);
            mover.before = state.map(|state| (state.get_linear_velocity(), state.get_angular_velocity()));
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

fn mover_before(movers: &HashMap<Rid, Mover>, rid: Rid) -> Option<(Vector3, Vector3)> {
    movers.get(&rid)?.before
}

fn unfollow(rid: Rid, mover: &Mover) {
    let mut server = PhysicsServer3D::singleton();
    if mover.reported < POINTS && Gd::<PhysicsBody3D>::try_from_instance_id(mover.body).is_ok() {
        server.body_set_max_contacts_reported(rid, mover.reported);
    }
}

fn settings(node: InstanceId) -> Option<(f32, f32)> {
    let node = Gd::<CrumpleMeshInstance3D>::try_from_instance_id(node).ok()?;
    let settings = node.bind().contact_settings();
    Some(settings)
}
