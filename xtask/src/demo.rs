//! `cargo xtask demo`: the main job, from a mesh and its impacts to pictures and a dented GLB.

use std::fs;
use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result};

use crate::command::Command;
use crate::workspace::Workspace;

/// A car's hood and a drum, each with dents that an independent elasto-plastic solver computed as its examples.
const BODIES: &[&str] = &["hood", "drum"];
const HITS: &str = "12";

pub fn run(workspace: &Workspace, out: &Path) -> Result<()> {
    println!("Building the `crumple` command; the first time takes a few minutes.");
    let command = Command::build(workspace)?;
    let out = workspace.path(out);
    for body in BODIES {
        println!("\n== {body}");
        dent(workspace, &command, &format!("assets/demo/{body}.glb"), &out.join(body))?;
    }
    Ok(())
}

fn dent(workspace: &Workspace, command: &Command<'_>, mesh: &str, out: &Path) -> Result<()> {
    fs::create_dir_all(out).with_context(|| format!("creating {}", out.display()))?;
    let (mesh, impacts, dented) = (workspace.path(mesh), out.join("impacts.json"), out.join("dented.glb"));
    command.info(&mesh)?;
    command.sample(&mesh, &impacts, HITS)?;
    let start = Instant::now();
    command.apply(&mesh, &impacts, &dented, Some(out))?;

    println!(
        "{HITS} hits on the CPU, with reading, writing and pictures: {:.1} s. Look at:",
        start.elapsed().as_secs_f64()
    );
    let mut files = fs::read_dir(out)?.collect::<Result<Vec<_>, _>>()?;
    files.sort_by_key(fs::DirEntry::path);
    for file in files {
        println!("  {} ({} kB)", file.path().display(), file.metadata()?.len().div_ceil(1000));
    }
    Ok(())
}
