//! `THIRD-PARTY-LICENSES.txt`: every package that is linked, and the full text of its license, each text once. cargo-about does the
//! same, but would add 150 packages to the build of this helper, and it does not look into the libraries (`paths::nothing_unlicensed`).

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};

use super::{Flavour, Parts};
use crate::command;
use crate::files::{copy, name, read, write};
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
    let (flavour, target) = (parts.flavour, &parts.library.target.triple);
    let mut lines = library_tree(workspace, flavour, target)?;
    if flavour.command {
        let command = ["--package", "crumple", "--target", target, "--features", command::FEATURES];
        lines.extend(tree(workspace, &command)?);
    }
    known(workspace, lines, &["--all-features"])
}

/// The packages that the flavour's library links on any system.
pub fn library(workspace: &Workspace, flavour: &Flavour) -> Result<Vec<Linked>> {
    known(workspace, library_tree(workspace, flavour, "all")?, &["--all-features"])
}

/// The packages that a binding of its own workspace links, for any of the targets.
pub fn linked_of(workspace: &Workspace, manifest: &Path, targets: &[Target]) -> Result<Vec<Linked>> {
    let manifest = ["--manifest-path", &manifest.to_string_lossy()];
    let mut lines = Vec::new();
    for target in targets {
        lines.extend(tree(workspace, &[&manifest[..], &["--target", &target.triple]].concat())?);
    }
    known(workspace, lines, &manifest)
}

fn library_tree(workspace: &Workspace, flavour: &Flavour, target: &str) -> Result<Vec<String>> {
    let features = flavour.library.join(",");
    tree(workspace, &["--package", "crumple", "--target", target, "--no-default-features", "--features", &features])
}

/// `NAME vVERSION` and a path for each package that `cargo tree` names.
fn tree(workspace: &Workspace, arguments: &[&str]) -> Result<Vec<String>> {
    let format = ["tree", "--edges", "normal,no-proc-macro", "--prefix", "none", "--format", "{p}"];
    let printed = workspace.cargo(&format).args(arguments).quiet().read()?;
    // Cargo marks packages that it has printed before.
    Ok(printed.lines().map(|line| line.trim_end_matches(" (*)").to_owned()).collect())
}

/// The packages of lines of `cargo tree`, with what `cargo metadata` knows of them. Ours are left out.
fn known(workspace: &Workspace, mut lines: Vec<String>, metadata: &[&str]) -> Result<Vec<Linked>> {
    lines.sort();
    lines.dedup();
    let packages = workspace.packages(metadata)?;
    let mut linked = Vec::new();
    for line in lines.iter().filter(|line| !line.starts_with("crumple")) {
        let mut words = line.split_whitespace();
        let (name, version) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
        let version = version.strip_prefix('v').with_context(|| format!("cargo tree says {line:?}"))?;
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

/// Writes the file into a folder, and the licenses of Rust's standard library beside it.
pub fn write_all(workspace: &Workspace, linked: &[Linked], folder: &Path) -> Result<()> {
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
    write(&folder.join(FILE), whole)?;
    let standard = workspace.sysroot()?.join("share/doc/rust/COPYRIGHT-library.html");
    copy(&standard, &folder.join(STANDARD_LIBRARY))
        .context("the licenses of Rust's standard library are missing: a toolchain of rustup's has them")
}

/// The license texts of a package: its own files, or the supplied text, or Apache's text if the package offers that license.
fn texts_of(package: &Linked, supplied: &Path, apache: &str) -> Result<Vec<String>> {
    let Linked { version, license, directory, .. } = package;
    let mut texts = Vec::new();
    let entries = fs::read_dir(directory).with_context(|| format!("reading {}", directory.display()))?;
    let mut files: Vec<PathBuf> = entries.map(|entry| Ok(entry?.path())).collect::<Result<_>>()?;
    files.sort();
    for file in files.iter().filter(|file| file.is_file()) {
        let name = name(file)?.to_lowercase();
        if BEGINNINGS.iter().any(|beginning| name.starts_with(beginning)) {
            texts.push(read(file)?);
        }
    }
    texts.retain(|text| !text.trim().is_empty());
    if !texts.is_empty() {
        return Ok(texts);
    }
    let own = &package.name;
    for supplied in [format!("{own}.txt"), format!("{license}.txt")].map(|file| supplied.join(file)) {
        if supplied.exists() {
            return Ok(vec![read(&supplied)?]);
        }
    }
    let offered: Vec<&str> = license.split(" OR ").flat_map(|part| part.split('/')).map(str::trim).collect();
    if offered.contains(&"Apache-2.0") {
        return Ok(vec![apache.to_owned()]);
    }
    bail!(
        "{own} {version} ({license}) is linked and was published without the text of its license; \
         put what its authors' repository has into {SUPPLIED}/{own}.txt"
    )
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
