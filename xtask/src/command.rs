//! Builds the `crumple` command.

use std::path::PathBuf;

use anyhow::Result;

use crate::target::Target;
use crate::workspace::build_as_tested;

/// The features of the released command, beside the default ones.
pub const FEATURES: &str = "cli,wgpu";

/// The command that the tests use.
pub fn tested() -> Result<PathBuf> {
    build_as_tested(&["--bin", "crumple"]).run()?;
    Ok(Target::host()?.built("debug", "crumple"))
}

/// An optimized command, without paths of this machine.
pub fn optimized(target: &Target, profile: &str, features: &str) -> Result<PathBuf> {
    let what = ["build", "--profile", profile, "--bin", "crumple", "--package", "crumple", "--features", features];
    target.cargo(&what)?.run()?;
    Ok(target.built(profile, "crumple"))
}
