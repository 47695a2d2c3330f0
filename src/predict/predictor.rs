//! The learned rule as plain data, and what it says of a hit.

use super::body::Body;
use super::features::{Point, Points, STRENGTH_AXIS, Strike, point};
use super::hits::Typical;
use super::kernel::{GROUPS, exp, matern};
use super::linear::add;
use super::own::{self, Fields};
use super::size::SizeLaw;
use super::stamp::{STAMP, View, reads};
use super::{Blow, Hit, Prediction, Told};
use crate::base::math::{Four, add_rows, side_by_side, squares};
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
            add_rows(out, &factors, modes);
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
    /// The field, four points side by side.
    fours: Vec<Four>,
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
        self.body.points.len() * 24
            + self.body.held.len() * 4
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

    /// Predicts the displacements of all points, m, four side by side; those behind the last point do not move. A blow that points out of
    /// the body, or is far weaker than all examples, leaves nothing. So does a blow if no sample knows one ([`Predictor::knows_blows`]).
    ///
    /// `fields` are those of the samples that it was learned from: a sample's own hit gives its field.
    pub fn predict<'s>(&self, hit: &Hit, fields: &dyn Fields, scratch: &'s mut Scratch) -> (Prediction, &'s [Four]) {
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
        s.field.resize(3 * body.points.len(), 0.0);
        model.anchored.add(n, &s.differences, &mut s.sums, &mut s.weights, &mut s.field);
        s.stamp.clear();
        s.stamp.resize(STAMP, 0.0);
        model.carried.add(n, &s.differences, &mut s.sums, &mut s.weights, &mut s.stamp);
        let (w, v) = (model.share as f32, (1.0 - model.share) as f32);
        let view = View::new(&body.frames, hit.contact, hit.normal, body.diagonal, wide);
        view.turned(&s.stamp, v / wide as f32, &mut s.turned);
        let far = END * reach;
        // Of the point nearest to the contact, and how it would move without held rims.
        let (mut contact, mut least, mut open) = (0, f32::INFINITY, Vec3::ZERO);
        let mut sums = [0.0f64; 4];
        s.fours.clear();
        let points = body.points.chunks(4).zip(body.normals.chunks(4)).zip(s.field.as_chunks::<3>().0.chunks(4));
        for (first, ((points, normals), field)) in (0..).step_by(4).zip(points) {
            // Missing points are outside.
            let at = side_by_side(points, f32::INFINITY);
            let distances = squares(&std::array::from_fn(|k| at[k] - hit.contact[k]));
            let nearest = distances.min_element();
            let is_nearest = nearest < least;
            if is_nearest {
                let here = distances.to_array();
                contact = first + (0..4).find(|i| here[*i] == nearest).unwrap_or_default();
                least = nearest;
            }
            if nearest >= far * far {
                s.fours.push([Vec4::ZERO; 3]);
                continue;
            }
            let cells = view.cells(&at, &side_by_side(normals, 0.0));
            let carried = reads(&s.turned, &cells);
            let share = Vec4::from([0, 1, 2, 3].map(|i| body.held(first + i)));
            let anchored = side_by_side(bytemuck::cast_slice(field), 0.0);
            let mut sum: Four = std::array::from_fn(|k| anchored[k] * w + carried[k] * share);
            if is_nearest {
                open = Vec3::from([0, 1, 2].map(|k| (anchored[k] * w + carried[k])[contact % 4]));
            }
            if distances.max_element() > reach * reach {
                let off = distances.to_array().map(|d| d.sqrt() / reach);
                let t = ((Vec4::from(off) - END) / (1.0 - END)).clamp(Vec4::ZERO, Vec4::ONE);
                let fade = t * t * (3.0 - 2.0 * t);
                sum = sum.map(|u| u * fade);
            }
            let own = squares(&sum).to_array();
            (0..4).for_each(|i| sums[i] += f64::from(own[i]));
            s.fours.push(sum);
        }
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
            s.fours.iter_mut().flatten().for_each(|u| *u *= left);
            open *= left;
            fields.moved(self.order[example as usize] as usize, &mut |v, u| {
                let v = partners.map_or(v, |(_, p)| p[v] as usize);
                let u = mirror.direction(u) * k;
                open += if v == contact { u } else { Vec3::ZERO };
                (0..3).for_each(|axis| s.fours[v / 4][axis][v % 4] += u[axis]);
            });
            let each = s.fours.iter().flat_map(|u| squares(u).to_array());
            total = each.map(f64::from).sum::<f64>().max(1e-30);
        }

        // Of the field with a size of 1.
        let unit = (1.0 / total.sqrt()) as f32;
        let there = (open * unit).length();
        let held = Vec3::from([0, 1, 2].map(|k| s.fours[contact / 4][k][contact % 4])).length() * unit;
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
        let longest = s.fours.iter().fold(Vec4::ZERO, |m, u| m.max(squares(u))).max_element();
        let faint = FAINT * longest.sqrt() * (1.0 - exact);
        let scale = unit * size;
        for fours in &mut s.fours {
            let own = squares(fours);
            let kept = if own.min_element() < 4.0 * faint * faint {
                // Nothing up to `faint`, all of it from twice as much on.
                let lengths = Vec4::from(own.to_array().map(f32::sqrt));
                ((lengths - faint) / faint.max(f32::MIN_POSITIVE)).clamp(Vec4::ZERO, Vec4::ONE)
            } else {
                Vec4::ONE
            };
            *fours = fours.map(|along| along * (scale * kept));
        }
        (Prediction { size, depth: there * size, expected_error: (errors / all) as f32 * (1.0 - exact) }, &s.fours)
    }
}
