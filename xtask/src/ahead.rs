//! What some stages compile in folders of their own is compiled from the start of a whole run, in the time in which other stages leave
//! a core idle: a stage finds it ready, or waits for Cargo's lock.

use std::process::{Child, Command, Stdio};

use anyhow::Result;

use crate::workspace::Workspace;
use crate::{fuzz, godot, nightly, platforms, web};

/// In the order of the stages.
const BUILDS: &[fn(&Workspace) -> Result<()>] =
    &[godot::build, web::build, fuzz::build_for_stage, nightly::build, platforms::build];

/// A process that does nothing else, and gives way to every other.
pub struct Ahead(Option<Child>);

impl Ahead {
    /// Without the `nice` command it does nothing, and stages build for themselves.
    pub fn start() -> Self {
        let program = std::env::current_exe().unwrap_or_default();
        let mut command = Command::new("nice");
        // A stage whose build fails says so.
        command.args(["-n", "19"]).arg(program).arg("ahead").stdout(Stdio::null()).stderr(Stdio::null());
        Self(command.spawn().ok())
    }
}

impl Drop for Ahead {
    fn drop(&mut self) {
        if let Some(child) = &mut self.0 {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

pub fn run(workspace: &Workspace) {
    for build in BUILDS {
        let _ = build(workspace);
    }
}
