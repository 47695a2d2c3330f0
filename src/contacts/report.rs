//! The results of a step of contacts.

use crate::base::error::Error;
use crate::instance::inbox::Inbox;
use crate::select::hit::{Hit, Outcome};
use std::sync::Arc;

/// A hit that a step of a [`ContactLayer`](crate::ContactLayer) brought to a body. Two bodies that dent get one each.
#[derive(Debug, Clone, Copy)]
pub struct ContactHit<'a> {
    /// The pair whose points made it.
    pub pair: u64,
    /// The inbox of the body.
    pub inbox: &'a Arc<Inbox>,
    /// The hit, in world space. Its contact is the touch, of which it is one step.
    pub hit: &'a Hit,
    /// Its effect alone; [`Instance::contact`](crate::Instance::contact) returns that of the touch.
    pub outcome: &'a Outcome,
}

/// What one step of a [`ContactLayer`](crate::ContactLayer) did. Counts are of this step, except for `open`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ContactReport {
    /// Points that were reported.
    pub points: u64,
    /// Hits that bodies got.
    pub hits: u64,
    /// Touches that began.
    pub begun: u64,
    /// Touches that ended.
    pub ended: u64,
    /// Touches that last.
    pub open: u64,
    /// Points on dentable bodies that approached too slowly: resting, rolling and sliding bodies.
    pub slow: u64,
    /// Points that pushed while the bodies separated. If all do so, the normal or the velocity points the wrong way.
    pub separating: u64,
    /// Touches that ended with too little energy for a dent.
    pub weak: u64,
    /// Touches that ended early because there were too many.
    pub crowded: u64,
    /// Hits that a body refused.
    pub refused: u64,
    /// Why it refused the first of them.
    pub refusal: Option<Error>,
}

impl ContactReport {
    /// Adds the counts of a step to sums.
    pub(super) fn add(&mut self, step: &Self) {
        self.points += step.points;
        self.hits += step.hits;
        self.begun += step.begun;
        self.ended += step.ended;
        self.open = step.open;
        self.slow += step.slow;
        self.separating += step.separating;
        self.weak += step.weak;
        self.crowded += step.crowded;
        self.refused += step.refused;
        if self.refusal.is_none() {
            self.refusal.clone_from(&step.refusal);
        }
    }
}
