//! The candidates nearest to a hit and their shares.

use super::kriging::{self, Axes, CANDIDATES};
use super::query::HitQuery;
use crate::base::array_vec::ArrayVec;
use crate::damage::mark::{MAX_PAIRS, Pair};
use crate::example::candidates::Candidate;
use crate::mesh::mirror::Mirror;

/// A candidate that can be used for a hit, with its distance from the hit.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Scored {
    /// Squared distance from the hit.
    distance: f32,
    example: u32,
    mirror: Mirror,
    anchored: bool,
    /// Its index in the set's list of candidates.
    index: u32,
}

impl Scored {
    /// Scores the candidate with index `index`. `None` if it cannot be used for the hit.
    #[inline]
    pub(crate) fn new(index: usize, candidate: &Candidate, anchored: bool, hit: &HitQuery) -> Option<Self> {
        let distance = kriging::distance(&hit.axes(candidate, anchored)?);
        Some(Scored { distance, example: candidate.example, mirror: candidate.mirror, anchored, index: index as u32 })
    }

    /// Orders by distance, then by example and mirror.
    pub(crate) fn order(&self, other: &Self) -> std::cmp::Ordering {
        let key = |s: &Self| (s.example, s.mirror);
        self.distance.total_cmp(&other.distance).then_with(|| key(self).cmp(&key(other)))
    }
}

/// The nearest candidates, sorted with the nearest first.
pub(crate) struct Shortlist(ArrayVec<Scored, CANDIDATES>);

impl Shortlist {
    pub(crate) fn new() -> Self {
        Shortlist(ArrayVec::new())
    }

    pub(crate) fn one(scored: Scored) -> Self {
        let mut one = Self::new();
        one.add(scored);
        one
    }

    pub(crate) fn add(&mut self, scored: Scored) {
        let after = self.0.iter().rev().take_while(|other| scored.order(other).is_lt()).count();
        self.0.insert(self.0.len() - after, scored);
    }

    /// Candidates with a greater squared distance cannot enter the list.
    pub(crate) fn limit(&self) -> f32 {
        self.0.get(CANDIDATES - 1).map_or(f32::INFINITY, |last| last.distance)
    }

    /// Chooses up to `k` of the candidates. Returns them with their shares of the dent, the largest share first.
    pub(crate) fn pairs(&self, k: usize, candidates: &[Candidate], hit: &HitQuery) -> [Pair; MAX_PAIRS] {
        let mut pairs = [Pair::NONE; MAX_PAIRS];
        let found = &self.0;
        let mut axes: ArrayVec<Axes, CANDIDATES> = ArrayVec::new();
        found.iter().filter_map(|c| hit.axes(&candidates[c.index as usize], c.anchored)).for_each(|a| axes.push(a));
        if axes.is_empty() {
            return pairs;
        }
        let mut chosen = kriging::choose(&axes, k);
        chosen.sort_unstable_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        let units = |w: f64| (w * f64::from(Pair::WHOLE)).round_ties_even() as i32;
        // The first share takes the rounding error, so that shares sum to the whole.
        let mut shares: ArrayVec<(usize, i32), MAX_PAIRS> = ArrayVec::new();
        chosen.iter().for_each(|(i, w)| shares.push((*i, units(*w))));
        shares[0].1 = i32::from(Pair::WHOLE) - shares[1..].iter().map(|s| s.1).sum::<i32>();
        if shares.iter().any(|s| !(-2048..2048).contains(&s.1)) {
            // The hit is far outside the range of the examples: use the first alone, because no mixture is better.
            shares.clear();
            shares.push((0, i32::from(Pair::WHOLE)));
        }
        for (slot, (i, share)) in pairs.iter_mut().zip(shares.iter().filter(|s| s.1 != 0)) {
            let c = &found[*i];
            *slot = if c.anchored {
                Pair::anchored(c.example as u16, *share as i16)
            } else {
                Pair::carried(c.example as u16, *share as i16, c.mirror)
            };
        }
        pairs
    }
}
