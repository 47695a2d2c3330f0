//! `THIRD-PARTY-LICENSES.txt`: every package that is linked, and the full text of its license, each text once. cargo-about does the
//! same, but would add 150 packages to the build of this helper, and it does not look into the libraries. The table of docs/reliability.md
//! with all of them, and what must hold for them: cargo-deny checks the same and more, but takes longer to build than this repository.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use memchr::memmem;

use crate::command;
use crate::files::{bytes, copy, files, files_of, name, passage, read, write};
use crate::install::{Built, FULL, Flavour, SLIM};
use crate::target::Target;
use crate::workspace::{SOURCES, VERSION, in_root, packages, said, sysroot};

pub const FILE: &str = "THIRD-PARTY-LICENSES.txt";
/// The licenses of Rust's standard library, from Rust's distribution.
pub const STANDARD_LIBRARY: &str = "RUST-STANDARD-LIBRARY-LICENSES.html";
/// `REPOSITORY.txt`: license texts from the repositories of packages that were published without one.
const SUPPLIED: &str = "xtask/package/licenses";
/// The names of files with license texts begin with these.
const BEGINNINGS: &[&str] = &["license", "licence", "copying", "unlicense", "notice", "copyright"];
const RULE: &str = "================================================================================";

/// Around the table of docs/reliability.md with every package that the C library links.
const BEGIN: &str = "<!-- written by cargo xtask repo --fix -->\n";
const END: &str = "<!-- end -->\n";
/// Licenses under which everyone may ship a library, each with its text.
const ALLOWED: &[&str] = &["Apache-2.0", "BSD-2-Clause", "BSD-3-Clause", "MIT", "Zlib"];

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
    pub folder: PathBuf,
}

/// The packages that the flavour's library and command link. Procedural macros and build dependencies are not among them.
pub fn linked(built: &Built) -> Result<Vec<Linked>> {
    let target = built.target.triple.as_str();
    let (library, command) =
        (library_tree(built.flavour), format!("--package crumple --features {}", command::FEATURES));
    let trees = [library, command].into_iter().take(if built.flavour.command { 2 } else { 1 });
    known(trees.map(|tree| tree + " --target " + target), "--all-features")
}

/// The packages that the flavour's library links on any system.
fn library(flavour: &Flavour) -> Result<Vec<Linked>> {
    known([library_tree(flavour) + " --target all"].into_iter(), "--all-features")
}

fn library_tree(flavour: &Flavour) -> String {
    format!("--package crumple --no-default-features --features {}", flavour.library.join(","))
}

/// The packages that a binding of its own workspace, in a folder, links for any of the targets.
pub fn linked_of(binding: &str, targets: &[Target]) -> Result<Vec<Linked>> {
    let manifest = format!("--manifest-path {binding}/Cargo.toml");
    known(targets.iter().map(|target| format!("{manifest} --target {}", target.triple)), &manifest)
}

/// The packages that calls of `cargo tree` name, with what `cargo metadata` knows of them. Ours are left out.
fn known(trees: impl Iterator<Item = String>, metadata: &str) -> Result<Vec<Linked>> {
    let mut lines = BTreeSet::new();
    for tree in trees {
        let (edges, form, arguments) = ("normal,no-proc-macro", "{p}", tree.split(' '));
        let printed = said!("cargo tree --edges {edges} --prefix none --format {form} {arguments...}")?;
        // Cargo marks packages that it has printed before.
        lines.extend(printed.lines().map(|line| line.trim_end_matches(" (*)").to_owned()));
    }
    let packages = packages(&metadata.split(' ').collect::<Vec<_>>())?;
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
            folder: manifest.parent().context("manifests lie somewhere")?.to_path_buf(),
        });
    }
    ensure!(linked.len() > 10, "cargo tree names {} packages that are linked; that cannot be all", linked.len());
    Ok(linked)
}

