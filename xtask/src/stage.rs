//! Stages of `cargo xtask test` and `cargo xtask ci`. Every stage runs, and a table at the end says how each one ended and how long
//! it took.

use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::process::{Command, Stdio};
use std::time::Instant;

use anyhow::{Result, bail, ensure};

use crate::tools::{self, Tool};
use crate::workspace::{Background, Workspace};

pub struct Stage {
    pub name: &'static str,
    pub run: fn(&Workspace) -> Result<()>,
    /// What passing it shows.
    pub shows: &'static str,
    pub needs: &'static [Tool],
    /// Without these it runs, but leaves something out.
    pub wants: &'static [Tool],
    /// Large folders of the target directory that no later stage reads.
    pub leaves: &'static [&'static str],
    /// Why it has nothing to do on this system.
    pub elsewhere: Option<&'static str>,
}

/// A list of stages: the name, what runs, what passing it shows, and the fields that are not empty.
macro_rules! stages {
    ($($name:literal: $run:expr, $shows:literal $(, $field:ident: $value:expr)*;)*) => {
        &[$(Stage { $($field: $value,)* ..Stage::new($name, $run, $shows) }),*]
    };
}
pub(crate) use stages;

/// Unless `here` a stage has nothing to do, for the reason given.
pub const fn unless(here: bool, reason: &'static str) -> Option<&'static str> {
    if here { None } else { Some(reason) }
}

impl Stage {
    pub const fn new(name: &'static str, run: fn(&Workspace) -> Result<()>, shows: &'static str) -> Self {
        Self { name, run, shows, needs: &[], wants: &[], leaves: &[], elsewhere: None }
    }
}

/// The error of a stage that does not run. It says why.
#[derive(Debug)]
pub enum LeftOut {
    /// A program is missing, or cannot be fetched.
    Missing(String),
    /// It has nothing to do here. No installation changes that.
    NotApplicable(String),
}

impl fmt::Display for LeftOut {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (Self::Missing(reason) | Self::NotApplicable(reason)) = self;
        f.write_str(reason)
    }
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
    /// Passed, but left out a part.
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

/// Starts a process that compiles, and gives way to every other. Without the `nice` command there is none, and stages compile for
/// themselves.
fn compile_ahead() -> Option<Background> {
    let program = std::env::current_exe().ok()?;
    let mut command = Command::new("nice");
    // A stage whose build fails says so.
    command.args(["-n", "19"]).arg(program).arg("ahead").stdout(Stdio::null()).stderr(Stdio::null());
    command.spawn().ok().map(Background)
}

/// Runs `stages` in order, prints the closing table, and fails if any stage failed.
pub fn run_all(workspace: &Workspace, stages: &[&Stage], rules: Rules) -> Result<()> {
    let used = |tool: &&Tool| workspace.all || !tools::FOR_ALL.contains(tool);
    let wanted = |stage: &&Stage| stage.needs.iter().chain(stage.wants.iter().filter(used));
    let missing = tools::provide(workspace, stages.iter().flat_map(wanted));
    let _ahead = rules.ahead.then(compile_ahead);
    let rows = run_each(stages, rules, |stage| {
        let left_out = run_one(workspace, stage, &missing)?;
        for folder in stage.leaves.iter().filter(|_| rules.tidy) {
            // What cannot be removed only costs disk.
            let _ = workspace.shell.remove_path(workspace.target.join(folder));
        }
        Ok(left_out)
    });
    print!("\n{}", table(&rows, workspace.all));
    let failed = names(&rows, Verdict::Failed);
    ensure!(failed.is_empty(), "failed: {failed}");
    Ok(())
}

/// Returns why a part was left out, if one was.
fn run_one(workspace: &Workspace, stage: &Stage, missing: &[Tool]) -> Result<Option<String>> {
    if let Some(reason) = stage.elsewhere {
        bail!(LeftOut::NotApplicable(reason.to_owned()));
    }
    let missing_of = |tools: &[Tool]| -> Option<String> {
        let missing: Vec<Tool> = tools.iter().filter(|tool| missing.contains(tool)).copied().collect();
        (!missing.is_empty()).then(|| tools::advice(&missing))
    };
    if let Some(advice) = missing_of(stage.needs) {
        bail!(LeftOut::Missing(advice));
    }
    workspace.left_out.take();
    (stage.run)(workspace)?;
    Ok(workspace.left_out.take().or_else(|| missing_of(stage.wants)))
}

type Run<'a> = dyn FnMut(&Stage) -> Result<Option<String>> + 'a;

fn run_each(stages: &[&Stage], rules: Rules, mut run: impl FnMut(&Stage) -> Result<Option<String>>) -> Vec<Row> {
    let mut rows: Vec<Row> = Vec::new();
    for stage in stages {
        let stopped = rules.fail_fast && rows.iter().any(|row| row.verdict == Verdict::Failed);
        let skipped = || ("an earlier stage failed".to_owned(), Verdict::LeftOut);
        rows.push(match stopped.then(skipped) {
            Some((reason, verdict)) => Row { name: stage.name, verdict, seconds: 0.0, reason },
            None => row(stage, rules, &mut run),
        });
    }
    let again = rules.retry && !rules.fail_fast;
    for (stage, first) in stages.iter().zip(&mut rows).filter(|(_, row)| again && row.verdict == Verdict::Failed) {
        println!("\n== {} failed and runs once more", stage.name);
        let second = row(stage, rules, &mut run);
        // The row keeps why it failed first, and has the seconds of both runs.
        first.seconds += second.seconds;
        if second.verdict != Verdict::Failed {
            first.verdict = Verdict::SecondTry;
        }
    }
    rows
}

fn row(stage: &Stage, rules: Rules, run: &mut Run<'_>) -> Row {
    println!("\n== {}: {}", stage.name, stage.shows);
    let start = Instant::now();
    // A stage that panics must not end the others.
    let ended = catch_unwind(AssertUnwindSafe(|| run(stage))).unwrap_or_else(|_| bail!("the stage panicked"));
    let (verdict, reason) = match ended {
        Ok(None) => (Verdict::Passed, String::new()),
        Ok(Some(reason)) => (if rules.require_all { Verdict::Failed } else { Verdict::InPart }, reason),
        Err(error) => match error.downcast_ref() {
            Some(LeftOut::NotApplicable(_)) => (Verdict::LeftOut, format!("{error:#}")),
            Some(LeftOut::Missing(_)) if !rules.require_all => (Verdict::LeftOut, format!("{error:#}")),
            _ => (Verdict::Failed, format!("{error:#}")),
        },
    };
    let seconds = start.elapsed().as_secs_f64();
    println!("== {}: {} after {seconds:.1} s", stage.name, verdict.word());
    if !reason.is_empty() {
        println!("{reason}");
    }
    Row { name: stage.name, verdict, seconds, reason }
}

/// Fails with the names of what failed, after printing why.
pub fn all_passed(results: Vec<(&str, Result<()>)>) -> Result<()> {
    let failed = results.into_iter().filter_map(|(name, result)| Some((name, result.err()?)));
    let failed: Vec<&str> =
        failed.inspect(|(name, error)| println!("{name}: {error:#}")).map(|(name, _)| name).collect();
    ensure!(failed.is_empty(), "{} failed", failed.join(", "));
    Ok(())
}

/// The closing table and, alone on the last line, the counts that CI reads.
fn table(rows: &[Row], all: bool) -> String {
    let width = rows.iter().map(|row| row.name.len()).max().unwrap_or(0);
    let all = if all { " --all" } else { "" };
    let mut text = format!("{:width$}  result      seconds  repeat alone\n", "stage");
    for Row { name, verdict, seconds, reason } in rows {
        let (result, reason) = (verdict.word(), reason.lines().next().unwrap_or_default());
        let line = format!(
            "{name:width$}  {result:10}  {seconds:7.1}  cargo xtask test{all} --only {name:width$}  {reason:.90}"
        );
        text += line.trim_end();
        text.push('\n');
    }
    let unsteady = names(rows, Verdict::SecondTry);
    if !unsteady.is_empty() {
        text += &format!("\n{unsteady}: failed, then passed when run again. That is a bug.\n");
    }
    let count = |verdict| rows.iter().filter(|row| row.verdict == verdict).count();
    let passed = count(Verdict::Passed) + count(Verdict::SecondTry) + count(Verdict::InPart);
    format!("{text}\n{passed} passed, {} failed, {} skipped\n", count(Verdict::Failed), count(Verdict::LeftOut))
}

/// The stages that ended so.
fn names(rows: &[Row], verdict: Verdict) -> String {
    rows.iter().filter(|row| row.verdict == verdict).map(|row| row.name).collect::<Vec<_>>().join(", ")
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
    use super::*;

    fn verdicts(rules: Rules) -> Vec<Verdict> {
        let names = ["good", "bad", "partial", "absent", "untagged", "unsteady", "panics"];
        let (stages, mut tries) = (names.map(|name| Stage::new(name, |_| Ok(()), "")), 0);
        let rows = run_each(&stages.each_ref(), rules, |stage| match stage.name {
            "good" => Ok(None),
            "bad" => bail!("two is not three\nand more"),
            "partial" => Ok(Some("no ODE".into())),
            "absent" => bail!(LeftOut::Missing("no CMake".into())),
            "unsteady" => {
                tries += 1;
                ensure!(tries > 1, "a race");
                Ok(None)
            }
            "panics" => panic!("a panic that a test makes"),
            _ => bail!(LeftOut::NotApplicable("no tag".into())),
        });
        rows.iter().map(|row| row.verdict).collect()
    }

    #[test]
    fn a_stage_that_fails_does_not_hide_the_others() {
        use Verdict::{Failed, InPart, LeftOut, Passed, SecondTry};
        assert_eq!(verdicts(Rules::default()), [Passed, Failed, InPart, LeftOut, LeftOut, Failed, Failed]);
        let required = [Passed, Failed, Failed, Failed, LeftOut, Failed, Failed];
        assert_eq!(verdicts(Rules { require_all: true, ..Rules::default() }), required);
        let stopped = [Passed, Failed, LeftOut, LeftOut, LeftOut, LeftOut, LeftOut];
        assert_eq!(verdicts(Rules { fail_fast: true, retry: true, ..Rules::default() }), stopped);
        let tried = [Passed, Failed, InPart, LeftOut, LeftOut, SecondTry, Failed];
        assert_eq!(verdicts(Rules { retry: true, ..Rules::default() }), tried);
    }

    #[test]
    fn the_table_ends_with_a_line_of_counts() {
        let row = |name, verdict, reason: &str| Row { name, verdict, seconds: 1.25, reason: reason.into() };
        let rows = [
            row("install", Verdict::Passed, ""),
            row("abi", Verdict::LeftOut, "no tag"),
            row("rust", Verdict::Failed, "cargo test failed\nwith status 101"),
            row("threads", Verdict::SecondTry, "a race"),
        ];
        let expected = "\
stage    result      seconds  repeat alone
install  passed          1.2  cargo xtask test --all --only install
abi      left out        1.2  cargo xtask test --all --only abi      no tag
rust     failed          1.2  cargo xtask test --all --only rust     cargo test failed
threads  second try      1.2  cargo xtask test --all --only threads  a race

threads: failed, then passed when run again. That is a bug.

2 passed, 1 failed, 1 skipped
";
        assert_eq!(table(&rows, true), expected);
    }
}
