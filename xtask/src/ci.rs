//! `cargo xtask ci`: everything that must hold before a change lands. Lints first, since they are quick to fail;
//! the tests last, so that the output ends with their runners' own closing lines.

use std::time::Instant;

use anyhow::{Context, Result};

use crate::workspace::Workspace;
use crate::{abi, header, repo, test};

pub fn run(workspace: &Workspace) -> Result<()> {
    let start = Instant::now();
    let check = |name: &str, result: Result<()>| -> Result<()> {
        result.with_context(|| format!("check {name} failed"))?;
        println!("== {name}: well after {:.0} s", start.elapsed().as_secs_f64());
        Ok(())
    };
    check("repository", repo::run(workspace, false))?;
    check("header", header::run(workspace, true))?;
    check("binary interface", abi::run(workspace, true))?;
    check("format", cargo(workspace, &["fmt", "--all", "--check"]))?;
    check("lints", clippy(workspace, &["--workspace", "--all-targets", "--all-features"]))?;
    check("lints without features", clippy(workspace, &["--package", "crumple", "--lib", "--no-default-features"]))?;
    check("documentation", documentation(workspace))?;
    test::run(workspace, &test::Options { require_all: true, ..Default::default() })
}

fn cargo(workspace: &Workspace, arguments: &[&str]) -> Result<()> {
    Ok(workspace.cargo(arguments).run()?)
}

fn clippy(workspace: &Workspace, what: &[&str]) -> Result<()> {
    let deny = ["--", "--deny", "warnings", "--deny", "clippy::undocumented_unsafe_blocks"];
    Ok(workspace.cargo(&["clippy"]).args(what).args(deny).run()?)
}

fn documentation(workspace: &Workspace) -> Result<()> {
    // The whole workspace, since the lints have checked its dependencies with just these features.
    let what = ["doc", "--no-deps", "--workspace", "--all-features"];
    Ok(workspace.cargo(&what).env("RUSTDOCFLAGS", "--deny warnings").run()?)
}
