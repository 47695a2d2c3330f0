//! The programs that throw strikers in physics engines (lab/throws).

use std::fs;
use std::path::PathBuf;

use anyhow::{Context, Result};
use xshell::cmd;

use crate::native::{self, Build};
use crate::tools::Tool;
use crate::workspace::{Workspace, empty_directory, jobs};

/// The crate that has Jolt's source. Nothing links with the crate itself.
const JOLT: &str = "joltc-sys";
const JOLT_VERSION: &str = "=0.3.1";

/// Builds lab/throws and the examples that need Jolt against the installed library. Returns the folder of the programs. Bullet is left
/// out where it is not installed.
pub fn build(workspace: &Workspace) -> Result<PathBuf> {
    if !Tool::Bullet.here(workspace) {
        println!("Bullet is left out: on Debian, apt-get install libbullet-dev pkg-config");
    }
    let prefix = native::release_prefix(workspace)?;
    let source = format!("-DCRUMPLE_JOLT={}", jolt_source(workspace)?.display());
    let directory = workspace.target.join("throws");
    let build = Build { options: &[&source], ..Build::new("throws", &prefix) };
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
