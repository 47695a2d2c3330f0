//! Hits: what the physics engine reports.

use super::prelude::*;
use super::types::CrumpleStriker;
use crate::base::error::reserve;
use crate::damage::mark::Mark;
use crate::example::blow::Blow;
use crate::select::hit::{Cause, Hit, HitStatus, Outcome, Space};
use std::num::NonZeroU64;

/// How a hit is given.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(dead_code)] // made by C
pub enum CrumpleHitKind {
    /// As a blow: by its impulse, or by the mass and velocity of the striker. If the set has examples with blows
    /// (blow_count), it predicts the displacement of the contact: give as much of the blow as the engine knows. Otherwise
    /// the displacement is impulse * the instance's compliance, or impulse * duration / mass. The default.
    Blow = 0,
    /// As the displacement of the contact, for engines with their own impulse-to-depth mapping. The dent does not depend
    /// on the frame rate. The fields of blows are unused.
    Displacement = 1,
}

/// A hit. Report a blow once with its whole impulse, or as several hits with the same contact_id.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleHitDef {
    pub struct_size: u32,
    pub kind: MaybeUninit<CrumpleHitKind>,
    /// The space of point and of all vectors. Default CRUMPLE_SPACE_LOCAL.
    pub space: MaybeUninit<Space>,
    /// Where the body was hit, m. The nearest vertex becomes the contact.
    pub point: CrumpleVec3,
    /// For CRUMPLE_HIT_KIND_DISPLACEMENT: the target displacement of the contact, m.
    pub displacement: CrumpleVec3,
    /// The impulse on the body, N s. Default 0: striker.mass * striker.velocity. If that is 0 too, there is no mark.
    pub impulse: CrumpleVec3,
    /// How long the impulse acted, s: a constant of the material such as 0.01, not the time step. Required if the set's
    /// blow_count is 0 and the instance has no compliance.
    pub duration: f32,
    /// Mass of the contact vertex, kg, for impulse * duration / mass. Default 0: the set's mass for that vertex.
    pub mass: f32,
    /// Contact normal, out of the body, of any length. Default 0: unknown.
    pub normal: CrumpleVec3,
    pub striker: CrumpleStriker,
    /// The contact that the hit belongs to; see crumple_contacts.h. Default 0: none.
    pub contact_id: u64,
}

c_enums!(CrumpleHitKind::Displacement);
defs!(CrumpleHitDef);

/// The effect of a hit. If its status is not CRUMPLE_HIT_STATUS_MARKED, achieved, expected_error and mark are zero.
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
    /// Expected error of the dent relative to its size (L2): 0 exact, 1 as wrong as no dent. Where it is large, one more
    /// example helps.
    pub expected_error: f32,
    /// Whether the target was longer than the depth limit and was cut to it.
    pub clamped: bool,
    /// The mark. All zero if the hit leaves none.
    pub mark: Mark,
    pub reserved: [u32; 7],
}

impl From<&Outcome> for CrumpleHitResult {
    fn from(outcome: &Outcome) -> Self {
        CrumpleHitResult {
            status: MaybeUninit::new(outcome.status),
            contact_vertex: outcome.contact_vertex,
            contact_distance: outcome.contact_distance,
            target: outcome.target.into(),
            achieved: outcome.achieved.into(),
            clamped: outcome.clamped,
            mark: outcome.mark.unwrap_or(bytemuck::Zeroable::zeroed()),
            expected_error: outcome.expected_error.unwrap_or(0.0),
            reserved: [0; 7],
        }
    }
}

#[unsafe(no_mangle)]
pub extern "C" fn crumple_hit_def_default() -> CrumpleHitDef {
    zeroed()
}

