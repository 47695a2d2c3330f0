//! `cargo xtask abi`: what a program built against the header relies on, written down, compared in CI (`docs/abi.md` has the rules).

mod declarations;
mod layout;
mod table;

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use object::Object;
use xshell::cmd;

use crate::native::{self, Build};
use crate::stage::Outcome;
use crate::workspace::Workspace;
use declarations::Declaration;
use table::Table;

/// The present state. Its name has the part of the version that a program depends on; `build.rs` puts it into the SONAME.
const COMMITTED: &str = "docs/abi/crumple-0.1.abi";
const HEADER: &str = "include/crumple.h";
/// The first header of this SONAME. It is never changed: what was built against it must run for as long as the SONAME lasts.
const FIRST: &str = "tests/abi/0.1.0/crumple.h";
/// What abidiff is not to mention.
const SUPPRESSED: &str = "tests/abi/abidiff.suppressions";

/// Writes what the present header says, or compares it.
pub fn run(workspace: &Workspace, check: bool) -> Result<()> {
    let present = layout::of(workspace, &workspace.path(HEADER), "cc")?;
    kept(workspace, &present)?;
    let path = workspace.path(COMMITTED);
    if !check {
        fs::write(&path, present.to_text()).with_context(|| format!("writing {COMMITTED}"))?;
        println!("wrote {COMMITTED}");
        return Ok(());
    }
    let committed = fs::read_to_string(&path).with_context(|| format!("reading {COMMITTED}"))?;
    let changes = Table::from_text(&committed).changes(&present);
    changes.print(COMMITTED);
    ensure!(changes.is_empty(), "{COMMITTED} is not what {HEADER} says; when that is meant, type: cargo xtask abi");
    println!("{COMMITTED} is what {HEADER} says");
    Ok(())
}

/// Everything that the first header says still holds.
fn kept(workspace: &Workspace, present: &Table) -> Result<()> {
    let first = layout::of(workspace, &workspace.path(FIRST), "cc")?;
    let breaks = first.changes(present).breaks();
    breaks.print(FIRST);
    if !breaks.is_empty() {
        bail!(
            "programs that were built against {FIRST} do not fit any more. Undo that: docs/abi.md says how things grow. \
             Or raise the minor version, which changes the library's SONAME, and begin anew with the header of then"
        );
    }
    println!("all {} facts of {FIRST} hold", first.len());
    Ok(())
}

/// The table, from C and from C++, and programs of the first header on the library of today.
pub fn stage(workspace: &Workspace) -> Result<Outcome> {
    run(workspace, true)?;
    let header = workspace.path(HEADER);
    let differ = layout::of(workspace, &header, "cc")?.changes(&layout::of(workspace, &header, "c++")?);
    differ.print("what C says");
    ensure!(differ.is_empty(), "C and C++ understand {HEADER} differently");
    println!("C++ says the same as C");

    second_opinion(workspace)?;
    old_programs(workspace, &native::release_prefix(workspace))?;
    Ok(Outcome::Passed)
}

/// A shared library exports what a header declares, all of it and nothing else.
pub fn exported(header: &Path, shared: &Path) -> Result<()> {
    let bytes = fs::read(shared).with_context(|| format!("reading {}", shared.display()))?;
    let file = object::File::parse(&*bytes)?;
    // Apple's format puts an underscore before every C name.
    let bare = if cfg!(target_os = "macos") { 1 } else { 0 };
    let exports = file.exports()?;
    let names: BTreeSet<String> =
        exports.iter().map(|export| String::from_utf8_lossy(&export.name()[bare..]).into_owned()).collect();
    let declared = functions(header)?;
    let foreign: Vec<_> = names.difference(&declared).collect();
    ensure!(
        foreign.is_empty(),
        "{} exports {foreign:?}, which {} does not declare",
        shared.display(),
        header.display()
    );
    let absent: Vec<_> = declared.difference(&names).collect();
    ensure!(absent.is_empty(), "{} declares {absent:?}, which {} does not export", header.display(), shared.display());
    println!("{} names exported, those that the header declares", names.len());
    Ok(())
}

/// Names of the functions that a header declares.
pub fn functions(header: &Path) -> Result<BTreeSet<String>> {
    Ok(declarations::of(header)?.into_iter().filter_map(Declaration::into_function).collect())
}

/// libabigail compares the headers by itself, as libraries whose functions do nothing. The library cannot be compared so: its debug
/// information is of lines alone, and Rust's.
fn second_opinion(workspace: &Workspace) -> Result<()> {
    let scratch = tempfile::tempdir()?;
    let (first, present) = (scratch.path().join("first.so"), scratch.path().join("present.so"));
    layout::stand_in(workspace, &workspace.path(FIRST), &first)?;
    layout::stand_in(workspace, &workspace.path(HEADER), &present)?;
    let known = workspace.path(SUPPRESSED);
    let same = cmd!(workspace.shell, "abidiff --no-added-syms --suppressions {known} {first} {present}").quiet().run();
    same.with_context(|| format!("abidiff finds that {HEADER} breaks programs of {FIRST}"))?;
    println!("abidiff finds nothing that breaks programs of {FIRST}");
    Ok(())
}

/// Compiles programs against the first header, and runs them with the library of today.
fn old_programs(workspace: &Workspace, prefix: &Path) -> Result<()> {
    let directory = workspace.target.join("ctest/abi");
    native::compile(workspace, &Build::new("abi", prefix), &workspace.path("tests/abi"), &directory)?;
    Ok(cmd!(workspace.shell, "ctest --test-dir {directory} --parallel 2 --output-on-failure --no-tests=error").run()?)
}
