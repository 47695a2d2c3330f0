//! The options of an instance.

use super::hit::Selection;
use crate::base::error::{Error, at_least_zero, positive};

/// What an impulse leaves on an instance.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Rule {
    /// Marks: bounded, local, independent of order, without per-vertex state.
    #[default]
    Marks,
    /// The classic rule: each vertex keeps the most displaced candidate.
    MostDisplaced,
    /// The classic rule with blending: a vertex that is already displaced further blends by this constant, 0 to 1.
    Blend(f32),
}

impl Rule {
    /// Fails for a classic rule. `call` is what needs marks.
    pub(crate) fn only_marks(self, call: &str) -> Result<(), Error> {
        let rule = match self {
            Rule::Marks => return Ok(()),
            Rule::MostDisplaced => "MostDisplaced",
            Rule::Blend(_) => "Blend",
        };
        Err(Error::WrongRule { call: call.into(), needed: "the rule Marks".into(), rule: rule.into() })
    }
}

/// The options of an instance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InstanceOptions {
    /// What an impulse leaves.
    pub rule: Rule,
    /// How a classic rule chooses an example. The default is that of the paper's Figure 4.2; the other is for comparison.
    pub selection: Selection,
    /// The furthest that any vertex moves, m. `None`: the set's limit.
    pub depth_limit: Option<f32>,
    /// The most marks kept, 1 to 65535. Beyond it marks merge (see [`crate::Instance::marks`]).
    pub capacity: u32,
    /// Impulses shorter than this leave no mark, N·s.
    pub yield_impulse: f32,
    /// Target displacements shorter than this leave no mark, m.
    pub yield_displacement: f32,
    /// How far a blow of 1 N·s moves its contact, m per N·s, if no example of the set knows its blow; above 0. The
    /// duration and mass of impulses are then unused. `None`: `duration / mass` of each impulse.
    pub compliance: Option<f32>,
    /// The largest distance from a contact to the nearest vertex, m; contacts further away are refused. `None`: the
    /// body's diagonal.
    pub max_contact_distance: Option<f32>,
    /// How long a dent takes to appear, to deepen or to be repaired, s; 0: no time. See [`crate::Instance::set_time`].
    pub grow_time: f32,
}

impl Default for InstanceOptions {
    fn default() -> Self {
        Self {
            rule: Rule::Marks,
            selection: Selection::Classic,
            depth_limit: None,
            capacity: 64,
            yield_impulse: 0.0,
            yield_displacement: 0.0,
            compliance: None,
            max_contact_distance: None,
            grow_time: 0.0,
        }
    }
}

impl InstanceOptions {
    /// Default options for a classic rule.
    pub fn classic(rule: Rule) -> Self {
        Self { rule, ..Self::default() }
    }

    pub(crate) fn check(&self) -> Result<(), Error> {
        at_least_zero("yield_impulse", self.yield_impulse, "N·s")?;
        at_least_zero("yield_displacement", self.yield_displacement, "m")?;
        if let Some(c) = self.compliance {
            positive("compliance", c, "m per N·s")?;
        }
        if let Some(d) = self.max_contact_distance {
            at_least_zero("max_contact_distance", d, "m")?;
        }
        check_limit(self.depth_limit)?;
        at_least_zero("grow_time", self.grow_time, "s")?;
        if self.grow_time > 0.0 && self.rule != Rule::Marks {
            return Err(Error::invalid("grow_time", self.grow_time, "0 with a classic rule"));
        }
        if !(1..=65535).contains(&self.capacity) {
            return Err(Error::invalid("capacity", self.capacity, "1 to 65535 marks"));
        }
        if let Rule::Blend(k) = self.rule
            && !(0.0..=1.0).contains(&k)
        {
            return Err(Error::invalid("the blend constant", k, "0 to 1"));
        }
        if self.rule == Rule::Marks && self.selection == Selection::ClassicUnclamped {
            return Err(Error::invalid(
                "selection",
                "ClassicUnclamped",
                "Classic with the rule Marks, which is bounded",
            ));
        }
        Ok(())
    }
}

pub(crate) fn check_limit(limit: Option<f32>) -> Result<(), Error> {
    match limit {
        Some(l) if !(l > 0.0 && l <= 1e9) => Err(Error::invalid("depth_limit", l, "above 0 and at most 1e9 m")),
        _ => Ok(()),
    }
}
