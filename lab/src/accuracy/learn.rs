//! Error against the number of examples, up to hundreds, on every body: the rule that learns from all examples, beside
//! 0.1.0's, a radial falloff and the classic rule. Told the blow, or the displacement that the truth left at the contact.

use std::collections::BTreeMap;
use std::time::Instant;

use anyhow::Result;
use crumple::glam::Vec3;
use crumple::predict::{self, LearnOptions, Predictor, Scratch, Told};
use crumple::{Hit, InstanceOptions, Mirror, Placement, Rule, Selection, Serial, SetOptions};

use super::law::{Law, Sees};
use super::radial::Radial;
use crate::Options;
use crate::metric::{length, median, quantile, relative_l2};
use crate::scene;
use crate::table::{Table, num};
use crate::truth::{Body, Field, Impact, Truth};

/// Hits that leave less than this at the contact are left out, m.
const WEAK: f64 = 2e-3;
/// Above every dent, m.
const DEEP: f32 = 1.0;
/// Largest number of examples of a quick run.
const QUICK: usize = 24;

const COLUMNS: [&str; 17] = [
    "truth",
    "body",
    "test",
    "told",
    "method",
    "examples",
    "rel_l2_median",
    "rel_l2_p25",
    "rel_l2_p75",
    "rel_l2_p90",
    "log_size_error_median",
    "expected_error_median",
    "left_out_error_median",
    "us_per_hit",
    "learn_s",
    "bytes",
    "n",
];

/// What was measured of a method beside its fields.
#[derive(Default)]
struct Costs {
    expected: Vec<f64>,
    left_out: Vec<f64>,
    us: Vec<f64>,
    learn_s: f64,
    bytes: usize,
}

pub fn run(options: &Options) -> Result<()> {
    let mut table = Table::new(&COLUMNS);
    table.comment("command", "cargo xtask lab --only learn");
    table.comment("error", "relative L2 of the displacement field over all vertices; 1 is no dent at all");
    table.comment("left out", format!("hits that leave less than {} mm at the contact", 1e3 * WEAK));
    table.comment("told", "blow: contact point and normal, velocity, mass, radius and kind of the striker (learned), the same and the impulse, no kind (crumple)");
    table.comment("log_size_error", "of the root of the sum of squares of the field, natural logarithm");
    table.comment("us_per_hit", "learned: from the hit to the displacements of all vertices");
    table.comment("methods", "learned: predict; crumple: 0.1.0's three nearest examples; classic: the literature's rule, told the displacement of a law");
    for truth in Truth::ALL.into_iter().chain([Truth::Dense]) {
        for name in truth.bodies() {
            let mut body = Body::read(truth, name)?;
            let free = std::mem::take(&mut body.train_free);
            body.train.extend(free);
            body.train.retain(|i| i.depth() >= WEAK);
            case(&body, options, &mut table)?;
            println!("learn: {} {name}", truth.name());
        }
    }
    table.write(&options.out, "learn.csv")?;
    Ok(())
}

fn case(body: &Body, options: &Options, table: &mut Table) -> Result<()> {
    let (test, hits) = if body.play.is_empty() { ("heldout", &body.heldout) } else { ("play", &body.play) };
    let mut hits: Vec<&Impact> = hits.iter().filter(|i| i.depth() >= WEAK).collect();
    if options.quick {
        hits.truncate(4);
    }
    let all = body.train.len();
    let mut counts: Vec<usize> = [4, 8, 24, 100, all].into_iter().filter(|n| *n <= all).collect();
    counts.dedup();
    if options.quick {
        counts.retain(|n| *n <= QUICK);
    }
    let knows_blows = body.train.iter().any(|i| i.blow.is_some());
    for n in counts {
        let known = Body { train: body.train[..n].to_vec(), ..body.clone() };
        let automatic = scene::set(&known, n, Placement::Automatic, SetOptions::default())?;
        let anchored =
            scene::set(&known, n, Placement::Anchored, SetOptions { drop_below: 1e-4, ..SetOptions::default() })?;
        let radial = Radial::fit(&known);
        for told in ["blow", "displacement"].into_iter().filter(|t| knows_blows || *t == "displacement") {
            let blows = told == "blow";
            let mut add = |method: &str, fields: &[Field], costs: &Costs| {
                let head = [body.truth.name(), body.name, test, told, method].map(str::to_owned);
                let errors: Vec<f64> = fields.iter().zip(&hits).map(|(f, i)| relative_l2(f, &i.field)).collect();
                let sizes: Vec<f64> =
                    fields.iter().zip(&hits).map(|(f, i)| (size(f).max(1e-9) / size(&i.field)).ln().abs()).collect();
                let or_nothing = |x: &[f64]| if x.is_empty() { f64::NAN } else { median(x) };
                let numbers = [
                    median(&errors),
                    quantile(&errors, 0.25),
                    quantile(&errors, 0.75),
                    quantile(&errors, 0.9),
                    median(&sizes),
                    or_nothing(&costs.expected),
                    or_nothing(&costs.left_out),
                    or_nothing(&costs.us),
                    if costs.learn_s > 0.0 { costs.learn_s } else { f64::NAN },
                ];
                let numbers = numbers.into_iter().map(num);
                let tail = [costs.bytes.to_string(), hits.len().to_string()];
                table.row(head.into_iter().chain([n.to_string()]).chain(numbers).chain(tail))
            };
            let (fields, costs) = learned(&known, &hits, blows)?;
            add("learned", &fields, &costs)?;
            let ours = InstanceOptions { depth_limit: Some(DEEP), ..InstanceOptions::default() };
            let hit = |i: &Impact| match &i.blow {
                Some(blow) if blows => Hit::blow(i.point, scene::blow(&blow.in_engine())),
                _ => scene::hit(i),
            };
            let fields = hits.iter().map(|i| scene::field_after(&automatic, &ours, &[hit(i)]));
            add("crumple", &fields.collect::<Result<Vec<_>>>()?, &Costs::default())?;
            let law = Law::fit(&known.train, Sees::Striker);
            let target = |i: &Impact| match (&law, &i.blow) {
                (Some(law), Some(blow)) if blows => law.displacement(&blow.in_engine()),
                _ => i.displacement,
            };
            let fields = hits.iter().map(|i| {
                let mut field = Field::new();
                radial.predict(
                    &known,
                    &Impact { displacement: target(i), field: Field::new(), ..(*i).clone() },
                    &mut field,
                );
                field
            });
            add("radial", &fields.collect::<Vec<_>>(), &Costs::default())?;
            let classic =
                InstanceOptions { selection: Selection::Classic, ..InstanceOptions::classic(Rule::MostDisplaced) };
            let fields =
                hits.iter().map(|i| scene::field_after(&anchored, &classic, &[Hit::displacement(i.point, target(i))]));
            add("classic", &fields.collect::<Result<Vec<_>>>()?, &Costs::default())?;
        }
    }
    Ok(())
}

