//! The response of a body: the displacement that a blow leaves at its contact, learned from the examples that know
//! their blow.
//!
//! The law is a line in logarithms with an elastic threshold, plus what places differ by:
//!
//! ```text
//! log(depth + elastic) = level + b · (log strength, log radius) + place(p)          strength = v · m^0.6
//! ```
//!
//! It is fitted as Gaussian process regression with fixed priors (Rasmussen and Williams, "Gaussian Processes for Machine
//! Learning", 2006, sections 2.2 and 2.7), so a single example gives the physical law through that example, and many
//! examples give the differences between places too. A cone around every example makes the fit exact there without
//! ever letting a harder blow leave a shallower dent.
//!
//! Uses only IEEE f64 operations, `sqrt` and `libm`, so it gives the same result on every platform.

use super::blow::Blow;
use super::example::Example;
use crate::base::math::Aabb;
use crate::mesh::mirror::{self, Mirror};
use glam::{DVec3, Vec3};

/// Exponent of the striker's mass relative to that of its speed.
const MASS: f64 = 0.6;
/// Distances are divided by this share of the diagonal.
const WIDTH: f64 = 0.2;
/// Standard deviations in logarithms: of the differences between places, of noise, and of the level.
const PLACE: f64 = 0.35;
const NOISE: f64 = 0.25;
const LEVEL: f64 = 1.5;
/// The elastic recovery, as a share of the median depth, and its least value as a share of the diagonal.
const ELASTIC: f64 = 0.2;
const LEAST_ELASTIC: f64 = 1e-6;
/// A dent counts as at least this share of its longest displacement: a contact beside the dent says little about it.
const LONGEST: f64 = 0.5;
/// Limits of the fitted exponent of the strength: this share of the expected exponent, and this value.
const EXPONENT: (f64, f64) = (0.75, 2.0);
/// Predictions are lowered by this many variances, at most [`MOST_VARIANCE`]: too deep a dent is further from the truth
/// than one that is too shallow by the same factor.
const CAUTION: f64 = 0.5;
const MOST_VARIANCE: f64 = 0.25;
/// Prior of the variance, and how many examples it counts for.
const VARIANCE: (f64, f64) = (0.05, 4.0);
/// Least slopes of the cones around examples: per unit of distance, and per logarithm of strength.
const CONE: f64 = 3.0;
const STEEP: f64 = 4.0;
/// Distance that equals a factor e in radius.
const RADIUS: f64 = 0.5;
/// Examples this near to each other are at one place.
const SAME_PLACE: f64 = 1e-3;
/// A blow along the surface counts as at least this much of a normal one.
const GRAZING: f64 = 0.02;
/// The tangential part of a blow beyond this share of the normal part only slides.
const FRICTION: f64 = 0.4;
/// Lean: distance that equals a unit of tangential part, noise, and standard deviation of the slope.
const TANGENT: f64 = 0.5;
const LEAN_NOISE: f64 = 0.8;
const LEAN_SLOPE: f64 = 0.05;
/// Longest lean that is predicted.
const MOST_LEAN: f64 = 0.9;
/// Mirror images are judged from this many examples on. With fewer, a symmetric body responds symmetrically.
const ENOUGH: usize = 8;
/// Maximum number of examples that the law is fitted to, evenly spread over the list.
const MOST_EXAMPLES: usize = 64;

/// A blow that an example or a hit knows, as the law sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Strike {
    /// Outward unit normal of the surface.
    surface: DVec3,
    /// Contact relative to the body's centre, in units of distance.
    place: DVec3,
    /// Logarithm of `v · m^0.6`. `None` if the mass is unknown.
    momentum: Option<f64>,
    /// Logarithm of the normal impulse.
    impulse: f64,
    /// Logarithm of the striker's radius.
    pub radius: Option<f64>,
    /// The part of the blow along the surface, divided by the normal part.
    pub tangent: DVec3,
    /// Whether the blow points out of the body. Such a blow leaves nothing.
    outward: bool,
}

/// What a blow is predicted to leave at its contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Predicted {
    /// Displacement of the contact, m.
    pub displacement: DVec3,
    pub strike: Strike,
}

