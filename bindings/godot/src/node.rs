use crate::body::Body;
use crate::physics;
use crate::set::CrumpleExampleSet;
use crate::tasks;
use crate::world;
use crumple::glam::{Mat4, Vec4};
use crumple::{Blow, Cause, ExampleSet, Hit, HitStatus, Inbox, InstanceOptions, Outcome, Space, Striker};
use godot::classes::{ArrayMesh, Engine, IMeshInstance3D, MeshInstance3D, PhysicsBody3D};
use godot::global;
use godot::prelude::*;
use godot::register::info::{PropertyInfo, PropertyUsageFlags};
use std::cell::{Ref, RefCell, RefMut};
use std::sync::Arc;

/// A mesh that collisions dent.
///
/// It dents by the examples of its [member example_set]. Without one, the node makes a set of its own [member
/// MeshInstance3D.mesh], whose blend shapes are the examples; nodes with the same mesh share that set. So an imported
/// mesh with blend shapes dents once its node has this type.
///
/// Put it below a [PhysicsBody3D]. Collisions of the body dent the mesh: [RigidBody3D], [VehicleBody3D] and
/// [CharacterBody3D] by what they run into, and bodies that do not move by the rigid bodies that run into them.
/// [method add_impulse] and [method add_displacement] dent it from scripts.
///
/// The damage is [member damage], a few bytes that can be saved, sent and synchronized.
///
/// The mesh shown is the node's own. Its levels of detail, shadows and bounds follow the dents. Collision shapes do not.
#[derive(GodotClass)]
#[class(tool, base = MeshInstance3D)]
pub struct CrumpleMeshInstance3D {
    /// The examples. If it is empty when the node is ready, the node makes a set of its mesh.
    #[export]
    #[var(set)]
    example_set: Option<Gd<CrumpleExampleSet>>,

    /// How long an impulse acts, s. It is a constant of the material, not the time step. It only matters if the set does
    /// not know its blows: then an impulse displaces the contact by `impulse * duration / vertex_mass`.
    #[export_group(name = "Material")]
    #[export(range = (0.0001, 0.1, 0.0001, or_greater, suffix = "s"))]
    #[var(set)]
    duration: f32,
    /// The mass of a vertex, kg. See [member duration].
    #[export(range = (0.001, 100.0, 0.001, or_greater, suffix = "kg"))]
    #[var(set)]
    vertex_mass: f32,
    /// Impulses below this leave no dent, N s.
    #[export(range = (0.0, 1000.0, 0.1, or_greater, suffix = "N s"))]
    #[var(set)]
    yield_impulse: f32,
    /// The furthest that any vertex moves, m. 0 takes the set's.
    #[export(range = (0.0, 1.0, 0.001, or_greater, suffix = "m"))]
    #[var(set)]
    depth_limit: f32,

    /// If `true`, collisions of [member contact_body] dent the mesh. It is read when the node enters the tree.
    #[export_group(name = "Contacts")]
    #[export]
    #[var(pub)]
    contacts: bool,
    /// The body whose collisions dent the mesh. If it is empty, the nearest [PhysicsBody3D] above the node.
    #[export]
    #[var(pub)]
    contact_body: Option<Gd<PhysicsBody3D>>,
    /// The mass of a [CharacterBody3D] above the node, which has none of its own, kg.
    #[export(range = (0.1, 1000.0, 0.1, or_greater, suffix = "kg"))]
    #[var(pub)]
    character_mass: f32,

    /// The damage as bytes, the same as [method save_damage] and [method load_damage]. It is stored with the scene and
    /// copied by [method Node.duplicate]. A [MultiplayerSynchronizer] may replicate it.
    #[var(get, set, usage_flags = [STORAGE])]
    damage: PhantomVar<PackedByteArray>,

    /// Reading damage folds the hits that have arrived.
    body: RefCell<Option<Body>>,
    /// The mesh that the node had before it was ready.
    original: Option<Gd<godot::classes::Mesh>>,
    /// Damage that was set before there was a body.
    waiting: Option<PackedByteArray>,
    problem: String,
    warned: bool,
    base: Base<MeshInstance3D>,
}

