//! The npm package for browsers and Node: the library as WebAssembly, its interface in JavaScript, and a page that crashes a car.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use clap::Args;
use xshell::cmd;

use crate::car::{self, CRASH};
use crate::command;
use crate::files::{copy, copy_tree, empty_directory};
use crate::install::Profile;
use crate::package::licenses;
use crate::target::{self, Target};
use crate::tools::{self, LLVM, NPM, WEB_RUST};
use crate::workspace::Workspace;

const PACKAGE: &str = "bindings/web";
/// The parts of the package's folder that users get.
const INTERFACE: &[&str] = &["package.json", "README.md", "crumple.js", "crumple.d.ts"];
/// What the page draws with, and what drives the browser in its test.
const THREE: &str = "three@0.180.0";
const DRIVER: &str = "playwright-core@1.56.1";
/// The parts of three.js that the page loads.
const DRAWN_WITH: &str = "LICENSE build/three.module.js build/three.core.js examples/jsm/controls/OrbitControls.js \
                          examples/jsm/environments/RoomEnvironment.js examples/jsm/libs/meshopt_decoder.module.js \
                          examples/jsm/loaders/GLTFLoader.js examples/jsm/utils/BufferGeometryUtils.js";

#[derive(Args)]
pub struct Options {
    /// Folder for the package and the page
    #[arg(long, value_name = "DIR", default_value = "out/web")]
    out: PathBuf,
}

/// `cargo xtask web`: the package in DIR/crumple, and the page around it.
pub fn run(workspace: &Workspace, options: &Options) -> Result<()> {
    tools::require(workspace, &[WEB_RUST, LLVM, NPM])?;
    let out = workspace.path(&options.out);
    lay_out(workspace, &node(workspace, &[THREE])?, &out)?;
    println!(
        "{0}/crumple is the package. Serve {0} and open it: python3 -m http.server --directory {0}",
        out.display()
    );
    Ok(())
}

/// The module gives the native library's bits under Node, and the page works in Chromium.
pub fn stage(workspace: &Workspace) -> Result<()> {
    let modules = node(workspace, &[THREE, DRIVER])?;
    let folder = workspace.target.join("web/page");
    lay_out(workspace, &modules, &folder)?;
    let (sh, set) = (&workspace.shell, folder.join("car.crumple"));
    let dented = workspace.target.join("web/dented.glb");
    let program = command::tested(workspace)?;
    cmd!(sh, "{program} apply {set} --impacts {CRASH} -o {dented}").quiet().ignore_stdout().run()?;
    let (page, module) = (workspace.path(PACKAGE).join("test/page.mjs"), folder.join("crumple/crumple.wasm"));
    cmd!(sh, "node {PACKAGE}/test/node.mjs {module} {set} {CRASH} {dented}").run()?;
    let _there = sh.push_dir(modules.parent().context("the modules are in a folder")?);
    let picture = workspace.target.join("web/page.png");
    cmd!(sh, "node {page} {folder} /usr/bin/chromium {picture}").run()?;
    Ok(())
}

/// The folder of Node's modules, with these packages.
fn node(workspace: &Workspace, packages: &[&str]) -> Result<PathBuf> {
    tools::npm(workspace, &workspace.target.join("web/node"), packages)
}

fn manifest(workspace: &Workspace) -> PathBuf {
    workspace.path(PACKAGE).join("Cargo.toml")
}

/// Builds the module.
pub fn build(workspace: &Workspace) -> Result<()> {
    let cargo = Target::other(target::WEB).cargo(workspace, &["build", "--release", "--locked"])?;
    Ok(cargo.arg("--manifest-path").arg(manifest(workspace)).run()?)
}

fn lay_out(workspace: &Workspace, modules: &Path, out: &Path) -> Result<()> {
    empty_directory(out)?;
    let package = out.join("crumple");
    workspace.copy_sources(PACKAGE, INTERFACE, &package)?;
    workspace.copy_licenses(&package)?;
    build(workspace)?;
    let (web, manifest) = (Target::other(target::WEB), manifest(workspace));
    let module = web.directory(workspace, Profile::Release.directory()).join("crumple_web.wasm");
    copy(&module, &package.join("crumple.wasm"))?;
    licenses::write_all(workspace, &licenses::linked_of(workspace, &manifest, &[web])?, &package)?;
    copy_tree(&workspace.path(PACKAGE).join("demo"), out)?;
    for file in DRAWN_WITH.split(' ') {
        copy(&modules.join("three").join(file), &out.join("three").join(file))?;
    }
    car::lay_out(workspace, out, &[])
}
