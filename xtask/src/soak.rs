//! `cargo xtask soak`: hours of random hits and frames through the C interface (tests/c/soak.c), or how long very many of them take
//! (tests/c/times.c, tests/c/vulkan_times.c).

use crate::prelude::*;

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

pub fn run(options: &Options) -> Result<()> {
    let prefix = native::release_prefix()?;
    let build = Build::new("release", &prefix);
    let directory = in_target("ctest/release/tests-c");
    native::compile(&build, &in_root("tests/c"), &directory)?;
    if let Some(frames) = options.frames {
        return times(&directory, &frames.to_string());
    }
    let seconds = options.hours.map_or(options.seconds, |hours| 3600.0 * hours).to_string();
    let (bodies, seed) = (options.bodies.to_string(), options.seed.to_string());
    let soak = directory.join("soak");
    Ok(cmd!("{soak} {seconds} {bodies} {seed}").run()?)
}

fn times(directory: &Path, frames: &str) -> Result<()> {
    one_core(&directory.join("times")).arg(frames).run()?;
    let vulkan = directory.join("vulkan_times");
    if !vulkan.exists() {
        println!("Vulkan is left out: its headers are not installed");
        return Ok(());
    }
    Ok(one_core(&vulkan).arg(frames).run()?)
}

/// `program`, kept on the last core where the system has a command for that.
fn one_core(program: &Path) -> Cmd<'static> {
    let last = (std::thread::available_parallelism().map_or(1, usize::from) - 1).to_string();
    if cfg!(target_os = "linux") { cmd!("taskset --cpu-list {last} {program}") } else { cmd!("{program}") }
}
