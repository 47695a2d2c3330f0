//! The response to a blow: the displacement of the contact, fitted to the examples that know their blows. Naive: every
//! matrix is inverted, and every law is fitted by itself.

use super::body::mirrored;
use super::kriging::inverse;
use super::select::in_surface;
use super::vector::{V, add, dot, from_f32, length, scale, sub, unit};
use super::{Example, Model};

/// What is known of a blow, in the mesh's space.
#[derive(Debug, Clone, Copy, Default)]
pub struct Known {
    pub impulse: Option<V>,
    pub mass: Option<f64>,
    pub velocity: Option<V>,
    pub radius: Option<f64>,
    /// Unit contact normal, out of the body.
    pub normal: Option<V>,
}

impl Known {
    /// `None` if neither the impulse nor the striker's momentum is known.
    pub fn of(blow: &crumple::Blow) -> Option<Self> {
        let known = Known {
            impulse: blow.impulse.map(from_f32),
            mass: blow.striker.mass.map(f64::from),
            velocity: blow.striker.velocity.map(from_f32),
            radius: blow.striker.radius.map(f64::from),
            normal: blow.normal.map(|n| unit(from_f32(n))),
        };
        (known.impulse.is_some() || known.mass.is_some() && known.velocity.is_some()).then_some(known)
    }

    fn total(&self) -> V {
        self.impulse.unwrap_or_else(|| scale(self.mass.unwrap(), self.velocity.unwrap()))
    }

    /// The normal of the surface, and that of the contact.
    fn normals(&self, surface: V) -> (V, V) {
        let against = scale(-1.0, unit(self.total()));
        let surface = if length(surface) > 0.0 { surface } else { self.normal.unwrap_or(against) };
        (surface, self.normal.unwrap_or(surface))
    }
}

/// The part of `w` that goes into a surface with normal `n`.
fn into(w: V, n: V) -> f64 {
    (-dot(w, n)).max(0.02 * length(w)).max(1e-9)
}

/// The features of a blow at a contact.
#[derive(Debug, Clone, Copy)]
pub struct Strike {
    pub surface: V,
    pub place: V,
    /// With mass and velocity, and by the impulse alone.
    pub strengths: [Option<f64>; 2],
    /// Logarithm of the radius.
    pub radius: Option<f64>,
    pub tangent: V,
    /// The blow points out of the body.
    pub outward: bool,
}

/// Folds vectors at a place onto the side of positive coordinates, or does nothing.
#[derive(Debug, Clone, Copy)]
struct Fold(u8);

impl Fold {
    fn at(self, place: V, v: V) -> V {
        mirrored(v, (0..3).filter(|k| self.0 >> k & 1 == 1 && place[*k] < 0.0).map(|k| 1u8 << k).sum())
    }
}

/// An example that the response is fitted to.
#[derive(Debug, Clone, Copy)]
struct Given {
    example: usize,
    strike: Strike,
    depth: f64,
    /// Half the longest displacement.
    half: f64,
    lean: V,
}

/// The kernel of the places.
fn alike(a: V, b: V) -> f64 {
    1.0 / (1.0 + length(sub(a, b)))
}

fn product(m: &[Vec<f64>], v: &[f64]) -> Vec<f64> {
    m.iter().map(|row| row.iter().zip(v).map(|(a, b)| a * b).sum()).collect()
}

fn mean(list: impl Iterator<Item = f64>) -> Option<f64> {
    let list: Vec<f64> = list.collect();
    (!list.is_empty()).then(|| list.iter().sum::<f64>() / list.len() as f64)
}

/// The law of the depth for one of the strengths.
#[derive(Debug, Clone)]
struct Law {
    which: usize,
    fold: Fold,
    given: Vec<Given>,
    elastic: f64,
    means: [f64; 2],
    exponents: [f64; 2],
    level: f64,
    weights: Vec<f64>,
    lowered: f64,
    cone: f64,
    /// What the logarithm of each example's depth is off if the others predict it.
    left_out: Vec<f64>,
    contradictions: Vec<(usize, usize)>,
    close: bool,
}

