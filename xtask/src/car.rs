//! `cargo xtask car`: makes the passenger car of assets/car, draws it, and makes its examples.

use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::Args;
use xshell::cmd;

use crate::files::empty_directory;
use crate::stage::LeftOut;
use crate::tools::{NPM, PYTHON3};
use crate::workspace::Workspace;
use crate::{blender, exports, python};

const ASSETS: &str = "assets/car";
/// Examples that the repository keeps, some 40 kB each.
const KEPT: &str = "100";

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
        let (script, car, picture) =
            (workspace.path(ASSETS).join("draw_car.py"), out.join("car.glb"), out.join("car.png"));
        let size = ["--size", "1000", "560", "--samples", "64"];
        cmd!(workspace.shell, "{python} {script} {car} {picture} {size...}").quiet().ignore_stdout().run()?;
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
    let (assets, hits) = (workspace.path(ASSETS), out.join("hits"));
    let (strike, write) = (assets.join("strike_car.py"), assets.join("example_car.py"));
    cmd!(sh, "{python} -B -W ignore {strike} {out} {hits}").quiet().run()?;
    cmd!(sh, "{python} -B {write} {hits} {assets} {KEPT}").quiet().run()?;
    cmd!(sh, "{python} -B {write} {hits} {out}").quiet().run()?;
    Ok(())
}

/// The car is made, and its files are as a car's should be and as glTF demands.
pub fn stage(workspace: &Workspace) -> Result<()> {
    let out = workspace.target.join("car");
    empty_directory(&out)?;
    let python = make(workspace, &out)?;
    let check = workspace.path(ASSETS).join("check_car.py");
    cmd!(workspace.shell, "{python} -B {check} {out}").quiet().run()?;
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
    let script = workspace.path(ASSETS).join("make_car.py");
    println!("making the car in {}", out.display());
    cmd!(workspace.shell, "{python} -B {script} {out}").quiet().run()?;
    Ok(python)
}
