//! Coverage-guided fuzzing on the stable toolchain. Code generation flags switch on the compiler's coverage pass.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Result, ensure};
use clap::Args;

use crate::files::{copy_into, empty, files, make};
use crate::vulkan;
use crate::workspace::{cmd, in_root, in_target, jobs, run, rustc_says, side_by_side, sysroot};

/// Instruments the code for libFuzzer's coverage.
const COVERAGE: &str = "--cfg=fuzzing -Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
                        -Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table \
                        -Cllvm-args=-sanitizer-coverage-trace-compares";

/// What CI gives to each target, s.
const STAGE_SECONDS: u32 = 10;
/// Bytes and files of fuzz/corpus for each target. Every clone carries them.
const KEPT_BYTES: u64 = 30_000;
const KEPT_FILES: usize = 64;

#[derive(Args, Default)]
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
    /// The profile of fuzz/Cargo.toml to build with.
    #[arg(skip = "release")]
    profile: &'static str,
    /// Fuzz nothing: print how much of each file of src the inputs reach; installs rustup's llvm-tools
    #[arg(long, conflicts_with_all = ["keep", "address"])]
    coverage: bool,
    /// Fuzz nothing: choose the inputs in fuzz/corpus anew, from the corpora
    #[arg(long)]
    keep: bool,
}

pub fn run(options: &Options) -> Result<()> {
    let targets = targets()?;
    for name in &options.target {
        ensure!(targets.contains(name), "there is no target {name:?}; there are: {}", targets.join(", "));
    }
    let [home, programs] = build(options)?;
    let corpora = options.corpus.clone().unwrap_or_else(|| in_target("fuzz/corpus"));
    let chosen = targets.iter().filter(|name| options.target.is_empty() || options.target.contains(name));
    let target = |name| -> Target<'_> {
        let (corpus, kept) = (corpora.join(name), in_root("fuzz/corpus").join(name));
        Target { name, program: programs.join(name), corpus, kept }
    };
    let chosen: Vec<_> = chosen.map(String::as_str).map(target).collect();
    if options.coverage {
        return coverage(options, &home, &chosen);
    }
    if options.keep {
        return chosen.iter().try_for_each(Target::keep);
    }
    let fuzzers = chosen.iter().map(|target| target.fuzzer(options, &home.join("found").join(target.name)));
    side_by_side(options.jobs, fuzzers.collect::<Result<_>>()?)
}

/// A program that is fuzzed.
struct Target<'a> {
    name: &'a str,
    program: PathBuf,
    /// The folder of the inputs that it found interesting.
    corpus: PathBuf,
    /// The folder of those in the repository.
    kept: PathBuf,
}

impl Target<'_> {
    /// Its call. It adds to the corpus, reads what is kept too, and leaves what breaks it in `found`.
    fn fuzzer(&self, options: &Options, found: &Path) -> Result<(String, Command)> {
        let Self { name, program, corpus, kept } = self;
        [corpus, found].into_iter().try_for_each(make)?;
        let Options { seconds, seed, .. } = options;
        // The first folder receives new inputs; the others are only read.
        let folders = [corpus].into_iter().chain(Some(kept).filter(|kept| kept.exists()));
        let dictionary = Some(in_root("fuzz/dictionaries").join(name)).filter(|dictionary| dictionary.exists());
        let dictionary = dictionary.map(|dictionary| format!("-dict={}", dictionary.display()));
        let limits = ["-timeout=30", "-rss_limit_mb=2048", "-malloc_limit_mb=1024", "-max_len=65536"];
        let numbers = [format!("-max_total_time={seconds}"), format!("-seed={seed}")];
        let fuzz = cmd!("{program} {folders...} {limits...} {numbers...} -print_final_stats=1 {dictionary...}");
        let fuzz = fuzz.arg(format!("-artifact_prefix={}/", found.display())).env("CRUMPLE_SEEDS", corpus);
        // Both software drivers, if they are there. Mesa's device selection layer prints errors without a display.
        let drivers = vulkan::drivers().ok().filter(|_| *name == "device").map(std::env::join_paths).transpose()?;
        let fuzz = fuzz.env("NODEVICE_SELECT", "1").envs(drivers.map(|drivers| ("VK_DRIVER_FILES", drivers)));
        Ok((format!("{name} (what broke it lies in {})", found.display()), fuzz.into()))
    }

    /// Replaces what is kept by the smallest of those inputs of the corpus that together reach all that it reaches.
    fn keep(&self) -> Result<()> {
        let Self { program, corpus, kept, .. } = self;
        let merged = empty(corpus.with_extension("merged"))?;
        run!("{program} -set_cover_merge=1 {merged} {corpus}")?;
        let sized = |file: PathBuf| Ok((fs::metadata(&file)?.len(), file));
        let mut all = files(&merged)?.into_iter().map(sized).collect::<Result<Vec<_>>>()?;
        all.sort();
        empty(kept)?;
        let mut total = 0;
        for (size, file) in all.into_iter().take(KEPT_FILES) {
            total += size;
            if total <= KEPT_BYTES {
                copy_into(&file, kept)?;
            }
        }
        println!("{} holds {} files", kept.display(), files(kept)?.len());
        Ok(())
    }
}

