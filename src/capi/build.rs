//! Example sets from the caller's arrays, further meshes of a set, and baking.

use super::memory::{CrumpleInput, read};
use super::prelude::*;
use super::set::insert_set;
use super::store::SetEntry;
use super::types::CrumpleStriker;
use crate::base::error::reserve;
use crate::basis::learn::BasisOptions;
use crate::example::blow::Blow;
use crate::example::data::{Contact, Deltas, ExampleData};
use crate::example::options::{SetOptions, VertexMass};
use crate::example::set::ExampleSet;
use crate::mesh::data::MeshData;
use std::sync::Arc;

/// A level of detail further than this from the base surface is doubted, as a share of the body's diagonal.
const FAR_OFF: f32 = 0.1;

/// The type of triangle indices. CRUMPLE_INDEX_TYPE_U32 is the default.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(dead_code)] // made by C
pub enum CrumpleIndexType {
    U32 = 0,
    U16 = 1,
}

/// How an example's contact (the place where it was hit) is given.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(dead_code)] // made by C
pub enum CrumpleContactKind {
    /// Not given: Crumple uses the example's deepest vertex. The default.
    None = 0,
    /// As a vertex of the base mesh.
    Vertex = 1,
    /// As a point in the mesh's space. The vertex nearest to it becomes the contact.
    Point = 2,
}

/// How an example set is built. The def that contains it sets its defaults.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleExampleSetOptions {
    /// No vertex moves further than this, m. Default 0: three times the depth of the deepest example.
    pub depth_limit: f32,
    /// Displacements of an example up to this length are dropped, m. Default 0: drops only zeros.
    pub drop_below: f32,
    /// Mass of every vertex, kg, for impulses without a mass. It is a calibration constant in impulse * duration /
    /// mass, not the body's mass. Default 0: unknown.
    pub vertex_mass: f32,
    /// How far a vertex may be from where dents would put it, m: vertices follow a few of them, and more are added to these where
    /// vertices are wrong. Less takes more memory, and hits cost more. Default 0: as many as fit all bodies well.
    pub basis_tolerance: f32,
    /// Largest position error from quantisation at weight 1, m. Above 0, displacements are stored as integers of 1 or 2
    /// bytes. Default 0: exact floats. It changes the fingerprint; depth_limit and vertex_mass do not.
    pub bake_tolerance: f32,
    /// Largest error of a normal at weight 1, degrees, above 0 and up to 45. Unused if bake_tolerance is 0. Default 1.
    pub bake_normal_tolerance: f32,
    /// Mass of each vertex, kg: vertex_count floats, instead of vertex_mass. Default absent.
    pub vertex_masses: CrumpleInput,
    /// Examples also count mirrored unless they contradict it, if the body is symmetric about a coordinate plane through the
    /// centre of its bounds. Default true.
    pub mirror: MaybeUninit<bool>,
    /// Dents fade to zero at boundary edges that no example moves. Default true.
    pub held_rims: MaybeUninit<bool>,
    /// Keep the examples whole in baked bytes too, as CRUMPLE_RULE_MOST_DISPLACED and CRUMPLE_RULE_BLEND need them. An
    /// example of a body of many vertices then takes ten times the memory. Default false.
    pub whole_examples: MaybeUninit<bool>,
}

