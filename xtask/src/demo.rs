//! `cargo xtask demo`: crashes a car with impacts and writes pictures and a GLB.

use std::fs;
use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result, ensure};
use xshell::cmd;

use crate::command;
use crate::files::{make, write};
use crate::workspace::Workspace;

/// The car with its examples, and what hits it; `cargo xtask car --examples` makes both.
const CAR: &str = "assets/car/car_dents.glb";
pub const CRASH: &str = "assets/car/crash.json";

/// `gpu`: deform on the GPU whose name contains this.
pub fn run(workspace: &Workspace, out: &Path, gpu: Option<&str>) -> Result<()> {
    println!("Building the `crumple` command; the first time takes a few minutes.");
    let gpu: Vec<String> = gpu.iter().map(|name| format!("--gpu={name}")).collect();
    show(workspace, &command::fast(workspace, !gpu.is_empty())?, &workspace.path(out), &gpu)
}

/// The demo as a test: it runs and writes every file that it promises.
pub fn check(workspace: &Workspace) -> Result<()> {
    let out = workspace.target.join("demo");
    show(workspace, &command::tested(workspace)?, &out, &[])?;
    for file in ["base.png", "after.png", "heat.png", "before_after.png", "dented.glb", "report.txt"] {
        ensure!(out.join(file).exists(), "the demo left no {}", out.join(file).display());
    }
    Ok(())
}

fn show(workspace: &Workspace, program: &Path, out: &Path, options: &[String]) -> Result<()> {
    println!("\nA car before and after a crash; its examples are dents that a physics solver computed.");
    let start = Instant::now();
    make(out)?;
    let dented = out.join("dented.glb");
    let pictures = ["--join", "--size", "1280x560", "--png"];
    let apply =
        cmd!(workspace.shell, "{program} apply {CAR} --impacts {CRASH} -o {dented} {pictures...} {out} {options...}");
    let applied = apply.quiet().read()?;
    // A table with a line for each hit comes first. The summary follows the last empty line.
    println!("{}", applied.rsplit("\n\n").next().unwrap_or(&applied).trim_end());
    write(&out.join("report.txt"), format!("{applied}\n"))?;
    println!("  {:.1} s with reading, writing and pictures", start.elapsed().as_secs_f64());
    println!("  Look at {} and dented.glb beside it.", out.join("before_after.png").display());
    println!("  The hits are in {CRASH}, what each became in report.txt.");
    Ok(())
}

/// Writes what other programs need to draw the car and to dent it: `car.glb`, without examples and packing, and the baked `car.crumple`.
/// `options` are further ones of both commands, such as `--moving`.
pub fn lay_out_car(workspace: &Workspace, folder: &Path, options: &[&str]) -> Result<()> {
    make(folder)?;
    let (sh, program) = (&workspace.shell, command::tested(workspace)?);
    let [car, set, none] = ["car.glb", "car.crumple", "impacts.json"].map(|name| folder.join(name));
    cmd!(sh, "{program} bake {CAR} --join --one-mesh {options...} -o {set}").quiet().ignore_stdout().run()?;
    write(&none, "[]")?;
    cmd!(sh, "{program} apply {CAR} --impacts {none} -o {car} --join {options...}").quiet().ignore_stdout().run()?;
    fs::remove_file(&none).context("removing the list of no impacts")
}
