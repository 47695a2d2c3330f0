//! What a shipped game links: the stripped slim library.

use anyhow::{Context, Result};

use super::Bench;
use super::findings::Finding;

/// The size says nothing about vertices, so there are none to run it on.
pub fn run(bench: &Bench<'_>, _: &[usize]) -> Result<()> {
    let Some(path) = &bench.library else {
        bench.findings.borrow_mut().leave_out("the library's size: no --library was given".into());
        return Ok(());
    };
    let bytes = std::fs::metadata(path).with_context(|| format!("looking at {}", path.display()))?.len();
    let finding = Finding::value("library", "stripped", 0, bytes as f64 / 1e6, "MB");
    bench.add(finding.aim("library"));
    Ok(())
}
