//! Hits that belong together by a contact id, and what came of them.

use super::contacts::CrumpleContactReport;
use super::context::StepHit;
use super::hit::CrumpleHitResult;
use super::prelude::*;
use crate::base::error::reserve;
use crate::select::hit::{Cause, HitStatus};
use std::num::NonZeroU64;

/// A hit on an instance by the last step of contacts, for sounds, sparks and scores. If both bodies dent, each has one.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleContactHit {
    /// The pair whose points made the hit.
    pub pair: u64,
    /// The touch that the hit belongs to; see crumple_instance_get_contact().
    pub contact_id: u64,
    pub instance: CrumpleInstance,
    /// Where the instance was hit, m, in world space.
    pub point: CrumpleVec3,
    /// The impulse on the instance, N s, in world space.
    pub impulse: CrumpleVec3,
    /// The effect of this hit alone.
    pub result: CrumpleHitResult,
}

impl From<&StepHit> for CrumpleContactHit {
    fn from(StepHit { pair, instance, hit, outcome }: &StepHit) -> Self {
        let impulse = match &hit.cause {
            Cause::Impulse { blow, .. } => blow.impulse.unwrap_or_default(),
            Cause::Displacement(_) => [0.0; 3],
        };
        CrumpleContactHit {
            pair: *pair,
            contact_id: hit.contact.map_or(0, u64::from),
            instance: *instance,
            point: hit.point.into(),
            impulse: impulse.into(),
            result: outcome.into(),
        }
    }
}

/// Ends a contact. Its dent stays; later hits with the same id begin a new one. Contact ids are for engines that report one
/// contact as many small impulses and do not use crumple_context_report_contacts(). Give these hits the same contact_id,
/// any number but 0, and end the contact when the bodies separate. Together they make one dent, that of their sum at the
/// mean of their points, at any frame rate. Yield thresholds and depth limit apply to the sum. Contacts also end by
/// themselves: all when the damage is set, loaded, copied to the instance, repaired or reset, and the one hit longest ago
/// when more than 256 are open; ending them once more does nothing. Any thread. Errors: CRUMPLE_ERROR_UNKNOWN_CONTACT (no
/// hit has this id, or it was ended), CRUMPLE_ERROR_WRONG_RULE (a classic rule).
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

/// Returns the result of all hits of a contact taken as one. If the sum is too weak, the status is
/// CRUMPLE_HIT_STATUS_BELOW_YIELD. Errors: CRUMPLE_ERROR_UNKNOWN_CONTACT (the contact is neither open nor one of the 256
/// that ended last), CRUMPLE_ERROR_WRONG_RULE (a classic rule).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_get_contact(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    contact_id: u64,
    out_result: *mut CrumpleHitResult,
) -> CrumpleResult {
    exclusive("crumple_instance_get_contact", context, |_, state| {
        let (out, id) = (Out::new(out_result, "out_result")?, contact(contact_id)?);
        out.answer(match state.body(instance)?.contact(id)? {
            Some(outcome) => (&outcome).into(),
            // SAFETY: zeros are a value of every field.
            None => CrumpleHitResult {
                status: MaybeUninit::new(HitStatus::BelowYield),
                ..MaybeUninit::zeroed().assume_init()
            },
        })
    })
}

fn contact(id: u64) -> Result<NonZeroU64, Failure> {
    NonZeroU64::new(id)
        .ok_or_else(|| Failure::invalid("contact_id is 0; it must be the id that hits were given, not 0"))
}

/// Returns the hits of the last crumple_context_step_contacts(), at most as many as its report's hits, in no particular
/// order. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_context_get_contact_hits(
    context: *mut CrumpleContext,
    hits: *mut CrumpleContactHit,
    capacity: u32,
    out_count: *mut u32,
) -> CrumpleResult {
    concurrent("crumple_context_get_contact_hits", context, |context| {
        let out = Out::new(out_count, "out_count")?;
        let told = context.contact_hits();
        let mut found = reserve(told.len(), "hits")?;
        found.extend(told.iter().map(CrumpleContactHit::from));
        write_array(&found, hits, capacity as usize, "hits", out)
    })
}

/// Returns the sums of the reports of all steps; open is that of the last step. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_context_get_contact_totals(
    context: *mut CrumpleContext,
    out_report: *mut CrumpleContactReport,
) -> CrumpleResult {
    concurrent("crumple_context_get_contact_totals", context, |context| {
        Out::new(out_report, "out_report")?.answer((&context.contacts.totals()).into())
    })
}
