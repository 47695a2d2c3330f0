//! Selects examples for a hit as the instance's rule requires, and decides what the hit leaves.

use super::options::Rule;
use crate::base::error::Error;
use crate::classic::select::select_by_cosine;
use crate::damage::mark::Mark;
use crate::damage::told::{Told, predicted};
use crate::example::set::ExampleSet;
use crate::mesh::mirror::Mirror;
use crate::select::hit::{Chosen, Hit, HitStatus, Outcome, Selection};
use crate::select::nearest::select_nearest;
use crate::select::target::{HitParams, HitTarget, resolve};
use glam::Vec3;

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
        Rule::Marks if predicts(set, &target) => predict(set, &target, &mut outcome).map(Effect::Mark),
        Rule::Marks => select_nearest(set, params.examples_per_hit, &target, &mut outcome).map(Effect::Mark),
        Rule::MostDisplaced | Rule::Blend(_) => classic(set, &target, params.selection, &mut outcome),
    };
    Ok((outcome, effect.unwrap_or(Effect::None)))
}

/// Whether the set predicts hits like this one.
fn predicts(set: &ExampleSet, target: &HitTarget) -> bool {
    set.rule().is_some_and(|rule| target.told.is_some() || rule.predicts()[1] && target.strike.is_none())
}

/// The mark of a hit whose dent the set predicts.
fn predict(set: &ExampleSet, target: &HitTarget, out: &mut Outcome) -> Option<Mark> {
    let told = target.told.unwrap_or(Told::Displacement(target.direction));
    let mark =
        Mark { contact: target.contact, depth: target.size, energy: Mark::ONE, pairs: told.pairs(target.normal?) };
    let found = predicted(set, &mark)?;
    let moved = found.moved * found.scale;
    if moved == Vec3::ZERO {
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
    out.chosen[0] = Some(Chosen { example, share: 1.0, scale: weight, anchored: true, mirror: Mirror::NONE });
    let moved = chosen.delta * weight;
    out.achieved = (moved * set.mesh().limits().factor(target.contact, moved)).to_array();
    out.status = HitStatus::Marked;
    Some(Effect::Classic { example, weight })
}
