//! `THIRD-PARTY-LICENSES.txt`: every package that is linked, and the full text of its license, each text once. cargo-about does the
//! same, but would add 150 packages to the build of this helper, and it does not look into the libraries (`paths::nothing_unlicensed`).

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use serde_json::Value;

use super::{Flavour, Parts};
use crate::command;
use crate::target::Target;
use crate::workspace::Workspace;

pub const FILE: &str = "THIRD-PARTY-LICENSES.txt";
/// The licenses of Rust's standard library, from Rust's distribution.
pub const STANDARD_LIBRARY: &str = "RUST-STANDARD-LIBRARY-LICENSES.html";
/// `NAME.txt`: license texts from the repositories of packages that were published without one, and `LICENSE.txt`: texts that are
/// the same for everyone.
const SUPPLIED: &str = "xtask/package/licenses";
/// The names of files with license texts begin with these.
const BEGINNINGS: &[&str] = &["license", "licence", "copying", "unlicense", "notice", "copyright"];
const TREE: &[&str] = &["tree", "--edges", "normal,no-proc-macro", "--prefix", "none", "--format", "{p}"];
const RULE: &str = "================================================================================";

/// A package whose code is in the archive.
pub struct Linked {
    pub name: String,
    pub version: String,
    /// The SPDX expression.
    pub license: String,
    /// Where its sources are kept.
    pub repository: String,
    pub from_crates_io: bool,
    /// The folder of its sources.
    pub directory: PathBuf,
}

/// The packages that the flavour's library and command link. Procedural macros and build dependencies are not among them.
pub fn linked(workspace: &Workspace, parts: &Parts) -> Result<Vec<Linked>> {
    let flavour = parts.flavour;
    let library = flavour.library.join(",");
    let mut lines = tree(workspace, &parts.library.target.triple, &["--no-default-features", "--features", &library])?;
    if flavour.command {
        lines.extend(tree(workspace, &parts.library.target.triple, &["--features", command::FEATURES])?);
    }
    known(lines, workspace.cargo(&["metadata", "--format-version", "1", "--all-features"]))
}

/// The packages that the flavour's library links on any system.
pub fn library(workspace: &Workspace, flavour: &Flavour) -> Result<Vec<Linked>> {
    let features = flavour.library.join(",");
    let lines = tree(workspace, "all", &["--no-default-features", "--features", &features])?;
    known(lines, workspace.cargo(&["metadata", "--format-version", "1", "--all-features"]))
}

/// The packages that a binding of its own workspace links, for any of the targets.
pub fn linked_of(workspace: &Workspace, manifest: &Path, targets: &[Target]) -> Result<Vec<Linked>> {
    let manifest = manifest.display().to_string();
    let manifest = ["--manifest-path", &manifest];
    let mut lines = Vec::new();
    for target in targets {
        let printed = workspace.cargo(TREE).args(manifest).args(["--target", &target.triple]).quiet().read()?;
        lines.extend(printed.lines().map(without_mark));
    }
    known(lines, workspace.cargo(&["metadata", "--format-version", "1"]).args(manifest))
}

/// The packages of lines of `cargo tree`, with what `cargo metadata` knows of them. Ours are left out.
fn known(mut lines: Vec<String>, metadata: xshell::Cmd<'_>) -> Result<Vec<Linked>> {
    lines.sort();
    lines.dedup();
    let metadata = metadata.quiet().read()?;
    let metadata: Value = serde_json::from_str(&metadata).context("reading what cargo metadata says")?;
    let packages = metadata["packages"].as_array().context("cargo metadata lists packages")?;
    let mut linked = Vec::new();
    for line in &lines {
        let mut words = line.split_whitespace();
        let (name, version) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
        let version = version.strip_prefix('v').with_context(|| format!("cargo tree says {line:?}"))?;
        if name == "crumple" || name == "crumple-godot" {
            continue;
        }
        let package = packages.iter().find(|package| package["name"] == name && package["version"] == version);
        let package = package.with_context(|| format!("cargo metadata does not know {name} {version}"))?;
        let manifest = Path::new(package["manifest_path"].as_str().context("packages have manifests")?);
        linked.push(Linked {
            name: name.to_owned(),
            version: version.to_owned(),
            license: package["license"].as_str().unwrap_or("see its text").to_owned(),
            repository: package["repository"].as_str().unwrap_or("unknown").to_owned(),
            from_crates_io: package["source"] == "registry+https://github.com/rust-lang/crates.io-index",
            directory: manifest.parent().context("manifests lie somewhere")?.to_path_buf(),
        });
    }
    ensure!(linked.len() > 10, "cargo tree names {} packages that are linked; that cannot be all", linked.len());
    Ok(linked)
}

fn tree(workspace: &Workspace, target: &str, features: &[&str]) -> Result<Vec<String>> {
    let printed =
        workspace.cargo(TREE).args(["--package", "crumple", "--target", target]).args(features).quiet().read()?;
    Ok(printed.lines().map(without_mark).collect())
}

/// Cargo marks packages that it has printed before.
fn without_mark(line: &str) -> String {
    line.trim_end_matches(" (*)").to_owned()
}