#[godot_api]
impl IMeshInstance3D for CrumpleMeshInstance3D {
    fn init(base: Base<MeshInstance3D>) -> Self {
        Self {
            example_set: None,
            duration: 0.01,
            vertex_mass: 0.5,
            yield_impulse: 0.0,
            depth_limit: 0.0,
            contacts: true,
            contact_body: None,
            character_mass: 80.0,
            damage: PhantomVar::default(),
            body: RefCell::default(),
            original: None,
            waiting: None,
            problem: String::new(),
            warned: false,
            base,
        }
    }

    fn on_validate_property(&self, property: &mut PropertyInfo) {
        // The mesh comes from the set. A scene that is packed at run time must not hold a copy of it.
        if property.property_name == "mesh" && self.example_set.is_some() {
            property.usage = PropertyUsageFlags::from_ord(property.usage.ord() & !PropertyUsageFlags::STORAGE.ord());
        }
    }

    #[func(gd_self)]
    fn enter_tree(this: Gd<Self>) {
        Self::open(&this);
        if !Engine::singleton().is_editor_hint() && this.bind().contacts && this.bind().is_open() {
            let body = this.bind().contact_body.clone().or_else(|| body_above(&this));
            if let Some(body) = body {
                physics::watch(&this, &body);
            }
        }
    }

    fn exit_tree(&mut self) {
        physics::forget(self.base().instance_id());
    }

    fn get_configuration_warnings(&self) -> PackedStringArray {
        let mut warnings = PackedStringArray::new();
        if !self.problem.is_empty() {
            warnings.push(&format!("This mesh does not dent: {}.", self.problem));
        }
        warnings
    }
}

#[godot_api]
impl CrumpleMeshInstance3D {
    /// A hit arrived that dents the mesh or adds to a dent. `point` is the contact and `displacement` what the hit alone
    /// does there, m; both are in the node's space.
    #[signal]
    pub fn dented(point: Vector3, displacement: Vector3);

    /// Hits the mesh with an impulse (N s) at a point (m), both in global space. The impulse is what the mesh receives: it
    /// points into the body.
    ///
    /// The other arguments say what is known of the blow; zeros are unknown, which costs accuracy. `normal` points out of
    /// the mesh. `striker_mass` (kg), `striker_velocity` (m/s, relative to the mesh before the touch) and `striker_radius`
    /// (m, small for a corner) describe what struck.
    ///
    /// Returns a dictionary with the `status` ([constant MARKED] and so on), the `contact_vertex`, and the `target` and the
    /// `achieved` displacement of the contact in the node's space (m). Returns an empty dictionary after an error, which is
    /// printed.
    #[func(gd_self)]
    fn add_impulse(
        this: Gd<Self>,
        point: Vector3,
        impulse: Vector3,
        #[opt(default = Vector3::ZERO)] normal: Vector3,
        #[opt(default = 0.0)] striker_mass: f32,
        #[opt(default = Vector3::ZERO)] striker_velocity: Vector3,
        #[opt(default = 0.0)] striker_radius: f32,
    ) -> VarDictionary {
        let vector = |v: Vector3| (v != Vector3::ZERO).then(|| array(v));
        let size = |x: f32| (x != 0.0).then_some(x);
        let blow = Blow {
            impulse: Some(array(impulse)),
            duration: None,
            normal: vector(normal),
            striker: Striker {
                mass: size(striker_mass),
                velocity: vector(striker_velocity),
                radius: size(striker_radius),
                ..Striker::default()
            },
        };
        let cause = Cause::Impulse { blow, mass: None };
        Self::outcome(Self::submit(&this, &Hit { point: array(point), cause, space: Space::World, contact: None }))
    }

