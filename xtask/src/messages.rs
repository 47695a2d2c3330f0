//! Checks that messages quoted in docs exist in the sources.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};

use crate::workspace::{Workspace, files};

/// Each page, and the folders whose sources contain the messages that it quotes.
const PAGES: &[(&str, &[&str])] = &[
    ("docs/troubleshooting.md", &["src"]),
    ("bindings/unity/Runtime/README.md", &["bindings/unity/Runtime"]),
    ("bindings/unity/Documentation~/index.md", &["bindings/unity"]),
];
/// The first head of tables that quote our messages. Tables with other heads quote other programs.
const HEAD: &str = "| it says |";

pub fn run(workspace: &Workspace) -> Result<()> {
    for (page, sources) in PAGES {
        let text = fs::read_to_string(workspace.path(page)).with_context(|| format!("reading {page}"))?;
        let mut source = String::new();
        for directory in *sources {
            gather(&workspace.path(directory), &mut source)?;
        }
        let quoted = quoted(&text);
        let unknown: Vec<&&str> = quoted.iter().filter(|quote| !source.contains(**quote)).collect();
        ensure!(unknown.is_empty(), "{page} quotes {unknown:?}, which no source in {sources:?} contains");
        println!("{page} quotes {} pieces of messages; all exist", quoted.len());
    }
    Ok(())
}

/// The text in backticks in the first column of our tables.
fn quoted(page: &str) -> Vec<&str> {
    let mut within = false;
    let mut found = Vec::new();
    for line in page.lines() {
        within = if line.starts_with(HEAD) { true } else { within && line.starts_with('|') };
        if within && !line.starts_with(HEAD) {
            let cell = line.split('|').nth(1).unwrap_or_default();
            found.extend(cell.split('`').skip(1).step_by(2));
        }
    }
    found
}

/// Appends the text of all source files. Continued lines of a string are joined as the compiler joins them.
fn gather(folder: &Path, all: &mut String) -> Result<()> {
    let known = ["rs", "cs", "cpp", "h", "c"];
    let is_source = |path: &PathBuf| path.extension().is_some_and(|extension| known.iter().any(|k| *k == extension));
    for path in files(folder)?.iter().filter(|path| is_source(path)) {
        let text = fs::read_to_string(path).with_context(|| format!("reading {}", path.display()))?;
        let mut joined = false;
        for line in text.lines() {
            let line = if joined { line.trim_start() } else { line };
            joined = line.ends_with('\\');
            all.push_str(line.strip_suffix('\\').unwrap_or(line));
            if !joined {
                all.push('\n');
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::quoted;

    #[test]
    fn only_the_first_column_of_tables_of_messages_counts() {
        let page =
            "`a`\n| it says | why |\n|---|---|\n| `b` … `c` | `d` |\n\n| you see | why |\n|---|---|\n| `e` | |\n";
        assert_eq!(quoted(page), ["b", "c"]);
    }
}
