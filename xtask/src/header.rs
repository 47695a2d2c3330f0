//! `include/crumple.h`: written by cbindgen from the sources of `src/capi`, committed, and compared in CI.

use std::fs;

use anyhow::{Context, Result, anyhow, bail};
use similar::TextDiff;

use crate::workspace::Workspace;

const HEADER: &str = "include/crumple.h";

pub fn run(workspace: &Workspace, check: bool) -> Result<()> {
    let fresh = generate(workspace)?;
    let path = workspace.path(HEADER);
    if !check {
        fs::write(&path, fresh).with_context(|| format!("writing {HEADER}"))?;
        println!("wrote {HEADER}");
        return Ok(());
    }
    let committed = fs::read_to_string(&path).with_context(|| format!("reading {HEADER}"))?.replace("\r\n", "\n");
    if committed != fresh {
        let committed_name = format!("{HEADER} (committed)");
        let diff = TextDiff::from_lines(&committed, &fresh);
        print!("{}", diff.unified_diff().header(&committed_name, "what the sources say"));
        bail!("{HEADER} is not what the sources say; type: cargo xtask header");
    }
    println!("{HEADER} is what the sources say");
    Ok(())
}

fn generate(workspace: &Workspace) -> Result<String> {
    let config = cbindgen::Config::from_file(workspace.path("cbindgen.toml"))
        .map_err(|message| anyhow!("cbindgen.toml: {message}"))?;
    let bindings = cbindgen::Builder::new()
        .with_crate(&workspace.root)
        .with_config(config)
        .generate()
        .context("cbindgen cannot read the sources; does the library build?")?;
    let mut text = Vec::new();
    bindings.write(&mut text);
    let text = String::from_utf8(text)?.replace("\r\n", "\n");
    // What is left out of the header leaves its blank lines behind.
    let mut lines: Vec<&str> = text.lines().collect();
    lines.dedup_by(|line, above| line.is_empty() && above.is_empty());
    Ok(lines.join("\n") + "\n")
}
