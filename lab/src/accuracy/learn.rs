//! Error against the number of examples, up to hundreds, on every body, beside a radial falloff and the classic rule. Told the
//! blow, or the displacement that the truth left at the contact.

use std::time::Instant;

use anyhow::Result;
use crumple::{Hit, Instance, InstanceOptions, Rule, Selection, SetOptions};

use super::law::{Law, Sees, target};
use super::radial::Radial;
use crate::Options;
use crate::metric::{bilinear, length, median, relative_l2, spread};
use crate::scene;
use crate::table::{Table, num};
use crate::truth::{Body, Field, Impact, Truth};

/// Hits that leave less than this at the contact are left out, m.
const WEAK: f64 = 2e-3;
/// Above every dent, m.
const DEEP: f32 = 1.0;
/// Largest number of examples of a quick run.
const QUICK: usize = 24;

const COLUMNS: [&str; 16] = [
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
    "left_out_error_median",
    "us_per_hit",
    "build_s",
    "bytes",
    "n",
];

/// What was measured of a method beside its fields.
#[derive(Default)]
struct Costs {
    left_out: Vec<f64>,
    us: Vec<f64>,
    build_s: f64,
    bytes: usize,
}

pub fn run(options: &Options) -> Result<()> {
    let mut table = Table::new(&COLUMNS);
    table.comment("command", "cargo xtask lab --only learn");
    table.comment("error", "relative L2 of the displacement field over all vertices; 1 is no dent at all");
    table.comment("left out", format!("hits that leave less than {} mm at the contact", 1e3 * WEAK));
    table.comment("told", "blow: contact point and normal, impulse, velocity, mass and radius of the striker");
    table.comment("log_size_error", "of the root of the sum of squares of the field, natural logarithm");
    table.comment("us_per_hit", "from the hit to the displacements of the nodes, the first time");
    table.comment("build_s", "making the set, in which it learns from its examples");
    table.comment("left_out_error", "of each example, predicted by the others");
    table.comment("methods", "classic: the literature's rule; it and radial are told the displacement of a law");
    for truth in Truth::ALL.into_iter().chain([Truth::Dense]) {
        for name in truth.bodies() {
            case(&training(truth, name)?, options, &mut table)?;
            println!("learn: {} {name}", truth.name());
        }
    }
    if !options.quick {
        mixed(&mut table)?;
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
        // An example counts as moving a vertex from a tenth of a millimetre, as in `methods`.
        let cut = scene::set(&known, n, SetOptions { drop_below: 1e-4, ..SetOptions::default() })?;
        let radial = Radial::fit(&known);
        for told in ["blow", "displacement"].into_iter().filter(|t| knows_blows || *t == "displacement") {
            let blows = told == "blow";
            let head = [body.truth.name(), body.name, test, told];
            let mut add =
                |method: &str, fields: &[Field], costs: &Costs| table.row(row(head, method, n, &hits, fields, costs));
            let hit = if blows { scene::blow_hit } else { scene::hit };
            let (fields, costs) = predicted(&known, &hits.iter().map(|i| hit(i)).collect::<Vec<_>>())?;
            add("crumple", &fields, &costs)?;
            let law = Law::fit(&known.train, Sees::Striker).filter(|_| blows);
            let target = |i: &Impact| target(law.as_ref(), i);
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
                hits.iter().map(|i| scene::field_after(&cut, &classic, &[Hit::displacement(i.point, target(i))]));
            add("classic", &fields.collect::<Result<Vec<_>>>()?, &Costs::default())?;
        }
    }
    Ok(())
}

/// Hits in play on the door, told the blow, by cheaper examples of a mesh with half as many points, carried onto its own, and by these and
/// its own in one set.
fn mixed(table: &mut Table) -> Result<()> {
    let own = training(Truth::Structure, "door")?;
    let cheap = carried(&training(Truth::Dense, "door")?, &own);
    let both = [own.train.clone(), cheap.clone()].concat();
    let hits: Vec<&Impact> = own.play.iter().filter(|i| i.depth() >= WEAK).collect();
    let told: Vec<Hit> = hits.iter().map(|i| scene::blow_hit(i)).collect();
    for train in [cheap, both] {
        let known = Body { train, ..own.clone() };
        let (fields, costs) = predicted(&known, &told)?;
        let head = ["structure and dense", own.name, "play", "blow"];
        table.row(row(head, "crumple", known.train.len(), &hits, &fields, &costs))?;
    }
    Ok(())
}

