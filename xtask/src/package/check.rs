//! Checks an archive as a user has it: unpacked in an empty folder. Its files match its manifest, and its examples build and run,
//! shared and static, by CMake and by pkg-config.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use serde_json::Value;

use super::{manifest, name_of, pack};
use crate::abi;
use crate::files::{copy_tree, read};
use crate::install::{self, Built};
use crate::native::{self, Build};
use crate::target::launch;
use crate::wine::Wine;
use crate::workspace::{VERSION, cmd, run, said, sh, silent};

/// A project of a user, beside the archive's examples.
pub const CLIENT: &str = "xtask/package/client";

/// Packs and checks the full flavour with the release library and the tests' command, which other stages build too.
pub fn stage() -> Result<()> {
    packed(&Built::tested()?, None)
}

/// Packs what was built, and checks the archive.
pub fn packed(built: &Built, wine: Option<&Wine>) -> Result<()> {
    let out = tempfile::tempdir()?;
    check(built, &pack(built, out.path())?, wine)
}

/// Tries an archive on this machine, or under Wine, where stage "windows" runs the examples.
pub fn check(built: &Built, archive: &Path, wine: Option<&Wine>) -> Result<()> {
    if cfg!(windows) {
        println!("an archive for Windows is not unpacked and tried here");
        return Ok(());
    }
    let (scratch, target) = (tempfile::tempdir()?, &built.target);
    let (root, runner) = (scratch.path(), Vec::from_iter(wine.map(|wine| wine.program)));
    let folder = unpack(built, archive, root)?;
    install::loads_well(target, &target.shared_in(&folder))?;
    let _found = wine.map(|wine| wine.libraries(&[&folder.join("bin")]));
    command(built, &folder, &runner)?;
    client(built, root, &folder, &runner)?;
    // pkg-config finds nothing but the archive.
    let _found =
        [sh().push_env("PKG_CONFIG_LIBDIR", folder.join("lib/pkgconfig")), sh().push_env("PKG_CONFIG_PATH", "")];
    if wine.is_some() {
        install::loads_well(target, &folder.join("bindings/unity/Plugins/x86_64/crumple_unity.dll"))?;
        let (flags, program) = (ask(&["--cflags", "--libs"])?, root.join("quickstart.exe"));
        let compiler = target.gnu("gcc");
        run!("{compiler} {folder}/examples-c/quickstart.c -o {program} {flags...}")?;
        launch(&runner, &program).run().context("quickstart.exe under Wine")?;
    } else {
        first_page(built, &folder)?;
        by_cmake(root, &folder)?;
        by_pkg_config(built, root, &folder)?;
    }
    println!("{} is what it says, and programs run with it", archive.display());
    Ok(())
}

/// Unpacks an archive, compares it with its manifest, and returns its folder.
fn unpack(built: &Built, archive: &Path, root: &Path) -> Result<PathBuf> {
    let _there = sh().push_dir(root);
    run!("cmake -E tar xf {archive}")?;
    let folder = root.join(name_of(built));
    ensure!(fs::read_dir(root)?.count() == 1 && folder.is_dir(), "{} holds another folder", archive.display());
    let manifest: Value = serde_json::from_str(&read(folder.join(manifest::FILE))?).context("reading the manifest")?;
    let files = manifest::entries(&folder)?;
    ensure!(manifest["files"] == Value::from(files), "{} is not what its manifest says", archive.display());
    abi::exported(&folder.join("include"), &built.target.shared_in(&folder))?;
    Ok(folder)
}

/// `runner` runs the command, if it is for another system.
fn command(built: &Built, folder: &Path, runner: &[&str]) -> Result<()> {
    let program = folder.join("bin").join(built.target.program("crumple"));
    ensure!(program.exists() == built.flavour.command, "the {} flavour and its command do not fit", built.flavour.name);
    if program.exists() {
        let hood = folder.join("assets/demo/hood.glb");
        let said = launch(runner, &program).arg("info").arg(hood).read()?;
        ensure!(said.contains("24616 vertices"), "crumple info says: {said}");
    }
    Ok(())
}

/// Runs the commands that the first page shows, which build the examples with the shared library.
fn first_page(built: &Built, folder: &Path) -> Result<()> {
    let page = read(folder.join("README.md"))?;
    let _there = sh().push_dir(folder);
    let blocks: Vec<&str> = page.split("```sh\n").skip(1).filter_map(|rest| rest.split("```").next()).collect();
    ensure!(blocks.len() >= 2, "the first page has {} blocks of commands", blocks.len());
    let slow = |block: &&str| !built.handed_out && block.starts_with("bin/crumple");
    for block in blocks.into_iter().filter(|block| !slow(block)) {
        println!("{}", block.trim_end());
        silent!("sh -e -c {block}").context("typing what README.md says")?;
    }
    ensure!(folder.join("build/quickstart").exists(), "the first page builds no quickstart");
    Ok(())
}

/// Builds the archive's examples with the static library. Those that need more than a compiler are left out.
fn by_cmake(root: &Path, folder: &Path) -> Result<()> {
    let (examples, build) = (folder.join("examples-c"), root.join("static"));
    let plain = ["-DCMAKE_DISABLE_FIND_PACKAGE_Vulkan=ON", "-DCMAKE_DISABLE_FIND_PACKAGE_PkgConfig=ON"];
    silent!("cmake -S {examples} -B {build} -DCMAKE_PREFIX_PATH={folder} -DCRUMPLE_STATIC=ON {plain...}")?;
    cmd!("cmake --build {build} --parallel 2").ignore_stdout().run()?;
    native::run_tests(&build, &[])
}

fn client(built: &Built, root: &Path, folder: &Path, runner: &[&str]) -> Result<()> {
    let (source, built, target) = (root.join("client"), root.join("client-build"), &built.target);
    copy_tree(CLIENT, &source)?;
    native::compile(&Build::on(target, "client", folder)?, &source, &built)?;
    for name in ["client-shared", "client-static"] {
        let program = built.join(target.program(name));
        launch(runner, &program).run().with_context(|| format!("{name}, built by CMake"))?;
    }
    Ok(())
}

/// The words that pkg-config says about the library.
fn ask(arguments: &[&str]) -> Result<Vec<String>> {
    let said = said!("pkg-config {arguments...} crumple")?;
    Ok(said.split_whitespace().map(str::to_owned).collect())
}

fn by_pkg_config(built: &Built, root: &Path, folder: &Path) -> Result<()> {
    let version = ask(&["--modversion"])?.concat();
    ensure!(version == VERSION, "pkg-config says version {version}");
    let features = ask(&["--variable=features"])?;
    ensure!(features == built.flavour.library, "pkg-config says the library was built with {features:?}");

    // The first page has the shared library. `--static` adds the system libraries. The file is named because the linker would take the
    // shared library beside it.
    let compile = [ask(&["--cflags"])?, ask(&["--variable=staticlibrary"])?].concat();
    let mut libraries = ask(&["--libs", "--static"])?;
    libraries.retain(|flag| flag != "-lcrumple");
    for (compiler, file) in [("cc", folder.join("examples-c/quickstart.c")), ("c++", root.join("client/client.cpp"))] {
        let (compile, libraries) = (&compile, &libraries);
        run!("{compiler} {file} -o {root}/fixed {compile...} {libraries...} -lm")?;
        run!("{root}/fixed")?;
    }
    Ok(())
}
