//! Links between pages. Links to files that an archive leaves out become plain text.

use std::ops::Range;
use std::path::Path;

/// A link or an image in a page.
struct Link {
    whole: Range<usize>,
    image: bool,
    text: Range<usize>,
    target: String,
}

/// The files that `page` links to, relative to it. Web addresses and anchors are left out.
pub fn targets(page: &str) -> Vec<String> {
    links(page).into_iter().map(|link| link.target).collect()
}

/// `page` of `directory` without links to files that do not exist.
pub fn without_dead_links(page: &str, directory: &Path) -> String {
    let mut kept = String::new();
    let mut from = 0;
    for link in links(page) {
        if directory.join(&link.target).exists() {
            continue;
        }
        kept += &page[from..link.whole.start];
        if !link.image {
            kept += &page[link.text];
        }
        from = link.whole.end;
    }
    kept + &page[from..]
}

/// `[text](target)` and `![text](target)` outside code.
fn links(page: &str) -> Vec<Link> {
    let mut found = Vec::new();
    let mut start = 0;
    let mut fenced = false;
    for line in page.split_inclusive('\n') {
        let at = start;
        start += line.len();
        if line.trim_start().starts_with("```") {
            fenced = !fenced;
        }
        if !fenced {
            in_line(line, at, &mut found);
        }
    }
    found
}

fn in_line(line: &str, at: usize, found: &mut Vec<Link>) {
    let mut from = 0;
    while let Some(middle) = line[from..].find("](").map(|found| from + found) {
        from = middle + 2;
        let Some(end) = line[from..].find(')').map(|found| from + found) else { return };
        let Some(open) = opening(&line[..middle]) else { continue };
        if line[..open].matches('`').count() % 2 == 1 {
            continue;
        }
        let target = line[from..end].split(['#', ' ']).next().unwrap_or_default();
        if target.is_empty() || target.contains("://") || target.starts_with("mailto:") {
            continue;
        }
        let image = line[..open].ends_with('!');
        found.push(Link {
            whole: at + open - usize::from(image)..at + end + 1,
            image,
            text: at + open + 1..at + middle,
            target: target.to_owned(),
        });
        from = end + 1;
    }
}

/// The position of the bracket that the one after `text` closes.
fn opening(text: &str) -> Option<usize> {
    let mut depth = 0;
    for (at, byte) in text.bytes().enumerate().rev() {
        match byte {
            b']' => depth += 1,
            b'[' if depth == 0 => return Some(at),
            b'[' => depth -= 1,
            _ => {}
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAGE: &str = "See [the model](model.md#rules), [a site](https://example.org/x.md), [below](#below)\n\
                        ![Chart](lab/chart.png) and `[no](link.md)`.\n```c\na[b](c.md)\n```\n[`f`](gone.md): x\n";

    #[test]
    fn links_to_files_are_found_and_code_is_not() {
        assert_eq!(targets(PAGE), ["model.md", "lab/chart.png", "gone.md"]);
    }

    #[test]
    fn dead_links_become_their_text_and_dead_pictures_vanish() {
        let scratch = tempfile::tempdir().unwrap();
        std::fs::write(scratch.path().join("model.md"), "").unwrap();
        let page = without_dead_links(PAGE, scratch.path());
        assert_eq!(targets(&page), ["model.md"]);
        assert!(page.contains(")\n and `[no](link.md)`.\n```c\na[b](c.md)\n```\n`f`: x\n"), "{page}");
    }
}
