//! Instances: bodies in the scene.

use super::check::{CEnum, Def, MadeBy, Out, def, enumerator, finite, positive_or_none};
use super::context::{CrumpleContext, recorded};
use super::recording::{Call, Number, info_number};
use super::result::{CrumpleResult, Failure};
use super::types::{CrumpleBuffer, CrumpleExampleSet, CrumpleInstance};
use crate::glam::Mat4;
use crate::{Instance, InstanceOptions, Rule, Selection};
use std::mem::MaybeUninit;
use std::sync::PoisonError;

/// What hits do to an instance.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CrumpleRule {
    /// Hits leave marks: bounded, local, the same in any order, without memory per vertex. The default.
    Marks = 0,
    /// The literature's rule "most displaced", for comparison: depends on the order of hits, needs memory per vertex,
    /// has no marks.
    MostDisplaced = 1,
    /// The literature's rule "blend", with blend_constant.
    Blend = 2,
}

impl CEnum for CrumpleRule {
    const ALL: &'static [Self] = &[Self::Marks, Self::MostDisplaced, Self::Blend];
}

/// How the examples for a hit are chosen.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CrumpleSelection {
    /// CRUMPLE_SELECTION_NEAREST with marks, CRUMPLE_SELECTION_CLASSIC with the literature's rules. The default.
    OfRule = 0,
    /// The examples that say most of a hit's place, depth and lean, carried or anchored as each says. Marks only.
    Nearest = 1,
    /// The literature's: the one example that moves the contact in the direction most like the target, weight at most
    /// 1.
    Classic = 2,
    /// The same without a limit of the weight: diverges above 2. The literature's rules only, for comparison.
    ClassicUnclamped = 3,
}

impl CEnum for CrumpleSelection {
    const ALL: &'static [Self] = &[Self::OfRule, Self::Nearest, Self::Classic, Self::ClassicUnclamped];
}

/// A body in the scene.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleInstanceDef {
    /// Bytes of this struct, from crumple_instance_def_default().
    pub struct_size: u32,
    /// How many examples one hit may mix: 1 to 4. Default 3.
    pub examples_per_hit: u32,
    /// The mesh and the examples. Required. The instance keeps what it needs of it alive.
    pub set: CrumpleExampleSet,
    /// What hits do. Default CRUMPLE_RULE_MARKS.
    pub rule: MaybeUninit<CrumpleRule>,
    /// How examples are chosen. Default CRUMPLE_SELECTION_OF_RULE.
    pub selection: MaybeUninit<CrumpleSelection>,
    /// Marks kept, 1 to 65535, 32 bytes each. Above it the weakest mark gives its energy to its nearest neighbour.
    /// Default 64.
    pub mark_capacity: u32,
    /// No vertex moves further than this, m. 0: the set's limit. Default 0.
    pub depth_limit: f32,
    /// Impulses shorter than this leave no mark, N s. Default 0.
    pub yield_impulse: f32,
    /// Hits that would displace their contact by less than this leave no mark, m. Default 0.
    pub yield_displacement: f32,
    /// Contacts further than this from the nearest vertex are refused, m. 0: the body's diagonal. Default 0.
    pub max_contact_distance: f32,
    /// Constant of CRUMPLE_RULE_BLEND, 0 to 1. Default 0.
    pub blend_constant: f32,
    /// No vertex is wrong by more than this, m; see crumple_instance_set_tolerance(). Default 0: nothing is left out.
    pub tolerance: f32,
    /// From mesh to world space, column-major (element 4 * column + row); see crumple_instance_set_transform().
    /// Default the identity.
    pub local_to_world: [f32; 16],
}

// SAFETY: `repr(C)`, starts with its size, and any bytes are a value of it.
unsafe impl Def for CrumpleInstanceDef {
    const DEFAULT: MadeBy<Self> = ("crumple_instance_def_default", crumple_instance_def_default);
}

/// What an instance is at the moment.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleInstanceInfo {
    /// The id it was made with, which may be stale by now.
    pub set: CrumpleExampleSet,
    /// Bytes of memory it takes, without the set and without your buffers.
    pub memory_bytes: u64,
    /// Marks, hits that wait among them. 0 with the literature's rules.
    pub mark_count: u32,
    /// Registered buffers.
    pub buffer_count: u32,
    /// No vertex moves further than this, m.
    pub depth_limit: f32,
    /// Open contacts, see crumple_instance_end_contact().
    pub contact_count: u32,
    /// Zero; room for later.
    pub reserved: [u32; 4],
}

/// What a context keeps of an instance.
pub(super) struct InstanceEntry {
    pub(super) instance: Instance,
    pub(super) set: CrumpleExampleSet,
    /// As it was given.
    pub(super) local_to_world: [f32; 16],
    pub(super) buffers: Vec<CrumpleBuffer>,
}

