use crate::surfaces::{self, Surface};
use crate::tasks;
use crumple::glam::Vec3;
use crumple::{Aabb, ExampleSet, SetOptions, VertexMass};
use godot::classes::{ArrayMesh, FileAccess, IResource, Resource, file_access};
use godot::global;
use godot::prelude::*;
use std::sync::Arc;

/// A set that is ready for use.
pub struct Built {
    pub set: Arc<ExampleSet>,
    pub surfaces: Vec<Surface>,
    /// The undamaged mesh, without blend shapes. Nodes share it until they are dented.
    pub pristine: Gd<ArrayMesh>,
}

/// The examples of one mesh: how it looks after collisions. Nodes share it.
///
/// An example set comes from a [ArrayMesh] whose blend shapes are the deformed mesh, one for each example. Godot's
/// glTF importer makes such a mesh from morph targets, and keeps the mesh's extras, which say what blow made each
/// example. A `.crumple` file (baked by the `crumple` command, or by [method save_file]) loads faster and is smaller.
///
/// The set is built when it is first needed. An error is printed once, and [method get_problem] returns it.
///
/// Change the properties before the set is used: nodes keep the set that they began with.
#[derive(GodotClass)]
#[class(tool, base = Resource)]
pub struct CrumpleExampleSet {
    /// The mesh with one blend shape for each example. With [member data], it gives only what a baked set lacks: texture
    /// coordinates, materials and levels of detail. It must then be the mesh that was baked.
    #[export]
    #[var(set)]
    mesh: Option<Gd<ArrayMesh>>,
    /// The bytes of a `.crumple` file. If it is empty, the set is built from [member mesh].
    #[var(set, usage_flags = [STORAGE])]
    data: PackedByteArray,
    /// The furthest that any vertex moves, m. 0 takes three times the longest displacement of all examples.
    #[export(range = (0.0, 1.0, 0.001, or_greater, suffix = "m"))]
    #[var(set)]
    depth_limit: f32,
    /// Edges of [member mesh] that are longer than this are divided, m, so that a coarse mesh dents smoothly. 0 divides none.
    /// Baked [member data] must have been baked with the same value.
    #[export(range = (0.0, 1.0, 0.001, or_greater, suffix = "m"))]
    #[var(set)]
    edge_length: f32,
    /// The position error that compression may cause, m. 0 stores exact floats.
    #[export(range = (0.0, 0.01, 0.0001, or_greater, suffix = "m"))]
    #[var(set)]
    tolerance: f32,
    /// If `true`, examples also count mirrored unless they contradict it, on symmetric bodies.
    #[export]
    #[var(set)]
    mirror: bool,
    built: Option<Result<Arc<Built>, String>>,
    base: Base<Resource>,
}

#[godot_api]
impl IResource for CrumpleExampleSet {
    fn init(base: Base<Resource>) -> Self {
        Self {
            mesh: None,
            data: PackedByteArray::new(),
            depth_limit: 0.0,
            edge_length: 0.0,
            tolerance: 0.0,
            mirror: true,
            built: None,
            base,
        }
    }
}

#[godot_api]
impl CrumpleExampleSet {
    /// Makes a set from a mesh with blend shapes.
    #[func]
    fn from_mesh(mesh: Option<Gd<ArrayMesh>>) -> Gd<Self> {
        let mut set = Self::new_gd();
        set.bind_mut().mesh = mesh;
        set
    }

    /// Makes a set from a `.crumple` file, also below `res://` in an exported game. Returns `null` after an error, which
    /// is printed.
    #[func]
    fn load_file(path: GString) -> Option<Gd<Self>> {
        let data = FileAccess::get_file_as_bytes(&path);
        if data.is_empty() {
            let error = FileAccess::get_open_error();
            godot_error!("CrumpleExampleSet: '{path}' cannot be read or is empty ({error:?})");
            return None;
        }
        let mut set = Self::new_gd();
        set.bind_mut().data = data;
        Self::built(&set).is_ok().then_some(set)
    }

    /// Returns a copy of a mesh in which no edge is longer than `edge_length`, m, with its blend shapes, materials and extras.
    /// Returns `null` after an error, which is printed. It is for meshes that get their examples from a script; for others
    /// set [member edge_length].
    #[func]
    fn divide_mesh(mesh: Option<Gd<ArrayMesh>>, edge_length: f32) -> Option<Gd<ArrayMesh>> {
        let divided = match mesh {
            Some(mesh) if edge_length > 0.0 && edge_length.is_finite() => surfaces::divided(&mesh, edge_length),
            Some(_) => Err(format!("edge_length is {edge_length}; it must be above 0 and finite, m")),
            None => Err("there is no mesh".into()),
        };
        divided.inspect_err(|error| godot_error!("CrumpleExampleSet.divide_mesh: {error}")).ok()
    }

