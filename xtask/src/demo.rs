//! `cargo xtask demo`: the main job, from a mesh and its impacts to pictures and a dented GLB.

use std::fs;
use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result};

use crate::command::Command;
use crate::workspace::Workspace;

/// A hood with eight dents that an independent elasto-plastic solver computed.
const MESH: &str = "assets/demo/panel_render.glb";
const HITS: &str = "12";

pub fn run(workspace: &Workspace, out: &Path) -> Result<()> {
    println!("Building the `crumple` command (the first time takes minutes) ...");
    let command = Command::build(workspace)?;
    let out = workspace.path(out);
    fs::create_dir_all(&out).with_context(|| format!("creating {}", out.display()))?;
    let (mesh, impacts, dented) = (workspace.path(MESH), out.join("impacts.json"), out.join("dented.glb"));

    println!("\n1. The mesh and its examples: {MESH}");
    command.info(&mesh)?;
    println!("\n2. {HITS} impacts, spread over the body");
    command.sample(&mesh, &impacts, HITS)?;
    println!("\n3. The impacts become dents, on the CPU");
    let start = Instant::now();
    command.apply(&mesh, &impacts, &dented, Some(&out))?;

    println!("\nDone in {:.1} s, reading, pictures and all. Look at:", start.elapsed().as_secs_f64());
    let mut files: Vec<_> = fs::read_dir(&out)?.collect::<Result<Vec<_>, _>>()?;
    files.sort_by_key(fs::DirEntry::path);
    for file in files {
        println!("  {}  ({} kB)", file.path().display(), file.metadata()?.len().div_ceil(1000));
    }
    Ok(())
}
