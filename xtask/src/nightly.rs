//! Checks that need Rust's nightly toolchain with the source of the standard library: ThreadSanitizer, MemorySanitizer and Miri.

use anyhow::{Result, ensure};
use xshell::cmd;

use crate::stage::Outcome;
use crate::workspace::Workspace;

/// Without devices and file formats, which share nothing between threads.
const FEATURES: [&str; 3] = ["--no-default-features", "--features", "capi"];

/// The tests in which threads share something: the task systems, inboxes, and everything that several threads do in the C interface.
const THREADED: [&str; 4] = ["base::tasks", "capi::thread_tests", "capi::recording_tests", "instance::schedules"];

/// The modules that Miri interprets within some minutes. Most others build sets or load files, which takes it hours.
const INTERPRETED: [&str; 5] = ["base::", "capi::boundary", "capi::check", "capi::deform", "capi::ids"];

/// Makes 65,535 ids.
const TOO_LONG: [&str; 2] = ["--skip", "a_slot_is_retired"];

/// What installs it.
const INSTALL: &str = "rustup toolchain install nightly --component rust-src,miri";

/// Whether the toolchain has what both need; rustup is asked for it first.
fn available(workspace: &Workspace) -> bool {
    let sh = &workspace.shell;
    let quiet = |command: xshell::Cmd<'_>| command.quiet().ignore_stderr().ignore_stdout().run().is_ok();
    quiet(cmd!(sh, "rustup component add --toolchain nightly rust-src miri"))
        && quiet(cmd!(sh, "rustup run nightly cargo miri --version"))
}

/// Runs the tests of threads under ThreadSanitizer, with a standard library that is instrumented too.
pub fn threads(workspace: &Workspace) -> Result<Outcome> {
    if !available(workspace) {
        return Ok(Outcome::NotApplicable(format!(
            "there is no nightly toolchain with the library's source: {INSTALL}"
        )));
    }
    sanitized(workspace, "thread", &THREADED)?;
    Ok(Outcome::Passed)
}

/// Runs the unit tests under MemorySanitizer, which finds reads of memory that nobody wrote.
pub fn memory(workspace: &Workspace) -> Result<()> {
    ensure!(available(workspace), "MemorySanitizer is not there: {INSTALL}");
    sanitized(workspace, "memory", &[])
}

/// Runs unit tests under a sanitizer, with a standard library that is instrumented too.
fn sanitized(workspace: &Workspace, sanitizer: &str, tests: &[&str]) -> Result<()> {
    let (host, home) = (workspace.rustc("host")?, workspace.target.join("sanitizers").join(sanitizer));
    let arguments = ["-Zbuild-std", "--package", "crumple", "--lib", "--target", &host];
    cmd!(
        workspace.shell,
        "rustup run nightly cargo test {arguments...} {FEATURES...} --target-dir {home} -- {tests...}"
    )
    .env("RUSTFLAGS", format!("-Zsanitizer={sanitizer}"))
    .env("TSAN_OPTIONS", "halt_on_error=1")
    .run()?;
    Ok(())
}

/// Runs unit tests in Miri, which finds undefined behaviour that no processor shows.
pub fn miri(workspace: &Workspace) -> Result<()> {
    ensure!(available(workspace), "Miri is not there: {INSTALL}");
    let home = workspace.target.join("miri");
    let arguments = ["--package", "crumple", "--lib", "--target-dir"];
    cmd!(
        workspace.shell,
        "rustup run nightly cargo miri test {arguments...} {home} {FEATURES...} -- {INTERPRETED...} {TOO_LONG...}"
    )
    // rayon keeps memory in the ends of its threads, and its pointers follow the rules of tree borrows only.
    .env("MIRIFLAGS", "-Zmiri-disable-isolation -Zmiri-tree-borrows -Zmiri-ignore-leaks")
    .env("PROPTEST_CASES", "4")
    .run()?;
    Ok(())
}
