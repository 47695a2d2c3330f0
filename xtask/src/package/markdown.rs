//! Links between pages. Links to files that an archive leaves out become plain text.

use crate::prelude::*;
use pulldown_cmark::{Event, Options, Parser, Tag};

/// Copies a page into a folder, without links to files that do not exist there.
pub fn copy_page(page: &Path, folder: &Path) -> Result<()> {
    write(folder.join(name(page)?), without_dead_links(&read(page)?, folder))
}

/// `page` of `directory` without links to files that do not exist. Web addresses and anchors stay.
fn without_dead_links(page: &str, directory: &Path) -> String {
    let mut kept = String::new();
    let mut from = 0;
    for (event, whole) in Parser::new_ext(page, Options::ENABLE_TABLES).into_offset_iter() {
        let (Event::Start(Tag::Link { dest_url: target, .. }) | Event::Start(Tag::Image { dest_url: target, .. })) =
            &event
        else {
            continue;
        };
        let file = target.split('#').next().unwrap_or_default();
        // An image may be inside a link that is gone.
        if whole.start < from || file.contains(':') || directory.join(file).exists() {
            continue;
        }
        // `[text](target)`, or `![text](target)`, of which nothing stays.
        let link = &page[whole.clone()];
        kept += &page[from..whole.start];
        if let Some((text, _)) = link.strip_prefix('[').and_then(|link| link.rsplit_once("](")) {
            kept += text;
        }
        from = whole.end;
    }
    kept + &page[from..]
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
        assert_eq!(super::without_dead_links(page, scratch.path()), expected);
    }
}
