//! `docs/reference.md`: the C interface as a page, made of the header's comments. Its chapters are the files of `src/capi`, in the
//! order of the header.

use std::collections::BTreeSet;
use std::fs;

use anyhow::{Context, Result, ensure};

use crate::declarations::{self, Form, Item};
use crate::workspace::Workspace;

pub const PAGE: &str = "docs/reference.md";

const SOURCES: &str = "src/capi";
/// The chapter of types that several calls share.
const SHARED: &str = "Values that several calls share";
const OPENING: &str = "# The C interface

Every function and type of [crumple.h](../include/crumple.h), chapter by chapter in the order in which you meet them; made of its
comments by `cargo xtask header`, so edit them in the library's source. A whole program is
[quickstart.c](../examples-c/quickstart.c); [crumple.hpp](../include/crumple.hpp) has the same for C++17, and
[bindings/unity/Runtime](../bindings/unity/Runtime) for C#.

";

/// A file of `src/capi` that adds to the header.
struct Chapter<'a> {
    title: String,
    items: Vec<&'a Item>,
}

pub fn page(workspace: &Workspace, header: &str) -> Result<String> {
    let items = declarations::header(header).context("reading include/crumple.h")?;
    let chapters = chapters(workspace, &items)?;
    let known: BTreeSet<&str> = items.iter().map(|item| item.name.as_str()).collect();
    let mut out = OPENING.to_owned();
    for chapter in &chapters {
        out.push_str(&format!("- [{}](#{})", chapter.title, anchor(&chapter.title)));
        let functions = chapter.items.iter().filter(|item| matches!(item.form, Form::Function { .. }));
        let links: Vec<String> = functions.map(|item| format!("[{0}](#{0})", item.name)).collect();
        out.push_str(if links.is_empty() { "\n" } else { ":\n  " });
        out.push_str(&links.join(", "));
        out.push_str(if links.is_empty() { "" } else { "\n" });
    }
    out.push_str("\n## What holds for all of it\n\n");
    general(header)?.lines().for_each(|line| out.push_str(&(linked(line, &known) + "\n")));
    for chapter in &chapters {
        out.push_str(&format!("\n## {}\n", chapter.title));
        for item in &chapter.items {
            out.push_str(&format!("\n### {}\n\n```c\n{}\n```\n", item.name, item.text));
            for paragraph in item.docs.split(String::is_empty).filter(|lines| !lines.is_empty()) {
                out.push('\n');
                paragraph.iter().for_each(|line| out.push_str(&(linked(line, &known) + "\n")));
            }
        }
    }
    Ok(out)
}

/// The header's opening comment from "Results." on: its paragraphs, each with its first words in bold.
fn general(header: &str) -> Result<String> {
    let opening = header.lines().map_while(|line| line.strip_prefix("//")).map(str::trim);
    let lines: Vec<&str> = opening.skip_while(|line| !line.starts_with("Results. ")).collect();
    ensure!(!lines.is_empty(), "the opening comment of the header has no paragraph that begins with \"Results. \"");
    let mut out = String::new();
    for paragraph in lines.split(|line| line.is_empty()).filter(|lines| !lines.is_empty()) {
        let text = paragraph.join("\n");
        if text.starts_with("This file is generated") {
            continue;
        }
        match text.split_once(". ") {
            Some((head, rest)) if head.split(' ').count() <= 2 => out.push_str(&format!("**{head}.** {rest}\n\n")),
            _ => out.push_str(&format!("{text}\n\n")),
        }
    }
    Ok(out.trim_end().to_owned() + "\n")
}

/// Names of functions and constants as code, with a link where the page has them.
fn linked(line: &str, known: &BTreeSet<&str>) -> String {
    let mut out = String::new();
    let mut rest = line;
    while let Some(start) = rest.find(|c: char| c.is_ascii_alphabetic()) {
        let (before, word) = rest.split_at(start);
        let end = word.find(|c: char| !c.is_ascii_alphanumeric() && c != '_').unwrap_or(word.len());
        let (name, after) = word.split_at(end);
        out.push_str(before);
        let call = after.starts_with("()") && name.starts_with("crumple_");
        out.push_str(&match (known.contains(name), call) {
            (true, _) if name.starts_with("crumple_") => format!("[`{name}`](#{name})"),
            (true, _) => format!("[`{name}`](#{})", anchor(name)),
            (false, _) if name.starts_with("CRUMPLE_") => format!("`{name}`"),
            _ => name.to_owned(),
        });
        rest = if call && known.contains(name) { &after[2..] } else { after };
    }
    out + rest
}

/// As GitHub names the place of a heading.
fn anchor(heading: &str) -> String {
    let kept = heading.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
    kept.map(|c| if c == ' ' { '-' } else { c.to_ascii_lowercase() }).collect()
}

/// Sorts what the header declares by the file that it comes from.
fn chapters<'a>(workspace: &Workspace, items: &'a [Item]) -> Result<Vec<Chapter<'a>>> {
    let list = fs::read_to_string(workspace.path(SOURCES).join("mod.rs"))?;
    let modules = list.lines().filter_map(|line| line.strip_suffix(';')?.rsplit_once("mod ").map(|(_, name)| name));
    let mut left: Vec<&Item> = items.iter().collect();
    let mut chapters = Vec::new();
    for module in modules {
        let path = workspace.path(SOURCES).join(module).with_extension("rs");
        let source = fs::read_to_string(&path).with_context(|| format!("reading {}", path.display()))?;
        let opening = source.lines().map_while(|line| line.strip_prefix("//! ")).collect::<Vec<_>>().join(" ");
        let title = opening.split(['.', ':', '(']).next().unwrap_or_default().trim().replace('`', "");
        let (here, elsewhere): (Vec<&Item>, Vec<&Item>) = left.iter().partition(|item| defines(&source, &item.name));
        left = elsewhere;
        if !here.is_empty() {
            chapters.push(Chapter { title, items: here });
        }
    }
    // Types of the library itself, which the header has under C names.
    let shared = chapters.iter_mut().find(|chapter| chapter.title == SHARED);
    shared.with_context(|| format!("no file of {SOURCES} begins with \"{SHARED}\""))?.items.extend(left);
    Ok(chapters)
}

fn defines(source: &str, name: &str) -> bool {
    let kinds = ["pub struct ", "pub enum ", "pub type ", "pub const ", "extern \"C\" fn "];
    kinds.iter().any(|kind| {
        source.match_indices(&format!("{kind}{name}")).any(|(at, found)| {
            let next = source[at + found.len()..].chars().next();
            !next.is_some_and(|c| c.is_alphanumeric() || c == '_')
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_become_links() {
        let known = BTreeSet::from(["crumple_context_deform", "CrumpleMark", "CRUMPLE_OK"]);
        assert_eq!(
            linked("See crumple_context_deform(): a CrumpleMark, CRUMPLE_OK or CRUMPLE_ERROR_IO.", &known),
            "See [`crumple_context_deform`](#crumple_context_deform): a [`CrumpleMark`](#crumplemark), [`CRUMPLE_OK`](#crumple_ok) or `CRUMPLE_ERROR_IO`."
        );
        assert_eq!(anchor("Damage: read, replaced, saved"), "damage-read-replaced-saved");
    }

    #[test]
    fn a_name_that_begins_another_is_not_it() {
        assert!(defines("pub struct CrumpleMark {", "CrumpleMark"));
        assert!(!defines("pub struct CrumpleMarks {", "CrumpleMark"));
        assert!(defines("pub unsafe extern \"C\" fn crumple_context_deform(", "crumple_context_deform"));
    }
}
