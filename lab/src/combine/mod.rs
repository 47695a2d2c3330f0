//! How several dents combine: after the last impact of a sequence, each rule against the truth.

mod rules;

use anyhow::Result;
use crumple::{
    Contact, Deltas, ExampleData, ExampleSet, Hit, InstanceOptions, Rule as LibraryRule, Serial, SetOptions,
};
use std::sync::Arc;

use crate::Options;
use crate::metric::{deepest, edges, inverted, largest_jump, length, median, quantile, relative_l2};
use crate::scene;
use crate::table::{Table, num};
use crate::truth::{Body, Field};
use rules::{Dent, Field64, RULES};

/// Examples of the sets that predict dents end to end.
const EXAMPLES: usize = 24;
/// Above every dent, m: the rules are compared, not the limit.
const DEEP: f32 = 1.0;

/// Several impacts with the truth after the last.
struct Case {
    /// `overlap`, `random`, `repeat`, `press`, or `again` (one impact eight times).
    kind: String,
    name: String,
    dents: Vec<Dent>,
    hits: Vec<Hit>,
    contacts: Vec<u32>,
    truth: Field,
}

/// What is measured about a case.
struct Score {
    rel_l2: f64,
    seam: f64,
    retention: Vec<f64>,
    order: f64,
    depth: f64,
    inverted: i64,
}

pub fn run(options: &Options) -> Result<()> {
    let examples = if options.quick { 6 } else { EXAMPLES };
    let mut table = Table::new(&[
        "source",
        "rule",
        "ordered",
        "truth",
        "body",
        "kind",
        "rel_l2_median",
        "rel_l2_p90",
        "rel_l2_max",
        "seam_median",
        "seam_worst",
        "retention_mean",
        "retention_worst",
        "order_worst",
        "depth_ratio_median",
        "inverted_worst",
        "n",
    ]);
    let mut each = Table::new(&[
        "source",
        "rule",
        "truth",
        "body",
        "kind",
        "name",
        "impacts",
        "rel_l2",
        "seam",
        "retention_mean",
        "retention_worst",
        "order",
        "depth_ratio",
        "inverted",
    ]);
    for t in [&mut table, &mut each] {
        t.comment("command", "cargo xtask lab --only combine");
        t.comment("source", format!("true singles: each impact's own true dent, only the rule is wrong; predicted: the library's dents with {examples} examples"));
        t.comment("seam", "largest difference of displacement across an edge, over the truth's");
        t.comment(
            "retention",
            "displacement kept at the contacts of all but the last impact, over the truth's, along it",
        );
        t.comment(
            "order",
            "largest difference at any vertex between any two orders of the impacts, over the truth's deepest dent",
        );
        t.comment("inverted", "triangles turned by more than 90 degrees, beyond the truth's");
        t.comment(
            "kind",
            "press: presses; overlap, random, repeat: shots; all: those together; again: one shot eight times",
        );
    }
    for body in Body::read_smooth()? {
        let cases = cases(&body, options.quick);
        for kind in ["all", "overlap", "random", "repeat", "press", "again"] {
            let count = cases.iter().filter(|c| is(c, kind)).count();
            if count > 0 {
                table.comment("n", format!("{} {} {kind}: {count} sequences", body.truth.name(), body.name));
            }
        }
        let edges = edges(&body.triangles);
        let mut add = |source: &str, rule: &str, ordered: bool, make: &dyn Fn(&Case, &[usize]) -> Result<Field>| {
            let scores =
                cases.iter().map(|c| score(&body, &edges, c, ordered, &|o| make(c, o))).collect::<Result<Vec<_>>>()?;
            for (case, s) in cases.iter().zip(&scores) {
                let head = [source, rule, body.truth.name(), body.name, &case.kind, &case.name].map(str::to_owned);
                let numbers = [
                    s.rel_l2,
                    s.seam,
                    mean(&s.retention),
                    quantile(&s.retention, 0.0),
                    s.order,
                    s.depth,
                    s.inverted as f64,
                ];
                let impacts = [case.hits.len().to_string()];
                each.row(head.into_iter().chain(impacts).chain(numbers.map(num)))?;
            }
            for kind in ["all", "overlap", "random", "repeat", "press", "again"] {
                let of: Vec<&Score> = cases.iter().zip(&scores).filter(|(c, _)| is(c, kind)).map(|(_, s)| s).collect();
                if of.is_empty() {
                    continue;
                }
                let ordered = if ordered { "yes" } else { "no" };
                let head = [source, rule, ordered, body.truth.name(), body.name, kind].map(str::to_owned);
                table.row(head.into_iter().chain(summary(&of)).chain([of.len().to_string()]))?;
            }
            Ok::<(), anyhow::Error>(())
        };
        for (name, rule) in RULES {
            add("true singles", name, rule.ordered(), &|case, order| {
                let dents: Vec<&Dent> = order.iter().map(|i| &case.dents[*i]).collect();
                Ok(narrow(&rule.combine(&dents)))
            })?;
        }
        let deep = InstanceOptions { depth_limit: Some(DEEP), ..Default::default() };
        add("true singles", "energies", false, &|case, order| after(&own_set(&body, case)?, &deep, case, order))?;
        let set = scene::set(&body, examples, SetOptions::default())?;
        for (name, options) in [("energies", &deep), ("all defaults", &InstanceOptions::default())] {
            add("predicted", name, false, &|case, order| after(&set, options, case, order))?;
        }
        let options = SetOptions { drop_below: 1e-4, ..SetOptions::default() };
        let set = scene::set(&body, examples, options)?;
        for (name, rule) in [
            ("classic, most displaced", LibraryRule::MostDisplaced),
            ("classic, blend k=0.1", LibraryRule::Blend(0.1)),
            ("classic, blend k=0.5", LibraryRule::Blend(0.5)),
        ] {
            let classic = InstanceOptions::classic(rule);
            add("predicted", name, true, &|case, order| after(&set, &classic, case, order))?;
        }
        println!("combine: {} {}, {} sequences", body.truth.name(), body.name, cases.len());
    }
    table.write(&options.out, "combine.csv")?;
    each.write(&options.out, "combine_sequences.csv")?;
    Ok(())
}