/// An example: the base mesh after a collision. Set target_positions, or delta_indices and position_deltas.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleExampleDef {
    pub struct_size: u32,
    /// Number of vertices in delta_indices, position_deltas and normal_deltas.
    pub delta_count: u32,
    /// UTF-8 text. It is copied and need not be unique. Null: empty.
    pub name: *const c_char,
    /// Full form: the new position of every vertex, vertex_count times 3 floats, m, in the base mesh's order.
    pub target_positions: CrumpleInput,
    /// Full form: the new unit normals, vertex_count times 3 floats. Absent: computed. Needs normals of the base mesh.
    pub target_normals: CrumpleInput,
    /// Sparse form: indices of the moved vertices, strictly increasing, delta_count times uint32_t.
    pub delta_indices: CrumpleInput,
    /// Sparse form: their displacements, delta_count times 3 floats, m.
    pub position_deltas: CrumpleInput,
    /// Sparse form: the changes of their unit normals, delta_count times 3 floats. Absent: computed.
    pub normal_deltas: CrumpleInput,
    pub contact_kind: MaybeUninit<CrumpleContactKind>,
    /// The vertex that was hit, for CRUMPLE_CONTACT_KIND_VERTEX.
    pub contact_vertex: u32,
    /// The point that was hit, m, in the mesh's space, for CRUMPLE_CONTACT_KIND_POINT.
    pub contact_point: CrumpleVec3,
    /// The surface's outward direction at the contact, of any length above 0. Used only if has_contact_normal is true.
    pub contact_normal: CrumpleVec3,
    /// The impulse on the body, N s. Default 0: unknown.
    pub impulse: CrumpleVec3,
    /// How long the impulse acted, s. Default 0: unknown.
    pub duration: f32,
    pub striker: CrumpleStriker,
    /// Whether contact_normal is given. Default false: the mesh's normal is used.
    pub has_contact_normal: MaybeUninit<bool>,
}

/// A mesh as arrays, which are copied.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleMeshDef {
    pub struct_size: u32,
    /// Number of vertices, at least 1. Their order is kept.
    pub vertex_count: u32,
    /// Number of indices, a multiple of 3.
    pub index_count: u32,
    pub index_type: MaybeUninit<CrumpleIndexType>,
    /// Positions: vertex_count times 3 floats, m. Any handedness, any axis up. Required.
    pub positions: CrumpleInput,
    /// Unit normals: vertex_count times 3 floats. Absent: computed from the triangles, smooth across seams.
    pub normals: CrumpleInput,
    /// Tangents as in glTF: vertex_count times 4 floats, xyz of unit length, w +1 or -1. Absent: none.
    pub tangents: CrumpleInput,
    /// Triangles: index_count indices, counter-clockwise seen from outside. Absent: a point cloud, which needs normals.
    pub indices: CrumpleInput,
    /// How far each vertex may move: vertex_count floats, m, at least 0, INFINITY for no limit of its own. Rounded down by up to
    /// 1 in 128. The depth limits of the set and of the instance hold too. Absent: none; for a further mesh of a set, those
    /// of the nearest base vertices.
    pub depth_limits: CrumpleInput,
    /// How much less than its dents each vertex moves: vertex_count floats, 0 (as the dents say) to 1 (not at all). Absent: 0;
    /// for a further mesh of a set, as the nearest base vertices.
    pub stiffness: CrumpleInput,
}

/// A base mesh, at least one example, and the options of the set.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleExampleSetDef {
    pub struct_size: u32,
    pub example_count: u32,
    /// The base mesh, from crumple_mesh_def_default(). Required.
    pub mesh: *const CrumpleMeshDef,
    /// example_count defs, each from crumple_example_def_default().
    pub examples: *const CrumpleExampleDef,
    pub options: CrumpleExampleSetOptions,
}

c_enums!(CrumpleContactKind::Point, CrumpleIndexType::U16);
defs!(CrumpleExampleDef, CrumpleExampleSetDef, CrumpleMeshDef);

pub(super) fn default_options() -> CrumpleExampleSetOptions {
    CrumpleExampleSetOptions {
        bake_normal_tolerance: SetOptions::default().normal_tolerance,
        mirror: MaybeUninit::new(true),
        held_rims: MaybeUninit::new(true),
        whole_examples: MaybeUninit::new(false),
        ..zeroed::<CrumpleExampleSetDef>().options
    }
}

#[unsafe(no_mangle)]
pub extern "C" fn crumple_example_def_default() -> CrumpleExampleDef {
    zeroed()
}

#[unsafe(no_mangle)]
pub extern "C" fn crumple_example_set_def_default() -> CrumpleExampleSetDef {
    CrumpleExampleSetDef { options: default_options(), ..zeroed() }
}

