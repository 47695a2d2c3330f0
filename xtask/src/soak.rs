//! `cargo xtask soak`: hours of random hits and frames through the C interface (tests/c/soak.c), or how long very many of them take
//! (tests/c/times.c, tests/c/vulkan_times.c).

use std::path::Path;

use anyhow::Result;
use clap::Args;
use xshell::{Cmd, cmd};

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
    /// Only measure how long this many hits and frames take, on the CPU and recorded for Vulkan, on one core
    #[arg(long, value_name = "N", conflicts_with_all = ["hours", "seconds", "bodies", "seed"])]
    frames: Option<u64>,
}

pub fn run(workspace: &Workspace, options: &Options) -> Result<()> {
    let prefix = native::release_prefix(workspace)?;
    let build = Build::new("release", &prefix);
    let directory = workspace.target.join("ctest/release/tests-c");
    native::compile(workspace, &build, &workspace.path("tests/c"), &directory)?;
    if let Some(frames) = options.frames {
        return times(workspace, &directory, &frames.to_string());
    }
    let seconds = options.hours.map_or(options.seconds, |hours| 3600.0 * hours).to_string();
    let (bodies, seed) = (options.bodies.to_string(), options.seed.to_string());
    let soak = directory.join("soak");
    Ok(cmd!(workspace.shell, "{soak} {seconds} {bodies} {seed}").run()?)
}

fn times(workspace: &Workspace, directory: &Path, frames: &str) -> Result<()> {
    one_core(workspace, &directory.join("times")).arg(frames).run()?;
    let vulkan = directory.join("vulkan_times");
    if !vulkan.exists() {
        println!("Vulkan is left out: its headers are not installed");
        return Ok(());
    }
    Ok(one_core(workspace, &vulkan).arg(frames).run()?)
}

/// `program`, kept on the last core where the system has a command for that.
fn one_core<'a>(workspace: &'a Workspace, program: &Path) -> Cmd<'a> {
    let last = (std::thread::available_parallelism().map_or(1, usize::from) - 1).to_string();
    if cfg!(target_os = "linux") {
        cmd!(workspace.shell, "taskset --cpu-list {last} {program}")
    } else {
        cmd!(workspace.shell, "{program}")
    }
}
