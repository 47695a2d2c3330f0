//! The paper's classic rule: Eq. 4.4-4.7, Figure 4.2 (selection) and Figure 4.3 (deformation).

use super::Model;
use super::vector::{V, add, dot, length, lerp, scale, sub};

/// Eq. 4.4: displacement (m) by an impulse (N s) with a duration (s) on a vertex with a mass (kg).
pub fn target_displacement(impulse: V, duration: f64, mass: f64) -> V {
    scale(duration / mass, impulse)
}

/// Eq. 4.5.
pub fn cosine(a: V, b: V) -> f64 {
    dot(a, b) / (length(a) * length(b))
}

/// Eq. 4.7.
pub fn blend_weight(needed: V, example: V) -> f64 {
    length(needed) / length(example)
}

/// Figure 4.2: the first example with the highest cosine among those that move `vertex`, and its weight.
pub fn choose(model: &Model, vertex: usize, target: V, clamp: bool) -> Option<(usize, f64)> {
    let mut best: Option<(usize, f64)> = None;
    for (i, example) in model.examples.iter().enumerate() {
        let d = example.deltas[vertex];
        if d == [0.0; 3] {
            continue;
        }
        let similarity = cosine(target, d);
        if best.is_none_or(|(_, s)| similarity > s) {
            best = Some((i, similarity));
        }
    }
    best.map(|(i, _)| {
        let w = blend_weight(target, model.examples[i].deltas[vertex]);
        (i, if clamp { w.min(1.0) } else { w })
    })
}

/// Figure 4.3: blends the position of every vertex that the example moves towards the example. `k` is the "fine
/// constant"; 0 keeps the most displaced.
pub fn deform(model: &Model, current: &mut [V], example: usize, weight: f64, k: f64) {
    for (v, d) in model.examples[example].deltas.iter().enumerate() {
        if *d == [0.0; 3] {
            continue;
        }
        let base = model.positions[v];
        let result = lerp(current[v], add(base, *d), weight);
        if length(sub(result, base)) >= length(sub(current[v], base)) {
            current[v] = result;
        } else {
            current[v] = lerp(current[v], result, k);
        }
    }
}
