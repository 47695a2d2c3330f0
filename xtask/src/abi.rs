//! The binary interface: what the library exports, and what programs built against the last release rely on (`docs/abi.md`).

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use object::Object;
use xshell::cmd;

use crate::declarations::{self, Form, HEADER};
use crate::stage::Outcome;
use crate::workspace::Workspace;

/// Differences that abidiff does not report.
const SUPPRESSED: &str = "tests/abi/abidiff.suppressions";

/// Compares the header with that of the last tag, unless the SONAME differs.
pub fn stage(workspace: &Workspace) -> Result<Outcome> {
    let sh = &workspace.shell;
    let git = |arguments: &[&str]| {
        let trusted = "safe.directory=*"; // another user may own the checkout
        cmd!(sh, "git -c {trusted} {arguments...}").quiet().ignore_stderr().read()
    };
    let Ok(tag) = git(&["describe", "--tags", "--match", "v*", "--abbrev=0"]) else {
        return Ok(Outcome::NotApplicable("there is no tag v*, so no release to stay compatible with".into()));
    };
    if soname(&tag[1..]) != soname(&workspace.version) {
        return Ok(Outcome::NotApplicable(format!("the SONAME has changed since {tag}")));
    }
    let scratch = tempfile::tempdir()?;
    let (released, present) = (scratch.path().join("released"), scratch.path().join("present"));
    stand_in(workspace, &git(&["show", &format!("{tag}:{HEADER}")])?, &released)?;
    stand_in(workspace, &fs::read_to_string(workspace.path(HEADER))?, &present)?;
    let (known, released, present) =
        (workspace.path(SUPPRESSED), released.with_extension("so"), present.with_extension("so"));
    cmd!(sh, "abidiff --no-added-syms --suppressions {known} {released} {present}").quiet().run().with_context(
        || format!("programs built against {HEADER} of {tag} do not fit this one; docs/abi.md has the rules"),
    )?;
    println!("{HEADER} breaks nothing for programs built against {tag}");
    Ok(Outcome::Passed)
}

/// The part of the version that is in the SONAME.
fn soname(version: &str) -> Vec<&str> {
    let parts = version.split('.');
    if version.starts_with("0.") { parts.take(2).collect() } else { parts.take(1).collect() }
}

/// A shared library whose functions do nothing, with debug information about the header's types. abidiff cannot compare the libraries
/// themselves: their debug information is of lines alone.
fn stand_in(workspace: &Workspace, header: &str, at: &Path) -> Result<()> {
    let mut text = format!("{header}\n");
    for item in declarations::header(header)? {
        if matches!(item.form, Form::Function { .. }) {
            text += &format!("{} {{ for (;;) {{}} }}\n", item.text.trim_end_matches(';'));
        }
    }
    let (source, library) = (at.with_extension("c"), at.with_extension("so"));
    fs::write(&source, text)?;
    Ok(cmd!(workspace.shell, "cc -g -fPIC -shared {source} -o {library}").quiet().run()?)
}

/// The names that a shared library exports.
pub fn exports(shared: &Path) -> Result<Vec<String>> {
    let bytes = fs::read(shared).with_context(|| format!("reading {}", shared.display()))?;
    let file = object::File::parse(&*bytes)?;
    // Apple's format puts an underscore before every C name.
    let bare = usize::from(file.format() == object::BinaryFormat::MachO);
    let name = |export: &object::Export<'_>| String::from_utf8_lossy(&export.name()[bare..]).into_owned();
    Ok(file.exports()?.iter().map(name).collect())
}

/// A shared library exports the functions that a header declares, all of them and nothing else.
pub fn exported(header: &Path, shared: &Path) -> Result<()> {
    let names: BTreeSet<String> = exports(shared)?.into_iter().collect();
    let text = fs::read_to_string(header).with_context(|| format!("reading {}", header.display()))?;
    let functions = declarations::header(&text)?.into_iter().filter(|item| matches!(item.form, Form::Function { .. }));
    let declared: BTreeSet<String> = functions.map(|item| item.name).collect();
    let (header, shared) = (header.display(), shared.display());
    let foreign: Vec<_> = names.difference(&declared).collect();
    ensure!(foreign.is_empty(), "{shared} exports {foreign:?}, which {header} does not declare");
    let absent: Vec<_> = declared.difference(&names).collect();
    ensure!(absent.is_empty(), "{header} declares {absent:?}, which {shared} does not export");
    println!("{shared} exports the {} functions that the header declares, and nothing else", names.len());
    Ok(())
}

#[cfg(test)]
mod tests {
    #[test]
    fn before_1_0_the_minor_version_is_in_the_soname() {
        assert_eq!(super::soname("0.1.7"), ["0", "1"]);
        assert_eq!(super::soname("2.1.7"), ["2"]);
    }
}
