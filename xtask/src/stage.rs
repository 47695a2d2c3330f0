//! Stages of `cargo xtask test` and `cargo xtask ci`. Every stage runs, and a table at the end says how each one ended and how long
//! it took.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::process::{Child, Command, Stdio};
use std::time::Instant;

use anyhow::{Result, bail, ensure};

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
    /// Large folders of the target directory that no later stage reads.
    pub leaves: &'static [&'static str],
    pub run: fn(&Workspace) -> Result<Outcome>,
}

#[derive(Clone, Copy, Default)]
pub struct Rules {
    /// A stage that leaves something out because a program is missing fails.
    pub require_all: bool,
    /// No stage runs after the first that fails.
    pub fail_fast: bool,
    /// After all stages, each that failed runs once more. The table says which passed then: a stage that does not fail each time
    /// is a bug.
    pub retry: bool,
    /// The folders that a stage leaves are removed once it has passed.
    pub tidy: bool,
    /// `cargo xtask ahead` compiles what later stages need, from the start.
    pub ahead: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Verdict {
    Passed,
    /// Failed, and passed when it ran again.
    SecondTry,
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

/// A process that compiles, and gives way to every other.
struct Ahead(Option<Child>);

impl Ahead {
    /// Without the `nice` command it does nothing, and stages compile for themselves.
    fn start() -> Self {
        let program = std::env::current_exe().unwrap_or_default();
        let mut command = Command::new("nice");
        // A stage whose build fails says so.
        command.args(["-n", "19"]).arg(program).arg("ahead").stdout(Stdio::null()).stderr(Stdio::null());
        Self(command.spawn().ok())
    }
}

impl Drop for Ahead {
    fn drop(&mut self) {
        if let Some(child) = &mut self.0 {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

/// Runs `stages` in order, prints the closing table, and fails if any stage failed.
pub fn run_all(workspace: &Workspace, stages: &[&Stage], rules: Rules) -> Result<()> {
    let used = |tool: &Tool| workspace.all || tool.for_everybody();
    let wanted: BTreeSet<Tool> = stages
        .iter()
        .flat_map(|stage| stage.needs.iter().chain(stage.wants.iter().filter(|tool| used(tool))))
        .copied()
        .collect();
    let missing = tools::provide(workspace, &wanted)?;
    let _ahead = rules.ahead.then(Ahead::start);
    let rows = run_each(stages, rules, |stage| {
        let outcome = run_one(workspace, stage, &missing)?;
        if rules.tidy {
            for folder in stage.leaves {
                // What cannot be removed only costs disk.
                let _ = workspace.shell.remove_path(workspace.target.join(folder));
            }
        }
        Ok(outcome)
    });
    print!("\n{}", table(&rows, workspace.all));
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
        let stopped = rules.fail_fast && rows.iter().any(|row| row.verdict == Verdict::Failed);
        rows.push(if stopped {
            let reason = "an earlier stage failed".to_owned();
            Row { name: stage.name, verdict: Verdict::LeftOut, seconds: 0.0, reason }
        } else {
            row(stage, rules, &mut run)
        });
    }
    if rules.retry && !rules.fail_fast {
        for (stage, row) in stages.iter().zip(&mut rows).filter(|(_, row)| row.verdict == Verdict::Failed) {
            try_again(stage, row, rules, &mut run);
        }
    }
    rows
}

fn row(stage: &Stage, rules: Rules, run: &mut impl FnMut(&Stage) -> Result<Outcome>) -> Row {
    println!("\n== {}: {}", stage.name, stage.shows);
    let start = Instant::now();
    // A stage that panics must not end the others.
    let outcome = catch_unwind(AssertUnwindSafe(|| run(stage))).unwrap_or_else(|_| bail!("the stage panicked"));
    let (verdict, reason) = match outcome {
        Ok(Outcome::Passed) => (Verdict::Passed, String::new()),
        Ok(Outcome::NotApplicable(reason)) => (Verdict::LeftOut, reason),
        Ok(Outcome::InPart(reason)) if !rules.require_all => (Verdict::InPart, reason),
        Ok(Outcome::LeftOut(reason)) if !rules.require_all => (Verdict::LeftOut, reason),
        Ok(Outcome::InPart(reason) | Outcome::LeftOut(reason)) => (Verdict::Failed, reason),
        Err(error) => (Verdict::Failed, format!("{error:#}")),
    };
    let seconds = start.elapsed().as_secs_f64();
    println!("== {}: {} after {seconds:.1} s", stage.name, verdict.word());
    if !reason.is_empty() {
        println!("{reason}");
    }
    Row { name: stage.name, verdict, seconds, reason }
}

/// Runs a stage again that failed. Its row keeps why it failed first, and has the seconds of both runs.
fn try_again(stage: &Stage, first: &mut Row, rules: Rules, run: &mut impl FnMut(&Stage) -> Result<Outcome>) {
    println!("\n== {} failed and runs once more", stage.name);
    let second = row(stage, rules, run);
    first.seconds += second.seconds;
    if second.verdict != Verdict::Failed {
        first.verdict = Verdict::SecondTry;
    }
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
fn table(rows: &[Row], all: bool) -> String {
    let width = rows.iter().map(|row| row.name.len()).max().unwrap_or(0);
    let all = if all { " --all" } else { "" };
    let mut text = format!("{:width$}  result      seconds  repeat alone\n", "stage");
    for Row { name, verdict, seconds, reason } in rows {
        let (result, line) = (verdict.word(), reason.lines().next().unwrap_or_default());
        let repeat = format!("cargo xtask test{all} --only {name:width$}");
        let _ = writeln!(text, "{name:width$}  {result:10}  {seconds:7.1}  {repeat}  {}", shortened(line));
    }
    let count = |of: &[Verdict]| rows.iter().filter(|row| of.contains(&row.verdict)).count();
    let passed = count(&[Verdict::Passed, Verdict::SecondTry, Verdict::InPart]);
    let (failed, skipped) = (count(&[Verdict::Failed]), count(&[Verdict::LeftOut]));
    let mut text = text.lines().map(str::trim_end).collect::<Vec<_>>().join("\n");
    let unsteady: Vec<&str> = rows.iter().filter(|row| row.verdict == Verdict::SecondTry).map(|row| row.name).collect();
    if !unsteady.is_empty() {
        let names = unsteady.join(", ");
        let _ = write!(text, "\n\n{names}: failed, then passed when run again. That is a bug.");
    }
    format!("{text}\n\n{passed} passed, {failed} failed, {skipped} skipped\n")
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
            Self::SecondTry => "second try",
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
        Stage { name, shows: "", needs: &[], wants: &[], leaves: &[], run: |_| Ok(Outcome::Passed) }
    }

    const STAGES: &[&Stage] = &[
        &stage("good"),
        &stage("bad"),
        &stage("partial"),
        &stage("absent"),
        &stage("untagged"),
        &stage("unsteady"),
        &stage("panics"),
    ];

    fn verdicts(rules: Rules) -> Vec<Verdict> {
        let mut tries = 0;
        let rows = run_each(STAGES, rules, |stage| {
            Ok(match stage.name {
                "good" => Outcome::Passed,
                "bad" => bail!("two is not three\nand more"),
                "partial" => Outcome::InPart("no ODE".into()),
                "absent" => Outcome::LeftOut("no CMake".into()),
                "unsteady" => {
                    tries += 1;
                    ensure!(tries > 1, "a race");
                    Outcome::Passed
                }
                "panics" => panic!("a panic that a test makes"),
                _ => Outcome::NotApplicable("no tag".into()),
            })
        });
        rows.iter().map(|row| row.verdict).collect()
    }

    #[test]
    fn a_stage_that_fails_does_not_hide_the_others() {
        use Verdict::{Failed, InPart, LeftOut, Passed};
        assert_eq!(verdicts(Rules::default()), [Passed, Failed, InPart, LeftOut, LeftOut, Failed, Failed]);
        let required = [Passed, Failed, Failed, Failed, LeftOut, Failed, Failed];
        assert_eq!(verdicts(Rules { require_all: true, ..Rules::default() }), required);
        let stopped = [Passed, Failed, LeftOut, LeftOut, LeftOut, LeftOut, LeftOut];
        assert_eq!(verdicts(Rules { fail_fast: true, retry: true, ..Rules::default() }), stopped);
    }

    #[test]
    fn a_stage_that_fails_runs_again_and_the_table_says_so() {
        use Verdict::{Failed, InPart, LeftOut, Passed, SecondTry};
        let tried = [Passed, Failed, InPart, LeftOut, LeftOut, SecondTry, Failed];
        assert_eq!(verdicts(Rules { retry: true, ..Rules::default() }), tried);
        let row = Row { name: "threads", verdict: SecondTry, seconds: 61.04, reason: "a race".into() };
        let expected = "\
stage    result      seconds  repeat alone
threads  second try     61.0  cargo xtask test --all --only threads  a race

threads: failed, then passed when run again. That is a bug.

1 passed, 0 failed, 0 skipped
";
        assert_eq!(table(&[row], true), expected);
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
stage    result      seconds  repeat alone
install  passed          1.2  cargo xtask test --only install
abi      left out        1.2  cargo xtask test --only abi      no tag
rust     failed          1.2  cargo xtask test --only rust     cargo test failed

1 passed, 1 failed, 1 skipped
";
        assert_eq!(table(&rows, false), expected);
    }
}
