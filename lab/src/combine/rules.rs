//! Rules that combine dents, on plain displacement fields in f64. Each is measured with the true single dents, so that
//! nothing but the rule is wrong. The library's own rule asks how far dents act on one place, so the library itself runs it.

/// Displacement of each vertex, m.
pub type Field64 = Vec<[f64; 3]>;

/// One dent on the fresh body.
#[derive(Debug, Clone)]
pub struct Dent {
    pub field: Field64,
    /// Base position of the contact, m.
    pub contact: [f64; 3],
    /// Radius of the dent: root mean square distance from the contact, weighted by squared displacement, m.
    pub radius: f64,
}

impl Dent {
    pub fn new(field: &[[f32; 3]], vertices: &[[f32; 3]], contact: u32) -> Self {
        let field: Field64 = field.iter().map(|u| u.map(f64::from)).collect();
        let contact = vertices[contact as usize].map(f64::from);
        let (mut weighted, mut all) = (0.0, f64::MIN_POSITIVE);
        for (u, p) in field.iter().zip(vertices) {
            let d = [0, 1, 2].map(|k| f64::from(p[k]) - contact[k]);
            weighted += dot(*u, *u) * dot(d, d);
            all += dot(*u, *u);
        }
        Self { field, contact, radius: (weighted / all).sqrt() }
    }
}

pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub fn len(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

fn add(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

fn times(a: [f64; 3], x: f64) -> [f64; 3] {
    a.map(|v| v * x)
}

/// How several dents become one field.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Rule {
    /// The literature's (0: "most displaced"): a vertex takes the candidate that displaces it further; else it moves towards it by this share.
    Blend(f64),
    /// The plain sum.
    Sum,
    /// The sum, no longer than the longest of its parts at that vertex.
    SumCapped,
    /// Direction of the sum, length the p-norm of the lengths (infinity: the deepest), never longer than the sum.
    Norm(f64),
    /// Mean weighted by the p-th power of the lengths.
    SmoothMaximum(f64),
    /// Only what of a dent is not there yet along its own direction. Depends on the order.
    Remainder,
    /// Direction of the sum, length the geometric mean of the sum's and the deepest's.
    SumByDeepest,
    /// Like the 2-norm, but pairs of dents also add in length as far as their fields are unlike: each mixed term counts with
    /// one minus the cosine between the two whole fields.
    OverlapOfFields,
    /// The same with one factor a dent instead of one a pair: the root of one minus its mean cosine with the others.
    OverlapOfMarks,
    /// The same by distance of contacts `d` alone: each mixed term counts with `1 - exp(-(d / (r1 + r2))^2)`.
    OverlapOfContacts,
    /// A p-norm whose exponent is one plus the mean of the cosines between whole fields, weighted by lengths.
    OverlapExponent,
    /// No dent at all.
    Nothing,
    /// Like the 2-norm, but mixed terms count with one minus the ratio of the shorter to the longer, vertex by vertex.
    LocalRatio,
}

pub const RULES: [(&str, Rule); 25] = [
    ("most displaced", Rule::Blend(0.0)),
    ("blend k=0.1", Rule::Blend(0.1)),
    ("blend k=0.5", Rule::Blend(0.5)),
    ("sum", Rule::Sum),
    ("sum, capped", Rule::SumCapped),
    ("p-norm 1", Rule::Norm(1.0)),
    ("p-norm 1.25", Rule::Norm(1.25)),
    ("p-norm 1.5", Rule::Norm(1.5)),
    ("p-norm 2", Rule::Norm(2.0)),
    ("p-norm 2.4", Rule::Norm(2.4)),
    ("p-norm 3", Rule::Norm(3.0)),
    ("p-norm 4", Rule::Norm(4.0)),
    ("p-norm 8", Rule::Norm(8.0)),
    ("deepest", Rule::Norm(f64::INFINITY)),
    ("smooth maximum 1", Rule::SmoothMaximum(1.0)),
    ("smooth maximum 2", Rule::SmoothMaximum(2.0)),
    ("smooth maximum 4", Rule::SmoothMaximum(4.0)),
    ("remainder", Rule::Remainder),
    ("sum by deepest", Rule::SumByDeepest),
    ("overlap of fields", Rule::OverlapOfFields),
    ("overlap of marks", Rule::OverlapOfMarks),
    ("overlap of contacts", Rule::OverlapOfContacts),
    ("overlap as exponent", Rule::OverlapExponent),
    ("local ratio", Rule::LocalRatio),
    ("no dent", Rule::Nothing),
];

impl Rule {
    /// The dents together, in the order given.
    pub fn combine(self, dents: &[&Dent]) -> Field64 {
        let Some(first) = dents.first() else { return Field64::new() };
        let pairs = self.mixed_terms(dents);
        let mut parts = vec![[0.0; 3]; dents.len()];
        (0..first.field.len())
            .map(|v| {
                for (part, dent) in parts.iter_mut().zip(dents) {
                    *part = dent.field[v];
                }
                self.at_vertex(&parts, &pairs)
            })
            .collect()
    }

    /// What the mixed term of each pair of dents counts with, where the rule asks.
    fn mixed_terms(self, dents: &[&Dent]) -> Vec<Vec<f64>> {
        let cosine = |a: &Dent, b: &Dent| {
            let inner = |x: &Dent, y: &Dent| x.field.iter().zip(&y.field).map(|(p, q)| dot(*p, *q)).sum::<f64>();
            (inner(a, b) / (inner(a, a) * inner(b, b)).sqrt().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0)
        };
        let each = |f: &dyn Fn(&Dent, &Dent) -> f64| {
            dents.iter().map(|a| dents.iter().map(|b| f(a, b)).collect()).collect::<Vec<Vec<f64>>>()
        };
        match self {
            Rule::OverlapOfFields | Rule::OverlapExponent => each(&|a, b| 1.0 - cosine(a, b)),
            Rule::OverlapOfMarks => {
                let others = (dents.len().max(2) - 1) as f64;
                let cosines = each(&cosine);
                // A dent's cosine with itself is 1 and is not one of the others'.
                let apart = |row: &Vec<f64>| (1.0 - (row.iter().sum::<f64>() - 1.0) / others).max(0.0).sqrt();
                let apart: Vec<f64> = cosines.iter().map(apart).collect();
                apart.iter().map(|a| apart.iter().map(|b| a * b).collect()).collect()
            }
            Rule::OverlapOfContacts => each(&|a, b| {
                let d = [0, 1, 2].map(|k| a.contact[k] - b.contact[k]);
                1.0 - (-dot(d, d) / (a.radius + b.radius).powi(2)).exp()
            }),
            _ => Vec::new(),
        }
    }

    fn at_vertex(self, parts: &[[f64; 3]], pairs: &[Vec<f64>]) -> [f64; 3] {
        let sum = parts.iter().fold([0.0; 3], |s, u| add(s, *u));
        let longest = parts.iter().map(|u| len(*u)).fold(0.0, f64::max);
        // Direction of the sum, this length at most.
        let as_long_as = |l: f64| if len(sum) > 0.0 { times(sum, (l / len(sum)).min(1.0)) } else { sum };
        let mixed = |counts: &dyn Fn(usize, usize) -> f64| {
            let mut squared = parts.iter().map(|u| dot(*u, *u)).sum::<f64>();
            for i in 0..parts.len() {
                for j in 0..i {
                    squared += 2.0 * counts(i, j) * dot(parts[i], parts[j]);
                }
            }
            as_long_as(squared.max(0.0).sqrt())
        };
        match self {
            Rule::Blend(k) => parts.iter().fold([0.0; 3], |now, u| match len(*u) {
                // The rule's examples are sparse: what does not move a vertex leaves it alone.
                l if l < 5e-5 => now,
                l if l >= len(now) => *u,
                _ => add(now, times(add(*u, times(now, -1.0)), k)),
            }),
            Rule::Sum => sum,
            Rule::SumCapped => as_long_as(longest),
            Rule::Norm(p) if p.is_infinite() => as_long_as(longest),
            Rule::Norm(p) if longest > 0.0 => {
                // Scaled by the longest, so that powers neither overflow nor vanish.
                as_long_as(longest * parts.iter().map(|u| (len(*u) / longest).powf(p)).sum::<f64>().powf(1.0 / p))
            }
            Rule::SmoothMaximum(p) if longest > 0.0 => {
                let weights = parts.iter().map(|u| (len(*u) / longest).powf(p));
                let all: f64 = weights.clone().sum();
                parts.iter().zip(weights).fold([0.0; 3], |s, (u, w)| add(s, times(*u, w / all)))
            }
            Rule::Norm(_) | Rule::SmoothMaximum(_) | Rule::Nothing => [0.0; 3],
            Rule::Remainder => parts.iter().fold([0.0; 3], |now, u| {
                let there = dot(now, *u) / dot(*u, *u).max(f64::MIN_POSITIVE);
                add(now, times(*u, (1.0 - there).clamp(0.0, 1.0)))
            }),
            Rule::SumByDeepest => as_long_as((len(sum) * longest).sqrt()),
            Rule::OverlapOfFields | Rule::OverlapOfMarks | Rule::OverlapOfContacts => mixed(&|i, j| pairs[i][j]),
            Rule::LocalRatio => mixed(&|i, j| {
                let (a, b) = (len(parts[i]), len(parts[j]));
                if a.max(b) > 0.0 { 1.0 - a.min(b) / a.max(b) } else { 0.0 }
            }),
            Rule::OverlapExponent => {
                let (mut apart, mut all) = (0.0, f64::MIN_POSITIVE);
                for i in 0..parts.len() {
                    for j in 0..i {
                        let weight = len(parts[i]) * len(parts[j]);
                        apart += weight * pairs[i][j];
                        all += weight;
                    }
                }
                Rule::Norm(2.0 - apart / all).at_vertex(parts, pairs)
            }
        }
    }

    /// Whether the order of the dents matters. (Without blending the longest wins in any order.)
    pub fn ordered(self) -> bool {
        matches!(self, Rule::Remainder) || matches!(self, Rule::Blend(k) if k > 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two dents beside each other and one upon the first, on a strip of vertices.
    fn dents() -> Vec<Dent> {
        let vertices: Vec<[f32; 3]> = (0..60).map(|i| [0.02 * i as f32, 0.0, 0.0]).collect();
        let bowl = |centre: u32, depth: f32, lean: f32| {
            let u = |p: &[f32; 3]| {
                let q = ((p[0] - 0.02 * centre as f32) / 0.3).powi(2);
                let w = depth * (1.0 - q).max(0.0).powi(2);
                [lean * w, 0.0, -w]
            };
            Dent::new(&vertices.iter().map(u).collect::<Vec<_>>(), &vertices, centre)
        };
        vec![bowl(20, 0.03, 0.1), bowl(34, 0.05, -0.2), bowl(20, 0.02, 0.0)]
    }

    fn furthest(a: &Field64, b: &Field64) -> f64 {
        a.iter().zip(b).map(|(p, q)| len(add(*p, times(*q, -1.0)))).fold(0.0, f64::max)
    }

    #[test]
    fn rules_are_free_of_order_unless_they_say() {
        let d = dents();
        for (name, rule) in RULES {
            let forth = rule.combine(&[&d[0], &d[1], &d[2]]);
            let back = rule.combine(&[&d[2], &d[0], &d[1]]);
            let difference = furthest(&forth, &back);
            assert_eq!(difference > 1e-6, rule.ordered(), "{name}: {difference}");
        }
    }

    #[test]
    fn one_dent_is_itself_and_none_is_longer_than_the_sum() {
        let d = dents();
        for (name, rule) in RULES.into_iter().filter(|(name, _)| *name != "no dent") {
            assert!(furthest(&rule.combine(&[&d[1]]), &d[1].field) < 1e-4, "{name}");
            let all = rule.combine(&[&d[0], &d[1], &d[2]]);
            for (v, u) in all.iter().enumerate() {
                let lengths: f64 = d.iter().map(|d| len(d.field[v])).sum();
                assert!(len(*u) <= lengths + 1e-12, "{name} at {v}");
            }
        }
    }

    #[test]
    fn the_same_dent_again_grows_as_the_root_where_that_is_meant() {
        let d = dents();
        let four = [&d[0]; 4];
        let roots = ["p-norm 2", "overlap of fields", "overlap of marks", "overlap of contacts", "overlap as exponent"];
        for (name, rule) in RULES {
            let times_deeper = len(rule.combine(&four)[20]) / len(d[0].field[20]);
            let expected = match name {
                "sum" | "p-norm 1" => 4.0,
                _ if roots.contains(&name) || name == "local ratio" || name == "sum by deepest" => 2.0,
                "no dent" => 0.0,
                _ if name.starts_with("p-norm") => continue,
                _ => 1.0,
            };
            assert!((times_deeper - expected).abs() < 1e-6, "{name}: {times_deeper}");
        }
    }

    #[test]
    fn smooth_rules_do_not_tear() {
        let d = dents();
        let jump = |f: &Field64| f.windows(2).map(|w| len(add(w[0], times(w[1], -1.0)))).fold(0.0, f64::max);
        let steepest: f64 = d.iter().map(|d| jump(&d.field)).sum();
        for (name, rule) in RULES.into_iter().filter(|(_, rule)| !rule.ordered()) {
            let all = jump(&rule.combine(&[&d[0], &d[1], &d[2]]));
            assert!(all <= 1.5 * steepest, "{name}: {all} over {steepest}");
        }
    }
}
