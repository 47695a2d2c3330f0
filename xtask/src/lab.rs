//! `cargo xtask lab` runs the lab's parts one after the other, draws their charts and writes docs/lab/README.md. `cargo xtask bench` runs
//! its benchmark, and with `--gpu` that of graphics devices. Stage "engines" has physics engines whose contacts go through the contact
//! layer: Jolt on the demo's hood, and Rapier, Bullet and Jolt on the truths' hits, which the programs of lab/throws throw. The lab's
//! tests have Rapier in scenes of its own.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result, ensure};
use clap::Args;
use xshell::cmd;

use crate::files::{empty_directory, write};
use crate::native::{self, Build};
use crate::package::SLIM;
use crate::python;
use crate::stage::all_passed;
use crate::tools::{BULLET, PYTHON3};
use crate::workspace::{Workspace, jobs};

#[derive(Args)]
pub struct Options {
    /// Measure a few impacts only, in under 3 minutes; writes to target/lab-quick and replaces no committed figure
    #[arg(long)]
    quick: bool,
    /// Only this part; may be given several times
    #[arg(long, value_name = "PART")]
    only: Vec<String>,
}

#[derive(Args)]
pub struct BenchOptions {
    /// Measure briefly, without the largest meshes; replaces no committed figure
    #[arg(long)]
    quick: bool,
    /// Write the results as JSON: an array of name, value, unit, reference (in the unit) and ratio
    #[arg(long, value_name = "FILE", conflicts_with = "gpu")]
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
const MEASURED: &[(&str, &[&str])] = &[
    ("accuracy", &[]),
    ("told", &["surrogates.py"]),
    ("learn", &[]),
    ("contacts", &[]),
    ("combine", &[]),
    ("peers", &["mujoco_peer.py"]),
    ("stability", &[]),
    ("pictures", &[]),
    ("looks", &[]),
    ("speed", &[]),
    ("scene", &[]),
    ("crash", &["film.py", "crash"]),
    ("crowd", &["film.py", "crowd"]),
];
/// Parts that follow, each with its script, which gets the folder of what was measured.
const SHOWN: &[(&str, &str)] = &[("charts", "draw.py"), ("report", "report.py")];
/// The benchmark of graphics devices that needs none.
const COMPILED: &str = "compiled";

/// The crate that has Jolt's source. Nothing links with the crate itself.
const JOLT: &str = "joltc-sys";
const JOLT_VERSION: &str = "=0.3.1";

pub fn run(workspace: &Workspace, options: &Options) -> Result<()> {
    let names: Vec<&str> = MEASURED.iter().map(|part| part.0).chain(SHOWN.iter().map(|part| part.0)).collect();
    for name in &options.only {
        ensure!(names.contains(&name.as_str()), "there is no part {name:?}; there are: {}", names.join(", "));
    }
    let wanted = |name: &str| options.only.is_empty() || options.only.iter().any(|only| only == name);
    let out = if options.quick { workspace.target.join("lab-quick") } else { workspace.path("docs/lab") };
    if options.quick && options.only.is_empty() {
        empty_directory(&out)?;
    }

    let (sh, start) = (&workspace.shell, Instant::now());
    let program = timed("build", || program(workspace, &["--all-features"]))?;
    let python = timed("python", || python(workspace))?;
    let alone = |name: &str| format!("part {name} failed; alone: cargo xtask lab --only {name}");
    for (name, script) in MEASURED.iter().filter(|part| wanted(part.0)) {
        timed(name, || {
            let quick = options.quick.then_some("--quick");
            let throws = (*name == "contacts").then(|| throws(workspace)).transpose()?;
            let throws = throws.map(|folder| format!("--throws={}", folder.display()));
            cmd!(sh, "{program} {name} {throws...} {quick...} --out {out}").quiet().run()?;
            if let [script, arguments @ ..] = script {
                cmd!(sh, "{python} -B lab/python/{script} {arguments...} {quick...} --out {out}").quiet().run()?;
            }
            Ok(())
        })
        .with_context(|| alone(name))?;
    }
    for (name, script) in SHOWN.iter().filter(|part| wanted(part.0)) {
        timed(name, || Ok(cmd!(sh, "{python} -B lab/python/{script} {out}").quiet().run()?))
            .with_context(|| alone(name))?;
    }
    println!("== lab: {} after {:.0} s", out.display(), start.elapsed().as_secs_f64());
    Ok(())
}

pub fn bench(workspace: &Workspace, options: &BenchOptions) -> Result<()> {
    if options.gpu {
        return bench_devices(workspace, options);
    }
    // The physics engines that `cargo xtask lab` needs are left out: they take longer to build than all the rest.
    let program = program(workspace, &[])?;
    let (out, lab) = (workspace.path("docs/bench"), workspace.path("docs/lab"));
    let quick = options.quick.then_some("--quick");
    let only = options.only.iter().flat_map(|name| ["--only", name]);
    let json = match &options.json {
        // The program runs in the repository's root.
        Some(file) => vec!["--json".into(), std::path::absolute(file)?],
        None => Vec::new(),
    };
    cmd!(workspace.shell, "{program} bench {quick...} {only...} {json...} --out {out} --lab {lab}").quiet().run()?;
    Ok(())
}

/// Measures graphics devices. A full run replaces their tables, and the charts and the page made from all tables.
fn bench_devices(workspace: &Workspace, options: &BenchOptions) -> Result<()> {
    let program = program(workspace, &["--features", "gpu"])?;
    let (sh, out) = (&workspace.shell, workspace.path("docs/bench"));
    let asked = |what: &str| options.only.iter().any(|name| name == what);
    let (quick, whole) = (options.quick.then_some("--quick"), !options.quick && options.only.is_empty());
    let library = if asked("library") || whole { stripped_library(workspace)? } else { None };
    if asked(COMPILED) || options.only.is_empty() {
        let to = if options.quick { Vec::new() } else { vec!["--out".into(), out.clone()] };
        cmd!(sh, "{program} {COMPILED} {to...}").quiet().run()?;
    }
    if asked(COMPILED) && options.only.len() == 1 {
        return Ok(());
    }
    let only = options.only.iter().filter(|name| *name != COMPILED).flat_map(|name| ["--only", name]);
    let device = options.device.iter().flat_map(|name| ["--device", name]);
    let library = library.map(|file| format!("--library={}", file.display()));
    cmd!(sh, "{program} gpu {quick...} {only...} {device...} {library...} --out {out}").quiet().run()?;
    if whole {
        let python = python(workspace)?;
        for script in ["draw.py", "gpu_report.py"] {
            cmd!(sh, "{python} -B lab/python/{script} {out}").quiet().run()?;
        }
    }
    Ok(())
}

/// The slim C library, stripped. `None` without a `strip` program.
fn stripped_library(workspace: &Workspace) -> Result<Option<PathBuf>> {
    use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
    let features = SLIM.library.join(",");
    let what = ["build", "--profile", "dist", "--package", "crumple", "--lib", "--no-default-features", "--features"];
    workspace.cargo(&what).arg(features).run()?;
    let (name, folder) = (format!("{DLL_PREFIX}crumple{DLL_SUFFIX}"), workspace.target.join("stripped"));
    let (library, stripped) = (workspace.target.join("dist").join(&name), folder.join(&name));
    empty_directory(&folder)?;
    if let Err(error) = cmd!(workspace.shell, "strip -o {stripped} {library}").quiet().run() {
        println!("left out: the library's size, since it cannot be stripped ({error})");
        return Ok(None);
    }
    Ok(Some(stripped))
}

/// Builds the lab with these features and returns its program.
fn program(workspace: &Workspace, features: &[&str]) -> Result<PathBuf> {
    workspace.cargo_anywhere(&["build", "--release", "--package", "crumple-lab"])?.args(features).run()?;
    Ok(workspace.target.join("release/crumple-lab").with_extension(std::env::consts::EXE_EXTENSION))
}

/// A Python with the pinned packages that the scripts need.
fn python(workspace: &Workspace) -> Result<PathBuf> {
    python::environment(workspace, PYTHON3, "lab-venv", "lab/python/requirements.txt")
}

fn timed<T>(name: &str, work: impl FnOnce() -> Result<T>) -> Result<T> {
    let start = Instant::now();
    let done = work()?;
    println!("== {name}: {:.1} s", start.elapsed().as_secs_f64());
    Ok(done)
}

/// Stage "engines".
pub fn engines(workspace: &Workspace) -> Result<()> {
    let programs = throws(workspace)?;
    all_passed(vec![("Jolt", jolt(workspace, &programs)), ("the truths in all engines", truths(workspace, &programs))])
}

fn jolt(workspace: &Workspace, programs: &Path) -> Result<()> {
    let directory = programs.join("examples-c");
    let sh = &workspace.shell;
    Ok(cmd!(sh, "ctest --test-dir {directory} --tests-regex ^jolt_crash$ --verbose --no-tests=error").run()?)
}

fn truths(workspace: &Workspace, programs: &Path) -> Result<()> {
    workspace.build_as_tested(&["--bin", "crumple-lab"]).run()?;
    let program = workspace.target.join("debug/crumple-lab").with_extension(std::env::consts::EXE_EXTENSION);
    let out = workspace.target.join("lab-engines");
    Ok(cmd!(workspace.shell, "{program} contacts --check --throws {programs} --out {out}").run()?)
}

/// Builds lab/throws and the examples that need Jolt against the installed library. Returns the folder of the programs. Bullet is left
/// out where it is not installed.
fn throws(workspace: &Workspace) -> Result<PathBuf> {
    if !BULLET.here(workspace) {
        println!("Bullet is left out: on Debian, apt-get install libbullet-dev pkg-config");
    }
    let prefix = native::release_prefix(workspace)?;
    let source = format!("-DCRUMPLE_JOLT={}", jolt_source(workspace)?.display());
    let directory = workspace.target.join("throws");
    let build = Build { options: vec![source], ..Build::new("throws", &prefix) };
    native::compile(workspace, &build, &workspace.path("lab/throws"), &directory)?;
    let (sh, jobs) = (&workspace.shell, jobs().to_string());
    cmd!(sh, "cmake --build {directory} --config RelWithDebInfo --target jolt_crash --parallel {jobs}")
        .ignore_stdout()
        .run()?;
    Ok(directory)
}

/// The folder of Jolt's source, which Cargo fetches.
fn jolt_source(workspace: &Workspace) -> Result<PathBuf> {
    let directory = workspace.target.join("jolt");
    empty_directory(&directory)?;
    let manifest = directory.join("Cargo.toml");
    let text =
        "[package]\nname = \"jolt-source\"\nversion = \"0.0.0\"\nedition = \"2024\"\n\n[lib]\npath = \"empty.rs\"\n\n";
    write(&manifest, format!("{text}[dependencies]\n{JOLT} = \"{JOLT_VERSION}\"\n\n[workspace]\n"))?;
    write(&directory.join("empty.rs"), "")?;
    let packages = workspace.packages(&["--manifest-path", &manifest.to_string_lossy()])?;
    let file =
        packages.iter().find(|package| package["name"] == JOLT).and_then(|found| found["manifest_path"].as_str());
    let file = PathBuf::from(file.with_context(|| format!("cargo metadata does not tell where {JOLT} is"))?);
    Ok(file.with_file_name("JoltC").join("JoltPhysics"))
}