    /// Builds the set now. Returns [constant OK], or [constant ERR_INVALID_DATA] with an error that is printed.
    #[func(gd_self)]
    fn build(this: Gd<Self>) -> global::Error {
        match Self::built(&this) {
            Ok(_) => global::Error::OK,
            Err(_) => global::Error::ERR_INVALID_DATA,
        }
    }

    /// Writes the built set to a `.crumple` file, which [method load_file] and Crumple's other tools read.
    #[func(gd_self)]
    fn save_file(this: Gd<Self>, path: GString) -> global::Error {
        let bytes = Self::bake(this);
        if bytes.is_empty() {
            return global::Error::ERR_INVALID_DATA;
        }
        let Some(mut file) = FileAccess::open(&path, file_access::ModeFlags::WRITE) else {
            return FileAccess::get_open_error();
        };
        file.store_buffer(&bytes);
        file.get_error()
    }

    /// Returns the built set as the bytes of a `.crumple` file; an empty array after an error, which is printed.
    #[func(gd_self)]
    fn bake(this: Gd<Self>) -> PackedByteArray {
        let Ok(built) = Self::built(&this) else { return PackedByteArray::new() };
        built.set.save().map(PackedByteArray::from).unwrap_or_else(|error| {
            godot_error!("{}: {error}", this.bind().name());
            PackedByteArray::new()
        })
    }

    /// Returns what is wrong with the set, or an empty text. Builds the set.
    #[func(gd_self)]
    fn get_problem(this: Gd<Self>) -> GString {
        Self::built(&this).err().map_or_else(GString::new, |error| GString::from(&error))
    }

    /// Returns the mesh that undamaged nodes show: [member mesh] without blend shapes, or the mesh of the baked set.
    #[func(gd_self)]
    fn get_pristine_mesh(this: Gd<Self>) -> Option<Gd<ArrayMesh>> {
        Self::built(&this).ok().map(|built| built.pristine.clone())
    }

    /// Returns the number of examples; 0 if the set cannot be built.
    #[func(gd_self)]
    fn get_example_count(this: Gd<Self>) -> i64 {
        Self::built(&this).map_or(0, |built| built.set.examples().len() as i64)
    }

    /// Returns the number of vertices that dent; 0 if the set cannot be built.
    #[func(gd_self)]
    fn get_vertex_count(this: Gd<Self>) -> i64 {
        Self::built(&this).map_or(0, |built| built.set.vertex_count() as i64)
    }

    /// Returns a description of each example: its `name`, its `contact` point, its `depth` at the contact (m), its `radius`
    /// (m), and its `error` when it is predicted from the others (0 is perfect, 1 is as wrong as no dent).
    #[func(gd_self)]
    fn get_examples(this: Gd<Self>) -> Array<VarDictionary> {
        let Ok(built) = Self::built(&this) else { return Array::new() };
        let describe = |(example, error): (&crumple::Example, f32)| {
            let p = example.contact_point();
            vdict! {
                "name" => example.name(),
                "contact" => Vector3::new(p.x, p.y, p.z),
                "depth" => example.depth(),
                "radius" => example.support_radius(),
                "error" => error,
            }
        };
        built.set.examples().iter().zip(built.set.example_errors()).map(describe).collect()
    }

    /// Returns the median error of the examples when each is predicted from the others: 0 is perfect, 1 is as wrong as no
    /// dent. -1 if the set cannot be built.
    #[func(gd_self)]
    fn get_own_error(this: Gd<Self>) -> f32 {
        let Ok(built) = Self::built(&this) else { return -1.0 };
        let mut errors = built.set.example_errors();
        errors.sort_by(f32::total_cmp);
        errors[errors.len() / 2]
    }

    /// Returns whether the examples know their blows. Then the set predicts how deep a blow dents. Otherwise the depth is
    /// `impulse * duration / vertex_mass` of the node.
    #[func(gd_self)]
    fn knows_blows(this: Gd<Self>) -> bool {
        Self::built(&this).is_ok_and(|built| built.set.predicts_blows())
    }

    /// Returns the furthest that any vertex moves, m; 0 if the set cannot be built.
    #[func(gd_self)]
    fn get_deepest(this: Gd<Self>) -> f32 {
        Self::built(&this).map_or(0.0, |built| built.set.depth_limit())
    }

    #[func]
    fn set_mesh(&mut self, mesh: Option<Gd<ArrayMesh>>) {
        self.mesh = mesh;
        self.changed();
    }

