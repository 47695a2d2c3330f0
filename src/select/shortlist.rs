//! The candidates nearest to a hit and their shares.

use super::kriging::{self, Axes, CANDIDATES};
use super::query::HitQuery;
use crate::base::array_vec::ArrayVec;
use crate::damage::mark::{MAX_PAIRS, Pair};
use crate::example::candidates::Candidate;

/// A candidate that can be used for a hit. Orders by distance from the hit, then by place in the set's list of
/// candidates, which is sorted by example and mirror.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Scored(u64);

impl Scored {
    /// `distance` is the squared distance, `index` the place in the list, `slot` where a [`Shortlist`] has the axes.
    fn new(distance: f32, index: usize, anchored: bool, slot: usize) -> Self {
        // Floats that are not negative sort like their bits.
        Scored(u64::from(distance.to_bits()) << 32 | (index as u64) << 5 | u64::from(anchored) << 4 | slot as u64)
    }

    fn distance(self) -> f32 {
        f32::from_bits((self.0 >> 32) as u32)
    }

    fn index(self) -> usize {
        (self.0 as u32 >> 5) as usize
    }

    fn anchored(self) -> bool {
        self.0 >> 4 & 1 == 1
    }

    fn slot(self) -> usize {
        (self.0 & 15) as usize
    }
}

/// The nearest candidates, sorted with the nearest first.
pub(crate) struct Shortlist {
    sorted: ArrayVec<Scored, CANDIDATES>,
    /// The candidates' axes, in any order. One more than there are candidates, so that one is always free.
    axes: [Axes; CANDIDATES + 1],
    free: usize,
}

impl Shortlist {
    pub(crate) fn new() -> Self {
        Shortlist { sorted: ArrayVec::new(), axes: [Axes::default(); CANDIDATES + 1], free: 0 }
    }

    /// Scores the candidate with index `index` without adding it. `None` if it cannot be used for the hit.
    #[inline]
    pub(crate) fn score(
        &mut self,
        index: usize,
        candidate: &Candidate,
        anchored: bool,
        hit: &HitQuery,
    ) -> Option<Scored> {
        self.axes[self.free] = hit.axes(candidate, anchored)?;
        Some(Scored::new(kriging::distance(&self.axes[self.free]), index, anchored, self.free))
    }

    /// Adds what [`Shortlist::score`] returned last.
    #[inline]
    pub(crate) fn add(&mut self, scored: Scored) {
        let after = self.sorted.iter().rev().take_while(|other| scored < **other).count();
        let full = self.sorted.get(CANDIDATES - 1).copied();
        self.sorted.insert(self.sorted.len() - after, scored);
        self.free = match full {
            Some(_) if after == 0 => self.free,
            Some(dropped) => dropped.slot(),
            None => self.sorted.len(),
        };
    }

    /// The pairs of a mark that has this candidate alone.
    pub(crate) fn alone(scored: Scored, candidates: &[Candidate]) -> [Pair; MAX_PAIRS] {
        let mut pairs = [Pair::NONE; MAX_PAIRS];
        pairs[0] = pair(scored, i32::from(Pair::WHOLE), candidates);
        pairs
    }

    /// Candidates with a greater squared distance cannot enter the list.
    pub(crate) fn limit(&self) -> f32 {
        self.sorted.get(CANDIDATES - 1).map_or(f32::INFINITY, |last| last.distance())
    }

    /// Chooses up to `k` of the candidates. Returns them with their shares of the dent, the largest share first.
    pub(crate) fn pairs(&self, k: usize, candidates: &[Candidate]) -> [Pair; MAX_PAIRS] {
        let mut pairs = [Pair::NONE; MAX_PAIRS];
        let found = &self.sorted;
        if found.is_empty() {
            return pairs;
        }
        let mut chosen = kriging::choose(found.iter().map(|c| &self.axes[c.slot()]), k);
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
            *slot = pair(found[*i], *share, candidates);
        }
        pairs
    }
}

/// The pair of a candidate that has a share of the dent, in units of 1/[`Pair::WHOLE`].
fn pair(scored: Scored, share: i32, candidates: &[Candidate]) -> Pair {
    let c = &candidates[scored.index()];
    if scored.anchored() {
        Pair::anchored(c.example as u16, share as i16)
    } else {
        Pair::carried(c.example as u16, share as i16, c.mirror)
    }
}
