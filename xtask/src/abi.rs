//! The binary interface: what the library exports, and what programs built against the last release rely on (`docs/abi.md`).

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use object::Object;

use crate::declarations::{self, HEADERS, INCLUDE, Item};
use crate::files::{bytes, files_of, read, write};
use crate::stage::LeftOut;
use crate::workspace::{VERSION, run};

/// Differences that abidiff does not report.
const SUPPRESSED: &str = "tests/abi/abidiff.suppressions";

/// The interfaces of the releases: the declarations of the headers, in files named after the versions.
const RELEASED: &str = "tests/abi";

/// Compares the headers with those of the last release of this SONAME.
pub fn stage() -> Result<()> {
    let mut releases = Vec::new();
    for path in files_of(RELEASED, &["h"])? {
        let version = path.file_stem().context("files have names")?.to_string_lossy().into_owned();
        if soname(&version) == soname(VERSION) {
            let numbers: Vec<u32> = version.split('.').filter_map(|number| number.parse().ok()).collect();
            releases.push((numbers, version, path));
        }
    }
    let Some((_, version, path)) = releases.into_iter().max() else {
        bail!(LeftOut::NotApplicable(format!("{RELEASED} has no release of version {VERSION}")));
    };
    let scratch = tempfile::tempdir()?;
    let released = stand_in(&read(&path)?, &scratch.path().join("released.so"))?;
    let present = stand_in(&interface()?, &scratch.path().join("present.so"))?;
    run!("abidiff --no-added-syms --suppressions {SUPPRESSED} {released} {present}").with_context(|| {
        format!("programs built against the headers of {version} do not fit these; docs/abi.md has the rules")
    })?;
    println!("the headers break nothing for programs built against {version}");
    Ok(())
}

/// Keeps the headers as those of a release of the present version.
pub fn keep() -> Result<()> {
    let file = format!("{RELEASED}/{VERSION}.h");
    write(&file, interface()?)?;
    println!("wrote {file}");
    Ok(())
}

/// The declarations of the headers in one file, without comments.
fn interface() -> Result<String> {
    let text = declarations::read(INCLUDE, &HEADERS)?;
    let left_out = |line: &str| line.is_empty() || line.starts_with("//") || line.starts_with("#include \"");
    let lines = text.lines().filter(|line| !left_out(line.trim_start()));
    Ok(lines.flat_map(|line| [line, "\n"]).collect())
}

/// The name under which programs load the library of a version: before 1.0 the minor version is in it. `build.rs` sets it.
pub fn soname(version: &str) -> String {
    let parts: Vec<&str> = version.split('.').take(if version.starts_with("0.") { 2 } else { 1 }).collect();
    format!("libcrumple.so.{}", parts.join("."))
}

/// A shared library whose functions do nothing, with debug information about the headers' types. abidiff cannot compare the libraries
/// themselves: their debug information is of lines alone.
fn stand_in(header: &str, library: &Path) -> Result<PathBuf> {
    let body = |item: Item| format!("{} {{ for (;;) {{}} }}\n", item.text.trim_end_matches(';'));
    let (bodies, source) = (declarations::functions(header)?.into_iter().map(body), library.with_extension("c"));
    write(&source, [header.to_owned(), "\n".to_owned()].into_iter().chain(bodies).collect::<String>())?;
    run!("cc -g -fPIC -shared {source} -o {library}")?;
    Ok(library.to_owned())
}

/// The names that a shared library exports.
pub fn exports(shared: &Path) -> Result<Vec<String>> {
    let bytes = bytes(shared)?;
    let file = object::File::parse(&*bytes)?;
    // Apple's format puts an underscore before every C name.
    let bare = usize::from(file.format() == object::BinaryFormat::MachO);
    let name = |export: &object::Export<'_>| String::from_utf8_lossy(&export.name()[bare..]).into_owned();
    Ok(file.exports()?.iter().map(name).collect())
}

/// A shared library exports the functions that the headers of a folder declare, all of them and nothing else.
pub fn exported(include: &Path, shared: &Path) -> Result<()> {
    let names: BTreeSet<String> = exports(shared)?.into_iter().collect();
    let declared = declarations::names(include)?;
    let (include, shared) = (include.display(), shared.display());
    let foreign: Vec<_> = names.difference(&declared).collect();
    ensure!(foreign.is_empty(), "{shared} exports {foreign:?}, which {include} does not declare");
    let absent: Vec<_> = declared.difference(&names).collect();
    ensure!(absent.is_empty(), "{include} declares {absent:?}, which {shared} does not export");
    println!("{shared} exports the {} functions that the headers declare, and nothing else", names.len());
    Ok(())
}

#[cfg(test)]
mod tests {
    #[test]
    fn before_1_0_the_minor_version_is_in_the_soname() {
        assert_eq!(super::soname("0.1.7"), "libcrumple.so.0.1");
        assert_eq!(super::soname("2.1.7"), "libcrumple.so.2");
    }
}
