//! The ways to build the library from its source: the CMake project, the Conan recipe, and the crate as crates.io gets it.

use std::path::Path;

use anyhow::Result;

use crate::files::{copy_tree, empty, write};
use crate::package::CLIENT;
use crate::tools::PYTHON3;
use crate::workspace::{FLAGS, anywhere, cargo, cmd, in_target, root, run, sh, silent, target_folder};
use crate::{install, native, python};

const REQUIREMENTS: &str = "xtask/package/requirements.txt";

/// A program fetches the library's source with CMake, which builds it by Cargo. The same project installs the files that
/// `cargo xtask install` does, and a program finds them.
pub fn cmake() -> Result<()> {
    let (prefix, folder, root) = (install::release_prefix()?, empty(in_target("cmake"))?, root());
    // Cargo finds what the installer built.
    let _flags = sh().push_env(FLAGS, anywhere()?);
    let target = target_folder();
    let build = |source: &Path, name: &str, option: &str| -> Result<()> {
        silent!("cmake -S {source} -B {folder}/{name} -DCRUMPLE_CARGO_TARGET_DIR={target} {option}")?;
        Ok(cmd!("cmake --build {folder}/{name}").ignore_stdout().run()?)
    };
    build(root, "library", "-DCRUMPLE_INSTALL=ON")?;
    let installed = folder.join("prefix");
    cmd!("cmake --install {folder}/library --prefix {installed}").ignore_stdout().run()?;
    run!("diff --recursive {prefix} {installed}")?;
    let fetched = format!("-DCRUMPLE_SOURCE={}", root.display());
    let found = format!("-DCMAKE_PREFIX_PATH={}", installed.display());
    for (name, option) in [("fetched", fetched), ("found", found)] {
        build(Path::new(CLIENT), name, &option)?;
        native::run_tests(&folder.join(name), &[])?;
    }
    Ok(())
}

/// Conan builds the package of the recipe, and a program finds it.
pub fn conan() -> Result<()> {
    let python = python::environment(PYTHON3, "conan-venv", REQUIREMENTS)?;
    let (conan, home, root) = (python.with_file_name("conan"), empty(in_target("conan"))?, root());
    // Conan builds the program where its source is.
    let client = home.join("client");
    copy_tree(CLIENT, &client)?;
    let _home = sh().push_env("CONAN_HOME", &home);
    // Cargo builds in a folder below, and finds the dependencies that the installer built. The library alone is another one, which is not
    // optimised: that would take a minute.
    write(home.join(".cargo/config.toml"), "[profile.release.package.crumple]\nopt-level = 0\n")?;
    let _flags = sh().push_env(FLAGS, anywhere()?);
    // In the cache: CMake would prefer the default there to a plain variable.
    let target =
        format!("{{'value': '{}', 'cache': True, 'type': 'PATH', 'docstring': 'Cargo'}}", target_folder().display());
    let target = format!("tools.cmake.cmaketoolchain:extra_variables={{'CRUMPLE_CARGO_TARGET_DIR': {target}}}");
    cmd!("{conan} profile detect").quiet().ignore_stdout().ignore_stderr().run()?;
    cmd!("{conan} create {root} --test-folder {client} --conf {target}").ignore_stdout().run()?;
    Ok(())
}

/// The crate compiles from the files that crates.io gets.
pub fn crates_io() -> Result<()> {
    Ok(cargo(&["package", "--quiet", "--locked", "--allow-dirty", "--package", "crumple"]).run()?)
}