/// Runs all inputs once, and prints how much of each file of `src` they reach together.
fn coverage(options: &Options, home: &Path, targets: &[Target<'_>]) -> Result<()> {
    let (profiles, merged) = (empty(home.join("profiles"))?, home.join("merged"));
    let inputs = |target: &Target<'_>| {
        let (name, mut command) = target.fuzzer(options, home)?;
        command.arg("-runs=0").env("LLVM_PROFILE_FILE", profiles.join(target.name));
        Ok((name, command))
    };
    side_by_side(options.jobs, targets.iter().map(inputs).collect::<Result<_>>()?)?;
    run!("rustup component add llvm-tools")?;
    let tools = sysroot()?.join("lib/rustlib").join(rustc_says("host")?).join("bin");
    run!("{tools}/llvm-profdata merge --sparse {profiles} -o {merged}")?;
    let (source, programs) = (in_root("src"), targets.iter().map(|target| &target.program));
    let programs = programs.flat_map(|program| [Path::new("--object"), program]);
    run!("{tools}/llvm-cov report --instr-profile {merged} {programs...} --sources {source}")
}

fn targets() -> Result<Vec<String>> {
    let names = files("fuzz/src/bin")?.into_iter();
    Ok(names.filter_map(|file| Some(file.file_stem()?.to_string_lossy().into_owned())).collect())
}

/// Builds all targets, and returns Cargo's target directory and the folder of the programs.
fn build(options: &Options) -> Result<[PathBuf; 2]> {
    let (home, own) = match (options.coverage, options.address) {
        (true, _) => (in_target("fuzz-coverage"), "-Cinstrument-coverage"),
        (_, true) => (in_target("fuzz-address"), "-Zsanitizer=address"),
        _ => (in_target("fuzz"), ""),
    };
    let (profile, host) = (options.profile, rustc_says("host")?);
    // --target keeps build scripts and macros free of instrumentation.
    let arguments = ["--profile", profile, "--target", &host];
    let build = cmd!("cargo build --manifest-path fuzz/Cargo.toml --target-dir {home} {arguments...}");
    // The compiler calls sanitizers unstable.
    let bootstrap = options.address.then_some(("RUSTC_BOOTSTRAP", "1"));
    build.env("RUSTFLAGS", format!("{COVERAGE} {own}")).envs(bootstrap).run()?;
    let programs = home.join(host).join(profile);
    Ok([home, programs])
}

/// Runs every target for a short time, with the same inputs each time.
pub fn stage() -> Result<()> {
    run(&for_stage())
}

pub fn build_for_stage() -> Result<()> {
    build(&for_stage()).map(drop)
}

fn for_stage() -> Options {
    // Ten seconds are shorter than what the compiler takes to optimise.
    Options { seconds: STAGE_SECONDS, jobs: jobs(), seed: 1, profile: "quick", ..Options::default() }
}
