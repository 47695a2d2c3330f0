//! `cargo xtask demo`: crashes a car with impacts and writes pictures and a GLB.

use std::fs;
use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result};
use xshell::cmd;

use crate::command::Command;
use crate::install::Profile;
use crate::workspace::Workspace;

/// The car with its examples, and what hits it; `cargo xtask car --examples` makes both.
pub const CAR: &str = "assets/car/car_dents.glb";
pub const CRASH: &str = "assets/car/crash.json";

/// `gpu`: deform on the GPU whose name contains this.
pub fn run(workspace: &Workspace, out: &Path, gpu: Option<&str>) -> Result<()> {
    println!("Building the `crumple` command; the first time takes a few minutes.");
    show(workspace, &Command::build(workspace, Profile::Release, gpu)?, out)
}

fn show(workspace: &Workspace, command: &Command<'_>, out: &Path) -> Result<()> {
    println!("\nA car before and after a crash; its examples are dents that a physics solver computed.");
    let start = Instant::now();
    let out = workspace.path(out);
    dent(workspace, command, &out)?;
    println!("  {:.1} s with reading, writing and pictures", start.elapsed().as_secs_f64());
    println!("  Look at {} and dented.glb beside it.", out.join("before_after.png").display());
    println!("  The hits are in {CRASH}, what each became in report.txt.");
    Ok(())
}

/// Writes what other programs need to draw the car and to dent it: `car.glb`, without examples and packing, and the baked `car.crumple`.
/// `options` are further ones of both commands, such as `--moving`.
pub fn lay_out_car(workspace: &Workspace, folder: &Path, options: &[&str]) -> Result<()> {
    fs::create_dir_all(folder).with_context(|| format!("creating {}", folder.display()))?;
    let command = Command::build(workspace, Profile::Debug, None)?;
    let (program, car, set) = (command.program(), workspace.path(CAR), folder.join("car.crumple"));
    let bake = cmd!(workspace.shell, "{program} bake {car} --join --one-mesh {options...} -o {set}");
    bake.quiet().ignore_stdout().run()?;
    let none = folder.join("impacts.json");
    fs::write(&none, "[]")?;
    command.apply(&car, &none, &folder.join("car.glb"), None, &[&["--join"], options].concat())?;
    fs::remove_file(&none).context("removing the list of no impacts")
}

/// The demo as a test: it runs and writes every file that it promises.
pub fn check(workspace: &Workspace) -> Result<()> {
    let out = workspace.target.join("demo");
    show(workspace, &Command::build(workspace, Profile::Debug, None)?, &out)?;
    for file in ["base.png", "after.png", "heat.png", "before_after.png", "dented.glb", "report.txt"] {
        let path = out.join(file);
        fs::metadata(&path).with_context(|| format!("the demo left no {}", path.display()))?;
    }
    Ok(())
}

fn dent(workspace: &Workspace, command: &Command<'_>, out: &Path) -> Result<()> {
    fs::create_dir_all(out).with_context(|| format!("creating {}", out.display()))?;
    let (car, crash) = (workspace.path(CAR), workspace.path(CRASH));
    let applied = command.apply(&car, &crash, &out.join("dented.glb"), Some(out), &["--join", "--size", "1280x560"])?;
    // A table with a line for each hit comes first. The summary follows the last empty line.
    let summary = applied.rsplit("\n\n").next().unwrap_or(&applied);
    println!("{}", summary.trim_end());
    let report = out.join("report.txt");
    fs::write(&report, format!("{applied}\n")).with_context(|| format!("writing {}", report.display()))
}
