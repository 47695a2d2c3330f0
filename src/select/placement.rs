//! Where an example goes for a hit: it stays where it was made, or it is carried to the contact.
//!
//! An anchored example can be neither deepened nor narrowed, so an automatic one stays only for hits at its own contact that
//! ask for its own depth, or where the set learned that its surroundings are better met by anchored examples.

use super::query::HitQuery;
use crate::example::candidates::{Candidate, OWN_PLACE};
use crate::example::data::Placement;
use crate::example::example::Example;
use crate::example::set::ExampleSet;

/// A hit asks for an example's own depth from this share below it up to rounding above it. (A tenth, as for the place; no
/// training impact lies that near another, so the value could not be fitted.)
const OWN_DEPTH: f32 = 0.1;

/// How a candidate may answer a hit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Choice {
    /// It does not reach the contact and cannot be carried there.
    Nowhere,
    /// Carried to the contact.
    Carried,
    /// Where it was made. Carried where it does not reach the contact, if `or_carried`.
    Anchored { or_carried: bool },
    /// Where it was made, as the only example of the mark: the hit repeats the example.
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

/// The one rule for where an example goes.
#[inline]
pub(crate) fn placement_for(set: &ExampleSet, candidate: &Candidate, hit: &HitQuery) -> Choice {
    let i = candidate.example as usize;
    let off = candidate.point - hit.point;
    let e = &set.examples()[i];
    if off.length_squared() > candidate.own_place_square {
        return if e.placement() == Placement::Anchored { Choice::Nowhere } else { Choice::Carried };
    }
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

/// Whether hit and set decide where the example goes.
pub(crate) fn is_automatic(e: &Example) -> bool {
    e.placement() == Placement::Automatic && e.stamp().is_some()
}
