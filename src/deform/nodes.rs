//! The displacements of an instance's nodes, which its vertices follow ([`crate::basis`]).
//!
//! A node's displacement is the sum of those by all dents. Each dent contributes whole numbers of a tiny unit, so contributions can be
//! taken away again, and the sums have the same bits whatever happened before.

use super::view::{NodeSteps, NodeView};
use crate::base::math::{MOST_WHOLE, small_whole};
use crate::base::simd::{Work, widest};
use crate::basis::field::{GROUP, MOST, NodeField};
use crate::damage::dent::Dent;
use crate::damage::list::{Damage, walk};
use crate::damage::mark::Mark;
use std::sync::Arc;

/// The share of the depth limit up to which nodes move freely. Beyond it they approach the limit.
const FREE: f32 = 0.75;

/// The displacements of all nodes, as of the last update. Bodies that were never dented take no memory for them.
#[derive(Debug)]
pub(crate) struct NodeState {
    /// The number of nodes.
    count: usize,
    /// The marks whose dents the sums hold, and of each its field with what that is multiplied by.
    marks: Vec<Mark>,
    shown: Vec<(Arc<NodeField>, f32)>,
    /// In units, of each group of [`GROUP`] nodes: along x, y and z.
    sums: Vec<[[i32; GROUP]; 3]>,
    /// Of sums, m; a power of two.
    unit: f32,
    steps: Vec<NodeSteps>,
    /// m; a power of two.
    step: f32,
    /// The longest of `steps`.
    farthest: u16,
    /// The most that a dent contributes along an axis, in units, so that sums do not overflow.
    longest: f32,
    /// The depth limit of the last update, and the largest of any, m.
    limit: f32,
    most: f32,
    /// Whether an update changes the sums of each group.
    is_touched: Vec<bool>,
}

impl NodeState {
    /// As many nodes, none of them displaced, of a set with this depth limit (m), for at most so many dents.
    pub(crate) fn new(count: usize, own_limit: f32, dents: u32) -> Self {
        Self {
            count,
            marks: Vec::new(),
            shown: Vec::new(),
            sums: Vec::new(),
            unit: power(own_limit.clamp(LEAST, MOST_METRES)) * UNIT,
            steps: Vec::new(),
            step: 0.0,
            farthest: 0,
            limit: 0.0,
            most: MOST_LIMITS * own_limit,
            longest: (i32::MAX / dents.max(1) as i32).min(MOST_WHOLE) as f32,
            is_touched: Vec::new(),
        }
    }

    pub(crate) fn view(&self) -> NodeView<'_> {
        NodeView { steps: &self.steps, step: self.step, farthest: self.farthest }
    }

    /// Shows the damage, with nodes that approach `limit` (m). Calls `changed` with each group whose steps changed, and a bit for each node of
    /// it that did.
    pub(crate) fn show(&mut self, damage: &Damage, limit: f32, mut changed: impl FnMut(usize, u32)) {
        let limit = limit.min(self.most);
        if self.steps.is_empty() {
            if damage.dents().is_empty() {
                return;
            }
            let groups = self.count.div_ceil(GROUP);
            self.sums.resize(groups, [[0; GROUP]; 3]);
            self.steps.resize(self.count, [0; 4]);
            self.is_touched.resize(groups, false);
        }
        let everything = self.limit != limit;
        if everything {
            self.is_touched.fill(true);
            (self.limit, self.step) = (limit, step(limit));
        }
        let (before, shown) = (std::mem::take(&mut self.marks), std::mem::take(&mut self.shown));
        walk(&before, damage.marks(), |_, old, new| {
            let old = old.map(|at| &shown[at]);
            let new = new.map(|at| damage.dents()[at].field());
            match (old, new) {
                (Some((field, from)), Some((same, to))) if Arc::ptr_eq(field, same) => self.add(field, [*from, to]),
                _ => {
                    old.into_iter().for_each(|(field, factor)| self.add(field, [*factor, 0.0]));
                    new.into_iter().for_each(|(field, factor)| self.add(field, [0.0, factor]));
                }
            }
        });
        self.marks.extend_from_slice(damage.marks());
        self.shown.extend(damage.dents().iter().map(Dent::field).map(|(field, factor)| (field.clone(), factor)));
        let (limit, step, unit) = (self.limit, self.step, self.unit);
        let groups = self.is_touched.iter_mut().zip(&self.sums).zip(self.steps.chunks_mut(GROUP));
        for (group, ((is_touched, sums), steps)) in groups.enumerate() {
            if std::mem::take(is_touched) {
                let nodes = widest(Stepping { sums, unit, limit, step, steps, everything });
                if nodes != 0 {
                    changed(group, nodes);
                }
            }
        }
        self.farthest = self.steps.iter().map(|n| n[3] as u16).max().unwrap_or(0);
    }

    /// Changes what a dent adds to the sums from a factor of its field to another.
    fn add(&mut self, field: &NodeField, factors: [f32; 2]) {
        if factors[0] == factors[1] {
            return;
        }
        let per_step = factors.map(|factor| (factor * (field.step() / self.unit)).clamp(f32::MIN, f32::MAX));
        for (group, moves) in field.groups() {
            let group = group as usize;
            widest(Adding { sums: &mut self.sums[group], moves, per_step, longest: self.longest });
            self.is_touched[group] = true;
        }
    }

    /// Memory used, bytes. Fields are those of the damage.
    pub(crate) fn memory_bytes(&self) -> usize {
        self.marks.capacity() * size_of::<Mark>()
            + self.shown.capacity() * size_of::<(Arc<NodeField>, f32)>()
            + self.sums.capacity() * size_of::<[[i32; GROUP]; 3]>()
            + self.steps.capacity() * size_of::<NodeSteps>()
            + self.is_touched.capacity()
    }
}