/// An instance with default rules; set its set. Never fails; any thread.
#[unsafe(no_mangle)]
pub extern "C" fn crumple_instance_def_default() -> CrumpleInstanceDef {
    let options = InstanceOptions::default();
    CrumpleInstanceDef {
        struct_size: size_of::<CrumpleInstanceDef>() as u32,
        examples_per_hit: options.examples_per_hit,
        set: CrumpleExampleSet::default(),
        rule: MaybeUninit::new(CrumpleRule::Marks),
        selection: MaybeUninit::new(CrumpleSelection::OfRule),
        mark_capacity: options.capacity,
        depth_limit: 0.0,
        yield_impulse: options.yield_impulse,
        yield_displacement: options.yield_displacement,
        max_contact_distance: 0.0,
        blend_constant: 0.0,
        tolerance: options.tolerance,
        local_to_world: Mat4::IDENTITY.to_cols_array(),
    }
}

/// Creates an undamaged instance: a few hundred bytes, and 8 for each 128 vertices.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED, CRUMPLE_ERROR_STRUCT_SIZE,
/// CRUMPLE_ERROR_INVALID_ID (def.set), CRUMPLE_ERROR_INVALID_ARGUMENT, CRUMPLE_ERROR_NOT_FINITE,
/// CRUMPLE_ERROR_OUT_OF_MEMORY, CRUMPLE_ERROR_CONCURRENT_USE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_create(
    context: *mut CrumpleContext,
    def: *const CrumpleInstanceDef,
    out_instance: *mut CrumpleInstance,
) -> CrumpleResult {
    recorded("crumple_instance_create", context, |context, state, log| {
        // SAFETY: the caller's.
        let (def, out) = unsafe { (self::def(def, "def")?, Out::new(out_instance, "out_instance")?) };
        let set = state.sets.get(def.set, "def.set")?.set.clone();
        let instance = Instance::new(set, options(&def)?)?;
        instance.set_transform(Mat4::from_cols_array(&finite(def.local_to_world, "def.local_to_world")?))?;
        let mut inboxes = context.inboxes.write().unwrap_or_else(PoisonError::into_inner);
        state.instances.reserve::<CrumpleInstance>()?;
        inboxes.reserve::<CrumpleInstance>()?;
        let inbox: CrumpleInstance = inboxes.insert(instance.inbox().clone());
        let entry = InstanceEntry { instance, set: def.set, local_to_world: def.local_to_world, buffers: Vec::new() };
        log.instance(&entry);
        let id = state.instances.insert(entry);
        assert_eq!(inbox, id, "the two lists of instances went apart");
        log.gave_id(id);
        out.write(id);
        Ok(())
    })
}

fn options(def: &CrumpleInstanceDef) -> Result<InstanceOptions, Failure> {
    let rule = enumerator(def.rule, "def.rule")?;
    let yield_impulse = finite([def.yield_impulse], "def.yield_impulse")?[0];
    let yield_displacement = finite([def.yield_displacement], "def.yield_displacement")?[0];
    let blend_constant = finite([def.blend_constant], "def.blend_constant")?[0];
    Ok(InstanceOptions {
        rule: match rule {
            CrumpleRule::Marks => Rule::Marks,
            CrumpleRule::MostDisplaced => Rule::MostDisplaced,
            CrumpleRule::Blend => Rule::Blend(blend_constant),
        },
        selection: match (enumerator(def.selection, "def.selection")?, rule) {
            (CrumpleSelection::OfRule, CrumpleRule::Marks) | (CrumpleSelection::Nearest, _) => Selection::Nearest,
            (CrumpleSelection::OfRule | CrumpleSelection::Classic, _) => Selection::Classic,
            (CrumpleSelection::ClassicUnclamped, _) => Selection::ClassicUnclamped,
        },
        examples_per_hit: def.examples_per_hit,
        depth_limit: positive_or_none(def.depth_limit, "def.depth_limit", "m")?,
        capacity: def.mark_capacity,
        yield_impulse,
        yield_displacement,
        max_contact_distance: positive_or_none(def.max_contact_distance, "def.max_contact_distance", "m")?,
        tolerance: finite([def.tolerance], "def.tolerance")?[0],
    })
}

/// Ends an instance and unregisters its buffers, whose ids end too. Your memory stays as it is.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_INVALID_ID,
/// CRUMPLE_ERROR_CONCURRENT_USE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_destroy(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
) -> CrumpleResult {
    recorded("crumple_instance_destroy", context, |context, state, log| {
        log.call(|| Call::DestroyInstance { instance: Number::of(instance) });
        let entry = state.instances.remove(instance, "instance")?;
        context.inboxes.write().unwrap_or_else(PoisonError::into_inner).remove(instance, "instance")?;
        for buffer in entry.buffers {
            state.remove_buffer(buffer)?;
        }
        Ok(())
    })
}

