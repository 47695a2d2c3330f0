//! Example sets from the caller's arrays.

use super::check::{CEnum, Def, MadeBy, Out, boolean, def, enumerator, finite, nth_def, positive_or_none, string};
use super::context::{Context, CrumpleContext, CrumpleLogLevel, State, recorded};
use super::memory::{read, read_required};
use super::recording::{Call, Log, Number};
use super::result::{CrumpleResult, Failure};
use super::set_info::CrumplePrimitive;
use super::tasks::Quiet;
use super::types::{CrumpleExampleSet, CrumpleInput, CrumpleVec3};
use crate::base::error::reserve;
use crate::{Combine, Contact, Deltas, ExampleData, ExampleSet, MeshData, Placement, Seams, SetOptions, VertexMass};
use std::ffi::{CString, c_char};
use std::mem::MaybeUninit;
use std::sync::Arc;

/// How the dents of several hits combine at a vertex. The direction is always that of their sum.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CrumpleCombine {
    /// Energies add: depth grows as the root of the number of equal hits, as metal does. The default.
    Energies = 0,
    /// Lengths add, up to the depth limit.
    Sum = 1,
    /// The deepest dent decides: stamping to a fixed position.
    Deepest = 2,
}

impl CEnum for CrumpleCombine {
    const ALL: &'static [Self] = &[Self::Energies, Self::Sum, Self::Deepest];
}

/// What becomes of an example that moves apart vertices which share a position in the base mesh.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CrumpleSeams {
    /// They stay together: each gets the mean of their displacements. The default.
    Weld = 0,
    /// They move apart, as the example says: a tear that the artist made.
    Keep = 1,
}

impl CEnum for CrumpleSeams {
    const ALL: &'static [Self] = &[Self::Weld, Self::Keep];
}

/// Whether an example may be carried away from where it was made.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CrumplePlacement {
    /// Anchored for hits close to its own contact that ask for about its own depth, carried for others. The default.
    Automatic = 0,
    /// Always where and as the artist made it: creases, frames, bumpers.
    Anchored = 1,
    /// Always carried to where the body was hit: sheet metal.
    Carried = 2,
}

impl CEnum for CrumplePlacement {
    const ALL: &'static [Self] = &[Self::Automatic, Self::Anchored, Self::Carried];
}

/// The type of triangle indices.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CrumpleIndexType {
    /// uint32_t, 4 bytes. The default.
    U32 = 0,
    /// uint16_t, 2 bytes.
    U16 = 1,
}

impl CEnum for CrumpleIndexType {
    const ALL: &'static [Self] = &[Self::U32, Self::U16];
}

/// How the place where an example was hit is told.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CrumpleContactKind {
    /// Not told: its deepest vertex. The default.
    None = 0,
    /// A vertex of the base mesh.
    Vertex = 1,
    /// A point in the mesh's space; its nearest vertex becomes the contact.
    Point = 2,
}

impl CEnum for CrumpleContactKind {
    const ALL: &'static [Self] = &[Self::None, Self::Vertex, Self::Point];
}

/// How an example set is made ready. Part of the defs that make one, which carry its defaults.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleExampleSetOptions {
    /// No vertex ever moves further than this, m. 0: the deepest displacement of any example. Default 0.
    pub depth_limit: f32,
    /// Displacements of an example up to this length are dropped, m. 0: only exact zeros. Default 0.
    pub drop_below: f32,
    /// Mass of every vertex, kg, for impulses that bring none of their own. 0: not known. Default 0.
    pub vertex_mass: f32,
    /// Nodes along each side of the grid that a carried example is kept in: 4 to 128. Default 32; sharp creases want
    /// more. With a tolerance, at most.
    pub stamp_resolution: u32,
    /// How far an example of weight 1 may put a vertex off, m: displacements are kept as integers of 1 or 2 bytes that hold
    /// this, and carried examples on the coarsest grid that does. 0, the default: exact floats.
    pub tolerance: f32,
    /// With a tolerance: how far an example of weight 1 may turn a normal off, degrees; above 0 to 45. Default 1.
    pub normal_tolerance: f32,
    /// Mass of each vertex, kg: vertex_count floats, instead of vertex_mass. Default absent.
    pub vertex_masses: CrumpleInput,
    /// How the dents of several hits combine. Default CRUMPLE_COMBINE_ENERGIES.
    pub combine: MaybeUninit<CrumpleCombine>,
    /// What becomes of examples that tear seams. Default CRUMPLE_SEAMS_WELD.
    pub seams: MaybeUninit<CrumpleSeams>,
    /// Whether carried examples may never be scaled above their own depth, as anchored ones never are. Default false.
    pub strict: MaybeUninit<bool>,
    /// Whether examples also serve mirrored, where the body is the same on both sides of a coordinate plane through the
    /// centre of its bounds. Default true.
    pub mirror: MaybeUninit<bool>,
    /// Whether carried dents fall to zero towards edges of the sheet that the examples show to be held. Default true.
    pub held_rims: MaybeUninit<bool>,
}

