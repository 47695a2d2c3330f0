//! The learned rule as plain data, and what it says of a hit.

use super::body::Body;
use super::features::{Point, Points, STRENGTH_AXIS, Strike, point};
use super::hits::Typical;
use super::kernel::{GROUPS, exp, matern};
use super::linear::add;
use super::own::{self, Fields};
use super::size::SizeLaw;
use super::stamp::{STAMP, View, read};
use super::{Blow, Hit, Prediction, Told};
use crate::base::math::{AddRows, within_one};
use crate::base::simd::{Work, widest};
use crate::basis::field::{GROUP, Group, greatest, squares};
use crate::mesh::mirror::Mirror;
use glam::{Vec3, Vec4};

/// Displacements below this share of the field's longest are left out; above twice as much they are kept whole.
const FAINT: f32 = 0.004;
/// Energies of this share of the weakest example's leave nothing, and of `WEAK` all that the law says; logarithms.
const NOTHING: f64 = -3.4;
const WEAK: f64 = -1.6;
/// With fewer examples all blows leave what the law says.
const FEW: usize = 6;
/// A field is scaled to a told displacement by at most this factor.
pub(crate) const MOST_SCALE: f32 = 4.0;
/// And by this, if only a held rim keeps the contact from moving as far.
const MOST_BESIDE_RIMS: f32 = 1.5;
/// The largest size over that of the largest example; a logarithm.
const MOST_LOG: f64 = 0.7;
/// Where a field ends, in units of the distance at which all examples have ended.
const END: f32 = 1.3;
/// Covariance that counts against errors of near examples.
const FAR_WEIGHT: f64 = 0.5;

/// A regression on rows of low rank.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Part {
    pub factors: [f64; GROUPS],
    /// `rank` numbers.
    pub mean: Vec<f64>,
    /// `rank` numbers a point.
    pub coefficients: Vec<f64>,
    /// What a unit of each mode is.
    pub steps: Vec<f32>,
    /// `rank` rows, in units of their steps.
    pub modes: Vec<i16>,
}

impl Part {
    /// `modes` are rows; they are rounded to 16 bits.
    pub(super) fn new(factors: [f64; GROUPS], mean: Vec<f64>, coefficients: Vec<f64>, modes: &[f32]) -> Self {
        let mut part = Part { factors, mean, coefficients, ..Part::default() };
        for mode in modes.chunks_exact((modes.len() / part.mean.len().max(1)).max(1)) {
            let most = mode.iter().fold(f32::MIN_POSITIVE, |m, x| m.max(x.abs()));
            let step = most / f32::from(i16::MAX);
            part.modes.extend(mode.iter().map(|x| (x / step).round() as i16));
            part.steps.push(step);
        }
        part
    }

    /// Adds the prediction's row to `out`.
    fn add(&self, n: usize, d2: &[f64], scratch: &mut Vec<f64>, weights: &mut Vec<f64>, out: &mut [f32]) {
        let rank = self.mean.len();
        if rank == 0 {
            return;
        }
        scratch.clear();
        scratch.resize(n, 0.0);
        for g in 0..GROUPS {
            let f = self.factors[g];
            scratch.iter_mut().zip(&d2[g * n..(g + 1) * n]).for_each(|(s, d)| *s += f * d);
        }
        scratch.iter_mut().for_each(|s| *s = matern(*s));
        weights.clear();
        weights.extend(&self.mean);
        for (k, row) in scratch.iter().zip(self.coefficients.chunks_exact(rank)) {
            add(weights, *k, row);
        }
        let columns = out.len();
        let modes = weights.chunks(4).zip(self.steps.chunks(4)).zip(self.modes.chunks(4 * columns));
        for ((weights, steps), modes) in modes {
            let mut factors = [0.0; 4];
            for (factor, (w, step)) in factors.iter_mut().zip(weights.iter().zip(steps)) {
                *factor = (w * f64::from(*step)) as f32;
            }
            widest(AddRows { to: out, factors, rows: modes });
        }
    }
}

