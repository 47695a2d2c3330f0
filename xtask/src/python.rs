//! Python: generates the declarations from the header, and builds and tests the package as a wheel in environments below the
//! target directory.

mod write;

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use clap::Args;
use xshell::cmd;

use crate::declarations;
use crate::install;
use crate::package;
use crate::stage::Outcome;
use crate::tools::{self, Tool};
use crate::workspace::{Workspace, empty_directory, files, jobs};

pub const DECLARATIONS: &str = "bindings/python/src/crumple/_native.py";

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

/// The text of `DECLARATIONS`.
pub fn declarations(header: &str) -> Result<String> {
    let items = declarations::header(header).context("reading the headers")?;
    write::module(&items)
}

/// `cargo xtask wheel`: the wheel for this system, with the release library and command.
pub fn run(workspace: &Workspace, options: &Options) -> Result<()> {
    let wheel = build(workspace, true, &workspace.path(&options.out))?;
    println!("{} ({:.1} MB)", wheel.display(), fs::metadata(&wheel)?.len() as f64 / 1e6);
    Ok(())
}

/// The wheel, in an emptied folder: of the library and command that users get, or of those that tests have.
pub fn build(workspace: &Workspace, handed_out: bool, out: &Path) -> Result<PathBuf> {
    let folder = package::full(workspace, handed_out)?;
    wheel(workspace, &tested_environment(workspace)?, &folder, out)
}

/// Builds the wheel, installs it beside the packages that its tests need and nothing else, and runs the tests.
pub fn stage(workspace: &Workspace) -> Result<Outcome> {
    if cfg!(not(target_os = "linux")) {
        return Ok(Outcome::NotApplicable("the wheel was built and tried on Linux only".into()));
    }
    let python = match tested_environment(workspace) {
        Ok(python) => python,
        Err(error) => {
            let line = format!("python3.11 -m pip install -r {REQUIREMENTS}");
            return Ok(Outcome::LeftOut(format!(
                "the packages of the Python tests cannot be had; to see why: {line} ({error})"
            )));
        }
    };
    let wheel = build(workspace, false, &workspace.target.join("python/dist"))?;
    let sh = &workspace.shell;
    cmd!(sh, "{python} {PIP...} install --no-index --no-deps --force-reinstall {wheel}").quiet().run()?;
    let tests = workspace.path(PACKAGE).join("tests");
    // Simulations take one thread each.
    let jobs = jobs().to_string();
    let _no_cache = [sh.push_env("PYTHONDONTWRITEBYTECODE", "1"), sh.push_env("MPLBACKEND", "agg")];
    cmd!(sh, "{python} -m pytest --quiet -p no:cacheprovider -n {jobs} --durations 5 {tests}").quiet().run()?;
    Ok(Outcome::Passed)
}

/// The Python with what the package's tests need.
pub fn tested_environment(workspace: &Workspace) -> Result<PathBuf> {
    environment(workspace, Tool::Python311, "python-venv", REQUIREMENTS)
}

/// Builds the wheel from the package's folder and the library and command of `folder`, which is laid out like an archive.
fn wheel(workspace: &Workspace, python: &Path, folder: &Path, out: &Path) -> Result<PathBuf> {
    let sh = &workspace.shell;
    let source = workspace.target.join("python/source");
    empty_directory(&source)?;
    empty_directory(out)?;
    let package = workspace.path(PACKAGE);
    for part in SOURCES {
        let part = package.join(part);
        let within = if part.is_dir() { files(&part)? } else { vec![part] };
        for file in within.iter().filter(|file| !file.to_string_lossy().contains("__pycache__")) {
            let to = source.join(file.strip_prefix(&package)?);
            install::copy(file, to.parent().context("the file is in a folder")?)?;
        }
    }
    for license in LICENSES {
        install::copy(&folder.join(license), &source)?;
    }
    let binaries = source.join("src/crumple/_bin");
    let target = crate::target::Target::host(workspace)?;
    install::copy_as(&install::shared(&target, folder), &binaries, target.shared())?;
    let command = target.program("crumple");
    install::copy_as(&folder.join("bin").join(&command), &binaries, &command)?;
    let build = ["wheel", "--no-build-isolation", "--no-deps", "--no-index", "--wheel-dir"];
    cmd!(sh, "{python} {PIP...} {build...} {out} {source}").quiet().run()?;
    let wheels = files(out)?;
    match wheels.as_slice() {
        [wheel] => Ok(wheel.clone()),
        _ => bail!("pip wrote {} files to {}; it should write one wheel", wheels.len(), out.display()),
    }
}

/// A Python with pinned packages, in an environment below the target directory that is kept while the pins are the same.
pub fn environment(workspace: &Workspace, tool: Tool, name: &str, requirements: &str) -> Result<PathBuf> {
    let sh = &workspace.shell;
    let environment = workspace.target.join(name);
    let python = if cfg!(windows) { environment.join("Scripts/python.exe") } else { environment.join("bin/python") };
    let path = workspace.path(requirements);
    let wanted = fs::read_to_string(&path).with_context(|| format!("reading {requirements}"))?;
    let installed = environment.join("installed.txt");
    let works = |python: &Path| cmd!(sh, "{python} --version").quiet().ignore_stdout().ignore_stderr().run().is_ok();
    if fs::read_to_string(&installed).is_ok_and(|have| have == wanted) && works(&python) {
        return Ok(python);
    }
    let missing = tools::provide(workspace, &BTreeSet::from([tool]))?;
    ensure!(missing.is_empty(), "{requirements} needs Python. {}", tools::advice(&missing));
    println!("installing into {}: {}", environment.display(), wanted.split_whitespace().collect::<Vec<_>>().join(" "));
    empty_directory(&environment)?;
    let base = if tool == Tool::Python311 { "python3.11" } else { "python3" };
    cmd!(sh, "{base} -m venv {environment}").quiet().run()?;
    cmd!(sh, "{python} {PIP...} install --only-binary :all: -r {path}").quiet().run()?;
    fs::write(&installed, wanted).context("noting what is installed")?;
    Ok(python)
}