/// A body with all of its training impacts that leave a dent.
fn training(truth: Truth, name: &'static str) -> Result<Body> {
    let mut body = Body::read(truth, name)?.with_free();
    body.train.retain(|i| i.depth() >= WEAK);
    Ok(body)
}

/// The training impacts of a body on the mesh of another that is the same but for its grid: x along the rows, y along the columns.
fn carried(from: &Body, to: &Body) -> Vec<Impact> {
    let [rows, columns] = from.grid;
    let x: Vec<f32> = (0..rows).map(|i| from.vertices[i * columns][0]).collect();
    let y: Vec<f32> = (0..columns).map(|j| from.vertices[j][1]).collect();
    let place = |lines: &[f32], at: f32| {
        let k = lines.partition_point(|line| *line < at).clamp(1, lines.len() - 1) - 1;
        (k, (at - lines[k]) / (lines[k + 1] - lines[k]))
    };
    let cells: Vec<_> = to.vertices.iter().map(|p| (place(&x, p[0]), place(&y, p[1]))).collect();
    let carry = |impact: &Impact| {
        let corner = |i: usize, j: usize| impact.field[i * columns + j];
        let at = |((i, u), (j, w)): &((usize, f32), (usize, f32))| {
            bilinear([corner(*i, *j), corner(i + 1, *j), corner(*i, j + 1), corner(i + 1, j + 1)], *u, *w)
        };
        let field: Field = cells.iter().map(at).collect();
        let away = |v: &[f32; 3]| length([0, 1, 2].map(|k| v[k] - impact.point[k]));
        let nearest = to.vertices.iter().enumerate().min_by(|a, b| away(a.1).total_cmp(&away(b.1)));
        let vertex = nearest.map_or(0, |(v, _)| v);
        Impact { contact_vertex: vertex as u32, displacement: field[vertex], field, ..impact.clone() }
    };
    from.train.iter().map(carry).collect()
}

/// One row of the table. `head` is the truth, the body, the test, and what is told.
fn row(head: [&str; 4], method: &str, n: usize, hits: &[&Impact], fields: &[Field], costs: &Costs) -> Vec<String> {
    let errors: Vec<f64> = fields.iter().zip(hits).map(|(f, i)| relative_l2(f, &i.field)).collect();
    let sizes: Vec<f64> =
        fields.iter().zip(hits).map(|(f, i)| (size(f).max(1e-9) / size(&i.field)).ln().abs()).collect();
    let or_nothing = |x: &[f64]| if x.is_empty() { f64::NAN } else { median(x) };
    let of_costs = [
        or_nothing(&costs.left_out),
        or_nothing(&costs.us),
        if costs.build_s > 0.0 { costs.build_s } else { f64::NAN },
    ];
    let numbers = [&spread(&errors)[..], &[median(&sizes)], &of_costs].concat();
    let tail = [costs.bytes.to_string(), hits.len().to_string()];
    let head = head.into_iter().chain([method]).map(str::to_owned).chain([n.to_string()]);
    head.chain(numbers.into_iter().map(num)).chain(tail).collect()
}

/// The fields that a set of all these examples predicts.
fn predicted(body: &Body, hits: &[Hit]) -> Result<(Vec<Field>, Costs)> {
    let start = Instant::now();
    let set = scene::with_nodes(body, body.train.len())?;
    let build_s = start.elapsed().as_secs_f64();
    let left_out = set.example_errors().into_iter().map(f64::from).collect();
    let mut costs = Costs { build_s, left_out, bytes: set.memory_bytes(), ..Costs::default() };
    let ours = InstanceOptions { depth_limit: Some(DEEP), ..InstanceOptions::default() };
    let mut out = Vec::new();
    for hit in hits {
        let mut body = Instance::new(set.clone(), ours)?;
        let start = Instant::now();
        body.submit(hit)?;
        body.fold();
        costs.us.push(1e6 * start.elapsed().as_secs_f64());
        out.push(scene::displacements(&mut body)?);
    }
    Ok((out, costs))
}

/// Root of the sum of squares, m.
fn size(field: &Field) -> f64 {
    field.iter().map(|u| length(*u).powi(2)).sum::<f64>().sqrt()
}
