//! `cargo xtask car`: makes the passenger car of assets/car, and draws it.

use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::Args;
use xshell::cmd;

use crate::blender;
use crate::peers;
use crate::python;
use crate::stage::Outcome;
use crate::tools::Tool;
use crate::workspace::{Workspace, empty_directory};

const ASSETS: &str = "assets/car";

#[derive(Args)]
pub struct Options {
    /// Folder for car.glb and the files that belong to it
    #[arg(long, value_name = "DIR", default_value = "out/car")]
    out: PathBuf,
    /// Also draw the car in Blender without a window, into car.png there; this installs `bpy`, about 400 MB
    #[arg(long)]
    picture: bool,
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
    Ok(())
}

/// The car is made, and its files are as a car's should be and as glTF demands.
pub fn stage(workspace: &Workspace) -> Result<Outcome> {
    let out = workspace.target.join("car");
    empty_directory(&out)?;
    let python = make(workspace, &out)?;
    let check = workspace.path(ASSETS).join("check_car.py");
    cmd!(workspace.shell, "{python} -B {check} {out}").quiet().run()?;
    if !Tool::Npm.here(workspace) {
        return Ok(Outcome::Passed);
    }
    let files =
        ["car", "car_coarse", "car_body", "car_inner", "car_collider"].map(|name| out.join(format!("{name}.glb")));
    peers::validate(workspace, &files)
}

/// Writes the car's files to `out`. Returns the Python that made them.
fn make(workspace: &Workspace, out: &Path) -> Result<PathBuf> {
    let python = python::environment(workspace, Tool::Python3, "car-venv", &format!("{ASSETS}/requirements.txt"))?;
    let script = workspace.path(ASSETS).join("make_car.py");
    println!("making the car in {}", out.display());
    cmd!(workspace.shell, "{python} -B {script} {out}").quiet().run()?;
    Ok(python)
}
