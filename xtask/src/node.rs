//! Packages of npm, and the Khronos glTF validator, which is one of them.

use std::path::PathBuf;

use anyhow::{Context, Result};

use crate::files::empty;
use crate::stage::LeftOut;
use crate::workspace::{cmd, in_target, run};

const VALIDATOR: &str = "gltf-validator@2.0.0-dev.3.10";

/// Installs packages of npm, `NAME@VERSION`, if they are not there, in a folder below the target directory that has nothing else. Returns
/// the folder of the modules.
pub fn modules(folder: &str, packages: &[&str]) -> Result<PathBuf> {
    let home = in_target(folder);
    let modules = home.join("node_modules");
    let name = |package: &str| package.split('@').next().unwrap_or_default().to_owned();
    if !packages.iter().all(|package| modules.join(name(package)).is_dir()) {
        empty(&home)?;
        let install = ["install", "--loglevel=error", "--no-audit", "--no-fund", "--prefix"];
        let installed = cmd!("npm {install...} {home} {packages...}").run();
        installed.with_context(|| {
            let packages = packages.join(" ");
            LeftOut::Missing(format!("packages of npm cannot be had; to see why: npm install {packages}"))
        })?;
    }
    Ok(modules)
}

/// The Khronos glTF validator finds no error and no warning in `files`.
pub fn validate(files: &[PathBuf]) -> Result<()> {
    let modules = modules("validator", &[VALIDATOR])?;
    run!("node tests/validate_gltf.js {modules} {files...}")?;
    println!("the validator finds nothing in {} files", files.len());
    Ok(())
}
