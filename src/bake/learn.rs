//! Leave-one-out learning at build: every example is left out in turn and predicted from the others.
//!
//! It sets the width of the place axes: how far from its contact an example is useful. On an even sheet that is
//! everywhere, on a body of many parts it is not far. For each automatic example it also decides whether anchored or
//! carried examples predict hits around it better. The errors show an artist where another example would help most.

use crate::base::tasks::TaskSystem;
use crate::base::tasks::map;
use crate::damage::dent::{frame_rotations, place};
use crate::example::data::Placement;
use crate::example::learned::Learned;
use crate::example::set::ExampleSet;
use crate::select::placement::is_automatic;
use crate::select::query::HitQuery;
use crate::select::shortlist::Shortlist;
use crate::select::target::HitTarget;
use glam::Vec3;

/// Widths of the place axes that are tried, as shares of the bounds' diagonal. The first is used if there are too few
/// examples.
const WIDTHS: [f32; 3] = [Learned::DEFAULT_WIDTH, 0.5, 0.2];
/// With fewer examples than this nothing is learned: if half of them were missing, the results would be chance.
const ENOUGH: usize = 8;
/// Maximum number of examples left out in turn, evenly spread over the list.
const QUERIES: usize = 64;
/// Number of other examples that predict one. Same as the default of instances.
const EXAMPLES: usize = 3;
/// Maximum number of vertices, besides the contact, at which predictions are compared.
const SAMPLES: usize = 384;
/// Predictions are compared within this many support radii of the contact.
const AROUND: f32 = 1.5;
/// The error of a narrower width must be below that of the first times this factor. Smaller gains are chance:
/// cross-validated on the solved bodies, nothing is gained on average without such a margin.
const CLEARLY: f32 = 0.95;
/// The error of anchored examples must be below that of carried ones times this factor. Carrying is preferred because
/// it puts the dent where the body was hit.
const BETTER: f32 = 0.9;
/// Placement is decided by the errors of this many examples: the example itself and its nearest neighbours.
const NEIGHBOURS: usize = 3;
/// Errors are clamped to this, because the size of the error of a failed prediction means nothing.
const WORST: f32 = 2.0;

/// The errors of predicting one example that was left out: carried, for each width, and anchored.
#[derive(Default, Clone, Copy)]
struct Errors {
    carried: [Option<f32>; WIDTHS.len()],
    anchored: Option<f32>,
}

/// Leaves the set's examples out in turn and returns what was learned.
pub(crate) fn learn(set: &ExampleSet, tasks: &dyn TaskSystem) -> Learned {
    let examples = set.examples();
    let mut learned = Learned::nothing(examples.len());
    let usable: Vec<usize> = (0..examples.len()).filter(|i| examples[*i].stamp().is_some()).collect();
    if usable.len() < 2 {
        return learned;
    }
    let step = usable.len().div_ceil(QUERIES);
    let queries: Vec<usize> = usable.iter().copied().step_by(step).collect();
    let errors = map(tasks, &queries, |q| left_out(set, *q));
    let answered = errors.iter().filter(|e| e.carried[0].is_some()).count();
    let total = |w: usize| errors.iter().filter_map(|e| e.carried[w]).map(|x| x.min(WORST)).sum::<f32>();
    let mut width = 0;
    if answered >= ENOUGH {
        for w in 1..WIDTHS.len() {
            if total(w) < total(width) && total(w) < CLEARLY * total(0) {
                width = w;
            }
        }
    }
    learned.place_width = WIDTHS[width];
    for (q, e) in queries.iter().zip(&errors) {
        learned.carried_error[*q] = e.carried[width];
        learned.anchored_error[*q] = e.anchored;
    }
    if answered >= ENOUGH {
        for i in usable.iter().filter(|i| is_automatic(&examples[**i])) {
            learned.anchored[*i] = stays(set, &learned, &queries, *i);
        }
    }
    learned
}

/// Whether anchored examples predict better than carried ones around example `i`.
fn stays(set: &ExampleSet, learned: &Learned, queries: &[usize], i: usize) -> bool {
    let at = |q: usize| set.examples()[q].contact_point();
    let mut near: Vec<usize> = queries.iter().copied().filter(|q| learned.carried_error[*q].is_some()).collect();
    near.sort_by(|a, b| (at(*a) - at(i)).length().total_cmp(&(at(*b) - at(i)).length()).then(a.cmp(b)));
    near.truncate(NEIGHBOURS);
    let sum = |of: &[Option<f32>]| near.iter().map(|q| of[*q].unwrap_or(WORST).min(WORST)).sum::<f32>();
    sum(&learned.anchored_error) < BETTER * sum(&learned.carried_error)
}

fn left_out(set: &ExampleSet, q: usize) -> Errors {
    let examples = set.examples();
    let e = &examples[q];
    let samples = samples(set, q);
    let (contact, size) = (e.contact_vertex(), e.depth());
    let direction = e.contact_displacement() / size;
    let copies: Vec<bool> = examples.iter().map(|other| set.candidates().are_copies(e, other)).collect();
    let all = set.candidates().all();
    let others = || all.iter().enumerate().filter(|(_, c)| c.example as usize != q && !copies[c.example as usize]);
    let predict = |width: f32, anchored: bool| {
        let normal = set.mesh().contact_normal(contact);
        let hit = HitQuery::new(set, &HitTarget { contact, normal, direction, size, strike: None, told: None }, width);
        let usable = |i: usize| anchored || examples[i].placement() != Placement::Anchored;
        let mut found = Shortlist::new();
        for (i, c) in others().filter(|(_, c)| usable(c.example as usize)) {
            if let Some(scored) = found.score(i, c, anchored, &hit) {
                found.add(scored);
            }
        }
        let pairs = found.pairs(EXAMPLES, all);
        (!pairs[0].is_none()).then(|| {
            let parts = place(set, contact, size, &pairs, &frame_rotations(set, contact, &pairs)).parts;
            let (mut wrong, mut all) = (0.0f64, 0.0f64);
            for v in &samples {
                let p = set.mesh().positions()[*v as usize];
                let mut u = Vec3::ZERO;
                for part in &parts {
                    u += match &part.carried {
                        Some(at) => at.alone(set, part.example, p) * set.rim().at(*v),
                        None => examples[part.example].delta(*v),
                    } * part.scale;
                }
                let truth = e.delta(*v);
                wrong += f64::from((u - truth).length_squared());
                all += f64::from(truth.length_squared());
            }
            (wrong / all).sqrt() as f32
        })
    };
    Errors { carried: WIDTHS.map(|w| predict(w, false)), anchored: predict(WIDTHS[0], true) }
}

/// Every n-th vertex around an example's contact, in mesh order, and the contact vertex.
fn samples(set: &ExampleSet, q: usize) -> Vec<u32> {
    let e = &set.examples()[q];
    let radius = e.support_radius() * AROUND;
    let positions = set.mesh().positions();
    let near: Vec<u32> = (0..positions.len() as u32)
        .filter(|v| (positions[*v as usize] - e.contact_point()).length() <= radius)
        .collect();
    let step = near.len().div_ceil(SAMPLES).max(1);
    near.into_iter().step_by(step).chain([e.contact_vertex()]).collect()
}
