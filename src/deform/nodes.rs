//! The displacements of an instance's nodes, which its vertices follow ([`crate::basis`]).
//!
//! A node's displacement is the sum of those by all dents. Each dent contributes whole numbers of a tiny unit, so contributions can be
//! taken away again, and the sums have the same bits whatever happened before.

use super::view::{NodeSteps, NodeView};
use crate::base::math::nearest_whole;
use crate::basis::FREE;
use crate::basis::field::{NodeField, in_steps};
use crate::damage::list::Damage;
use crate::damage::mark::Mark;
use glam::{IVec3, Vec3};
use std::cmp::Ordering;
use std::sync::Arc;

/// The displacements of all nodes, as of the last update. Bodies that were never dented take no memory for them.
#[derive(Debug)]
pub(crate) struct NodeState {
    /// The number of nodes.
    count: usize,
    /// What the sums hold, sorted by mark.
    shown: Vec<Shown>,
    /// In units.
    sums: Vec<IVec3>,
    /// Of sums, m; a power of two.
    unit: f32,
    steps: Vec<NodeSteps>,
    /// m; a power of two.
    step: f32,
    /// The most that a dent contributes along an axis, in units, so that sums do not overflow.
    longest: f64,
    /// The depth limit of the last update, and the largest of any, m.
    limit: f32,
    most: f32,
    /// Whether an update changes the sum of each node.
    is_touched: Vec<bool>,
}

/// A dent that the sums hold.
#[derive(Debug)]
struct Shown {
    mark: Mark,
    field: Arc<NodeField>,
    factor: f32,
}

impl NodeState {
    /// As many nodes, none of them displaced, of a set with this depth limit (m), for at most so many dents.
    pub(crate) fn new(count: usize, own_limit: f32, dents: u32) -> Self {
        Self {
            count,
            shown: Vec::new(),
            sums: Vec::new(),
            unit: power(own_limit.clamp(LEAST, MOST_METRES)) * UNIT,
            steps: Vec::new(),
            step: 0.0,
            limit: 0.0,
            most: MOST_LIMITS * own_limit,
            longest: f64::from(i32::MAX / dents.max(1) as i32),
            is_touched: Vec::new(),
        }
    }

    pub(crate) fn view(&self) -> NodeView<'_> {
        NodeView { steps: &self.steps, step: self.step }
    }

    /// Shows the damage, with nodes that approach `limit` (m). Calls `changed` with the nodes whose steps changed.
    pub(crate) fn show(&mut self, damage: &Damage, limit: f32, mut changed: impl FnMut(u32)) {
        let limit = limit.min(self.most);
        if self.steps.is_empty() {
            if damage.dents().is_empty() {
                return;
            }
            self.sums.resize(self.count, IVec3::ZERO);
            self.steps.resize(self.count, [0; 4]);
            self.is_touched.resize(self.count, false);
        }
        let everything = self.limit != limit;
        if everything {
            self.is_touched.fill(true);
            (self.limit, self.step) = (limit, step(limit));
        }
        let before = std::mem::take(&mut self.shown);
        let mut old = before.iter().peekable();
        let dents = damage.marks().iter().zip(damage.dents());
        self.shown.reserve(dents.len());
        for (mark, dent) in dents {
            while let Some(gone) = old.next_if(|o| o.mark.key().cmp(&mark.key()) == Ordering::Less) {
                self.add(&gone.field, gone.factor, -1);
            }
            let (field, factor) = dent.field();
            match old.next_if(|o| o.mark.key() == mark.key()) {
                Some(same) if same.factor == factor && Arc::ptr_eq(&same.field, field) => {}
                other => {
                    if let Some(other) = other {
                        self.add(&other.field, other.factor, -1);
                    }
                    self.add(field, factor, 1);
                }
            }
            self.shown.push(Shown { mark: *mark, field: field.clone(), factor });
        }
        for gone in old {
            self.add(&gone.field, gone.factor, -1);
        }
        let (limit, step, unit) = (self.limit, self.step, self.unit);
        let nodes = self.is_touched.iter_mut().zip(&self.sums).zip(&mut self.steps);
        for (node, ((is_touched, sum), steps)) in (0..).zip(nodes).filter(|(_, ((is_touched, _), _))| **is_touched) {
            *is_touched = false;
            let moved = sum.as_vec3() * unit;
            let before = std::mem::replace(steps, with_length(in_steps(soft(moved, limit), step)));
            if before != *steps || everything && before != [0; 4] {
                changed(node);
            }
        }
    }

    /// Adds what a dent moves to the sums, or takes it away.
    fn add(&mut self, field: &NodeField, factor: f32, sign: i32) {
        // The same numbers whenever the same dent comes or goes.
        let (per_unit, longest) = (f64::from(factor) / f64::from(self.unit), self.longest);
        for (node, u) in field.moved() {
            let units = (u.as_dvec3() * per_unit).to_array().map(|x| nearest_whole(x.clamp(-longest, longest)));
            let at = node as usize;
            self.sums[at] += IVec3::from_array(units) * sign;
            self.is_touched[at] = true;
        }
    }

    /// Memory used, bytes. Fields are those of the damage.
    pub(crate) fn memory_bytes(&self) -> usize {
        self.shown.capacity() * size_of::<Shown>()
            + self.sums.capacity() * size_of::<IVec3>()
            + self.steps.capacity() * size_of::<NodeSteps>()
            + self.is_touched.capacity()
    }
}

/// The steps of a node with their length.
fn with_length([x, y, z]: [i16; 3]) -> NodeSteps {
    let length = Vec3::from([x, y, z].map(f32::from)).length();
    let below = length as u16;
    [x, y, z, (below + u16::from(f32::from(below) < length)) as i16]
}

/// Nodes move no further than this many times the set's own depth limit, whatever that of the instance: so that steps stay fine.
const MOST_LIMITS: f32 = 16.0;
/// The unit of sums, as a share of the set's depth limit.
const UNIT: f32 = 1.0 / (1u32 << 17) as f32;
/// Units and their inverses are floats for bodies of all sizes.
const LEAST: f32 = 1e-20;
const MOST_METRES: f32 = 1e20;

/// A displacement that approaches the depth limit instead of being cut to it, so that many dents leave no plateau: up to [`FREE`] of
/// the limit it is `u`, beyond it grows ever more slowly. Only IEEE operations.
fn soft(u: Vec3, limit: f32) -> Vec3 {
    let (length, free) = (u.length(), FREE * limit);
    // A length that overflows is cut.
    if length <= free || !length.is_finite() {
        return u;
    }
    let (rest, beyond) = (limit - free, length - free);
    u * ((free + rest * (beyond / (rest + beyond))) / length)
}

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
