//! `cargo xtask schedules`: tests of threads with the locks of shuttle, which runs the threads in orders of its own choice.

use anyhow::Result;
use xshell::cmd;

use crate::workspace::Workspace;

pub fn run(workspace: &Workspace) -> Result<()> {
    // A folder of its own: the flag builds everything again.
    let home = workspace.target.join("schedules");
    let arguments = ["--package", "crumple", "--lib", "--no-default-features", "--target-dir"];
    cmd!(workspace.shell, "cargo test {arguments...} {home} -- instance::schedules")
        .env("RUSTFLAGS", "--cfg shuttle")
        .run()?;
    Ok(())
}
