//! Time against the number of moved vertices and against threads: the literature's Tables 5.2 and 5.3, Figures 5.4 and 5.5.

use std::path::Path;

use anyhow::Result;

use super::report::{Aim, Row, Sense};
use super::sheet::Dent;
use super::sheets::{Sheets, of};
use super::width::Width;
use super::{Bench, Size};
use crate::table::{Table, num};

const SIZES: [Size; 7] = [Size::K10, Size::K30, Size::K100, Size::K300, Size::M1, Size::M3, Size::M10];
/// From here on a frame is long enough for two threads to be told to share it.
const SHARED_FROM: usize = 1_000_000;

/// Measures, adds rows, and writes `speed_vertices.csv` and `speed_threads.csv` where `out` is given.
pub fn run(bench: &Bench, out: Option<&Path>) -> Result<()> {
    let mut vertices = Table::threaded(&[
        "method",
        "threads",
        "vertices",
        "moved_vertices",
        "ms",
        "ms_p25",
        "ms_p75",
        "ns_per_moved_vertex",
        "times_classic",
        "times_memcpy",
        "runs",
        "hash",
    ]);
    let mut threads = Table::threaded(&["method", "threads", "vertices", "ms", "speedup", "hash"]);
    for t in [&mut vertices, &mut threads] {
        t.comment("command", "cargo xtask lab --only speed");
        t.comment(
            "ms",
            "medians of interleaved runs: an anchored example that moves every vertex of a sheet, positions only",
        );
        t.comment("classic", "the literature's kernel: entries of 16 bytes, state and base position a vertex");
        t.comment("memcpy", "copying as many positions, 12 bytes a vertex");
        t.comment("times", "as fast as: classic or memcpy over the method");
    }
    let counts = super::thread_counts(bench.quick);
    for size in SIZES.into_iter().filter(|s| !bench.quick || s.vertices() <= 300_000) {
        let names = Width::ALL.map(Width::name).into_iter().chain(["classic", "memcpy"]);
        if !names.into_iter().any(|n| bench.wanted(&format!("scaling_{n}_{}_", size.name()))) {
            continue;
        }
        let sheets = Sheets::build(size.vertices(), &[Dent::whole([0.5; 2])], bench.tasks(2))?;
        let mut single: Vec<(&str, f64)> = Vec::new();
        for &count in &counts {
            let measured = sheets.measure(&bench.plan, bench.tasks(count))?;
            let (classic, memcpy) = (of(&measured, "classic").median(), of(&measured, "memcpy").median());
            for m in &measured {
                let s = m.times.median();
                let per_vertex = m.times.per(sheets.moved as f64);
                let hash = format!("{:016x}", m.hash);
                if count <= 2 {
                    vertices.row([
                        m.method.to_owned(),
                        count.to_string(),
                        sheets.vertices().to_string(),
                        sheets.moved.to_string(),
                        num(1e3 * s),
                        num(1e3 * m.times.quantile(0.25)),
                        num(1e3 * m.times.quantile(0.75)),
                        num(1e9 * per_vertex.median()),
                        num(classic / s),
                        num(memcpy / s),
                        m.times.runs().to_string(),
                        hash.clone(),
                    ])?;
                    let row =
                        Row::time(format!("scaling_{}_{}_t{count}", m.method, size.name()), &per_vertex, "ns/vertex");
                    let classic = of(&measured, "classic").per(sheets.moved as f64);
                    bench.add(row.beside_time("classic", &classic, Sense::Speed).hash(m.hash));
                }
                if count == 1 {
                    single.push((m.method, s));
                }
                let alone = single.iter().find(|(name, _)| *name == m.method).map_or(f64::NAN, |(_, s)| *s);
                threads.row([
                    m.method.to_owned(),
                    count.to_string(),
                    sheets.vertices().to_string(),
                    num(1e3 * s),
                    num(alone / s),
                    hash,
                ])?;
                if count == 2 {
                    let row = Row::time(format!("scaling_{}_{}_t1_t2", m.method, size.name()), &m.times, "ms");
                    let row = row.beside("one thread", 1e3 * alone, Sense::Speed).hash(m.hash);
                    let ours = m.method != "classic" && m.method != "memcpy";
                    let aim = (ours && sheets.vertices() >= SHARED_FROM).then_some(Aim::AtLeast(1.7));
                    bench.add(Row { aim, ..row });
                }
            }
        }
    }
    if let Some(out) = out {
        vertices.write(out, "speed_vertices.csv")?;
        threads.write(out, "speed_threads.csv")?;
    }
    Ok(())
}
