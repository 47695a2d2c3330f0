//! Where an example goes for a hit: it stays where it was made, or it is carried to the contact.
//!
//! An anchored example can be neither deepened nor narrowed, so an automatic one stays only for hits at its own contact that
//! ask for its own depth, or where the set learned that its surroundings are better met by anchored examples.

use super::query::HitQuery;
use crate::example::candidates::Candidate;
use crate::example::data::Placement;
use crate::example::example::Example;
use crate::example::set::ExampleSet;
use crate::mesh::mirror::Mirror;

/// A hit is at an example's own contact within this share of its support radius.
const OWN_PLACE: f32 = 0.1;
/// A hit asks for an example's own depth from this share below it up to rounding above it. (A tenth, as for the place; no
/// training impact lies that near another, so the value could not be fitted.)
const OWN_DEPTH: f32 = 0.1;

/// How a candidate may answer a hit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Choice {
    /// Carried to the contact.
    Carried,
    /// Where it was made. Carried where it does not reach the contact, if `or_carried`.
    Anchored { or_carried: bool },
    /// Where it was made, as the only example of the mark: the hit repeats the example.
    Alone { or_carried: bool },
}

/// The one rule for where an example goes.
pub(crate) fn placement_for(set: &ExampleSet, candidate: &Candidate, hit: &HitQuery) -> Choice {
    let i = candidate.example as usize;
    let e = &set.examples()[i];
    let own_place = || (e.contact_point() - hit.point).length() <= OWN_PLACE * e.support_radius();
    let own_depth = || (1.0 - OWN_DEPTH..=1.001).contains(&(hit.size / e.depth()));
    if candidate.mirror != Mirror::NONE {
        return Choice::Carried;
    }
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
