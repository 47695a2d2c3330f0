//! Stages of `cargo xtask test` and `cargo xtask ci`. Every stage runs, and a table at the end says how each one ended.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::time::Instant;

use anyhow::{Result, ensure};

use crate::tools::{self, Tool};
use crate::workspace::Workspace;

/// How a stage that did not fail ended.
pub enum Outcome {
    Passed,
    /// Passed, but a missing program left out a part of it. The text names the program.
    InPart(String),
    /// Did not run because a program is missing. The text names it.
    LeftOut(String),
    /// Has nothing to do here, for the reason given. No installation changes that.
    NotApplicable(String),
}

pub struct Stage {
    pub name: &'static str,
    /// What passing it shows.
    pub shows: &'static str,
    pub needs: &'static [Tool],
    /// Without these it runs, but leaves something out.
    pub wants: &'static [Tool],
    pub run: fn(&Workspace) -> Result<Outcome>,
}

#[derive(Clone, Copy, Default)]
pub struct Rules {
    /// A stage that leaves something out because a program is missing fails.
    pub require_all: bool,
    /// No stage runs after the first that fails.
    pub fail_fast: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Verdict {
    Passed,
    InPart,
    LeftOut,
    Failed,
}

/// A stage's row in the closing table.
struct Row {
    name: &'static str,
    verdict: Verdict,
    seconds: f64,
    reason: String,
}

/// Runs `stages` in order, prints the closing table, and fails if any stage failed.
pub fn run_all(workspace: &Workspace, stages: &[&Stage], rules: Rules) -> Result<()> {
    let wanted: BTreeSet<Tool> =
        stages.iter().flat_map(|stage| stage.needs.iter().chain(stage.wants)).copied().collect();
    let missing = tools::provide(workspace, &wanted)?;
    let rows = run_each(stages, rules, |stage| run_one(workspace, stage, &missing));
    print!("\n{}", table(&rows));
    let failed: Vec<&str> = rows.iter().filter(|row| row.verdict == Verdict::Failed).map(|row| row.name).collect();
    ensure!(failed.is_empty(), "failed: {}", failed.join(", "));
    Ok(())
}

fn run_one(workspace: &Workspace, stage: &Stage, missing: &BTreeSet<Tool>) -> Result<Outcome> {
    let missing_of = |tools: &[Tool]| tools.iter().filter(|tool| missing.contains(tool)).copied().collect();
    let (needs, wants): (BTreeSet<Tool>, BTreeSet<Tool>) = (missing_of(stage.needs), missing_of(stage.wants));
    if !needs.is_empty() {
        return Ok(Outcome::LeftOut(tools::advice(&needs)));
    }
    Ok(match (stage.run)(workspace)? {
        Outcome::Passed if !wants.is_empty() => Outcome::InPart(tools::advice(&wants)),
        outcome => outcome,
    })
}

fn run_each(stages: &[&Stage], rules: Rules, mut run: impl FnMut(&Stage) -> Result<Outcome>) -> Vec<Row> {
    let mut rows: Vec<Row> = Vec::new();
    for stage in stages {
        let start = Instant::now();
        let stopped = rules.fail_fast && rows.iter().any(|row| row.verdict == Verdict::Failed);
        let (verdict, reason) = if stopped {
            (Verdict::LeftOut, "an earlier stage failed".to_owned())
        } else {
            println!("\n== {}: {}", stage.name, stage.shows);
            match run(stage) {
                Ok(Outcome::Passed) => (Verdict::Passed, String::new()),
                Ok(Outcome::NotApplicable(reason)) => (Verdict::LeftOut, reason),
                Ok(Outcome::InPart(reason)) if !rules.require_all => (Verdict::InPart, reason),
                Ok(Outcome::LeftOut(reason)) if !rules.require_all => (Verdict::LeftOut, reason),
                Ok(Outcome::InPart(reason) | Outcome::LeftOut(reason)) => (Verdict::Failed, reason),
                Err(error) => (Verdict::Failed, format!("{error:#}")),
            }
        };
        let seconds = start.elapsed().as_secs_f64();
        println!("== {}: {} after {seconds:.1} s", stage.name, verdict.word());
        if !reason.is_empty() {
            println!("{reason}");
        }
        rows.push(Row { name: stage.name, verdict, seconds, reason });
    }
    rows
}

/// Fails with the names of what failed, after printing why.
pub fn all_passed(results: Vec<(&str, Result<()>)>) -> Result<()> {
    let mut failed = Vec::new();
    for (name, result) in results {
        if let Err(error) = result {
            println!("{name}: {error:#}");
            failed.push(name);
        }
    }
    ensure!(failed.is_empty(), "{} failed", failed.join(", "));
    Ok(())
}

/// The closing table and, alone on the last line, the counts that CI reads.
fn table(rows: &[Row]) -> String {
    let width = rows.iter().map(|row| row.name.len()).max().unwrap_or(0);
    let mut text = format!("{:width$}  result    seconds  repeat alone\n", "stage");
    for Row { name, verdict, seconds, reason } in rows {
        let (result, line) = (verdict.word(), reason.lines().next().unwrap_or_default());
        let repeat = format!("cargo xtask test --only {name:width$}");
        let _ = writeln!(text, "{name:width$}  {result:8}  {seconds:7.1}  {repeat}  {}", shortened(line));
    }
    let count = |of: &[Verdict]| rows.iter().filter(|row| of.contains(&row.verdict)).count();
    let passed = count(&[Verdict::Passed, Verdict::InPart]);
    let (failed, skipped) = (count(&[Verdict::Failed]), count(&[Verdict::LeftOut]));
    let lines = text.lines().map(str::trim_end).collect::<Vec<_>>().join("\n");
    format!("{lines}\n\n{passed} passed, {failed} failed, {skipped} skipped\n")
}

/// The first 90 letters.
fn shortened(line: &str) -> String {
    let start: String = line.chars().take(90).collect();
    if start.len() < line.len() { start + "…" } else { start }
}

impl Verdict {
    fn word(self) -> &'static str {
        match self {
            Self::Passed => "passed",
            Self::InPart => "in part",
            Self::LeftOut => "left out",
            Self::Failed => "failed",
        }
    }
}

