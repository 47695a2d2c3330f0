//! Checks that messages quoted in docs exist in the sources.

use anyhow::{Result, ensure};

use crate::files::{files_of, read};
use crate::workspace::Workspace;

/// Each page, and the folder whose sources contain the messages that it quotes.
const PAGES: &[(&str, &str)] = &[
    ("docs/troubleshooting.md", "src"),
    ("bindings/unity/Runtime/README.md", "bindings/unity/Runtime"),
    ("bindings/unity/Documentation~/index.md", "bindings/unity"),
];
/// The first head of tables that quote our messages. Tables with other heads quote other programs.
const HEAD: &str = "| it says |";

pub fn run(workspace: &Workspace) -> Result<()> {
    for (page, sources) in PAGES {
        let (text, mut source) = (read(&workspace.path(page))?, String::new());
        for file in files_of(&workspace.path(sources), &["rs", "cs", "cpp", "h", "c"])? {
            source += &joined(&read(&file)?);
        }
        let quoted = quoted(&text);
        let unknown: Vec<&&str> = quoted.iter().filter(|quote| !source.contains(**quote)).collect();
        ensure!(unknown.is_empty(), "{page} quotes {unknown:?}, which no source in {sources} contains");
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

/// Continued lines of a string are joined as the compiler joins them.
fn joined(source: &str) -> String {
    let mut parts = source.split("\\\n");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |text, part| text + part.trim_start())
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