/// The rule for hits of one kind: blows or displacements.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Model {
    /// The examples and their mirror images, in the space of hits.
    pub rows: Vec<Point>,
    pub points: Points,
    /// For each the example, and the mirror.
    pub examples: Vec<(u32, Mirror)>,
    /// Logarithms of their sizes.
    pub logs: Vec<f64>,
    /// The largest of them.
    pub most: f64,
    pub size: SizeLaw,
    pub carried: Part,
    pub anchored: Part,
    /// Share of the anchored part.
    pub share: f64,
    /// Logarithm of the factor on sizes.
    pub factor: f64,
    /// Logarithm of the strength for which the grid is not stretched.
    pub reference: f64,
    /// Relative L2 error of each when it is left out, and of a hit that is far from all.
    pub errors: Vec<f64>,
    pub far: f64,
}

/// A learned rule: from hits to displacement fields at the points of a body.
#[derive(Debug, Clone, PartialEq)]
pub struct Predictor {
    pub(super) body: Body,
    /// For each mirror the partner of each point; empty if no image is used.
    pub(super) partners: Vec<(Mirror, Vec<u32>)>,
    pub(super) typical: Typical,
    pub(super) blow: Option<Model>,
    pub(super) displacement: Option<Model>,
    /// Of each example the sample that it was given as.
    pub(super) order: Vec<u32>,
    /// The largest distance from a contact at which a sample moves by a hundredth of its longest displacement, m.
    pub(super) reach: f32,
}

/// Memory that predictions share.
#[derive(Debug, Clone, Default)]
pub struct Scratch {
    differences: Vec<f64>,
    near: Vec<f64>,
    sums: Vec<f64>,
    weights: Vec<f64>,
    stamp: Vec<f32>,
    turned: Vec<Vec4>,
    field: Vec<f32>,
    /// The field of the hit.
    groups: Vec<Group>,
}

/// What a hit leaves at the points, seen from its contact.
struct Sight<'a> {
    body: &'a Body,
    view: &'a View,
    turned: &'a [Vec4],
    /// What the anchored part says, and its share.
    field: &'a [f32],
    share: f32,
    reach: f32,
    /// What is filled.
    groups: &'a mut Vec<Group>,
}

/// The point nearest to the contact, how it would move without held rims, and four sums of squares.
struct Seen {
    contact: usize,
    open: Vec3,
    sums: [f64; 4],
}

impl Work for Sight<'_> {
    type Done = Seen;

    #[inline(always)]
    fn run(self) -> Seen {
        let Sight { body, view, turned, field, share, reach, groups } = self;
        let far = END * reach;
        let mut seen = Seen { contact: 0, open: Vec3::ZERO, sums: [0.0; 4] };
        let mut least = f32::INFINITY;
        groups.clear();
        groups.reserve(body.places.len());
        for (first, (places, field)) in
            (0..).step_by(GROUP).zip(body.places.iter().zip(field.as_chunks::<{ 3 * GROUP }>().0))
        {
            let distances = squares(&places.points, view.contact);
            let (nearest, furthest) = distances.iter().fold((f32::INFINITY, 0.0f32), |(low, high), d| {
                (if *d < low { *d } else { low }, if *d > high { *d } else { high })
            });
            if nearest >= far * far {
                groups.push([[0.0; GROUP]; 3]);
                continue;
            }
            let mut anchored = [[0.0; GROUP]; 3];
            let [x, y, z] = &mut anchored;
            for i in 0..GROUP {
                (x[i], y[i], z[i]) = (field[3 * i] * share, field[3 * i + 1] * share, field[3 * i + 2] * share);
            }
            let carried = read(turned, &view.cells(places));
            if nearest < least {
                let at = distances.iter().position(|d| *d == nearest).unwrap_or_default();
                (least, seen.contact) = (nearest, first + at);
                seen.open = vector(&anchored, at) + vector(&carried, at);
            }
            let mut sum = anchored;
            for k in 0..3 {
                for i in 0..GROUP {
                    sum[k][i] += carried[k][i] * places.held[i];
                }
            }
            if furthest > reach * reach {
                for i in 0..GROUP {
                    let t = within_one((distances[i].sqrt() / reach - END) / (1.0 - END));
                    let fade = t * t * (3.0 - 2.0 * t);
                    (0..3).for_each(|k| sum[k][i] *= fade);
                }
            }
            for four in squares(&sum, Vec3::ZERO).as_chunks::<4>().0 {
                (0..4).for_each(|i| seen.sums[i] += f64::from(four[i]));
            }
            groups.push(sum);
        }
        seen
    }
}

