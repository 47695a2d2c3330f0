//! Links between pages. Links to files that an archive leaves out become plain text.

use std::path::Path;

use anyhow::Result;
use regex_lite::{Captures, Regex};

use crate::files::{name, read, write};

/// Code, in which nothing is a link, or a link or picture: its mark, text and target.
const LINK: &str = r"(?s)```.*?```|`[^`\n]*`|(!?)\[((?:[^\[\]]|\[[^\[\]]*\])*)\]\(([^()\s]*)\)";

/// Copies a page into a folder, without links to files that do not exist there.
pub fn copy_page(page: &Path, folder: &Path) -> Result<()> {
    write(folder.join(name(page)?), without_dead_links(&read(page)?, folder)?)
}

/// `page` of `folder` without links to files that do not exist. Web addresses and anchors stay.
fn without_dead_links(page: &str, folder: &Path) -> Result<String> {
    let kept = |found: &Captures<'_>| {
        let file = found.get(3).map(|target| target.as_str().split('#').next().unwrap_or_default());
        let dead = |file: &str| !file.contains(':') && !folder.join(file).exists();
        let part = if !file.is_some_and(dead) { 0 } else { 2 };
        // Of a dead picture nothing stays.
        if part == 2 && &found[1] == "!" { String::new() } else { found[part].to_owned() }
    };
    Ok(Regex::new(LINK)?.replace_all(page, kept).into_owned())
}

#[cfg(test)]
mod tests {
    #[test]
    fn dead_links_become_their_text_and_dead_pictures_vanish() {
        let page = "See [the model](model.md#rules), [a site](https://example.org/x.md), [below](#below)\n\
                    ![Chart](lab/chart.png) and `[no](link.md)`.\n```c\na[b](c.md)\n```\n[`f`](gone.md): x\n";
        let scratch = tempfile::tempdir().unwrap();
        std::fs::write(scratch.path().join("model.md"), "").unwrap();
        let expected = page.replace("![Chart](lab/chart.png)", "").replace("[`f`](gone.md)", "`f`");
        assert_eq!(super::without_dead_links(page, scratch.path()).unwrap(), expected);
    }
}
