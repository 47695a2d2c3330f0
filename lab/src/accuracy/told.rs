//! How near single dents come to the truth by what a hit tells: the displacement that the truth left at the contact, its
//! depth alone, the blow as a rigid-body engine knows it, or the impulse alone. On every body and training set, on impacts
//! that no example shows.

use anyhow::Result;
use crumple::{Blow, Hit, InstanceOptions, Rule, Selection, SetOptions};

use super::law::{Law, Sees};
use super::methods::{Answer, Timer, answer, library};
use super::radial::Radial;
use crate::Options;
use crate::metric::{length, median, relative_l2, spread};
use crate::scene;
use crate::table::{Table, num};
use crate::truth::{Body, Field, Impact};

/// What a hit tells.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Told {
    Displacement,
    Depth,
    Blow,
    Impulse,
}

impl Told {
    const ALL: [Told; 4] = [Told::Displacement, Told::Depth, Told::Blow, Told::Impulse];

    fn name(self) -> &'static str {
        match self {
            Told::Displacement => "displacement",
            Told::Depth => "depth",
            Told::Blow => "blow",
            Told::Impulse => "impulse",
        }
    }

    fn sees(self) -> Sees {
        if self == Told::Impulse { Sees::Impulse } else { Sees::Striker }
    }
}

/// A hit that leaves less than this at the contact is weak, m: it should leave less than this in the prediction too.
const WEAK: f64 = 2e-3;
/// Above every dent, m.
const DEEP: f32 = 1.0;

/// What both tables begin with.
const HEAD: [&str; 7] = ["truth", "body", "train", "test", "told", "method", "examples"];
const SUMMARY: [&str; 9] = [
    "rel_l2_median",
    "rel_l2_p25",
    "rel_l2_p75",
    "rel_l2_p90",
    "depth_error_median",
    "us_per_impact",
    "n",
    "weak",
    "weak_kept",
];

struct Tables {
    summary: Table,
    impacts: Table,
}

pub fn run(options: &Options) -> Result<()> {
    let mut tables = Tables {
        summary: Table::new(&[&HEAD[..], &SUMMARY].concat()),
        impacts: Table::new(&[&HEAD[..], &["impact", "depth_mm", "predicted_mm", "rel_l2"]].concat()),
    };
    for t in [&mut tables.summary, &mut tables.impacts] {
        t.comment("command", "cargo xtask lab --only told");
        t.comment("error", "relative L2 of the displacement field over all vertices");
        t.comment("depth_error", "length of the displacement at the contact, relative to the truth's");
        t.comment(
            "weak",
            format!(
                "hits that leave less than {} mm at the contact; they are in no error; kept: predicted so too",
                1e3 * WEAK
            ),
        );
        t.comment("told", "blow: contact point and normal, impulse without restitution, mass, velocity and radius of the striker; impulse: point, normal and impulse");
    }
    for body in Body::read_all()? {
        let sets = [("train", &body.train), ("train_free", &body.train_free)];
        for (train, impacts) in sets.into_iter().filter(|(_, impacts)| !impacts.is_empty()) {
            let body = Body { train: impacts.clone(), ..body.clone() };
            case(&body, train, options, &mut tables)?;
        }
        // What no method can beat.
        let mut row = [body.truth.name(), body.name, "", "", "", "floor", "0"].map(str::to_owned).to_vec();
        row.extend(std::iter::repeat_n(num(body.truth.noise_floor(body.name)), 4));
        row.resize(HEAD.len() + SUMMARY.len(), String::new());
        tables.summary.row(row)?;
    }
    tables.summary.write(&options.out, "told.csv")?;
    tables.impacts.write(&options.out, "told_impacts.csv")?;
    Ok(())
}

/// The numbers of examples that are measured.
fn counts(body: &Body) -> Vec<usize> {
    [4, 8, 16, 24, body.train.len()].to_vec()
}