#[cfg(test)]
mod tests {
    use anyhow::bail;

    use super::*;

    const fn stage(name: &'static str) -> Stage {
        Stage { name, shows: "", needs: &[], wants: &[], run: |_| Ok(Outcome::Passed) }
    }

    const STAGES: &[&Stage] = &[&stage("good"), &stage("bad"), &stage("partial"), &stage("absent"), &stage("untagged")];

    fn verdicts(rules: Rules) -> Vec<Verdict> {
        let rows = run_each(STAGES, rules, |stage| {
            Ok(match stage.name {
                "good" => Outcome::Passed,
                "bad" => bail!("two is not three\nand more"),
                "partial" => Outcome::InPart("no ODE".into()),
                "absent" => Outcome::LeftOut("no CMake".into()),
                _ => Outcome::NotApplicable("no tag".into()),
            })
        });
        rows.iter().map(|row| row.verdict).collect()
    }

    #[test]
    fn a_stage_that_fails_does_not_hide_the_others() {
        use Verdict::{Failed, InPart, LeftOut, Passed};
        assert_eq!(verdicts(Rules::default()), [Passed, Failed, InPart, LeftOut, LeftOut]);
        assert_eq!(verdicts(Rules { require_all: true, fail_fast: false }), [Passed, Failed, Failed, Failed, LeftOut]);
        let stopped = [Passed, Failed, LeftOut, LeftOut, LeftOut];
        assert_eq!(verdicts(Rules { require_all: false, fail_fast: true }), stopped);
    }

    #[test]
    fn the_table_ends_with_a_line_of_counts() {
        let row = |name, verdict, reason: &str| Row { name, verdict, seconds: 1.25, reason: reason.into() };
        let rows = [
            row("install", Verdict::Passed, ""),
            row("abi", Verdict::LeftOut, "no tag"),
            row("rust", Verdict::Failed, "cargo test failed\nwith status 101"),
        ];
        let expected = "\
stage    result    seconds  repeat alone
install  passed        1.2  cargo xtask test --only install
abi      left out      1.2  cargo xtask test --only abi      no tag
rust     failed        1.2  cargo xtask test --only rust     cargo test failed

1 passed, 1 failed, 1 skipped
";
        assert_eq!(table(&rows), expected);
    }
}
