//! The `.meta` files of the Unity package: Unity tells assets apart by the guid in them, so each is written once and kept.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::{Result, bail, ensure};

use crate::files::{files, read, within, write};
use crate::workspace::Workspace;

const PACKAGE: &str = "bindings/unity";
/// Packing puts the native libraries here. Their `.meta` files are here before.
const PLUGINS: &str = "Plugins/x86_64/";

/// Checks that every asset has a `.meta` file with a guid of its own, and that every `.meta` file has an asset. With `fix`, writes
/// missing ones.
pub fn metas(workspace: &Workspace, fix: bool) -> Result<()> {
    let root = workspace.path(PACKAGE);
    let mut names = BTreeSet::new();
    for file in files(&root)? {
        let path = within(&root, &file)?;
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
            // Unity adds the importer's settings when it first sees the asset.
            let text = format!("fileFormatVersion: 2\nguid: {}\n", guid_of(asset));
            write(&path, text)?;
            println!("wrote {}", path.display());
        }
        let text = read(&path)?;
        let guid = text.lines().find_map(|line| line.strip_prefix("guid: ")).unwrap_or_default().to_owned();
        let fits = guid.len() == 32 && guid.bytes().all(|byte| matches!(byte, b'0'..=b'9' | b'a'..=b'f'));
        ensure!(fits, "{} has no guid of 32 hexadecimal digits", path.display());
        if let Some(other) = guids.insert(guid, asset) {
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

/// 128 bits of FNV-1a over the path: no other asset has it, and it is the same for whoever writes it.
fn guid_of(asset: &str) -> String {
    let prime = (1 << 88) + 0x13b;
    let bytes = b"com.crumple.crumple/".iter().chain(asset.as_bytes());
    let hash = bytes.fold(0x6c62_272e_07bb_0142_62b8_2175_6295_c58d_u128, |hash, byte| {
        (hash ^ u128::from(*byte)).wrapping_mul(prime)
    });
    format!("{hash:032x}")
}
