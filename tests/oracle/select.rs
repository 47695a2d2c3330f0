//! The default selection: every example and its mirror images, seven axes, kriging among the twelve nearest, scaled
//! together to the target.

use crumple::Placement;

use super::body::{mirrored, mirrored_point};
use super::kriging::{Axes, choices, squared, weights};
use super::marks::{Mark, Part, met, open};
use super::vector::{V, apply, dot, length, rotation_between, scale, sub};
use super::{Example, Model};

/// The documented widths: place as a share of the body's diagonal for anchored examples (learned for carried ones),
/// depth in natural logarithms, lean.
const ANCHORED_PLACE: f64 = 0.15;
const DEPTH: f64 = 2.4;
const LEAN: f64 = 0.05;
/// A target's lean is used if it is at least `UPRIGHT` and at most `BEYOND` times the longest lean of any example.
const UPRIGHT: f64 = 0.002;
const BEYOND: f64 = 3.0;
/// An automatic example is anchored within this share of its support radius around its own contact. There anchored
/// examples answer alone.
const WITHIN: f64 = 0.1;
/// It is anchored there only for targets of about its own depth, within these factors.
const OWN_SIZE: (f64, f64) = (0.9, 1.001);
/// An anchored example reaches the vertices that it displaces by at least this share of its own contact's displacement.
const REACH: f64 = 0.1;
/// The most candidates considered, nearest first.
const NEAREST: usize = 12;
/// Images coincide within this share of the diagonal, this difference of the logarithm of depth and this lean.
const SAME: [f64; 3] = [0.01, 0.02, 0.01];

/// An example, or its image in some of the mirror planes.
#[derive(Debug, Clone, Copy)]
pub struct Image {
    pub example: usize,
    pub mirror: u8,
    pub point: V,
    pub normal: V,
    /// Unit displacement at its contact, and the component of that in the surface.
    pub direction: V,
    pub lean: V,
}

/// The component of `v` in the surface with normal `n`.
pub fn in_surface(v: V, n: V) -> V {
    sub(v, scale(dot(v, n), n))
}

pub fn image(model: &Model, i: usize, mirror: u8) -> Image {
    let e = &model.examples[i];
    let d = e.deltas[e.contact_vertex];
    let direction = mirrored(scale(1.0 / length(d), d), mirror);
    let normal = mirrored(e.contact_normal, mirror);
    let lean = in_surface(direction, normal);
    Image { example: i, mirror, point: mirrored_point(e.contact_point, mirror, model.centre), normal, direction, lean }
}

/// All examples that move something, and mirror images of those that can be carried. Leaves out images that coincide
/// with an example or with an earlier image.
pub fn images(model: &Model, close: &mut bool) -> Vec<Image> {
    let usable: Vec<usize> = (0..model.examples.len()).filter(|i| model.examples[*i].depth() > 0.0).collect();
    let mut all: Vec<Image> = usable.iter().map(|i| image(model, *i, 0)).collect();
    for i in usable {
        for m in (1..8u8).filter(|m| model.examples[i].grid.is_some() && m & !model.planes == 0) {
            let new = image(model, i, m);
            let depth = |i: &Image| model.examples[i.example].depth().ln();
            let taken = all.iter().any(|old| {
                let off = [
                    length(sub(old.point, new.point)) / model.diagonal,
                    (depth(old) - depth(&new)).abs(),
                    length(sub(old.lean, new.lean)),
                ];
                *close |=
                    (0..3).any(|k| (off[k] / SAME[k] - 1.0).abs() < 1e-3) && (0..3).all(|k| off[k] < SAME[k] * 1.001);
                (0..3).all(|k| off[k] <= SAME[k])
            });
            if !taken {
                all.push(new);
            }
        }
    }
    all.sort_by_key(|i| (i.example, i.mirror));
    all
}

/// A candidate, relative to the hit.
#[derive(Debug, Clone, Copy)]
pub struct Candidate {
    pub example: usize,
    pub mirror: u8,
    pub anchored: bool,
    pub axes: Axes,
}

