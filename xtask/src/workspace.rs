//! The repository: its root, in which everything runs, its target directory, and the ways to call Cargo and other programs.

use std::ffi::OsString;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Context, Result, ensure};
use serde_json::Value;
use xshell::{Cmd, PushEnv, Shell};

/// Version of the `crumple` package, the same for every member.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");
/// The packages and features of every test build with `--all`. Cargo builds another library for each other choice.
const ALL_TESTED: &str = "--package crumple --package crumple-lab --features \
                          crumple/cli,crumple/host-allocator,crumple/wgpu,crumple-lab/engines,crumple-lab/gpu";
/// Without `--all`.
const TESTED: &str = "--package crumple --features crumple/cli,crumple/host-allocator";

/// Whether this run tests everything: also wgpu, the lab, a second graphics driver and the engines' plugins. Otherwise it tests
/// what everybody can test within minutes.
static ALL: AtomicBool = AtomicBool::new(true);

pub fn all() -> bool {
    ALL.load(Ordering::Relaxed)
}

pub fn test_all(all: bool) {
    ALL.store(all, Ordering::Relaxed);
}

/// The repository's root. Relative paths are relative to it, once [`enter`] was called.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("xtask is a folder of the repository")
}

pub fn enter() -> Result<()> {
    std::env::set_current_dir(root()).context("xtask works in the repository that it was built in")
}

/// A path in the repository as an absolute one.
pub fn in_root(path: impl AsRef<Path>) -> PathBuf {
    root().join(path)
}

/// A path of the user. What runs is in the repository's root.
pub fn absolute(path: &str) -> std::io::Result<PathBuf> {
    std::path::absolute(path)
}

/// Cargo's target directory; `CARGO_TARGET_DIR` may set it.
pub fn target_folder() -> PathBuf {
    root().join(std::env::var_os("CARGO_TARGET_DIR").unwrap_or_else(|| "target".into()))
}

pub fn in_target(path: impl AsRef<Path>) -> PathBuf {
    target_folder().join(path)
}

/// The shell of this thread.
pub fn sh() -> &'static Shell {
    thread_local! { static SHELL: &'static Shell = Box::leak(Box::new(Shell::new().expect("a current folder"))); }
    SHELL.with(|shell| *shell)
}

/// A command of [`sh`]. The others run it without printing it: `silent` drops what it prints, `said` returns that.
macro_rules! cmd {
    ($command:literal) => {
        xshell::cmd!($crate::workspace::sh(), $command)
    };
}
macro_rules! run {
    ($command:literal) => {
        $crate::workspace::cmd!($command).quiet().run().map_err(anyhow::Error::from)
    };
}
macro_rules! silent {
    ($command:literal) => {
        $crate::workspace::cmd!($command).quiet().ignore_stdout().run().map_err(anyhow::Error::from)
    };
}
macro_rules! said {
    ($command:literal) => {
        $crate::workspace::cmd!($command).quiet().read().map_err(anyhow::Error::from)
    };
}
pub(crate) use {cmd, run, said, silent};

/// `cargo` of the toolchain that runs this program.
pub fn cargo(arguments: &[&str]) -> Cmd<'static> {
    cmd!("cargo {arguments...}")
}

/// `cargo` for release builds: the binaries contain no path of this machine.
pub fn cargo_anywhere(arguments: &[&str]) -> Result<Cmd<'static>> {
    Ok(cargo(arguments).env(FLAGS, anywhere()?))
}

/// The variable by which Cargo is told flags for the compiler.
pub const FLAGS: &str = "CARGO_ENCODED_RUSTFLAGS";

/// The flags of such a build for the compiler, as [`FLAGS`] has them.
pub fn anywhere() -> Result<String> {
    let from = |path: PathBuf, to: &str| format!("--remap-path-prefix={}={to}", path.display());
    let mut flags = vec![
        from(root().to_owned(), "/crumple"),
        from(sysroot()?.join("lib/rustlib/src/rust"), "/rustc"),
        from(cargo_home()?, "/cargo"),
    ];
    // The last remapping that fits counts. Each registry has a folder, since this program's packages came from one; vendored ones have
    // none.
    for registry in std::fs::read_dir(cargo_home()?.join("registry/src")).into_iter().flatten() {
        flags.push(from(registry?.path(), SOURCES));
    }
    let given = std::env::var("RUSTFLAGS").unwrap_or_default();
    Ok(given.split_whitespace().map(str::to_owned).chain(flags).collect::<Vec<_>>().join("\u{1f}"))
}

