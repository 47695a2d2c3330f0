//! Checks of the repository that build nothing: sizes, and programs, versions and messages that pages repeat.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, bail, ensure};

use crate::declarations::{self, Form};
use crate::workspace::{Workspace, files};
use crate::{dependencies, messages, unity};

/// Meshes, fixtures and pictures together, in bytes.
const ASSETS_LIMIT: u64 = 17_500_000;
/// The lab's figures, in bytes; `cargo xtask lab` writes them.
const FIGURES_LIMIT: u64 = 15_000_000;
/// The lab's reference data, in bytes.
const TRUTHS_LIMIT: u64 = 14_000_000;
const RELIABILITY: &str = "docs/reliability.md";
const CALLS: &str = "fuzz/src/calls";
const REFUSALS: &str = "tests/c/refusals.c";
const FIRST_DENT: &str = "examples-c/first_dent.c";
const FIRST_DENT_LINES: usize = 45;
/// Programs that a page shows whole: the program, the page and the language.
const SHOWN: &[(&str, &str, &str)] = &[
    (FIRST_DENT, "README.md", "c"),
    ("tests/csharp/Quickstart.cs", "bindings/unity/Runtime/README.md", "csharp"),
    ("bindings/python/examples/plot_dent.py", "bindings/python/README.md", "python"),
];

pub fn run(workspace: &Workspace, fix: bool) -> Result<()> {
    assets(workspace)?;
    quickstart(workspace)?;
    for (file, page, language) in SHOWN {
        shown(workspace, fix, file, page, language)?;
    }
    unity::metas(workspace, fix)?;
    manifests(workspace)?;
    changelog(workspace)?;
    unsafe_blocks(workspace, fix)?;
    dependencies::run(workspace, RELIABILITY, fix)?;
    called(workspace)?;
    messages::run(workspace)
}

/// The plugins' manifests name the workspace's version.
fn manifests(workspace: &Workspace) -> Result<()> {
    let version = &workspace.version;
    for (file, key) in [("bindings/unity/package.json", "version"), ("bindings/unreal/Crumple.uplugin", "VersionName")]
    {
        let entry = format!("\"{key}\": \"{version}\"");
        ensure!(read(workspace, file)?.contains(&entry), "{file} lacks {entry}, the workspace's");
    }
    println!("the plugins are of version {version}");
    Ok(())
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

fn quickstart(workspace: &Workspace) -> Result<()> {
    let lines = read(workspace, FIRST_DENT)?.lines().count();
    ensure!(
        lines < FIRST_DENT_LINES,
        "{FIRST_DENT} has {lines} lines; a first program should have under {FIRST_DENT_LINES}"
    );
    Ok(())
}

fn shown(workspace: &Workspace, fix: bool, file: &str, page: &str, language: &str) -> Result<()> {
    let (begin, end) = (format!("<!-- {file} -->\n```{language}\n"), format!("```\n<!-- end of {file} -->"));
    let (program, text) = (read(workspace, file)?, read(workspace, page)?);
    let (before, rest) = text.split_once(&begin).with_context(|| format!("{page} lacks the lines {begin:?}"))?;
    let (snippet, after) = rest.split_once(&end).with_context(|| format!("{page} lacks the lines {end:?}"))?;
    if snippet == program {
        println!("{page} shows {file} as it is");
    } else if fix {
        fs::write(workspace.path(page), [before, &begin, &program, &end, after].concat())?;
        println!("{page} shows the present {file}");
    } else {
        bail!("{page} shows another program than {file}; type: cargo xtask repo --fix");
    }
    Ok(())
}

fn changelog(workspace: &Workspace) -> Result<()> {
    let heading = format!("## [{}]", workspace.version);
    let found = read(workspace, "CHANGELOG.md")?.lines().any(|line| line.starts_with(&heading));
    ensure!(found, "CHANGELOG.md has no heading {heading:?} for this package's version");
    println!("CHANGELOG.md has a section for version {}", workspace.version);
    Ok(())
}

/// The table of docs/reliability.md names every room with `unsafe` blocks, and their number.
fn unsafe_blocks(workspace: &Workspace, fix: bool) -> Result<()> {
    let text = read(workspace, RELIABILITY)?;
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let mut wrong = Vec::new();
    for entry in fs::read_dir(workspace.path("src"))? {
        let path = entry?.path();
        let room = path.file_name().context("folders have names")?.to_string_lossy().into_owned();
        let mut blocks = 0;
        for file in if path.is_dir() { files(&path)? } else { Vec::new() } {
            blocks += fs::read_to_string(&file).unwrap_or_default().matches("unsafe {").count();
        }
        let row = lines.iter_mut().find(|line| line.starts_with(&format!("| {room} | ")));
        let told = row.as_ref().and_then(|row| row.split('|').nth(2)?.trim().parse().ok()).unwrap_or(0);
        if told != blocks {
            wrong.push(format!("{room} has {blocks}, not {told}"));
            if let Some(row) = row {
                *row = row.replacen(&format!("| {told} |"), &format!("| {blocks} |"), 1);
            }
        }
    }
    if fix && !wrong.is_empty() {
        fs::write(workspace.path(RELIABILITY), lines.join("\n") + "\n")?;
    } else {
        ensure!(wrong.is_empty(), "{RELIABILITY}, unsafe blocks: {wrong:?}; type: cargo xtask repo --fix");
    }
    println!("{RELIABILITY} has the number of unsafe blocks of each room");
    Ok(())
}

/// The fuzz target of the C interface calls every function of the headers. So does the test of refused memory, except those of
/// Vulkan, which need a device.
fn called(workspace: &Workspace) -> Result<()> {
    let items = declarations::header(&declarations::read(&workspace.path(declarations::INCLUDE))?)?;
    let functions: Vec<String> =
        items.into_iter().filter(|item| matches!(item.form, Form::Function { .. })).map(|item| item.name).collect();
    let mut fuzzed = String::new();
    for file in files(&workspace.path(CALLS))? {
        fuzzed.push_str(&fs::read_to_string(file)?);
    }
    // With the headers that it includes.
    let refusals = [REFUSALS, "tests/c/support.h", "tests/c/heap.h"].map(|path| read(workspace, path));
    let refusals: String = refusals.into_iter().collect::<Result<_>>()?;
    for (path, text, without) in [(CALLS, fuzzed, "\0"), (REFUSALS, refusals, "vulkan")] {
        let called = |name: &String| name.contains(without) || text.contains(&format!("{name}("));
        let missing: Vec<_> = functions.iter().filter(|name| !called(name)).collect();
        ensure!(missing.is_empty(), "{path} does not call {missing:?}");
        println!("{path} calls the functions of the headers");
    }
    Ok(())
}

fn read(workspace: &Workspace, path: &str) -> Result<String> {
    let text = fs::read_to_string(workspace.path(path)).with_context(|| format!("reading {path}"))?;
    Ok(text.replace("\r\n", "\n"))
}
