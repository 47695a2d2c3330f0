//! What a set learns by leaving out each example and predicting it from the others. Naive: every width and every sum is
//! computed separately.

use crumple::Placement;

use super::Model;
use super::marks::{Mark, Part, example_at, scales};
use super::select::{Asked, answers, candidate, image};
use super::vector::{V, add, apply, length, rotation_between, scale, sub};

pub const WIDTHS: [f64; 3] = [1.3, 0.5, 0.2];

/// Error of a prediction, and whether it is certain that rounding did not change it.
#[derive(Debug, Clone, Copy)]
pub struct Answer {
    pub error: Option<f64>,
    pub sure: bool,
}

/// Whether two examples have the same depth and lean in some mirror image, wherever they are.
fn copies(model: &Model, a: usize, b: usize, close: &mut bool) -> bool {
    if model.examples[a].depth() == 0.0 || model.examples[b].depth() == 0.0 {
        return false;
    }
    let own = image(model, a, 0);
    (0..8u8).filter(|m| m & !model.planes == 0).any(|m| {
        let other = image(model, b, m);
        let turned = apply(rotation_between(other.normal, own.normal), other.lean);
        let depth = (model.examples[a].depth() / model.examples[b].depth()).ln().abs();
        let lean = length(sub(turned, own.lean));
        *close |= (depth < 1.01e-3 && (lean - 2e-3).abs() < 2e-5) || (lean < 2.02e-3 && (depth - 1e-3).abs() < 1e-5);
        depth <= 1e-3 && lean <= 2e-3
    })
}

/// The contact, and every n-th vertex within one and a half support radii, with n such that there are at most 384.
fn samples(model: &Model, q: usize, close: &mut bool) -> Vec<usize> {
    let e = &model.examples[q];
    let radius = 1.5 * e.support_radius;
    let away = |v: &usize| length(sub(model.positions[*v], e.contact_point));
    let all = 0..model.positions.len();
    *close |= all.clone().any(|v| away(&v) > 0.0 && (away(&v) - radius).abs() < 1e-6 * radius);
    let near: Vec<usize> = all.filter(|v| away(v) <= radius).collect();
    let step = near.len().div_ceil(384).max(1);
    near.iter().copied().step_by(step).chain([e.contact_vertex]).collect()
}

fn error(model: &Model, q: usize, parts: &[Part], samples: &[usize]) -> f64 {
    let e = &model.examples[q];
    let mark = Mark {
        contact: e.contact_vertex,
        depth: e.depth(),
        hits: 1.0,
        strength: 1.0,
        wide: 1.0,
        parts: parts.to_vec(),
    };
    let factors = scales(model, &mark);
    let (mut wrong, mut all) = (0.0, 0.0);
    for v in samples {
        let mut u: V = [0.0; 3];
        for (part, w) in parts.iter().zip(&factors) {
            u = add(u, scale(*w, example_at(model, &mark, part, *v)));
        }
        wrong += length(sub(u, e.deltas[*v])).powi(2);
        all += length(e.deltas[*v]).powi(2);
    }
    (wrong / all).sqrt()
}

/// Predicts example `q` from the others: carried with place axes of `width`, or anchored.
pub fn left_out(model: &Model, q: usize, width: f64, anchored: bool) -> Answer {
    let e = &model.examples[q];
    let mut close = model.close;
    let asked = Asked { contact: e.contact_vertex, target: e.deltas[e.contact_vertex], strike: None };
    let mut list = Vec::new();
    for image in &model.images {
        let i = image.example;
        if i == q || copies(model, q, i, &mut close) {
            continue;
        }
        if anchored || model.examples[i].placement != Placement::Anchored {
            list.extend(candidate(model, image, anchored, &asked, width, &mut close));
        }
    }
    let ways = answers(&list, 3, &mut close);
    let samples = samples(model, q, &mut close);
    let errors: Vec<f64> = ways.iter().map(|parts| error(model, q, parts, &samples)).collect();
    let Some(first) = errors.first().copied() else { return Answer { error: None, sure: !close } };
    Answer { error: Some(first), sure: !close && errors.iter().all(|e| (e - first).abs() < 1e-3 * (1.0 + first)) }
}

/// The conclusions from the errors of the examples left out.
#[derive(Debug, Clone)]
pub struct Learned {
    pub width: f64,
    /// For each example the error carried at that width and the error anchored; `None` if it is not left out.
    pub errors: Vec<Option<(Answer, Answer)>>,
    pub anchored: Vec<bool>,
    /// Whether the width, and the placement of each example, depend on rounding.
    pub close: bool,
    pub close_placement: Vec<bool>,
}

pub fn learn(model: &Model) -> Learned {
    let count = model.examples.len();
    let nothing = Learned {
        width: WIDTHS[0],
        errors: vec![None; count],
        anchored: vec![false; count],
        close: false,
        close_placement: vec![false; count],
    };
    let usable: Vec<usize> = (0..count).filter(|i| model.examples[*i].grid.is_some()).collect();
    if usable.len() < 2 {
        return nothing;
    }
    let queries: Vec<usize> = usable.iter().copied().step_by(usable.len().div_ceil(64)).collect();
    let carried: Vec<Vec<Answer>> =
        WIDTHS.iter().map(|w| queries.iter().map(|q| left_out(model, *q, *w, false)).collect()).collect();
    let anchored: Vec<Answer> = queries.iter().map(|q| left_out(model, *q, WIDTHS[0], true)).collect();
    let mut out = nothing;
    let answered = carried[0].iter().filter(|a| a.error.is_some()).count();
    let sum = |w: usize| carried[w].iter().filter_map(|a| a.error).map(|e| e.min(2.0)).sum::<f64>();
    let mut width = 0;
    if answered >= 8 {
        let (sums, first) = ([sum(0), sum(1), sum(2)], sum(0));
        for w in 1..3 {
            let better = sums[w] < sums[width] && sums[w] < 0.95 * first;
            out.close |= (sums[w] / sums[width] - 1.0).abs() < 0.02 || (sums[w] / (0.95 * first) - 1.0).abs() < 0.02;
            width = if better { w } else { width };
        }
    }
    out.width = WIDTHS[width];
    for (at, q) in queries.iter().enumerate() {
        out.errors[*q] = Some((carried[width][at], anchored[at]));
    }
    if answered >= 8 {
        for i in usable.iter().copied().filter(|i| model.examples[*i].placement == Placement::Automatic) {
            let away = |q: &usize| length(sub(model.examples[*q].contact_point, model.examples[i].contact_point));
            let mut near: Vec<usize> =
                queries.iter().copied().filter(|q| out.errors[*q].is_some_and(|e| e.0.error.is_some())).collect();
            near.sort_by(|a, b| away(a).total_cmp(&away(b)));
            let tie = near.len() > 3 && (away(&near[2]) - away(&near[3])).abs() < 1e-6;
            near.truncate(3);
            let of = |a: Answer| a.error.unwrap_or(2.0).min(2.0);
            let errors = near.iter().map(|q| out.errors[*q].unwrap());
            let (c, a) = errors.fold((0.0, 0.0), |s, (c, a)| (s.0 + of(c), s.1 + of(a)));
            let unsure = near.iter().any(|q| out.errors[*q].is_some_and(|(c, a)| !c.sure || !a.sure));
            out.close_placement[i] = tie || unsure || (a / (0.9 * c) - 1.0).abs() < 0.02;
            out.anchored[i] = a < 0.9 * c;
        }
    }
    out
}
