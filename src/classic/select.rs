//! How the classic rule chooses an example: Figure 4.2 of the paper.

use crate::example::set::ExampleSet;
use crate::select::target::HitTarget;
use glam::Vec3;

/// An example and its blend weight.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Weighted {
    pub example: u32,
    pub weight: f32,
    /// Displacement of the contact by the example before weighting, m.
    pub delta: Vec3,
}

/// Selects the example with the best cosine similarity (Eq. 4.5) among those that move the contact. Its weight is the
/// length of the target over that of the example's displacement (Eq. 4.7), at most 1 if `clamp`.
pub(crate) fn select_by_cosine(set: &ExampleSet, target: &HitTarget, clamp: bool) -> Option<Weighted> {
    let mut best: Option<(f32, usize, Vec3)> = None;
    for (i, whole) in set.base_lod().anchored.iter().enumerate() {
        let d = whole.delta(target.contact);
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
