//! Coverage-guided fuzzing on the stable toolchain. Code generation flags switch on the compiler's coverage pass.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Result, ensure};
use clap::Args;

use crate::files::{copy_into, empty, files, make, read, within};
use crate::vulkan;
use crate::workspace::{cmd, in_root, in_target, jobs, run, rustc_says, side_by_side};

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
    /// Fuzz nothing: print which lines of src the corpora reach
    #[arg(long, conflicts_with = "keep")]
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
    let mut chosen = chosen.map(|name| {
        let (corpus, kept) = (corpora.join(name), in_root("fuzz/corpus").join(name));
        Target { name, program: programs.join(name), corpus, kept }
    });
    if options.coverage {
        return coverage(chosen);
    }
    if options.keep {
        return chosen.try_for_each(|target| target.keep());
    }
    let fuzzers = chosen.map(|target| target.fuzzer(options, &home.join("found").join(target.name)));
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

    /// Runs the corpus once. Adds to `lines` those of `src` where the compiler counts, each with whether it was reached: binutils'
    /// addr2line names the lines of the places.
    fn lines(&self, lines: &mut BTreeMap<(String, u32), bool>) -> Result<()> {
        let Self { program, corpus, .. } = self;
        make(corpus)?;
        let places = corpus.with_extension("places");
        cmd!("{program}").env("CRUMPLE_SEEDS", corpus).env("CRUMPLE_COVERAGE", &places).run()?;
        let places = read(&places)?;
        let (addresses, reached): (Vec<&str>, Vec<bool>) =
            places.lines().filter_map(|line| line.split_once(' ')).map(|(address, hit)| (address, hit == "1")).unzip();
        let named = cmd!("addr2line -e {program}").stdin(addresses.join("\n")).read()?;
        ensure!(named.lines().count() == reached.len(), "addr2line named another number of lines");
        for (line, reached) in named.lines().zip(reached) {
            // FILE:LINE, and sometimes " (discriminator 2)".
            let place = line.split(' ').next().and_then(|line| line.rsplit_once(':'));
            let Some((file, number)) = place else { continue };
            if let (Ok(file), Ok(number)) = (within(&in_root("src"), Path::new(file)), number.parse()) {
                *lines.entry((file, number)).or_default() |= reached;
            }
        }
        Ok(())
    }
}

/// Prints for each room how many of the lines where the compiler counts any of the targets reached.
fn coverage<'a>(mut targets: impl Iterator<Item = Target<'a>>) -> Result<()> {
    let (mut lines, mut rooms) = (BTreeMap::new(), BTreeMap::<&str, (usize, usize)>::new());
    targets.try_for_each(|target| target.lines(&mut lines))?;
    for ((file, _), reached) in &lines {
        for room in [file.split_once('/').map_or(".", |(room, _)| room), "all"] {
            let (hit, all) = rooms.entry(room).or_default();
            (*hit, *all) = (*hit + usize::from(*reached), *all + 1);
        }
    }
    println!("| room | lines reached | lines where the compiler counts | |\n|---|---|---|---|");
    for (room, (hit, all)) in rooms {
        println!("| `{room}` | {hit} | {all} | {:.0} % |", 100.0 * hit as f64 / all as f64);
    }
    Ok(())
}

fn targets() -> Result<Vec<String>> {
    let names = files("fuzz/src/bin")?.into_iter();
    Ok(names.filter_map(|file| Some(file.file_stem()?.to_string_lossy().into_owned())).collect())
}

/// Builds all targets, and returns Cargo's target directory and the folder of the programs.
fn build(options: &Options) -> Result<[PathBuf; 2]> {
    let (address, profile, host) = (options.address, options.profile, rustc_says("host")?);
    let home = in_target(if address { "fuzz-address" } else { "fuzz" });
    let flags = if address { format!("{COVERAGE} -Zsanitizer=address") } else { COVERAGE.to_owned() };
    // --target keeps build scripts and macros free of instrumentation.
    let arguments = ["--profile", profile, "--target", &host];
    let build = cmd!("cargo build --manifest-path fuzz/Cargo.toml --target-dir {home} {arguments...}");
    // The compiler calls sanitizers unstable.
    let bootstrap = address.then_some(("RUSTC_BOOTSTRAP", "1"));
    build.env("RUSTFLAGS", flags).envs(bootstrap).run()?;
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
