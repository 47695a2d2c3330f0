//! Builds the `crumple` command.

use crate::prelude::*;

/// The features of the released command, beside the default ones.
pub const FEATURES: &str = "cli,wgpu";

/// The command that the tests use.
pub fn tested() -> Result<PathBuf> {
    build_as_tested(&["--bin", "crumple"]).run()?;
    built(Profile::Debug)
}

/// An optimized command for this machine; the GPU's part takes long to build.
pub fn fast(gpu: bool) -> Result<PathBuf> {
    let features = if gpu { FEATURES } else { "cli" };
    let release = ["build", "--release", "--bin", "crumple", "--package", "crumple", "--features", features];
    cargo_anywhere(&release)?.run()?;
    built(Profile::Release)
}

/// The command of a release archive.
pub fn handed_out(target: &Target) -> Result<PathBuf> {
    let dist = ["build", "--profile", "dist", "--bin", "crumple", "--package", "crumple", "--features", FEATURES];
    target.cargo(&dist)?.run()?;
    Ok(target.directory(Profile::Dist.directory()).join(target.program("crumple")))
}

fn built(profile: Profile) -> Result<PathBuf> {
    let target = Target::host()?;
    Ok(target.directory(profile.directory()).join(target.program("crumple")))
}
