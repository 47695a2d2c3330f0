//! Hits: what the physics engine reports.

use super::check::{Out, array, def, defs, enumerator, finite, positive_or, striker, zeroed};
use super::context::{CrumpleContext, concurrent, exclusive};
use super::result::{CrumpleResult, Failure};
use super::types::{CrumpleInstance, CrumpleStriker, CrumpleVec3};
use crate::base::error::reserve;
use crate::damage::mark::Mark;
use crate::example::blow::Blow;
use crate::instance::inbox::Inbox;
use crate::select::hit::{Cause, Hit, HitStatus, Outcome, Space};
use std::ffi::c_void;
use std::mem::MaybeUninit;
use std::num::NonZeroU64;

/// A hit given as a blow. point and vectors are in the given space (default CRUMPLE_SPACE_LOCAL). Give impulse, or mass
/// and velocity of the striker. Report a contact once with its whole impulse, or in parts with a contact_id. If any
/// example of the set knows its blow, the set predicts the displacement of the contact: give as much of the blow as the
/// engine knows. Otherwise the displacement is impulse * the instance's compliance, or impulse * duration / mass.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleImpulseDef {
    pub struct_size: u32,
    pub space: MaybeUninit<Space>,
    /// Where the body was hit, m. The nearest vertex becomes the contact.
    pub point: CrumpleVec3,
    /// The impulse on the body, N s. Default 0: striker.mass * striker.velocity. If that is 0 too, there is no mark.
    pub impulse: CrumpleVec3,
    /// How long the impulse acted, s: a constant of the material such as 0.01, not the time step. Required if no example
    /// knows its blow and the instance has no compliance.
    pub duration: f32,
    /// Mass of the contact vertex, kg, for impulse * duration / mass. Default 0: the set's mass for that vertex.
    pub mass: f32,
    /// Contact normal, out of the body, of any length. Default 0: unknown.
    pub normal: CrumpleVec3,
    pub striker: CrumpleStriker,
    /// The contact that the hit is part of; see crumple_instance_end_contact(). Default 0: none.
    pub contact_id: u64,
}

/// A hit given as the desired contact displacement, for engines with their own impulse-to-depth mapping. The dent does
/// not depend on the frame rate. Fields without a comment are as in CrumpleImpulseDef.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleDisplacementDef {
    pub struct_size: u32,
    pub space: MaybeUninit<Space>,
    pub point: CrumpleVec3,
    /// Target displacement of the contact, m.
    pub displacement: CrumpleVec3,
    pub contact_id: u64,
}

defs!(CrumpleImpulseDef, CrumpleDisplacementDef);

/// An example that a hit uses.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CrumpleChosen {
    pub example: u32,
    /// Share of the dent; shares of a hit sum to 1. Negative if it corrects overshoot of the others.
    pub share: f32,
    /// Factor that multiplies the example's displacements.
    pub scale: f32,
    /// Whether the example is anchored. Otherwise it is carried to the contact.
    pub anchored: bool,
    /// Mirrored coordinates, as bits: 1 for x, 2 for y, 4 for z.
    pub mirror: u8,
    pub reserved: u16,
}

/// The effect of a hit. If its status is not CRUMPLE_HIT_STATUS_MARKED, achieved, chosen and mark are zero.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleHitResult {
    pub status: MaybeUninit<HitStatus>,
    /// The vertex nearest to the point.
    pub contact_vertex: u32,
    /// Distance of that vertex from the point, m.
    pub contact_distance: f32,
    /// Target displacement of the contact, before it is clamped, m, in the mesh's space.
    pub target: CrumpleVec3,
    /// Displacement of the contact by this hit alone, m, in the mesh's space.
    pub achieved: CrumpleVec3,
    pub chosen_count: u32,
    /// Whether the target was longer than the depth limit and was cut to it.
    pub clamped: bool,
    /// The examples, the largest share first.
    pub chosen: [CrumpleChosen; 4],
    /// The mark. All zero if the hit leaves none.
    pub mark: Mark,
    pub reserved: [u64; 4],
}

impl CrumpleHitResult {
    fn nothing() -> Self {
        let zero = [0.0; 3];
        CrumpleHitResult::from(&Outcome {
            status: HitStatus::BelowYield,
            contact_vertex: 0,
            contact_distance: 0.0,
            target: zero,
            achieved: zero,
            clamped: false,
            chosen: [None; 4],
            mark: None,
        })
    }
}