/// Writes the file into a folder, and the licenses of Rust's standard library beside it.
pub fn write_all(linked: &[Linked], folder: &Path) -> Result<()> {
    let common = common()?;
    let mut texts: Vec<(String, Vec<String>)> = Vec::new();
    let mut list = String::new();
    for package in linked {
        let title = format!("{} {}", package.name, package.version);
        let mut numbers = Vec::new();
        for text in texts_of(package, &in_root(SUPPLIED), &common)? {
            // Texts that differ only in line breaks are one text.
            let same = |known: &(String, _)| known.0.split_whitespace().eq(text.split_whitespace());
            let at = texts.iter().position(same).unwrap_or(texts.len());
            if at == texts.len() {
                texts.push((text, Vec::new()));
            }
            texts[at].1.push(title.clone());
            numbers.push((at + 1).to_string());
        }
        list += &format!("  {title:44} {:40} {}\n", package.license, numbers.join(", "));
    }
    let mut whole = format!(
        "What Crumple {VERSION} is linked with beside Rust's standard library ({STANDARD_LIBRARY}):\n\
         package, its license, and the numbers of the texts below.\n\n{list}"
    );
    for (number, (text, of)) in texts.iter().enumerate() {
        whole += &format!("\n{RULE}\n{}: {}\n{RULE}\n\n{}\n", number + 1, of.join(", "), text.trim_end());
    }
    write(folder.join(FILE), whole)?;
    let standard = sysroot()?.join("share/doc/rust/COPYRIGHT-library.html");
    copy(&standard, &folder.join(STANDARD_LIBRARY))
        .context("the licenses of Rust's standard library are missing: a toolchain of rustup's has them")
}

