//! Hits: what the physics engine reports.

use super::check::{CEnum, Def, MadeBy, Out, boolean, def, enumerator, finite};
use super::context::{Context, CrumpleContext, CrumpleLogLevel, concurrent};
use super::damage::CrumpleMark;
use super::recording::{Call, Number, hit_digest};
use super::result::{CrumpleResult, Failure};
use super::types::{CrumpleInstance, CrumpleVec3};
use crate::{Cause, Error, Hit, HitStatus, Inbox, Outcome, Space};
use std::mem::MaybeUninit;
use std::num::NonZeroU64;
use std::sync::PoisonError;

/// The space a hit is given in.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CrumpleSpace {
    /// The mesh's own. The default.
    Local = 0,
    /// The world's: through the instance's transform.
    World = 1,
}

impl CEnum for CrumpleSpace {
    const ALL: &'static [Self] = &[Self::Local, Self::World];
}

/// A hit by an impulse. The contact is displaced by impulse * duration / mass. Let duration be a constant of the
/// material, never the time step, and report a contact once, with its whole impulse, or in parts with a contact_id:
/// then dents do not depend on the frame rate.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleImpulseDef {
    /// Bytes of this struct, from crumple_impulse_def_default().
    pub struct_size: u32,
    /// The space of point and impulse. Default CRUMPLE_SPACE_LOCAL.
    pub space: MaybeUninit<CrumpleSpace>,
    /// Where it hit, m; its nearest vertex is the contact.
    pub point: CrumpleVec3,
    /// The impulse that the body received, N s.
    pub impulse: CrumpleVec3,
    /// How long it acted, s; above 0: a constant of the material, say 0.01, not the time step. Default 0: set it.
    pub duration: f32,
    /// Mass of the contact vertex, kg. 0: that of the set. Default 0.
    pub mass: f32,
    /// Which contact it is part of, any number of your own; hits of one contact make one dent, see
    /// crumple_instance_end_contact(). 0: none, a hit of its own. Default 0.
    pub contact_id: u64,
    /// Only tell what the hit would do, and leave nothing. Default false.
    pub preview: MaybeUninit<bool>,
}

/// A hit that should displace its contact so far: for engines with a mapping of their own. Free of the frame rate.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleDisplacementDef {
    /// Bytes of this struct, from crumple_displacement_def_default().
    pub struct_size: u32,
    /// The space of point and displacement. Default CRUMPLE_SPACE_LOCAL.
    pub space: MaybeUninit<CrumpleSpace>,
    /// Where it hit, m; its nearest vertex is the contact.
    pub point: CrumpleVec3,
    /// How far the contact should move, m.
    pub displacement: CrumpleVec3,
    /// Which contact it is part of, as in CrumpleImpulseDef. Default 0.
    pub contact_id: u64,
    /// Only tell what the hit would do, and leave nothing. Default false.
    pub preview: MaybeUninit<bool>,
}

// SAFETY: `repr(C)`, starts with its size, and any bytes are a value of it.
unsafe impl Def for CrumpleImpulseDef {
    const DEFAULT: MadeBy<Self> = ("crumple_impulse_def_default", crumple_impulse_def_default);
}

// SAFETY: as above.
unsafe impl Def for CrumpleDisplacementDef {
    const DEFAULT: MadeBy<Self> = ("crumple_displacement_def_default", crumple_displacement_def_default);
}

/// What became of a hit.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CrumpleHitStatus {
    /// It leaves a mark (with the literature's rules: a deformation).
    Marked = 0,
    /// It is weaker than the instance's yield threshold, or next to nothing.
    BelowYield = 1,
    /// No example moves the contact in the direction asked for.
    NothingReaches = 2,
}

impl CEnum for CrumpleHitStatus {
    const ALL: &'static [Self] = &[Self::Marked, Self::BelowYield, Self::NothingReaches];
}

/// An example that a hit is made of.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CrumpleChosen {
    /// Its index in the set.
    pub example: u32,
    /// Its share of the dent; the shares of a hit sum to 1. Negative where it corrects others that overshoot.
    pub share: f32,
    /// What its displacements are multiplied with.
    pub scale: f32,
    /// Whether it stays where it was made; otherwise it is carried to the contact.
    pub anchored: bool,
    /// The planes that it is mirrored in: 1 for x, 2 for y, 4 for z, added up.
    pub mirror: u8,
}