/// One example: the base mesh after a collision. Give target_positions, or delta_indices with position_deltas.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleExampleDef {
    /// Bytes of this struct, from crumple_example_def_default().
    pub struct_size: u32,
    /// Number of moved vertices in delta_indices, position_deltas and normal_deltas. Without meaning for
    /// target_positions.
    pub delta_count: u32,
    /// Any UTF-8 text that ends with a zero, copied; need not be unique. Null: empty.
    pub name: *const c_char,
    /// Full form: where every vertex of the base mesh goes: vertex_count times 3 floats, m, in the base's order.
    pub target_positions: CrumpleInput,
    /// Full form: unit normals there: vertex_count times 3 floats. Absent: computed. Needs the base mesh's normals.
    pub target_normals: CrumpleInput,
    /// Sparse form: indices of the moved vertices, strictly increasing: delta_count times uint32_t.
    pub delta_indices: CrumpleInput,
    /// Sparse form: how far they move: delta_count times 3 floats, m.
    pub position_deltas: CrumpleInput,
    /// Sparse form: how their unit normals change: delta_count times 3 floats. Absent: computed.
    pub normal_deltas: CrumpleInput,
    /// How the place where the example was hit is told. Default CRUMPLE_CONTACT_KIND_NONE.
    pub contact_kind: MaybeUninit<CrumpleContactKind>,
    /// The vertex that was hit, for CRUMPLE_CONTACT_KIND_VERTEX.
    pub contact_vertex: u32,
    /// The point that was hit, m, in the mesh's space, for CRUMPLE_CONTACT_KIND_POINT.
    pub contact_point: CrumpleVec3,
    /// The surface's outward direction there, of any length but 0, where has_contact_normal is true.
    pub contact_normal: CrumpleVec3,
    /// Whether contact_normal is given; otherwise it is taken from the mesh. Default false.
    pub has_contact_normal: MaybeUninit<bool>,
    /// Whether it may be carried. Default CRUMPLE_PLACEMENT_AUTOMATIC.
    pub placement: MaybeUninit<CrumplePlacement>,
}

/// A base mesh and its examples, as arrays.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleExampleSetDef {
    /// Bytes of this struct, from crumple_example_set_def_default().
    pub struct_size: u32,
    /// Vertices of the base mesh, at least 1. Their order is yours and is kept.
    pub vertex_count: u32,
    /// Positions: vertex_count times 3 floats, m. Any handedness, any axis up. Required.
    pub positions: CrumpleInput,
    /// Unit normals: vertex_count times 3 floats. Absent: computed from the triangles, smooth across seams.
    pub normals: CrumpleInput,
    /// Tangents as in glTF: vertex_count times 4 floats, xyz of unit length, w +1 or -1. Absent: none.
    pub tangents: CrumpleInput,
    /// Triangles: index_count indices, three a triangle, counter-clockwise seen from outside. Absent: a cloud of
    /// points, which then needs normals.
    pub indices: CrumpleInput,
    /// Number of indices, a multiple of 3.
    pub index_count: u32,
    /// Type of indices. Default CRUMPLE_INDEX_TYPE_U32.
    pub index_type: MaybeUninit<CrumpleIndexType>,
    /// The examples: example_count of them, each from crumple_example_def_default().
    pub examples: *const CrumpleExampleDef,
    /// Number of examples, at least 1.
    pub example_count: u32,
    /// How the set is made ready.
    pub options: CrumpleExampleSetOptions,
}

// SAFETY: `repr(C)`, starts with its size, and any bytes are a value of it.
unsafe impl Def for CrumpleExampleDef {
    const DEFAULT: MadeBy<Self> = ("crumple_example_def_default", crumple_example_def_default);
}