impl Candidate {
    pub fn distance(&self) -> f64 {
        squared(&self.axes, &[0.0; 7])
    }
}

/// A hit: contact, and target displacement.
#[derive(Debug, Clone, Copy)]
pub struct Asked {
    pub contact: usize,
    pub target: V,
}

/// What the oracle would do with a hit.
#[derive(Debug, Clone)]
pub struct Selected {
    pub mark: Mark,
    pub met: V,
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-4 * (1.0 + b.abs())
}

/// An image as a candidate; `None` if it cannot answer. Sets `close` if a value is near a threshold.
pub fn candidate(
    model: &Model,
    image: &Image,
    anchored: bool,
    asked: &Asked,
    width: f64,
    close: &mut bool,
) -> Option<Candidate> {
    let e = &model.examples[image.example];
    if e.depth() < 1e-6 * model.depth_limit || (anchored && image.mirror != 0) {
        return None;
    }
    let normal = model.contact_normals[asked.contact];
    let (there, depth, width) = if anchored {
        let u = e.deltas[asked.contact];
        *close |= near(length(u) / e.depth(), REACH);
        if length(u) == 0.0 || length(u) < REACH * e.depth() {
            return None;
        }
        (scale(1.0 / length(u), u), length(u), ANCHORED_PLACE)
    } else {
        (apply(rotation_between(image.normal, normal), image.direction), e.depth(), width)
    };
    let size = length(asked.target);
    let direction = scale(1.0 / size, asked.target);
    let cos = dot(there, direction);
    *close |= near(cos, 1e-3);
    if cos <= 1e-3 {
        return None;
    }
    let longest = model.images.iter().map(|i| length(i.lean)).fold(0.0, f64::max);
    let leans = in_surface(direction, normal);
    let leaning = length(leans);
    *close |= near(leaning, UPRIGHT) || near(leaning, BEYOND * longest) || (leaning - UPRIGHT).abs() < 1e-6;
    let known = (UPRIGHT..=BEYOND * longest).contains(&leaning);
    let leans = scale((longest / leaning.max(1e-300)).min(1.0), leans);
    let place = scale(1.0 / (width * model.diagonal), sub(image.point, model.positions[asked.contact]));
    let lean = if known { scale(1.0 / LEAN, sub(in_surface(there, normal), leans)) } else { [0.0; 3] };
    let size = (depth / size).ln() / DEPTH;
    let axes = [place[0], place[1], place[2], size, lean[0], lean[1], lean[2]];
    Some(Candidate { example: image.example, mirror: image.mirror, anchored, axes })
}

/// Every way in which up to `k` of the candidates may answer: pairs with shares in units of 1/1024, without zero
/// shares.
pub fn answers(list: &[Candidate], k: usize, close: &mut bool) -> Vec<Vec<Part>> {
    let mut list = list.to_vec();
    list.sort_by(|a, b| a.distance().total_cmp(&b.distance()));
    if list.len() > NEAREST {
        let (a, b) = (list[NEAREST - 1].distance(), list[NEAREST].distance());
        *close |= (a - b).abs() <= 1e-5 * (1.0 + b);
        list.truncate(NEAREST);
    }
    if list.is_empty() {
        return Vec::new();
    }
    let points: Vec<Axes> = list.iter().map(|c| c.axes).collect();
    let Some(ways) = choices(&points, k) else {
        *close = true;
        return Vec::new();
    };
    let part = |i: usize, units: f64| Part {
        example: list[i].example,
        share: units / 1024.0,
        anchored: list[i].anchored,
        mirror: list[i].mirror,
    };
    let mut all = Vec::new();
    for way in ways {
        let (s, _) = weights(&way.iter().map(|i| points[*i]).collect::<Vec<_>>());
        let mut order: Vec<usize> = (0..way.len()).collect();
        order.sort_by(|a, b| s[*b].total_cmp(&s[*a]));
        let mut units: Vec<f64> = order.iter().map(|i| (s[*i] * 1024.0).round()).collect();
        units[0] = 1024.0 - units[1..].iter().sum::<f64>();
        *close |= units.iter().any(|u| (u - 2047.5).abs() < 3.0 || (u + 2048.5).abs() < 3.0);
        if units.iter().any(|u| *u < -2048.0 || *u > 2047.0) {
            // the nearest, or any that is equally near
            let first = list[0].distance();
            all.extend(
                (0..list.len())
                    .filter(|i| list[*i].distance() <= first * (1.0 + 1e-5) + 1e-9)
                    .map(|i| vec![part(i, 1024.0)]),
            );
        } else {
            all.push(order.iter().zip(&units).filter(|(_, u)| **u != 0.0).map(|(i, u)| part(way[*i], *u)).collect());
        }
    }
    all
}

