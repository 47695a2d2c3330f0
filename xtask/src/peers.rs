//! Other people's programs that must agree with what the command writes: Blender and the Khronos glTF validator.
//! Each is installed under the target directory, in the one version that the tests were written against.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Result, ensure};
use xshell::cmd;

use crate::command::Command;
use crate::stage::Outcome;
use crate::workspace::{Workspace, empty_directory};

const BLENDER: &str = "bpy==4.5.3";
const VALIDATOR: &str = "gltf-validator@2.0.0-dev.3.10";
/// Hits on each file that is tried: few enough that something stays undented, enough that dents meet.
const HITS: &str = "6";

pub fn blender(workspace: &Workspace) -> Result<Outcome> {
    let sh = &workspace.shell;
    let environment = tools(workspace).join(BLENDER.replace('=', "-"));
    let python = environment.join("bin/python");
    if cmd!(sh, "{python} -c 'import bpy'").quiet().ignore_stderr().run().is_err() {
        println!("installing {BLENDER}, about 350 MB, into {}", environment.display());
        empty_directory(&environment)?;
        cmd!(sh, "python3.11 -m venv {environment}").run()?;
        let pip = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--only-binary", ":all:"];
        if let Err(error) = cmd!(sh, "{python} {pip...} {BLENDER}").run() {
            return Ok(Outcome::Skipped(format!("{BLENDER} cannot be installed: {error}")));
        }
    }
    let script = workspace.path("xtask/peers/open_in_blender.py");
    let pairs: Vec<PathBuf> = dented(workspace)?.into_iter().flatten().collect();
    cmd!(sh, "{python} {script} {pairs...}").run()?;
    Ok(Outcome::Passed)
}

pub fn gltf_validator(workspace: &Workspace) -> Result<Outcome> {
    let sh = &workspace.shell;
    let directory = tools(workspace).join(VALIDATOR);
    if !directory.join("node_modules/gltf-validator").is_dir() {
        empty_directory(&directory)?;
        // A package of its own, or npm would look for one further up and install there.
        fs::write(directory.join("package.json"), "{ \"private\": true }\n")?;
        let _here = sh.push_dir(&directory);
        if let Err(error) = cmd!(sh, "npm install --loglevel=error --no-audit --no-fund {VALIDATOR}").run() {
            return Ok(Outcome::Skipped(format!("{VALIDATOR} cannot be installed: {error}")));
        }
    }
    // Node looks for a module beside the script that imports it.
    let script = directory.join("validate.mjs");
    fs::copy(workspace.path("xtask/peers/validate.mjs"), &script)?;
    let files: Vec<PathBuf> = dented(workspace)?.into_iter().map(|[_, dented]| dented).collect();
    cmd!(sh, "node {script} {files...}").run()?;
    Ok(Outcome::Passed)
}

fn tools(workspace: &Workspace) -> PathBuf {
    workspace.target.join("tools")
}

/// Every glTF file of the repository that has examples, with its dented copy.
fn dented(workspace: &Workspace) -> Result<Vec<[PathBuf; 2]>> {
    let command = Command::build(workspace)?;
    let directory = workspace.target.join("dented");
    empty_directory(&directory)?;
    let mut sources = Vec::new();
    for place in ["assets", "tests/fixtures"] {
        gltf_files(&workspace.path(place), &mut sources)?;
    }
    let mut pairs = Vec::new();
    for (index, source) in sources.into_iter().enumerate() {
        let stem = source.file_stem().unwrap_or_default().to_string_lossy();
        let name = format!("{index:02} {stem}");
        let impacts = directory.join(format!("{name}.json"));
        let dented = directory.join(format!("{name}.glb"));
        command.sample(&source, &impacts, HITS)?;
        command.apply(&source, &impacts, &dented, None)?;
        pairs.push([source, dented]);
    }
    ensure!(!pairs.is_empty(), "there is no glTF file in assets or tests/fixtures");
    Ok(pairs)
}

fn gltf_files(directory: &Path, files: &mut Vec<PathBuf>) -> Result<()> {
    let mut entries = fs::read_dir(directory)?.collect::<Result<Vec<_>, _>>()?;
    entries.sort_by_key(fs::DirEntry::path);
    for entry in entries {
        let path = entry.path();
        if path.is_dir() {
            gltf_files(&path, files)?;
        } else if path.extension().is_some_and(|extension| extension == "glb" || extension == "gltf") {
            files.push(path);
        }
    }
    Ok(())
}