/// An example that knows its blow.
#[derive(Debug, Clone, Copy)]
struct Known {
    example: usize,
    strike: Strike,
    depth: f64,
    longest: f64,
    /// The tangential part of the unit displacement.
    lean: DVec3,
}

/// What a set learned about its body's response to blows, from the examples that know theirs.
#[derive(Debug, Clone)]
pub struct Response {
    space: Space,
    /// The planes in which the body responds symmetrically.
    folded: Mirror,
    /// The law for blows of known mass, if any example knows one.
    momentum: Option<Law>,
    /// The law for blows of which only the impulse is known.
    impulse: Law,
    lean: LeanLaw,
    depth_error: Vec<Option<f32>>,
    contradictions: Vec<(u32, u32)>,
}

/// The scale of the body, and how its strikers rebound.
#[derive(Debug, Clone, Copy)]
struct Space {
    centre: DVec3,
    unit: f64,
    /// Mean ratio of the normal impulse to the striker's normal momentum before the touch.
    rebound: f64,
}

impl Response {
    /// Learns from the examples that know their blow. `None` if there is none.
    pub(crate) fn learn(examples: &[Example], bounds: &Aabb, planes: Mirror) -> Option<Self> {
        let unit = WIDTH * f64::from(bounds.diagonal()).max(f64::MIN_POSITIVE);
        let mut space = Space { centre: mirror::centre(bounds).as_dvec3(), unit, rebound: 1.0 };
        space.rebound = rebound(examples);
        let known: Vec<Known> = examples.iter().enumerate().filter_map(|(i, e)| space.known(i, e)).collect();
        let known: Vec<Known> = known.iter().step_by(known.len().div_ceil(MOST_EXAMPLES).max(1)).copied().collect();
        let fit = |folded: Mirror| Self::fit(space, folded, &known, examples.len());
        let symmetric = fit(planes)?;
        if planes == Mirror::NONE || known.len() < ENOUGH {
            return Some(symmetric);
        }
        let plain = fit(Mirror::NONE)?;
        Some(if plain.main().left_out_sum() < symmetric.main().left_out_sum() { plain } else { symmetric })
    }

    fn fit(space: Space, folded: Mirror, known: &[Known], examples: usize) -> Option<Self> {
        let law = |strength: fn(&Strike) -> Option<f64>, exponents: [(f64, f64); 2]| {
            let points: Vec<Point> = known.iter().filter_map(|k| Point::new(k, strength, folded)).collect();
            Law::fit(&points, exponents, space.unit / WIDTH)
        };
        let momentum = law(|s| s.momentum, [(1.0, 0.2), (-0.1, 0.2)]);
        let impulse = law(|s| Some(s.impulse), [(0.8, 0.3), (-0.1, 0.2)])?;
        let main = momentum.as_ref().unwrap_or(&impulse);
        let mut depth_error = vec![None; examples];
        for (i, error) in main.depth_errors() {
            depth_error[i] = Some(error);
        }
        Some(Response {
            space,
            folded,
            lean: LeanLaw::fit(known, folded),
            depth_error,
            contradictions: main.contradictions.clone(),
            momentum,
            impulse,
        })
    }

    fn main(&self) -> &Law {
        self.momentum.as_ref().unwrap_or(&self.impulse)
    }

    /// Predicts what a blow leaves at `point` (m) of the surface, whose unit normal is `normal`. The blow is in the
    /// mesh's space and knows its impulse or its striker's mass and velocity.
    pub(crate) fn predict(&self, blow: &Blow, point: Vec3, normal: Option<Vec3>) -> Option<Predicted> {
        let strike = self.space.strike(blow, point, normal)?;
        let (law, strength) = match (&self.momentum, strike.momentum) {
            (Some(law), Some(strength)) => (law, strength),
            _ => (&self.impulse, strike.impulse),
        };
        let depth = if strike.outward { 0.0 } else { law.depth(strength, strike.radius, strike.place, self.folded) };
        let up = strike.surface;
        let lean = self.lean.predict(&strike, self.folded);
        let lean = lean - up * up.dot(lean);
        let lean = lean * (MOST_LEAN / lean.length().max(MOST_LEAN));
        let displacement = (lean - up * (1.0 - lean.length_squared()).sqrt()) * depth;
        Some(Predicted { displacement, strike })
    }