/// What a hit was turned into, and what of it could not be met.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleHitResult {
    /// What became of it.
    pub status: MaybeUninit<CrumpleHitStatus>,
    /// The vertex nearest to the point.
    pub contact_vertex: u32,
    /// Its distance from the point, m.
    pub contact_distance: f32,
    /// Displacement asked for at the contact, m, in the mesh's space.
    pub target: CrumpleVec3,
    /// Displacement that this hit alone brings there, m, in the mesh's space.
    pub achieved: CrumpleVec3,
    /// Number of chosen examples.
    pub chosen_count: u32,
    /// Whether the target was longer than the depth limit and was cut to it.
    pub clamped: bool,
    /// The examples, the weightiest first.
    pub chosen: [CrumpleChosen; 4],
    /// The mark it leaves; zero everywhere where it leaves none.
    pub mark: CrumpleMark,
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
            };
            chosen_count += 1;
        }
        CrumpleHitResult {
            status: MaybeUninit::new(match outcome.status {
                HitStatus::Marked => CrumpleHitStatus::Marked,
                HitStatus::BelowYield => CrumpleHitStatus::BelowYield,
                HitStatus::NothingReaches => CrumpleHitStatus::NothingReaches,
            }),
            contact_vertex: outcome.contact_vertex,
            contact_distance: outcome.contact_distance,
            target: outcome.target.into(),
            achieved: outcome.achieved.into(),
            chosen_count,
            clamped: outcome.clamped,
            chosen,
            mark: outcome.mark.map(bytemuck::cast).unwrap_or_default(),
        }
    }
}

/// An impulse of nothing, in the mesh's space; set its point, impulse and duration. Never fails; any thread.
#[unsafe(no_mangle)]
pub extern "C" fn crumple_impulse_def_default() -> CrumpleImpulseDef {
    CrumpleImpulseDef {
        struct_size: size_of::<CrumpleImpulseDef>() as u32,
        space: MaybeUninit::new(CrumpleSpace::Local),
        point: CrumpleVec3::default(),
        impulse: CrumpleVec3::default(),
        duration: 0.0,
        mass: 0.0,
        contact_id: 0,
        preview: MaybeUninit::new(false),
    }
}

/// A displacement of nothing, in the mesh's space; set its point and displacement. Never fails; any thread.
#[unsafe(no_mangle)]
pub extern "C" fn crumple_displacement_def_default() -> CrumpleDisplacementDef {
    CrumpleDisplacementDef {
        struct_size: size_of::<CrumpleDisplacementDef>() as u32,
        space: MaybeUninit::new(CrumpleSpace::Local),
        point: CrumpleVec3::default(),
        displacement: CrumpleVec3::default(),
        contact_id: 0,
        preview: MaybeUninit::new(false),
    }
}

/// Reports an impulse. Its examples are chosen at once; the mark it makes counts from the next call that reads damage
/// (crumple_context_deform(), crumple_instance_get_marks() and so on), whatever the order and the threads hits came from. A hit that
/// is too weak, or that no example answers, is no error: see status. out_result may be null. With a contact_id it
/// tells what the hit would do alone; see crumple_instance_end_contact() for what it does with the contact's other hits.
///
/// May be called from any thread at any time, also while other threads submit or deform; not while the instance or
/// the context is being destroyed. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED,
/// CRUMPLE_ERROR_STRUCT_SIZE, CRUMPLE_ERROR_INVALID_ID, CRUMPLE_ERROR_NOT_FINITE, CRUMPLE_ERROR_INVALID_ARGUMENT (a
/// duration not above 0, a negative mass, or none known), CRUMPLE_ERROR_CONTACT_TOO_FAR (the point is further from
/// the body than the instance accepts), CRUMPLE_ERROR_WRONG_RULE (a contact_id with one of the literature's rules,
/// which cannot replace what they have deformed), CRUMPLE_ERROR_OUT_OF_MEMORY. Nothing is left behind then.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_submit_impulse(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    def: *const CrumpleImpulseDef,
    out_result: *mut CrumpleHitResult,
) -> CrumpleResult {
    let read = || {
        // SAFETY: the caller's.
        let def = unsafe { self::def(def, "def") }?;
        let mass = finite([def.mass], "def.mass")?[0];
        if mass < 0.0 {
            return Err(Failure::invalid(format!(
                "def.mass is {mass} kg; it must be positive, or 0 for that of the set"
            )));
        }
        let cause = Cause::Impulse {
            impulse: finite(def.impulse.array(), "def.impulse")?,
            duration: finite([def.duration], "def.duration")?[0],
            mass: (mass > 0.0).then_some(mass),
        };
        Ok((hit(def.point, def.space, def.contact_id, cause)?, boolean(def.preview)))
    };
    // SAFETY: the caller's.
    unsafe { submit("crumple_instance_submit_impulse", context, instance, read, out_result) }
}

/// Reports a hit that should displace its contact so far. As crumple_instance_submit_impulse() in every other respect, its
/// threads and errors too.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_submit_displacement(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    def: *const CrumpleDisplacementDef,
    out_result: *mut CrumpleHitResult,
) -> CrumpleResult {
    let read = || {
        // SAFETY: the caller's.
        let def = unsafe { self::def(def, "def") }?;
        let cause = Cause::Displacement(finite(def.displacement.array(), "def.displacement")?);
        Ok((hit(def.point, def.space, def.contact_id, cause)?, boolean(def.preview)))
    };
    // SAFETY: the caller's.
    unsafe { submit("crumple_instance_submit_displacement", context, instance, read, out_result) }
}

