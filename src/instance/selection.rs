//! Decides what a hit leaves, as the instance's rule requires.

use crate::base::error::Error;
use crate::classic::select_by_cosine;
use crate::damage::mark::Mark;
use crate::damage::told::predicted;
use crate::example::set::ExampleSet;
use crate::predict::Told;
use crate::select::hit::{Hit, HitStatus, Outcome, Selection};
use crate::select::options::Rule;
use crate::select::target::{HitParams, HitTarget, resolve};
use glam::Vec3;

/// Turns a hit into its outcome, which has what it leaves.
pub(crate) fn select(set: &ExampleSet, params: &HitParams, hit: &Hit) -> Result<Outcome, Error> {
    let (mut outcome, target) = resolve(set, params, hit)?;
    let Some(target) = target else { return Ok(outcome) };
    let moved = match params.options.rule {
        Rule::Marks => predict(set, &target, &mut outcome),
        Rule::MostDisplaced | Rule::Blend(_) => {
            let chosen = select_by_cosine(set, &target, params.options.selection == Selection::Classic);
            chosen.map(|(chosen, delta)| {
                outcome.classic = Some(chosen);
                delta * chosen.weight
            })
        }
    };
    if let Some(moved) = moved {
        outcome.achieved = (moved * set.mesh().limits().factor(target.contact, moved)).to_array();
        outcome.status = HitStatus::Marked;
    }
    Ok(outcome)
}

/// Makes the mark of a hit. Returns how far it moves the contact, m; `None` if it leaves nothing.
fn predict(set: &ExampleSet, target: &HitTarget, out: &mut Outcome) -> Option<Vec3> {
    let mark = Mark::new(target.contact, target.size, &target.told, target.normal);
    let found = predicted(set, &mark);
    let moved = found.moved * found.scale;
    let nothing = match target.told {
        // Examples that push tell nothing of a pull.
        Told::Displacement(_) => moved.dot(target.direction) <= 1e-3 * moved.length(),
        Told::Strike(_) => found.predicted.depth == 0.0,
    };
    if nothing {
        return None;
    }
    (out.mark, out.expected_error) = (Some(mark), Some(found.predicted.expected_error));
    Some(moved)
}