    /// The blow of an example, for comparison with that of a hit.
    pub(crate) fn strike_of(&self, e: &Example) -> Option<Strike> {
        self.space.strike(e.blow(), e.contact_point(), e.contact_normal())
    }

    /// For each example, the relative error of its depth when it is predicted from the blows of the others. `None` if
    /// it does not know its blow.
    pub fn depth_error(&self) -> &[Option<f32>] {
        &self.depth_error
    }

    /// Median of the errors of depth.
    pub fn median_depth_error(&self) -> f32 {
        let mut errors: Vec<f32> = self.depth_error.iter().flatten().copied().collect();
        errors.sort_by(f32::total_cmp);
        errors.get(errors.len() / 2).copied().unwrap_or(0.0)
    }

    /// Pairs of examples that contradict each other: at one place, the harder blow (the first) left the shallower dent.
    /// A hit like one of them does not get exactly its depth.
    pub fn contradictions(&self) -> &[(u32, u32)] {
        &self.contradictions
    }
}

/// Mean ratio, in logarithms, of the normal impulse to the normal momentum, over the examples that know both.
fn rebound(examples: &[Example]) -> f64 {
    let ratio = |e: &Example| {
        let (b, m) = (e.blow(), f64::from(e.blow().striker.mass?));
        let normal = b.normal.map_or_else(|| surface_normal(b, e.contact_normal()), |n| double(n).try_normalize())?;
        Some(libm::log(into(double(b.impulse?), normal) / (m * into(double(b.striker.velocity?), normal))))
    };
    let ratios: Vec<f64> = examples.iter().filter(|e| !e.is_empty()).filter_map(ratio).collect();
    if ratios.is_empty() { 1.0 } else { libm::exp(ratios.iter().sum::<f64>() / ratios.len() as f64) }
}

fn double(v: [f32; 3]) -> DVec3 {
    DVec3::from_array(v.map(f64::from))
}

/// The part of `v` that goes into the body.
fn into(v: DVec3, normal: DVec3) -> f64 {
    (-v.dot(normal)).max(GRAZING * v.length()).max(1e-9)
}

/// The outward unit normal: the mesh's, else that of the contact, else against the impulse.
fn surface_normal(blow: &Blow, mesh: Option<Vec3>) -> Option<DVec3> {
    let given = mesh.map(Vec3::as_dvec3).or(blow.normal.map(double));
    given.or_else(|| blow.total_impulse().map(|j| -double(j)))?.try_normalize()
}

impl Space {
    fn strike(&self, blow: &Blow, point: Vec3, mesh_normal: Option<Vec3>) -> Option<Strike> {
        let impulse = double(blow.total_impulse()?);
        let surface = surface_normal(blow, mesh_normal)?;
        let normal = blow.normal.and_then(|n| double(n).try_normalize()).unwrap_or(surface);
        let (mass, speed) = (blow.striker.mass.map(f64::from), blow.striker.velocity.map(|v| into(double(v), normal)));
        // Without an impulse, mass and velocity are known.
        let push = match (blow.impulse, mass, speed) {
            (None, Some(m), Some(v)) => m * v * self.rebound,
            _ => into(impulse, normal),
        };
        let momentum = mass.map(|m| libm::log(speed.unwrap_or(push / (m * self.rebound))) + MASS * libm::log(m));
        let direction = blow.striker.velocity.map_or(impulse, double);
        let across = direction - normal * direction.dot(normal);
        let tangent = across / into(direction, normal);
        let tangent = tangent - surface * surface.dot(tangent);
        Some(Strike {
            surface,
            place: (point.as_dvec3() - self.centre) / self.unit,
            momentum,
            impulse: libm::log(push),
            radius: blow.striker.radius.map(|r| libm::log(f64::from(r))),
            tangent: tangent * (FRICTION / tangent.length().max(FRICTION)),
            outward: direction.dot(normal) > GRAZING * direction.length(),
        })
    }

    /// An example, if it knows its blow and was pushed into the body.
    fn known(&self, i: usize, e: &Example) -> Option<Known> {
        let strike = self.strike(e.blow(), e.contact_point(), e.contact_normal()).filter(|_| !e.is_empty())?;
        let up = strike.surface;
        let direction = e.contact_displacement().as_dvec3().try_normalize().filter(|d| d.dot(up) < 0.0)?;
        Some(Known {
            example: i,
            strike,
            depth: f64::from(e.depth()),
            longest: f64::from(e.max_depth()),
            lean: direction - up * up.dot(direction),
        })
    }
}

