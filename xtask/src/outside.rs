//! Somebody else's programs: outside the tree, they find a Crumple that was moved after it was installed.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use xshell::cmd;

use crate::native::{self, Build};
use crate::stage::Outcome;
use crate::workspace::Workspace;

/// By the language, the compiler that a person would type and the program it builds.
const PROGRAMS: &[(&str, &str)] = &[("cc", "quickstart.c"), ("c++", "client.cpp")];

pub fn run(workspace: &Workspace) -> Result<Outcome> {
    if cfg!(windows) {
        return Ok(Outcome::Skipped("not done on Windows, where pkg-config is rare".into()));
    }
    let scratch = tempfile::tempdir()?;
    let moved = scratch.path().join("moved");
    let source = scratch.path().join("source");
    let sh = &workspace.shell;
    let installed = native::release_prefix(workspace);
    cmd!(sh, "cp -a {installed} {moved}").quiet().run()?;
    names_no_path(&moved, &installed)?;
    fs::create_dir(&source)?;
    for file in ["xtask/outside/CMakeLists.txt", "xtask/outside/client.cpp", "examples-c/quickstart.c"] {
        let name = Path::new(file).file_name().context("files have names")?;
        fs::copy(workspace.path(file), source.join(name)).with_context(|| format!("copying {file}"))?;
    }
    println!("by CMake:");
    by_cmake(workspace, &source, &scratch.path().join("build"), &moved)?;
    println!("by pkg-config:");
    by_pkg_config(workspace, &source, &moved)?;
    Ok(Outcome::Passed)
}

/// A package that can be moved says nowhere where it was installed.
fn names_no_path(package: &Path, installed: &Path) -> Result<()> {
    let installed = installed.to_string_lossy();
    for directory in ["lib/cmake/Crumple", "lib/pkgconfig", "include"] {
        for entry in fs::read_dir(package.join(directory))? {
            let path = entry?.path();
            let text = fs::read_to_string(&path)?;
            ensure!(!text.contains(&*installed), "{} names {installed}, so it cannot be moved", path.display());
        }
    }
    Ok(())
}

fn by_cmake(workspace: &Workspace, source: &Path, build: &Path, prefix: &Path) -> Result<()> {
    native::compile(workspace, &Build::new("outside", prefix), source, build)?;
    for name in ["quickstart-shared", "quickstart-static", "client-shared", "client-static"] {
        let program = build.join(name);
        cmd!(workspace.shell, "{program}").quiet().run().with_context(|| format!("{name}, built by CMake"))?;
    }
    Ok(())
}

fn by_pkg_config(workspace: &Workspace, source: &Path, prefix: &Path) -> Result<()> {
    let sh = &workspace.shell;
    let _found = sh.push_env("PKG_CONFIG_PATH", prefix.join("lib/pkgconfig"));
    let ask = |arguments: &[&str]| -> Result<Vec<String>> {
        Ok(cmd!(sh, "pkg-config {arguments...} crumple")
            .quiet()
            .read()?
            .split_whitespace()
            .map(str::to_owned)
            .collect())
    };
    for (compiler, file) in PROGRAMS {
        let file = source.join(file);
        let shared = file.with_extension("shared");
        let flags = ask(&["--cflags", "--libs"])?;
        cmd!(sh, "{compiler} {file} -o {shared} {flags...} -lm").quiet().run()?;
        let loader = if cfg!(target_os = "macos") { "DYLD_LIBRARY_PATH" } else { "LD_LIBRARY_PATH" };
        cmd!(sh, "{shared}").env(loader, prefix.join("lib")).quiet().run()?;

        // `--static` adds what the library itself needs; naming the file is how one picks it where the shared one lies beside it.
        let fixed = file.with_extension("static");
        let compile = ask(&["--cflags"])?;
        let archive = ask(&["--variable=staticlibrary"])?;
        let libraries: Vec<String> =
            ask(&["--libs", "--static"])?.into_iter().filter(|flag| flag != "-lcrumple").collect();
        cmd!(sh, "{compiler} {file} -o {fixed} {compile...} {archive...} {libraries...} -lm").quiet().run()?;
        cmd!(sh, "{fixed}").quiet().run()?;
    }
    Ok(())
}