/// Builds an example set from arrays. This indexes the mesh and samples every example, which takes time: build sets
/// while loading, or load baked ones. Errors: CRUMPLE_ERROR_MESH (no vertices), CRUMPLE_ERROR_EXAMPLE_MISMATCH (no
/// examples, or one that does not fit the mesh).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_example_set_create(
    context: *mut CrumpleContext,
    def: *const CrumpleExampleSetDef,
    out_set: *mut CrumpleExampleSet,
) -> CrumpleResult {
    exclusive("crumple_example_set_create", context, |context, state| {
        let (def, out) = (self::def(def, "def")?, Out::new(out_set, "out_set")?);
        let mesh = read_mesh(def.mesh, "def.mesh")?;
        let examples = read_examples(&def, &mesh)?;
        let options = read_options(&def.options, mesh.positions.len())?;
        let set = ExampleSet::build(mesh, examples, options, &context.tasks)?;
        insert_set(context, state, SetEntry::new(set), out)
    })
}

#[unsafe(no_mangle)]
pub extern "C" fn crumple_mesh_def_default() -> CrumpleMeshDef {
    zeroed()
}

/// Adds a mesh of the same body, such as a level of detail or a collision proxy, in the base mesh's space. It shows the
/// same damage. Call this before the set's first instance is created. out_lod receives its number for the lod fields of
/// defs, 1 for the first. Each vertex is bound to the nearest point of the base surface and moves with it. A vertex at
/// the position of a base vertex moves exactly like that vertex. Contacts, marks, saved damage and the fingerprint
/// still refer to the base mesh. Errors: CRUMPLE_ERROR_INVALID_ARGUMENT (the set has instances), CRUMPLE_ERROR_MESH.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_example_set_add_lod(
    context: *mut CrumpleContext,
    set: CrumpleExampleSet,
    mesh: *const CrumpleMeshDef,
    out_lod: *mut u32,
) -> CrumpleResult {
    exclusive("crumple_example_set_add_lod", context, |context, state| {
        let out = Out::new(out_lod, "out_lod")?;
        let entry = state.sets.get_mut(set, "set")?;
        let set = Arc::get_mut(entry).and_then(|entry| Arc::get_mut(&mut entry.set)).ok_or_else(|| {
            Failure::invalid("set has instances, or is shared with another context; add its levels of detail before the first instance is made")
        })?;
        let lod = set.add_lod(read_mesh(mesh, "mesh")?, &context.tasks)?;
        let report = set.report().lods[lod - 1];
        let (level, doubt) = if report.farthest > FAR_OFF * set.mesh().bounds().diagonal() {
            (CrumpleLogLevel::Warning, "; is it the same body, in the same space and units?")
        } else {
            (CrumpleLogLevel::Info, "")
        };
        let message = format!(
            "level of detail {lod}: {} vertices, at most {} m from the base surface, {} bytes{doubt}",
            report.vertices, report.farthest, report.bytes
        );
        context.log(level, &message);
        out.answer(lod as u32)
    })
}

pub(super) unsafe fn read_mesh(def: *const CrumpleMeshDef, name: &str) -> Result<MeshData, Failure> {
    let def = &self::def(def, name)?;
    let vertices = def.vertex_count as usize;
    if vertices == 0 {
        return Err(Failure::mesh(format!("{name}.vertex_count is 0; a mesh needs at least one vertex")));
    }
    let field = |field: &str| format!("{name}.{field}");
    Ok(MeshData {
        positions: read(def.positions, vertices, &field("positions"))?
            .ok_or_else(|| Failure::null(&field("positions.data")))?,
        normals: read(def.normals, vertices, &field("normals"))?,
        tangents: read(def.tangents, vertices, &field("tangents"))?,
        triangles: read_triangles(def, name)?,
        depth_limits: read(def.depth_limits, vertices, &field("depth_limits"))?,
        stiffness: read(def.stiffness, vertices, &field("stiffness"))?,
    })
}

