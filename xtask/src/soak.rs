//! `cargo xtask soak`: hours of random hits and frames through the C interface (tests/c/soak.c), or how long very many of them take
//! (tests/c/times.c, tests/c/vulkan_times.c).

use std::path::Path;

use anyhow::Result;
use clap::Args;

use crate::install;
use crate::native::{self, Build};
use crate::target::launch;
use crate::workspace::{cmd, in_target, jobs};

#[derive(Args)]
pub struct Options {
    /// How long it runs, hours
    #[arg(long, default_value_t = 0.02)]
    hours: f64,
    /// Bodies that are hit, at most 1000
    #[arg(long, default_value_t = 16)]
    bodies: u32,
    /// Another seed makes other hits
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Only measure how long this many hits and frames take, on the CPU and recorded for Vulkan, on one core
    #[arg(long, value_name = "N", conflicts_with_all = ["hours", "bodies", "seed"])]
    frames: Option<u64>,
}

pub fn run(options: &Options) -> Result<()> {
    let (prefix, folder) = (install::release_prefix()?, in_target("ctest/release/tests-c"));
    native::compile(&Build::new("release", &prefix), Path::new("tests/c"), &folder)?;
    if let Some(frames) = options.frames {
        return times(&folder, &frames.to_string());
    }
    let Options { hours, bodies, seed, .. } = options;
    let seconds = 3600.0 * hours;
    Ok(cmd!("{folder}/soak").args([seconds.to_string(), bodies.to_string(), seed.to_string()]).run()?)
}

/// On the last core, where the system has a command for that.
fn times(folder: &Path, frames: &str) -> Result<()> {
    let last = (jobs() - 1).to_string();
    let runner: &[&str] = if cfg!(target_os = "linux") { &["taskset", "--cpu-list", &last] } else { &[] };
    for name in ["times", "vulkan_times"] {
        let program = folder.join(name);
        if program.exists() {
            launch(runner, &program).arg(frames).run()?;
        } else {
            println!("Vulkan is left out: its headers are not installed");
        }
    }
    Ok(())
}
