//! Checks of the repository that build nothing: sizes, and programs, versions and messages that pages repeat.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use regex_lite::{Captures, Regex};

use crate::abi;
use crate::declarations::{self, INCLUDE};
use crate::files::{files, files_of, passage, read, renew, within, write};
use crate::package::licenses;
use crate::package::manifest::sha256;
use crate::workspace::VERSION;

/// The most bytes of meshes, fixtures and pictures together, of the lab's figures, which `cargo xtask lab` writes, and of its
/// reference data.
const LIMITS: &[(&[&str], u64)] =
    &[(&["assets", "docs/images", "tests"], 17_500_000), (&["docs/lab"], 15_000_000), (&["lab/data"], 14_000_000)];
const RELIABILITY: &str = "docs/reliability.md";
const CALLS: &str = "fuzz/src/calls";
const REFUSALS: &str = "tests/c/refusals.c";
/// It names the library that Unreal links on Linux.
const UNREAL_RULES: &str = "bindings/unreal/Source/ThirdParty/CrumpleLibrary/CrumpleLibrary.Build.cs";
const FIRST_DENT: &str = "examples-c/first_dent.c";
const FIRST_DENT_LINES: usize = 45;
/// Programs that a page shows whole: the program, the page and the language.
const SHOWN: &[(&str, &str, &str)] = &[
    (FIRST_DENT, "README.md", "c"),
    ("tests/csharp/Quickstart.cs", "bindings/unity/Runtime/README.md", "csharp"),
    ("bindings/python/examples/plot_dent.py", "bindings/python/README.md", "python"),
];

/// Each page, and the folder whose sources contain the messages that it quotes.
const QUOTING: &[(&str, &str)] = &[
    ("docs/troubleshooting.md", "src"),
    ("bindings/unity/Runtime/README.md", "bindings/unity/Runtime"),
    ("bindings/unity/Documentation~/index.md", "bindings/unity"),
];
/// The first head of tables that quote our messages. Tables with other heads quote other programs.
const QUOTES: &str = "| it says |";

const PACKAGE: &str = "bindings/unity";
/// Packing puts the native libraries here. Their `.meta` files are here before.
const PLUGINS: &str = "Plugins/x86_64/";

pub fn run(fix: bool) -> Result<()> {
    sizes()?;
    let lines = read(FIRST_DENT)?.lines().count();
    ensure!(lines < FIRST_DENT_LINES, "{FIRST_DENT}: {lines} lines; a first program has less than {FIRST_DENT_LINES}");
    for (file, page, language) in SHOWN {
        let (begin, end) = (format!("<!-- {file} -->\n```{language}\n"), format!("```\n<!-- end of {file} -->"));
        passage(fix, page, [&begin, &end], &read(file)?)?;
        println!("{page} shows {file} as it is");
    }
    metas(fix)?;
    versions()?;
    unsafe_blocks(fix)?;
    licenses::check_table(RELIABILITY, fix)?;
    called()?;
    messages()
}

/// The plugins' manifests and the changelog name the workspace's version.
fn versions() -> Result<()> {
    let version = VERSION;
    for (file, entry) in [
        ("bindings/unity/package.json", format!("\"version\": \"{version}\"")),
        ("bindings/unreal/Crumple.uplugin", format!("\"VersionName\": \"{version}\"")),
        ("bindings/blender/extension/blender_manifest.toml", format!("version = \"{version}\"")),
        ("bindings/godot/project/addons/crumple/plugin.cfg", format!("version=\"{version}\"")),
        ("CHANGELOG.md", format!("\n## [{version}]")),
        (UNREAL_RULES, format!("\"{}\"", abi::soname(version))),
    ] {
        ensure!(read(file)?.contains(&entry), "{file} lacks {entry:?}, the workspace's version");
    }
    println!("the plugins are of version {version}, and CHANGELOG.md has a section for it");
    Ok(())
}

/// Every clone carries these folders.
fn sizes() -> Result<()> {
    for (folders, limit) in LIMITS {
        let all = folders.iter().map(files).collect::<Result<Vec<_>>>()?.concat();
        let total = all.iter().map(|file| Ok(fs::metadata(file)?.len())).sum::<Result<u64>>()?;
        let folders = folders.join(", ");
        ensure!(
            total < *limit,
            "{folders}: {total} bytes; at most {limit} are allowed, since every clone carries them"
        );
        println!("{folders}: {:.1} MB of {} allowed", total as f64 / 1e6, limit / 1_000_000);
    }
    Ok(())
}

/// The table of docs/reliability.md names every room with `unsafe` blocks, and their number.
fn unsafe_blocks(fix: bool) -> Result<()> {
    let mut blocks: BTreeMap<String, usize> = BTreeMap::new();
    for file in files_of("src", &["rs"])? {
        if let Some((room, _)) = within(Path::new("src"), &file)?.split_once('/') {
            *blocks.entry(room.to_owned()).or_default() += read(&file)?.matches("unsafe {").count();
        }
    }
    blocks.retain(|_, blocks| *blocks > 0);
    let whole = read(RELIABILITY)?;
    let row = |found: &Captures<'_>| match blocks.get(&found[1]) {
        Some(blocks) => format!("| {} | {blocks} |", &found[1]),
        None => found[0].to_owned(),
    };
    let right = Regex::new(r"(?m)^\| (\w+) \| \d+ \|")?.replace_all(&whole, row);
    let absent: Vec<_> = blocks.keys().filter(|room| !right.contains(&format!("\n| {room} | "))).collect();
    ensure!(absent.is_empty(), "{RELIABILITY} has no row for the unsafe blocks of {absent:?}");
    renew(fix, RELIABILITY, &whole, &right)?;
    println!("{RELIABILITY} has the number of unsafe blocks of each room");
    Ok(())
}

