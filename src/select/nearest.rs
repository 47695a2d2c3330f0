//! The default selection: the examples that best predict a dent of the hit's place, depth and lean.

use super::hit::{Chosen, HitStatus, Outcome};
use super::kriging::CANDIDATES;
use super::placement::{Choice, placement_for};
use super::query::HitQuery;
use super::shortlist::{Scored, Shortlist};
use super::target::HitTarget;
use crate::damage::dent::{PlacedMark, frame_rotations, place};
use crate::damage::mark::{MAX_PAIRS, Mark, Pair};
use crate::example::candidates::{Candidate, LANES};
use crate::example::set::ExampleSet;
use glam::{BVec4A, Vec4};

/// Makes the mark of a hit from up to `k` examples, and writes its outcome. `None` if no example fits the hit.
pub(crate) fn select_nearest(set: &ExampleSet, k: usize, target: &HitTarget, out: &mut Outcome) -> Option<Mark> {
    let (placed, mark) = nearest_mark(set, k, target)?;
    Some(report(set, &placed, mark, out))
}

/// The mark of a hit from up to `k` examples, and how it is placed.
pub(crate) fn nearest_mark(set: &ExampleSet, k: usize, target: &HitTarget) -> Option<(PlacedMark, Mark)> {
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
    Some((placed, Mark::new(contact, depth, pairs)))
}

/// Groups of candidates whose bounds are computed before any candidate is looked at closely.
const GROUPS: usize = 64;

/// Steps of the bisection in [`nearly_smallest`]. After so many the result is at most 1.5 times too large.
const STEPS: usize = 9;

fn nearest_pairs(set: &ExampleSet, k: usize, hit: &HitQuery) -> [Pair; MAX_PAIRS] {
    let all = set.candidates().all();
    let mut search = Search { set, hit, shortlist: Shortlist::new(), alone: None };
    let chunks = all.chunks(GROUPS * LANES).enumerate().map(|(i, chunk)| (i * GROUPS * LANES, chunk));
    for (groups, chunk) in set.candidates().lanes().chunks(GROUPS).zip(chunks) {
        let mut bounds = [Vec4::INFINITY; GROUPS];
        bounds.iter_mut().zip(groups).for_each(|(bounds, group)| *bounds = hit.bounds(group));
        // Looks at the probable ones first. Few others can then still enter the list.
        let near = nearly_smallest(&bounds[..groups.len()], chunk.1.len()).min(search.shortlist.limit());
        search.look(chunk, &bounds, |b| b.cmple(Vec4::splat(near)));
        let limit = search.shortlist.limit();
        if limit > near {
            search.look(chunk, &bounds, |b| b.cmple(Vec4::splat(limit)) & b.cmpgt(Vec4::splat(near)));
        }
    }
    match search.alone {
        Some(own) => Shortlist::alone(own, all),
        None => search.shortlist.pairs(k, all),
    }
}

/// A value that about [`CANDIDATES`] bounds do not exceed. Infinite if there are no more than so many bounds.
fn nearly_smallest(bounds: &[Vec4], count: usize) -> f32 {
    if count <= CANDIDATES {
        return f32::INFINITY;
    }
    let below = |limit: f32| {
        let ones = |b: &Vec4| Vec4::select(b.cmple(Vec4::splat(limit)), Vec4::ONE, Vec4::ZERO);
        bounds.iter().map(ones).sum::<Vec4>().element_sum() as usize
    };
    // Bisection of the floats' bits, which sort like the floats.
    let (mut low, mut high) = (0u32, f32::INFINITY.to_bits());
    for _ in 0..STEPS {
        let middle = low.midpoint(high);
        if below(f32::from_bits(middle)) < CANDIDATES { low = middle } else { high = middle }
    }
    f32::from_bits(high)
}

/// The search for the candidates nearest to a hit.
struct Search<'a> {
    set: &'a ExampleSet,
    hit: &'a HitQuery<'a>,
    shortlist: Shortlist,
    /// The nearest of the examples that the hit repeats at their own contact. Such a hit gets the artist's dent and not
    /// a mixture.
    alone: Option<Scored>,
}

