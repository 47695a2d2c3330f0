//! The Unity package's `.meta` files: Unity tells assets apart by the number in them, so each asset's is written once and kept.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};

use crate::workspace::Workspace;

const PACKAGE: &str = "bindings/unity";

/// Native libraries, put there when the package is packed, and whether Unity loads them on startup. Their `.meta` files lie there before.
const PLUGINS: &[(&str, bool)] = &[
    ("libcrumple.so", false),
    ("libcrumple_unity.so", true),
    ("crumple.dll", false),
    ("crumple_unity.dll", true),
    ("libcrumple.dylib", false), // without a plugin: Unity draws with Metal there
];
const PLUGIN_FOLDER: &str = "Plugins/x86_64";

/// Every asset has a `.meta` file with a number of its own, and no `.meta` file is left over. With `fix`, missing ones are written.
pub fn metas(workspace: &Workspace, fix: bool) -> Result<()> {
    let root = workspace.path(PACKAGE);
    let mut assets = Vec::new();
    collect(&root, Path::new(""), &mut assets)?;
    let mut numbers: BTreeMap<String, String> = BTreeMap::new();
    let mut missing = Vec::new();
    for asset in &assets {
        let meta = root.join(format!("{asset}.meta"));
        if !meta.exists() {
            if !fix {
                missing.push(asset.as_str());
                continue;
            }
            fs::write(&meta, text(&root, asset)).with_context(|| format!("writing {}", meta.display()))?;
            println!("wrote {}", meta.display());
        }
        let number = number_in(&meta)?;
        if let Some(other) = numbers.insert(number.clone(), asset.clone()) {
            bail!("{PACKAGE}: {other} and {asset} have the same guid {number} in their .meta files");
        }
    }
    ensure!(missing.is_empty(), "{PACKAGE}: no .meta file for {}; type: cargo xtask repo --fix", missing.join(", "));
    let mut left_over = Vec::new();
    orphans(&root, Path::new(""), &assets, &mut left_over)?;
    ensure!(left_over.is_empty(), "{PACKAGE}: {} have no asset", left_over.join(", "));
    let manifest = fs::read_to_string(root.join("package.json"))?;
    let version = format!("\"version\": \"{}\"", workspace.version);
    ensure!(manifest.contains(&version), "{PACKAGE}/package.json lacks {version}, the workspace's");
    println!("{PACKAGE}: {} assets with .meta files, version {}", assets.len(), workspace.version);
    Ok(())
}

/// Paths below the package, with slashes, in order: files and folders that Unity sees.
fn collect(root: &Path, below: &Path, assets: &mut Vec<String>) -> Result<()> {
    for (name, folder) in entries(&root.join(below))? {
        let path = below.join(&name);
        if name.ends_with(".meta") || PLUGINS.iter().any(|(plugin, _)| *plugin == name) {
            continue;
        }
        assets.push(slashes(&path));
        if folder {
            collect(root, &path, assets)?;
        }
    }
    if slashes(below) == PLUGIN_FOLDER {
        assets.extend(PLUGINS.iter().map(|(plugin, _)| format!("{PLUGIN_FOLDER}/{plugin}")));
    }
    Ok(())
}

fn orphans(root: &Path, below: &Path, assets: &[String], found: &mut Vec<String>) -> Result<()> {
    for (name, folder) in entries(&root.join(below))? {
        let path = slashes(&below.join(&name));
        if folder {
            orphans(root, Path::new(&path), assets, found)?;
        } else if path.strip_suffix(".meta").is_some_and(|asset| !assets.iter().any(|known| known == asset)) {
            found.push(path);
        }
    }
    Ok(())
}

/// Unity does not look at names that end in ~ or begin with a dot.
fn entries(folder: &Path) -> Result<Vec<(String, bool)>> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).with_context(|| format!("looking into {}", folder.display()))? {
        let entry = entry?;
        let name = entry.file_name().to_string_lossy().into_owned();
        if !name.ends_with('~') && !name.starts_with('.') {
            found.push((name, entry.file_type()?.is_dir()));
        }
    }
    found.sort();
    Ok(found)
}

fn slashes(path: &Path) -> String {
    path.components().map(|part| part.as_os_str().to_string_lossy()).collect::<Vec<_>>().join("/")
}