/// The signs that bring a place to the positive side of the mirror planes.
fn signs(place: DVec3, planes: Mirror) -> DVec3 {
    let sign = |axis: usize| if planes.bits() >> axis & 1 == 1 && place[axis] < 0.0 { -1.0 } else { 1.0 };
    DVec3::new(sign(0), sign(1), sign(2))
}

/// Covariance of two places, at most 1: exponential decay would need a function that not every platform rounds alike.
fn kernel(distance: f64) -> f64 {
    1.0 / (1.0 + distance)
}

/// An example as a law is fitted to it.
#[derive(Debug, Clone, Copy)]
struct Point {
    example: usize,
    strength: f64,
    radius: Option<f64>,
    place: DVec3,
    /// The place after folding in the mirror planes.
    folded: DVec3,
    depth: f64,
    longest: f64,
}

impl Point {
    fn new(k: &Known, strength: fn(&Strike) -> Option<f64>, planes: Mirror) -> Option<Self> {
        let place = k.strike.place;
        Some(Point {
            example: k.example,
            strength: strength(&k.strike)?,
            radius: k.strike.radius,
            place,
            folded: place * signs(place, planes),
            depth: k.depth,
            longest: k.longest,
        })
    }
}

/// The law of depth for one measure of strength.
#[derive(Debug, Clone)]
struct Law {
    points: Vec<Point>,
    /// Elastic recovery, m.
    elastic: f64,
    /// Log of depth and elastic recovery of each example.
    log_depth: Vec<f64>,
    level: f64,
    exponents: [f64; 2],
    /// Mean of the logarithms of strength, and of radius if any example knows it.
    mean: (f64, Option<f64>),
    /// Weight of each example's place.
    weights: Vec<f64>,
    /// What each example's log depth is above its prediction from the others.
    left_out: Vec<f64>,
    /// How much predictions are lowered.
    caution: f64,
    cone: f64,
    contradictions: Vec<(u32, u32)>,
}

impl Law {
    /// Fits the law. `prior` has the expected exponents of strength and radius with their standard deviations.
    fn fit(points: &[Point], prior: [(f64, f64); 2], diagonal: f64) -> Option<Self> {
        let n = points.len();
        let mean_of = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
        let mut depths: Vec<f64> = points.iter().map(|p| p.depth).collect();
        depths.sort_by(f64::total_cmp);
        let median = (depths.get(n.checked_sub(1)? / 2)? + depths[n / 2]) / 2.0;
        let elastic = (ELASTIC * median).max(LEAST_ELASTIC * diagonal);
        let radii: Vec<f64> = points.iter().filter_map(|p| p.radius).collect();
        let strengths: Vec<f64> = points.iter().map(|p| p.strength).collect();
        let mean = (mean_of(&strengths), (!radii.is_empty()).then(|| mean_of(&radii)));
        let x: Vec<[f64; 2]> = points.iter().map(|p| features(mean, p.strength, p.radius)).collect();
        let y: Vec<f64> = points.iter().map(|p| libm::log(p.depth.max(LONGEST * p.longest) + elastic)).collect();
        let above =
            |b: [f64; 2]| -> Vec<f64> { y.iter().zip(&x).map(|(y, x)| y - x[0] * b[0] - x[1] * b[1]).collect() };
        let covariance = |spread: [f64; 2]| {
            Matrix::new(n, |i, j| {
                let slopes = spread[0].powi(2) * x[i][0] * x[j][0] + spread[1].powi(2) * x[i][1] * x[j][1];
                let place = PLACE * PLACE * kernel((points[i].folded - points[j].folded).length());
                place + LEVEL * LEVEL + slopes + if i == j { NOISE * NOISE } else { 0.0 }
            })
            .inverse()
        };
        let expected = prior.map(|p| p.0);
        let base = mean_of(&above(expected));
        let solve = |expected: [f64; 2], spread: [f64; 2]| {
            let inverse = covariance(spread);
            let rest: Vec<f64> = above(expected).iter().map(|r| r - base).collect();
            let alpha = inverse.times(&rest);
            let slope =
                |k: usize| expected[k] + spread[k].powi(2) * x.iter().zip(&alpha).map(|(x, a)| x[k] * a).sum::<f64>();
            ([slope(0), slope(1)], inverse, alpha)
        };
        let (mut exponents, mut inverse, mut alpha) = solve(expected, prior.map(|p| p.1));
        let within = exponents[0].clamp(EXPONENT.0 * expected[0], EXPONENT.1);
        if within != exponents[0] {
            (exponents, inverse, alpha) = solve([within, expected[1]], [0.0, prior[1].1]);
        }
        let left_out: Vec<f64> = (0..n).map(|i| alpha[i] / inverse.at(i, i)).collect();
        let squares = left_out.iter().map(|r| r * r).sum::<f64>();
        let variance = (squares + VARIANCE.0 * VARIANCE.1) / (n as f64 + VARIANCE.1);
        let mut law = Law {
            elastic,
            log_depth: points.iter().map(|p| libm::log(p.depth + elastic)).collect(),
            level: base + LEVEL * LEVEL * alpha.iter().sum::<f64>(),
            exponents,
            mean,
            weights: alpha.iter().map(|a| PLACE * PLACE * a).collect(),
            left_out,
            caution: CAUTION * variance.min(MOST_VARIANCE),
            cone: CONE,
            contradictions: Vec::new(),
            points: points.to_vec(),
        };
        law.widen_cones();
        Some(law)
    }

