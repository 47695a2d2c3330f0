//! What the command exports, in other programs, and what they export, in the command. Blender and the Khronos glTF validator open and
//! check our files. A plate with two dents goes through the exporters of Blender, three.js, assimp, trimesh and Godot, and what they
//! wrote is swept. Each program is installed in one pinned version below the target directory.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Result, ensure};
use xshell::{Cmd, cmd};

use crate::files::{empty_directory, files};
use crate::workspace::Workspace;
use crate::{blender, command, godot, python, tools};

const VALIDATOR: &str = "gltf-validator@2.0.0-dev.3.10";
const SCRIPTS: &str = "tests/exporters";
const THREE: &str = "three@0.187.0";
/// Files that have no examples left, or whose geometry is compressed with Draco.
const REFUSED: &str =
    "assimp/of_obj.glb,blender/applied.glb,blender/draco.glb,blender/no_shape_keys.glb,trimesh/scene.glb";

/// Blender opens every exported fixture and a body that the command dented.
pub fn opened_by_blender(workspace: &Workspace) -> Result<()> {
    let (python, files) = (blender::module(workspace, blender::NEWEST)?, exported(workspace)?);
    let count = files.len();
    cmd!(workspace.shell, "{python} tests/check_in_blender.py {files...}").quiet().ignore_stdout().run()?;
    println!("Blender opens {count} files");
    Ok(())
}

/// The validator finds no error and no warning in the same files.
pub fn valid(workspace: &Workspace) -> Result<()> {
    validate(workspace, &exported(workspace)?)
}

/// The validator finds no error and no warning in `files`.
pub fn validate(workspace: &Workspace, files: &[PathBuf]) -> Result<()> {
    let modules = tools::npm(workspace, &workspace.target.join("validator"), &[VALIDATOR])?;
    cmd!(workspace.shell, "node tests/validate_gltf.js {modules} {files...}").quiet().run()?;
    println!("the validator finds nothing in {} files", files.len());
    Ok(())
}

/// What the exporter's tests write, and a body that the command dented.
fn exported(workspace: &Workspace) -> Result<Vec<PathBuf>> {
    let (sh, program, body) = (&workspace.shell, command::tested(workspace)?, "assets/demo/hood.glb");
    let (directory, impacts) = (workspace.target.join("exported"), workspace.target.join("exported.json"));
    empty_directory(&directory)?;
    workspace.tests(&["--test", "export_gltf"]).env("CRUMPLE_EXPORTED", &directory).run()?;
    let written = files(&directory)?.len();
    ensure!(written > 10, "the exporter's tests wrote {written} files to {}", directory.display());
    cmd!(sh, "{program} sample {body} --count 6 -o {impacts}").quiet().ignore_stdout().run()?;
    cmd!(sh, "{program} apply {body} --impacts {impacts} -o {directory}/hood.glb").quiet().ignore_stdout().run()?;
    files(&directory)
}

/// What other programs write is read, and everything that no dent reached is kept.
pub fn of_others(workspace: &Workspace) -> Result<()> {
    let exports = workspace.target.join("exports");
    export(workspace, &exports)?;
    for options in ["", "--join"] {
        let test = workspace.tests(&[]).env("CRUMPLE_SWEEP_REFUSED", REFUSED);
        sweep(test, &exports, options)?;
    }
    Ok(())
}

/// Runs the sweep over a folder. `test` is a `cargo test` with its features, and `options` are for the commands.
pub fn sweep(test: Cmd<'_>, folder: &Path, options: &str) -> Result<()> {
    let test = test.args(["--test", "cli", "sweep", "--", "--nocapture"]);
    Ok(test.env("CRUMPLE_SWEEP", std::path::absolute(folder)?).env("CRUMPLE_SWEEP_OPTIONS", options).run()?)
}

/// Each program writes into a folder of its own. All but Blender read what Blender wrote.
fn export(workspace: &Workspace, exports: &Path) -> Result<()> {
    let blender = blender::module(workspace, blender::NEWEST)?;
    let trimesh = python::tested_environment(workspace)?;
    let modules = tools::npm(workspace, &workspace.target.join("three"), &[THREE])?;
    let godot = godot::engine(workspace)?;
    empty_directory(exports)?;
    let sh = &workspace.shell;
    let of = |name: &str| exports.join(name);
    let (plain, plain_obj) = (of("blender/plain.glb"), of("blender/plain.obj"));
    cmd!(sh, "{blender} {SCRIPTS}/blender.py {exports}/blender").ignore_stdout().ignore_stderr().run()?;
    cmd!(sh, "node {SCRIPTS}/three.mjs {modules} {plain} {exports}/three").run()?;
    cmd!(sh, "{trimesh} -B {SCRIPTS}/trimesh_files.py {plain} {exports}/trimesh").run()?;
    fs::create_dir(of("assimp"))?;
    for (source, name, format) in
        [(&plain, "plain.glb", "glb2"), (&plain, "plain.gltf", "gltf2"), (&plain_obj, "of_obj.glb", "glb2")]
    {
        cmd!(sh, "assimp export {source} {exports}/assimp/{name} -f{format}").ignore_stdout().run()?;
    }
    fs::create_dir(of("godot"))?;
    let (script, out) = (workspace.path(SCRIPTS).join("godot.gd"), of("godot/plain.glb"));
    let _home = godot::home(workspace, &exports.join("home"));
    cmd!(sh, "timeout 120 {godot} --headless --script {script} -- {plain} {out}").ignore_stdout().run()?;
    Ok(())
}
