//! How the classic rule chooses its example: Figure 4.2 of the paper.

use crate::example::set::ExampleSet;
use crate::select::target::Target;
use glam::Vec3;

/// An example and the weight that it is blended with.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Weighted {
    pub example: u32,
    pub weight: f32,
    /// Displacement of the contact that the example alone brings, m, before the weight.
    pub delta: Vec3,
}

/// Of the examples that move the contact, the one with the best cosine similarity (Eq. 4.5). Its weight is target over example
/// displacement (Eq. 4.7).
pub(crate) fn select_by_cosine(set: &ExampleSet, target: &Target, clamp: bool) -> Option<Weighted> {
    let mut best: Option<(f32, usize, Vec3)> = None;
    for (i, e) in set.examples().iter().enumerate() {
        let d = e.delta(target.contact);
        let length = d.length();
        if length > 0.0 {
            let cos = d.dot(target.direction) / length;
            if best.is_none_or(|b| cos > b.0) {
                best = Some((cos, i, d));
            }
        }
    }
    let (_, example, delta) = best?;
    let weight = target.size / delta.length();
    Some(Weighted { example: example as u32, weight: if clamp { weight.min(1.0) } else { weight }, delta })
}
