//! `crumple replay`: makes the calls of a recording again.

use crate::table::count;
use anyhow::{Context, Result, bail};
use clap::Args;
use std::fmt::{self, Write};
use std::path::PathBuf;

#[derive(Args)]
pub struct Arguments {
    /// What crumple_recording_begin() wrote
    file: PathBuf,
    /// Print every call before it is made: the last one is where a crash is
    #[arg(long)]
    list: bool,
    /// Threads that deform; 0: one a core. The results are the same
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=1024))]
    threads: u32,
}

pub fn run(arguments: &Arguments) -> Result<String> {
    let shown = arguments.file.display();
    let bytes = std::fs::read(&arguments.file).with_context(|| format!("cannot read {shown}"))?;
    let mut each = |number: u64, call: fmt::Arguments<'_>| {
        if arguments.list {
            // A reader that has gone away is told by the report at the end.
            let _ = crate::print(&format!("{number:6}  {call}\n"));
        }
    };
    let found =
        crumple::replay(&bytes, arguments.threads, &mut each).with_context(|| format!("cannot replay {shown}"))?;
    let version = |v: u32| format!("{}.{}.{}", v / 1_000_000, v / 1000 % 1000, v % 1000);
    let (then, now) = (version(found.recorded_by), env!("CARGO_PKG_VERSION"));
    let other = if then == now { String::new() } else { format!(" (recorded by {then}, replayed by {now})") };
    if let Some(first) = &found.first {
        bail!(
            "{shown}: {} of {} give something else than was recorded{other}; the first is call {}, {}: {}",
            found.differences,
            count(found.calls as usize, "call", "calls"),
            first.call,
            first.function,
            first.what
        );
    }
    let mut text = format!("{shown}: recorded by {then}\n");
    writeln!(
        text,
        "  {}, {} among them, give what was recorded; {} wrote {}",
        count(found.calls as usize, "call", "calls"),
        count(found.hits as usize, "hit", "hits"),
        count(found.deforms as usize, "deform", "deforms"),
        count(found.vertices_written as usize, "vertex", "vertices"),
    )?;
    if !found.complete {
        writeln!(text, "  the recording has no end: the program ended, perhaps in the last of these calls")?;
    }
    for refused in &found.refused {
        writeln!(text, "  refused then: {refused}")?;
    }
    Ok(text)
}
