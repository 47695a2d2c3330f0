//! `include/crumple.h`, which cbindgen writes from the sources of `src/capi`, and the C# and Python declarations made from it:
//! committed, and compared in CI.

use std::fs;

use anyhow::{Context, Result, anyhow, bail};
use similar::TextDiff;

use crate::csharp;
use crate::declarations::HEADER;
use crate::python;
use crate::workspace::Workspace;

/// Characters in a line of the header.
const WIDTH: usize = 120;

pub fn run(workspace: &Workspace, check: bool) -> Result<()> {
    let header = generate(workspace)?;
    let (types, functions) = csharp::declarations(&header)?;
    let python = python::declarations(&header)?;
    let files =
        [(HEADER, header), (csharp::TYPES, types), (csharp::FUNCTIONS, functions), (python::DECLARATIONS, python)];
    for (name, fresh) in &files {
        if check { compare(workspace, name, fresh)? } else { write(workspace, name, fresh)? }
    }
    Ok(())
}

fn write(workspace: &Workspace, name: &str, fresh: &str) -> Result<()> {
    fs::write(workspace.path(name), fresh).with_context(|| format!("writing {name}"))?;
    println!("wrote {name}");
    Ok(())
}

fn compare(workspace: &Workspace, name: &str, fresh: &str) -> Result<()> {
    let committed = fs::read_to_string(workspace.path(name)).with_context(|| format!("reading {name}"))?;
    let committed = committed.replace("\r\n", "\n");
    if committed != fresh {
        let committed_name = format!("{name} (committed)");
        let diff = TextDiff::from_lines(&committed, fresh);
        print!("{}", diff.unified_diff().header(&committed_name, "what the sources say"));
        bail!("{name} is not what the sources say; type: cargo xtask header");
    }
    println!("{name} is what the sources say");
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
    // Items that cbindgen leaves out leave their blank lines behind.
    let mut lines: Vec<String> = Vec::new();
    for line in text.lines() {
        // Constants go together.
        if line.starts_with("///") && lines.ends_with(&[String::new()]) && lines[lines.len() - 2].starts_with("#define")
        {
            lines.pop();
        }
        match lines.last_mut() {
            Some(above) if line.is_empty() && above.is_empty() => {}
            // Arguments go beside each other, as far as there is room.
            Some(above) if line.starts_with("      ") && above.len() + 1 + line.trim_start().len() <= WIDTH => {
                above.push(' ');
                above.push_str(line.trim_start());
            }
            _ => lines.push(line.to_owned()),
        }
    }
    Ok(lines.join("\n") + "\n")
}
