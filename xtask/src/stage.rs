//! Stages of `cargo xtask test` and `cargo xtask ci`. Every stage runs, and a table at the end says how each one ended and how long
//! it took.

use std::fmt;
use std::panic::catch_unwind;
use std::process::{Command, Stdio};
use std::time::Instant;

use anyhow::{Result, anyhow, bail, ensure};

use crate::tools::{self, Tool};
use crate::workspace::{Background, all, in_target, sh};

pub struct Stage {
    pub name: &'static str,
    pub run: fn() -> Result<()>,
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
    pub const fn new(name: &'static str, run: fn() -> Result<()>, shows: &'static str) -> Self {
        Self { name, run, shows, needs: &[], wants: &[], leaves: &[], elsewhere: None }
    }
}

/// The error of a stage that does not run, or not whole. It says why.
#[derive(Debug)]
pub enum LeftOut {
    /// A program is missing, or cannot be fetched.
    Missing(String),
    /// It has passed, but has left out a part.
    Part(String),
    /// It has nothing to do here. No installation changes that.
    NotApplicable(String),
}

impl fmt::Display for LeftOut {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (Self::Missing(reason) | Self::Part(reason) | Self::NotApplicable(reason)) = self;
        f.write_str(reason)
    }
}

#[derive(Clone, Copy, Default)]
pub struct Rules {
    /// As CI runs them. A stage that leaves something out because a program is missing fails. The folders that a stage leaves are
    /// removed once it has passed. After all stages, each that failed runs once more, and the table says which passed then: a stage
    /// that does not fail each time is a bug.
    pub ci: bool,
    /// No stage runs after the first that fails.
    pub fail_fast: bool,
    /// `cargo xtask ahead` compiles what later stages need, from the start.
    pub ahead: bool,
}

/// How a stage ends, as the table says it.
type Verdict = &'static str;
const PASSED: Verdict = "passed";
/// Failed, and passed when it ran again.
const SECOND_TRY: Verdict = "second try";
/// Passed, but left out a part.
const IN_PART: Verdict = "in part";
const LEFT_OUT: Verdict = "left out";
const FAILED: Verdict = "failed";

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
pub fn run_all(stages: &[&Stage], rules: Rules) -> Result<()> {
    let used = |tool: &&Tool| all() || !tools::FOR_ALL.contains(tool);
    let wanted = |stage: &&Stage| stage.needs.iter().chain(stage.wants.iter().filter(used));
    let missing = tools::provide(stages.iter().flat_map(wanted));
    let _ahead = rules.ahead.then(compile_ahead);
    let rows = run_each(stages, rules, &missing);
    print!("\n{}", table(&rows, all()));
    let failed = names(&rows, FAILED);
    ensure!(failed.is_empty(), "failed: {failed}");
    Ok(())
}

fn run_each(stages: &[&Stage], rules: Rules, missing: &[Tool]) -> Vec<Row> {
    let mut rows: Vec<Row> = Vec::new();
    for stage in stages {
        let stopped = rules.fail_fast && rows.iter().any(|row| row.verdict == FAILED);
        let skipped =
            || Row { name: stage.name, verdict: LEFT_OUT, seconds: 0.0, reason: "an earlier stage failed".to_owned() };
        rows.push(stopped.then(skipped).unwrap_or_else(|| row(stage, rules, missing)));
    }
    let again = rules.ci && !rules.fail_fast;
    for (stage, first) in stages.iter().zip(&mut rows).filter(|(_, row)| again && row.verdict == FAILED) {
        println!("\n== {} failed and runs once more", stage.name);
        let second = row(stage, rules, missing);
        // The row keeps why it failed first, and has the seconds of both runs.
        first.seconds += second.seconds;
        if second.verdict != FAILED {
            first.verdict = SECOND_TRY;
        }
    }
    rows
}