/// Licenses whose texts are the same for everyone, with the texts. cbindgen has that of Mozilla.
fn common() -> Result<[(&'static str, String); 2]> {
    let packages = packages(&[])?;
    let cbindgen = packages.iter().find(|package| package["name"] == "cbindgen");
    let manifest =
        cbindgen.and_then(|package| package["manifest_path"].as_str()).context("cbindgen is a dependency")?;
    let mozilla = read(Path::new(manifest).with_file_name("LICENSE"))?;
    Ok([("Apache-2.0", read("LICENSE-APACHE")?), ("MPL-2.0", mozilla)])
}

/// The license texts of a package: its own files, or the supplied text, or a common one that it offers.
fn texts_of(package: &Linked, supplied: &Path, common: &[(&str, String)]) -> Result<Vec<String>> {
    let Linked { name: package, version, license, folder, repository, .. } = package;
    let mut texts = Vec::new();
    for file in files(folder)?.iter().filter(|file| file.parent() == Some(folder)) {
        let name = name(file)?.to_lowercase();
        if BEGINNINGS.iter().any(|beginning| name.starts_with(beginning)) {
            texts.push(read(file)?);
        }
    }
    texts.retain(|text| !text.trim().is_empty());
    let own = repository.trim_end_matches(".git").rsplit('/').next().unwrap_or_default();
    let supplied = supplied.join(format!("{own}.txt"));
    if texts.is_empty() && supplied.exists() {
        texts.push(read(&supplied)?);
    } else if texts.is_empty() {
        let known = common.iter().find(|(name, _)| offers(license, &[name])).with_context(|| {
            format!(
                "{package} {version} ({license}) is linked and was published without the text of its license; \
                 put what its authors' repository has into {SUPPLIED}/{own}.txt"
            )
        })?;
        texts.push(known.1.clone());
    }
    Ok(texts)
}

/// Fails if a library of an archive contains code of a package that is neither in `linked` nor, as `NAME-VERSION`, in `standard`. The
/// source paths in panic messages name the packages. The tests' debug build of the command has the tests' features.
pub fn nothing_unlicensed(built: &Built, folder: &Path, linked: &[Linked], standard: &[String]) -> Result<()> {
    let linked = linked.iter().map(|package| format!("{}-{}", package.name, package.version));
    let (known, mut libraries) = (linked.chain(standard.iter().cloned()).collect::<BTreeSet<_>>(), 0);
    for file in files(folder.join("lib"))?.into_iter().chain(files(folder.join("bin")).unwrap_or_default()) {
        if !built.handed_out && name(&file)? == built.target.program("crumple") {
            continue;
        }
        let (bytes, mut named) = (bytes(&file)?, false);
        for at in memmem::find_iter(&bytes, SOURCES) {
            // A slash of some system before the name, and one after it.
            let rest = &bytes[at + SOURCES.len()..];
            let mut parts = rest[..rest.len().min(102)].split(|byte| b"/\\".contains(byte));
            let (Some([]), Some(package), Some(_)) = (parts.next(), parts.next(), parts.next()) else { continue };
            let package = String::from_utf8_lossy(package);
            let file = file.display();
            ensure!(
                known.contains(&*package),
                "{file} holds code of {package}, which cargo tree does not say it links"
            );
            named = true;
        }
        libraries += usize::from(named);
    }
    ensure!(libraries > 0, "no library names a source in {SOURCES}: was it built for this?");
    Ok(())
}

/// Compares the table in `page` with what Cargo says, or writes it.
pub fn check_table(page: &str, fix: bool) -> Result<()> {
    let (full, slim) = (library(&FULL)?, library(&SLIM)?);
    let mut names = BTreeSet::new();
    let mut table =
        String::from("| package | slim | license | kept at | lines with `unsafe` |\n|---|---|---|---|---|\n");
    for Linked { name, version, license, repository, folder, from_crates_io } in &full {
        ensure!(offers(license, ALLOWED), "{name} is under {license}, which none of {ALLOWED:?} fulfils");
        ensure!(*from_crates_io, "{name} does not come from crates.io");
        ensure!(names.insert(name), "{name} is linked in several versions");
        let rust = files_of(folder.join("src"), &["rs"])?;
        let lines = rust.iter().map(|file| Ok(unsafe_lines(&read(file)?))).sum::<Result<usize>>()?;
        let home = repository.trim_start_matches("https://").trim_end_matches(".git").trim_end_matches('/');
        let slim = if slim.iter().any(|package| package.name == *name) { "yes" } else { "no" };
        let license = license.replace('/', " OR ");
        table += &format!("| {name} {version} | {slim} | {license} | {home} | {lines} |\n");
    }
    passage(fix, page, [BEGIN, END], &table)?;
    println!("{page} lists the {} packages that the library links; each may be shipped", full.len());
    Ok(())
}

/// Lines of code in which the keyword stands. Comments at the end of a line do not count, and neither does `unsafe_code`.
fn unsafe_lines(text: &str) -> usize {
    let word = |letter: char| !letter.is_alphanumeric() && letter != '_';
    let code = text.lines().filter_map(|line| line.split("//").next());
    code.filter(|code| code.split(word).any(|word| word == "unsafe")).count()
}

/// Whether one of the choices in an SPDX expression asks only for these licenses.
fn offers(expression: &str, allowed: &[&str]) -> bool {
    let choices = expression.split(" OR ").flat_map(|part| part.split('/'));
    choices.map(str::trim).any(|choice| choice.split(" AND ").all(|license| allowed.contains(&license)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_packages_own_texts_come_first_then_one_that_it_may_be_used_under() {
        let texts = |license: &str, files: &[(&str, &str)]| {
            let scratch = tempfile::tempdir().unwrap();
            let folder = scratch.path().to_path_buf();
            for (name, text) in files {
                std::fs::write(folder.join(name), text).unwrap();
            }
            let (name, version, repository) =
                ("denty".into(), "1.2.0".into(), "https://example.org/dents/denty.git".into());
            let package = Linked { name, version, license: license.into(), repository, from_crates_io: true, folder };
            texts_of(&package, scratch.path(), &[("Apache-2.0", "apache".into()), ("MPL-2.0", "mozilla".into())])
        };
        let files = [("LICENSE-MIT", "mit"), ("COPYING", "copy"), ("lib.rs", "no"), ("NOTICE", " ")];
        assert_eq!(texts("MIT OR Apache-2.0", &files).unwrap(), ["copy", "mit"]);
        assert_eq!(texts("MIT", &[("denty.txt", "supplied")]).unwrap(), ["supplied"]);
        for license in ["MIT OR Apache-2.0", "Zlib OR Apache-2.0 OR MIT", "Apache-2.0", "MIT/Apache-2.0"] {
            assert_eq!(texts(license, &[]).unwrap(), ["apache"]);
        }
        assert_eq!(texts("MPL-2.0", &[]).unwrap(), ["mozilla"]);
        for license in ["MIT", "Apache-2.0 AND MIT", "Apache-2.0 WITH LLVM-exception", ""] {
            let error = texts(license, &[]).unwrap_err().to_string();
            assert!(error.contains("denty 1.2.0") && error.contains("denty.txt"), "{error}");
        }
        assert!(offers("GPL-3.0 OR MIT", ALLOWED) && offers("MIT AND Zlib", ALLOWED) && !offers("GPL-3.0", ALLOWED));
    }
}