    /// Displaces the contact at a point (m) by a displacement (m), both in global space, for games with their own rule of
    /// how deep a hit dents. Returns what [method add_impulse] returns.
    #[func(gd_self)]
    fn add_displacement(this: Gd<Self>, point: Vector3, displacement: Vector3) -> VarDictionary {
        let cause = Cause::Displacement(array(displacement));
        let hit = Hit { point: array(point), cause, space: Space::World, contact: None };
        Self::outcome(Self::submit(&this, &hit))
    }

    /// Repairs the mesh: scales the depth of every dent by `keep`, 0 to 1. Without an argument it is as new.
    #[func(gd_self)]
    fn repair(this: Gd<Self>, #[opt(default = 0.0)] keep: f32) {
        Self::change(&this, "repair", |body| {
            if keep == 0.0 {
                body.instance.reset();
                return Ok(());
            }
            body.instance.repair(keep)
        });
    }

    /// Returns the damage as bytes. The same damage gives the same bytes on every machine. The set's fingerprint is part of
    /// them.
    #[func]
    fn save_damage(&self) -> PackedByteArray {
        if let Some(waiting) = &self.waiting {
            return waiting.clone();
        }
        let mut body = self.body.borrow_mut();
        let Some(body) = body.as_mut() else { return PackedByteArray::new() };
        // Scenes need not store that there is no damage.
        if body.instance.marks().is_ok_and(<[_]>::is_empty) {
            return PackedByteArray::new();
        }
        PackedByteArray::from(body.instance.save())
    }

    /// Replaces the damage by saved bytes; an empty array is no damage. Returns [constant OK], or [constant ERR_INVALID_DATA]
    /// with an error that is printed: for bytes that are cut short or belong to another set. Then nothing has changed.
    #[func(gd_self)]
    fn load_damage(mut this: Gd<Self>, bytes: PackedByteArray) -> global::Error {
        if !this.bind().is_open() {
            this.bind_mut().waiting = Some(bytes);
            return global::Error::OK;
        }
        let loaded = Self::change(&this, "load_damage", |body| {
            if bytes.is_empty() {
                body.instance.reset();
                return Ok(());
            }
            if body.instance.save() == bytes.as_slice() { Ok(()) } else { body.instance.load(bytes.as_slice()) }
        });
        if loaded { global::Error::OK } else { global::Error::ERR_INVALID_DATA }
    }

    /// Returns the number of dents stored. Hits at one place share one.
    #[func]
    fn get_mark_count(&self) -> i64 {
        let mut body = self.body.borrow_mut();
        body.as_mut().and_then(|body| body.instance.marks().ok().map(|marks| marks.len() as i64)).unwrap_or(0)
    }

    /// Returns where a vertex of the set is now, in the node's space. Vertices are counted over all surfaces of triangles.
    #[func]
    fn get_vertex(&self, vertex: i64) -> Vector3 {
        let mut body = self.body.borrow_mut();
        let Some(body) = body.as_mut() else { return Vector3::ZERO };
        body.instance.fold();
        let index = u32::try_from(vertex).unwrap_or(u32::MAX);
        match body.instance.displaced(index) {
            Ok(p) => Vector3::new(p.x, p.y, p.z),
            Err(error) => {
                godot_error!("CrumpleMeshInstance3D.get_vertex: {error}");
                Vector3::ZERO
            }
        }
    }

    /// Returns where something that is fixed to the mesh is now, such as a lamp or a wheel. `rest` is its place on the
    /// undamaged mesh; both are in the node's space. It moves and turns with the surface nearest to its origin.
    #[func]
    fn get_attached(&self, rest: Transform3D) -> Transform3D {
        let mut body = self.body.borrow_mut();
        let Some(body) = body.as_mut() else { return rest };
        body.instance.fold();
        let attached = body.built.set.attach(array(rest.origin)).and_then(|a| body.instance.attached_pose(&a));
        match attached {
            Ok(pose) => {
                let [x, y, z, w] = pose.rotation;
                let turn = Basis::from_quaternion(Quaternion::new(x, y, z, w));
                Transform3D::new(turn * rest.basis, Vector3::from_array(pose.position))
            }
            Err(error) => {
                godot_error!("CrumpleMeshInstance3D.get_attached: {error}");
                rest
            }
        }
    }

