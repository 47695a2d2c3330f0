//! The repository as the commands see it: its root, its target directory and a shell that stands in its root.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use xshell::{Shell, cmd};

/// What is built for tests, by every stage alike, so that it is built once: Cargo makes another library for each choice of
/// packages and features. The lab is without the engines it compares with: they take longer to build than all the rest.
const TESTED: &[&str] = &[
    "--package",
    "crumple",
    "--package",
    "crumple-lab",
    "--features",
    "crumple/cli,crumple/host-allocator,crumple/wgpu,crumple-lab/gpu",
];

pub struct Workspace {
    pub root: PathBuf,
    /// Cargo's target directory, which `CARGO_TARGET_DIR` may have moved.
    pub target: PathBuf,
    /// Version of the `crumple` package, the same for every member.
    pub version: String,
    pub shell: Shell,
}

impl Workspace {
    pub fn open() -> Result<Self> {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"))
            .parent()
            .context("xtask has no parent directory; run it from the repository it was built in")?
            .to_path_buf();
        let shell = Shell::new()?;
        shell.change_dir(&root);
        let target = match std::env::var_os("CARGO_TARGET_DIR") {
            Some(dir) => root.join(dir),
            None => root.join("target"),
        };
        Ok(Self { root, target, version: env!("CARGO_PKG_VERSION").to_owned(), shell })
    }

    /// `cargo`, which rustup keeps to the toolchain that runs this program.
    pub fn cargo(&self, arguments: &[&str]) -> xshell::Cmd<'_> {
        cmd!(self.shell, "cargo {arguments...}")
    }

    /// `cargo build` of what `arguments` choose of the Rust code, as the tests have it. A test is built along with it: without one
    /// Cargo leaves out the features that tests ask of dependencies, and builds everything again for the next test.
    pub fn build_as_tested(&self, arguments: &[&str]) -> xshell::Cmd<'_> {
        self.cargo(&["build"]).args(TESTED).args(arguments).args(["--test", "paper_equations"])
    }

    /// `cargo test` of the Rust code, or of what `arguments` choose of it.
    pub fn tests(&self, arguments: &[&str]) -> xshell::Cmd<'_> {
        self.cargo(&["test"]).args(TESTED).args(arguments)
    }

    /// `path` as seen from the repository's root: absolute, or joined to the root.
    pub fn path(&self, path: impl AsRef<Path>) -> PathBuf {
        self.root.join(path)
    }
}

/// Removes `directory` if it is there and makes it anew, empty.
pub fn empty_directory(directory: &Path) -> Result<()> {
    if directory.exists() {
        std::fs::remove_dir_all(directory).with_context(|| format!("removing {}", directory.display()))?;
    }
    std::fs::create_dir_all(directory).with_context(|| format!("creating {}", directory.display()))
}
