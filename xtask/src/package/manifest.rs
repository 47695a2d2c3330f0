//! `manifest.json`: the version, target, features and files of an archive, for programs.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use memchr::memmem;
use serde_json::{Value, json};
use sha2::{Digest, Sha256};

use crate::abi;
use crate::files::{bytes, files, within, write};
use crate::install::Built;
use crate::workspace::{VERSION, git, rustc_says};

pub const FILE: &str = "manifest.json";

/// Called last: the manifest lists every file but itself.
pub fn write_of(built: &Built, folder: &Path) -> Result<()> {
    let (flavour, linux) = (built.flavour, built.target.is_linux());
    let manifest = json!({
        "name": "crumple",
        "version": VERSION,
        "target": built.target.triple,
        "flavour": flavour.name,
        "features": flavour.library,
        "command": flavour.command,
        "soname": linux.then(|| abi::soname(VERSION)),
        "glibc": if linux { newest(&bytes(folder.join("lib/libcrumple.so"))?) } else { None },
        "rustc": rustc_says("release")?,
        "commit": git(&["rev-parse", "HEAD"])?.trim(),
        "files": entries(folder)?,
    });
    write(folder.join(FILE), serde_json::to_string_pretty(&manifest)? + "\n").context("writing the manifest")
}

/// What the manifest says of each file but itself. Symbolic links are not listed.
pub fn entries(folder: &Path) -> Result<Vec<Value>> {
    let entry = |path: &PathBuf| {
        let bytes = bytes(path)?;
        Ok(json!({"path": within(folder, path)?, "size": bytes.len(), "sha256": sha256(&bytes)}))
    };
    files(folder)?.iter().filter(|path| **path != folder.join(FILE)).map(entry).collect()
}

/// The oldest glibc that the shared library runs with: the newest version among its symbol versions.
fn newest(library: &[u8]) -> Option<String> {
    const PREFIX: &[u8] = b"GLIBC_2.";
    let minors = memmem::find_iter(library, PREFIX).filter_map(|at| {
        let mut parts = library[at + PREFIX.len()..].split(|byte| !byte.is_ascii_digit());
        std::str::from_utf8(parts.next()?).ok()?.parse().ok()
    });
    minors.max().map(|minor: u32| format!("2.{minor}"))
}

pub fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_newest_glibc_counts_by_its_number() {
        assert_eq!(super::newest(b"\0GLIBC_2.2.5\0GLIBC_2.34\0GLIBC_2.9\0GLIBC_PRIVATE\0"), Some("2.34".into()));
        assert_eq!(super::newest(b"none"), None);
    }
}