    /// Shows all hits now. Otherwise they are shown at the end of the frame's process or physics step.
    #[func(gd_self)]
    fn update_now(this: Gd<Self>) {
        Self::show(vec![this]);
    }

    #[func(gd_self, rename = _show_stale)]
    fn show_stale(_this: Gd<Self>) {
        world::show();
    }

    /// Returns why the mesh does not dent, or an empty text.
    #[func]
    fn get_problem(&self) -> GString {
        GString::from(&self.problem)
    }

    /// The hit dented the mesh.
    #[constant]
    const MARKED: i64 = 0;
    /// The hit was too weak.
    #[constant]
    const BELOW_YIELD: i64 = 1;
    /// No example moves the contact towards the hit.
    #[constant]
    const NOTHING_REACHES: i64 = 2;
    /// Alone the hit is too weak, but it adds to its collision.
    #[constant]
    const ACCUMULATED: i64 = 3;

    #[func]
    fn set_example_set(&mut self, set: Option<Gd<CrumpleExampleSet>>) {
        if self.example_set == set {
            return;
        }
        self.example_set = set;
        self.body.take();
        self.warned = false;
        let original = self.original.take();
        let mut this = self.to_gd();
        // From here on others may call the node.
        let _apart = self.base_mut();
        if let Some(original) = original {
            this.set_mesh(&original);
        }
        this.notify_property_list_changed();
        if this.is_inside_tree() {
            Self::open(&this);
        }
    }

    #[func]
    fn set_duration(&mut self, duration: f32) {
        let before = std::mem::replace(&mut self.duration, duration);
        if !self.renew() {
            self.duration = before;
        }
    }

    #[func]
    fn set_vertex_mass(&mut self, vertex_mass: f32) {
        let before = std::mem::replace(&mut self.vertex_mass, vertex_mass);
        if !self.renew() {
            self.vertex_mass = before;
        }
    }

    #[func]
    fn set_yield_impulse(&mut self, yield_impulse: f32) {
        let before = std::mem::replace(&mut self.yield_impulse, yield_impulse);
        if !self.renew() {
            self.yield_impulse = before;
        }
    }

    #[func]
    fn set_depth_limit(&mut self, depth_limit: f32) {
        let before = std::mem::replace(&mut self.depth_limit, depth_limit);
        if !self.renew() {
            self.depth_limit = before;
        }
    }

    #[func]
    fn get_damage(&self) -> PackedByteArray {
        self.save_damage()
    }

    #[func]
    fn set_damage(&mut self, damage: PackedByteArray) {
        let this = self.to_gd();
        let _apart = self.base_mut();
        Self::load_damage(this, damage);
    }
}

impl CrumpleMeshInstance3D {
    /// Makes the body, if there is none, and shows it.
    fn open(this: &Gd<Self>) {
        let mut this = this.clone();
        if this.bind().is_open() {
            return;
        }
        let result = Self::make(&mut this);
        let problem = match result {
            Ok(body) => {
                let mesh = body.mesh();
                if this.bind().original.is_none() {
                    let original = this.get_mesh();
                    this.bind_mut().original = original;
                }
                this.bind().body.replace(Some(body));
                this.set_mesh(&mesh);
                String::new()
            }
            Err(problem) => problem,
        };
        this.bind_mut().problem = problem;
        this.update_configuration_warnings();
        let waiting = this.bind_mut().waiting.take();
        if let Some(bytes) = waiting {
            Self::load_damage(this, bytes);
        }
    }

