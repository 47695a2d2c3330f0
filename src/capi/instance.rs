//! Instances: bodies in the scene.

use super::boundary::succeeds;
use super::check::read;
use super::context::{add_instance, find, reserve_instance};
use super::prelude::*;
use super::store::InstanceEntry;
use super::types::CrumpleRule;
use crate::instance::Instance;
use crate::select::hit::Selection;
use crate::select::options::{InstanceOptions, Rule};
use glam::Mat4;

/// Options of an instance.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleInstanceDef {
    pub struct_size: u32,
    /// Most marks kept, 1 to 65535. Above, the weakest mark merges into the nearest. Default 64.
    pub mark_capacity: u32,
    /// The example set, which the instance keeps alive. Required.
    pub set: CrumpleExampleSet,
    /// Any number of yours, such as an entity or a pointer. Default 0.
    pub user_data: u64,
    pub rule: MaybeUninit<CrumpleRule>,
    /// How a classic rule selects an example. CRUMPLE_RULE_MARKS needs the default.
    pub selection: MaybeUninit<Selection>,
    /// No vertex moves further than this, m. Default 0: the set's limit.
    pub depth_limit: f32,
    /// Impulses shorter than this leave no mark, N s, in the space of the hit. Default 0.
    pub yield_impulse: f32,
    /// Hits with a target displacement shorter than this leave no mark, m, in the mesh's space. Default 0.
    pub yield_displacement: f32,
    /// Hits further than this from the nearest vertex are errors, m, in the mesh's space. Default 0: the diagonal of
    /// the bounds, or the depth limit if larger.
    pub max_contact_distance: f32,
    /// Constant of CRUMPLE_RULE_BLEND, 0 to 1. Default 0.
    pub blend_constant: f32,
    /// How far a blow of 1 N s moves its contact, m per N s, if the set's blow_count is 0. duration and mass of hits
    /// are then unused. Default 0: duration / mass.
    pub compliance: f32,
    /// How long a dent takes to appear, to deepen or to be repaired, s; see crumple_context_set_time() in crumple_view.h. Default 0: none.
    pub grow_time: f32,
    /// Transform; see crumple_instance_set_transform(). Default the identity.
    pub local_to_world: [f32; 16],
}

defs!(CrumpleInstanceDef);

/// The state of an instance. Pending hits are included.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleInstanceInfo {
    /// The set that it was created with. The id is invalid if the set was destroyed.
    pub set: CrumpleExampleSet,
    /// Memory of the instance, bytes, without the set, and without what is kept for its buffers.
    pub memory_bytes: u64,
    /// Number of marks; 0 with a classic rule.
    pub mark_count: u32,
    pub buffer_count: u32,
    /// No vertex moves further than this, m.
    pub depth_limit: f32,
    /// Number of open contacts; see crumple_contacts.h.
    pub contact_count: u32,
    /// A hash of the marks: equal marks have equal revisions, on all machines. 0 without marks.
    pub revision: u64,
    pub reserved: [u32; 2],
}

#[unsafe(no_mangle)]
pub extern "C" fn crumple_instance_def_default() -> CrumpleInstanceDef {
    let options = InstanceOptions::default();
    CrumpleInstanceDef {
        mark_capacity: options.capacity,
        yield_impulse: options.yield_impulse,
        yield_displacement: options.yield_displacement,
        local_to_world: Mat4::IDENTITY.to_cols_array(),
        ..zeroed()
    }
}

/// Creates an undamaged instance.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_create(
    context: *mut CrumpleContext,
    def: *const CrumpleInstanceDef,
    out_instance: *mut CrumpleInstance,
) -> CrumpleResult {
    exclusive("crumple_instance_create", context, |context, state| {
        let (def, out) = (self::def(def, "def")?, Out::new(out_instance, "out_instance")?);
        let set = state.sets.get(def.set, "def.set")?.set.clone();
        let mut instance = Instance::new(set, options(&def)?)?;
        instance.set_time(state.time)?;
        instance.set_transform(Mat4::from_cols_array(&finite(def.local_to_world, "def.local_to_world")?))?;
        let mut inboxes = context.no_hits();
        reserve_instance(state, &mut inboxes)?;
        granted()?;
        let entry = InstanceEntry { instance, set: def.set, buffers: Vec::new(), user_data: def.user_data };
        out.answer(add_instance(state, &mut inboxes, entry))
    })
}

/// What a depth limit of 0 is.
const SET_LIMIT: &str = "that of the example set";