/// Scales a field. Displacements shorter than `faint` times the longest are left out, those twice as long stay whole.
struct Scaling<'a> {
    groups: &'a mut [Group],
    faint: f32,
    scale: f32,
}

impl Work for Scaling<'_> {
    type Done = ();

    #[inline(always)]
    fn run(self) {
        let longest = greatest(self.groups.iter().map(|group| squares(group, Vec3::ZERO)));
        let faint = self.faint * longest.sqrt();
        for group in self.groups {
            let squares = squares(group, Vec3::ZERO);
            for i in 0..GROUP {
                let along = self.scale * within_one((squares[i].sqrt() - faint) / faint.max(f32::MIN_POSITIVE));
                (0..3).for_each(|k| group[k][i] *= along);
            }
        }
    }
}

#[inline(always)]
fn vector(group: &Group, i: usize) -> Vec3 {
    Vec3::new(group[0][i], group[1][i], group[2][i])
}

/// Factor on the width of the grid for a strength (logarithm) above that of width 1: the size of a blow's field, or a displacement.
pub(super) fn wide(is_blow: bool, strength: f64) -> f64 {
    let exponent = if is_blow { 1.0 / 3.0 } else { 0.5 };
    exp((exponent * strength).clamp(-1.4, 1.4))
}

impl Predictor {
    /// Relative L2 error of each sample's field when the others predict it from the blow (from the displacement if it knows no blow), in the
    /// order in which they were given.
    pub fn errors(&self) -> Vec<f32> {
        let mut errors = vec![1.0; self.order.len()];
        // A sample that knows its blow has the error of that.
        for model in self.displacement.iter().chain(&self.blow) {
            let own = model.examples.iter().zip(&model.errors).filter(|((_, mirror), _)| *mirror == Mirror::NONE);
            own.for_each(|((example, _), error)| errors[self.order[*example as usize] as usize] = *error as f32);
        }
        errors
    }

    /// The number of samples that it was learned from.
    pub fn samples(&self) -> usize {
        self.order.len()
    }

    /// Whether blows can be predicted: some sample knows its own.
    pub fn knows_blows(&self) -> bool {
        self.blow.is_some()
    }

    /// Bytes of the arrays.
    pub fn bytes(&self) -> usize {
        let part = |p: &Part| p.modes.len() * 2 + p.steps.len() * 4 + (p.coefficients.len() + p.mean.len()) * 8;
        let model = |m: &Model| part(&m.carried) + part(&m.anchored) + m.rows.len() * (2 * 104 + 8 * 3 + 8);
        let partners: usize = self.partners.iter().map(|(_, p)| 4 * p.len()).sum();
        size_of_val(&*self.body.places)
            + partners
            + self.order.len() * 4
            + self.displacement.as_ref().map_or(0, model)
            + self.blow.as_ref().map_or(0, model)
    }

    /// What is known of a blow on a surface with this unit normal, the rest assumed. `None` if it points out of the body, or tells
    /// neither velocity nor impulse.
    pub fn strike(&self, blow: &Blow, normal: Vec3) -> Option<Strike> {
        blow.strike(normal, &self.typical)
    }

