//! Physics engines whose contacts go through the contact layer: Rapier in scenes of its own, Jolt on the demo's hood, and Rapier, Bullet
//! and Jolt on the truths' hits.

use std::path::Path;

use anyhow::Result;
use xshell::cmd;

use crate::lab;
use crate::stage::{Outcome, all_passed};
use crate::throws;
use crate::workspace::Workspace;

/// What is built of the lab.
const TESTED: &[&str] = &["--features", "engines", "--test", "rapier"];

pub fn stage(workspace: &Workspace) -> Result<Outcome> {
    let programs = throws::build(workspace)?;
    all_passed(vec![
        ("Rapier", rapier(workspace)),
        ("Jolt", jolt(workspace, &programs)),
        ("the truths in all engines", truths(workspace, &programs)),
    ])?;
    Ok(Outcome::Passed)
}

fn rapier(workspace: &Workspace) -> Result<()> {
    let test = ["test", "--release", "--package", "crumple-lab"];
    Ok(workspace.cargo_anywhere(&test)?.args(TESTED).run()?)
}

fn jolt(workspace: &Workspace, programs: &Path) -> Result<()> {
    let directory = programs.join("examples-c");
    let sh = &workspace.shell;
    Ok(cmd!(sh, "ctest --test-dir {directory} --tests-regex ^jolt_crash$ --verbose --no-tests=error").run()?)
}

fn truths(workspace: &Workspace, programs: &Path) -> Result<()> {
    // With the test, so that Cargo does not build the engines again without the features that tests enable.
    let program = lab::program(workspace, &[TESTED, &["--bins"]].concat())?;
    let out = workspace.target.join("lab-engines");
    Ok(cmd!(workspace.shell, "{program} contacts --check --throws {programs} --out {out}").run()?)
}
