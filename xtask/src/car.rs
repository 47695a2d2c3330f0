//! The car: `cargo xtask car` makes the passenger car of assets/car, draws it, and makes its examples; `cargo xtask demo` crashes it with
//! impacts and writes pictures and a GLB.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result, ensure};
use clap::Args;
use xshell::cmd;

use crate::files::{self, empty_directory, write};
use crate::stage::LeftOut;
use crate::tools::{NPM, PYTHON3};
use crate::workspace::Workspace;
use crate::{blender, command, exports, python};

const ASSETS: &str = "assets/car";
/// Examples that the repository keeps, some 40 kB each.
const KEPT: &str = "100";

/// The car with its examples, and what hits it; `cargo xtask car --examples` makes both.
const CAR: &str = "assets/car/car_dents.glb";
pub const CRASH: &str = "assets/car/crash.json";

#[derive(Args)]
pub struct Options {
    /// Folder for car.glb and the files that belong to it
    #[arg(long, value_name = "DIR", default_value = "out/car")]
    out: PathBuf,
    /// Also draw the car in Blender without a window, into car.png there; this installs `bpy`, about 400 MB
    #[arg(long)]
    picture: bool,
    /// Also strike the car with a solver; write all of its examples to the folder, and those that the repository keeps, with the
    /// demo's impacts, into assets/car. This takes about forty minutes of a core, and goes on where it was interrupted
    #[arg(long)]
    examples: bool,
}

pub fn run(workspace: &Workspace, options: &Options) -> Result<()> {
    let out = workspace.path(&options.out);
    make(workspace, &out)?;
    if options.picture {
        let python = blender::module(workspace, blender::NEWEST)?;
        let (car, picture) = (out.join("car.glb"), out.join("car.png"));
        let size = ["--size", "1000", "560", "--samples", "64"];
        cmd!(workspace.shell, "{python} {ASSETS}/draw_car.py {car} {picture} {size...}")
            .quiet()
            .ignore_stdout()
            .run()?;
        println!("{}", picture.display());
    }
    if options.examples {
        examples(workspace, &out)?;
    }
    Ok(())
}

/// Makes assets/car's examples from the car in `out`, with the Python package of this checkout.
fn examples(workspace: &Workspace, out: &Path) -> Result<()> {
    let sh = &workspace.shell;
    let (python, _) = python::with_package(workspace, &workspace.target.join("car-wheel"))?;
    let hits = out.join("hits");
    cmd!(sh, "{python} -B -W ignore {ASSETS}/strike_car.py {out} {hits}").quiet().run()?;
    cmd!(sh, "{python} -B {ASSETS}/example_car.py {hits} {ASSETS} {KEPT}").quiet().run()?;
    cmd!(sh, "{python} -B {ASSETS}/example_car.py {hits} {out}").quiet().run()?;
    Ok(())
}

/// The car is made, and its files are as a car's should be and as glTF demands.
pub fn stage(workspace: &Workspace) -> Result<()> {
    let out = workspace.target.join("car");
    empty_directory(&out)?;
    let python = make(workspace, &out)?;
    cmd!(workspace.shell, "{python} -B {ASSETS}/check_car.py {out}").quiet().run()?;
    if !NPM.here(workspace) {
        return Ok(());
    }
    let files =
        ["car", "car_coarse", "car_body", "car_inner", "car_collider"].map(|name| out.join(format!("{name}.glb")));
    match exports::validate(workspace, &files) {
        Err(error) if error.is::<LeftOut>() => {
            workspace.leave_out(format!("{error:#}"));
            Ok(())
        }
        judged => judged,
    }
}

/// Writes the car's files to `out`. Returns the Python that made them.
fn make(workspace: &Workspace, out: &Path) -> Result<PathBuf> {
    let python = python::environment(workspace, PYTHON3, "car-venv", &format!("{ASSETS}/requirements.txt"))?;
    println!("making the car in {}", out.display());
    cmd!(workspace.shell, "{python} -B {ASSETS}/make_car.py {out}").quiet().run()?;
    Ok(python)
}

/// `cargo xtask demo`. `gpu`: deform on the GPU whose name contains this.
pub fn demo(workspace: &Workspace, out: &Path, gpu: Option<&str>) -> Result<()> {
    println!("Building the `crumple` command; the first time takes a few minutes.");
    let gpu: Vec<String> = gpu.iter().map(|name| format!("--gpu={name}")).collect();
    show(workspace, &command::fast(workspace, !gpu.is_empty())?, &workspace.path(out), &gpu)
}

/// The demo as a test: it runs and writes every file that it promises.
pub fn demo_stage(workspace: &Workspace) -> Result<()> {
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
    files::make(out)?;
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
pub fn lay_out(workspace: &Workspace, folder: &Path, options: &[&str]) -> Result<()> {
    files::make(folder)?;
    let (sh, program) = (&workspace.shell, command::tested(workspace)?);
    let [car, set, none] = ["car.glb", "car.crumple", "impacts.json"].map(|name| folder.join(name));
    cmd!(sh, "{program} bake {CAR} --join --one-mesh {options...} -o {set}").quiet().ignore_stdout().run()?;
    write(&none, "[]")?;
    cmd!(sh, "{program} apply {CAR} --impacts {none} -o {car} --join {options...}").quiet().ignore_stdout().run()?;
    fs::remove_file(&none).context("removing the list of no impacts")
}
