//! `THIRD-PARTY-LICENSES.txt`: every package that is linked, and the full text of its license, each text once. cargo-about does the
//! same, but would add 150 packages to the build of this helper, and it does not look into the libraries. The table of docs/reliability.md
//! with all of them, and what must hold for them: cargo-deny checks the same and more, but takes longer to build than this repository.

use super::{FULL, Flavour, Parts, SLIM};
use crate::prelude::*;

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
    pub directory: PathBuf,
}

/// The packages that the flavour's library and command link. Procedural macros and build dependencies are not among them.
pub fn linked(parts: &Parts) -> Result<Vec<Linked>> {
    let (flavour, target) = (parts.flavour, &parts.library.target.triple);
    let mut lines = library_tree(flavour, target)?;
    if flavour.command {
        let command = ["--package", "crumple", "--target", target, "--features", command::FEATURES];
        lines.extend(tree(&command)?);
    }
    known(lines, &["--all-features"])
}

/// The packages that the flavour's library links on any system.
fn library(flavour: &Flavour) -> Result<Vec<Linked>> {
    known(library_tree(flavour, "all")?, &["--all-features"])
}

/// The packages that a binding of its own workspace links, for any of the targets.
pub fn linked_of(manifest: &Path, targets: &[Target]) -> Result<Vec<Linked>> {
    let manifest = ["--manifest-path", &manifest.to_string_lossy()];
    let mut lines = Vec::new();
    for target in targets {
        lines.extend(tree(&[&manifest[..], &["--target", &target.triple]].concat())?);
    }
    known(lines, &manifest)
}

fn library_tree(flavour: &Flavour, target: &str) -> Result<Vec<String>> {
    let features = flavour.library.join(",");
    tree(&["--package", "crumple", "--target", target, "--no-default-features", "--features", &features])
}

/// `NAME vVERSION` and a path for each package that `cargo tree` names.
fn tree(arguments: &[&str]) -> Result<Vec<String>> {
    let format = ["tree", "--edges", "normal,no-proc-macro", "--prefix", "none", "--format", "{p}"];
    let printed = cargo(&format).args(arguments).quiet().read()?;
    // Cargo marks packages that it has printed before.
    Ok(printed.lines().map(|line| line.trim_end_matches(" (*)").to_owned()).collect())
}

