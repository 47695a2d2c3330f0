//! Decides whether an example stays where it was made (anchored) or is carried to the contact.
//!
//! An anchored example can be neither deepened nor narrowed. An automatic example is therefore anchored only in two
//! cases: the hit is at its own contact and asks for its own depth, or the set learned that anchored examples predict
//! hits around it better.

use super::query::HitQuery;
use crate::example::candidates::{Candidate, OWN_PLACE};
use crate::example::data::Placement;
use crate::example::example::Example;
use crate::example::set::ExampleSet;

/// A hit asks for an example's own depth if it is at most this share below it and, up to rounding, not above it. The
/// value is a tenth, as for the place. It could not be fitted, because no training impact is that near another.
const OWN_DEPTH: f32 = 0.1;

/// How a candidate may be used for a hit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Choice {
    /// Not at all: it does not reach the contact and cannot be carried there.
    Nowhere,
    /// Carried to the contact.
    Carried,
    /// Anchored where it was made. If it does not reach the contact and `or_carried` is set, carried.
    Anchored { or_carried: bool },
    /// Anchored as the only example of the mark, because the hit repeats the example. `or_carried` as in `Anchored`.
    Alone { or_carried: bool },
}

impl Choice {
    /// Whether the example may stay where it was made.
    pub(crate) fn may_stay(self) -> bool {
        matches!(self, Choice::Anchored { .. } | Choice::Alone { .. })
    }

    /// Whether the example may be carried, if it cannot stay.
    pub(crate) fn may_carry(self) -> bool {
        match self {
            Choice::Nowhere => false,
            Choice::Carried => true,
            Choice::Anchored { or_carried } | Choice::Alone { or_carried } => or_carried,
        }
    }
}

/// The rule that decides how a candidate may be used for a hit. There is no other.
#[inline]
pub(crate) fn placement_for(set: &ExampleSet, candidate: &Candidate, hit: &HitQuery) -> Choice {
    let off = candidate.point - hit.point;
    if off.length_squared() > candidate.own_place_square {
        return if candidate.placement == Placement::Anchored { Choice::Nowhere } else { Choice::Carried };
    }
    let i = candidate.example as usize;
    let e = &set.examples()[i];
    let own_place = || off.length() <= OWN_PLACE * e.support_radius();
    let own_depth = || (1.0 - OWN_DEPTH..=1.001).contains(&(hit.size / e.depth()));
    let or_carried = is_automatic(e);
    match e.placement() {
        Placement::Anchored if own_place() => Choice::Alone { or_carried },
        Placement::Anchored => Choice::Anchored { or_carried },
        _ if or_carried && own_depth() && own_place() => Choice::Alone { or_carried },
        _ if or_carried && set.learned().anchored[i] => Choice::Anchored { or_carried },
        _ => Choice::Carried,
    }
}

/// Whether the hit and the set decide if the example is carried.
pub(crate) fn is_automatic(e: &Example) -> bool {
    e.placement() == Placement::Automatic && e.stamp().is_some()
}
