//! What a run on one device found: printed as it comes, and written as CSV.

use std::path::{Path, PathBuf};

use anyhow::Result;

use super::aims::{Goal, goal};
use super::check::Agreement;
use super::engine::Gpu;
use crate::bench::measure::Times;
use crate::bench::report::{Report, Row, Sense};
use crate::table::{Table, num};

/// One figure.
#[derive(Debug, Clone)]
pub struct Finding {
    workload: &'static str,
    /// What was measured.
    method: String,
    /// Of the method: a workgroup's size, a number of marks or instances; empty where there is but one.
    case: String,
    /// Vertices that move in one run.
    vertices: usize,
    /// Bytes a vertex that must move.
    bytes: Option<f64>,
    /// Seconds of a copy of as many bytes.
    copy: Option<f64>,
    goal: Option<&'static Goal>,
    /// How the result was held against the CPU's.
    check: String,
    /// The 90th percentile, in the row's unit.
    p90: f64,
    seconds: f64,
    row: Row,
}

impl Finding {
    /// The median of `times`, in `unit` (ms or µs).
    pub fn time(
        workload: &'static str,
        method: &str,
        case: &str,
        vertices: usize,
        times: &Times,
        unit: &'static str,
    ) -> Self {
        let row = Row::time(name(workload, method, case, vertices), times, unit);
        let p90 = row.value / times.median() * times.quantile(0.9);
        Finding { p90, seconds: times.median(), ..Self::new(workload, method, case, vertices, row) }
    }

    /// A value that is no time.
    pub fn value(workload: &'static str, method: &str, vertices: usize, value: f64, unit: &'static str) -> Self {
        let row = Row::new(name(workload, method, "", vertices), value, unit);
        Self::new(workload, method, "", vertices, row)
    }

    fn new(workload: &'static str, method: &str, case: &str, vertices: usize, row: Row) -> Self {
        let (method, case) = (method.to_owned(), case.to_owned());
        let (bytes, copy, goal, check) = (None, None, None, String::new());
        Finding { workload, method, case, vertices, bytes, copy, goal, check, p90: f64::NAN, seconds: f64::NAN, row }
    }

    /// The result was held against the CPU's.
    pub fn checked(self, agreement: Agreement) -> Self {
        Finding { check: agreement.to_string(), row: self.row.hash(agreement.hash), ..self }
    }

    /// So many bytes a vertex must move, and a copy of as many took so long.
    pub fn moving(self, bytes: f64, copy: &Times) -> Self {
        Finding { bytes: Some(bytes), copy: Some(copy.median()), ..self }
    }

    /// So many bytes a vertex must move.
    pub fn bytes(self, bytes: f64) -> Self {
        Finding { bytes: Some(bytes), ..self }
    }

    pub fn beside(self, name: &str, times: &Times, sense: Sense) -> Self {
        Finding { row: self.row.beside_time(name, times, sense), ..self }
    }

    /// The aim of that name, which is judged on software drivers only where it is for everything.
    pub fn aim(self, name: &str) -> Self {
        let goal = goal(name);
        let row = Row { judged: goal.everywhere, ..self.row.aim(goal.aim) };
        Finding { row, goal: Some(goal), ..self }
    }

    /// The same, if this is the figure that it is for.
    pub fn aim_if(self, here: bool, name: &str) -> Self {
        if here { self.aim(name) } else { self }
    }

    /// GB/s that must move.
    fn bandwidth(&self) -> f64 {
        self.bytes.map_or(f64::NAN, |b| b * self.vertices as f64 / self.seconds / 1e9)
    }
}

/// 1000 is 1k, 1000000 is 1m; in three digits.
pub fn short(count: usize) -> String {
    let three = |x: f64| if x < 100.0 { num((10.0 * x).round() / 10.0) } else { num(x.round()) };
    match count {
        999_500.. => format!("{}m", three(count as f64 / 1e6)),
        1000.. => format!("{}k", three(count as f64 / 1e3)),
        _ => count.to_string(),
    }
}

fn name(workload: &str, method: &str, case: &str, vertices: usize) -> String {
    let parts = [workload, &method.replace(' ', "_"), case];
    let mut name = parts.into_iter().filter(|p| !p.is_empty()).collect::<Vec<_>>().join("_");
    if vertices > 0 {
        name = format!("{name}_{}", short(vertices));
    }
    name
}

/// All of a device's, so far.
#[derive(Default)]
pub struct Findings {
    report: Report,
    all: Vec<Finding>,
    /// What could not be measured, and why.
    left_out: Vec<String>,
    /// What the machine was busy with before: tasks running or waiting.
    pub load: Option<f64>,
}

