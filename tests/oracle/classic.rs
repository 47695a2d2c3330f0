//! The paper's classic rule: Eq. 4.4-4.7, Figure 4.2 (selection) and Figure 4.3 (deformation).

use crumple::glam::DVec3;

use super::Model;

/// Eq. 4.4: displacement (m) by an impulse (N s) with a duration (s) on a vertex with a mass (kg).
pub fn target_displacement(impulse: DVec3, duration: f64, mass: f64) -> DVec3 {
    impulse * (duration / mass)
}

/// Eq. 4.5.
pub fn cosine(a: DVec3, b: DVec3) -> f64 {
    a.dot(b) / (a.length() * b.length())
}

/// Eq. 4.7.
pub fn blend_weight(needed: DVec3, example: DVec3) -> f64 {
    needed.length() / example.length()
}

/// Figure 4.2: the first example with the highest cosine among those that move `vertex`, and its weight.
pub fn choose(model: &Model, vertex: usize, target: DVec3, clamp: bool) -> Option<(usize, f64)> {
    let mut best: Option<(usize, f64)> = None;
    for (i, example) in model.examples.iter().enumerate() {
        let d = example.deltas[vertex];
        if d == DVec3::ZERO {
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
pub fn deform(model: &Model, current: &mut [DVec3], example: usize, weight: f64, k: f64) {
    for (v, d) in model.examples[example].deltas.iter().enumerate() {
        if *d == DVec3::ZERO {
            continue;
        }
        let base = model.positions[v];
        let result = current[v].lerp(base + *d, weight);
        if result.distance(base) >= current[v].distance(base) {
            current[v] = result;
        } else {
            current[v] = current[v].lerp(result, k);
        }
    }
}