    #[func]
    fn set_data(&mut self, data: PackedByteArray) {
        self.data = data;
        self.changed();
    }

    #[func]
    fn set_depth_limit(&mut self, depth_limit: f32) {
        self.depth_limit = depth_limit;
        self.changed();
    }

    #[func]
    fn set_edge_length(&mut self, edge_length: f32) {
        self.edge_length = edge_length;
        self.changed();
    }

    #[func]
    fn set_tolerance(&mut self, tolerance: f32) {
        self.tolerance = tolerance;
        self.changed();
    }

    #[func]
    fn set_mirror(&mut self, mirror: bool) {
        self.mirror = mirror;
        self.changed();
    }
}

impl CrumpleExampleSet {
    /// A set made of a mesh.
    pub fn of_mesh(mesh: Gd<ArrayMesh>) -> Gd<Self> {
        Self::from_mesh(Some(mesh))
    }

    fn changed(&mut self) {
        self.built = None;
        self.base_mut().emit_changed();
    }

    /// What messages call the set.
    fn name(&self) -> String {
        let path = self.base().get_path();
        if path.is_empty() { "CrumpleExampleSet".into() } else { format!("CrumpleExampleSet '{path}'") }
    }

    /// The set, built on the first call. An error is printed then.
    pub fn built(this: &Gd<Self>) -> Result<Arc<Built>, String> {
        if let Some(built) = &this.bind().built {
            return built.clone();
        }
        let (mesh, edge, data, options) = {
            let set = this.bind();
            (set.mesh.clone(), set.edge_length, set.data.clone(), set.options())
        };
        let built = make(mesh, edge, &data, options).map(Arc::new);
        if let Err(error) = &built {
            godot_error!("{}: {error}", this.bind().name());
        }
        this.clone().bind_mut().built = Some(built.clone());
        built
    }

    fn options(&self) -> SetOptions {
        let above_zero = |x: f32| (x != 0.0).then_some(x);
        SetOptions {
            depth_limit: above_zero(self.depth_limit),
            tolerance: above_zero(self.tolerance),
            mirror: self.mirror,
            mass: VertexMass::None,
            ..SetOptions::default()
        }
    }
}

fn make(mesh: Option<Gd<ArrayMesh>>, edge: f32, data: &PackedByteArray, options: SetOptions) -> Result<Built, String> {
    if !(edge >= 0.0 && edge.is_finite()) {
        return Err(format!("edge_length is {edge}; it must be at least 0 and finite, m"));
    }
    let (set, surfaces) = if data.is_empty() {
        let mesh = mesh.ok_or("it has neither a mesh nor the bytes of a .crumple file")?;
        let source = surfaces::read(&mesh, edge)?;
        let set = tasks::with(|tasks| ExampleSet::build(source.mesh, source.examples, options, tasks));
        (set.map_err(|e| e.to_string())?, source.surfaces)
    } else {
        let set = tasks::with(|tasks| ExampleSet::load_copy(data.as_slice(), tasks)).map_err(|e| e.to_string())?;
        let surfaces = match mesh {
            None => surfaces::of_set(&set),
            Some(mesh) => fitting(&mesh, edge, &set)?,
        };
        (set, surfaces)
    };
    let pristine = surfaces::make(&surfaces);
    Ok(Built { set: Arc::new(set), surfaces, pristine })
}

/// The surfaces of a mesh, which must be the one that the set was baked from. If Godot compressed it, positions are rounded to a 65535th
/// of the size of their surface.
fn fitting(mesh: &Gd<ArrayMesh>, edge: f32, set: &ExampleSet) -> Result<Vec<Surface>, String> {
    let (mut surfaces, positions) = surfaces::shown(mesh, edge)?;
    surfaces.iter_mut().for_each(|surface| surface.fit(set));
    let baked = set.mesh().positions();
    if positions.len() != baked.len() {
        return Err(format!(
            "its data was baked from another mesh: it has {} vertices, and the mesh has {}",
            baked.len(),
            positions.len()
        ));
    }
    let bounds = Aabb::of(baked);
    let rounding = (bounds.max - bounds.min) / 65535.0;
    let differs = |p: &[f32; 3], b: Vec3| (Vec3::from_array(*p) - b).abs().cmpgt(rounding).any();
    match positions.iter().zip(baked).position(|(p, b)| differs(p, *b)) {
        None => Ok(surfaces),
        Some(v) => Err(format!(
            "its data was baked from another mesh: vertex {v} is at {:?}, and the mesh has it at {:?}",
            baked[v].to_array(),
            positions[v]
        )),
    }
}
