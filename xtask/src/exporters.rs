//! What other programs write: a plate with two dents goes through the exporters of Blender, three.js, assimp, trimesh and Godot, and
//! what they wrote is swept.

use std::fs;
use std::path::Path;

use anyhow::Result;
use xshell::{Cmd, cmd};

use crate::files::empty_directory;
use crate::workspace::Workspace;
use crate::{blender, godot, python, tools};

const SCRIPTS: &str = "tests/exporters";
const THREE: &str = "three@0.187.0";
/// Files that have no examples left, or whose geometry is compressed with Draco.
const REFUSED: &[&str] = &[
    "assimp/of_obj.glb",
    "blender/applied.glb",
    "blender/draco.glb",
    "blender/no_shape_keys.glb",
    "trimesh/scene.glb",
];

pub fn stage(workspace: &Workspace) -> Result<()> {
    let exports = workspace.target.join("exports");
    export(workspace, &exports)?;
    for options in ["", "--join"] {
        let test = workspace.tests(&[]).env("CRUMPLE_SWEEP_REFUSED", REFUSED.join(","));
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
    let script = |name: &str| workspace.path(SCRIPTS).join(name);
    let of = |name: &str| exports.join(name);
    let (by_blender, by_three, by_trimesh) = (script("blender.py"), script("three.mjs"), script("trimesh_files.py"));
    let (plain, plain_obj) = (of("blender/plain.glb"), of("blender/plain.obj"));
    let folder = of("blender");
    cmd!(sh, "{blender} {by_blender} {folder}").ignore_stdout().ignore_stderr().run()?;
    let folder = of("three");
    cmd!(sh, "node {by_three} {modules} {plain} {folder}").run()?;
    let folder = of("trimesh");
    cmd!(sh, "{trimesh} {by_trimesh} {plain} {folder}").env("PYTHONDONTWRITEBYTECODE", "1").run()?;
    fs::create_dir(of("assimp"))?;
    for (source, name, format) in
        [(&plain, "plain.glb", "glb2"), (&plain, "plain.gltf", "gltf2"), (&plain_obj, "of_obj.glb", "glb2")]
    {
        let (out, format) = (of("assimp").join(name), format!("-f{format}"));
        cmd!(sh, "assimp export {source} {out} {format}").ignore_stdout().run()?;
    }
    fs::create_dir(of("godot"))?;
    let (by_godot, out) = (script("godot.gd"), of("godot/plain.glb"));
    let _home = godot::home(workspace, &exports.join("home"));
    cmd!(sh, "timeout 120 {godot} --headless --script {by_godot} -- {plain} {out}").ignore_stdout().run()?;
    Ok(())
}
