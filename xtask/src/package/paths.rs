//! Checks that an archive contains no path of this machine and no code without its license.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use anyhow::{Result, bail, ensure};
use memchr::memmem;

use super::Parts;
use super::licenses::Linked;
use crate::files::{bytes, files, name};
use crate::workspace::{self, Workspace};

/// Fails if a file contains the path of a folder of this machine.
pub fn nothing_of_this_machine(workspace: &Workspace, files: &[PathBuf]) -> Result<()> {
    let known = [workspace.root.clone(), workspace.target.clone(), workspace::cargo_home()?, workspace.sysroot()?];
    for file in files {
        let bytes = bytes(file)?;
        for path in known.iter().map(|path| path.to_string_lossy()) {
            let found = memmem::find(&bytes, path.as_bytes());
            ensure!(found.is_none(), "{} names {path}, a folder of this machine", file.display());
        }
    }
    Ok(())
}

fn separator(byte: &u8) -> bool {
    b"/\\".contains(byte)
}

/// Fails if a library contains code of a package that is neither in `linked` nor, as `NAME-VERSION`, in `standard`. The
/// source paths in panic messages name the packages. The tests' debug build of the command has the tests' features.
pub fn nothing_unlicensed(parts: &Parts, folder: &Path, linked: &[Linked], standard: &[String]) -> Result<()> {
    let linked = linked.iter().map(|package| format!("{}-{}", package.name, package.version));
    let known: BTreeSet<String> = linked.chain(standard.iter().cloned()).collect();
    let mut libraries = 0;
    let all = files(&folder.join("lib"))?.into_iter().chain(files(&folder.join("bin")).unwrap_or_default());
    for file in all {
        if !parts.handed_out && name(&file)? == parts.library.target.program("crumple") {
            continue;
        }
        let bytes = bytes(&file)?;
        let mut named = 0;
        for at in memmem::find_iter(&bytes, workspace::SOURCES) {
            let Some((first, rest)) = bytes[at + workspace::SOURCES.len()..].split_first() else { continue };
            let end = rest.iter().take(100).position(separator);
            let Some(end) = end.filter(|_| separator(first)) else { continue };
            let package = String::from_utf8_lossy(&rest[..end]);
            if !known.contains(&*package) {
                bail!("{} holds code of {package}, which cargo tree does not say it is linked with", file.display());
            }
            named += 1;
        }
        libraries += usize::from(named > 0);
    }
    ensure!(libraries > 0, "no library names a source in {}: was it built for this?", workspace::SOURCES);
    Ok(())
}