/// Ends a contact of an instance: its dent stays as it is, and later hits with the same id begin another one.
///
/// A physics engine that reports one contact as many small impulses, one a step, gives all of them the same contact_id
/// (of its own choice, one for each contact point and touch, not 0) and ends the contact when the bodies part. They
/// make the one dent that the whole impulse in one report would have made, at any frame rate: while the contact is
/// open, displacements (impulse * duration / mass) add, the point is the mean of their points, weighted by the lengths
/// of their displacements, yield thresholds and depth limit hold for the sum, and the contact's one mark is replaced
/// as more hits come.
///
/// Counts from the next call that reads damage on, after all hits that have arrived by then: use an id again only after
/// that. An id that is not open is no error. Contacts also end when the instance's damage is set, loaded, copied
/// into, repaired or reset, and when more than 256 are open: the one hit longest ago ends then (of equals the lowest
/// id).
///
/// May be called from any thread at any time, as crumple_instance_submit_impulse(). Errors: CRUMPLE_ERROR_NULL_POINTER,
/// CRUMPLE_ERROR_INVALID_ID, CRUMPLE_ERROR_INVALID_ARGUMENT (contact_id is 0), CRUMPLE_ERROR_WRONG_RULE (one of the
/// literature's rules), CRUMPLE_ERROR_OUT_OF_MEMORY.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_end_contact(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    contact_id: u64,
) -> CrumpleResult {
    concurrent("crumple_instance_end_contact", context, |context| {
        let id = NonZeroU64::new(contact_id)
            .ok_or_else(|| Failure::invalid("contact_id is 0; it must be the id that hits were given, not 0"))?;
        let call = || Call::EndContact { instance: Number::of(instance), contact_id };
        deliver(context, instance, call, |inbox| inbox.end_contact(id), |()| 0)
    })
}

fn hit(point: CrumpleVec3, space: MaybeUninit<CrumpleSpace>, contact_id: u64, cause: Cause) -> Result<Hit, Failure> {
    let space = match enumerator(space, "def.space")? {
        CrumpleSpace::Local => Space::Local,
        CrumpleSpace::World => Space::World,
    };
    Ok(Hit { point: finite(point.array(), "def.point")?, cause, space, contact: NonZeroU64::new(contact_id) })
}

/// # Safety
/// `out` is null or points to a writable result.
unsafe fn submit(
    call: &'static str,
    context: *const CrumpleContext,
    instance: CrumpleInstance,
    read: impl FnOnce() -> Result<(Hit, bool), Failure>,
    out: *mut CrumpleHitResult,
) -> CrumpleResult {
    concurrent(call, context, |context| {
        // SAFETY: the caller's.
        let out = unsafe { Out::optional(out, "out_result") }?;
        let (hit, preview) = read()?;
        let call = || recorded_hit(instance, &hit, preview);
        let bring = |inbox: &Inbox| if preview { inbox.preview(&hit) } else { inbox.submit(&hit) };
        let outcome = deliver(context, instance, call, bring, |o| hit_digest(&o.into()))?;
        out.write((&outcome).into());
        Ok(())
    })
}

/// Brings something to an instance's inbox; what `call` makes of it, and the number that stands for what it gave, go into a
/// recording.
fn deliver<T>(
    context: &Context,
    instance: CrumpleInstance,
    call: impl FnOnce() -> Call,
    bring: impl FnOnce(&Inbox) -> Result<T, Error>,
    number: impl FnOnce(&T) -> u64,
) -> Result<T, Failure> {
    loop {
        let log = context.recorder.hit();
        let inboxes = context.inboxes.read().unwrap_or_else(PoisonError::into_inner);
        if log.is_none() && context.recorder.is_on() {
            continue; // it began just now
        }
        let inbox = inboxes.get(instance, "instance")?;
        let Some(mut log) = log else { return Ok(bring(inbox)?) };
        log.call(call());
        let given = bring(inbox).map_err(Failure::from);
        let trouble = match &given {
            Ok(given) => log.ended(CrumpleResult::CrumpleOk, number(given)),
            Err(failure) => log.ended(failure.result, 0),
        };
        drop(inboxes);
        if let Some(trouble) = trouble {
            context.log(CrumpleLogLevel::Warning, &trouble);
        }
        return given;
    }
}

fn recorded_hit(instance: CrumpleInstance, hit: &Hit, preview: bool) -> Call {
    let space = match hit.space {
        Space::Local => CrumpleSpace::Local,
        Space::World => CrumpleSpace::World,
    } as u32;
    let (instance, point, contact_id) = (Number::of(instance), hit.point, hit.contact.map_or(0, NonZeroU64::get));
    match hit.cause {
        Cause::Impulse { impulse, duration, mass } => {
            let mass = mass.unwrap_or(0.0);
            Call::Impulse { instance, space, point, impulse, duration, mass, contact_id, preview }
        }
        Cause::Displacement(displacement) => {
            Call::Displacement { instance, space, point, displacement, contact_id, preview }
        }
    }
}