impl Findings {
    /// What the rows that follow are.
    pub fn group(&mut self, name: &str, about: &str) {
        self.report.group(name, about);
    }

    /// Adds a figure of `gpu`; aims that are for real cards are shown but not judged on software drivers.
    pub fn add(&mut self, gpu: &Gpu, mut finding: Finding) {
        finding.row.judged |= !gpu.software;
        self.report.add(finding.row.clone());
        self.all.push(finding);
    }

    pub fn leave_out(&mut self, what: String) {
        println!("  left out: {what}");
        self.left_out.push(what);
    }

    pub fn summary(&self) {
        self.report.summary();
    }

    #[cfg(test)]
    pub fn rows(&self) -> &[Row] {
        self.report.rows()
    }

    /// `directory/gpu-DEVICE.csv`.
    pub fn write(&self, gpu: &Gpu, directory: &Path, recipe: &str) -> Result<PathBuf> {
        self.table(gpu, recipe)?.write(directory, &format!("gpu-{}.csv", slug(&gpu.name)))
    }

    fn table(&self, gpu: &Gpu, recipe: &str) -> Result<Table> {
        let mut table = Table::threaded(&[
            "name",
            "workload",
            "method",
            "case",
            "vertices",
            "value",
            "least",
            "p25",
            "p75",
            "p90",
            "runs",
            "unit",
            "bytes_per_vertex",
            "gb_per_s",
            "share_of_copy",
            "reference",
            "reference_value",
            "ratio",
            "ratio_is",
            "aim",
            "met",
            "aim_is",
            "check",
            "hash",
        ]);
        table.comment("device", &gpu.name);
        table.comment("driver", &gpu.driver);
        table.comment(
            "kind",
            if gpu.software { "software driver: aims for real cards are shown, not judged" } else { "graphics card" },
        );
        table.comment("clock", gpu.clock());
        if let Some(load) = self.load {
            table.comment("load before", format!("{load:.2} tasks running or waiting, the mean of a minute"));
        }
        table.comment("command", recipe);
        for text in &self.left_out {
            table.comment("left out", text);
        }
        for f in &self.all {
            let r = &f.row;
            let ([least, low, high], runs) = r.spread.unwrap_or(([f64::NAN; 3], 0));
            let (reference, value) = r.reference.clone().unwrap_or((String::new(), f64::NAN));
            table.row([
                r.name.clone(),
                f.workload.to_owned(),
                f.method.clone(),
                f.case.clone(),
                f.vertices.to_string(),
                num(r.value),
                num(least),
                num(low),
                num(high),
                num(f.p90),
                if runs == 0 { String::new() } else { runs.to_string() },
                r.unit.to_owned(),
                num(f.bytes.unwrap_or(f64::NAN)),
                num(f.bandwidth()),
                num(f.copy.map_or(f64::NAN, |c| c / f.seconds)),
                reference,
                num(value),
                num(r.ratio().unwrap_or(f64::NAN)),
                r.ratio_text().to_owned(),
                r.aim_text(),
                r.met_text().to_lowercase(),
                f.goal.map_or("", |g| g.about).to_owned(),
                f.check.clone(),
                r.hash.map_or_else(String::new, |h| format!("{h:016x}")),
            ])?;
        }
        Ok(table)
    }
}

/// A name as a file may have it.
fn slug(name: &str) -> String {
    let lower = name.to_lowercase();
    lower.split(|c: char| !c.is_ascii_alphanumeric()).filter(|w| !w.is_empty()).collect::<Vec<_>>().join("-")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_short_and_plain() {
        assert_eq!(
            [1, 1024, 100_172, 999_999, 1_000_000, 10_000_000].map(short),
            ["1", "1k", "100k", "1m", "1m", "10m"]
        );
        assert_eq!(slug("llvmpipe (LLVM 15.0.6, 256 bits)"), "llvmpipe-llvm-15-0-6-256-bits");
        assert_eq!(name("vertices", "literature's kernel", "", 1000), "vertices_literature's_kernel_1k");
    }

    #[test]
    fn bandwidth_is_what_must_move() {
        let (times, copy) = (Times::new(vec![0.001]), Times::new(vec![0.0009]));
        let f = Finding::time("vertices", "positions", "", 1_000_000, &times, "ms").moving(30.0, &copy);
        assert_eq!((f.bandwidth(), f.p90), (30.0, 1.0));
    }
}