pub fn sysroot() -> Result<PathBuf> {
    let rustc = rustc();
    Ok(said!("{rustc} --print sysroot")?.into())
}

/// The value of `key` in the output of `rustc -vV`.
pub fn rustc_says(key: &str) -> Result<String> {
    let rustc = rustc();
    let version = said!("{rustc} -vV")?;
    let line = version.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix(": "));
    line.map(str::to_owned).with_context(|| format!("rustc -vV says no {key}"))
}

/// The packages in what `cargo metadata` says with these arguments.
pub fn packages(arguments: &[&str]) -> Result<Vec<Value>> {
    let told = said!("cargo metadata --format-version 1 {arguments...}")?;
    let mut told: Value = serde_json::from_str(&told).context("reading what cargo metadata says")?;
    Ok(serde_json::from_value(told["packages"].take())?)
}

pub fn git(arguments: &[&str]) -> Result<String> {
    // Another user may own the checkout.
    let trusted = "safe.directory=*";
    said!("git -c {trusted} {arguments...}").context("this needs a git checkout: it takes what git tracks")
}

/// `cargo build` with the features of the tests; `arguments` choose what to build. A test is built along: without one Cargo leaves
/// out the features that dev-dependencies enable, and the next test would build everything again.
pub fn build_as_tested(arguments: &[&str]) -> Cmd<'static> {
    let tested = if all() { ALL_TESTED } else { TESTED }.split(' ');
    cmd!("cargo build {tested...} {arguments...} --test widths")
}

/// `cargo test` of the Rust code, or of the part that `arguments` choose. A test program that fails does not hide the others.
pub fn tests(arguments: &[&str]) -> Cmd<'static> {
    let tested = if all() { ALL_TESTED } else { TESTED }.split(' ');
    cmd!("cargo test --no-fail-fast {tested...} {arguments...}")
}

/// The compiler that Cargo calls.
pub fn rustc() -> OsString {
    std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into())
}

/// The name that `cargo_anywhere` gives to the folder with the sources of dependencies.
pub const SOURCES: &str = "/cargo/registry";

pub fn cargo_home() -> Result<PathBuf> {
    let own = std::env::var_os("CARGO_HOME").map(PathBuf::from);
    let home = || std::env::home_dir().map(|home| home.join(".cargo"));
    own.or_else(home).context("there is neither CARGO_HOME nor a home directory")
}

/// A process that ends when this is dropped.
pub struct Background(pub Child);

impl Drop for Background {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A display without a screen, which programs draw on while it lives.
pub struct Display(#[expect(dead_code)] PushEnv<'static>, #[expect(dead_code)] Background);

impl Display {
    pub fn start() -> Result<Self> {
        let mut server = Command::new("Xvfb");
        let server = server.args(["-displayfd", "1", "-nolisten", "tcp"]).stdin(Stdio::null()).stderr(Stdio::null());
        let mut server = server.stdout(Stdio::piped()).spawn().context("starting Xvfb")?;
        let mut number = String::new();
        BufReader::new(server.stdout.take().context("Xvfb has an output")?).read_line(&mut number)?;
        Ok(Self(sh().push_env("DISPLAY", format!(":{}", number.trim())), Background(server)))
    }
}

/// Runs a program to its end. Returns how it ended, and what it printed.
pub fn ended(command: Cmd) -> Result<(ExitStatus, String)> {
    let output = command.ignore_status().output()?;
    let text = [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
    Ok((output.status, text.concat()))
}

pub fn jobs() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// Runs named commands, `jobs` at a time. One that fails ends none of the others.
pub fn side_by_side(jobs: usize, mut commands: Vec<(String, Command)>) -> Result<()> {
    let mut failed = Vec::new();
    for some in commands.chunks_mut(jobs.max(1)) {
        let start = |(name, command): &mut (String, Command)| {
            Ok((name.clone(), command.spawn().with_context(|| format!("starting {name}"))?))
        };
        for (name, mut child) in some.iter_mut().map(start).collect::<Result<Vec<_>>>()? {
            let ended = child.wait()?;
            failed.extend((!ended.success()).then(|| format!("{name} ends with {ended}")));
        }
    }
    ensure!(failed.is_empty(), "{}", failed.join("; "));
    Ok(())
}
