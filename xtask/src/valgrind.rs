//! Runs the tests under valgrind, which must find no error and no leak.

use std::path::PathBuf;

use anyhow::{Result, ensure};

use crate::files::{empty, files, read};
use crate::native::{self, Build};
use crate::target::Target;
use crate::workspace::{in_root, in_target, side_by_side, tests};
use crate::{install, vulkan};

/// Rooms of src that have unsafe code, and use no driver. src/lib.rs denies it to the others.
const UNSAFE: &[&str] = &["base::", "deform::", "capi::"];
/// Rust test programs that reach this code from other rooms. Of these only the tests named `quick_…` run: the others make thousands of
/// hits and would take hours. Those of the promises build a set in every case, which takes half an hour there, and call nothing else.
const IN_PART: &[&str] = &["--test=contacts", "--test=oracle_rules"];

/// C programs that do not run under valgrind. A driver takes a minute there to compile the kernels, and the programs that remain make
/// every call to it. Others build sets very often, or differ by how they are linked.
const SLOW: &str = "^(vulkan_faults_|(refusals|allocator_static)$)";

pub fn c() -> Result<()> {
    let (run, prefix) = (Run::new("c", "definite,possible")?, install::release_prefix()?);
    run.judge(native::test_projects(&Build {
        // Stage "sanitizers" checks the programs of users and plugins: their calls are among those of the tests.
        projects: native::TESTS,
        validation: false,
        launcher: run.command.join(";"),
        drivers: vulkan::one_driver()?,
        left_out: SLOW,
        ..Build::new("release", &prefix)
    }))
}

pub fn rust() -> Result<()> {
    // Rust's own test runner keeps pointers into the middle of blocks, which valgrind calls "possibly lost".
    let run = Run::new("rust", "definite")?;
    let runner = Target::host()?.variable("RUNNER");
    let under = |programs: &[&str], names: &[&str]| {
        let cargo = tests(programs).env(&runner, run.command.join(" ")).env("PROPTEST_CASES", "2");
        (programs.join(" "), cargo.args(["--"]).args(names).into())
    };
    tests(&["--lib"]).args(IN_PART).arg("--no-run").run()?;
    // Valgrind runs the threads of a program on one core.
    run.judge(side_by_side(2, vec![under(&["--lib"], UNSAFE), under(IN_PART, &["quick_"])]))
}

/// A run of many programs, each with a log.
struct Run {
    logs: PathBuf,
    command: Vec<String>,
}

impl Run {
    /// `leaks`: the kinds of leaks that fail a program.
    fn new(name: &str, leaks: &str) -> Result<Self> {
        let logs = empty(in_target("valgrind").join(name))?;
        let (log, known) = (logs.join("%p.log"), in_root("tests/c/valgrind.supp"));
        let (log, known) = (format!("--log-file={}", log.display()), format!("--suppressions={}", known.display()));
        let leaks = format!("--errors-for-leak-kinds={leaks}");
        let command = ["valgrind", "--error-exitcode=99", "--leak-check=full", &leaks, &known, &log];
        Ok(Self { logs, command: command.map(str::to_owned).to_vec() })
    }

    /// Prints the logs with findings. Without any log the programs did not run under valgrind, which is an error.
    fn judge(&self, tests: Result<()>) -> Result<()> {
        let mut logs = files(&self.logs)?.iter().map(read).collect::<Result<Vec<_>>>()?;
        // The log of a child that became another program (Blender, node) has no summary.
        logs.retain(|log| log.contains("ERROR SUMMARY: "));
        let programs = logs.len();
        logs.retain(|log| !log.contains("ERROR SUMMARY: 0 errors"));
        logs.iter().for_each(|log| println!("{log}"));
        ensure!(logs.is_empty(), "valgrind finds something in {} of {programs} programs", logs.len());
        tests?;
        ensure!(programs > 0, "no program ran under valgrind");
        println!("valgrind finds nothing in {programs} programs");
        Ok(())
    }
}