/// Adds a field of a group's nodes in units, times the second factor, and takes it away times the first.
struct Adding<'a> {
    sums: &'a mut [[i32; GROUP]; 3],
    moves: &'a [[i16; GROUP]; 3],
    per_step: [f32; 2],
    longest: f32,
}

impl Work for Adding<'_> {
    type Done = ();

    #[inline(always)]
    fn run(self) {
        let (longest, [from, to]) = (self.longest, self.per_step);
        // The same numbers whenever the same dent comes or goes.
        let units = |x: i16, per_step: f32| small_whole((f32::from(x) * per_step).clamp(-longest, longest));
        for (sums, moves) in self.sums.iter_mut().zip(self.moves) {
            for (sum, x) in sums.iter_mut().zip(moves) {
                *sum += units(*x, to) - units(*x, from);
            }
        }
    }
}

/// Sets the steps of a group's nodes, which approach the depth limit instead of being cut to it, so that many dents leave no
/// plateau: up to [`FREE`] of the limit they are the sums, beyond it they grow ever more slowly. Only IEEE operations.
/// Returns a bit for each node whose steps changed; for each that moves or moved, with `everything`.
struct Stepping<'a> {
    sums: &'a [[i32; GROUP]; 3],
    unit: f32,
    limit: f32,
    step: f32,
    steps: &'a mut [NodeSteps],
    everything: bool,
}

impl Work for Stepping<'_> {
    type Done = u32;

    #[inline(always)]
    fn run(self) -> u32 {
        let Stepping { sums: [x, y, z], unit, limit, step, steps, everything } = self;
        let (free, rest) = (FREE * limit, limit - FREE * limit);
        let mut now = [[0i16; GROUP]; 4];
        let [to_x, to_y, to_z, to_length] = &mut now;
        let whole = |x: f32| small_whole((x / step).clamp(-MOST, MOST));
        for i in 0..GROUP {
            let (x, y, z) = (x[i] as f32 * unit, y[i] as f32 * unit, z[i] as f32 * unit);
            let length = (x * x + y * y + z * z).sqrt();
            let beyond = length - free;
            let shorter = (free + rest * (beyond / (rest + beyond))) / length;
            // A length that overflows is cut.
            let factor = if (length > free) & (length < f32::INFINITY) { shorter } else { 1.0 };
            let (x, y, z) = (whole(x * factor), whole(y * factor), whole(z * factor));
            (to_x[i], to_y[i], to_z[i]) = (x as i16, y as i16, z as i16);
            let (x, y, z) = (x as f32, y as f32, z as f32);
            let length = (x * x + y * y + z * z).sqrt();
            let near = small_whole(length);
            to_length[i] = (near + i32::from((near as f32) < length)) as i16;
        }
        let mut changed = 0;
        for (i, steps) in steps.iter_mut().enumerate().take(GROUP) {
            let now = [now[0][i], now[1][i], now[2][i], now[3][i]];
            let before = std::mem::replace(steps, now);
            changed |= u32::from(before != now || everything && before != [0; 4]) << i;
        }
        changed
    }
}

/// Nodes move no further than this many times the set's own depth limit, whatever that of the instance: so that steps stay fine.
const MOST_LIMITS: f32 = 16.0;
/// The unit of sums, as a share of the set's depth limit.
const UNIT: f32 = 1.0 / (1u32 << 17) as f32;
/// Units and their inverses are floats for bodies of all sizes.
const LEAST: f32 = 1e-20;
const MOST_METRES: f32 = 1e20;

/// The step for displacements up to `limit`, m: a power of two.
fn step(limit: f32) -> f32 {
    let least = (limit / 32000.0).clamp(f32::MIN_POSITIVE, 1e30);
    let below = power(least);
    if below < least { 2.0 * below } else { below }
}

/// The greatest power of two that is not above a number.
fn power(x: f32) -> f32 {
    f32::from_bits(x.to_bits() & 0x7F80_0000)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_is_the_least_power_of_two_that_holds_the_limit() {
        for limit in [1e-6, 0.03, 0.25, 1.0, 77.0] {
            let step = step(limit);
            assert_eq!(step.to_bits() & 0x007F_FFFF, 0);
            assert!(limit / step <= 32000.0 && limit / step > 15999.0, "{limit} {step}");
        }
    }
}
