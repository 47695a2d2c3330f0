//! The table of docs/reliability.md with every package that the C library links, and what must hold for all of them. cargo-deny checks
//! the same and more, but takes longer to build than this repository.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::{Result, ensure};

use crate::files::{files_of, read};
use crate::package::licenses::{self, Linked};
use crate::repo;
use crate::workspace::Workspace;

const BEGIN: &str = "<!-- written by cargo xtask repo --fix -->\n";
const END: &str = "<!-- end -->\n";
/// Licenses under which everyone may ship a library, each with its text.
const ALLOWED: &[&str] = &["Apache-2.0", "BSD-2-Clause", "BSD-3-Clause", "MIT", "Zlib"];

/// Compares the table in `page` with what Cargo says, or writes it.
pub fn run(workspace: &Workspace, page: &str, fix: bool) -> Result<()> {
    let full = licenses::library(workspace, &crate::package::FULL)?;
    let slim = licenses::library(workspace, &crate::package::SLIM)?;
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

    repo::passage(workspace, fix, page, [BEGIN, END], &table)?;
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
    fn one_allowed_choice_is_enough() {
        for expression in ["MIT", "GPL-3.0 OR MIT", "MIT/Unlicense", "MIT AND Zlib"] {
            assert!(offers(expression, &["MIT", "Zlib"]), "{expression}");
        }
        for expression in ["GPL-3.0", "GPL-3.0 AND MIT", "", "see its text"] {
            assert!(!offers(expression, &["MIT", "Zlib"]), "{expression}");
        }
    }

    #[test]
    fn only_the_keyword_in_code_counts() {
        let text = "#![forbid(unsafe_code)]\n// unsafe\nunsafe fn f() {} // unsafe\nlet x = unsafe { 1 };\n";
        assert_eq!(unsafe_lines(text), 2);
    }
}
