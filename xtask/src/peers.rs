//! Checks the exported files with Blender and the Khronos glTF validator. Each is installed in one pinned version below the target
//! directory.

use std::path::PathBuf;

use anyhow::Result;
use xshell::cmd;

use crate::blender;
use crate::command::Command;
use crate::files::empty_directory;
use crate::install::Profile;
use crate::tools;
use crate::workspace::Workspace;

const VALIDATOR: &str = "gltf-validator@2.0.0-dev.3.10";

/// Blender opens every exported fixture and a body that the command dented.
pub fn opens_exports(workspace: &Workspace) -> Result<()> {
    let python = blender::module(workspace, blender::NEWEST)?;
    let sh = &workspace.shell;
    let _required = [sh.push_env("CRUMPLE_REQUIRE_BLENDER", "1"), sh.push_env("CRUMPLE_BLENDER_PYTHON", &python)];
    let dented = exported(workspace)?;
    cmd!(sh, "{python} tests/check_in_blender.py {dented}").ignore_stdout().run()?;
    println!("Blender opens {}", dented.display());
    Ok(())
}

/// The validator finds no error and no warning in the same files.
pub fn gltf_validator(workspace: &Workspace) -> Result<()> {
    install_validator(workspace)?;
    let _required = workspace.shell.push_env("CRUMPLE_REQUIRE_VALIDATOR", "1");
    let dented = exported(workspace)?;
    validate(workspace, &[dented])
}

/// The validator finds no error and no warning in `files`.
pub fn validate(workspace: &Workspace, files: &[PathBuf]) -> Result<()> {
    install_validator(workspace)?;
    cmd!(workspace.shell, "node tests/validate_gltf.js {files...}").quiet().run()?;
    println!("the validator finds nothing in {} files", files.len());
    Ok(())
}

/// Installs it where tests/validate_gltf.js looks for it.
fn install_validator(workspace: &Workspace) -> Result<()> {
    tools::npm(workspace, &workspace.path("target/validator"), &[VALIDATOR]).map(drop)
}

/// Runs the exporter's tests. Returns the path of a body that the command dented.
fn exported(workspace: &Workspace) -> Result<PathBuf> {
    workspace.tests(&["--test", "export_gltf"]).run()?;
    let command = Command::build(workspace, Profile::Debug, None)?;
    let directory = workspace.target.join("dented");
    empty_directory(&directory)?;
    let (body, impacts, dented) =
        (workspace.path("assets/demo/hood.glb"), directory.join("impacts.json"), directory.join("hood.glb"));
    command.sample(&body, &impacts, "6")?;
    command.apply(&body, &impacts, &dented, None, &[])?;
    Ok(dented)
}