/// Submits a hit. The call selects the examples. The next read of the damage applies the mark (see "Reads" at the top).
/// A hit that is too weak, or that no example fits, is not an error; see out_result->status. out_result may be null.
/// With a contact_id, it describes this hit alone. Any thread. Errors: CRUMPLE_ERROR_INVALID_ARGUMENT (a negative
/// duration, mass or radius; no duration, or no mass in def and set, where they are needed),
/// CRUMPLE_ERROR_CONTACT_TOO_FAR, CRUMPLE_ERROR_WRONG_RULE (a contact_id with a classic rule).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_submit_hit(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    def: *const CrumpleHitDef,
    out_result: *mut CrumpleHitResult,
) -> CrumpleResult {
    concurrent("crumple_instance_submit_hit", context, |context| {
        let (out, hit) = (Out::optional(out_result, "out_result")?, read_hit(def)?);
        let outcome = context.deliver(instance, |inbox| inbox.submit(&hit))?;
        out.answer((&outcome).into())
    })
}

/// Submits count hits, each to the instance at the same index: all, or none, and the message names the first wrong one.
/// out_results is null, or has room for count results. Otherwise like crumple_instance_submit_hit().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_context_submit_hits(
    context: *mut CrumpleContext,
    instances: *const CrumpleInstance,
    defs: *const CrumpleHitDef,
    count: u32,
    out_results: *mut CrumpleHitResult,
) -> CrumpleResult {
    concurrent("crumple_context_submit_hits", context, |context| {
        if count == 0 {
            return Ok(());
        }
        let instances = array(instances, count as usize, "instances")?;
        if defs.is_null() {
            return Err(Failure::null("defs"));
        }
        let _ = Out::optional(out_results, "out_results")?;
        let inboxes = context.inboxes();
        let mut prepared = Vec::new();
        for (i, instance) in instances.iter().enumerate() {
            let of_hit = |failure: Failure| Failure { message: format!("hit {i}: {}", failure.message), ..failure };
            let hit = read_hit(defs.wrapping_add(i)).map_err(of_hit)?;
            if i == 0 {
                // The first hit was read before, so that a wrong count asks for no memory.
                prepared = reserve(instances.len(), "hits")?;
            }
            let inbox = inboxes.get(*instance, &format!("instances[{i}]"))?;
            prepared.push((inbox, inbox.prepare(&hit).map_err(|error| of_hit(error.into()))?));
        }
        granted()?;
        for (i, (inbox, (outcome, pending))) in prepared.into_iter().enumerate() {
            inbox.queue_prepared(pending);
            if !out_results.is_null() {
                out_results.add(i).write((&outcome).into());
            }
        }
        Ok(())
    })
}

/// Returns what crumple_instance_submit_hit() would, without leaving a mark. out_result is required. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_preview_hit(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    def: *const CrumpleHitDef,
    out_result: *mut CrumpleHitResult,
) -> CrumpleResult {
    concurrent("crumple_instance_preview_hit", context, |context| {
        let (out, hit) = (Out::new(out_result, "out_result")?, read_hit(def)?);
        let outcome = context.deliver(instance, |inbox| inbox.preview(&hit))?;
        out.answer((&outcome).into())
    })
}

unsafe fn read_hit(def: *const CrumpleHitDef) -> Result<Hit, Failure> {
    let def = self::def(def, "def")?;
    let cause = match enumerator(def.kind, "def.kind")? {
        CrumpleHitKind::Blow => read_blow(&def)?,
        CrumpleHitKind::Displacement => Cause::Displacement(finite(def.displacement.array(), "def.displacement")?),
    };
    let (point, space) = (finite(def.point.array(), "def.point")?, enumerator(def.space, "def.space")?);
    Ok(Hit { point, cause, space, contact: NonZeroU64::new(def.contact_id) })
}

fn read_blow(def: &CrumpleHitDef) -> Result<Cause, Failure> {
    let mass = positive_or(def.mass, "def.mass", "kg", "that of the set")?;
    let impulse = finite(def.impulse.array(), "def.impulse")?;
    let [duration] = finite([def.duration], "def.duration")?;
    finite(def.normal.array(), "def.normal")?;
    let mut blow = Blow {
        impulse: def.impulse.known(),
        duration: (duration != 0.0).then_some(duration),
        normal: def.normal.known(),
        striker: def.striker.read("def.striker")?,
    };
    if blow.total_impulse().is_none() {
        // Zero: the hit is too weak, not wrong.
        blow.impulse = Some(impulse);
    }
    Ok(Cause::Impulse { blow, mass })
}