fn number_in(meta: &PathBuf) -> Result<String> {
    let text = fs::read_to_string(meta).with_context(|| format!("reading {}", meta.display()))?;
    let number = text.lines().find_map(|line| line.strip_prefix("guid: ")).unwrap_or_default();
    let fits = number.len() == 32 && number.bytes().all(|byte| matches!(byte, b'0'..=b'9' | b'a'..=b'f'));
    ensure!(fits, "{} has no guid of 32 hexadecimal digits", meta.display());
    Ok(number.to_owned())
}

/// 128 bits of FNV-1a over the path: a number that no other asset has, and the same for whoever writes it.
fn number(asset: &str) -> String {
    let prime = (1 << 88) + 0x13b;
    let bytes = b"com.crumple.crumple/".iter().chain(asset.as_bytes());
    let hash = bytes.fold(0x6c62_272e_07bb_0142_62b8_2175_6295_c58d_u128, |hash, byte| {
        (hash ^ u128::from(*byte)).wrapping_mul(prime)
    });
    format!("{hash:032x}")
}

fn text(root: &Path, asset: &str) -> String {
    let importer = match asset.rsplit_once('.').map(|(_, extension)| extension) {
        _ if root.join(asset).is_dir() => "folderAsset: yes\nDefaultImporter:\n  externalObjects: {}\n".to_owned(),
        Some("cs") => "MonoImporter:\n  externalObjects: {}\n  serializedVersion: 2\n  defaultReferences: []\n  executionOrder: 0\n  icon: \
                       {instanceID: 0}\n"
            .to_owned(),
        Some("asmdef") => "AssemblyDefinitionImporter:\n  externalObjects: {}\n".to_owned(),
        Some("json") => "PackageManifestImporter:\n  externalObjects: {}\n".to_owned(),
        Some("md") => "TextScriptImporter:\n  externalObjects: {}\n".to_owned(),
        Some("so" | "dll" | "dylib") => plugin(asset),
        _ => "DefaultImporter:\n  externalObjects: {}\n".to_owned(),
    };
    let number = number(asset);
    format!(
        "fileFormatVersion: 2\nguid: {number}\n{importer}  userData: \n  assetBundleName: \n  assetBundleVariant: \n"
    )
}

/// On one system, in its editor and its players.
fn plugin(asset: &str) -> String {
    let preloaded = PLUGINS.iter().any(|(name, preloaded)| *preloaded && asset.ends_with(name));
    let (system, player) = match asset.rsplit_once('.') {
        Some((_, "so")) => ("Linux", "Linux64"),
        Some((_, "dll")) => ("Windows", "Win64"),
        _ => ("OSX", "OSXUniversal"),
    };
    let mut platforms = "  - first:\n      Any: \n    second:\n      enabled: 0\n      settings: {}\n".to_owned();
    platforms += &format!(
        "  - first:\n      Editor: Editor\n    second:\n      enabled: 1\n      settings:\n        CPU: x86_64\n        DefaultValueInitialized: \
         true\n        OS: {system}\n"
    );
    platforms += &format!(
        "  - first:\n      Standalone: {player}\n    second:\n      enabled: 1\n      settings:\n        CPU: x86_64\n"
    );
    format!(
        "PluginImporter:\n  externalObjects: {{}}\n  serializedVersion: 2\n  iconMap: {{}}\n  executionOrder: {{}}\n  defineConstraints: []\n  \
         isPreloaded: {}\n  isOverridable: 0\n  isExplicitlyReferenced: 0\n  validateReferences: 1\n  platformData:\n{platforms}",
        u8::from(preloaded)
    )
}

#[cfg(test)]
mod tests {
    use super::{number, slashes};
    use std::path::Path;

    #[test]
    fn numbers_are_those_of_fnv_1a() {
        // The empty text's hash is the offset itself; each path has its own.
        assert_eq!(number("Runtime"), number("Runtime"));
        assert_ne!(number("Runtime"), number("Editor"));
        assert_eq!(number("Runtime").len(), 32);
        assert_eq!(slashes(&Path::new("a").join("b.cs")), "a/b.cs");
    }
}
