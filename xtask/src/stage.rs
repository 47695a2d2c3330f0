//! Stages of `cargo xtask test`: each runs, is skipped with a reason, or fails; the summary names every one.

use std::collections::BTreeSet;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};

use crate::tools::{self, Tool};
use crate::workspace::Workspace;

/// How a stage that did not fail ended.
pub enum Outcome {
    Passed,
    /// Passed, but for what this says was left out.
    InPart(String),
    Skipped(String),
}

pub struct Stage {
    pub name: &'static str,
    /// What passing it shows, for the summary.
    pub shows: &'static str,
    pub needs: &'static [Tool],
    /// Without these it runs, but leaves something out.
    pub wants: &'static [Tool],
    /// Whether its runner's own closing lines should be among the last that are printed: such stages come last, after the summary.
    pub closing: bool,
    pub run: fn(&Workspace) -> Result<Outcome>,
}

struct Entry {
    name: &'static str,
    shows: &'static str,
    outcome: Outcome,
    took: Duration,
}

/// Runs `stages` in order and stops at the first that fails. With `require_all` a skipped stage fails too.
pub fn run_all(workspace: &Workspace, stages: &[&Stage], require_all: bool) -> Result<()> {
    let wanted: BTreeSet<Tool> =
        stages.iter().flat_map(|stage| stage.needs.iter().chain(stage.wants)).copied().collect();
    let missing = tools::provide(workspace, &wanted)?;
    let mut entries = Vec::new();
    let mut told = false;
    for (index, stage) in stages.iter().enumerate() {
        if stage.closing && !told {
            summarise(&entries, &stages[index..]);
            told = true;
        }
        println!("\n== {}: {}", stage.name, stage.shows);
        let start = Instant::now();
        let lacking = |tools: &[Tool]| -> BTreeSet<Tool> {
            tools.iter().filter(|tool| missing.contains(tool)).copied().collect()
        };
        let (needs, wants) = (lacking(stage.needs), lacking(stage.wants));
        let mut outcome = if needs.is_empty() {
            (stage.run)(workspace)
                .with_context(|| format!("stage {0} failed; alone: cargo xtask test --only {0}", stage.name))?
        } else {
            Outcome::Skipped(tools::advice(&needs))
        };
        if matches!(outcome, Outcome::Passed) && !wants.is_empty() {
            outcome = Outcome::InPart(tools::advice(&wants));
        }
        if let Outcome::Skipped(reason) | Outcome::InPart(reason) = &outcome {
            if require_all {
                bail!("stage {} left something out, and everything is required: {reason}", stage.name);
            }
            println!("left out: {reason}");
        }
        entries.push(Entry { name: stage.name, shows: stage.shows, outcome, took: start.elapsed() });
    }
    if !told {
        summarise(&entries, &[]);
    }
    Ok(())
}

fn summarise(entries: &[Entry], still_to_run: &[&Stage]) {
    let names = entries.iter().map(|entry| entry.name).chain(still_to_run.iter().map(|stage| stage.name));
    let width = names.map(str::len).max().unwrap_or(0);
    println!("\n== summary");
    for Entry { name, shows, outcome, took } in entries {
        match outcome {
            Outcome::Passed => println!("  {name:width$}  passed   {:6.1} s  {shows}", took.as_secs_f64()),
            Outcome::InPart(reason) => println!("  {name:width$}  IN PART  {:6.1} s  {reason}", took.as_secs_f64()),
            Outcome::Skipped(reason) => println!("  {name:width$}  SKIPPED            {reason}"),
        }
    }
    for stage in still_to_run {
        println!("  {:width$}  follows            {}", stage.name, stage.shows);
    }
}
