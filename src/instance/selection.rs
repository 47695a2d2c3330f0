//! Decides what a hit leaves, as the instance's rule requires.

use super::options::Rule;
use crate::base::error::Error;
use crate::classic::select::select_by_cosine;
use crate::damage::mark::Mark;
use crate::damage::told::{Told, predicted};
use crate::example::set::ExampleSet;
use crate::select::hit::{Chosen, Hit, HitStatus, Outcome, Selection};
use crate::select::target::{HitParams, HitTarget, resolve};

/// What a hit leaves on the instance.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Effect {
    None,
    Mark(Mark),
    /// The classic rules: blends towards the example by the weight.
    Classic {
        example: u32,
        weight: f32,
    },
}

/// Turns a hit into its outcome and its effect.
pub(crate) fn select(set: &ExampleSet, rule: Rule, params: &HitParams, hit: &Hit) -> Result<(Outcome, Effect), Error> {
    let (mut outcome, target) = resolve(set, params, hit)?;
    let Some(target) = target else { return Ok((outcome, Effect::None)) };
    let effect = match rule {
        Rule::Marks => predict(set, &target, &mut outcome).map(Effect::Mark),
        Rule::MostDisplaced | Rule::Blend(_) => classic(set, &target, params.selection, &mut outcome),
    };
    Ok((outcome, effect.unwrap_or(Effect::None)))
}

/// The mark of a hit.
fn predict(set: &ExampleSet, target: &HitTarget, out: &mut Outcome) -> Option<Mark> {
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
    out.achieved = (moved * set.mesh().limits().factor(mark.contact, moved)).to_array();
    out.status = HitStatus::Marked;
    (out.mark, out.expected_error) = (Some(mark), Some(found.predicted.expected_error));
    Some(mark)
}

fn classic(set: &ExampleSet, target: &HitTarget, selection: Selection, out: &mut Outcome) -> Option<Effect> {
    let chosen = select_by_cosine(set, target, selection == Selection::Classic)?;
    let (example, weight) = (chosen.example, chosen.weight);
    out.classic = Some(Chosen { example, weight });
    let moved = chosen.delta * weight;
    out.achieved = (moved * set.mesh().limits().factor(target.contact, moved)).to_array();
    out.status = HitStatus::Marked;
    Some(Effect::Classic { example, weight })
}