    /// Makes the cones as steep as the examples need, so that no example lies outside another's cone.
    fn widen_cones(&mut self) {
        for (i, a) in self.points.iter().enumerate() {
            for (j, b) in self.points.iter().enumerate() {
                let rise = self.log_depth[j] - self.log_depth[i] - STEEP * (b.strength - a.strength).max(0.0);
                let distance = distance(a, b.place, b.radius);
                if rise > 0.0 && distance >= SAME_PLACE {
                    self.cone = self.cone.max(rise / distance);
                } else if rise > 1e-6 && a.strength >= b.strength {
                    self.contradictions.push((a.example as u32, b.example as u32));
                }
            }
        }
    }

    /// The depth that a blow leaves, m. It never decreases with the strength.
    fn depth(&self, strength: f64, radius: Option<f64>, place: DVec3, planes: Mirror) -> f64 {
        let folded = place * signs(place, planes);
        let x = features(self.mean, strength, radius);
        let mut y = self.level + self.exponents[0] * x[0] + self.exponents[1] * x[1] - self.caution;
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        for ((p, weight), log_depth) in self.points.iter().zip(&self.weights).zip(&self.log_depth) {
            y += weight * kernel((folded - p.folded).length());
            let reach = self.cone * distance(p, place, radius);
            low = low.max(log_depth - reach - STEEP * (p.strength - strength).max(0.0));
            high = high.min(log_depth + reach + STEEP * (strength - p.strength).max(0.0));
        }
        (libm::exp(y.max(low).min(high)) - self.elastic).max(0.0)
    }

    fn left_out_sum(&self) -> f64 {
        self.left_out.iter().map(|r| r.abs()).sum()
    }

    /// The relative error of each example's depth when it is predicted from the others.
    fn depth_errors(&self) -> impl Iterator<Item = (usize, f32)> {
        self.points.iter().zip(&self.left_out).map(|(p, rest)| {
            let seen = p.depth.max(LONGEST * p.longest) + self.elastic;
            let depth = (seen * libm::exp(-rest) - self.elastic).max(0.0);
            (p.example, ((depth - p.depth).abs() / p.depth) as f32)
        })
    }
}

/// Logarithms of strength and radius less their means. An unknown radius counts as the mean.
fn features(mean: (f64, Option<f64>), strength: f64, radius: Option<f64>) -> [f64; 2] {
    [strength - mean.0, radius.zip(mean.1).map_or(0.0, |(r, mean)| r - mean)]
}

/// Distance of a blow from an example. Radii count if both are known.
fn distance(p: &Point, place: DVec3, radius: Option<f64>) -> f64 {
    let radii = p.radius.zip(radius).map_or(0.0, |(a, b)| (a - b).abs());
    (p.place - place).length() + RADIUS * radii
}