impl Law {
    fn fit(which: usize, all: &[Given], fold: Fold, diagonal: f64) -> Option<Self> {
        let given: Vec<Given> = all.iter().copied().filter(|g| g.strike.strengths[which].is_some()).collect();
        let n = given.len();
        let mut depths: Vec<f64> = given.iter().map(|g| g.depth).collect();
        depths.sort_by(f64::total_cmp);
        let median = mean([depths.get(n.checked_sub(1)? / 2)?, &depths[n / 2]].into_iter().copied())?;
        let elastic = (0.2 * median).max(1e-6 * diagonal);
        let strength = |i: usize| given[i].strike.strengths[which].unwrap();
        let means = [mean((0..n).map(strength))?, mean(given.iter().filter_map(|g| g.strike.radius)).unwrap_or(0.0)];
        let x: Vec<[f64; 2]> =
            (0..n).map(|i| [strength(i) - means[0], given[i].strike.radius.map_or(0.0, |r| r - means[1])]).collect();
        let y: Vec<f64> = given.iter().map(|g| ln(g.depth.max(g.half) + elastic)).collect();
        let (expected, deviation) = [([1.0, -0.1], [0.2, 0.2]), ([0.8, -0.1], [0.3, 0.2])][which];
        let q: Vec<V> = given.iter().map(|g| fold.at(g.strike.place, g.strike.place)).collect();
        let trend = |e: [f64; 2], i: usize| e[0] * x[i][0] + e[1] * x[i][1];
        let base = mean((0..n).map(|i| y[i] - trend(expected, i)))?;
        let solve = |e: [f64; 2], sd: [f64; 2]| {
            let covariance = |i: usize, j: usize| {
                let features: f64 = (0..2).map(|f| sd[f] * sd[f] * x[i][f] * x[j][f]).sum();
                let own = if i == j { 0.25 * 0.25 } else { 0.0 };
                0.35 * 0.35 * alike(q[i], q[j]) + 1.5 * 1.5 + features + own
            };
            let inverse = inverse((0..n).map(|i| (0..n).map(|j| covariance(i, j)).collect()).collect());
            let alpha = product(&inverse, &(0..n).map(|i| y[i] - trend(e, i) - base).collect::<Vec<_>>());
            let sum = |f: usize| (0..n).map(|i| alpha[i] * x[i][f]).sum::<f64>();
            let exponents = [0, 1].map(|f| e[f] + sd[f] * sd[f] * sum(f));
            let left_out: Vec<f64> = (0..n).map(|i| alpha[i] / inverse[i][i]).collect();
            (alpha, exponents, left_out)
        };
        let (mut alpha, mut exponents, mut left_out) = solve(expected, deviation);
        let allowed = [0.75 * expected[0], 2.0];
        let close = allowed.iter().any(|a| (exponents[0] - a).abs() < 1e-9);
        if exponents[0] < allowed[0] || exponents[0] > allowed[1] {
            let limit = exponents[0].clamp(allowed[0], allowed[1]);
            (alpha, exponents, left_out) = solve([limit, expected[1]], [0.0, deviation[1]]);
        }
        let variance = (left_out.iter().map(|l| l * l).sum::<f64>() + 4.0 * 0.05) / (n as f64 + 4.0);
        let mut law = Law {
            which,
            fold,
            elastic,
            means,
            exponents,
            level: base + 1.5 * 1.5 * alpha.iter().sum::<f64>(),
            weights: alpha.iter().map(|a| 0.35 * 0.35 * a).collect(),
            lowered: (0.5 * variance).min(0.125),
            cone: 3.0,
            left_out,
            contradictions: Vec::new(),
            close,
            given,
        };
        law.steepen();
        Some(law)
    }

    /// How far apart example and blow are, without their strengths.
    fn away(&self, i: usize, s: &Strike) -> f64 {
        let own = &self.given[i].strike;
        let radius = own.radius.zip(s.radius).map_or(0.0, |(a, b)| 0.5 * (a - b).abs());
        length(sub(own.place, s.place)) + radius
    }

    /// The logarithm of an example's depth, with the elastic part.
    fn top(&self, i: usize) -> f64 {
        ln(self.given[i].depth + self.elastic)
    }

    fn steepen(&mut self) {
        let strength = |i: usize| self.given[i].strike.strengths[self.which].unwrap();
        let mut cone = self.cone;
        for i in 0..self.given.len() {
            for j in (0..self.given.len()).filter(|j| *j != i) {
                let rise = self.top(j) - self.top(i) - 4.0 * (strength(j) - strength(i)).max(0.0);
                let away = self.away(i, &self.given[j].strike);
                self.close |= (away - 1e-3).abs() < 1e-6;
                if away >= 1e-3 {
                    cone = cone.max(rise / away);
                } else {
                    let harder = strength(i) - strength(j);
                    self.close |= harder != 0.0 && harder.abs() < 1e-6 || (rise - 1e-6).abs() < 2e-7;
                    if harder >= 0.0 && rise > 1e-6 {
                        self.contradictions.push((self.given[i].example, self.given[j].example));
                    }
                }
            }
        }
        self.cone = cone;
    }

