//! Checks of threads and memory: those that need Rust's nightly toolchain with the source of the standard library (ThreadSanitizer,
//! MemorySanitizer and Miri), and tests with the locks of shuttle, which runs threads in orders of its own choice.

use std::path::Path;

use anyhow::{Context, Result};
use xshell::Cmd;

use crate::files::empty;
use crate::stage::LeftOut;
use crate::workspace::{cmd, in_root, in_target, root, run, rustc_says, said, sh};

/// Without file formats, which share nothing between threads.
const FEATURES: [&str; 3] = ["--no-default-features", "--features", "capi"];

/// The tests in which threads share something: the task systems, inboxes, and everything that several threads do in the C interface.
const THREADED: [&str; 3] = ["base::tasks", "capi::tests::eight_threads", "instance::schedules"];

/// The modules that Miri interprets within some minutes. Most others build sets or load files, which takes it hours.
const INTERPRETED: [&str; 3] = ["base::", "capi::boundary", "capi::tests::memory"];

/// C programs and their arguments. Those that need C++, Vulkan or another library are left out: what uninstrumented libraries write
/// would be reported.
const C_PROGRAMS: &str = "allocator, bad_input, bodies, files FIXTURES ., memory, threads";

/// What installs the toolchain.
const INSTALL: &str = "rustup toolchain install nightly --component rust-src,miri";

/// An error unless the toolchain has what all need; rustup is asked for it first.
fn available() -> Result<()> {
    let quiet = |command: Cmd| command.quiet().ignore_stderr().ignore_stdout().run();
    quiet(cmd!("rustup component add --toolchain nightly rust-src miri"))
        .and_then(|()| quiet(cmd!("rustup run nightly cargo miri --version")))
        .context(LeftOut::NotApplicable(format!("there is no nightly toolchain with the library's source: {INSTALL}")))
}

/// Runs the tests of threads under ThreadSanitizer.
pub fn threads() -> Result<()> {
    sanitized("thread", &[&["--"][..], &THREADED].concat())
}

pub fn build() -> Result<()> {
    sanitized("thread", &["--no-run"])
}

/// Runs the unit tests and C programs under MemorySanitizer, which finds reads of memory that nobody wrote.
pub fn memory() -> Result<()> {
    sanitized("memory", &["--"])?;
    let (host, home) = (rustc_says("host")?, in_target("sanitizers/memory"));
    let library =
        ["--package", "crumple", "--lib", "--crate-type", "staticlib", "--target", &host, "--no-default-features"];
    let cargo = cmd!("rustup run nightly cargo rustc -Zbuild-std {library...} --features capi,gltf,obj,host-allocator");
    cargo.arg("--target-dir").arg(&home).env("RUSTFLAGS", flags("memory")).run()?;
    let sysroot = said!("rustup run nightly rustc --print sysroot")?;
    let runtime = Path::new(&sysroot).join("lib/rustlib").join(&host).join("lib/librustc-nightly_rt.msan.a");
    let library = home.join(&host).join("debug/libcrumple.a");
    let (root, programs) = (root(), empty(home.join("c"))?);
    let _there = sh().push_dir(&programs);
    for program in C_PROGRAMS.split(", ") {
        let program = program.replace("FIXTURES", &in_root("tests/fixtures").to_string_lossy());
        let mut words = program.split(' ');
        let name = words.next().unwrap_or_default();
        let c = ["-std=c99", "-O1", "-g", "-fsanitize=memory", "-fno-sanitize-memory-param-retval"];
        run!("clang {c...} -D_POSIX_C_SOURCE=200809L -I {root}/include -c {root}/tests/c/{name}.c")?;
        // Rust's runtime, because clang's may be older than the compiler of the library.
        let rest = ["-Wl,--no-whole-archive", "-Wl,--export-dynamic", "-lm", "-lpthread", "-ldl", "-lrt", "-o", name];
        run!("clang {name}.o {library} -Wl,--whole-archive {runtime} {rest...}")?;
        cmd!("./{name}").args(words).run()?;
    }
    Ok(())
}

/// `cargo test` of the unit tests under a sanitizer, with a standard library that is instrumented too.
fn sanitized(sanitizer: &str, what: &[&str]) -> Result<()> {
    available()?;
    let (host, home) = (rustc_says("host")?, in_target("sanitizers").join(sanitizer));
    let arguments = ["-Zbuild-std", "--package", "crumple", "--lib", "--target", &host];
    // The tests take seconds, and optimising them takes a minute.
    let fast = ["--config", "profile.dev.package.crumple.opt-level=0", "--config", "profile.dev.opt-level=0"];
    let test =
        cmd!("rustup run nightly cargo {fast...} test {arguments...} {FEATURES...} --target-dir {home} {what...}");
    Ok(test.env("RUSTFLAGS", flags(sanitizer)).env("TSAN_OPTIONS", "halt_on_error=1").run()?)
}

fn flags(sanitizer: &str) -> String {
    // C compilers and Rust do not agree on which arguments are checked by the caller. So none are.
    let eager = if sanitizer == "memory" { " -Cllvm-args=-msan-eager-checks=0" } else { "" };
    format!("-Zsanitizer={sanitizer}{eager}")
}

/// Runs unit tests in Miri, which finds undefined behaviour that no processor shows.
pub fn miri() -> Result<()> {
    available()?;
    let (home, what) = (in_target("miri"), ["--package", "crumple", "--lib"]);
    let test =
        cmd!("rustup run nightly cargo miri test {what...} --target-dir {home} {FEATURES...} -- {INTERPRETED...}");
    // rayon keeps memory in the ends of its threads, and its pointers follow the rules of tree borrows only.
    let flags = "-Zmiri-disable-isolation -Zmiri-tree-borrows -Zmiri-ignore-leaks";
    Ok(test.env("MIRIFLAGS", flags).env("PROPTEST_CASES", "4").run()?)
}

/// `cargo xtask schedules`: tests of threads with the locks of shuttle.
pub fn schedules() -> Result<()> {
    // A folder of its own: the flag builds everything again.
    let (home, what) = (in_target("schedules"), ["--package", "crumple", "--lib", "--no-default-features"]);
    let test = cmd!("cargo test {what...} --target-dir {home} -- instance::schedules");
    Ok(test.env("RUSTFLAGS", "--cfg shuttle").run()?)
}
