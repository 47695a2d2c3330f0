//! The npm package for browsers and Node: the library as WebAssembly, its interface in JavaScript, and a page that crashes a car.

use std::path::Path;

use anyhow::{Context, Result};

use crate::car::{self, CRASH};
use crate::files::{copy, copy_licenses, copy_sources, copy_tree, empty};
use crate::package::licenses;
use crate::target::{Target, WEB};
use crate::tools::{self, LLVM, NPM, WEB_RUST};
use crate::workspace::{cmd, in_root, in_target, sh, silent};
use crate::{command, node};

const PACKAGE: &str = "bindings/web";
/// The parts of the package's folder that users get.
const INTERFACE: &[&str] = &["package.json", "README.md", "crumple.js", "crumple.d.ts"];
/// What the page draws with, and what drives the browser in its test.
const THREE: &str = "three@0.180.0";
const DRIVER: &str = "playwright-core@1.56.1";
const NODE: &str = "web/node";
/// The parts of three.js that the page loads.
const DRAWN_WITH: &str = "LICENSE build/three.module.js build/three.core.js examples/jsm/controls/OrbitControls.js \
                          examples/jsm/environments/RoomEnvironment.js examples/jsm/libs/meshopt_decoder.module.js \
                          examples/jsm/loaders/GLTFLoader.js examples/jsm/utils/BufferGeometryUtils.js";

/// `cargo xtask web`: the package in DIR/crumple, and the page around it.
pub fn run(out: &Path) -> Result<()> {
    tools::require(&[WEB_RUST, LLVM, NPM])?;
    let out = in_root(out);
    lay_out(&node::modules(NODE, &[THREE])?, &out)?;
    println!(
        "{0}/crumple is the package. Serve {0} and open it: python3 -m http.server --directory {0}",
        out.display()
    );
    Ok(())
}

/// The module gives the native library's bits under Node, and the page works in Chromium.
pub fn stage() -> Result<()> {
    let modules = node::modules(NODE, &[THREE, DRIVER])?;
    let folder = in_target("web/page");
    lay_out(&modules, &folder)?;
    let set = folder.join("car.crumple");
    let dented = in_target("web/dented.glb");
    let program = command::tested()?;
    silent!("{program} apply {set} --impacts {CRASH} -o {dented}")?;
    let (page, module) = (in_root(PACKAGE).join("test/page.mjs"), folder.join("crumple/crumple.wasm"));
    cmd!("node {PACKAGE}/test/node.mjs {module} {set} {CRASH} {dented}").run()?;
    let _there = sh().push_dir(modules.parent().context("the modules are in a folder")?);
    let picture = in_target("web/page.png");
    cmd!("node {page} {folder} /usr/bin/chromium {picture}").run()?;
    Ok(())
}

pub fn build() -> Result<()> {
    let cargo = Target::other(WEB).cargo(&["build", "--release", "--locked"])?;
    Ok(cargo.arg("--manifest-path").arg("bindings/web/Cargo.toml").run()?)
}

fn lay_out(modules: &Path, out: &Path) -> Result<()> {
    empty(out)?;
    let package = out.join("crumple");
    copy_sources(PACKAGE, INTERFACE, &package)?;
    copy_licenses(&package)?;
    build()?;
    let web = Target::other(WEB);
    let module = web.folder("release").join("crumple_web.wasm");
    copy(&module, &package.join("crumple.wasm"))?;
    licenses::write_all(&licenses::linked_of(PACKAGE, &[web])?, &package)?;
    copy_tree(in_root(PACKAGE).join("demo"), out)?;
    for file in DRAWN_WITH.split(' ') {
        copy(modules.join("three").join(file), &out.join("three").join(file))?;
    }
    car::lay_out(out, &[])
}
