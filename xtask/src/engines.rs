//! Physics engines whose contacts go through the contact layer: Jolt on the demo's hood, and rapier and Bullet on the truths' hits.

use std::fs;
use std::path::PathBuf;

use anyhow::{Context, Result};
use xshell::cmd;

use crate::lab;
use crate::native::{self, Build};
use crate::stage::{Outcome, all_passed};
use crate::workspace::{Workspace, empty_directory};

/// The crate that has Jolt's source. Nothing links with the crate itself.
const JOLT: &str = "joltc-sys";
const JOLT_VERSION: &str = "=0.3.1";

pub fn stage(workspace: &Workspace) -> Result<Outcome> {
    all_passed(vec![("Jolt", jolt(workspace)), ("the truths in rapier and Bullet", truths(workspace))])?;
    Ok(Outcome::Passed)
}

fn jolt(workspace: &Workspace) -> Result<()> {
    let prefix = native::release_prefix(workspace)?;
    let source = format!("-DCRUMPLE_JOLT={}", jolt_source(workspace)?.display());
    let directory = workspace.target.join("ctest/jolt");
    let build = Build { options: &[&source], ..Build::new("jolt", &prefix) };
    native::configure(workspace, &build, &workspace.path("examples-c"), &directory)?;
    let (sh, jobs) = (&workspace.shell, native::jobs());
    cmd!(sh, "cmake --build {directory} --config RelWithDebInfo --target jolt_crash --parallel {jobs}")
        .ignore_stdout()
        .run()?;
    Ok(cmd!(sh, "ctest --test-dir {directory} --tests-regex ^jolt_crash$ --verbose --no-tests=error").run()?)
}

/// The folder of Jolt's source, which Cargo fetches.
fn jolt_source(workspace: &Workspace) -> Result<PathBuf> {
    let directory = workspace.target.join("jolt");
    empty_directory(&directory)?;
    let manifest = directory.join("Cargo.toml");
    let text =
        "[package]\nname = \"jolt-source\"\nversion = \"0.0.0\"\nedition = \"2024\"\n\n[lib]\npath = \"empty.rs\"\n\n";
    fs::write(&manifest, format!("{text}[dependencies]\n{JOLT} = \"{JOLT_VERSION}\"\n\n[workspace]\n"))?;
    fs::write(directory.join("empty.rs"), "")?;
    let told =
        workspace.cargo(&["metadata", "--format-version", "1", "--manifest-path"]).arg(&manifest).quiet().read()?;
    let told: serde_json::Value = serde_json::from_str(&told)?;
    let packages = told["packages"].as_array().context("cargo metadata lists packages")?;
    let package = packages.iter().find(|package| package["name"] == JOLT);
    let file = package.and_then(|package| package["manifest_path"].as_str());
    let file = PathBuf::from(file.with_context(|| format!("cargo metadata does not tell where {JOLT} is"))?);
    Ok(file.with_file_name("JoltC").join("JoltPhysics"))
}

fn truths(workspace: &Workspace) -> Result<()> {
    let program = lab::program(workspace, &["--features", "engines"])?;
    let throws = lab::throws(workspace)?.map(|program| format!("--bullet={}", program.display()));
    let out = workspace.target.join("lab-engines");
    Ok(cmd!(workspace.shell, "{program} contacts --check {throws...} --out {out}").run()?)
}
