//! `docs/reference.md` of an archive: the C interface as a page, made of the headers' comments.

use std::collections::BTreeSet;
use std::path::Path;

use anyhow::{Context, Result};

use crate::declarations::{self, HEADERS, Item};
use crate::files::read;

pub const PAGE: &str = "docs/reference.md";
const OPENING: &str = "# The C interface

Every function and type of the [headers](../include), in their order. [quickstart.c](../examples-c/quickstart.c) is a whole program.
[crumple.hpp](../include/crumple.hpp) has the same for C++17, and [bindings/unity/Runtime](../bindings/unity/Runtime) for C#, on the CPU.
";

pub fn page(include: &Path) -> Result<String> {
    let all = declarations::header(&declarations::read(include)?).context("reading the headers")?;
    let known: BTreeSet<&str> = all.iter().map(|item| item.name.as_str()).collect();
    let mut page = OPENING.to_owned();
    for file in HEADERS {
        let header = read(&include.join(file))?;
        let opening = header.lines().map_while(|line| line.strip_prefix("//"));
        let opening: Vec<_> = opening.map(|line| line.strip_prefix(' ').unwrap_or(line)).collect();
        page += &format!("\n## {file}\n\n```text\n{}\n```\n", opening.join("\n").trim());
        for Item { docs, name, text, .. } in &declarations::header(&declarations::joined(&[header]))? {
            page += &format!("\n### {name}\n\n```c\n{text}\n```\n\n");
            docs.iter().for_each(|line| page.push_str(&(linked(line, &known) + "\n")));
        }
    }
    Ok(page)
}

/// Names of functions and constants as code, with a link where the page has them.
fn linked(line: &str, known: &BTreeSet<&str>) -> String {
    let part = |letter: char| letter.is_ascii_alphanumeric() || letter == '_';
    let mut out = String::new();
    let mut rest = line;
    while let Some(start) = rest.find(part) {
        let (before, word) = rest.split_at(start);
        let (name, after) = word.split_at(word.find(|letter| !part(letter)).unwrap_or(word.len()));
        out += before;
        out += &match known.contains(name) {
            true => format!("[`{name}`](#{})", name.to_ascii_lowercase()),
            false if name.starts_with("CRUMPLE_") => format!("`{name}`"),
            false => name.to_owned(),
        };
        rest = if known.contains(name) { after.strip_prefix("()").unwrap_or(after) } else { after };
    }
    out + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_become_links() {
        let known = BTreeSet::from(["crumple_context_deform", "CrumpleMark"]);
        assert_eq!(
            linked("See crumple_context_deform(): a CrumpleMark or CRUMPLE_ERROR_IO.", &known),
            "See [`crumple_context_deform`](#crumple_context_deform): a [`CrumpleMark`](#crumplemark) or `CRUMPLE_ERROR_IO`."
        );
    }
}
