//! What a set learns from its own examples: each is left out in turn, and the others predict it.

use super::body::{Body, Sample};
use super::features::{Point, Points, STRENGTH_AXIS, Strike, point};
use super::fit::{Prior, fit};
use super::hits::{Blow, Typical};
use super::kernel::{Lengths, factors};
use super::kriging::Kriging;
use super::linear::{add, dot};
use super::predictor::{MOST_SCALE, Model, Part, Predictor, wide};
use super::rank::{LowRank, gram};
use super::size::SizeLaw;
use super::stamp::{STAMP, View, read};
use crate::base::tasks::{TaskSystem, map};
use crate::basis::field::GROUP;
use crate::mesh::mirror::{self, Mirror};
use glam::{DVec3, Vec3};

/// Most examples and images from which lengths are fitted.
const FIT_ROWS: usize = 200;
/// Most modes of stamps and of fields, and the share of their squares that may be lost.
const CARRIED_MODES: usize = 32;
const ANCHORED_MODES: usize = 48;
const LOST: f64 = 5e-4;
/// With fewer groups nothing is chosen by leaving out: it would be chance.
const LEAST_GROUPS: usize = 6;
/// Fields count as this many independent outputs.
const OUTPUTS: f64 = 20.0;
/// Shares of the carried field that the anchored part starts from.
const STARTS: [f64; 3] = [0.0, 0.5, 1.0];

/// Expected logarithms of lengths and noise: the size, the carried and the anchored part.
const SIZE: Lengths = [-1.386, 0.0, 1.792, 1.792, 3.0, 1.099, 0.693, -2.0];
const CARRIED: Lengths = [0.0, 0.405, 1.099, 1.609, 1.099, 0.0, 0.405, -1.0];
const ANCHORED: Lengths = [-1.386, 0.405, 1.099, 1.609, 1.099, 1.099, 0.693, -3.0];
/// Samples lie on one side of a plane if at most one of so many lies on the other.
const FEW_BEYOND: usize = 10;
/// Expected logarithm of the length of a lean.
const LEAN: f64 = -1.6;

/// Samples in canonical order and their images, with everything that both kinds of hits share.
struct Data<'a> {
    body: Body,
    samples: Vec<Sample<'a>>,
    partners: Vec<(Mirror, Vec<u32>)>,
    /// The planes of symmetry that have samples on both sides. Only these can samples contradict.
    two_sided: Mirror,
    typical: Typical,
}

/// One image of one sample.
struct Image {
    sample: usize,
    mirror: Mirror,
    contact: Vec3,
    normal: Vec3,
    /// The displacement of the point nearest to the contact, m.
    moved: Vec3,
    point: Point,
}