impl Search<'_> {
    /// Looks closely at the candidates of a chunk whose bounds are wanted. `first` is the index of the first of them.
    fn look(&mut self, (first, chunk): (usize, &[Candidate]), bounds: &[Vec4], wanted: impl Fn(Vec4) -> BVec4A) {
        for (at, bounds) in (0..chunk.len()).step_by(LANES).zip(bounds) {
            let mut lanes = wanted(*bounds).bitmask();
            while lanes != 0 {
                let i = at + lanes.trailing_zeros() as usize;
                lanes &= lanes - 1;
                if let Some(candidate) = chunk.get(i) {
                    self.look_at(first + i, candidate);
                }
            }
        }
    }

    fn look_at(&mut self, index: usize, candidate: &Candidate) {
        let Search { set, hit, shortlist, alone } = self;
        let choice = placement_for(set, candidate, hit);
        if choice.may_stay()
            && let Some(scored) = shortlist.score(index, candidate, true, hit)
        {
            if matches!(choice, Choice::Anchored { .. }) {
                shortlist.add(scored);
            } else if alone.is_none_or(|other| scored < other) {
                *alone = Some(scored);
            }
        } else if choice.may_carry()
            && let Some(scored) = shortlist.score(index, candidate, false, hit)
        {
            shortlist.add(scored);
        }
    }
}

/// Writes the mark, its examples and the displacement it achieves at its contact to the outcome.
pub(crate) fn report(set: &ExampleSet, placed: &PlacedMark, mark: Mark, out: &mut Outcome) -> Mark {
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
    out.achieved = (placed.achieved * set.mesh().limits().factor(mark.contact, placed.achieved)).to_array();
    out.status = HitStatus::Marked;
    out.mark = Some(mark);
    mark
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::tasks::Serial;
    use crate::example::data::{Contact, Deltas, ExampleData};
    use crate::example::options::SetOptions;
    use crate::mesh::data::MeshData;
    use glam::Vec3;

    /// A bumpy sheet of 50 x 50 vertices with small dents, each of another depth and lean.
    fn set(dents: u32) -> ExampleSet {
        let at = |v: u32| [(v % 50) as f32, (v / 50) as f32];
        let positions = (0..2500).map(at).map(|[x, y]| [x, y, (0.3 * x).sin() + (0.2 * y).cos()]).collect();
        let corner = (0..2450).filter(|v| v % 50 < 49);
        let triangles = corner.flat_map(|v| [[v, v + 1, v + 50], [v + 50, v + 1, v + 51]]).collect();
        let dent = |i: u32| {
            let contact = 51 + 50 * (i * 7 % 47) + i * 11 % 47;
            let d = [0.01 * (i % 5) as f32, 0.02 * (i % 3) as f32, -0.5 - 0.01 * i as f32];
            let deltas = Deltas::Sparse { indices: vec![contact, contact + 1], values: vec![d, d.map(|x| 0.5 * x)] };
            ExampleData { contact: Some(Contact::Vertex(contact)), ..ExampleData::new("dent", deltas) }
        };
        let mesh = MeshData { positions, triangles, ..Default::default() };
        let options = SetOptions { stamp_resolution: 4, ..SetOptions::default() };
        ExampleSet::build(mesh, (0..dents).map(dent).collect(), options, &Serial).unwrap()
    }

    #[test]
    fn bounds_leave_out_no_candidate_that_counts() {
        for dents in [5, 13, 300] {
            let set = set(dents);
            let all = set.candidates().all();
            for contact in (0..2500).step_by(97) {
                let direction = Vec3::new(0.03, 0.01 * (contact % 4) as f32, -1.0).normalize();
                let normal = set.mesh().contact_normal(contact);
                let target = HitTarget { contact, normal, direction, size: 0.7, strike: None, told: None };
                let hit = HitQuery::new(&set, &target, 1.3);
                let mut search = Search { set: &set, hit: &hit, shortlist: Shortlist::new(), alone: None };
                all.iter().enumerate().for_each(|(i, c)| search.look_at(i, c));
                let found = nearest_pairs(&set, 3, &hit);
                assert!(!found[0].is_none());
                if search.alone.is_none() {
                    assert_eq!(found, search.shortlist.pairs(3, all), "{dents} {contact}");
                }
            }
        }
    }
}
