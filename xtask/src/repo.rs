//! Checks of the repository itself that build nothing: its size, and that what README and changelog repeat is true.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, bail, ensure};

use crate::unity;
use crate::workspace::Workspace;

/// Meshes, fixtures and pictures together, in bytes.
const ASSETS_LIMIT: u64 = 15_000_000;
/// The lab's figures, in bytes; made again by `cargo xtask lab`.
const FIGURES_LIMIT: u64 = 15_000_000;
/// The lab's truths, in bytes.
const TRUTHS_LIMIT: u64 = 14_000_000;
const QUICKSTART: &str = "examples-c/quickstart.c";
const QUICKSTART_LINES: usize = 80;
const README: &str = "README.md";
const SNIPPET_BEGIN: &str = "<!-- examples-c/quickstart.c -->\n```c\n";
const SNIPPET_END: &str = "```\n<!-- end of examples-c/quickstart.c -->";

pub fn run(workspace: &Workspace, fix: bool) -> Result<()> {
    assets(workspace)?;
    quickstart(workspace, fix)?;
    unity::metas(workspace, fix)?;
    changelog(workspace)
}

fn assets(workspace: &Workspace) -> Result<()> {
    within(workspace, &["assets", "docs/images", "tests"], ASSETS_LIMIT)?;
    within(workspace, &["docs/lab"], FIGURES_LIMIT)?;
    within(workspace, &["lab/data"], TRUTHS_LIMIT)
}

fn within(workspace: &Workspace, directories: &[&str], limit: u64) -> Result<()> {
    let mut total = 0;
    for directory in directories {
        total += size_of(&workspace.path(directory))?;
    }
    let (names, verb) = (directories.join(", "), if directories.len() > 1 { "hold" } else { "holds" });
    ensure!(total < limit, "{names} {verb} {total} bytes; at most {limit} are allowed, since every clone carries them");
    println!("{names} {verb} {:.1} MB of {} allowed", total as f64 / 1e6, limit / 1_000_000);
    Ok(())
}

fn size_of(path: &Path) -> Result<u64> {
    let metadata = fs::symlink_metadata(path).with_context(|| format!("looking at {}", path.display()))?;
    if !metadata.is_dir() {
        return Ok(metadata.len());
    }
    fs::read_dir(path)?.try_fold(0, |total, entry| Ok(total + size_of(&entry?.path())?))
}

fn quickstart(workspace: &Workspace, fix: bool) -> Result<()> {
    let program = read(workspace, QUICKSTART)?;
    let lines = program.lines().count();
    ensure!(
        lines < QUICKSTART_LINES,
        "{QUICKSTART} has {lines} lines; a first program should have under {QUICKSTART_LINES}"
    );
    let readme = read(workspace, README)?;
    let (before, rest) =
        readme.split_once(SNIPPET_BEGIN).with_context(|| format!("{README} lacks the lines {SNIPPET_BEGIN:?}"))?;
    let (snippet, after) =
        rest.split_once(SNIPPET_END).with_context(|| format!("{README} lacks the lines {SNIPPET_END:?}"))?;
    if snippet == program {
        println!("{README} shows {QUICKSTART} as it is");
    } else if fix {
        fs::write(workspace.path(README), [before, SNIPPET_BEGIN, &program, SNIPPET_END, after].concat())?;
        println!("{README} shows the present {QUICKSTART}");
    } else {
        bail!("{README} shows another program than {QUICKSTART}; type: cargo xtask repo --fix");
    }
    Ok(())
}

fn changelog(workspace: &Workspace) -> Result<()> {
    let heading = format!("## [{}]", workspace.version);
    let found = read(workspace, "CHANGELOG.md")?.lines().any(|line| line.starts_with(&heading));
    ensure!(found, "CHANGELOG.md has no heading {heading:?} for this package's version");
    println!("CHANGELOG.md tells about version {}", workspace.version);
    Ok(())
}

fn read(workspace: &Workspace, path: &str) -> Result<String> {
    let text = fs::read_to_string(workspace.path(path)).with_context(|| format!("reading {path}"))?;
    Ok(text.replace("\r\n", "\n"))
}
