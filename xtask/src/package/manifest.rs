//! `manifest.json`: what an archive is and what is in it, for programs.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result};
use serde_json::{Value, json};
use sha2::{Digest, Sha256};

use super::{Parts, files, git, within};
use crate::install;
use crate::workspace::Workspace;

pub const FILE: &str = "manifest.json";

/// Written last: it names every file but itself. Symbolic links are not files.
pub fn write(workspace: &Workspace, parts: &Parts, folder: &Path) -> Result<()> {
    let flavour = parts.flavour;
    let mut entries = Vec::new();
    for path in files(folder)? {
        let bytes = fs::read(&path).with_context(|| format!("reading {}", path.display()))?;
        entries.push(json!({"path": within(folder, &path)?, "size": bytes.len(), "sha256": sha256(&bytes)}));
    }
    let manifest = json!({
        "name": "crumple",
        "version": workspace.version,
        "target": parts.target,
        "flavour": flavour.name,
        "features": flavour.library,
        "command": flavour.command,
        "soname": if cfg!(target_os = "linux") { Value::from(install::soname(&parts.library.shared)?) } else { Value::Null },
        "rustc": workspace.rustc("release")?,
        "commit": git(workspace, &["rev-parse", "HEAD"])?.trim(),
        "files": entries,
    });
    let text = serde_json::to_string_pretty(&manifest)? + "\n";
    fs::write(folder.join(FILE), text).context("writing the manifest")
}

pub fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    #[test]
    fn digests_are_sha_256() {
        // FIPS 180-4's own example.
        let digest = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(super::sha256(b"abc"), digest);
    }
}
