//! What the command exports, in other programs, and what they export, in the command. Blender and the Khronos glTF validator open and
//! check our files. A plate with two dents goes through the exporters of Blender, three.js, assimp, trimesh and Godot, and what they
//! wrote is swept. Each program is installed in one pinned version below the target directory.

use std::path::{Path, PathBuf};

use anyhow::{Result, ensure};
use xshell::Cmd;

use crate::files::{empty, files, make};
use crate::workspace::{cmd, in_root, in_target, silent, tests};
use crate::{blender, command, godot, node, python};

const SCRIPTS: &str = "tests/exporters";
const THREE: &str = "three@0.187.0";
/// Files that have no examples left, or whose geometry is compressed with Draco.
const REFUSED: &str =
    "assimp/of_obj.glb,blender/applied.glb,blender/draco.glb,blender/no_shape_keys.glb,trimesh/scene.glb";

/// Blender opens every exported fixture and a body that the command dented.
pub fn opened_by_blender() -> Result<()> {
    let (python, files) = (blender::module(blender::NEWEST)?, exported()?);
    let count = files.len();
    silent!("{python} tests/check_in_blender.py {files...}")?;
    println!("Blender opens {count} files");
    Ok(())
}

/// The validator finds no error and no warning in the same files.
pub fn valid() -> Result<()> {
    node::validate(&exported()?)
}

/// What the exporter's tests write, and a body that the command dented.
fn exported() -> Result<Vec<PathBuf>> {
    let (program, body) = (command::tested()?, "assets/demo/hood.glb");
    let (folder, impacts) = (empty(in_target("exported"))?, in_target("exported.json"));
    tests(&["--test", "export_gltf"]).env("CRUMPLE_EXPORTED", &folder).run()?;
    let written = files(&folder)?.len();
    ensure!(written > 10, "the exporter's tests wrote {written} files to {}", folder.display());
    silent!("{program} sample {body} --count 6 -o {impacts}")?;
    silent!("{program} apply {body} --impacts {impacts} -o {folder}/hood.glb")?;
    files(&folder)
}

/// What other programs write is read, and everything that no dent reached is kept.
pub fn of_others() -> Result<()> {
    let exports = empty(in_target("exports"))?;
    export(&exports)?;
    let sweep = |options| sweep(tests(&[]).env("CRUMPLE_SWEEP_REFUSED", REFUSED), &exports, options);
    ["", "--join"].into_iter().try_for_each(sweep)
}

/// Runs the sweep over a folder. `test` is a `cargo test` with its features, and `options` are for the commands.
pub fn sweep(test: Cmd, folder: &Path, options: &str) -> Result<()> {
    let test = test.args(["--test", "cli", "sweep", "--", "--nocapture"]);
    Ok(test.env("CRUMPLE_SWEEP", folder).env("CRUMPLE_SWEEP_OPTIONS", options).run()?)
}

/// Each program writes into a folder of its own. All but Blender read what Blender wrote.
fn export(exports: &Path) -> Result<()> {
    let (blender, trimesh) = (blender::module(blender::NEWEST)?, python::tested_environment()?);
    let (modules, godot) = (node::modules("three", &[THREE])?, godot::engine()?);
    ["assimp", "godot"].iter().try_for_each(|name| make(exports.join(name)))?;
    let plain = exports.join("blender/plain.glb");
    cmd!("{blender} {SCRIPTS}/blender.py {exports}/blender").ignore_stdout().ignore_stderr().run()?;
    cmd!("node {SCRIPTS}/three.mjs {modules} {plain} {exports}/three").run()?;
    cmd!("{trimesh} -B {SCRIPTS}/trimesh_files.py {plain} {exports}/trimesh").run()?;
    for (source, name, format) in
        [("plain.glb", "plain.glb", "glb2"), ("plain.glb", "plain.gltf", "gltf2"), ("plain.obj", "of_obj.glb", "glb2")]
    {
        cmd!("assimp export {exports}/blender/{source} {exports}/assimp/{name} -f{format}").ignore_stdout().run()?;
    }
    let script = in_root(SCRIPTS).join("godot.gd");
    let _home = godot::home(&exports.join("home"));
    cmd!("timeout 120 {godot} --headless --script {script} -- {plain} {exports}/godot/plain.glb")
        .ignore_stdout()
        .run()?;
    Ok(())
}
