//! The checks that `cargo xtask ci` runs before the tests. Each is a stage: `cargo xtask test --only NAME` repeats it.

use anyhow::Result;

use crate::stage::Stage;
use crate::workspace::Workspace;
use crate::{header, repo, rooms};

pub const CHECKS: &[Stage] = &[
    Stage::new("repository", |workspace| repo::run(workspace, false))
        .shows("sizes, shown programs, changelog, .meta files and quoted messages are right"),
    Stage::new("rooms", rooms::run).shows("the imports of src keep the order of its rooms"),
    Stage::new("header", |workspace| header::run(workspace, true))
        .shows("the committed header and the C# and Python declarations match the sources"),
    Stage::new("format", |workspace| Ok(workspace.cargo(&["fmt", "--all", "--check"]).run()?))
        .shows("rustfmt changes nothing"),
    Stage::new("lints", |workspace| clippy(workspace, &["--workspace", "--all-targets", "--all-features"]))
        .shows("clippy finds nothing, with all features"),
    Stage::new("lints-slim", |workspace| {
        clippy(workspace, &["--package", "crumple", "--lib", "--no-default-features"])
    })
    .shows("clippy finds nothing in the library without features"),
    Stage::new("documentation", |workspace| {
        // The whole workspace with all features: stage "lints" has checked its dependencies so.
        let what = ["doc", "--no-deps", "--workspace", "--all-features"];
        Ok(workspace.cargo(&what).env("RUSTDOCFLAGS", "--deny warnings").run()?)
    })
    .shows("rustdoc finds nothing"),
];

fn clippy(workspace: &Workspace, what: &[&str]) -> Result<()> {
    let deny = ["--", "--deny", "warnings", "--deny", "clippy::undocumented_unsafe_blocks"];
    Ok(workspace.cargo(&["clippy"]).args(what).args(deny).run()?)
}
