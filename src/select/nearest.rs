//! The default selection: the examples that best predict a dent of the hit's place, depth and lean.

use super::hit::{Chosen, HitStatus, Outcome};
use super::placement::{Choice, placement_for};
use super::query::HitQuery;
use super::shortlist::{Scored, Shortlist};
use super::target::HitTarget;
use crate::damage::dent::{PlacedMark, frame_rotations, place};
use crate::damage::mark::{MAX_PAIRS, Mark, Pair};
use crate::example::candidates::LANES;
use crate::example::set::ExampleSet;

/// Makes the mark of a hit from up to `k` examples. `None` if no example fits the hit.
pub(crate) fn select_nearest(set: &ExampleSet, k: usize, target: &HitTarget, out: &mut Outcome) -> Option<Mark> {
    let HitTarget { contact, direction, size, .. } = *target;
    let pairs = nearest_pairs(set, k, &HitQuery::new(set, target, set.learned().place_width));
    if pairs[0].is_none() {
        return None;
    }
    // The depth is the target's component along the dent's direction at the contact. Of a blow only the depth is
    // predicted well enough to be kept.
    let rotations = frame_rotations(set, contact, &pairs);
    let placed = place(set, contact, size, &pairs, &rotations);
    let along = placed.without_rim.length();
    let depth = if along > 0.0 { (direction * size).dot(placed.without_rim / along) } else { 0.0 };
    // Keeps the exact size if the target lies along the dent up to rounding.
    let keep = target.strike.is_some() || (depth - size).abs() <= 1e-6 * size;
    let depth = if keep { size } else { depth };
    if depth.is_nan() || depth <= 0.0 {
        return None;
    }
    let placed = if depth == size { placed } else { place(set, contact, depth, &pairs, &rotations) };
    Some(report(&placed, Mark::new(contact, depth, pairs), out))
}

fn nearest_pairs(set: &ExampleSet, k: usize, hit: &HitQuery) -> [Pair; MAX_PAIRS] {
    let mut shortlist = Shortlist::new();
    let mut alone: Option<Scored> = None;
    let candidates = set.candidates().all();
    for (g, lanes) in set.candidates().lanes().iter().enumerate() {
        let Some(bounds) = hit.bounds(lanes, shortlist.limit()) else { continue };
        for (i, bound) in (g * LANES..candidates.len()).zip(bounds.to_array()) {
            if bound > shortlist.limit() {
                continue;
            }
            let candidate = &candidates[i];
            let choice = placement_for(set, candidate, hit);
            if choice.may_stay()
                && let Some(scored) = Scored::new(i, candidate, true, hit)
            {
                if matches!(choice, Choice::Anchored { .. }) {
                    shortlist.add(scored);
                } else if alone.is_none_or(|other| scored.order(&other).is_lt()) {
                    // The hit repeats an example at its own contact, so it gets the artist's dent and not a mixture.
                    alone = Some(scored);
                }
            } else if choice.may_carry()
                && let Some(scored) = Scored::new(i, candidate, false, hit)
            {
                shortlist.add(scored);
            }
        }
    }
    match alone {
        Some(own) => Shortlist::one(own).pairs(1, candidates, hit),
        None => shortlist.pairs(k, candidates, hit),
    }
}

/// Writes the mark, its examples and the displacement it achieves at its contact to the outcome.
pub(crate) fn report(placed: &PlacedMark, mark: Mark, out: &mut Outcome) -> Mark {
    let used = mark.pairs.iter().filter(|p| !p.is_none());
    for (slot, (pair, part)) in out.chosen.iter_mut().zip(used.zip(&placed.parts)) {
        *slot = Some(Chosen {
            example: u32::from(pair.example),
            share: pair.share_fraction(),
            scale: part.scale,
            anchored: pair.is_anchored(),
            mirror: pair.mirror(),
        });
    }
    out.achieved = placed.achieved.to_array();
    out.status = HitStatus::Marked;
    out.mark = Some(mark);
    mark
}
