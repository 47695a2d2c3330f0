//! `cargo xtask bench`: builds the lab's benchmark and runs it from the repository's root. `--gpu` runs the benchmark of graphics devices.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use clap::Args;
use xshell::cmd;

use crate::files::empty_directory;
use crate::lab;
use crate::package::SLIM;
use crate::workspace::Workspace;

/// The part that needs no device.
const COMPILED: &str = "compiled";

#[derive(Args)]
pub struct Options {
    /// Measure briefly, without the largest meshes; replaces no committed figure
    #[arg(long)]
    pub quick: bool,
    /// Write the results as JSON: an array of name, value, unit, reference (in the unit) and ratio
    #[arg(long, value_name = "FILE", conflicts_with = "gpu")]
    pub json: Option<PathBuf>,
    /// Only the results whose names begin like this, or this workload of graphics devices; may be given several times
    #[arg(long, value_name = "NAME")]
    pub only: Vec<String>,
    /// Measure each graphics device that the Vulkan loader finds; VK_DRIVER_FILES chooses its drivers
    #[arg(long)]
    pub gpu: bool,
    /// Only devices whose names begin like this; may be given several times
    #[arg(long, value_name = "NAME", requires = "gpu")]
    pub device: Vec<String>,
}

pub fn run(workspace: &Workspace, options: &Options) -> Result<()> {
    if options.gpu {
        return devices(workspace, options);
    }
    // The physics engines that `cargo xtask lab` needs are left out: they take longer to build than all the rest.
    let program = lab::program(workspace, &[])?;
    let (out, lab) = (workspace.path("docs/bench"), workspace.path("docs/lab"));
    let quick = options.quick.then_some("--quick");
    let only = options.only.iter().flat_map(|name| ["--only", name]);
    let json: Vec<PathBuf> = match &options.json {
        Some(file) => vec![PathBuf::from("--json"), absolute(file)?],
        None => Vec::new(),
    };
    cmd!(workspace.shell, "{program} bench {quick...} {only...} {json...} --out {out} --lab {lab}").quiet().run()?;
    Ok(())
}

/// Measures graphics devices. A full run replaces their tables, and the charts and the page made from all tables.
fn devices(workspace: &Workspace, options: &Options) -> Result<()> {
    let program = lab::program(workspace, &["--features", "gpu"])?;
    let out = workspace.path("docs/bench");
    let quick = options.quick.then_some("--quick");
    let only = options.only.iter().filter(|name| *name != COMPILED).flat_map(|name| ["--only", name]);
    let device = options.device.iter().flat_map(|name| ["--device", name]);
    let asked = options.only.iter().any(|name| name == "library");
    let whole = !options.quick && options.only.is_empty();
    let library = if asked || whole { stripped_library(workspace)? } else { None };
    let library: Vec<PathBuf> = library.into_iter().flat_map(|file| [PathBuf::from("--library"), file]).collect();
    let sh = &workspace.shell;
    let compiled = options.only.iter().any(|name| name == COMPILED);
    if compiled || options.only.is_empty() {
        let to = (!options.quick).then_some(["--out".into(), out.clone()]).into_iter().flatten();
        cmd!(sh, "{program} compiled {to...}").quiet().run()?;
    }
    if compiled && options.only.len() == 1 {
        return Ok(());
    }
    cmd!(sh, "{program} gpu {quick...} {only...} {device...} {library...} --out {out}").quiet().run()?;
    if whole {
        let python = lab::python(workspace)?;
        let _no_cache = sh.push_env("PYTHONDONTWRITEBYTECODE", "1");
        for script in ["draw.py", "gpu_report.py"] {
            let path = workspace.path("lab/python").join(script);
            cmd!(sh, "{python} {path} {out}").quiet().run()?;
        }
    }
    Ok(())
}

/// The slim C library, stripped. `None` without a `strip` program.
fn stripped_library(workspace: &Workspace) -> Result<Option<PathBuf>> {
    use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
    let features = SLIM.library.join(",");
    let what = ["build", "--profile", "dist", "--package", "crumple", "--lib", "--no-default-features", "--features"];
    workspace.cargo(&what).arg(features).run()?;
    let name = format!("{DLL_PREFIX}crumple{DLL_SUFFIX}");
    let (library, stripped) =
        (workspace.target.join("dist").join(&name), workspace.target.join("stripped").join(&name));
    empty_directory(&workspace.target.join("stripped"))?;
    if let Err(error) = cmd!(workspace.shell, "strip -o {stripped} {library}").quiet().run() {
        println!("left out: the library's size, since it cannot be stripped ({error})");
        return Ok(None);
    }
    Ok(Some(stripped))
}

/// Resolves `file` against the folder in which the user typed the command.
fn absolute(file: &Path) -> Result<PathBuf> {
    std::path::absolute(file).with_context(|| format!("finding {}", file.display()))
}