fn row(stage: &Stage, rules: Rules, missing: &[Tool]) -> Row {
    println!("\n== {}: {}", stage.name, stage.shows);
    let start = Instant::now();
    // A stage that panics must not end the others.
    let ended = catch_unwind(|| run_one(stage, missing)).unwrap_or_else(|_| Err(anyhow!("the stage panicked")));
    let verdict = match ended.as_ref().map_err(|error| error.downcast_ref()) {
        Ok(()) => PASSED,
        Err(Some(LeftOut::NotApplicable(_))) => LEFT_OUT,
        Err(Some(LeftOut::Missing(_))) if !rules.ci => LEFT_OUT,
        Err(Some(LeftOut::Part(_))) if !rules.ci => IN_PART,
        Err(_) => FAILED,
    };
    for folder in stage.leaves.iter().filter(|_| rules.ci && [PASSED, IN_PART].contains(&verdict)) {
        // What cannot be removed only costs disk.
        let _ = sh().remove_path(in_target(folder));
    }
    let (seconds, reason) = (start.elapsed().as_secs_f64(), ended.err().map(|error| format!("{error:#}")));
    println!("== {}: {verdict} after {seconds:.1} s", stage.name);
    reason.iter().for_each(|reason| println!("{reason}"));
    Row { name: stage.name, verdict, seconds, reason: reason.unwrap_or_default() }
}

fn run_one(stage: &Stage, missing: &[Tool]) -> Result<()> {
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
    (stage.run)()?;
    missing_of(stage.wants).map_or(Ok(()), |advice| Err(anyhow!(LeftOut::Part(advice))))
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
        let reason = reason.lines().next().unwrap_or_default();
        let repeat = format!("cargo xtask test{all} --only {name:width$}  {reason:.90}");
        text += format!("{name:width$}  {verdict:10}  {seconds:7.1}  {repeat}").trim_end();
        text.push('\n');
    }
    let unsteady = names(rows, SECOND_TRY);
    if !unsteady.is_empty() {
        text += &format!("\n{unsteady}: failed, then passed when run again. That is a bug.\n");
    }
    let count = |verdicts: &[Verdict]| rows.iter().filter(|row| verdicts.contains(&row.verdict)).count();
    let passed = count(&[PASSED, SECOND_TRY, IN_PART]);
    format!("{text}\n{passed} passed, {} failed, {} skipped\n", count(&[FAILED]), count(&[LEFT_OUT]))
}

fn names(rows: &[Row], verdict: Verdict) -> String {
    rows.iter().filter(|row| row.verdict == verdict).map(|row| row.name).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

    use super::*;

    static TRIES: AtomicUsize = AtomicUsize::new(0);
    const STAGES: &[Stage] = stages! {
        "good": || Ok(()), "";
        "bad": || bail!("two is not three\nand more"), "";
        "partial": || bail!(LeftOut::Part("no ODE".into())), "";
        "absent": || Ok(()), "", needs: &[tools::CMAKE];
        "elsewhere": || Ok(()), "", elsewhere: unless(false, "no tag");
        "unsteady": || if TRIES.fetch_add(1, Relaxed) > 0 { Ok(()) } else { bail!("a race") }, "";
        "panics": || panic!("a panic that a test makes"), "";
    };

    #[test]
    fn a_stage_that_fails_does_not_hide_the_others() {
        let verdicts = |rules: Rules| -> Vec<Verdict> {
            TRIES.store(0, Relaxed);
            let rows = run_each(&STAGES.iter().collect::<Vec<_>>(), rules, &[tools::CMAKE]);
            rows.iter().map(|row| row.verdict).collect()
        };
        let (default, p, f, l) = (Rules::default(), PASSED, FAILED, LEFT_OUT);
        assert_eq!(verdicts(default), [p, f, IN_PART, l, l, f, f]);
        assert_eq!(verdicts(Rules { ci: true, ..default }), [p, f, f, f, l, SECOND_TRY, f]);
        assert_eq!(verdicts(Rules { ci: true, fail_fast: true, ..default }), [p, f, l, l, l, l, l]);
    }

    #[test]
    fn the_table_ends_with_a_line_of_counts() {
        let row = |name, verdict, reason: &str| Row { name, verdict, seconds: 1.25, reason: reason.into() };
        let rows = [
            row("install", PASSED, ""),
            row("abi", LEFT_OUT, "no tag"),
            row("rust", FAILED, "cargo test failed\nwith status 101"),
            row("threads", SECOND_TRY, "a race"),
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