/// The fuzz target of the C interface calls every function of the headers. So does the test of refused memory, except those of
/// Vulkan, which need a device.
fn called() -> Result<()> {
    let functions = declarations::names(INCLUDE)?;
    let fuzzed = files(CALLS)?.iter().map(read).collect::<Result<String>>()?;
    // With the headers that it includes.
    let refusals =
        [REFUSALS, "tests/c/support.h", "tests/c/heap.h"].into_iter().map(read).collect::<Result<String>>()?;
    for (path, text, without) in [(CALLS, fuzzed, "\0"), (REFUSALS, refusals, "vulkan")] {
        let called = |name: &str| name.contains(without) || text.contains(&format!("{name}("));
        let missing: Vec<_> = functions.iter().filter(|name| !called(name)).collect();
        ensure!(missing.is_empty(), "{path} does not call {missing:?}");
        println!("{path} calls the functions of the headers");
    }
    Ok(())
}

/// The messages that docs quote exist in the sources.
fn messages() -> Result<()> {
    let continued = Regex::new(r"\\\n\s*")?;
    for (page, sources) in QUOTING {
        let (text, mut source) = (read(page)?, String::new());
        for file in files_of(sources, &["rs", "cs", "cpp", "h", "c"])? {
            // Continued lines of a string are joined as the compiler joins them.
            source += &continued.replace_all(&read(&file)?, "");
        }
        let quoted = quoted(&text);
        let unknown: Vec<&&str> = quoted.iter().filter(|quote| !source.contains(**quote)).collect();
        ensure!(unknown.is_empty(), "{page} quotes {unknown:?}, which no source in {sources} contains");
        println!("{page} quotes {} pieces of messages; all exist", quoted.len());
    }
    Ok(())
}

/// The text in backticks in the first column of our tables.
fn quoted(page: &str) -> Vec<&str> {
    let (mut within, mut found) = (false, Vec::new());
    for line in page.lines() {
        let head = line.starts_with(QUOTES);
        within = head || within && line.starts_with('|');
        let cell = line.split('|').nth(1).filter(|_| within && !head).unwrap_or_default();
        found.extend(cell.split('`').skip(1).step_by(2));
    }
    found
}

/// Checks that every asset has a `.meta` file with a guid of its own, and that every `.meta` file has an asset. With `fix`, writes
/// missing ones.
fn metas(fix: bool) -> Result<()> {
    let root = Path::new(PACKAGE);
    let mut names = BTreeSet::new();
    for file in files(root)? {
        let path = within(root, &file)?;
        // Unity does not look at names that end in ~ or begin with a dot.
        if !path.split('/').any(|name| name.ends_with('~') || name.starts_with('.')) {
            names.extend(path.match_indices('/').map(|(end, _)| path[..end].to_owned()));
            names.insert(path);
        }
    }
    let (mut guids, mut missing) = (BTreeMap::new(), Vec::new());
    for asset in names.iter().filter(|name| !name.ends_with(".meta")) {
        let path = root.join(format!("{asset}.meta"));
        if !path.exists() && !fix {
            missing.push(asset.as_str());
            continue;
        }
        if !path.exists() {
            // No other asset has this guid, and it is the same for whoever writes it. Unity adds the importer's settings when it first sees
            // the asset.
            let guid = &sha256(format!("com.crumple.crumple/{asset}").as_bytes())[..32];
            write(&path, format!("fileFormatVersion: 2\nguid: {guid}\n"))?;
            println!("wrote {}", path.display());
        }
        let (text, form) = (read(&path)?, Regex::new("(?m)^guid: ([0-9a-f]{32})$")?);
        let guid = form.captures(&text).with_context(|| format!("{} has no guid of 32 digits", path.display()))?;
        if let Some(other) = guids.insert(guid[1].to_owned(), asset) {
            bail!("{PACKAGE}: {other} and {asset} have the same guid in their .meta files");
        }
    }
    ensure!(missing.is_empty(), "{PACKAGE}: no .meta file for {}; type: cargo xtask repo --fix", missing.join(", "));
    let metas = names.iter().filter_map(|name| name.strip_suffix(".meta"));
    let orphans: Vec<&str> = metas.filter(|asset| !names.contains(*asset) && !asset.starts_with(PLUGINS)).collect();
    ensure!(orphans.is_empty(), "{PACKAGE}: {} have .meta files and are not there", orphans.join(", "));
    println!("{PACKAGE}: {} assets with .meta files", guids.len());
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::quoted;

    #[test]
    fn only_the_first_column_of_tables_of_messages_counts() {
        let page =
            "`a`\n| it says | why |\n|---|---|\n| `b` … `c` | `d` |\n\n| you see | why |\n|---|---|\n| `e` | |\n";
        assert_eq!(quoted(page), ["b", "c"]);
    }
}
