//! The repository: its root, its target directory, a shell in its root, and the ways to call Cargo.

use std::cell::{Cell, RefCell};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Child, Command};

use anyhow::{Context, Result, ensure};
use serde_json::Value;
use xshell::{Shell, cmd};

use crate::files::{copy, copy_into};

/// The packages and features of every test build with `--all`. Cargo builds another library for each other choice.
const ALL_TESTED: &str = "--package crumple --package crumple-lab --features \
                          crumple/cli,crumple/host-allocator,crumple/wgpu,crumple-lab/engines,crumple-lab/gpu";
/// Without `--all`.
const TESTED: &str = "--package crumple --features crumple/cli,crumple/host-allocator";

pub struct Workspace {
    pub root: PathBuf,
    /// Cargo's target directory; `CARGO_TARGET_DIR` may set it.
    pub target: PathBuf,
    /// Version of the `crumple` package, the same for every member.
    pub version: String,
    pub shell: Shell,
    /// Whether this run tests everything: also wgpu, the lab, a second graphics driver and the engines' plugins. Otherwise it tests
    /// what everybody can test within minutes.
    pub all: bool,
    /// Whether this run has installed the release library already.
    pub installed: Cell<bool>,
    /// Why the stage that runs leaves out a part, once it has left one out.
    pub left_out: RefCell<Option<String>>,
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
        let version = env!("CARGO_PKG_VERSION").to_owned();
        Ok(Self { root, target, version, shell, all: true, installed: Cell::new(false), left_out: RefCell::default() })
    }

    /// `cargo` of the toolchain that runs this program.
    pub fn cargo(&self, arguments: &[&str]) -> xshell::Cmd<'_> {
        cmd!(self.shell, "cargo {arguments...}")
    }

    /// `cargo` for release builds: the binaries contain no path of this machine.
    pub fn cargo_anywhere(&self, arguments: &[&str]) -> Result<xshell::Cmd<'_>> {
        Ok(self.cargo(arguments).env("CARGO_ENCODED_RUSTFLAGS", self.anywhere()?.join("\u{1f}")))
    }

    /// The flags of such a build for the compiler.
    pub fn anywhere(&self) -> Result<Vec<String>> {
        let from = |path: PathBuf, to: &str| format!("--remap-path-prefix={}={to}", path.display());
        let mut flags = vec![
            from(self.root.clone(), "/crumple"),
            from(self.sysroot()?.join("lib/rustlib/src/rust"), "/rustc"),
            from(cargo_home()?, "/cargo"),
        ];
        // The last remapping that fits counts. Each registry has a folder, since this program's packages came from one; vendored ones have
        // none.
        for registry in std::fs::read_dir(cargo_home()?.join("registry/src")).into_iter().flatten() {
            flags.push(from(registry?.path(), SOURCES));
        }
        flags.splice(0..0, std::env::var("RUSTFLAGS").iter().flat_map(|f| f.split_whitespace().map(str::to_owned)));
        Ok(flags)
    }

    /// The toolchain's directory.
    pub fn sysroot(&self) -> Result<PathBuf> {
        let rustc = rustc();
        Ok(cmd!(self.shell, "{rustc} --print sysroot").quiet().read()?.into())
    }

    /// The value of `key` in the output of `rustc -vV`.
    pub fn rustc(&self, key: &str) -> Result<String> {
        let rustc = rustc();
        let version = cmd!(self.shell, "{rustc} -vV").quiet().read()?;
        let line = version.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix(": "));
        line.map(str::to_owned).with_context(|| format!("rustc -vV says no {key}"))
    }

    /// The packages in what `cargo metadata` says with these arguments.
    pub fn packages(&self, arguments: &[&str]) -> Result<Vec<Value>> {
        let told = self.cargo(&["metadata", "--format-version", "1"]).args(arguments).quiet().read()?;
        let mut told: Value = serde_json::from_str(&told).context("reading what cargo metadata says")?;
        Ok(serde_json::from_value(told["packages"].take())?)
    }

    /// The output of git.
    pub fn git(&self, arguments: &[&str]) -> Result<String> {
        // Another user may own the checkout.
        let trusted = "safe.directory=*";
        let printed = cmd!(self.shell, "git -c {trusted} {arguments...}").quiet().read();
        printed.context("this needs a git checkout: it takes what git tracks")
    }

    /// Copies those files of `parts` of a folder into another that git does not ignore.
    pub fn copy_sources(&self, folder: &str, parts: &[&str], to: &Path) -> Result<()> {
        let list = ["-C", folder, "ls-files", "--cached", "--others", "--exclude-standard", "--"];
        let listed = self.git(&[&list[..], parts].concat())?;
        listed.lines().try_for_each(|name| copy(&self.path(folder).join(name), &to.join(name)))
    }

    pub fn copy_licenses(&self, to: &Path) -> Result<()> {
        ["LICENSE-MIT", "LICENSE-APACHE"].iter().try_for_each(|license| copy_into(&self.path(license), to))
    }

    /// The stage that runs passes in part.
    pub fn leave_out(&self, why: String) {
        self.left_out.replace(Some(why));
    }

    /// The packages and features of this run's test builds.
    fn tested(&self) -> impl Iterator<Item = &'static str> {
        if self.all { ALL_TESTED } else { TESTED }.split(' ')
    }

    /// `cargo build` with the features of the tests; `arguments` choose what to build. A test is built along: without one Cargo leaves
    /// out the features that dev-dependencies enable, and the next test would build everything again.
    pub fn build_as_tested(&self, arguments: &[&str]) -> xshell::Cmd<'_> {
        self.cargo(&["build"]).args(self.tested()).args(arguments).args(["--test", "paper_equations"])
    }

    /// `cargo test` of the Rust code, or of the part that `arguments` choose. A test program that fails does not hide the others.
    pub fn tests(&self, arguments: &[&str]) -> xshell::Cmd<'_> {
        self.cargo(&["test", "--no-fail-fast"]).args(self.tested()).args(arguments)
    }

    /// `path`, resolved against the repository's root.
    pub fn path(&self, path: impl AsRef<Path>) -> PathBuf {
        self.root.join(path)
    }
}

/// The compiler that Cargo calls.
pub fn rustc() -> OsString {
    std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into())
}

/// The name that `cargo_anywhere` gives to the folder with the sources of dependencies.
pub const SOURCES: &str = "/cargo/registry";

pub fn cargo_home() -> Result<PathBuf> {
    if let Some(home) = std::env::var_os("CARGO_HOME") {
        return Ok(home.into());
    }
    let home = std::env::home_dir().context("there is neither CARGO_HOME nor a home directory")?;
    Ok(home.join(".cargo"))
}

/// A process that ends when this is dropped.
pub struct Background(pub Child);

impl Drop for Background {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// The number of cores.
pub fn jobs() -> usize {
    std::thread::available_parallelism().map_or(2, usize::from)
}

/// Runs named commands, `jobs` at a time. One that fails ends none of the others.
pub fn side_by_side(jobs: usize, mut commands: Vec<(String, Command)>) -> Result<()> {
    let mut failed = Vec::new();
    for some in commands.chunks_mut(jobs.max(1)) {
        let running = some.iter_mut().map(|(name, command)| {
            let started = command.spawn().with_context(|| format!("starting {name}"))?;
            Ok((&*name, started))
        });
        for (name, mut child) in running.collect::<Result<Vec<_>>>()? {
            let ended = child.wait()?;
            if !ended.success() {
                failed.push(format!("{name} ends with {ended}"));
            }
        }
    }
    ensure!(failed.is_empty(), "{}", failed.join("; "));
    Ok(())
}