impl Predictor {
    /// Learns the rule of a body from its samples, each of which moves some of its points. The result does not depend on their order.
    pub fn learn(body: Body, samples: &[Sample<'_>], tasks: &dyn TaskSystem) -> Self {
        let mut order: Vec<u32> = (0..samples.len() as u32).collect();
        order.sort_by_cached_key(|i| key(&samples[*i as usize]));
        let ordered: Vec<Sample> = order.iter().map(|i| samples[*i as usize]).collect();
        let mirrors = body.mirror.choices().filter(|m| *m != Mirror::NONE);
        let partners = mirrors.map(|m| (m, body.partners(m))).collect();
        let two_sided = two_sided(&body, &ordered);
        let data = Data { body, partners, two_sided, typical: typical(&ordered), samples: ordered };

        let (displacement, blow) = (data.best_model(false, tasks), data.best_model(true, tasks));
        let reach = data.reach();
        let images = || displacement.iter().chain(&blow).flat_map(|model| &model.examples);
        let mut partners = data.partners;
        partners.retain(|(used, _)| images().any(|(_, mirror)| mirror == used));
        Predictor { reach, body: data.body, partners, typical: data.typical, blow, displacement, order }
    }
}

/// The planes of symmetry on both sides of which samples lie. What lies in a plane lies on neither of its sides.
fn two_sided(body: &Body, samples: &[Sample<'_>]) -> Mirror {
    let near = mirror::TOLERANCE * body.diagonal as f32;
    let both = |plane: &Mirror| {
        let to_image = |s: &Sample<'_>| (s.contact - plane.point(s.contact, body.centre)).element_sum();
        let before = samples.iter().filter(|s| to_image(s) < -near).count();
        let beyond = samples.iter().filter(|s| to_image(s) > near).count();
        beyond.min(before) * FEW_BEYOND > samples.len()
    };
    Mirror::from_bits(body.mirror.planes().filter(both).map(Mirror::bits).sum())
}

/// The place of a sample in the canonical order.
fn key(sample: &Sample<'_>) -> Vec<u32> {
    let vector = |v: Vec3| v.to_array().map(f32::to_bits);
    let sum = sample.field.iter().fold(DVec3::ZERO, |sum, u| sum + u.as_dvec3());
    let mut key = vector(sample.contact).to_vec();
    key.extend(vector(sample.normal));
    key.extend(sum.to_array().iter().flat_map(|x| [(x.to_bits() >> 32) as u32, x.to_bits() as u32]));
    let known = sample.blow.unwrap_or_default();
    key.extend(vector(known.velocity.or(known.impulse).unwrap_or(Vec3::ZERO)));
    key
}

/// Means of what is known of the samples' blows.
fn typical(samples: &[Sample<'_>]) -> Typical {
    let blows = || samples.iter().filter_map(|s| s.blow.map(|b| (b, s.normal)));
    let mean = |logs: Vec<f64>, or: f64| {
        if logs.is_empty() { or } else { libm::exp(logs.iter().sum::<f64>() / logs.len() as f64) }
    };
    let log = |x: Option<f32>| x.filter(|x| *x > 0.0).map(|x| libm::log(f64::from(x)));
    let mut kinds: Vec<u32> = blows().filter_map(|(b, _)| b.kind).collect();
    kinds.sort_unstable();
    let count = |k: u32| kinds.iter().filter(|o| **o == k).count();
    Typical {
        mass: mean(blows().filter_map(|(b, _)| log(b.mass)).collect(), 10.0),
        radius: mean(blows().filter_map(|(b, _)| log(b.radius)).collect(), 0.1),
        kind: kinds.iter().copied().max_by_key(|k| (count(*k), std::cmp::Reverse(*k))).unwrap_or(0),
        rebound: mean(blows().filter_map(|(b, n)| b.rebound(n).map(libm::log)).collect(), 1.0),
    }
}

/// A model whose anchored part is not yet learned, and how well it predicts.
struct Draft {
    model: Model,
    images: Vec<Image>,
    groups: Vec<Vec<usize>>,
    /// Fields over their sizes, and what the others carry there.
    unit: Vec<f32>,
    carried: Vec<f32>,
    /// What the others miss of the logarithms of sizes.
    missed: Vec<f64>,
    /// Relative L2 errors of the carried part alone.
    errors: Vec<f64>,
    score: f64,
}

impl Data<'_> {
    /// The largest distance from a contact at which a sample still moves by a hundredth of its longest displacement, m; at least a
    /// hundredth of the diagonal.
    fn reach(&self) -> f32 {
        let mut reach = 0.01 * self.body.diagonal as f32;
        for s in &self.samples {
            let longest = s.field.iter().fold(0.0f32, |m, u| m.max(u.length_squared()));
            for (p, _) in self.body.points().zip(s.field).filter(|(_, u)| u.length_squared() > 1e-4 * longest) {
                reach = reach.max((p - s.contact).length());
            }
        }
        reach
    }

    /// The model for blows or for displacements, with images in the planes that the samples do not contradict. `None` if no sample knows a blow.
    fn best_model(&self, blows: bool, tasks: &dyn TaskSystem) -> Option<Model> {
        let draft = |planes: Mirror| self.draft(blows, &planes.choices().collect::<Vec<_>>(), tasks);
        let mut used = self.body.mirror;
        let mut best = draft(used)?;
        if best.groups.len() >= LEAST_GROUPS {
            for plane in self.two_sided.planes() {
                let without = draft(used.without(plane))?;
                if without.score <= best.score {
                    (used, best) = (used.without(plane), without);
                }
            }
        }
        Some(self.finish(best, blows))
    }

    /// The rows from which lengths are fitted. Images in planes that have samples on one side only are near no sample, and are left out.
    fn fit_rows(&self, images: &[Image], groups: &[Vec<usize>]) -> Vec<usize> {
        let near = |i: &usize| images[*i].mirror.within(self.two_sided);
        let groups: Vec<Vec<usize>> = groups.iter().map(|group| group.iter().copied().filter(near).collect()).collect();
        some_rows(&groups, FIT_ROWS)
    }

    fn images(&self, blows: bool, mirrors: &[Mirror]) -> Vec<Image> {
        let mut images = Vec::new();
        for mirror in mirrors {
            for (i, s) in self.samples.iter().enumerate() {
                let (contact, normal) = (mirror.point(s.contact, self.body.centre), mirror.direction(s.normal));
                let moved = mirror.direction(s.moved);
                let mirrored = |b: Blow| Blow {
                    velocity: b.velocity.map(|v| mirror.direction(v)),
                    impulse: b.impulse.map(|v| mirror.direction(v)),
                    ..b
                };
                let strike = if blows {
                    s.blow.and_then(|b| mirrored(b).strike(normal, &self.typical))
                } else {
                    Strike::of_displacement(moved, normal)
                };
                if let Some(strike) = strike {
                    let point = point(contact, normal, self.body.diagonal, &strike);
                    images.push(Image { sample: i, mirror: *mirror, contact, normal, moved, point });
                }
            }
        }
        images
    }

    fn field(&self, image: &Image) -> Vec<Vec3> {
        let field = self.samples[image.sample].field;
        match self.partners.iter().find(|(m, _)| *m == image.mirror) {
            Some((m, partners)) if *m != Mirror::NONE => {
                partners.iter().map(|p| m.direction(field[*p as usize])).collect()
            }
            _ => field.to_vec(),
        }
    }

    fn draft(&self, blows: bool, mirrors: &[Mirror], tasks: &dyn TaskSystem) -> Option<Draft> {
        let images = self.images(blows, mirrors);
        let (n, columns) = (images.len(), 3 * self.body.count);
        if n == 0 {
            return None;
        }
        let points: Vec<Point> = images.iter().map(|i| i.point).collect();
        let mut groups: Vec<(u32, Vec<usize>)> = Vec::new();
        for (i, image) in images.iter().enumerate() {
            let source = self.samples[image.sample].source;
            match groups.iter_mut().find(|(s, _)| *s == source) {
                Some((_, group)) => group.push(i),
                None => groups.push((source, vec![i])),
            }
        }
        let groups: Vec<Vec<usize>> = groups.into_iter().map(|(_, g)| g).collect();
        let used = self.fit_rows(&images, &groups);
        let mut unit = Vec::with_capacity(n * columns);
        let mut logs = Vec::with_capacity(n);
        for image in &images {
            let field = self.field(image);
            let squares: f64 = field.iter().map(|u| f64::from(u.length_squared())).sum();
            let size = squares.sqrt().max(1e-12);
            logs.push(libm::log(size));
            unit.extend(field.iter().flat_map(|u| u.to_array().map(|x| (f64::from(x) / size) as f32)));
        }
        let strengths: Vec<f64> =
            points.iter().zip(&logs).map(|(p, l)| if blows { *l } else { p[STRENGTH_AXIS] }).collect();
        let reference = strengths.iter().sum::<f64>() / n as f64;
        let wide = |strength: f64| wide(blows, strength - reference);

        let lean = |mut l: Lengths| {
            if !blows {
                l[5] = LEAN;
            }
            l
        };
        let exponent = if blows { 0.5 } else { 1.0 };
        let (size, missed) = SizeLaw::learn(&points, &logs, &groups, &used, exponent, lean(SIZE));

        let view = |i: usize, wide: f64| {
            View::new(&self.body.frames, images[i].contact, images[i].normal, self.body.diagonal, wide)
        };
        // Stamps of all images, side by side. A field of size 1 that is twice as wide is half as deep: so that they mix as shapes, each
        // is multiplied by its width.
        let stamps = map(tasks, 0..n, |i| {
            let at = |v: usize| Vec3::from_slice(&unit[i * columns + 3 * v..]);
            let wide = wide(strengths[i]);
            let mut stamp = view(i, wide).resample(&self.body.places, at);
            stamp.iter_mut().for_each(|x| *x *= wide as f32);
            stamp
        });
        let stamps = stamps.concat();
        let products = gram(&stamps, STAMP);
        let low = LowRank::of(&stamps, STAMP, &products, CARRIED_MODES, LOST);
        let prior = Prior { mean: lean(CARRIED), deviation: 0.4, outputs: OUTPUTS, ordinary: true };
        let lengths = fit(&points, &used, |i, j| products[i * n + j], &prior);
        let kriging = Kriging::new(&points, &lengths, true);
        let (mean, coefficients) = kriging.coefficients(&low.coefficients, low.rank);
        let left = kriging.missed(&low.coefficients, low.rank, &groups);
        let mut carried = vec![0.0f32; n * columns];
        let (mut stamp, mut turned) = (vec![0.0f32; STAMP], Vec::new());
        for i in 0..n {
            stamp.fill(0.0);
            let rank = low.rank;
            let weights: Vec<f64> = (i * rank..(i + 1) * rank).map(|k| low.coefficients[k] - left[k]).collect();
            low.mix(&weights, &mut stamp);
            // The size of a blow that is left out is not known either: its dent is as wide as the others say.
            let wide = wide(if blows { strengths[i] - missed[i] } else { strengths[i] });
            let view = view(i, wide);
            view.turned(&stamp, 1.0 / wide as f32, &mut turned);
            let carried = carried[i * columns..(i + 1) * columns].chunks_mut(3 * GROUP);
            for (carried, places) in carried.zip(&self.body.places) {
                let read = read(&turned, &view.cells(places));
                for (i, u) in carried.as_chunks_mut::<3>().0.iter_mut().enumerate() {
                    *u = read.map(|along| along[i] * places.held[i]);
                }
            }
        }
        // How well the carried part alone tells the directions of the samples themselves.
        let error = |i: usize| {
            let (c, y) = (&carried[i * columns..(i + 1) * columns], &unit[i * columns..(i + 1) * columns]);
            let cosine = dot(c, y) / dot(c, c).sqrt().max(1e-30);
            let sine = (1.0 - cosine * cosine.abs()).max(0.0).sqrt();
            (sine * sine + missed[i] * missed[i]).sqrt().min(2.0)
        };
        let errors: Vec<f64> = (0..n).map(error).collect();
        let own = (0..n).filter(|i| images[*i].mirror == Mirror::NONE);
        let score = own.map(|i| errors[i].sqrt()).sum();
        let model = Model {
            points: Points::new(&points),
            rows: points,
            examples: images.iter().map(|i| (i.sample as u32, i.mirror)).collect(),
            most: logs.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            logs,
            size,
            carried: Part::new(factors(&lengths), mean, coefficients, &low.modes),
            reference,
            far: 1.0,
            ..Model::default()
        };
        Some(Draft { model, images, groups, unit, carried, missed, errors, score })
    }

    /// Learns the anchored part, its share and the factor on sizes.
    fn finish(&self, draft: Draft, blows: bool) -> Model {
        let Draft { mut model, images, groups, unit, carried, missed, errors, .. } = draft;
        let (n, columns) = (images.len(), 3 * self.body.count);
        let row = |rows: &'_ [f32], i: usize| -> Vec<f32> { rows[i * columns..(i + 1) * columns].to_vec() };
        if groups.len() < LEAST_GROUPS {
            model.errors = if groups.len() > 1 { errors } else { vec![1.0; n] };
            return model;
        }
        let used = self.fit_rows(&images, &groups);
        let contacts: Vec<usize> = images.iter().map(|i| self.body.nearest(i.contact)).collect();
        let mut kriging: Option<(Kriging, Lengths)> = None;
        // Score, errors, share and factor; the part is that of their start.
        let mut best: Option<(f64, Vec<f64>, f64, f64)> = None;
        let mut part = Part::default();
        for start in [STARTS[1], STARTS[0], STARTS[2]] {
            let mut rest = unit.clone();
            add(&mut rest, -start as f32, &carried);
            let products = gram(&rest, columns);
            let (kriging, lengths) = kriging.get_or_insert_with(|| {
                let mut mean = ANCHORED;
                if !blows {
                    mean[5] = LEAN + 0.5;
                }
                let prior = Prior { mean, deviation: 0.7, outputs: OUTPUTS, ordinary: false };
                let lengths = fit(&model.rows, &used, |i, j| products[i * n + j], &prior);
                (Kriging::new(&model.rows, &lengths, false), lengths)
            });
            let low = LowRank::of(&rest, columns, &products, ANCHORED_MODES, LOST);
            let rank = low.rank;
            let left = kriging.missed(&low.coefficients, rank, &groups);
            let predicted: Vec<f64> = low.coefficients.iter().zip(&left).map(|(c, l)| c - l).collect();
            // Scalar products of carried (c), anchored (g) and true (y) fields, and the contacts' displacements.
            let mut terms = Vec::with_capacity(n);
            let mut field = vec![0.0f32; columns];
            for i in 0..n {
                field.fill(0.0);
                low.mix(&predicted[i * rank..(i + 1) * rank], &mut field);
                let (c, y) = (row(&carried, i), row(&unit, i));
                let at = |f: &[f32]| Vec3::from_slice(&f[3 * contacts[i]..]).as_dvec3();
                let products = [dot(&c, &c), dot(&c, &field), dot(&field, &field), dot(&c, &y), dot(&field, &y)];
                terms.push((products, at(&c), at(&field)));
            }
            let before = best.as_ref().map(|b| b.0);
            for step in 0..=10 {
                let w = 0.1 * f64::from(step);
                let v = 1.0 - w;
                let factors: &[f64] = if blows { &[-0.3, -0.2, -0.1, 0.0] } else { &[0.0] };
                for factor in factors {
                    let errors: Vec<f64> = (0..n)
                        .map(|i| {
                            let ([cc, cg, gg, cy, gy], c, g) = terms[i];
                            let length = (v * v * cc + 2.0 * v * w * cg + w * w * gg).max(1e-30).sqrt();
                            let free = libm::exp(factor - missed[i]);
                            let size = if blows {
                                free
                            } else {
                                let there = (c * v + g * w).length() / length;
                                let depth = images[i].moved.as_dvec3().length() * libm::exp(-model.logs[i]);
                                let most = f64::from(MOST_SCALE);
                                (depth / there.max(1e-9)).clamp(free / most, free * most)
                            };
                            (size * size - 2.0 * size * (v * cy + w * gy) / length + 1.0).max(0.0).sqrt()
                        })
                        .collect();
                    let own = (0..n).filter(|i| images[*i].mirror == Mirror::NONE);
                    let score: f64 = own.map(|i| errors[i].min(2.0).sqrt()).sum();
                    if best.as_ref().is_none_or(|b| score < b.0) {
                        best = Some((score, errors, w, *factor));
                    }
                }
            }
            if best.as_ref().map(|b| b.0) != before {
                let (mean, coefficients) = kriging.coefficients(&low.coefficients, rank);
                part = Part::new(factors(lengths), mean, coefficients, &low.modes);
            }
        }
        if let Some((_, errors, share, factor)) = best {
            let mut sorted = errors.clone();
            sorted.sort_by(f64::total_cmp);
            model.far = sorted[sorted.len() * 9 / 10].min(2.0);
            model.errors = errors.iter().map(|e| e.min(2.0)).collect();
            (model.share, model.factor) = (share, factor);
            model.anchored = if share > 0.0 { part } else { Part::default() };
        }
        model
    }
}

/// Whole groups of rows, evenly from all, of at most `most` rows.
fn some_rows(groups: &[Vec<usize>], most: usize) -> Vec<usize> {
    let rows: usize = groups.iter().map(Vec::len).sum();
    let step = rows.div_ceil(most).max(1);
    groups.iter().step_by(step).flatten().copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_stay_whole_when_rows_are_chosen() {
        let groups: Vec<Vec<usize>> = (0..300).map(|i| vec![i, i + 300]).collect();
        let rows = some_rows(&groups, 200);
        assert!(rows.len() <= 200 && rows.len() > 100);
        assert!(rows.iter().all(|r| rows.contains(&((r + 300) % 600))));
    }
}