/// Tells what an instance is at the moment.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED, CRUMPLE_ERROR_INVALID_ID,
/// CRUMPLE_ERROR_CONCURRENT_USE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_get_info(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    out_info: *mut CrumpleInstanceInfo,
) -> CrumpleResult {
    recorded("crumple_instance_get_info", context, |_, state, log| {
        // SAFETY: the caller's.
        let out = unsafe { Out::new(out_info, "out_info") }?;
        log.call(|| Call::InstanceInfo { instance: Number::of(instance) });
        let entry = state.instances.get_mut(instance, "instance")?;
        let (mark_count, contact_count) = match entry.instance.options().rule {
            Rule::Marks => (entry.instance.marks()?.len() as u32, entry.instance.contact_count() as u32),
            _ => (0, 0),
        };
        let info = CrumpleInstanceInfo {
            set: entry.set,
            memory_bytes: entry.instance.memory_bytes() as u64,
            mark_count,
            buffer_count: entry.buffers.len() as u32,
            depth_limit: entry.instance.depth_limit(),
            contact_count,
            reserved: [0; 4],
        };
        log.gave(|| info_number(&info));
        out.write(info);
        Ok(())
    })
}

/// Tells where an instance is: local_to_world points to 16 floats, column-major (element 4 * column + row, as in
/// glTF, OpenGL and Vulkan), translation in elements 12 to 14, m, last row 0 0 0 1. May scale and shear, but not
/// flatten. Only hits in CRUMPLE_SPACE_WORLD go through it, those submitted from then on; deformed vertices are
/// always in the mesh's own space.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED, CRUMPLE_ERROR_INVALID_ID,
/// CRUMPLE_ERROR_NOT_FINITE, CRUMPLE_ERROR_INVALID_ARGUMENT (it flattens, or the last row is another),
/// CRUMPLE_ERROR_CONCURRENT_USE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_set_transform(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    local_to_world: *const f32,
) -> CrumpleResult {
    recorded("crumple_instance_set_transform", context, |_, state, log| {
        // SAFETY: the caller's.
        let columns = unsafe { super::check::read(local_to_world.cast::<[f32; 16]>(), "local_to_world") }?;
        let matrix = Mat4::from_cols_array(&finite(columns, "local_to_world")?);
        log.call(|| Call::SetTransform { instance: Number::of(instance), local_to_world: columns });
        let entry = state.instances.get_mut(instance, "instance")?;
        entry.instance.set_transform(matrix)?;
        entry.local_to_world = columns;
        Ok(())
    })
}

/// No vertex of the instance moves further than depth_limit, m, from the next crumple_context_deform() on; 0: the set's
/// limit. Damage that is there stays, and shows again when the limit is raised.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_INVALID_ID, CRUMPLE_ERROR_NOT_FINITE,
/// CRUMPLE_ERROR_INVALID_ARGUMENT, CRUMPLE_ERROR_CONCURRENT_USE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_set_depth_limit(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    depth_limit: f32,
) -> CrumpleResult {
    recorded("crumple_instance_set_depth_limit", context, |_, state, log| {
        log.call(|| Call::SetDepthLimit { instance: Number::of(instance), depth_limit });
        let limit = positive_or_none(depth_limit, "depth_limit", "m")?;
        Ok(state.instances.get_mut(instance, "instance")?.instance.set_depth_limit(limit)?)
    })
}

/// Lets vertices of the instance be wrong by up to tolerance, m, in the mesh's space, so that deforming it costs less:
/// displacements too short to matter are left out. 0: nothing is left out. Seams stay closed. It is rounded down to a power of
/// two times 1 m, so it may be set in each frame from crumple_pixel_tolerance(); where that changes, the next crumple_context_deform()
/// writes everything that is dented anew. Instances with one of the literature's rules ignore it.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_INVALID_ID, CRUMPLE_ERROR_NOT_FINITE,
/// CRUMPLE_ERROR_INVALID_ARGUMENT (below 0), CRUMPLE_ERROR_CONCURRENT_USE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_set_tolerance(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    tolerance: f32,
) -> CrumpleResult {
    recorded("crumple_instance_set_tolerance", context, |_, state, log| {
        log.call(|| Call::SetTolerance { instance: Number::of(instance), tolerance });
        let tolerance = finite([tolerance], "tolerance")?[0];
        Ok(state.instances.get_mut(instance, "instance")?.instance.set_tolerance(tolerance)?)
    })
}

/// The length, m, that covers so many pixels at a distance, m, before a camera with this vertical field of view, radians, and
/// viewport height, pixels: the tolerance for an instance whose nearest vertex is that far off. 0, which leaves out nothing, for
/// values that make no sense: negative, not a number, a field of view of half a turn or more, a height of 0. Never fails; any
/// thread.
#[unsafe(no_mangle)]
pub extern "C" fn crumple_pixel_tolerance(pixels: f32, distance: f32, fov_y: f32, viewport_height: f32) -> f32 {
    crate::pixel_tolerance(pixels, distance, fov_y, viewport_height)
}