fn is(case: &Case, kind: &str) -> bool {
    case.kind == kind || (kind == "all" && case.kind != "again")
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn summary(scores: &[&Score]) -> Vec<String> {
    let of = |f: &dyn Fn(&Score) -> f64| scores.iter().map(|s| f(s)).collect::<Vec<f64>>();
    let errors = of(&|s| s.rel_l2);
    let seams = of(&|s| s.seam);
    let kept: Vec<f64> = scores.iter().flat_map(|s| s.retention.iter().copied()).collect();
    [
        median(&errors),
        quantile(&errors, 0.9),
        quantile(&errors, 1.0),
        median(&seams),
        quantile(&seams, 1.0),
        mean(&kept),
        quantile(&kept, 0.0),
        quantile(&of(&|s| s.order), 1.0),
        median(&of(&|s| s.depth)),
        quantile(&of(&|s| s.inverted as f64), 1.0),
    ]
    .map(num)
    .to_vec()
}

fn narrow(field: &Field64) -> Field {
    field.iter().map(|u| u.map(|x| x as f32)).collect()
}

fn cases(body: &Body, quick: bool) -> Vec<Case> {
    let dent = |i: &crate::truth::Impact| Dent::new(&i.field, &body.vertices, i.contact_vertex);
    let mut cases: Vec<Case> = body
        .sequences
        .iter()
        .take(if quick { 2 } else { usize::MAX })
        .map(|s| Case {
            kind: s.kind.clone(),
            name: s.name.clone(),
            dents: s.impacts.iter().map(dent).collect(),
            hits: s.impacts.iter().map(scene::hit).collect(),
            contacts: s.impacts.iter().map(|i| i.contact_vertex).collect(),
            truth: s.after[s.after.len() - 1].clone(),
        })
        .collect();
    for repeat in &body.repeats {
        let (impact, times) = (&body.train[repeat.train], repeat.after.len());
        cases.push(Case {
            kind: "again".into(),
            name: format!("{} {times} times", impact.source),
            dents: vec![dent(impact); times],
            hits: vec![scene::hit(impact); times],
            contacts: vec![impact.contact_vertex; times],
            truth: repeat.after[times - 1].clone(),
        });
    }
    cases
}

/// A set whose examples are the true single dents of a sequence, so that each hit repeats its own.
fn own_set(body: &Body, case: &Case) -> Result<Arc<ExampleSet>> {
    let mut examples: Vec<ExampleData> = Vec::new();
    for (dent, contact) in case.dents.iter().zip(&case.contacts) {
        let example = ExampleData {
            contact: Some(Contact::Vertex(*contact)),
            ..ExampleData::new(format!("{}", examples.len()), Deltas::Full(narrow(&dent.field)))
        };
        if !examples.iter().any(|e| e.contact == example.contact && e.positions == example.positions) {
            examples.push(example);
        }
    }
    Ok(Arc::new(ExampleSet::build(scene::mesh(body), examples, SetOptions::default(), &Serial)?))
}

fn after(set: &Arc<ExampleSet>, options: &InstanceOptions, case: &Case, order: &[usize]) -> Result<Field> {
    let hits: Vec<Hit> = order.iter().map(|i| case.hits[*i]).collect();
    scene::field_after(set, options, &hits)
}

fn score(
    body: &Body,
    edges: &[[u32; 2]],
    case: &Case,
    ordered: bool,
    make: &dyn Fn(&[usize]) -> Result<Field>,
) -> Result<Score> {
    let as_it_was: Vec<usize> = (0..case.hits.len()).collect();
    let field = make(&as_it_was)?;
    let along = |u: [f32; 3], t: [f32; 3]| {
        let dot: f64 = (0..3).map(|k| f64::from(u[k]) * f64::from(t[k])).sum();
        dot / length(t).powi(2)
    };
    let earlier = &case.contacts[..case.contacts.len() - 1];
    let mut order: f64 = 0.0;
    // Equal impacts have one order only; orders of the others are few (at most 24).
    if case.kind != "again" {
        let orders =
            if ordered { permutations(as_it_was.len()) } else { vec![as_it_was.iter().rev().copied().collect()] };
        let fields = orders.iter().map(|o| make(o)).collect::<Result<Vec<_>>>()?;
        for (i, a) in fields.iter().enumerate() {
            for b in fields[..i].iter().chain([&field]) {
                order = order.max(1e-3 * crate::metric::max_error_mm(a, b));
            }
        }
    }
    let folded = |f: &Field| inverted(f, &body.vertices, &body.triangles) as i64;
    Ok(Score {
        rel_l2: relative_l2(&field, &case.truth),
        seam: largest_jump(&field, edges) / largest_jump(&case.truth, edges),
        retention: earlier.iter().map(|c| along(field[*c as usize], case.truth[*c as usize])).collect(),
        order: order / deepest(&case.truth),
        depth: deepest(&field) / deepest(&case.truth),
        inverted: folded(&field) - folded(&case.truth),
    })
}

/// All orders of `n` things.
fn permutations(n: usize) -> Vec<Vec<usize>> {
    let mut all = vec![Vec::new()];
    for next in 0..n {
        all = all
            .into_iter()
            .flat_map(|p: Vec<usize>| {
                (0..=p.len()).map(move |at| {
                    let mut q = p.clone();
                    q.insert(at, next);
                    q
                })
            })
            .collect();
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_orders_once() {
        let mut all = permutations(4);
        all.sort();
        all.dedup();
        assert_eq!(all.len(), 24);
    }
}
