//! Checks the exported files with Blender and the Khronos glTF validator. Each is installed in one pinned version below the target
//! directory.

use std::path::PathBuf;

use anyhow::Result;
use xshell::cmd;

use crate::blender;
use crate::command::Command;
use crate::install::Profile;
use crate::stage::Outcome;
use crate::tools;
use crate::workspace::{Workspace, empty_directory};

const VALIDATOR: &str = "gltf-validator@2.0.0-dev.3.10";

/// Blender opens every exported fixture and a body that the command dented.
pub fn opens_exports(workspace: &Workspace) -> Result<Outcome> {
    let python = match blender::module(workspace, blender::NEWEST) {
        Ok(python) => python,
        Err(error) => return Ok(Outcome::LeftOut(format!("{error:#}"))),
    };
    let sh = &workspace.shell;
    let _required = [sh.push_env("CRUMPLE_REQUIRE_BLENDER", "1"), sh.push_env("CRUMPLE_BLENDER_PYTHON", &python)];
    exporter_tests(workspace)?;
    let dented = dented(workspace)?;
    cmd!(sh, "{python} tests/check_in_blender.py {dented}").ignore_stdout().run()?;
    println!("Blender opens {}", dented.display());
    Ok(Outcome::Passed)
}

/// The validator finds no error and no warning in the same files.
pub fn gltf_validator(workspace: &Workspace) -> Result<Outcome> {
    let sh = &workspace.shell;
    if let Err(error) = install_validator(workspace) {
        return Ok(Outcome::LeftOut(format!("{VALIDATOR} cannot be installed: {error}")));
    }
    let _required = sh.push_env("CRUMPLE_REQUIRE_VALIDATOR", "1");
    exporter_tests(workspace)?;
    let dented = dented(workspace)?;
    cmd!(sh, "node tests/validate_gltf.js {dented}").run()?;
    println!("the validator finds nothing in {}", dented.display());
    Ok(Outcome::Passed)
}

/// The validator finds no error and no warning in `files`, made by another stage.
pub fn validate(workspace: &Workspace, files: &[PathBuf]) -> Result<Outcome> {
    if let Err(error) = install_validator(workspace) {
        return Ok(Outcome::InPart(format!("{VALIDATOR} cannot be installed: {error}")));
    }
    cmd!(workspace.shell, "node tests/validate_gltf.js {files...}").quiet().run()?;
    println!("the validator finds nothing in {} files", files.len());
    Ok(Outcome::Passed)
}

/// Installs it where tests/validate_gltf.js looks for it.
fn install_validator(workspace: &Workspace) -> Result<()> {
    tools::npm(workspace, &workspace.path("target/validator"), &[VALIDATOR]).map(drop)
}

fn exporter_tests(workspace: &Workspace) -> Result<()> {
    Ok(workspace.tests(&["--test", "export_gltf"]).run()?)
}

/// The path of a body that the command dented.
fn dented(workspace: &Workspace) -> Result<PathBuf> {
    let command = Command::build(workspace, Profile::Debug, None)?;
    let directory = workspace.target.join("dented");
    empty_directory(&directory)?;
    let (body, impacts, dented) =
        (workspace.path("assets/demo/hood.glb"), directory.join("impacts.json"), directory.join("hood.glb"));
    command.sample(&body, &impacts, "6")?;
    command.apply(&body, &impacts, &dented, None, &[])?;
    Ok(dented)
}
