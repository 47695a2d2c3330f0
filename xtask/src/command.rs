//! Builds the `crumple` command.

use std::path::PathBuf;

use anyhow::Result;

use crate::install::Profile;
use crate::target::Target;
use crate::workspace::Workspace;

/// The features of the released command, beside the default ones.
pub const FEATURES: &str = "cli,wgpu";

/// The command that the tests use.
pub fn tested(workspace: &Workspace) -> Result<PathBuf> {
    workspace.build_as_tested(&["--bin", "crumple"]).run()?;
    built(workspace, Profile::Debug)
}

/// An optimized command for this machine; the GPU's part takes long to build.
pub fn fast(workspace: &Workspace, gpu: bool) -> Result<PathBuf> {
    let features = if gpu { FEATURES } else { "cli" };
    let release = ["build", "--release", "--bin", "crumple", "--package", "crumple", "--features", features];
    workspace.cargo_anywhere(&release)?.run()?;
    built(workspace, Profile::Release)
}

/// The command of a release archive.
pub fn handed_out(workspace: &Workspace, target: &Target) -> Result<PathBuf> {
    let dist = ["build", "--profile", "dist", "--bin", "crumple", "--package", "crumple", "--features", FEATURES];
    target.cargo(workspace, &dist)?.run()?;
    Ok(target.directory(workspace, Profile::Dist.directory()).join(target.program("crumple")))
}

fn built(workspace: &Workspace, profile: Profile) -> Result<PathBuf> {
    let target = Target::host(workspace)?;
    Ok(target.directory(workspace, profile.directory()).join(target.program("crumple")))
}