// SAFETY: as above.
unsafe impl Def for CrumpleExampleSetDef {
    const DEFAULT: MadeBy<Self> = ("crumple_example_set_def_default", crumple_example_set_def_default);
}

/// What a context keeps of a set.
pub(super) struct SetEntry {
    pub(super) set: Arc<ExampleSet>,
    /// The mesh's name in the file it came from.
    pub(super) name: CString,
    /// The examples' names.
    pub(super) names: Vec<CString>,
    pub(super) primitives: Vec<CrumplePrimitive>,
    /// What `primitives` points to.
    pub(super) _materials: Vec<CString>,
    pub(super) node_transform: Option<[f32; 16]>,
}

pub(super) fn default_options() -> CrumpleExampleSetOptions {
    CrumpleExampleSetOptions {
        depth_limit: 0.0,
        drop_below: 0.0,
        vertex_mass: 0.0,
        stamp_resolution: SetOptions::default().stamp_resolution,
        tolerance: 0.0,
        normal_tolerance: SetOptions::default().normal_tolerance,
        vertex_masses: CrumpleInput::ABSENT,
        combine: MaybeUninit::new(CrumpleCombine::Energies),
        seams: MaybeUninit::new(CrumpleSeams::Weld),
        strict: MaybeUninit::new(false),
        mirror: MaybeUninit::new(true),
        held_rims: MaybeUninit::new(true),
    }
}

/// A text of any origin as one that C can read.
pub(super) fn c_string(text: &str) -> CString {
    CString::new(text.replace('\0', "\u{fffd}")).unwrap_or_default()
}

/// An example without anything: set its positions. Never fails; any thread.
#[unsafe(no_mangle)]
pub extern "C" fn crumple_example_def_default() -> CrumpleExampleDef {
    CrumpleExampleDef {
        struct_size: size_of::<CrumpleExampleDef>() as u32,
        delta_count: 0,
        name: std::ptr::null(),
        target_positions: CrumpleInput::ABSENT,
        target_normals: CrumpleInput::ABSENT,
        delta_indices: CrumpleInput::ABSENT,
        position_deltas: CrumpleInput::ABSENT,
        normal_deltas: CrumpleInput::ABSENT,
        contact_kind: MaybeUninit::new(CrumpleContactKind::None),
        contact_vertex: 0,
        contact_point: CrumpleVec3::default(),
        contact_normal: CrumpleVec3::default(),
        has_contact_normal: MaybeUninit::new(false),
        placement: MaybeUninit::new(CrumplePlacement::Automatic),
    }
}

/// A set without anything: set its mesh and its examples. Never fails; any thread.
#[unsafe(no_mangle)]
pub extern "C" fn crumple_example_set_def_default() -> CrumpleExampleSetDef {
    CrumpleExampleSetDef {
        struct_size: size_of::<CrumpleExampleSetDef>() as u32,
        vertex_count: 0,
        positions: CrumpleInput::ABSENT,
        normals: CrumpleInput::ABSENT,
        tangents: CrumpleInput::ABSENT,
        indices: CrumpleInput::ABSENT,
        index_count: 0,
        index_type: MaybeUninit::new(CrumpleIndexType::U32),
        examples: std::ptr::null(),
        example_count: 0,
        options: default_options(),
    }
}

/// Makes an example set from arrays, which are copied: free them afterwards. Takes a moment (it indexes the mesh and
/// samples every example), so load before the scene starts, on a context of its own thread if need be.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED, CRUMPLE_ERROR_STRUCT_SIZE
/// (of def or of an example), CRUMPLE_ERROR_INVALID_ID, CRUMPLE_ERROR_INVALID_ARGUMENT (an enumerator or a count, a
/// stride smaller than an element, an option out of range), CRUMPLE_ERROR_BUFFER_TOO_SMALL (an array has fewer bytes
/// than its count needs), CRUMPLE_ERROR_NOT_FINITE, CRUMPLE_ERROR_INDEX_OUT_OF_RANGE, CRUMPLE_ERROR_MESH (no
/// vertices), CRUMPLE_ERROR_EXAMPLE_MISMATCH (no example, or one that does not fit the mesh),
/// CRUMPLE_ERROR_OUT_OF_MEMORY, CRUMPLE_ERROR_CONCURRENT_USE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_example_set_create(
    context: *mut CrumpleContext,
    def: *const CrumpleExampleSetDef,
    out_set: *mut CrumpleExampleSet,
) -> CrumpleResult {
    recorded("crumple_example_set_create", context, |context, state, log| {
        // SAFETY: the caller's.
        let (def, out) = unsafe { (self::def(def, "def")?, Out::new(out_set, "out_set")?) };
        // SAFETY: the caller's.
        let (mesh, examples) = unsafe {
            let mesh = read_mesh(&base_of(&def))?;
            let examples = read_examples(&def, &mesh)?;
            (mesh, examples)
        };
        let triangles = mesh.triangles.len() as u32;
        let whole = CrumplePrimitive::new(0..def.vertex_count, 0..triangles);
        // SAFETY: the caller's.
        let options = unsafe { read_options(&def.options, mesh.positions.len()) }?;
        let name = CString::default();
        add_set((context, state, log), (mesh, examples, options), (name, vec![whole], Vec::new(), None), out)
    })
}