    fn predict(&self, s: &Strike) -> f64 {
        let strength = s.strengths[self.which].unwrap();
        let radius = if self.given.iter().any(|g| g.strike.radius.is_some()) { s.radius } else { None };
        let q = self.fold.at(s.place, s.place);
        let mut log = self.level + self.exponents[0] * (strength - self.means[0]) - self.lowered;
        log += radius.map_or(0.0, |r| self.exponents[1] * (r - self.means[1]));
        for (g, w) in self.given.iter().zip(&self.weights) {
            log += w * alike(q, self.fold.at(g.strike.place, g.strike.place));
        }
        let (mut least, mut most) = (f64::NEG_INFINITY, f64::INFINITY);
        for i in 0..self.given.len() {
            let own = self.given[i].strike.strengths[self.which].unwrap();
            let wide = self.cone * self.away(i, s);
            least = least.max(self.top(i) - wide - 4.0 * (own - strength).max(0.0));
            most = most.min(self.top(i) + wide + 4.0 * (strength - own).max(0.0));
        }
        (exp(log.max(least).min(most)) - self.elastic).max(0.0)
    }
}

/// The laws and the lean, folded or not.
#[derive(Debug, Clone)]
struct Fit {
    fold: Fold,
    laws: [Option<Law>; 2],
    slope: f64,
    /// For each example its place and tangent, and its weight for the lean; all folded.
    leans: Vec<(V, V, V)>,
}

fn lean_kernel(a: (V, V), b: (V, V)) -> f64 {
    let (p, t) = (sub(a.0, b.0), scale(0.5, sub(a.1, b.1)));
    1.0 / (1.0 + (dot(p, p) + dot(t, t)).sqrt())
}

impl Fit {
    fn new(given: &[Given], fold: Fold, diagonal: f64) -> Self {
        let n = given.len();
        let at = |g: &Given, v: V| fold.at(g.strike.place, v);
        let points: Vec<(V, V)> = given.iter().map(|g| (at(g, g.strike.place), at(g, g.strike.tangent))).collect();
        let leans: Vec<V> = given.iter().map(|g| at(g, g.lean)).collect();
        let entry = |i: usize, j: usize| lean_kernel(points[i], points[j]) + if i == j { 0.8 * 0.8 } else { 0.0 };
        let inverse = inverse((0..n).map(|i| (0..n).map(|j| entry(i, j)).collect()).collect());
        let between = |a: &[V], b: &[V]| {
            (0..n).flat_map(|i| (0..n).map(move |j| (i, j))).map(|(i, j)| dot(a[i], b[j]) * inverse[i][j]).sum::<f64>()
        };
        let tangents: Vec<V> = points.iter().map(|p| p.1).collect();
        let square = (leans.iter().map(|l| dot(*l, *l)).sum::<f64>() / (2.0 * n as f64)).max(1e-6);
        let slope = between(&tangents, &leans) / (between(&tangents, &tangents) + square / (0.05 * 0.05));
        let rest: Vec<V> = leans.iter().zip(&tangents).map(|(l, t)| sub(*l, scale(slope, *t))).collect();
        let weight = |i: usize| (0..n).fold([0.0; 3], |sum, j| add(sum, scale(inverse[i][j], rest[j])));
        Self {
            fold,
            laws: [0, 1].map(|which| Law::fit(which, given, fold, diagonal)),
            slope,
            leans: (0..n).map(|i| (points[i].0, points[i].1, weight(i))).collect(),
        }
    }

    /// The law that says whether the body is folded.
    fn first(&self) -> &Law {
        self.laws.iter().flatten().next().unwrap()
    }

    fn left_out(&self) -> f64 {
        self.first().left_out.iter().map(|l| l.abs()).sum()
    }

    fn lean(&self, s: &Strike) -> V {
        let at = |v: V| self.fold.at(s.place, v);
        let point = (at(s.place), at(s.tangent));
        let mut lean = scale(self.slope, point.1);
        for (place, tangent, weight) in &self.leans {
            lean = add(lean, scale(lean_kernel(point, (*place, *tangent)), *weight));
        }
        // folding twice undoes it
        let lean = in_surface(at(lean), s.surface);
        scale((0.9 / length(lean).max(1e-300)).min(1.0), lean)
    }
}

/// What a set learns from its examples' blows.
#[derive(Debug, Clone)]
pub struct Response {
    rebound: f64,
    fit: Fit,
    /// The greater elastic part of the laws, m.
    pub elastic: f64,
    /// The features of each example's blow; `None` if it does not know one.
    pub strikes: Vec<Option<Strike>>,
    /// Whether rounding decides something.
    pub close: bool,
}

/// What a blow is predicted to leave.
#[derive(Debug, Clone, Copy)]
pub struct Predicted {
    pub target: V,
    pub strike: Strike,
}

/// Not inlined: the compiler would also take the logarithm of a value that is unknown and drop it, which valgrind
/// reports.
#[inline(never)]
fn ln(x: f64) -> f64 {
    x.ln()
}

/// Not inlined, for the same reason.
#[inline(never)]
fn exp(x: f64) -> f64 {
    x.exp()
}

