//! Physics engines whose contacts go through the contact layer: Jolt on the demo's hood, and Rapier, Bullet and Jolt on the truths' hits,
//! which the programs of lab/throws throw. The lab's tests have Rapier in scenes of its own.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use xshell::cmd;

use crate::files::{empty_directory, write};
use crate::native::{self, Build};
use crate::stage::all_passed;
use crate::tools::BULLET;
use crate::workspace::{Workspace, jobs};

/// The crate that has Jolt's source. Nothing links with the crate itself.
const JOLT: &str = "joltc-sys";
const JOLT_VERSION: &str = "=0.3.1";

pub fn stage(workspace: &Workspace) -> Result<()> {
    let programs = build(workspace)?;
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
pub fn build(workspace: &Workspace) -> Result<PathBuf> {
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
    fs::write(directory.join("empty.rs"), "")?;
    let packages = workspace.packages(&["--manifest-path", &manifest.to_string_lossy()])?;
    let file =
        packages.iter().find(|package| package["name"] == JOLT).and_then(|found| found["manifest_path"].as_str());
    let file = PathBuf::from(file.with_context(|| format!("cargo metadata does not tell where {JOLT} is"))?);
    Ok(file.with_file_name("JoltC").join("JoltPhysics"))
}
