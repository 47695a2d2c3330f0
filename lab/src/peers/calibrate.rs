//! Chooses rapier's material on training impacts: its model knows no modulus of a sheet and no yield stress, so what makes
//! its dents most like the truth's is searched.

use super::rapier::{Material, Quality, hit};
use super::sheet::{Sheet, field_error};
use crate::metric::median;
use crate::truth::Body;

/// Lowest and highest of each quantity searched, log scale: edge and bend frequency in Hz, yield, shape frequency in Hz
/// (below 1 it is left out).
type Range = [[f64; 2]; 4];

const WHOLE: Range = [[30.0, 1e5], [3.0, 1e4], [3e-4, 0.1], [0.1, 100.0]];

/// The best of `samples` spread over the whole range, then of a third as many around the best.
pub fn search(bodies: &[Body], quality: Quality, hits: usize, samples: usize) -> (Material, f64) {
    let best = best_of(bodies, quality, hits, samples, WHOLE);
    let refined = around(bodies, quality, hits, samples.div_ceil(3), best.0);
    if refined.1 < best.1 { refined } else { best }
}

/// The best of `samples` around one that is good.
pub fn around(bodies: &[Body], quality: Quality, hits: usize, samples: usize, m: Material) -> (Material, f64) {
    let near = |x: f32, factor: f64| [f64::from(x) / factor, f64::from(x) * factor];
    let shape = if m.shape_hz == 0.0 { [0.1, 1.0] } else { near(m.shape_hz, 3.0) };
    let range = [near(m.edge_hz, 3.0), near(m.bend_hz, 3.0), near(m.plastic_yield, 2.0), shape];
    best_of(bodies, quality, hits, samples, range)
}

fn best_of(bodies: &[Body], quality: Quality, hits: usize, samples: usize, range: Range) -> (Material, f64) {
    let mut best: Option<(Material, f64)> = None;
    for k in 0..samples {
        let material = sample(k, range);
        let cost = cost(bodies, quality, hits, material);
        if best.is_none_or(|(_, least)| cost < least) {
            println!("{k:4} {cost:.4} {material:?}");
            best = Some((material, cost));
        }
    }
    best.expect("at least one sample")
}

/// The k-th point of an additive recurrence that fills four dimensions evenly.
fn sample(k: usize, range: Range) -> Material {
    // The positive root of x^5 = x + 1: its powers are the steps.
    const ROOT: f64 = 1.167_303_978_261_418_7;
    let at = |dimension: usize| {
        let share = (0.5 + k as f64 * ROOT.powi(-(dimension as i32 + 1))).fract();
        let [low, high] = range[dimension];
        (low.ln() + share * (high / low).ln()).exp() as f32
    };
    let shape_hz = at(3);
    Material {
        edge_hz: at(0),
        bend_hz: at(1),
        plastic_yield: at(2),
        shape_hz: if shape_hz < 1.0 { 0.0 } else { shape_hz },
    }
}

/// Mean over the bodies of the median error as is and the median error after scaling, on the first training impacts.
pub fn cost(bodies: &[Body], quality: Quality, hits: usize, material: Material) -> f64 {
    let of_body = |body: &Body| {
        let sheet = Sheet::new(body, quality.stride);
        let dents = body.train.iter().filter(|i| i.depth() > 0.005).take(hits);
        let errors: Vec<_> = dents
            .map(|i| {
                let outcome = hit(&sheet, i, material, quality);
                field_error(&sheet.at_truth(&outcome.field), &i.field, i.contact_vertex as usize)
            })
            .collect();
        let as_is: Vec<f64> = errors.iter().map(|e| e.relative_l2).collect();
        let scaled: Vec<f64> = errors.iter().map(|e| e.scaled_relative_l2).collect();
        0.5 * (median(&as_is) + median(&scaled))
    };
    bodies.iter().map(of_body).sum::<f64>() / bodies.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_fill_the_range() {
        let materials: Vec<Material> = (0..64).map(|k| sample(k, WHOLE)).collect();
        assert!(materials.iter().all(|m| (30.0..=1e5).contains(&m.edge_hz) && (3e-4..=0.1).contains(&m.plastic_yield)));
        let soft = materials.iter().filter(|m| m.edge_hz < 1.7e3).count();
        let bare = materials.iter().filter(|m| m.shape_hz == 0.0).count();
        assert!((28..=36).contains(&soft) && (17..=26).contains(&bare), "{soft} {bare}");
    }
}