/// The law of lean: a slope with the tangential part of the blow, plus what places differ by.
#[derive(Debug, Clone)]
struct LeanLaw {
    slope: f64,
    /// Place and tangential part of each example, and its weight.
    points: Vec<(DVec3, DVec3, DVec3)>,
}

impl LeanLaw {
    fn fit(known: &[Known], planes: Mirror) -> Self {
        let folded = |k: &Known| {
            let sign = signs(k.strike.place, planes);
            (k.strike.place * sign, k.strike.tangent * sign, k.lean * sign)
        };
        let points: Vec<(DVec3, DVec3, DVec3)> = known.iter().map(folded).collect();
        let n = points.len();
        let inverse = Matrix::new(n, |i, j| {
            kernel(Self::distance(&points[i], points[j].0, points[j].1))
                + if i == j { LEAN_NOISE * LEAN_NOISE } else { 0.0 }
        })
        .inverse();
        let solved = |values: fn(&(DVec3, DVec3, DVec3)) -> DVec3| -> Vec<DVec3> {
            (0..n).map(|i| (0..n).map(|j| values(&points[j]) * inverse.at(i, j)).sum()).collect()
        };
        let (tangents, leans) = (solved(|p| p.1), solved(|p| p.2));
        let product = |with: &[DVec3]| points.iter().zip(with).map(|(p, w)| p.1.dot(*w)).sum::<f64>();
        let spread = (points.iter().map(|p| p.2.length_squared()).sum::<f64>() / (2 * n.max(1)) as f64).max(1e-6);
        let slope = product(&leans) / (product(&tangents) + spread / (LEAN_SLOPE * LEAN_SLOPE));
        let weight = |i: usize| leans[i] - tangents[i] * slope;
        LeanLaw { slope, points: (0..n).map(|i| (points[i].0, points[i].1, weight(i))).collect() }
    }

    fn distance(p: &(DVec3, DVec3, DVec3), place: DVec3, tangent: DVec3) -> f64 {
        ((p.0 - place).length_squared() + TANGENT * TANGENT * (p.1 - tangent).length_squared()).sqrt()
    }

    fn predict(&self, strike: &Strike, planes: Mirror) -> DVec3 {
        let sign = signs(strike.place, planes);
        let (place, tangent) = (strike.place * sign, strike.tangent * sign);
        let places = self.points.iter().map(|p| p.2 * kernel(Self::distance(p, place, tangent))).sum::<DVec3>();
        (tangent * self.slope + places) * sign
    }
}

/// A small symmetric matrix.
struct Matrix {
    n: usize,
    values: Vec<f64>,
}

impl Matrix {
    fn new(n: usize, f: impl Fn(usize, usize) -> f64) -> Self {
        Matrix { n, values: (0..n * n).map(|k| f(k / n, k % n)).collect() }
    }

    fn at(&self, i: usize, j: usize) -> f64 {
        self.values[i * self.n + j]
    }

    fn times(&self, v: &[f64]) -> Vec<f64> {
        self.values.chunks(self.n.max(1)).map(|row| row.iter().zip(v).map(|(a, b)| a * b).sum()).collect()
    }

    /// The inverse of a positive definite matrix, by its Cholesky factor.
    fn inverse(self) -> Self {
        let n = self.n;
        let mut lower = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..=i {
                let known: f64 = (0..j).map(|k| lower[i * n + k] * lower[j * n + k]).sum();
                let rest = self.at(i, j) - known;
                lower[i * n + j] = if i == j { rest.sqrt() } else { rest / lower[j * n + j] };
            }
        }
        let mut inverse = vec![0.0; n * n];
        for column in 0..n {
            // Solves L y = e, then L^T x = y.
            let mut x = vec![0.0; n];
            for i in column..n {
                let known: f64 = (column..i).map(|k| lower[i * n + k] * x[k]).sum();
                x[i] = (f64::from(i == column) - known) / lower[i * n + i];
            }
            for i in (0..n).rev() {
                let known: f64 = (i + 1..n).map(|k| lower[k * n + i] * x[k]).sum();
                x[i] = (x[i] - known) / lower[i * n + i];
            }
            (0..n).for_each(|i| inverse[i * n + column] = x[i]);
        }
        Matrix { n, values: inverse }
    }
}