/// The packages of lines of `cargo tree`, with what `cargo metadata` knows of them. Ours are left out.
fn known(mut lines: Vec<String>, metadata: &[&str]) -> Result<Vec<Linked>> {
    lines.sort();
    lines.dedup();
    let packages = packages(metadata)?;
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
pub fn write_all(linked: &[Linked], folder: &Path) -> Result<()> {
    let common = common()?;
    let mut texts: Vec<(String, Vec<String>)> = Vec::new();
    let mut by_words: BTreeMap<Vec<String>, usize> = BTreeMap::new();
    let mut list = String::new();
    for package in linked {
        let title = format!("{} {}", package.name, package.version);
        let mut numbers = Vec::new();
        for text in texts_of(package, &in_root(SUPPLIED), &common)? {
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
        VERSION
    );
    for (number, (text, of)) in texts.iter().enumerate() {
        whole += &format!("\n{RULE}\n{}: {}\n{RULE}\n\n{}\n", number + 1, of.join(", "), text.trim_end());
    }
    write(&folder.join(FILE), whole)?;
    let standard = sysroot()?.join("share/doc/rust/COPYRIGHT-library.html");
    copy(&standard, &folder.join(STANDARD_LIBRARY))
        .context("the licenses of Rust's standard library are missing: a toolchain of rustup's has them")
}

/// Licenses whose texts are the same for everyone, with the texts. cbindgen has that of Mozilla.
fn common() -> Result<[(&'static str, String); 2]> {
    let packages = packages(&[])?;
    let cbindgen = packages.iter().find(|package| package["name"] == "cbindgen").context("cbindgen is a dependency")?;
    let manifest = Path::new(cbindgen["manifest_path"].as_str().context("packages have manifests")?);
    let mozilla = read(&manifest.with_file_name("LICENSE"))?;
    Ok([("Apache-2.0", read("LICENSE-APACHE")?), ("MPL-2.0", mozilla)])
}

/// The license texts of a package: its own files, or the supplied text, or a common one that it offers.
fn texts_of(package: &Linked, supplied: &Path, common: &[(&str, String)]) -> Result<Vec<String>> {
    let Linked { version, license, directory, repository, .. } = package;
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
    let own = repository.trim_end_matches(".git").rsplit('/').next().unwrap_or_default();
    let supplied = supplied.join(format!("{own}.txt"));
    if supplied.exists() {
        return Ok(vec![read(&supplied)?]);
    }
    let known = common.iter().find(|(name, _)| offers(license, &[name]));
    let (_, text) = known.with_context(|| {
        format!(
            "{} {version} ({license}) is linked and was published without the text of its license; \
             put what its authors' repository has into {SUPPLIED}/{own}.txt",
            package.name
        )
    })?;
    Ok(vec![text.clone()])
}

/// Fails if a library of an archive contains code of a package that is neither in `linked` nor, as `NAME-VERSION`, in `standard`. The
/// source paths in panic messages name the packages. The tests' debug build of the command has the tests' features.
pub fn nothing_unlicensed(parts: &Parts, folder: &Path, linked: &[Linked], standard: &[String]) -> Result<()> {
    let linked = linked.iter().map(|package| format!("{}-{}", package.name, package.version));
    let known: BTreeSet<String> = linked.chain(standard.iter().cloned()).collect();
    let (separators, mut libraries) = (b"/\\", 0);
    let all = files(&folder.join("lib"))?.into_iter().chain(files(&folder.join("bin")).unwrap_or_default());
    for file in all {
        if !parts.handed_out && name(&file)? == parts.library.target.program("crumple") {
            continue;
        }
        let bytes = bytes(&file)?;
        let mut named = 0;
        for at in memmem::find_iter(&bytes, SOURCES) {
            let Some((first, rest)) = bytes[at + SOURCES.len()..].split_first() else { continue };
            let end = rest.iter().take(100).position(|byte| separators.contains(byte));
            let Some(end) = end.filter(|_| separators.contains(first)) else { continue };
            let package = String::from_utf8_lossy(&rest[..end]);
            if !known.contains(&*package) {
                bail!("{} holds code of {package}, which cargo tree does not say it is linked with", file.display());
            }
            named += 1;
        }
        libraries += usize::from(named > 0);
    }
    ensure!(libraries > 0, "no library names a source in {}: was it built for this?", SOURCES);
    Ok(())
}

/// Compares the table in `page` with what Cargo says, or writes it.
pub fn check_table(page: &str, fix: bool) -> Result<()> {
    let full = library(&FULL)?;
    let slim = library(&SLIM)?;
    let slim: BTreeSet<&str> = slim.iter().map(|package| package.name.as_str()).collect();
    let mut versions: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    let mut table =
        String::from("| package | slim | license | kept at | lines with `unsafe` |\n|---|---|---|---|---|\n");
    for package in &full {
        ensure!(
            offers(&package.license, ALLOWED),
            "{} is under {}, which none of {ALLOWED:?} fulfils",
            package.name,
            package.license
        );
        ensure!(package.from_crates_io, "{} does not come from crates.io", package.name);
        versions.entry(&package.name).or_default().push(&package.version);
        table += &row(package, slim.contains(package.name.as_str()))?;
    }
    versions.retain(|_, versions| versions.len() > 1);
    ensure!(versions.is_empty(), "linked in several versions: {versions:?}");

    repo::passage(fix, page, [BEGIN, END], &table)?;
    println!("{page} lists the {} packages that the library links; each may be shipped", full.len());
    Ok(())
}

fn row(package: &Linked, slim: bool) -> Result<String> {
    let Linked { name, version, license, repository, directory, .. } = package;
    let mut lines = 0;
    for file in files_of(&directory.join("src"), &["rs"])? {
        lines += unsafe_lines(&read(&file)?);
    }
    let home = repository.trim_start_matches("https://").trim_end_matches(".git").trim_end_matches('/');
    let (slim, license) = (if slim { "yes" } else { "no" }, license.replace('/', " OR "));
    Ok(format!("| {name} {version} | {slim} | {license} | {home} | {lines} |\n"))
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
            let directory = scratch.path().to_path_buf();
            for (name, text) in files {
                fs::write(directory.join(name), text).unwrap();
            }
            let (name, version, repository) =
                ("denty".into(), "1.2.0".into(), "https://example.org/dents/denty.git".into());
            let package =
                Linked { name, version, license: license.into(), repository, from_crates_io: true, directory };
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
