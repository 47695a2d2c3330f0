//! Physics engines whose contacts go through the contact layer: Jolt on the demo's hood, and Rapier, Bullet and Jolt on the truths' hits.
//! The lab's tests have Rapier in scenes of its own.

use std::path::Path;

use anyhow::Result;
use xshell::cmd;

use crate::stage::{Outcome, all_passed};
use crate::throws;
use crate::workspace::Workspace;

pub fn stage(workspace: &Workspace) -> Result<Outcome> {
    let programs = throws::build(workspace)?;
    all_passed(vec![
        ("Jolt", jolt(workspace, &programs)),
        ("the truths in all engines", truths(workspace, &programs)),
    ])?;
    Ok(Outcome::Passed)
}

fn jolt(workspace: &Workspace, programs: &Path) -> Result<()> {
    let directory = programs.join("examples-c");
    let sh = &workspace.shell;
    Ok(cmd!(sh, "ctest --test-dir {directory} --tests-regex ^jolt_crash$ --verbose --no-tests=error").run()?)
}

fn truths(workspace: &Workspace, programs: &Path) -> Result<()> {
    workspace.build_as_tested(&["--bin", "crumple-lab"]).run()?;
    let program = workspace.target.join("debug/crumple-lab").with_extension(std::env::consts::EXE_EXTENSION);
    let out = workspace.target.join("lab-engines");
    Ok(cmd!(workspace.shell, "{program} contacts --check --throws {programs} --out {out}").run()?)
}
