//! `crumple replay`: repeats the calls of a recording.

use crate::table::count;
use anyhow::{Context, Result, bail};
use clap::Args;
use std::fmt::{self, Write};
use std::path::PathBuf;

#[derive(Args)]
pub struct Arguments {
    /// The recording, a file that crumple_recording_begin() wrote
    file: PathBuf,
    /// Print every call before it is made; after a crash, the last line is the call that crashed
    #[arg(long)]
    list: bool,
    /// Number of threads that deform; 0 is one per core. It does not change the results
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=1024))]
    threads: u32,
}

pub fn run(arguments: &Arguments) -> Result<String> {
    let shown = arguments.file.display();
    let bytes = std::fs::read(&arguments.file).with_context(|| format!("cannot read {shown}"))?;
    let mut each = |number: u64, call: fmt::Arguments<'_>| {
        if arguments.list {
            // A closed pipe is reported when the final report is printed.
            let _ = crate::output::print(&format!("{number:6}  {call}\n"));
        }
    };
    let found =
        crumple::replay(&bytes, arguments.threads, &mut each).with_context(|| format!("cannot replay {shown}"))?;
    let version = |v: u32| format!("{}.{}.{}", v / 1_000_000, v / 1000 % 1000, v % 1000);
    let (then, now) = (version(found.recorded_by), env!("CARGO_PKG_VERSION"));
    let other = if then == now { String::new() } else { format!(" (recorded by {then}, replayed by {now})") };
    if let Some(first) = &found.first {
        bail!(
            "{shown}: {} of {} differ from the recording{other}; the first is call {}, {}: {}",
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
        "  {} ({} among them) match the recording; {} wrote {}",
        count(found.calls as usize, "call", "calls"),
        count(found.hits as usize, "hit", "hits"),
        count(found.deforms as usize, "deform", "deforms"),
        count(found.vertices_written as usize, "vertex", "vertices"),
    )?;
    if !found.complete {
        writeln!(text, "  the recording has no end: the program ended, perhaps inside the last of these calls")?;
    }
    for refused in &found.refused {
        writeln!(text, "  refused when recorded: {refused}")?;
    }
    Ok(text)
}
