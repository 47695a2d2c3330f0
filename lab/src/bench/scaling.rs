//! Time against the number of moved vertices and against threads: the paper's Tables 5.2 and 5.3, Figures 5.4 and 5.5.

use std::path::Path;

use anyhow::Result;

use super::measure::Times;
use super::report::{Aim, Row, Sense};
use super::sheet::Dent;
use super::sheets::{Measured, Sheets, of};
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
        t.comment("ms", "medians of interleaved runs: an example that moves every vertex of a sheet, positions only");
        t.comment("classic", "the classic kernel: entries of 16 bytes, state and base position a vertex");
        t.comment("memcpy", "copying as many positions, 12 bytes a vertex");
        t.comment("times", "as fast as: classic or memcpy over the method");
    }
    let counts = super::thread_counts(bench.quick);
    for size in SIZES.into_iter().filter(|s| !bench.quick || s.vertices() <= 300_000) {
        if !["crumple", "classic", "memcpy"].iter().any(|n| bench.wanted(&format!("scaling_{n}_{}_", size.name()))) {
            continue;
        }
        let sheets = Sheets::build(size.vertices(), &[Dent::whole([0.5; 2])], bench.tasks(2))?;
        let measured = sheets.measure(bench, &counts)?;
        for m in &measured {
            threads.row([
                m.method.to_owned(),
                m.threads.to_string(),
                sheets.vertices().to_string(),
                num(1e3 * m.times.median()),
                num(of(&measured, m.method, 1).median() / m.times.median()),
                format!("{:016x}", m.hash),
            ])?;
            if m.threads <= 2 {
                vertices.row(cells(m, &measured, &sheets))?;
                rows(bench, size, m, &measured, &sheets);
            }
        }
    }
    if let Some(out) = out {
        vertices.write(out, "speed_vertices.csv")?;
        threads.write(out, "speed_threads.csv")?;
    }
    Ok(())
}

fn cells(m: &Measured, all: &[Measured], sheets: &Sheets) -> [String; 12] {
    let s = m.times.median();
    [
        m.method.to_owned(),
        m.threads.to_string(),
        sheets.vertices().to_string(),
        sheets.moved.to_string(),
        num(1e3 * s),
        num(1e3 * m.times.quantile(0.25)),
        num(1e3 * m.times.quantile(0.75)),
        num(1e9 * s / sheets.moved as f64),
        num(of(all, "classic", m.threads).median() / s),
        num(of(all, "memcpy", m.threads).median() / s),
        m.times.runs().to_string(),
        format!("{:016x}", m.hash),
    ]
}

fn rows(bench: &Bench, size: Size, m: &Measured, all: &[Measured], sheets: &Sheets) {
    let name = format!("scaling_{}_{}", m.method, size.name());
    let per_vertex = |times: &Times| times.per(sheets.moved as f64);
    let row = Row::time(format!("{name}_t{}", m.threads), &per_vertex(&m.times), "ns/vertex");
    let classic = per_vertex(of(all, "classic", m.threads));
    bench.add(row.beside_time("classic", &classic, Sense::Speed).hash(m.hash));
    if m.threads == 2 {
        let row = Row::time(format!("{name}_t1_t2"), &m.times, "ms");
        let row = row.beside_time("one thread", of(all, m.method, 1), Sense::Speed).hash(m.hash);
        let aim = (m.is_ours() && sheets.vertices() >= SHARED_FROM).then_some(Aim::AtLeast(1.7));
        bench.add(Row { aim, ..row });
    }
}
