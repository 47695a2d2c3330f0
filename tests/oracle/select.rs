//! The default selection: the K examples nearest in place, size and angle, kernel-weighted, scaled together to the target.

use crumple::Placement;

use super::marks::{Mark, Part, met};
use super::vector::{V, apply, dot, length, rotation_between, scale, sub};
use super::{Example, Model};

/// Documented kernel widths: place as a share of the body's diagonal, size in natural logarithms of depth, angle as one minus the cosine.
const PLACE: f64 = 0.25;
const SIZE: f64 = 0.6;
const ANGLE: f64 = 0.3;
/// An automatic example is anchored within this share of its support radius around its own contact; anchored ones answer alone there.
const WITHIN: f64 = 0.1;
/// An automatic example is anchored there only for targets of about its own depth.
const OWN_SIZE: (f64, f64) = (0.9, 1.001);
/// An anchored example reaches the vertices that it displaces by at least this share of its own contact's displacement.
const REACH: f64 = 0.1;

/// A candidate and its squared kernel distance.
#[derive(Debug, Clone, Copy)]
pub struct Candidate {
    pub example: usize,
    pub anchored: bool,
    pub q: f64,
}

/// What the oracle would do with a hit.
#[derive(Debug, Clone)]
pub struct Selected {
    pub mark: Mark,
    pub met: V,
    /// Some decision (a threshold, a rank) was so close that rounding may turn it.
    pub close: bool,
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-4 * (1.0 + b.abs())
}

/// Squared kernel distance; `None` where the example cannot answer. `close` is set where a threshold is near.
fn distance(
    model: &Model,
    e: &Example,
    anchored: bool,
    contact: usize,
    target: V,
    limit: f64,
    close: &mut bool,
) -> Option<f64> {
    if e.depth() < 1e-6 * limit {
        return None;
    }
    let there = if anchored {
        e.deltas[contact]
    } else {
        let r = rotation_between(e.contact_normal, model.contact_normals[contact]);
        apply(r, e.deltas[e.contact_vertex])
    };
    *close |= anchored && near(length(there) / e.depth(), REACH);
    if anchored && (length(there) < REACH * e.depth() || length(there) == 0.0) {
        return None;
    }
    let cos = dot(there, target) / (length(there) * length(target));
    *close |= near(cos, 1e-3);
    if cos <= 1e-3 {
        return None;
    }
    let place = length(sub(e.contact_point, model.positions[contact])) / (PLACE * model.diagonal);
    let size = (e.depth() / length(target)).ln() / SIZE;
    let angle = (1.0 - cos) / ANGLE;
    Some(place * place + size * size + angle * angle)
}

/// The mark of a hit at vertex `contact`, or `None` where nothing reaches. `target` may be longer than `limit`; it is cut to it first.
pub fn select(model: &Model, contact: usize, target: V, limit: f64, k: usize) -> (Option<Selected>, bool) {
    let target = scale((limit / length(target)).min(1.0), target);
    let mut close = false;
    let (mut own, mut others): (Vec<Candidate>, Vec<Candidate>) = (Vec::new(), Vec::new());
    for (i, e) in model.examples.iter().enumerate() {
        let away = length(sub(e.contact_point, model.positions[contact]));
        close |= near(away, WITHIN * e.support_radius) && away > 0.0;
        let within = away <= WITHIN * e.support_radius;
        let ratio = length(target) / e.depth();
        let own_size = (OWN_SIZE.0..=OWN_SIZE.1).contains(&ratio);
        close |= e.placement == Placement::Automatic && (near(ratio, OWN_SIZE.0) || near(ratio, OWN_SIZE.1));
        let anchored = match e.placement {
            Placement::Anchored => true,
            Placement::Carried => false,
            Placement::Automatic => within && own_size,
        };
        if let Some(q) = distance(model, e, anchored, contact, target, limit, &mut close) {
            let list = if anchored && within { &mut own } else { &mut others };
            list.push(Candidate { example: i, anchored, q });
        }
    }
    let alone = !own.is_empty();
    let mut list = if alone { own } else { others };
    list.sort_by(|a, b| a.q.total_cmp(&b.q).then(a.example.cmp(&b.example)));
    let k = if alone { 1 } else { k };
    for pair in list.windows(2).take(k) {
        close |= near(pair[0].q, pair[1].q);
    }
    list.truncate(k);
    let Some(first) = list.first().copied() else { return (None, close) };
    let weights: Vec<f64> = list.iter().map(|c| (-0.5 * (c.q - first.q)).exp()).collect();
    let total: f64 = weights.iter().sum();
    let mut parts: Vec<Part> = Vec::new();
    let mut rest = 32767.0;
    for (c, w) in list.iter().zip(&weights).skip(1) {
        let share = (w / total * 32767.0).floor();
        if share > 0.0 {
            parts.push(Part { example: c.example, share: share / 32767.0, anchored: c.anchored });
            rest -= share;
        }
    }
    parts.insert(0, Part { example: first.example, share: rest / 32767.0, anchored: first.anchored });
    // The dent has its own direction at the contact: of the target it meets the component along it.
    let mut mark = Mark { contact, depth: length(target), strength: 1.0, parts };
    let brings = met(model, &mark);
    if length(brings) == 0.0 {
        return (None, close);
    }
    mark.depth = dot(target, brings) / length(brings);
    close |= mark.depth.abs() < 1e-4 * length(target);
    if mark.depth <= 0.0 {
        return (None, close);
    }
    let met = met(model, &mark);
    (Some(Selected { mark, met, close }), close)
}