fn strike(model: &Model, known: &Known, at: V, surface: V, rebound: f64) -> Strike {
    let (surface, n) = known.normals(surface);
    let push = match (known.impulse, known.mass, known.velocity) {
        (Some(j), ..) => into(j, n),
        (None, mass, velocity) => mass.unwrap() * into(velocity.unwrap(), n) * rebound,
    };
    let with_mass = known.mass.map(|m| {
        let v = known.velocity.map_or(push / (m * rebound), |v| into(v, n));
        ln(v) + 0.6 * ln(m)
    });
    let w = known.velocity.unwrap_or_else(|| known.total());
    let tangent = in_surface(scale(1.0 / into(w, n), in_surface(w, n)), surface);
    Strike {
        surface,
        place: scale(1.0 / (0.2 * model.diagonal), sub(at, model.centre)),
        strengths: [with_mass, Some(ln(push))],
        radius: known.radius.map(ln),
        tangent: scale((0.4 / length(tangent).max(1e-300)).min(1.0), tangent),
        outward: dot(w, n) > 0.02 * length(w),
    }
}

impl Response {
    /// `None` if no example that knows its blow was pushed into the body.
    pub fn learn(model: &Model, blows: &[Option<Known>]) -> Option<Self> {
        let known: Vec<(usize, &Example, Known)> =
            blows.iter().enumerate().filter_map(|(i, k)| Some((i, &model.examples[i], (*k)?))).collect();
        let rebound = mean(known.iter().filter(|(_, e, _)| e.depth() > 0.0).filter_map(|(_, e, k)| {
            let n = k.normals(e.contact_normal).1;
            Some(ln(into(k.impulse?, n) / (k.mass? * into(k.velocity?, n))))
        }));
        let rebound = exp(rebound.unwrap_or(0.0));
        let mut strikes = vec![None; blows.len()];
        let (mut given, mut close) = (Vec::new(), false);
        for (i, e, k) in known {
            let s = strike(model, &k, e.contact_point, e.contact_normal, rebound);
            strikes[i] = Some(s);
            let (d, depth) = (e.deltas[e.contact_vertex], e.depth());
            close |= depth > 0.0 && dot(d, s.surface).abs() < 1e-6 * depth;
            close |= (0..3).any(|k| s.place[k].abs() < 1e-5 && s.place[k] != 0.0);
            if depth > 0.0 && dot(d, s.surface) < 0.0 {
                let half = 0.5 * e.deltas.iter().map(|u| length(*u)).fold(0.0, f64::max);
                let lean = in_surface(scale(1.0 / depth, d), s.surface);
                given.push(Given { example: i, strike: s, depth, half, lean });
            }
        }
        let given: Vec<Given> = given.iter().copied().step_by(given.len().div_ceil(64).max(1)).collect();
        if given.is_empty() {
            return None;
        }
        let mut fit = Fit::new(&given, Fold(model.planes), model.diagonal);
        if given.len() >= 8 && model.planes != 0 {
            let plain = Fit::new(&given, Fold(0), model.diagonal);
            close |= (plain.left_out() / fit.left_out() - 1.0).abs() < 1e-9;
            if plain.left_out() < fit.left_out() {
                fit = plain;
            }
        }
        close |= fit.laws.iter().flatten().any(|l| l.close);
        let elastic = fit.laws.iter().flatten().map(|l| l.elastic).fold(0.0, f64::max);
        Some(Self { rebound, fit, elastic, strikes, close })
    }

    pub fn predict(&self, model: &Model, known: &Known, contact: usize) -> Predicted {
        let s = strike(model, known, model.positions[contact], model.contact_normals[contact], self.rebound);
        let law = match (&self.fit.laws, s.strengths) {
            ([Some(law), _], [Some(_), _]) => law,
            ([_, law], _) => law.as_ref().unwrap(),
        };
        let depth = if s.outward { 0.0 } else { law.predict(&s) };
        let lean = self.fit.lean(&s);
        let inward = scale(-(1.0 - dot(lean, lean)).sqrt(), s.surface);
        Predicted { target: scale(depth, add(lean, inward)), strike: s }
    }

    /// Pairs of examples that contradict each other: the first is the harder blow.
    pub fn contradictions(&self) -> &[(usize, usize)] {
        &self.fit.first().contradictions
    }

    /// For each of `count` examples, the relative error of its depth if the others predict it.
    pub fn depth_errors(&self, count: usize) -> Vec<Option<f64>> {
        let law = self.fit.first();
        let mut errors = vec![None; count];
        for (g, l) in law.given.iter().zip(&law.left_out) {
            let depth = ((g.depth.max(g.half) + law.elastic) * exp(-l) - law.elastic).max(0.0);
            errors[g.example] = Some((depth / g.depth - 1.0).abs());
        }
        errors
    }
}
