//! The car: `cargo xtask car` makes the passenger car of assets/car, draws it, and makes its examples; `cargo xtask demo` crashes it with
//! impacts and writes pictures and a GLB.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Result, bail, ensure};
use clap::Args;

use crate::files::{empty, make, write};
use crate::stage::LeftOut;
use crate::target::Target;
use crate::tools::{NPM, PYTHON3};
use crate::workspace::{in_root, in_target, run, said, sh, silent};
use crate::{blender, command, node, python};

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
    /// demo's impacts, into assets/car. This takes about eighty minutes of a core, and goes on where it was interrupted
    #[arg(long)]
    examples: bool,
}

pub fn run(options: &Options) -> Result<()> {
    let out = in_root(&options.out);
    make_car(&out)?;
    if options.picture {
        let python = blender::module(blender::NEWEST)?;
        let picture = out.join("car.png");
        silent!("{python} {ASSETS}/draw_car.py {out}/car.glb {picture} --size 1000 560 --samples 64")?;
        println!("{}", picture.display());
    }
    if options.examples {
        // From the car in `out`, with the Python package of this checkout.
        let (python, _) = python::with_package(&in_target("car-wheel"))?;
        run!("{python} -B -W ignore {ASSETS}/strike_car.py {out} {out}/hits")?;
        run!("{python} -B {ASSETS}/example_car.py {out}/hits {ASSETS} {KEPT}")?;
        run!("{python} -B {ASSETS}/example_car.py {out}/hits {out}")?;
    }
    Ok(())
}

/// The car is made, and its files are as a car's should be and as glTF demands.
pub fn stage() -> Result<()> {
    let out = empty(in_target("car"))?;
    let python = make_car(&out)?;
    run!("{python} -B {ASSETS}/check_car.py {out}")?;
    if !NPM.here() {
        return Ok(());
    }
    let files =
        ["car", "car_coarse", "car_body", "car_inner", "car_collider"].map(|name| out.join(format!("{name}.glb")));
    match node::validate(&files) {
        Err(error) if error.is::<LeftOut>() => bail!(LeftOut::Part(format!("{error:#}"))),
        judged => judged,
    }
}

/// Writes the car's files to `out`. Returns the Python that made them.
fn make_car(out: &Path) -> Result<PathBuf> {
    let python = python::environment(PYTHON3, "car-venv", &format!("{ASSETS}/requirements.txt"))?;
    println!("making the car in {}", out.display());
    run!("{python} -B {ASSETS}/make_car.py {out}")?;
    Ok(python)
}

/// `cargo xtask demo`. `gpu`: deform on the GPU whose name contains this.
pub fn demo(out: &Path, gpu: Option<&str>) -> Result<()> {
    println!("Building the `crumple` command; the first time takes a few minutes.");
    let gpu: Vec<String> = gpu.iter().map(|name| format!("--gpu={name}")).collect();
    // The GPU's part takes long to build.
    let features = if gpu.is_empty() { "cli" } else { command::FEATURES };
    show(&command::optimized(&Target::host()?, "release", features)?, &in_root(out), &gpu)
}

/// The demo as a test: it runs and writes every file that it promises.
pub fn demo_stage() -> Result<()> {
    let out = in_target("demo");
    show(&command::tested()?, &out, &[])?;
    for file in ["base.png", "after.png", "heat.png", "before_after.png", "dented.glb", "report.txt"] {
        ensure!(out.join(file).exists(), "the demo left no {}", out.join(file).display());
    }
    Ok(())
}

fn show(program: &Path, out: &Path, options: &[String]) -> Result<()> {
    println!("\nA car before and after a crash; its examples are dents that a physics solver computed.");
    make(out)?;
    let start = Instant::now();
    let dented = out.join("dented.glb");
    let pictures = ["--size", "1280x560", "--png"];
    let applied = said!("{program} apply {CAR} --impacts {CRASH} -o {dented} --join {pictures...} {out} {options...}")?;
    // A table with a line for each hit comes first. The summary follows the last empty line.
    println!("{}", applied.rsplit("\n\n").next().unwrap_or(&applied).trim_end());
    write(out.join("report.txt"), format!("{applied}\n"))?;
    println!("  {:.1} s with reading, writing and pictures", start.elapsed().as_secs_f64());
    println!("  Look at {} and dented.glb beside it.", out.join("before_after.png").display());
    println!("  The hits are in {CRASH}, what each became in report.txt.");
    Ok(())
}

/// Writes what other programs need to draw the car and to dent it: `car.glb`, without examples and packing, and the baked `car.crumple`.
/// `options` are further ones of both commands, such as `--moving`.
pub fn lay_out(folder: &Path, options: &[&str]) -> Result<()> {
    let (program, none) = (command::tested()?, folder.join("impacts.json"));
    write(&none, "[]")?;
    silent!("{program} bake {CAR} --join --one-mesh {options...} -o {folder}/car.crumple")?;
    silent!("{program} apply {CAR} --impacts {none} -o {folder}/car.glb --join {options...}")?;
    Ok(sh().remove_path(none)?)
}