/// Writes the file, and the licenses of Rust's standard library beside it.
pub fn write(workspace: &Workspace, linked: &[Linked], to: &Path) -> Result<()> {
    let apache = read(&workspace.path("LICENSE-APACHE"))?;
    let mut texts: Vec<(String, Vec<String>)> = Vec::new();
    let mut by_words: BTreeMap<Vec<String>, usize> = BTreeMap::new();
    let mut list = String::new();
    for package in linked {
        let title = format!("{} {}", package.name, package.version);
        let mut numbers = Vec::new();
        for text in texts_of(package, &workspace.path(SUPPLIED), &apache)? {
            // Texts that differ only in line breaks are one text.
            let words: Vec<String> = text.split_whitespace().map(str::to_owned).collect();
            let number = *by_words.entry(words).or_insert_with(|| {
                texts.push((text, Vec::new()));
                texts.len()
            });
            texts[number - 1].1.push(title.clone());
            numbers.push(number.to_string());
        }
        list += &format!("  {title:44} {:40} {}\n", package.license, numbers.join(", "));
    }
    let mut whole = format!(
        "What Crumple {} is linked with beside Rust's standard library ({STANDARD_LIBRARY}):\n\
         package, its license, and the numbers of the texts below.\n\n{list}",
        workspace.version
    );
    for (number, (text, of)) in texts.iter().enumerate() {
        whole += &format!("\n{RULE}\n{}: {}\n{RULE}\n\n{}\n", number + 1, of.join(", "), text.trim_end());
    }
    fs::write(to, whole).with_context(|| format!("writing {}", to.display()))?;

    let said = workspace.sysroot()?.join("share/doc/rust/COPYRIGHT-library.html");
    let standard = to.with_file_name(STANDARD_LIBRARY);
    fs::copy(&said, standard).with_context(|| {
        format!(
            "{}, the licenses of Rust's standard library, is missing: a toolchain of rustup's has it",
            said.display()
        )
    })?;
    Ok(())
}

/// The license texts of a package: its own files, or the supplied text, or Apache's text if the package offers that license.
fn texts_of(package: &Linked, supplied: &Path, apache: &str) -> Result<Vec<String>> {
    let Linked { name, version, license, directory, .. } = package;
    let mut found = Vec::new();
    for entry in fs::read_dir(directory).with_context(|| format!("reading {}", directory.display()))? {
        let entry = entry?;
        let file = entry.file_name().to_string_lossy().to_lowercase();
        if entry.path().is_file() && BEGINNINGS.iter().any(|beginning| file.starts_with(beginning)) {
            found.push(entry.path());
        }
    }
    found.sort();
    let mut texts = found.iter().map(|path| read(path)).collect::<Result<Vec<_>>>()?;
    texts.retain(|text| !text.trim().is_empty());
    if !texts.is_empty() {
        return Ok(texts);
    }
    for supplied in [format!("{name}.txt"), format!("{license}.txt")].map(|file| supplied.join(file)) {
        if supplied.exists() {
            return Ok(vec![read(&supplied)?]);
        }
    }
    let offered: Vec<&str> = license.split(" OR ").flat_map(|part| part.split('/')).map(str::trim).collect();
    if offered.contains(&"Apache-2.0") {
        return Ok(vec![apache.to_owned()]);
    }
    bail!(
        "{name} {version} ({license}) is linked and was published without the text of its license; \
         put what its authors' repository has into {SUPPLIED}/{name}.txt"
    )
}

fn read(path: &Path) -> Result<String> {
    let bytes = fs::read(path).with_context(|| format!("reading {}", path.display()))?;
    Ok(String::from_utf8_lossy(&bytes).replace("\r\n", "\n"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(license: &str, files: &[(&str, &str)]) -> Result<Vec<String>> {
        let scratch = tempfile::tempdir().unwrap();
        let directory = scratch.path().join("denty-1.2.0");
        fs::create_dir(&directory).unwrap();
        for (name, text) in files {
            fs::write(directory.join(name), text).unwrap();
        }
        let (name, version, repository) = ("denty".into(), "1.2.0".into(), String::new());
        let package = Linked { name, version, license: license.into(), repository, from_crates_io: true, directory };
        texts_of(&package, scratch.path(), "the Apache text")
    }

    #[test]
    fn a_packages_own_texts_come_first() {
        let files = [("LICENSE-MIT", "mit"), ("COPYING", "copy"), ("lib.rs", "no"), ("NOTICE", " ")];
        assert_eq!(texts("MIT OR Apache-2.0", &files).unwrap(), ["copy", "mit"]);
    }

    #[test]
    fn a_package_without_a_text_is_used_under_apache_where_it_may_be() {
        for license in ["MIT OR Apache-2.0", "Zlib OR Apache-2.0 OR MIT", "Apache-2.0", "MIT/Apache-2.0"] {
            assert_eq!(texts(license, &[]).unwrap(), ["the Apache text"]);
        }
        for license in ["MIT", "Apache-2.0 AND MIT", "Apache-2.0 WITH LLVM-exception"] {
            let error = texts(license, &[]).unwrap_err().to_string();
            assert!(error.contains("denty 1.2.0") && error.contains("denty.txt"), "{error}");
        }
    }
}
