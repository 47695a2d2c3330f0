//! `cargo xtask demo`: dents a mesh with impacts and writes pictures and a GLB.

use std::fs;
use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result};

use crate::command::Command;
use crate::install::Profile;
use crate::stage::Outcome;
use crate::workspace::Workspace;

/// A car's hood of sheet steel and a drum. Independent elasto-plastic solvers computed their example dents.
const BODIES: &[&str] = &["hood", "drum"];

/// `gpu`: deform on the GPU whose name contains this.
pub fn run(workspace: &Workspace, out: &Path, gpu: Option<&str>) -> Result<()> {
    println!("Building the `crumple` command; the first time takes a few minutes.");
    show(workspace, &Command::build(workspace, Profile::Release, gpu)?, out)
}

fn show(workspace: &Workspace, command: &Command<'_>, out: &Path) -> Result<()> {
    println!("\nFive hits each on a steel hood and a drum; their examples are dents that physics solvers computed.");
    for body in BODIES {
        let start = Instant::now();
        let out = workspace.path(out).join(body);
        println!("\n{body}:");
        dent(workspace, command, body, &out)?;
        println!("  {:.1} s with reading, writing and pictures", start.elapsed().as_secs_f64());
        println!("  Look at {} and dented.glb beside it.", out.join("before_after.png").display());
        println!("  The hits are in assets/demo/{body}.json, what each became in report.txt.");
    }
    Ok(())
}

/// The demo as a test: it runs and writes every file that it promises.
pub fn check(workspace: &Workspace) -> Result<Outcome> {
    let out = workspace.target.join("demo");
    show(workspace, &Command::build(workspace, Profile::Debug, None)?, &out)?;
    for body in BODIES {
        for file in ["base.png", "after.png", "heat.png", "before_after.png", "dented.glb", "report.txt"] {
            let path = out.join(body).join(file);
            fs::metadata(&path).with_context(|| format!("the demo left no {}", path.display()))?;
        }
    }
    Ok(Outcome::Passed)
}

fn dent(workspace: &Workspace, command: &Command<'_>, body: &str, out: &Path) -> Result<()> {
    fs::create_dir_all(out).with_context(|| format!("creating {}", out.display()))?;
    let mesh = workspace.path(format!("assets/demo/{body}.glb"));
    let impacts = workspace.path(format!("assets/demo/{body}.json"));
    let info = command.info(&mesh)?;
    let applied = command.apply(&mesh, &impacts, &out.join("dented.glb"), Some(out))?;
    // A table with a line for each hit comes first. The summary follows the last empty line.
    let summary = applied.rsplit("\n\n").next().unwrap_or(&applied);
    println!("{}", summary.trim_end());
    let report = out.join("report.txt");
    fs::write(&report, format!("{info}\n{applied}\n")).with_context(|| format!("writing {}", report.display()))
}