    fn make(this: &mut Gd<Self>) -> Result<Body, String> {
        let set = this.bind().example_set.clone();
        let set = match set {
            Some(set) => set,
            None => {
                let mesh = this.get_mesh().ok_or("it has neither an example set nor a mesh")?;
                let mesh = mesh.try_cast::<ArrayMesh>().map_err(|mesh| {
                    format!("its mesh is of type {}; it must be an ArrayMesh with blend shapes", mesh.get_class())
                })?;
                if Engine::singleton().is_editor_hint() {
                    // In the editor the mesh stays the one that was chosen.
                    let set = world::set_of(&mesh);
                    let built = CrumpleExampleSet::built(&set);
                    return Err(built.err().unwrap_or_default());
                }
                let set = world::set_of(&mesh);
                this.bind_mut().example_set = Some(set.clone());
                this.notify_property_list_changed();
                set
            }
        };
        let built = CrumpleExampleSet::built(&set)?;
        let options = this.bind().options();
        Body::new(built, options).map_err(|error| error.to_string())
    }

    /// The set that it dents by. `None` if it does not dent.
    pub fn set(&self) -> Option<Arc<ExampleSet>> {
        self.body.borrow().as_ref().map(|body| body.built.set.clone())
    }

    pub fn body(&self) -> RefMut<'_, Option<Body>> {
        self.body.borrow_mut()
    }

    pub fn shared_body(&self) -> Ref<'_, Option<Body>> {
        self.body.borrow()
    }

    /// Whether hits can dent it.
    pub fn is_open(&self) -> bool {
        self.body.borrow().is_some()
    }

    /// Gives the body the present options. Returns whether they are right; an error is printed.
    fn renew(&mut self) -> bool {
        let options = self.options();
        let result = self.body.borrow_mut().as_mut().map_or(Ok(()), |body| body.renew(options));
        match &result {
            Ok(()) if self.is_open() => world::mark(&self.to_gd()),
            Ok(()) => (),
            Err(error) => godot_error!("CrumpleMeshInstance3D: {error}"),
        }
        result.is_ok()
    }

    fn options(&self) -> InstanceOptions {
        InstanceOptions {
            yield_impulse: self.yield_impulse,
            depth_limit: (self.depth_limit != 0.0).then_some(self.depth_limit),
            compliance: Some(self.duration / self.vertex_mass),
            ..InstanceOptions::default()
        }
    }

    /// The inbox that contacts of this step go to. `None` if it does not dent.
    pub fn touched(this: &Gd<Self>) -> Option<Arc<Inbox>> {
        let transform = matrix(this.get_global_transform());
        let placed = {
            let node = this.bind();
            let body = node.body.borrow();
            let body = body.as_ref()?;
            body.instance.set_transform(transform).map(|()| body.instance.inbox().clone())
        };
        placed.inspect_err(|error| Self::warn(this, &error.to_string())).ok()
    }

    fn submit(this: &Gd<Self>, hit: &Hit) -> Option<Outcome> {
        let transform = matrix(this.get_global_transform());
        let outcome = {
            let node = this.bind();
            let body = node.body.borrow();
            body.as_ref().map(|body| body.instance.set_transform(transform).and_then(|()| body.instance.submit(hit)))
        };
        let outcome = match outcome {
            Some(Ok(outcome)) => outcome,
            None => {
                Self::warn(this, "it has no examples, or was never in the tree");
                return None;
            }
            Some(Err(error)) => {
                Self::warn(this, &error.to_string());
                return None;
            }
        };
        Self::took(this, &outcome);
        Some(outcome)
    }

    /// The body has got a hit.
    pub fn took(this: &Gd<Self>, outcome: &Outcome) {
        if matches!(outcome.status, HitStatus::Marked | HitStatus::Accumulated) {
            world::mark(this);
            if outcome.status == HitStatus::Marked {
                let point = this.bind().get_vertex(outcome.contact_vertex.into());
                let displacement = Vector3::from_array(outcome.achieved);
                this.signals().dented().emit(point, displacement);
            }
        }
    }

    /// A hit that cannot be taken may come again in the next step, so it is said once.
    pub fn warn(this: &Gd<Self>, message: &str) {
        let mut this = this.clone();
        if !std::mem::replace(&mut this.bind_mut().warned, true) {
            godot_error!("CrumpleMeshInstance3D '{}': a hit was not taken: {message}", this.get_name());
        }
    }

    fn outcome(outcome: Option<Outcome>) -> VarDictionary {
        let Some(outcome) = outcome else { return VarDictionary::new() };
        vdict! {
            "status" => outcome.status as i64,
            "contact_vertex" => i64::from(outcome.contact_vertex),
            "target" => Vector3::from_array(outcome.target),
            "achieved" => Vector3::from_array(outcome.achieved),
        }
    }

    /// Changes the damage, and returns whether that went well. An error is printed.
    fn change(this: &Gd<Self>, call: &str, work: impl FnOnce(&mut Body) -> Result<(), crumple::Error>) -> bool {
        let result = {
            let node = this.bind();
            let mut body = node.body.borrow_mut();
            body.as_mut().map_or(Ok(()), work)
        };
        match &result {
            Ok(()) => world::mark(this),
            Err(error) => godot_error!("CrumpleMeshInstance3D.{call}: {error}"),
        }
        result.is_ok()
    }

    /// How far a point in global space is from the mesh, m. `None` if it does not dent.
    pub fn distance(this: &Gd<Self>, point: Vector3) -> Option<f32> {
        let transform = this.get_global_transform();
        let local = transform.affine_inverse() * point;
        let node = this.bind();
        let body = node.body.borrow();
        let set = &body.as_ref()?.built.set;
        let vertex = set.nearest_vertex(array(local)).ok()?.vertex;
        let nearest = set.mesh().positions()[vertex as usize];
        Some((transform * Vector3::new(nearest.x, nearest.y, nearest.z)).distance_to(point))
    }

    /// The mass as a character, kg.
    pub fn character_mass(&self) -> f32 {
        self.character_mass
    }

    /// Brings the meshes of nodes up to date, together.
    pub fn show(mut nodes: Vec<Gd<Self>>) {
        for node in &mut nodes {
            let new = node.bind().body.borrow_mut().as_mut().and_then(|body| body.prepare().then(|| body.mesh()));
            if let Some(mesh) = new {
                node.set_mesh(&mesh);
            }
        }
        let bound: Vec<_> = nodes.iter().map(Gd::bind).collect();
        let mut bodies: Vec<_> = bound.iter().map(|node| node.body.borrow_mut()).collect();
        let result = {
            let mut jobs: Vec<_> = bodies.iter_mut().filter_map(|body| body.as_mut()?.job()).collect();
            tasks::with(|tasks| crumple::deform(&mut jobs, tasks))
        };
        match result {
            Ok(_) => bodies.iter_mut().filter_map(|body| body.as_mut()).for_each(Body::upload),
            Err(error) => godot_error!("CrumpleMeshInstance3D: the dents cannot be shown: {error}"),
        }
    }
}

