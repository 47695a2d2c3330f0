//! `cargo xtask lab` runs the lab's parts one after the other, draws their charts and writes docs/lab/README.md. `cargo xtask bench` runs
//! its benchmark, and with `--gpu` that of graphics devices. Stage "engines" has physics engines whose contacts go through the contact
//! layer: Jolt on the demo's hood, and Rapier, Bullet and Jolt on the truths' hits, which the programs of lab/throws throw. The lab's
//! tests have Rapier in scenes of its own.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result};
use clap::Args;
use clap::builder::PossibleValuesParser;

use crate::files::{empty, name, write};
use crate::install::{self, SLIM};
use crate::native::{self, Build};
use crate::python;
use crate::stage::all_passed;
use crate::target::Target;
use crate::tools::{BULLET, PYTHON3};
use crate::workspace::{absolute, build_as_tested, cargo_anywhere, cmd, in_root, in_target, jobs, packages, run};

#[derive(Args)]
pub struct Options {
    /// Measure a few impacts only, in under 3 minutes; writes to target/lab-quick and replaces no committed figure
    #[arg(long)]
    quick: bool,
    /// Only this part; may be given several times
    #[arg(long, value_name = "PART", value_parser = PossibleValuesParser::new(parts().map(|(name, _)| name)))]
    only: Vec<String>,
}

#[derive(Args)]
pub struct BenchOptions {
    /// Measure briefly, without the largest meshes; replaces no committed figure
    #[arg(long)]
    quick: bool,
    /// Write the results as JSON: an array of name, value, unit, reference (in the unit) and ratio
    #[arg(long, value_name = "FILE", conflicts_with = "gpu", value_parser = absolute)]
    json: Option<PathBuf>,
    /// Only the results whose names begin like this, or this workload of graphics devices; may be given several times
    #[arg(long, value_name = "NAME")]
    only: Vec<String>,
    /// Measure each graphics device that the Vulkan loader finds; VK_DRIVER_FILES chooses its drivers
    #[arg(long)]
    gpu: bool,
    /// Only devices whose names begin like this; may be given several times
    #[arg(long, value_name = "NAME", requires = "gpu")]
    device: Vec<String>,
}

/// Parts in their order: subcommands of `crumple-lab`, each with a script of lab/python that follows it, and its arguments.
const PARTS: &str = "accuracy, told surrogates.py, learn, contacts, combine, peers mujoco_peer.py, stability, pictures, looks, speed, \
                        scene, crash film.py crash, crowd film.py crowd, charts draw.py, report report.py";
/// Parts that are a script alone, which gets the folder of what was measured.
const SHOWN: &[&str] = &["charts", "report"];
/// The benchmark of graphics devices that needs none.
const COMPILED: &str = "compiled";

/// The crate that has Jolt's source. Nothing links with the crate itself.
const JOLT: &str = "joltc-sys";
const JOLT_VERSION: &str = "=0.3.1";

pub fn run(options: &Options) -> Result<()> {
    let out = if options.quick { in_target("lab-quick") } else { in_root("docs/lab") };
    if options.quick && options.only.is_empty() {
        empty(&out)?;
    }
    let (start, quick) = (Instant::now(), options.quick.then_some("--quick"));
    let program = timed("build", || program(&["--all-features"]))?;
    let python = timed("python", python)?;
    let run_part = |name: &str, script: &str| -> Result<()> {
        if SHOWN.contains(&name) {
            return run!("{python} -B lab/python/{script} {out}");
        }
        let throws = (name == "contacts").then(throws).transpose()?;
        let throws = throws.map(|folder| format!("--throws={}", folder.display()));
        run!("{program} {name} {throws...} {quick...} --out {out}")?;
        if script.is_empty() {
            return Ok(());
        }
        let script = format!("lab/python/{script}");
        let words = script.split(' ');
        run!("{python} -B {words...} {quick...} --out {out}")
    };
    for (name, script) in
        parts().filter(|(name, _)| options.only.is_empty() || options.only.iter().any(|only| only == name))
    {
        timed(name, || run_part(name, script))
            .with_context(|| format!("part {name} failed; alone: cargo xtask lab --only {name}"))?;
    }
    println!("== lab: {} after {:.0} s", out.display(), start.elapsed().as_secs_f64());
    Ok(())
}

/// The name of each part, and its script with arguments.
fn parts() -> impl Iterator<Item = (&'static str, &'static str)> {
    PARTS.split(", ").map(|part| part.split_once(' ').unwrap_or((part, "")))
}

pub fn bench(options: &BenchOptions) -> Result<()> {
    if options.gpu {
        return bench_devices(options);
    }
    // The physics engines that `cargo xtask lab` needs are left out: they take longer to build than all the rest.
    let program = program(&[])?;
    let (out, lab) = (in_root("docs/bench"), in_root("docs/lab"));
    let quick = options.quick.then_some("--quick");
    let only = options.only.iter().flat_map(|name| ["--only", name]);
    let json = options.json.iter().map(|file| format!("--json={}", file.display()));
    run!("{program} bench {quick...} {only...} {json...} --out {out} --lab {lab}")
}

