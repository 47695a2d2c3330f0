//! `cargo xtask bench`: builds the lab's benchmark and runs it from the repository's root.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use clap::Args;
use xshell::cmd;

use crate::workspace::Workspace;

#[derive(Args)]
pub struct Options {
    /// Short runs, and without the largest meshes; replaces no committed figure
    #[arg(long)]
    pub quick: bool,
    /// Writes the results as JSON: an array of name, value, unit, reference (in the unit) and ratio
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Only the results whose names begin like this; may be given several times
    #[arg(long, value_name = "NAME")]
    pub only: Vec<String>,
}

pub fn run(workspace: &Workspace, options: &Options) -> Result<()> {
    // Without the physics engines that `cargo xtask lab` needs: they take longer to build than all the rest.
    workspace.cargo(&["build", "--release", "--package", "crumple-lab"]).run()?;
    let program = workspace.target.join("release/crumple-lab").with_extension(std::env::consts::EXE_EXTENSION);
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

/// As seen from where the command was typed.
fn absolute(file: &Path) -> Result<PathBuf> {
    std::path::absolute(file).with_context(|| format!("finding {}", file.display()))
}