impl From<&Outcome> for CrumpleHitResult {
    fn from(outcome: &Outcome) -> Self {
        let mut chosen = [CrumpleChosen::default(); 4];
        let mut chosen_count = 0;
        for (to, from) in chosen.iter_mut().zip(outcome.chosen.iter().flatten()) {
            *to = CrumpleChosen {
                example: from.example,
                share: from.share,
                scale: from.scale,
                anchored: from.anchored,
                mirror: from.mirror.bits(),
                reserved: 0,
            };
            chosen_count += 1;
        }
        CrumpleHitResult {
            status: MaybeUninit::new(outcome.status),
            contact_vertex: outcome.contact_vertex,
            contact_distance: outcome.contact_distance,
            target: outcome.target.into(),
            achieved: outcome.achieved.into(),
            chosen_count,
            clamped: outcome.clamped,
            chosen,
            mark: outcome.mark.unwrap_or(bytemuck::Zeroable::zeroed()),
            reserved: [0; 4],
        }
    }
}

/// Returns a zero impulse in the mesh's space. Set point and impulse, and what else is known.
#[unsafe(no_mangle)]
pub extern "C" fn crumple_impulse_def_default() -> CrumpleImpulseDef {
    zeroed()
}

/// Returns a zero displacement in the mesh's space. Set point and displacement.
#[unsafe(no_mangle)]
pub extern "C" fn crumple_displacement_def_default() -> CrumpleDisplacementDef {
    zeroed()
}

/// Submits a hit. The call selects the examples. The next read of the damage applies the mark (see "Reads" at the top).
/// A hit that is too weak, or that no example fits, is not an error; see out_result->status. out_result may be null.
/// With a contact_id, it describes this hit alone. May be called from any thread at any time, except while the instance
/// or context is being destroyed. Errors: CRUMPLE_ERROR_INVALID_ARGUMENT (a negative duration, mass or radius; no
/// duration, or no mass in def and set, where they are needed), CRUMPLE_ERROR_CONTACT_TOO_FAR, CRUMPLE_ERROR_WRONG_RULE
/// (a contact_id with a classic rule).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_submit_impulse(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    def: *const CrumpleImpulseDef,
    out_result: *mut CrumpleHitResult,
) -> CrumpleResult {
    submit("crumple_instance_submit_impulse", context, instance, || read_impulse(def), Effect::Submit, out_result)
}

/// Like crumple_instance_submit_impulse(), but for a displacement.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_submit_displacement(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    def: *const CrumpleDisplacementDef,
    out_result: *mut CrumpleHitResult,
) -> CrumpleResult {
    submit(
        "crumple_instance_submit_displacement",
        context,
        instance,
        || read_displacement(def),
        Effect::Submit,
        out_result,
    )
}

/// Submits count hits, each to the instance at the same index. Either all are submitted, or none and the message names
/// the first wrong one. out_results is null, or has room for count results. Otherwise like
/// crumple_instance_submit_impulse().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_context_submit_impulses(
    context: *mut CrumpleContext,
    instances: *const CrumpleInstance,
    defs: *const CrumpleImpulseDef,
    count: u32,
    out_results: *mut CrumpleHitResult,
) -> CrumpleResult {
    let read = |i| read_impulse(defs.wrapping_add(i));
    submit_all("crumple_context_submit_impulses", context, instances, (defs.cast(), count), read, out_results)
}

/// Like crumple_context_submit_impulses(), but for displacements.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_context_submit_displacements(
    context: *mut CrumpleContext,
    instances: *const CrumpleInstance,
    defs: *const CrumpleDisplacementDef,
    count: u32,
    out_results: *mut CrumpleHitResult,
) -> CrumpleResult {
    let read = |i| read_displacement(defs.wrapping_add(i));
    submit_all("crumple_context_submit_displacements", context, instances, (defs.cast(), count), read, out_results)
}

/// Computes the result of crumple_instance_submit_impulse() without leaving a mark. out_result is required. May be
/// called from any thread at any time.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_preview_impulse(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    def: *const CrumpleImpulseDef,
    out_result: *mut CrumpleHitResult,
) -> CrumpleResult {
    submit("crumple_instance_preview_impulse", context, instance, || read_impulse(def), Effect::Preview, out_result)
}

/// Like crumple_instance_preview_impulse(), but for a displacement.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_preview_displacement(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    def: *const CrumpleDisplacementDef,
    out_result: *mut CrumpleHitResult,
) -> CrumpleResult {
    submit(
        "crumple_instance_preview_displacement",
        context,
        instance,
        || read_displacement(def),
        Effect::Preview,
        out_result,
    )
}

/// Ends a contact. Its dent stays; later hits with the same id begin a new contact. Use contacts if your physics engine
/// reports one contact as many small impulses. Give each of these hits the same contact_id, any number but 0, and end
/// the contact when the bodies separate. Together they make the dent of the whole impulse, at any frame rate: their
/// impulses or displacements add up, and the place is the mean of their points, weighted by these. Yield thresholds and
/// depth limit apply to the sum. A contact has one mark, which is replaced as hits arrive.
///
/// Ending an unknown id is not an error. Contacts also end when the instance's damage is set, loaded, copied to it,
/// repaired or reset. At most 256 are open per instance; above that, the one hit longest ago ends. May be called from
/// any thread at any time. CRUMPLE_ERROR_WRONG_RULE: a classic rule.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_end_contact(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    contact_id: u64,
) -> CrumpleResult {
    concurrent("crumple_instance_end_contact", context, |context| {
        let id = contact(contact_id)?;
        context.deliver(instance, |inbox| inbox.end_contact(id))
    })
}