fn case(body: &Body, train: &str, options: &Options, tables: &mut Tables) -> Result<()> {
    let quick = options.quick;
    let timer = Timer::of(quick);
    let mut tests = vec![("heldout", super::heldout(body, quick))];
    let play: Vec<&Impact> = body.play.iter().take(if quick { 4 } else { usize::MAX }).collect();
    if !play.is_empty() {
        tests.push(("play", play));
    }
    let knows_blows = body.train.iter().any(|i| i.blow.is_some());
    let toldest = Told::ALL.into_iter().filter(|t| knows_blows || matches!(t, Told::Displacement | Told::Depth));
    let toldest: Vec<Told> = toldest.collect();
    let mut add = |told: Told, method: &str, examples: usize, of: &mut dyn FnMut(&Impact) -> Result<Answer>| {
        for (test, impacts) in &tests {
            let answers: Vec<Answer> = impacts.iter().map(|i| of(i)).collect::<Result<_>>()?;
            let head = [body.truth.name(), body.name, train, test, told.name(), method].map(str::to_owned);
            let head: Vec<String> = head.into_iter().chain([examples.to_string()]).collect();
            for (index, (impact, a)) in impacts.iter().zip(&answers).enumerate() {
                let tail = [
                    index.to_string(),
                    num(1e3 * impact.depth()),
                    num(1e3 * left(impact, a)),
                    num(relative_l2(&a.field, &impact.field)),
                ];
                tables.impacts.row(head.iter().chain(&tail))?;
            }
            tables.summary.row(head.iter().chain(&summary(impacts, &answers)))?;
        }
        Ok::<(), anyhow::Error>(())
    };

    let radial = Radial::fit(body);
    for told in &toldest {
        let law = Law::fit(&body.train, told.sees());
        add(*told, "radial", 0, &mut |impact| {
            let mut field = Field::new();
            let (_, target) = target(*told, law.as_ref(), impact, body);
            let as_told = Impact { displacement: target, field: Field::new(), ..impact.clone() };
            let us = timer.time(|| (), |()| radial.predict(body, &as_told, &mut field));
            Ok(answer(field, true, us, f64::NAN, body.vertices.len() as u64))
        })?;
    }
    for n in counts(body).into_iter().filter(|n| !quick || [4, 24].contains(n)) {
        let set = scene::set(body, n, SetOptions::default())?;
        // An example counts as moving a vertex from a tenth of a millimetre, as in `methods`.
        let cut = scene::set(body, n, SetOptions { drop_below: 1e-4, ..SetOptions::default() })?;
        let ours = InstanceOptions { depth_limit: Some(DEEP), ..Default::default() };
        let classic =
            InstanceOptions { selection: Selection::Classic, ..InstanceOptions::classic(Rule::MostDisplaced) };
        for told in &toldest {
            let law = Law::fit(&body.train[..n], told.sees());
            add(*told, "crumple", n, &mut |impact| library(&set, &ours, hit(*told, impact, body), &timer))?;
            add(*told, "classic", n, &mut |impact| {
                let (point, target) = target(*told, law.as_ref(), impact, body);
                library(&cut, &classic, Hit::displacement(point, target), &timer)
            })?;
        }
    }
    println!("told: {} {} {train}", body.truth.name(), body.name);
    Ok(())
}

/// What Crumple is told.
fn hit(told: Told, impact: &Impact, body: &Body) -> Hit {
    match (told, &impact.blow) {
        (Told::Blow, Some(_)) => scene::blow_hit(impact),
        (Told::Impulse, Some(known)) => {
            let known = known.in_engine();
            let blow = Blow { impulse: Some(known.impulse), normal: Some(known.normal), ..Blow::default() };
            Hit::blow(impact.point, blow)
        }
        _ => {
            let (point, target) = target(told, None, impact, body);
            Hit::displacement(point, target)
        }
    }
}

/// What a method is told that wants a displacement: the contact point and the target there.
fn target(told: Told, law: Option<&Law>, impact: &Impact, body: &Body) -> ([f32; 3], [f32; 3]) {
    let displacement = match (told, law, &impact.blow) {
        (Told::Displacement, ..) => impact.displacement,
        (Told::Blow | Told::Impulse, Some(law), Some(blow)) => law.displacement(&blow.in_engine()),
        _ => {
            let normal = impact.blow.map_or(body.normals[impact.contact_vertex as usize], |b| b.normal);
            normal.map(|n| -(impact.depth() as f32) * n)
        }
    };
    (impact.point, displacement)
}

/// Length of the predicted displacement at the contact, m.
fn left(impact: &Impact, answer: &Answer) -> f64 {
    length(answer.field[impact.contact_vertex as usize])
}

fn summary(impacts: &[&Impact], answers: &[Answer]) -> Vec<String> {
    let (weak, strong): (Vec<_>, Vec<_>) = impacts.iter().zip(answers).partition(|(i, _)| i.depth() < WEAK);
    let errors: Vec<f64> = strong.iter().map(|(i, a)| relative_l2(&a.field, &i.field)).collect();
    let depths: Vec<f64> = strong.iter().map(|(i, a)| (left(i, a) / i.depth() - 1.0).abs()).collect();
    let us: Vec<f64> = answers.iter().map(|a| a.us).collect();
    let kept = weak.iter().filter(|(i, a)| left(i, a) < WEAK).count();
    let numbers = [&spread(&errors)[..], &[median(&depths), median(&us)]].concat();
    let counts = [strong.len(), weak.len(), kept].map(|c| c.to_string());
    numbers.into_iter().map(num).chain(counts).collect()
}
