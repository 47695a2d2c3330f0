//! Runs the tests under valgrind, which must find no error and no leak.

use std::fs;
use std::path::PathBuf;
use std::process::{Child, Command, ExitStatus};

use anyhow::{Result, anyhow, bail, ensure};

use crate::native::{self, Build};
use crate::stage::Outcome;
use crate::workspace::{Workspace, empty_directory};

/// Rust test programs that run whole under valgrind.
const WHOLE: &[&str] =
    &["--lib", "--test=export_gltf", "--test=import_broken", "--test=import_gltf", "--test=import_obj"];
/// Rust test programs of which only the tests named `quick_…` run. The others make thousands of hits and would take hours. Those of
/// the promises build a set in every case, which takes half an hour there, and call nothing else.
const IN_PART: &[&str] = &["--test=bad_input", "--test=contacts", "--test=oracle_rules", "--test=paper_equations"];

/// Tests of learning, which take a quarter of an hour there. Nothing that they call is unsafe.
const LEARNING: &[&str] = &["--skip", "predict::tests::"];

/// C programs that do not run under valgrind. A driver takes a minute there to compile the kernels, and the programs that remain make
/// every call to it. The others learn how vertices follow nodes, a large body or very often, which takes minutes there.
const SLOW: &str = "^(vulkan_(device_lost|faults|memory|record|render|times)|(crash|first_crash|job_system|refusals)$)";

pub fn c(workspace: &Workspace) -> Result<Outcome> {
    let run = Run::new(workspace, "c", "definite,possible")?;
    let prefix = native::release_prefix(workspace)?;
    let build = Build {
        // Stage "sanitizers" checks the plugins.
        projects: native::OURS,
        validation: false,
        launcher: &run.command.join(";"),
        drivers: &native::one_driver(workspace)?,
        left_out: SLOW,
        ..Build::new("release", &prefix)
    };
    run.judge(native::test_projects(workspace, &build))
}

pub fn rust(workspace: &Workspace) -> Result<Outcome> {
    // Rust's own test runner keeps pointers into the middle of blocks, which valgrind calls "possibly lost".
    let run = Run::new(workspace, "rust", "definite")?;
    let runner = format!("CARGO_TARGET_{}_RUNNER", workspace.rustc("host")?.to_uppercase().replace('-', "_"));
    let tests = |programs: &[&str], names: &[&str]| -> Command {
        let cargo = workspace.tests(programs).env(&runner, run.command.join(" ")).env("PROPTEST_CASES", "2");
        cargo.args(["--"]).args(names).into()
    };
    workspace.tests(WHOLE).args(IN_PART).arg("--no-run").run()?;
    // Valgrind runs the threads of a program on one core.
    let mut both = [tests(WHOLE, LEARNING), tests(IN_PART, &["quick_"])];
    let started: Vec<Child> = both.iter_mut().map(Command::spawn).collect::<Result<_, _>>()?;
    let ended = started.into_iter().map(|mut child| child.wait()).collect::<Result<Vec<ExitStatus>, _>>()?;
    run.judge(match ended.iter().find(|status| !status.success()) {
        Some(status) => Err(anyhow!("the tests end with {status}")),
        None => Ok(()),
    })
}

/// A run of many programs, each with a log.
struct Run {
    logs: PathBuf,
    command: Vec<String>,
}

impl Run {
    /// `leaks`: the kinds of leaks that fail a program.
    fn new(workspace: &Workspace, name: &str, leaks: &str) -> Result<Self> {
        let logs = workspace.target.join("valgrind").join(name);
        empty_directory(&logs)?;
        let log = format!("--log-file={}", logs.join("%p.log").display());
        let known = format!("--suppressions={}", workspace.path("tests/c/valgrind.supp").display());
        let leaks = format!("--errors-for-leak-kinds={leaks}");
        let command = ["valgrind", "--error-exitcode=99", "--leak-check=full", &leaks, &known, &log];
        let command = command.map(str::to_owned).to_vec();
        Ok(Self { logs, command })
    }

    /// Prints the logs with findings. Without any log the programs did not run under valgrind, which is an error.
    fn judge(&self, tests: Result<()>) -> Result<Outcome> {
        let mut programs = 0;
        let mut with_findings = 0;
        for entry in fs::read_dir(&self.logs)? {
            let log = fs::read_to_string(entry?.path())?;
            // The log of a child that became another program (Blender, node) has no summary.
            let Some(summary) = log.lines().find_map(|line| line.split("ERROR SUMMARY: ").nth(1)) else { continue };
            programs += 1;
            if !summary.starts_with("0 errors") {
                with_findings += 1;
                println!("{log}");
            }
        }
        if with_findings > 0 {
            bail!("valgrind finds something in {with_findings} of {programs} programs");
        }
        tests?;
        ensure!(programs > 0, "no program ran under valgrind");
        println!("valgrind finds nothing in {programs} programs");
        Ok(Outcome::Passed)
    }
}