/// Another mesh of a set's body, as arrays.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleLodDef {
    /// Bytes of this struct, from crumple_lod_def_default().
    pub struct_size: u32,
    /// Its vertices, at least 1. Their order is yours and is kept.
    pub vertex_count: u32,
    /// Positions: vertex_count times 3 floats, m, in the base mesh's space. Required.
    pub positions: CrumpleInput,
    /// Unit normals: vertex_count times 3 floats. Absent: computed from the triangles, smooth across seams.
    pub normals: CrumpleInput,
    /// Tangents as in glTF: vertex_count times 4 floats, xyz of unit length, w +1 or -1. Absent: none.
    pub tangents: CrumpleInput,
    /// Triangles: index_count indices, three a triangle, counter-clockwise seen from outside. Absent: none.
    pub indices: CrumpleInput,
    /// Number of indices, a multiple of 3.
    pub index_count: u32,
    /// Type of indices. Default CRUMPLE_INDEX_TYPE_U32.
    pub index_type: MaybeUninit<CrumpleIndexType>,
}

// SAFETY: `repr(C)`, starts with its size, and any bytes are a value of it.
unsafe impl Def for CrumpleLodDef {
    const DEFAULT: MadeBy<Self> = ("crumple_lod_def_default", crumple_lod_def_default);
}

/// A level of detail without anything: set its mesh. Never fails; any thread.
#[unsafe(no_mangle)]
pub extern "C" fn crumple_lod_def_default() -> CrumpleLodDef {
    CrumpleLodDef {
        struct_size: size_of::<CrumpleLodDef>() as u32,
        vertex_count: 0,
        positions: CrumpleInput::ABSENT,
        normals: CrumpleInput::ABSENT,
        tangents: CrumpleInput::ABSENT,
        indices: CrumpleInput::ABSENT,
        index_count: 0,
        index_type: MaybeUninit::new(CrumpleIndexType::U32),
    }
}

/// Adds another mesh of the same body that shows the same damage, such as a level of detail or a collision proxy. The arrays
/// are copied. Its number, 1 for the first, is what CrumpleHostBufferDef.lod takes. Each of its vertices is bound to the nearest
/// point of the base surface and moves as that does; one that stands on a base vertex moves exactly as that one. Contacts, marks,
/// saved damage and the set's fingerprint stay those of the base mesh. All instances of the set know all of its levels, so
/// add them before the first instance is made.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED, CRUMPLE_ERROR_STRUCT_SIZE,
/// CRUMPLE_ERROR_INVALID_ID, CRUMPLE_ERROR_INVALID_ARGUMENT (the set has instances; an enumerator, a count, or a stride smaller
/// than an element), CRUMPLE_ERROR_BUFFER_TOO_SMALL (an array has fewer bytes than its count needs),
/// CRUMPLE_ERROR_NOT_FINITE, CRUMPLE_ERROR_INDEX_OUT_OF_RANGE, CRUMPLE_ERROR_MESH (no vertices),
/// CRUMPLE_ERROR_OUT_OF_MEMORY, CRUMPLE_ERROR_CONCURRENT_USE. The set is as it was then.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_example_set_add_lod(
    context: *mut CrumpleContext,
    set: CrumpleExampleSet,
    def: *const CrumpleLodDef,
    out_lod: *mut u32,
) -> CrumpleResult {
    recorded("crumple_example_set_add_lod", context, |context, state, log| {
        // SAFETY: the caller's.
        let (def, out) = unsafe { (self::def(def, "def")?, Out::new(out_lod, "out_lod")?) };
        let id = set;
        let entry = state.sets.get_mut(id, "set")?;
        let set = Arc::get_mut(&mut entry.set).ok_or_else(|| {
            Failure::invalid("set has instances; add its levels of detail before the first instance is made")
        })?;
        // SAFETY: the caller's.
        let mesh = unsafe { read_mesh(&def) }?;
        let lod = set.add_lod(mesh, &Quiet(context.tasks()))?;
        log.set(id, set);
        let report = set.report().lods[lod - 1];
        context.log(
            CrumpleLogLevel::Info,
            &format!(
                "level of detail {lod}: {} vertices, at most {} m from the base surface, {} bytes",
                report.vertices, report.farthest, report.bytes
            ),
        );
        out.write(lod as u32);
        Ok(())
    })
}

