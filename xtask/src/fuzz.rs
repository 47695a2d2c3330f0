//! Coverage-guided fuzzing on the stable toolchain. Code generation flags switch on the compiler's coverage pass.

use std::fs;
use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::Args;
use xshell::cmd;

use crate::workspace::Workspace;

/// Instruments the code for libFuzzer's coverage.
const COVERAGE: &[&str] = &[
    "-Cpasses=sancov-module",
    "-Cllvm-args=-sanitizer-coverage-level=4",
    "-Cllvm-args=-sanitizer-coverage-inline-8bit-counters",
    "-Cllvm-args=-sanitizer-coverage-pc-table",
    "-Cllvm-args=-sanitizer-coverage-trace-compares",
    "-Ccodegen-units=1",
    "--cfg=fuzzing",
];

#[derive(Args)]
pub struct Options {
    /// Duration, s
    #[arg(long, default_value_t = 120)]
    seconds: u32,
    /// Number of processes
    #[arg(long, default_value_t = 1)]
    jobs: u32,
    /// Folder that keeps interesting inputs between runs [default: fuzz/corpus in the target directory]
    #[arg(long)]
    corpus: Option<PathBuf>,
}

pub fn run(workspace: &Workspace, options: &Options) -> Result<()> {
    let shell = &workspace.shell;
    let host = workspace.rustc("host")?;
    let home = workspace.target.join("fuzz");
    let corpus = options.corpus.clone().unwrap_or_else(|| home.join("corpus"));
    fs::create_dir_all(&corpus).with_context(|| format!("making {}", corpus.display()))?;
    let manifest = workspace.path("fuzz/Cargo.toml");
    // --target keeps build scripts and macros free of instrumentation.
    cmd!(shell, "cargo build --release --manifest-path {manifest} --target {host} --target-dir {home}")
        .env("RUSTFLAGS", COVERAGE.join(" "))
        .run()?;
    let load = home.join(host).join("release").join("load");
    let (seconds, jobs) = (options.seconds.to_string(), options.jobs.to_string());
    let found = format!("{}/", home.display());
    let mut fuzz = cmd!(shell, "{load} {corpus} -max_total_time={seconds} -timeout=10 -rss_limit_mb=2048")
        .env("CRUMPLE_SEEDS", &corpus)
        .arg(format!("-artifact_prefix={found}"))
        .arg("-max_len=65536")
        .arg("-print_final_stats=1");
    if options.jobs > 1 {
        fuzz = fuzz.arg(format!("-fork={jobs}"));
    }
    fuzz.run().with_context(|| format!("what broke it lies in {found}"))
}