/// The candidates for a hit: those that answer alone, and all others.
pub fn candidates(model: &Model, asked: &Asked, close: &mut bool) -> (Vec<Candidate>, Vec<Candidate>) {
    let (mut own, mut others): (Vec<Candidate>, Vec<Candidate>) = (Vec::new(), Vec::new());
    for image in &model.images {
        let e: &Example = &model.examples[image.example];
        let away = length(sub(e.contact_point, model.positions[asked.contact]));
        *close |= near(away, WITHIN * e.support_radius) && away > 0.0;
        let here = away <= WITHIN * e.support_radius && image.mirror == 0;
        let ratio = length(asked.target) / e.depth();
        let own_size = (OWN_SIZE.0..=OWN_SIZE.1).contains(&ratio);
        let automatic = e.placement == Placement::Automatic && e.grid.is_some();
        *close |= automatic && here && (near(ratio, OWN_SIZE.0) || near(ratio, OWN_SIZE.1));
        let anchored = e.placement == Placement::Anchored || automatic && (e.stays || here && own_size);
        let width = model.place_width;
        let mut found = candidate(model, image, anchored, asked, width, close);
        if found.is_none() && anchored && automatic {
            // an example that would stay but does not reach the contact is carried
            found = candidate(model, image, false, asked, width, close);
        }
        let Some(c) = found else { continue };
        let alone = c.anchored && here && (own_size || e.placement == Placement::Anchored);
        if alone { &mut own } else { &mut others }.push(c);
    }
    (own, others)
}

/// The marks that a hit at vertex `contact` may leave: several only if rounding decides, `None` if nothing reaches. A
/// `target` longer than `limit` is shortened to it first. The flag says that rounding may change the result, since some
/// value is near a threshold.
pub fn select(model: &Model, contact: usize, target: V, limit: f64, k: usize) -> (Vec<Option<Selected>>, bool) {
    let target = scale((limit / length(target)).min(1.0), target);
    let mut close = model.close;
    let asked = Asked { contact, target };
    let (mut own, others) = candidates(model, &asked, &mut close);
    let ways = if own.is_empty() {
        answers(&others, k, &mut close)
    } else {
        own.sort_by(|a, b| a.distance().total_cmp(&b.distance()));
        close |= own.len() > 1 && near(own[0].distance(), own[1].distance());
        answers(&own[..1], 1, &mut close)
    };
    if ways.is_empty() {
        return (vec![None], close);
    }
    let of = |parts: Vec<Part>, close: &mut bool| {
        // The dent has its own direction at the contact and meets the target's component along that direction.
        let mut mark = Mark { contact, depth: length(target), hits: 1.0, strength: 1.0, wide: 1.0, parts };
        let brings = open(model, &mark);
        if length(brings) == 0.0 {
            return None;
        }
        mark.depth = dot(target, brings) / length(brings);
        *close |= mark.depth.abs() < 1e-4 * length(target);
        if mark.depth <= 0.0 {
            return None;
        }
        let met = met(model, &mark);
        Some(Selected { mark, met })
    };
    (ways.into_iter().map(|parts| of(parts, &mut close)).collect(), close)
}