unsafe fn read_triangles(def: &CrumpleMeshDef, name: &str) -> Result<Vec<[u32; 3]>, Failure> {
    let count = def.index_count as usize;
    if !count.is_multiple_of(3) {
        return Err(Failure::invalid(format!("{name}.index_count is {count}; it must be a multiple of 3")));
    }
    let indices = &format!("{name}.indices");
    let found = match enumerator(def.index_type, &format!("{name}.index_type"))? {
        CrumpleIndexType::U32 => read::<u32>(def.indices, count, indices)?.map(|all| corners(&all, indices)),
        CrumpleIndexType::U16 => read::<u16>(def.indices, count, indices)?.map(|all| corners(&all, indices)),
    };
    match found {
        Some(triangles) => triangles,
        None if count == 0 => Ok(Vec::new()),
        None => Err(Failure::null_pointer(format!("{indices}.data is null but {name}.index_count is {count}"))),
    }
}

fn corners<T: Copy + Into<u32>>(indices: &[T], name: &str) -> Result<Vec<[u32; 3]>, Failure> {
    let mut triangles = reserve(indices.len() / 3, name)?;
    triangles.extend(indices.as_chunks::<3>().0.iter().map(|corners| corners.map(Into::into)));
    Ok(triangles)
}

unsafe fn read_examples(def: &CrumpleExampleSetDef, mesh: &MeshData) -> Result<Vec<ExampleData>, Failure> {
    let count = def.example_count as usize;
    let mut examples = Vec::new();
    for i in 0..count {
        let name = format!("def.examples[{i}]");
        let at = def.examples.wrapping_add(i);
        // The first is read before memory is reserved for all: a wrong count is found by it.
        let example = self::def(at, if def.examples.is_null() { "def.examples" } else { &name })?;
        if i == 0 {
            examples = reserve(count, "def.examples")?;
        }
        examples.push(read_example(example, mesh, &name)?);
    }
    Ok(examples)
}

unsafe fn read_example(example: CrumpleExampleDef, mesh: &MeshData, name: &str) -> Result<ExampleData, Failure> {
    let field = |field: &str| format!("{name}.{field}");
    let invalid = |what: &str| Err(Failure::invalid(format!("{name}{what}")));
    let missing = |what: &str| Err(Failure::null_pointer(format!("{name} {what}")));
    let vertices = mesh.positions.len();
    let title = string(example.name, &field("name"))?.unwrap_or_default();
    let targets = vectors(example.target_positions, vertices, &field("target_positions"))?;
    let target_normals = vectors(example.target_normals, vertices, &field("target_normals"))?;
    let count = example.delta_count as usize;
    let indices = || read(example.delta_indices, count, &field("delta_indices"));
    let moved = indices()?;
    let deltas = vectors(example.position_deltas, count, &field("position_deltas"))?;
    let normal_deltas = vectors(example.normal_deltas, count, &field("normal_deltas"))?;

    let (positions, normals) = match (targets, moved, deltas) {
        (Some(targets), None, None) => {
            if normal_deltas.is_some() {
                return invalid(".normal_deltas belongs to the sparse form; give target_normals with target_positions");
            }
            let normals = match (target_normals, &mesh.normals) {
                (Some(targets), Some(base)) => Some(differences(targets, base)),
                (Some(_), None) => return invalid(".target_normals needs the base mesh's normals (def.mesh.normals)"),
                (None, _) => None,
            };
            (differences(targets, &mesh.positions), normals)
        }
        (None, Some(own), Some(values)) => {
            if target_normals.is_some() {
                return invalid(".target_normals belongs to the full form; give normal_deltas with position_deltas");
            }
            let normals = match normal_deltas {
                Some(values) => Some(Deltas::Sparse { indices: indices()?.unwrap_or_default(), values }),
                None => None,
            };
            (Deltas::Sparse { indices: own, values }, normals)
        }
        (None, None, None) => {
            return missing("has neither target_positions nor delta_indices and position_deltas");
        }
        (None, ..) => return missing("has one of delta_indices and position_deltas; the sparse form needs both"),
        (Some(_), ..) => return invalid(" has target_positions and sparse deltas; give one of the two forms"),
    };
    let contact = match enumerator(example.contact_kind, &field("contact_kind"))? {
        CrumpleContactKind::None => None,
        CrumpleContactKind::Vertex => Some(Contact::Vertex(example.contact_vertex)),
        CrumpleContactKind::Point => {
            Some(Contact::Point(finite(example.contact_point.array(), &field("contact_point"))?))
        }
    };
    let contact_normal = boolean(example.has_contact_normal)
        .then(|| finite(example.contact_normal.array(), &field("contact_normal")))
        .transpose()?;
    finite(example.impulse.array(), &field("impulse"))?;
    let blow = Blow {
        impulse: example.impulse.known(),
        duration: positive_or(example.duration, &field("duration"), "s", "an unknown one")?,
        normal: contact_normal,
        striker: example.striker.read(&field("striker"))?,
    };
    Ok(ExampleData { normals, contact, contact_normal, blow, ..ExampleData::new(title, positions) })
}