/// Measures graphics devices. A full run replaces their tables, and the charts and the page made from all tables.
fn bench_devices(options: &BenchOptions) -> Result<()> {
    let (program, out) = (program(&["--features", "gpu"])?, in_root("docs/bench"));
    let asked = |what: &str| options.only.is_empty() || options.only.iter().any(|name| name == what);
    let (quick, whole) = (options.quick.then_some("--quick"), !options.quick && options.only.is_empty());
    if asked(COMPILED) {
        let to = if options.quick { Vec::new() } else { vec!["--out".into(), out.clone()] };
        run!("{program} {COMPILED} {to...}")?;
    }
    let others: Vec<&String> = options.only.iter().filter(|name| *name != COMPILED).collect();
    if others.is_empty() && !options.only.is_empty() {
        return Ok(());
    }
    let library = if whole || !options.only.is_empty() && asked("library") { stripped_library()? } else { None };
    let library = library.map(|file| format!("--library={}", file.display()));
    let only = others.into_iter().flat_map(|name| ["--only", name]);
    let device = options.device.iter().flat_map(|name| ["--device", name]);
    run!("{program} gpu {quick...} {only...} {device...} {library...} --out {out}")?;
    if whole {
        let python = python()?;
        run!("{python} -B lab/python/draw.py {out}")?;
        run!("{python} -B lab/python/gpu_report.py {out}")?;
    }
    Ok(())
}

/// The slim C library, stripped. `None` without a `strip` program.
fn stripped_library() -> Result<Option<PathBuf>> {
    let library = install::dist(&SLIM, &Target::host()?)?.shared;
    let stripped = empty(in_target("stripped"))?.join(name(&library)?);
    if let Err(error) = run!("strip -o {stripped} {library}") {
        println!("left out: the library's size, since it cannot be stripped ({error})");
        return Ok(None);
    }
    Ok(Some(stripped))
}

/// Builds the lab with these features and returns its program.
fn program(features: &[&str]) -> Result<PathBuf> {
    cargo_anywhere(&["build", "--release", "--package", "crumple-lab"])?.args(features).run()?;
    Ok(Target::host()?.built("release", "crumple-lab"))
}

/// A Python with the pinned packages that the scripts need.
fn python() -> Result<PathBuf> {
    python::environment(PYTHON3, "lab-venv", "lab/python/requirements.txt")
}

fn timed<T>(name: &str, work: impl FnOnce() -> Result<T>) -> Result<T> {
    let start = Instant::now();
    let done = work()?;
    println!("== {name}: {:.1} s", start.elapsed().as_secs_f64());
    Ok(done)
}

/// Stage "engines".
pub fn engines() -> Result<()> {
    let (programs, out) = (throws()?, in_target("lab-engines"));
    let options = ["--tests-regex", "^jolt_crash$", "--verbose"];
    let jolt = native::run_tests(&programs.join("examples-c"), &options);
    build_as_tested(&["--bin", "crumple-lab"]).run()?;
    let program = Target::host()?.built("debug", "crumple-lab");
    let truths = cmd!("{program} contacts --check --throws {programs} --out {out}").run();
    all_passed(vec![("Jolt", jolt), ("the truths in all engines", truths.map_err(Into::into))])
}

/// Builds lab/throws and the examples that need Jolt against the installed library. Returns the folder of the programs. Bullet is left
/// out where it is not installed.
fn throws() -> Result<PathBuf> {
    if !BULLET.here() {
        println!("Bullet is left out: on Debian, apt-get install libbullet-dev pkg-config");
    }
    let prefix = install::release_prefix()?;
    let source = format!("-DCRUMPLE_JOLT={}", jolt_source()?.display());
    let folder = in_target("throws");
    let build = Build { options: vec![source], ..Build::new("throws", &prefix) };
    native::compile(&build, &in_root("lab/throws"), &folder)?;
    let jobs = jobs().to_string();
    let build = cmd!("cmake --build {folder} --config RelWithDebInfo --target jolt_crash --parallel {jobs}");
    build.ignore_stdout().run()?;
    Ok(folder)
}

/// The folder of Jolt's source, which Cargo fetches.
fn jolt_source() -> Result<PathBuf> {
    let folder = empty(in_target("jolt"))?;
    let manifest = folder.join("Cargo.toml");
    let package = "[package]\nname = \"jolt-source\"\nedition = \"2024\"\n[lib]\npath = \"empty.rs\"\n[workspace]\n";
    write(&manifest, format!("{package}[dependencies]\n{JOLT} = \"{JOLT_VERSION}\"\n"))?;
    write(folder.join("empty.rs"), "")?;
    let packages = packages(&["--manifest-path", &manifest.to_string_lossy()])?;
    let file =
        packages.iter().find(|package| package["name"] == JOLT).and_then(|found| found["manifest_path"].as_str());
    let file = Path::new(file.with_context(|| format!("cargo metadata does not tell where {JOLT} is"))?);
    Ok(file.with_file_name("JoltC").join("JoltPhysics"))
}