/// Returns the result of a contact, all its hits taken as one. The contact is open, or among the 256 of the instance
/// that ended last. The status is CRUMPLE_HIT_STATUS_BELOW_YIELD if there is no such contact or the sum is too weak.
/// CRUMPLE_ERROR_WRONG_RULE: a classic rule.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_get_contact(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    contact_id: u64,
    out_result: *mut CrumpleHitResult,
) -> CrumpleResult {
    exclusive("crumple_instance_get_contact", context, |_, state| {
        let (out, id) = (Out::new(out_result, "out_result")?, contact(contact_id)?);
        let found = state.instances.get_mut(instance, "instance")?.instance.contact(id)?;
        let result = found.as_ref().map_or_else(CrumpleHitResult::nothing, CrumpleHitResult::from);
        out.write(result);
        Ok(())
    })
}

fn contact(id: u64) -> Result<NonZeroU64, Failure> {
    NonZeroU64::new(id)
        .ok_or_else(|| Failure::invalid("contact_id is 0; it must be the id that hits were given, not 0"))
}

/// Whether a hit leaves a mark.
#[derive(Clone, Copy, PartialEq)]
enum Effect {
    Submit,
    Preview,
}

unsafe fn read_impulse(def: *const CrumpleImpulseDef) -> Result<Hit, Failure> {
    let def = self::def(def, "def")?;
    let mass = positive_or(def.mass, "def.mass", "kg", "that of the set")?;
    let impulse = finite(def.impulse.array(), "def.impulse")?;
    let [duration] = finite([def.duration], "def.duration")?;
    finite(def.normal.array(), "def.normal")?;
    let mut blow = Blow {
        impulse: def.impulse.known(),
        duration: (duration != 0.0).then_some(duration),
        normal: def.normal.known(),
        striker: striker(def.striker, "def.striker")?,
    };
    if blow.total_impulse().is_none() {
        // Zero: the hit is too weak, not wrong.
        blow.impulse = Some(impulse);
    }
    let cause = Cause::Impulse { blow, mass };
    hit(def.point, def.space, def.contact_id, cause)
}

unsafe fn read_displacement(def: *const CrumpleDisplacementDef) -> Result<Hit, Failure> {
    let def = self::def(def, "def")?;
    let cause = Cause::Displacement(finite(def.displacement.array(), "def.displacement")?);
    hit(def.point, def.space, def.contact_id, cause)
}

fn hit(point: CrumpleVec3, space: MaybeUninit<Space>, contact_id: u64, cause: Cause) -> Result<Hit, Failure> {
    let space = enumerator(space, "def.space")?;
    Ok(Hit { point: finite(point.array(), "def.point")?, cause, space, contact: NonZeroU64::new(contact_id) })
}

unsafe fn submit(
    call: &'static str,
    context: *const CrumpleContext,
    instance: CrumpleInstance,
    read: impl FnOnce() -> Result<Hit, Failure>,
    effect: Effect,
    out: *mut CrumpleHitResult,
) -> CrumpleResult {
    concurrent(call, context, |context| {
        let preview = effect == Effect::Preview;
        let out = if preview { Out::new(out, "out_result") } else { Out::optional(out, "out_result") }?;
        let hit = read()?;
        let bring = |inbox: &Inbox| if preview { inbox.preview(&hit) } else { inbox.submit(&hit) };
        let outcome = context.deliver(instance, bring)?;
        out.write((&outcome).into());
        Ok(())
    })
}

unsafe fn submit_all(
    call: &'static str,
    context: *const CrumpleContext,
    instances: *const CrumpleInstance,
    (defs, count): (*const c_void, u32),
    read: impl Fn(usize) -> Result<Hit, Failure>,
    out: *mut CrumpleHitResult,
) -> CrumpleResult {
    concurrent(call, context, |context| {
        let count = count as usize;
        if count == 0 {
            return Ok(());
        }
        let instances = array(instances, count, "instances")?;
        if defs.is_null() {
            return Err(Failure::null("defs"));
        }
        let _ = Out::optional(out, "out_results")?;
        let mut hits = Vec::new();
        for (i, instance) in instances.iter().enumerate() {
            let hit = read(i).map_err(|failure| failure.of_hit(i))?;
            if i == 0 {
                // The first hit was read before, so that a wrong count asks for no memory.
                hits = reserve(count, "hits")?;
            }
            hits.push((*instance, hit));
        }
        let outcomes = context.deliver_all(&hits)?;
        if !out.is_null() {
            outcomes.iter().enumerate().for_each(|(i, outcome)| out.add(i).write(outcome.into()));
        }
        Ok(())
    })
}
