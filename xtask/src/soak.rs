//! `cargo xtask soak`: hours of random hits and frames through the C interface (tests/c/soak.c).

use anyhow::Result;
use clap::Args;
use xshell::cmd;

use crate::native::{self, Build};
use crate::workspace::Workspace;

#[derive(Args)]
pub struct Options {
    /// How long it runs, hours
    #[arg(long, conflicts_with = "seconds")]
    hours: Option<f64>,
    /// How long it runs, seconds
    #[arg(long, default_value_t = 60.0)]
    seconds: f64,
    /// Bodies that are hit, at most 1000
    #[arg(long, default_value_t = 16)]
    bodies: u32,
    /// Another seed makes other hits
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

pub fn run(workspace: &Workspace, options: &Options) -> Result<()> {
    let prefix = native::release_prefix(workspace)?;
    let build = Build::new("release", &prefix);
    let directory = workspace.target.join("ctest/release/tests-c");
    native::compile(workspace, &build, &workspace.path("tests/c"), &directory)?;
    let seconds = options.hours.map_or(options.seconds, |hours| 3600.0 * hours).to_string();
    let (bodies, seed) = (options.bodies.to_string(), options.seed.to_string());
    let soak = directory.join("soak");
    Ok(cmd!(workspace.shell, "{soak} {seconds} {bodies} {seed}").run()?)
}
