//! `docs/reference.md` of an archive: the C interface as a page, made of the headers' comments.

use std::collections::BTreeSet;

use anyhow::{Context, Result};
use regex_lite::{Captures, Regex};

use crate::declarations::{self, HEADERS, INCLUDE, Item};
use crate::files::read;

pub const PAGE: &str = "docs/reference.md";
const OPENING: &str = "# The C interface

Every function and type of the [headers](../include), in their order. [quickstart.c](../examples-c/quickstart.c) is a whole program.
[crumple.hpp](../include/crumple.hpp) has the same for C++17, and [bindings/unity/Runtime](../bindings/unity/Runtime) for C#, on the CPU.
";

pub fn page() -> Result<String> {
    let all = declarations::header(&declarations::read(INCLUDE, &HEADERS)?).context("reading the headers")?;
    let known: BTreeSet<&str> = all.iter().map(|item| item.name.as_str()).collect();
    let mut page = OPENING.to_owned();
    for file in HEADERS.iter() {
        let header = read(format!("{INCLUDE}/{file}"))?;
        let opening = header.lines().map_while(|line| line.strip_prefix("//"));
        let opening: Vec<_> = opening.map(|line| line.strip_prefix(' ').unwrap_or(line)).collect();
        page += &format!("\n## {file}\n\n```text\n{}\n```\n", opening.join("\n").trim());
        for Item { docs, name, text, .. } in &declarations::header(&header)? {
            page += &format!("\n### {name}\n\n```c\n{text}\n```\n\n");
            page += &linked(&(docs.join("\n") + "\n"), &known)?;
        }
    }
    Ok(page)
}

/// Names of functions and constants as code, with a link where the page has them.
fn linked(line: &str, known: &BTreeSet<&str>) -> Result<String> {
    let word = Regex::new(r"(\w+)(\(\))?")?;
    let link = |found: &Captures<'_>| match &found[1] {
        name if known.contains(name) => format!("[`{name}`](#{})", name.to_ascii_lowercase()),
        name if name.starts_with("CRUMPLE_") => found[0].replacen(name, &format!("`{name}`"), 1),
        _ => found[0].to_owned(),
    };
    Ok(word.replace_all(line, link).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_become_links() {
        let known = BTreeSet::from(["crumple_context_deform", "CrumpleMark"]);
        assert_eq!(
            linked("See crumple_context_deform(): a CrumpleMark or CRUMPLE_ERROR_IO.", &known).unwrap(),
            "See [`crumple_context_deform`](#crumple_context_deform): a [`CrumpleMark`](#crumplemark) or `CRUMPLE_ERROR_IO`."
        );
    }
}