fn options(def: &CrumpleInstanceDef) -> Result<InstanceOptions, Failure> {
    let [yield_impulse] = finite([def.yield_impulse], "def.yield_impulse")?;
    let [yield_displacement] = finite([def.yield_displacement], "def.yield_displacement")?;
    let [blend_constant] = finite([def.blend_constant], "def.blend_constant")?;
    let [grow_time] = finite([def.grow_time], "def.grow_time")?;
    let (distance, compliance) = ("the body's diagonal", "duration / mass of each impulse");
    Ok(InstanceOptions {
        rule: match enumerator(def.rule, "def.rule")? {
            CrumpleRule::Marks => Rule::Marks,
            CrumpleRule::MostDisplaced => Rule::MostDisplaced,
            CrumpleRule::Blend => Rule::Blend(blend_constant),
        },
        selection: enumerator(def.selection, "def.selection")?,
        depth_limit: positive_or(def.depth_limit, "def.depth_limit", "m", SET_LIMIT)?,
        capacity: def.mark_capacity,
        yield_impulse,
        yield_displacement,
        max_contact_distance: positive_or(def.max_contact_distance, "def.max_contact_distance", "m", distance)?,
        grow_time,
        compliance: positive_or(def.compliance, "def.compliance", "m per N s", compliance)?,
    })
}

/// Destroys an instance and unregisters its buffers. Your memory keeps its contents.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_destroy(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
) -> CrumpleResult {
    exclusive("crumple_instance_destroy", context, |context, state| {
        let entry = state.instances.remove(instance, "instance")?;
        context.no_hits().remove(instance, "instance")?;
        entry.buffers.into_iter().try_for_each(|buffer| state.remove_buffer(buffer))
    })
}

/// Returns whether an id is that of an instance of the context. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_is_valid(context: *mut CrumpleContext, instance: CrumpleInstance) -> bool {
    succeeds(|| find(context)?.deliver(instance, |_| Ok(())))
}

/// Sets the user_data of an instance. A released part begins with that of its body.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_set_user_data(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    user_data: u64,
) -> CrumpleResult {
    exclusive("crumple_instance_set_user_data", context, |_, state| {
        state.instances.get_mut(instance, "instance")?.user_data = user_data;
        Ok(())
    })
}

/// Returns the user_data of an instance.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_get_user_data(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    out_data: *mut u64,
) -> CrumpleResult {
    exclusive("crumple_instance_get_user_data", context, |_, state| {
        Out::new(out_data, "out_data")?.answer(state.instances.get(instance, "instance")?.user_data)
    })
}

/// Returns the state of an instance.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_get_info(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    out_info: *mut CrumpleInstanceInfo,
) -> CrumpleResult {
    exclusive("crumple_instance_get_info", context, |_, state| {
        let out = Out::new(out_info, "out_info")?;
        let entry = state.instances.get_mut(instance, "instance")?;
        let (mark_count, contact_count) = match entry.instance.options().rule {
            Rule::Marks => (entry.instance.marks()?.len() as u32, entry.instance.contact_count() as u32),
            _ => (0, 0),
        };
        out.answer(CrumpleInstanceInfo {
            set: entry.set,
            memory_bytes: entry.instance.memory_bytes() as u64,
            mark_count,
            buffer_count: entry.buffers.len() as u32,
            depth_limit: entry.instance.depth_limit(),
            contact_count,
            revision: entry.instance.revision(),
            reserved: [0; 2],
        })
    })
}

/// Sets the transform: local_to_world points to 16 floats, column-major (element 4 * column + row, as in glTF and
/// Vulkan), translation in elements 12 to 14, m, last row 0 0 0 1. It may scale and shear, but must be invertible. Hits
/// in CRUMPLE_SPACE_WORLD use its inverse at the time of the call, without translation for vectors. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_set_transform(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    local_to_world: *const f32,
) -> CrumpleResult {
    concurrent("crumple_instance_set_transform", context, |context| {
        let columns = read(local_to_world.cast::<[f32; 16]>(), "local_to_world")?;
        let matrix = Mat4::from_cols_array(&finite(columns, "local_to_world")?);
        context.deliver(instance, |inbox| inbox.set_transform(matrix))
    })
}

/// Limits how far a vertex moves, m, from the next deform or recording on. 0: the set's limit. Marks are kept, and
/// their full depth returns when the limit is raised.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_set_depth_limit(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    depth_limit: f32,
) -> CrumpleResult {
    exclusive("crumple_instance_set_depth_limit", context, |_, state| {
        let limit = positive_or(depth_limit, "depth_limit", "m", SET_LIMIT)?;
        Ok(state.body(instance)?.set_depth_limit(limit)?)
    })
}