/// What leads from the base to the targets.
fn differences(mut targets: Vec<[f32; 3]>, base: &[[f32; 3]]) -> Deltas {
    for (target, base) in targets.iter_mut().zip(base) {
        *target = [target[0] - base[0], target[1] - base[1], target[2] - base[2]];
    }
    Deltas::Full(targets)
}

/// Reads an array of vectors, and refuses NaN and infinities.
unsafe fn vectors(input: CrumpleInput, count: usize, name: &str) -> Result<Option<Vec<[f32; 3]>>, Failure> {
    let values: Option<Vec<[f32; 3]>> = read(input, count, name)?;
    let wrong = values.iter().flatten().enumerate().find(|(_, v)| !v.iter().all(|x| x.is_finite()));
    wrong.map_or(Ok(()), |(i, v)| finite(*v, &format!("{name}[{i}]")).map(drop))?;
    Ok(values)
}

pub(super) unsafe fn read_options(options: &CrumpleExampleSetOptions, vertices: usize) -> Result<SetOptions, Failure> {
    let positive = |value, field: &str, unit, zero| positive_or(value, &format!("def.options.{field}"), unit, zero);
    let each = read(options.vertex_masses, vertices, "def.options.vertex_masses")?;
    let mass = match (positive(options.vertex_mass, "vertex_mass", "kg", "unknown masses")?, each) {
        (None, None) => VertexMass::None,
        (Some(mass), None) => VertexMass::Uniform(mass),
        (None, Some(masses)) => VertexMass::PerVertex(masses),
        (Some(mass), Some(_)) => {
            let what = "but vertex_masses is there too; give one of the two";
            return Err(Failure::invalid(format!("def.options.vertex_mass is {mass} kg {what}")));
        }
    };
    Ok(SetOptions {
        depth_limit: positive(options.depth_limit, "depth_limit", "m", "three times the deepest example's")?,
        mirror: boolean(options.mirror),
        held_rims: boolean(options.held_rims),
        whole_examples: boolean(options.whole_examples),
        basis: positive(options.basis_tolerance, "basis_tolerance", "m", "nodes spread evenly")?.map(BasisOptions::new),
        mass,
        drop_below: options.drop_below,
        tolerance: positive(options.bake_tolerance, "bake_tolerance", "m", "exact floats")?,
        normal_tolerance: options.bake_normal_tolerance,
    })
}

/// Writes an example set as the bytes of a .crumple file, equal on all machines.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_example_set_save_baked(
    context: *mut CrumpleContext,
    set: CrumpleExampleSet,
    data: *mut c_void,
    capacity: usize,
    out_size: *mut usize,
) -> CrumpleResult {
    exclusive("crumple_example_set_save_baked", context, |_, state| {
        let out = Out::new(out_size, "out_size")?;
        let set = &state.sets.get(set, "set")?.set;
        if data.is_null() && capacity == 0 {
            return out.answer(set.saved_bytes());
        }
        write_array(&set.save()?, data.cast::<u8>(), capacity, "data", out)
    })
}