    /// Predicts the displacements of all points, m, in groups; those behind the last point do not move. A blow that points out of
    /// the body, or is far weaker than all examples, leaves nothing. So does a blow if no sample knows one ([`Predictor::knows_blows`]).
    ///
    /// `fields` are those of the samples that it was learned from: a sample's own hit gives its field.
    pub fn predict<'s>(&self, hit: &Hit, fields: &dyn Fields, scratch: &'s mut Scratch) -> (Prediction, &'s [Group]) {
        let Predictor { body, reach, .. } = self;
        let (model, strike, told) = match hit.told {
            Told::Strike(strike) => (&self.blow, Some(strike), None),
            Told::Displacement(u) => (&self.displacement, Strike::of_displacement(u, hit.normal), Some(u.length())),
        };
        let (Some(model), Some(strike)) = (model, strike) else { return Default::default() };
        let x = point(hit.contact, hit.normal, body.diagonal, &strike);
        if !x.iter().all(|v| v.is_finite()) {
            return Default::default();
        }
        let n = model.rows.len();
        let s = scratch;
        model.points.differences(&x, &mut s.differences);

        let mut log = model.size.at(&x, &model.points, &s.differences, &mut s.near, &mut s.sums) + model.factor;
        log = own::within_cones(&model.rows, &model.logs, &x, log).min(model.most + MOST_LOG);
        let (mut errors, mut all) = (FAR_WEIGHT * model.far, FAR_WEIGHT);
        for (k, e) in s.near.iter().zip(&model.errors) {
            errors += k * e;
            all += k;
        }
        let strength = if told.is_some() { x[STRENGTH_AXIS] } else { log };
        let wide = wide(told.is_none(), strength - model.reference);

        s.field.clear();
        s.field.resize(3 * GROUP * body.places.len(), 0.0);
        model.anchored.add(n, &s.differences, &mut s.sums, &mut s.weights, &mut s.field[..3 * body.count]);
        s.stamp.clear();
        s.stamp.resize(STAMP, 0.0);
        model.carried.add(n, &s.differences, &mut s.sums, &mut s.weights, &mut s.stamp);
        let (w, v) = (model.share as f32, (1.0 - model.share) as f32);
        let view = View::new(&body.frames, hit.contact, hit.normal, body.diagonal, wide);
        view.turned(&s.stamp, v / wide as f32, &mut s.turned);
        let groups = &mut s.groups;
        let Seen { contact, mut open, sums } =
            widest(Sight { body, view: &view, turned: &s.turned, field: &s.field, share: w, reach: *reach, groups });
        let mut total = (sums[0] + sums[1]) + (sums[2] + sums[3]);
        let own = own::nearest(&model.rows, &x);
        if total.is_nan() || total <= 0.0 && own.is_none() {
            return (Prediction { expected_error: (errors / all) as f32, ..Prediction::default() }, &[]);
        }
        let exact = own.map_or(0.0, |(_, weight)| weight as f32);
        if let Some((i, _)) = own {
            let (example, mirror) = model.examples[i];
            let length = (-model.logs[i]).min(300.0);
            let k = exact * exp(length) as f32;
            let partners = self.partners.iter().find(|(m, _)| *m == mirror && mirror != Mirror::NONE);
            let left = (f64::from(1.0 - exact) / total.sqrt().max(1e-30)) as f32;
            groups.as_flattened_mut().as_flattened_mut().iter_mut().for_each(|u| *u *= left);
            open *= left;
            fields.moved(self.order[example as usize] as usize, &mut |v, u| {
                let v = partners.map_or(v, |(_, p)| p[v] as usize);
                let u = mirror.direction(u) * k;
                open += if v == contact { u } else { Vec3::ZERO };
                (0..3).for_each(|axis| groups[v / GROUP][axis][v % GROUP] += u[axis]);
            });
            total = groups.iter().flat_map(|group| squares(group, Vec3::ZERO)).map(f64::from).sum::<f64>().max(1e-30);
        }

        // Of the field with a size of 1.
        let unit = (1.0 / total.sqrt()) as f32;
        let there = (open * unit).length();
        let held = vector(&groups[contact / GROUP], contact % GROUP).length() * unit;
        let mut size = exp(log.clamp(-40.0, 20.0)) as f32;
        match told {
            Some(depth) => {
                let free = size;
                size = depth / held.max(there / MOST_BESIDE_RIMS).max(1e-9);
                size = size.clamp(free / MOST_SCALE, free * MOST_SCALE);
            }
            // A few examples do not tell where weak blows end. Their images come after all of them.
            None if model.examples.get(FEW - 1).is_none_or(|(_, mirror)| *mirror != Mirror::NONE) => {}
            None => {
                let t = ((x[STRENGTH_AXIS] - model.size.weakest() - NOTHING) / (WEAK - NOTHING)).clamp(0.0, 1.0);
                size *= (t * t * (3.0 - 2.0 * t)) as f32;
            }
        }
        widest(Scaling { groups, faint: FAINT * (1.0 - exact), scale: unit * size });
        (Prediction { size, depth: there * size, expected_error: (errors / all) as f32 * (1.0 - exact) }, groups)
    }
}