// The class documentation shows the constants as they are written.
const _: () = assert!(
    CrumpleMeshInstance3D::MARKED == HitStatus::Marked as i64
        && CrumpleMeshInstance3D::BELOW_YIELD == HitStatus::BelowYield as i64
        && CrumpleMeshInstance3D::NOTHING_REACHES == HitStatus::NothingReaches as i64
        && CrumpleMeshInstance3D::ACCUMULATED == HitStatus::Accumulated as i64
);

/// The nearest physics body above a node.
fn body_above(node: &Gd<CrumpleMeshInstance3D>) -> Option<Gd<PhysicsBody3D>> {
    let mut above = node.get_parent();
    while let Some(node) = above {
        match node.try_cast::<PhysicsBody3D>() {
            Ok(body) => return Some(body),
            Err(node) => above = node.get_parent(),
        }
    }
    None
}

pub fn array(v: Vector3) -> [f32; 3] {
    [v.x, v.y, v.z]
}

fn matrix(t: Transform3D) -> Mat4 {
    let column = |v: Vector3, w: f32| Vec4::new(v.x, v.y, v.z, w);
    let b = t.basis;
    Mat4::from_cols(column(b.col_a(), 0.0), column(b.col_b(), 0.0), column(b.col_c(), 0.0), column(t.origin, 1.0))
}