/// The fields of the rule that learns from all examples.
fn learned(body: &Body, hits: &[&Impact], blows: bool) -> Result<(Vec<Field>, Costs)> {
    let points: Vec<Vec3> = body.vertices.iter().map(|p| Vec3::from_array(*p)).collect();
    let normals: Vec<Vec3> = body.normals.iter().map(|n| Vec3::from_array(*n)).collect();
    let (low, high) = points.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(a, b), p| (a.min(*p), b.max(*p)));
    let centre = 0.5 * (low + high);
    let mirror = planes(&points, low, high);
    let fields: Vec<Vec<Vec3>> =
        body.train.iter().map(|i| i.field.iter().map(|u| Vec3::from_array(*u)).collect()).collect();
    let mut sources = BTreeMap::new();
    let samples: Vec<predict::Sample> = body
        .train
        .iter()
        .zip(&fields)
        .map(|(impact, field)| {
            let next = sources.len() as u32;
            predict::Sample {
                contact: Vec3::from_array(impact.point),
                normal: normal(body, impact),
                blow: blow(impact).filter(|_| blows),
                field,
                source: *sources.entry(impact.source.clone()).or_insert(next),
            }
        })
        .collect();
    let start = Instant::now();
    let body_now = predict::Body { points: &points, normals: &normals, mirror, centre };
    let predictor = Predictor::learn(&body_now, &samples, &LearnOptions::default(), &Serial)?;
    let mut costs = Costs {
        learn_s: start.elapsed().as_secs_f64(),
        bytes: predictor.bytes(),
        left_out: predictor.learned().errors.iter().map(|e| f64::from(*e)).collect(),
        ..Costs::default()
    };
    let (mut scratch, mut moved) = (Scratch::default(), Vec::new());
    let mut out = Vec::new();
    for impact in hits {
        let told = match blow(impact) {
            Some(blow) if blows => Told::Blow(blow),
            _ => Told::Displacement(Vec3::from_array(impact.displacement)),
        };
        let hit = predict::Hit { contact: Vec3::from_array(impact.point), normal: normal(body, impact), told };
        let mut times = Vec::new();
        for _ in 0..5 {
            let start = Instant::now();
            let prediction = predictor.predict(&hit, &mut scratch, &mut moved);
            times.push(1e6 * start.elapsed().as_secs_f64());
            if times.len() == 1 {
                costs.expected.push(f64::from(prediction.expected_error));
            }
        }
        costs.us.push(median(&times));
        let mut field = vec![[0.0; 3]; points.len()];
        moved.iter().for_each(|(v, u)| field[*v as usize] = u.to_array());
        out.push(field);
    }
    Ok((out, costs))
}

/// The coordinate planes that map every vertex onto a vertex.
fn planes(points: &[Vec3], low: Vec3, high: Vec3) -> Mirror {
    let tolerance = 1e-3 * (high - low).length();
    let key = |p: Vec3| (p / tolerance).round().as_ivec3();
    let mut cells: BTreeMap<[i32; 3], Vec<Vec3>> = BTreeMap::new();
    points.iter().for_each(|p| cells.entry(key(*p).to_array()).or_default().push(*p));
    let near = |p: Vec3| {
        let k = key(p);
        let shifts = (0..27).map(|s| k + crumple::glam::IVec3::new(s / 9 - 1, s / 3 % 3 - 1, s % 3 - 1));
        shifts.into_iter().filter_map(|k| cells.get(&k.to_array())).flatten().any(|q| (*q - p).length() < tolerance)
    };
    let mapped = |axis: usize| {
        (high - low)[axis] > 0.1 * (high - low).length()
            && points.iter().all(|p| {
                let mut image = *p;
                image[axis] = low[axis] + high[axis] - image[axis];
                near(image)
            })
    };
    Mirror::from_bits((0..3).filter(|axis| mapped(*axis)).map(|axis| 1 << axis).sum())
}

fn normal(body: &Body, impact: &Impact) -> Vec3 {
    Vec3::from_array(impact.blow.map_or(body.normals[impact.contact_vertex as usize], |b| b.normal))
}

fn blow(impact: &Impact) -> Option<predict::Blow> {
    impact.blow.map(|b| predict::Blow {
        velocity: Some(Vec3::from_array(b.velocity)),
        impulse: None,
        mass: Some(b.mass),
        radius: Some(b.radius),
        kind: Some(u32::from(b.pole)),
    })
}

/// Root of the sum of squares, m.
fn size(field: &Field) -> f64 {
    field.iter().map(|u| length(*u).powi(2)).sum::<f64>().sqrt()
}
