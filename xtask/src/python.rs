//! Python: builds and tests the package as a wheel in environments below the target directory.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use clap::Args;
use xshell::cmd;

use crate::files::{announce, copy, copy_into, empty_directory, files, read, write};
use crate::stage::LeftOut;
use crate::target::Target;
use crate::tools::{self, PYTHON3, PYTHON311, Tool};
use crate::workspace::{Workspace, jobs};
use crate::{install, package};

const PACKAGE: &str = "bindings/python";
/// What the package's tests need, pinned.
const REQUIREMENTS: &str = "bindings/python/tests/requirements.txt";
/// Parts of the package's folder that are in the wheel or make it.
const SOURCES: &[&str] = &["pyproject.toml", "setup.py", "README.md", "src"];
/// Files of a package's folder that the wheel holds as its licenses.
const LICENSES: &[&str] =
    &["LICENSE-MIT", "LICENSE-APACHE", "THIRD-PARTY-LICENSES.txt", "RUST-STANDARD-LIBRARY-LICENSES.html"];
const PIP: &[&str] = &["-m", "pip", "--quiet", "--disable-pip-version-check"];

#[derive(Args)]
pub struct Options {
    /// Folder for the wheel
    #[arg(long, value_name = "DIR", default_value = "out/wheel")]
    out: PathBuf,
}

/// `cargo xtask wheel`: the wheel for this system, with the release library and command.
pub fn run(workspace: &Workspace, options: &Options) -> Result<()> {
    let wheel = build(workspace, true, &workspace.path(&options.out))?;
    announce(&wheel)?;
    Ok(())
}

/// Builds the wheel, installs it beside the packages that its tests need and nothing else, and runs the tests.
pub fn stage(workspace: &Workspace) -> Result<()> {
    let (python, _) = with_package(workspace, &workspace.target.join("python/dist"))?;
    let sh = &workspace.shell;
    // Simulations take one thread each.
    let jobs = jobs().to_string();
    let _no_cache = [sh.push_env("PYTHONDONTWRITEBYTECODE", "1"), sh.push_env("MPLBACKEND", "agg")];
    cmd!(sh, "{python} -m pytest --quiet -p no:cacheprovider -n {jobs} --durations 5 {PACKAGE}/tests").quiet().run()?;
    Ok(())
}

/// A Python in which the package of this checkout is installed, and its wheel, which is in the emptied folder `out`. Its library and
/// command are those that tests have.
pub fn with_package(workspace: &Workspace, out: &Path) -> Result<(PathBuf, PathBuf)> {
    let (python, wheel) = (tested_environment(workspace)?, build(workspace, false, out)?);
    let install = ["install", "--no-index", "--no-deps", "--force-reinstall"];
    cmd!(workspace.shell, "{python} {PIP...} {install...} {wheel}").quiet().run()?;
    Ok((python, wheel))
}

/// The Python with what the package's tests need.
pub fn tested_environment(workspace: &Workspace) -> Result<PathBuf> {
    environment(workspace, PYTHON311, "python-venv", REQUIREMENTS)
}

/// Builds the wheel in an emptied folder: with the library and command that users get, or with those that tests have.
pub fn build(workspace: &Workspace, handed_out: bool, out: &Path) -> Result<PathBuf> {
    // Laid out like an archive.
    let folder = package::full(workspace, handed_out)?;
    let python = tested_environment(workspace)?;
    let source = workspace.target.join("python/source");
    empty_directory(&source)?;
    empty_directory(out)?;
    workspace.copy_sources(PACKAGE, SOURCES, &source)?;
    for license in LICENSES {
        copy_into(&folder.join(license), &source)?;
    }
    let (binaries, target) = (source.join("src/crumple/_bin"), Target::host(workspace)?);
    copy(&install::shared(&target, &folder), &binaries.join(target.shared()))?;
    copy_into(&folder.join("bin").join(target.program("crumple")), &binaries)?;
    let build = ["wheel", "--no-build-isolation", "--no-deps", "--no-index", "--wheel-dir"];
    cmd!(workspace.shell, "{python} {PIP...} {build...} {out} {source}").quiet().run()?;
    match files(out)?.as_slice() {
        [wheel] => Ok(wheel.clone()),
        wheels => bail!("pip wrote {} files to {}; it should write one wheel", wheels.len(), out.display()),
    }
}

/// A Python with pinned packages, in an environment below the target directory that is kept while the pins are the same.
pub fn environment(workspace: &Workspace, tool: Tool, name: &str, requirements: &str) -> Result<PathBuf> {
    let sh = &workspace.shell;
    let environment = workspace.target.join(name);
    let python = if cfg!(windows) { environment.join("Scripts/python.exe") } else { environment.join("bin/python") };
    let path = workspace.path(requirements);
    let (wanted, installed) = (read(&path)?, environment.join("installed.txt"));
    let works = |python: &Path| cmd!(sh, "{python} --version").quiet().ignore_stdout().ignore_stderr().run().is_ok();
    if read(&installed).is_ok_and(|have| have == wanted) && works(&python) {
        return Ok(python);
    }
    tools::require(workspace, &[tool]).with_context(|| format!("{requirements} needs Python"))?;
    println!("installing into {}: {}", environment.display(), wanted.split_whitespace().collect::<Vec<_>>().join(" "));
    empty_directory(&environment)?;
    let base = if tool == PYTHON3 { "python3" } else { "python3.11" };
    cmd!(sh, "{base} -m venv {environment}").quiet().run()?;
    cmd!(sh, "{python} {PIP...} install --only-binary :all: -r {path}").quiet().run().with_context(|| {
        let line = format!("{base} -m pip install -r {requirements}");
        LeftOut::Missing(format!("packages of Python cannot be had; to see why: {line}"))
    })?;
    write(&installed, wanted)?;
    Ok(python)
}
