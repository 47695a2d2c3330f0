//! The checks that `cargo xtask ci` runs before the tests. Each is a stage: `cargo xtask test --only NAME` repeats it.

use anyhow::Result;

use crate::stage::{Outcome, Stage};
use crate::workspace::Workspace;
use crate::{header, repo, rooms};

pub const CHECKS: &[Stage] = &[
    check("repository", "sizes, shown programs, changelog, .meta files and quoted messages are right", |workspace| {
        repo::run(workspace, false).map(passed)
    }),
    check("rooms", "the imports of src keep the order of its rooms", |workspace| rooms::run(workspace).map(passed)),
    check("header", "the committed header and the C# and Python declarations match the sources", |workspace| {
        header::run(workspace, true).map(passed)
    }),
    check("format", "rustfmt changes nothing", |workspace| {
        Ok(workspace.cargo(&["fmt", "--all", "--check"]).run().map(passed)?)
    }),
    check("lints", "clippy finds nothing, with all features", |workspace| {
        clippy(workspace, &["--workspace", "--all-targets", "--all-features"])
    }),
    check("lints-slim", "clippy finds nothing in the library without features", |workspace| {
        clippy(workspace, &["--package", "crumple", "--lib", "--no-default-features"])
    }),
    check("documentation", "rustdoc finds nothing", |workspace| {
        // The whole workspace with all features: stage "lints" has checked its dependencies so.
        let what = ["doc", "--no-deps", "--workspace", "--all-features"];
        Ok(workspace.cargo(&what).env("RUSTDOCFLAGS", "--deny warnings").run().map(passed)?)
    }),
];

const fn check(name: &'static str, shows: &'static str, run: fn(&Workspace) -> Result<Outcome>) -> Stage {
    Stage { name, shows, needs: &[], wants: &[], leaves: &[], run }
}

fn passed((): ()) -> Outcome {
    Outcome::Passed
}

fn clippy(workspace: &Workspace, what: &[&str]) -> Result<Outcome> {
    let deny = ["--", "--deny", "warnings", "--deny", "clippy::undocumented_unsafe_blocks"];
    Ok(workspace.cargo(&["clippy"]).args(what).args(deny).run().map(passed)?)
}
