// Crumple: contact ids, which join hits to one dent, and the hits that contact points became.
//
// This file is generated from the library's source by `cargo xtask header`; do not edit it.

#ifndef CRUMPLE_CONTACTS_H
#define CRUMPLE_CONTACTS_H

#include "crumple.h"

/// A hit on an instance by the last step of contacts, for sounds, sparks and scores. If both bodies dent, each has one.
typedef struct CrumpleContactHit {
    /// The pair whose points made the hit.
    uint64_t pair;
    /// The touch that the hit belongs to; see crumple_instance_get_contact().
    uint64_t contact_id;
    CrumpleInstance instance;
    /// Where the instance was hit, m, in world space.
    CrumpleVec3 point;
    /// The impulse on the instance, N s, in world space.
    CrumpleVec3 impulse;
    /// The effect of this hit alone.
    CrumpleHitResult result;
} CrumpleContactHit;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/// Ends a contact. Its dent stays; later hits with the same id begin a new one. Contact ids are for engines that report one
/// contact as many small impulses and do not use crumple_context_report_contacts(). Give these hits the same contact_id,
/// any number but 0, and end the contact when the bodies separate. Together they make one dent, that of their sum at the
/// mean of their points, at any frame rate. Yield thresholds and depth limit apply to the sum. Contacts also end by
/// themselves: all when the damage is set, loaded, copied to the instance, repaired or reset, and the one hit longest ago
/// when more than 256 are open; ending them once more does nothing. Any thread. Errors: CRUMPLE_ERROR_UNKNOWN_CONTACT (no
/// hit has this id, or it was ended), CRUMPLE_ERROR_WRONG_RULE (a classic rule).
CrumpleResult crumple_instance_end_contact(CrumpleContext *context, CrumpleInstance instance, uint64_t contact_id);

/// Returns the result of all hits of a contact taken as one. If the sum is too weak, the status is
/// CRUMPLE_HIT_STATUS_BELOW_YIELD. Errors: CRUMPLE_ERROR_UNKNOWN_CONTACT (the contact is neither open nor one of the 256
/// that ended last), CRUMPLE_ERROR_WRONG_RULE (a classic rule).
CrumpleResult crumple_instance_get_contact(CrumpleContext *context, CrumpleInstance instance, uint64_t contact_id,
                                           CrumpleHitResult *out_result);

/// Returns the hits of the last crumple_context_step_contacts(), at most as many as its report's hits, in no particular
/// order. Any thread.
CrumpleResult crumple_context_get_contact_hits(CrumpleContext *context, CrumpleContactHit *hits, uint32_t capacity,
                                               uint32_t *out_count);

/// Returns the sums of the reports of all steps; open is that of the last step. Any thread.
CrumpleResult crumple_context_get_contact_totals(CrumpleContext *context, CrumpleContactReport *out_report);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* CRUMPLE_CONTACTS_H */