/// Builds the set and gives it an id.
pub(super) fn add_set(
    (context, state, log): (&Context, &mut State, &mut Log<'_>),
    (mesh, examples, options): (MeshData, Vec<ExampleData>, SetOptions),
    (name, primitives, materials, node_transform): (CString, Vec<CrumplePrimitive>, Vec<CString>, Option<[f32; 16]>),
    out: Out<CrumpleExampleSet>,
) -> Result<(), Failure> {
    state.sets.reserve::<CrumpleExampleSet>()?;
    let set = ExampleSet::build(mesh, examples, options, &Quiet(context.tasks()))?;
    insert_set((context, state, log), set, (name, primitives, materials, node_transform), out);
    Ok(())
}

/// Gives a set an id, for which there is room.
pub(super) fn insert_set(
    (context, state, log): (&Context, &mut State, &mut Log<'_>),
    set: ExampleSet,
    (name, primitives, materials, node_transform): (CString, Vec<CrumplePrimitive>, Vec<CString>, Option<[f32; 16]>),
    out: Out<CrumpleExampleSet>,
) {
    let names = set.examples().iter().map(|e| c_string(e.name())).collect();
    for example in set.examples().iter().filter(|e| e.is_empty()) {
        context.log(CrumpleLogLevel::Warning, &format!("example '{}' moves no vertex", example.name()));
    }
    context.log(
        CrumpleLogLevel::Info,
        &format!(
            "example set: {} vertices, {} examples, {} bytes",
            set.vertex_count(),
            set.examples().len(),
            set.memory_bytes()
        ),
    );
    let entry = SetEntry { set: Arc::new(set), name, names, primitives, _materials: materials, node_transform };
    let set = entry.set.clone();
    let id = state.sets.insert(entry);
    log.set(id, &set);
    out.write(id);
}

/// The base mesh alone.
fn base_of(def: &CrumpleExampleSetDef) -> CrumpleLodDef {
    CrumpleLodDef {
        vertex_count: def.vertex_count,
        positions: def.positions,
        normals: def.normals,
        tangents: def.tangents,
        indices: def.indices,
        index_count: def.index_count,
        index_type: def.index_type,
        ..crumple_lod_def_default()
    }
}

unsafe fn read_mesh(def: &CrumpleLodDef) -> Result<MeshData, Failure> {
    let vertices = def.vertex_count as usize;
    if vertices == 0 {
        return Err(
            crate::Error::Mesh { what: "def.vertex_count is 0; a mesh needs at least one vertex".into() }.into()
        );
    }
    // SAFETY: the caller's, here and below.
    let positions = unsafe { read_required(def.positions, vertices, "def.positions") }?;
    // SAFETY: see above.
    let normals = unsafe { read(def.normals, vertices, "def.normals") }?;
    // SAFETY: see above.
    let tangents = unsafe { read(def.tangents, vertices, "def.tangents") }?;
    // SAFETY: see above.
    let triangles = unsafe { read_triangles(def) }?;
    Ok(MeshData { positions, normals, tangents, triangles })
}

unsafe fn read_triangles(def: &CrumpleLodDef) -> Result<Vec<[u32; 3]>, Failure> {
    let count = def.index_count as usize;
    if !count.is_multiple_of(3) {
        return Err(Failure::invalid(format!("def.index_count is {count}; it must be a multiple of 3")));
    }
    let wide: Option<Vec<u32>> = match enumerator(def.index_type, "def.index_type")? {
        // SAFETY: the caller's.
        CrumpleIndexType::U32 => unsafe { read(def.indices, count, "def.indices") }?,
        CrumpleIndexType::U16 => {
            // SAFETY: the caller's.
            let narrow: Option<Vec<u16>> = unsafe { read(def.indices, count, "def.indices") }?;
            match narrow {
                Some(narrow) => {
                    let mut wide = reserve(count, "def.indices")?;
                    wide.extend(narrow.into_iter().map(u32::from));
                    Some(wide)
                }
                None => None,
            }
        }
    };
    let Some(wide) = wide else {
        return if count == 0 {
            Ok(Vec::new())
        } else {
            let message = format!("def.indices.data is null but def.index_count is {count}");
            Err(Failure::new(CrumpleResult::CrumpleErrorNullPointer, message))
        };
    };
    let mut triangles = reserve(count / 3, "def.indices")?;
    triangles.extend(wide.as_chunks::<3>().0);
    Ok(triangles)
}

unsafe fn read_examples(def: &CrumpleExampleSetDef, mesh: &MeshData) -> Result<Vec<ExampleData>, Failure> {
    let mut read = Vec::new();
    for i in 0..def.example_count as usize {
        let name = format!("def.examples[{i}]");
        // SAFETY: the caller's, and the first is read first.
        let example = unsafe { self::def(nth_def(def.examples, i, "def.examples")?, &name)? };
        if i == 0 {
            read = reserve(def.example_count as usize, "def.examples")?;
        }
        // SAFETY: the caller's.
        read.push(unsafe { read_example(example, mesh, &name) }?);
    }
    Ok(read)
}

unsafe fn read_example(example: CrumpleExampleDef, mesh: &MeshData, name: &str) -> Result<ExampleData, Failure> {
    let field = |field: &str| format!("{name}.{field}");
    let invalid = |what: &str| Err(Failure::invalid(format!("{name}{what}")));
    let vertices = mesh.positions.len();
    // SAFETY: the caller's, here and below.
    let title = unsafe { string(example.name, &field("name")) }?.unwrap_or_default();
    // SAFETY: see above.
    let targets = unsafe { read::<[f32; 3]>(example.target_positions, vertices, &field("target_positions")) }?;
    // SAFETY: see above.
    let target_normals = unsafe { read::<[f32; 3]>(example.target_normals, vertices, &field("target_normals")) }?;
    let count = example.delta_count as usize;
    // SAFETY: see above.
    let indices = unsafe { read::<u32>(example.delta_indices, count, &field("delta_indices")) }?;
    // SAFETY: see above.
    let deltas = unsafe { read::<[f32; 3]>(example.position_deltas, count, &field("position_deltas")) }?;
    // SAFETY: see above.
    let normal_deltas = unsafe { read::<[f32; 3]>(example.normal_deltas, count, &field("normal_deltas")) }?;

    let (positions, normals) = match (targets, indices, deltas) {
        (Some(targets), None, None) => {
            if normal_deltas.is_some() {
                return invalid(".normal_deltas belongs to the sparse form; give target_normals with target_positions");
            }
            let normals = match (target_normals, &mesh.normals) {
                (Some(targets), Some(base)) => Some(differences(targets, base, &field("target_normals"))?),
                (Some(_), None) => return invalid(".target_normals needs the base mesh's normals (def.normals)"),
                (None, _) => None,
            };
            (differences(targets, &mesh.positions, &field("target_positions"))?, normals)
        }
        (None, Some(indices), Some(values)) => {
            if target_normals.is_some() {
                return invalid(".target_normals belongs to the full form; give normal_deltas with position_deltas");
            }
            all_finite(&values, &field("position_deltas"))?;
            let normals = match normal_deltas {
                Some(values) => {
                    all_finite(&values, &field("normal_deltas"))?;
                    let mut copy = reserve(indices.len(), "delta_indices")?;
                    copy.extend_from_slice(&indices);
                    Some(Deltas::Sparse { indices: copy, values })
                }
                None => None,
            };
            (Deltas::Sparse { indices, values }, normals)
        }
        (None, None, None) => {
            let message = format!("{name} has neither target_positions nor delta_indices and position_deltas");
            return Err(Failure::new(CrumpleResult::CrumpleErrorNullPointer, message));
        }
        (None, ..) => {
            let message = format!("{name} has one of delta_indices and position_deltas; the sparse form needs both");
            return Err(Failure::new(CrumpleResult::CrumpleErrorNullPointer, message));
        }
        (Some(_), ..) => return invalid(" has target_positions and sparse deltas; give one of the two forms"),
    };
    let contact = match enumerator(example.contact_kind, &field("contact_kind"))? {
        CrumpleContactKind::None => None,
        CrumpleContactKind::Vertex => Some(Contact::Vertex(example.contact_vertex)),
        CrumpleContactKind::Point => {
            Some(Contact::Point(finite(example.contact_point.array(), &field("contact_point"))?))
        }
    };
    let contact_normal = match boolean(example.has_contact_normal) {
        true => Some(finite(example.contact_normal.array(), &field("contact_normal"))?),
        false => None,
    };
    let placement = match enumerator(example.placement, &field("placement"))? {
        CrumplePlacement::Automatic => Placement::Automatic,
        CrumplePlacement::Anchored => Placement::Anchored,
        CrumplePlacement::Carried => Placement::Carried,
    };
    Ok(ExampleData { normals, contact, contact_normal, placement, ..ExampleData::new(title, positions) })
}

/// What leads from the base to the targets.
fn differences(mut targets: Vec<[f32; 3]>, base: &[[f32; 3]], name: &str) -> Result<Deltas, Failure> {
    all_finite(&targets, name)?;
    for (target, base) in targets.iter_mut().zip(base) {
        *target = [target[0] - base[0], target[1] - base[1], target[2] - base[2]];
    }
    Ok(Deltas::Full(targets))
}

/// Refuses NaN and infinities, naming the first.
fn all_finite(values: &[[f32; 3]], name: &str) -> Result<(), Failure> {
    match values.iter().position(|v| !v.iter().all(|x| x.is_finite())) {
        Some(i) => finite(values[i], &format!("{name}[{i}]")).map(drop),
        None => Ok(()),
    }
}

/// # Safety
/// The caller's array, if there is one, can be read.
pub(super) unsafe fn read_options(options: &CrumpleExampleSetOptions, vertices: usize) -> Result<SetOptions, Failure> {
    let uniform = positive_or_none(options.vertex_mass, "def.options.vertex_mass", "kg")?;
    // SAFETY: the caller's.
    let each = unsafe { read::<f32>(options.vertex_masses, vertices, "def.options.vertex_masses") }?;
    let mass = match (uniform, each) {
        (None, None) => VertexMass::None,
        (Some(mass), None) => VertexMass::Uniform(mass),
        (None, Some(masses)) => VertexMass::PerVertex(masses),
        (Some(mass), Some(_)) => {
            let message =
                format!("def.options.vertex_mass is {mass} kg but vertex_masses is there too; give one of the two");
            return Err(Failure::invalid(message));
        }
    };
    Ok(SetOptions {
        depth_limit: positive_or_none(options.depth_limit, "def.options.depth_limit", "m")?,
        combine: match enumerator(options.combine, "def.options.combine")? {
            CrumpleCombine::Energies => Combine::Energies,
            CrumpleCombine::Sum => Combine::Sum,
            CrumpleCombine::Deepest => Combine::Deepest,
        },
        strict: boolean(options.strict),
        mirror: boolean(options.mirror),
        held_rims: boolean(options.held_rims),
        seams: match enumerator(options.seams, "def.options.seams")? {
            CrumpleSeams::Weld => Seams::Weld,
            CrumpleSeams::Keep => Seams::Keep,
        },
        mass,
        drop_below: options.drop_below,
        stamp_resolution: options.stamp_resolution,
        tolerance: positive_or_none(options.tolerance, "def.options.tolerance", "m")?,
        normal_tolerance: options.normal_tolerance,
    })
}

/// Ends a set's id. Its memory lives on as long as instances use it, and they keep working. Strings that the set's
/// infos pointed to are gone.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_INVALID_ID,
/// CRUMPLE_ERROR_CONCURRENT_USE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_example_set_destroy(
    context: *mut CrumpleContext,
    set: CrumpleExampleSet,
) -> CrumpleResult {
    recorded("crumple_example_set_destroy", context, |_, state, log| {
        log.call(|| Call::DestroySet { set: Number::of(set) });
        state.sets.remove(set, "set")?;
        Ok(())
    })
}
