//! Coverage-guided fuzzing on the stable toolchain. Code generation flags switch on the compiler's coverage pass.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};
use clap::Args;
use xshell::{Cmd, cmd};

use crate::workspace::{Workspace, jobs, side_by_side};
use crate::{corpus, coverage, vulkan};

/// Instruments the code for libFuzzer's coverage.
const COVERAGE: &[&str] = &[
    "-Cpasses=sancov-module",
    "-Cllvm-args=-sanitizer-coverage-level=4",
    "-Cllvm-args=-sanitizer-coverage-inline-8bit-counters",
    "-Cllvm-args=-sanitizer-coverage-pc-table",
    "-Cllvm-args=-sanitizer-coverage-trace-compares",
    "--cfg=fuzzing",
];

/// What CI gives to each target, s.
const STAGE_SECONDS: u32 = 10;

#[derive(Args)]
pub struct Options {
    /// Fuzz only this target; may be given several times [default: every file of fuzz/src/bin]
    #[arg(long, value_name = "NAME")]
    target: Vec<String>,
    /// Duration for each target, s
    #[arg(long, default_value_t = 120)]
    seconds: u32,
    /// Number of targets that are fuzzed at a time
    #[arg(long, default_value_t = 1)]
    jobs: usize,
    /// Folder that keeps interesting inputs between runs, in a folder for each target [default: fuzz/corpus in the target directory]
    #[arg(long)]
    corpus: Option<PathBuf>,
    /// Seed of the random changes; 0 takes another one each time
    #[arg(long, default_value_t = 0)]
    seed: u32,
    /// Build with the address sanitizer too, which finds wrong accesses to memory; slower
    #[arg(long)]
    address: bool,
    /// Profile of fuzz/Cargo.toml to build with
    #[arg(long, default_value = "release", hide = true)]
    profile: String,
    /// Fuzz nothing: print which lines of src the corpora reach
    #[arg(long, conflicts_with = "keep")]
    coverage: bool,
    /// Fuzz nothing: choose the inputs in fuzz/corpus anew, from the corpora
    #[arg(long)]
    keep: bool,
}

pub fn run(workspace: &Workspace, options: &Options) -> Result<()> {
    let targets = targets(workspace)?;
    for name in &options.target {
        ensure!(targets.contains(name), "there is no target {name:?}; there are: {}", targets.join(", "));
    }
    let home = home(workspace, options.address);
    let programs = build(workspace, &home, options)?;
    let corpus = options.corpus.clone().unwrap_or_else(|| workspace.target.join("fuzz/corpus"));
    let chosen = targets.iter().filter(|name| options.target.is_empty() || options.target.contains(name));
    if options.coverage {
        let pairs: Vec<_> = chosen.map(|name| (programs.join(name), corpus.join(name))).collect();
        return coverage::run(workspace, &pairs);
    }
    let kept = workspace.path("fuzz/corpus");
    if options.keep {
        return chosen
            .into_iter()
            .try_for_each(|name| corpus::keep(workspace, &programs.join(name), &corpus.join(name), &kept.join(name)));
    }
    let fuzzer = |name: &String| -> Result<(String, Command)> {
        let (corpus, found, kept) = (corpus.join(name), home.join("found").join(name), kept.join(name));
        for folder in [&corpus, &found] {
            fs::create_dir_all(folder).with_context(|| format!("making {}", folder.display()))?;
        }
        let fuzzer = fuzzer(workspace, options, &programs.join(name), [&corpus, &kept, &found])?;
        Ok((format!("{name} (what broke it lies in {})", found.display()), fuzzer.into()))
    };
    side_by_side(options.jobs, chosen.map(fuzzer).collect::<Result<_>>()?)
}

/// The call of a target. It adds to `corpus`, reads what is in `kept` too, and leaves what breaks it in `found`.
fn fuzzer<'a>(
    workspace: &'a Workspace,
    options: &Options,
    program: &Path,
    [corpus, kept, found]: [&Path; 3],
) -> Result<Cmd<'a>> {
    let (seconds, seed) = (options.seconds.to_string(), options.seed.to_string());
    // The first folder receives new inputs; the others are only read.
    let folders = [corpus].into_iter().chain(Some(kept).filter(|kept| kept.exists()));
    let artifacts = format!("-artifact_prefix={}/", found.display());
    let limits = ["-timeout=30", "-rss_limit_mb=2048", "-malloc_limit_mb=1024", "-max_len=65536"];
    let mut fuzz = cmd!(
        workspace.shell,
        "{program} {folders...} {artifacts} {limits...} -max_total_time={seconds} -seed={seed} -print_final_stats=1"
    )
    .env("CRUMPLE_SEEDS", corpus);
    let name = program.file_name().context("programs have names")?;
    let dictionary = workspace.path("fuzz/dictionaries").join(name);
    if dictionary.exists() {
        fuzz = fuzz.arg(format!("-dict={}", dictionary.display()));
    }
    if name == "device" {
        // Both software drivers, if they are there. Mesa's device selection layer prints errors without a display.
        fuzz = fuzz.env("NODEVICE_SELECT", "1");
        if let Ok(drivers) = vulkan::drivers(workspace) {
            fuzz = fuzz.env("VK_DRIVER_FILES", std::env::join_paths(drivers)?);
        }
    }
    Ok(fuzz)
}

/// The names of the targets.
fn targets(workspace: &Workspace) -> Result<Vec<String>> {
    let mut names = Vec::new();
    for entry in fs::read_dir(workspace.path("fuzz/src/bin"))? {
        names.extend(entry?.path().file_stem().map(|name| name.to_string_lossy().into_owned()));
    }
    names.sort();
    Ok(names)
}

/// Cargo's target directory.
fn home(workspace: &Workspace, address: bool) -> PathBuf {
    workspace.target.join(if address { "fuzz-address" } else { "fuzz" })
}

/// Builds all targets, and returns the folder of the programs.
fn build(workspace: &Workspace, home: &Path, options: &Options) -> Result<PathBuf> {
    let host = workspace.rustc("host")?;
    let manifest = workspace.path("fuzz/Cargo.toml");
    let (address, profile) = (options.address, &options.profile);
    let flags = [COVERAGE, if address { &["-Zsanitizer=address"] } else { &[] }].concat().join(" ");
    // --target keeps build scripts and macros free of instrumentation.
    let arguments = ["--profile", profile, "--target", &host];
    let mut build = cmd!(workspace.shell, "cargo build --manifest-path {manifest} --target-dir {home} {arguments...}")
        .env("RUSTFLAGS", flags);
    if address {
        // The compiler calls sanitizers unstable.
        build = build.env("RUSTC_BOOTSTRAP", "1");
    }
    build.run()?;
    Ok(home.join(host).join(profile))
}

/// Runs every target for a short time, with the same inputs each time.
pub fn stage(workspace: &Workspace) -> Result<()> {
    run(workspace, &for_stage())
}

/// Builds what the stage runs.
pub fn build_for_stage(workspace: &Workspace) -> Result<()> {
    build(workspace, &home(workspace, false), &for_stage()).map(drop)
}

fn for_stage() -> Options {
    Options {
        target: Vec::new(),
        seconds: STAGE_SECONDS,
        jobs: jobs(),
        corpus: None,
        seed: 1,
        address: false,
        // Ten seconds are shorter than what the compiler takes to optimise.
        profile: "quick".into(),
        coverage: false,
        keep: false,
    }
}
