//! Python: builds and tests the package as a wheel in environments below the target directory.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};

use crate::files::{announce, copy, copy_into, copy_licenses, copy_sources, empty, files, read, write};
use crate::package::{self, licenses};
use crate::stage::LeftOut;
use crate::target::Target;
use crate::tools::{self, PYTHON3, PYTHON311, Tool};
use crate::workspace::{in_root, in_target, jobs, run, sh, silent};

const PACKAGE: &str = "bindings/python";
/// What the package's tests need, pinned.
const REQUIREMENTS: &str = "bindings/python/tests/requirements.txt";
/// Parts of the package's folder that are in the wheel or make it.
const SOURCES: &[&str] = &["pyproject.toml", "setup.py", "README.md", "src"];
const PIP: &[&str] = &["-m", "pip", "--quiet", "--disable-pip-version-check"];

/// `cargo xtask wheel`: the wheel for this system, with the release library and command.
pub fn run(out: &Path) -> Result<()> {
    announce(&build(true, &in_root(out))?)
}

/// Builds the wheel, installs it beside the packages that its tests need and nothing else, and runs the tests.
pub fn stage() -> Result<()> {
    let (python, _) = with_package(&in_target("python/dist"))?;
    // Simulations take one thread each.
    let jobs = jobs().to_string();
    let _no_cache = [sh().push_env("PYTHONDONTWRITEBYTECODE", "1"), sh().push_env("MPLBACKEND", "agg")];
    run!("{python} -m pytest --quiet -p no:cacheprovider -n {jobs} --durations 5 {PACKAGE}/tests")
}

/// A Python in which the package of this checkout is installed, and its wheel, which is in the emptied folder `out`. Its library and
/// command are those that tests have.
pub fn with_package(out: &Path) -> Result<(PathBuf, PathBuf)> {
    let (python, wheel) = (tested_environment()?, build(false, out)?);
    run!("{python} {PIP...} install --no-index --no-deps --force-reinstall {wheel}")?;
    Ok((python, wheel))
}

pub fn tested_environment() -> Result<PathBuf> {
    environment(PYTHON311, "python-venv", REQUIREMENTS)
}

/// Builds the wheel in an emptied folder: with the library and command that users get, or with those that tests have.
pub fn build(handed_out: bool, out: &Path) -> Result<PathBuf> {
    // Laid out like an archive.
    let folder = package::full(handed_out)?;
    let python = tested_environment()?;
    let source = empty(in_target("python/source"))?;
    empty(out)?;
    copy_sources(PACKAGE, SOURCES, &source)?;
    copy_licenses(&source)?;
    [licenses::FILE, licenses::STANDARD_LIBRARY].iter().try_for_each(|name| copy_into(folder.join(name), &source))?;
    let (binaries, target) = (source.join("src/crumple/_bin"), Target::host()?);
    copy(target.shared_in(&folder), &binaries.join(target.shared()))?;
    copy_into(folder.join("bin").join(target.program("crumple")), &binaries)?;
    run!("{python} {PIP...} wheel --no-build-isolation --no-deps --no-index --wheel-dir {out} {source}")?;
    match files(out)?.as_slice() {
        [wheel] => Ok(wheel.clone()),
        wheels => bail!("pip wrote {} files to {}; it should write one wheel", wheels.len(), out.display()),
    }
}

/// A Python with pinned packages, in an environment below the target directory that is kept while the pins are the same.
pub fn environment(tool: Tool, name: &str, requirements: &str) -> Result<PathBuf> {
    let environment = in_target(name);
    let python = if cfg!(windows) { environment.join("Scripts/python.exe") } else { environment.join("bin/python") };
    let (wanted, installed) = (read(requirements)?, environment.join("installed.txt"));
    if read(&installed).is_ok_and(|have| have == wanted) && silent!("{python} --version").is_ok() {
        return Ok(python);
    }
    tools::require(&[tool]).with_context(|| format!("{requirements} needs Python"))?;
    println!("installing into {}: {}", environment.display(), wanted.split_whitespace().collect::<Vec<_>>().join(" "));
    empty(&environment)?;
    let base = if tool == PYTHON3 { "python3" } else { "python3.11" };
    run!("{base} -m venv {environment}")?;
    run!("{python} {PIP...} install --only-binary :all: -r {requirements}").with_context(|| {
        let line = format!("{base} -m pip install -r {requirements}");
        LeftOut::Missing(format!("packages of Python cannot be had; to see why: {line}"))
    })?;
    write(&installed, wanted)?;
    Ok(python)
}
