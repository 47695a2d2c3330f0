//! `cargo xtask lab`: runs the lab's parts one after the other, draws their charts and writes docs/lab/README.md.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Context, Result, bail};
use clap::Args;
use xshell::cmd;

use crate::engines;
use crate::files::empty_directory;
use crate::python;
use crate::tools::PYTHON3;
use crate::workspace::Workspace;

#[derive(Args)]
pub struct Options {
    /// Measure a few impacts only, in under 3 minutes; writes to target/lab-quick and replaces no committed figure
    #[arg(long)]
    pub quick: bool,
    /// Only this part; may be given several times
    #[arg(long, value_name = "PART")]
    pub only: Vec<String>,
}

/// A part of the lab. Its fields run in this order. A script that does not exist is left out.
struct Part {
    name: &'static str,
    /// Subcommand of `crumple-lab`.
    measures: Option<&'static str>,
    /// Script in lab/python and its own arguments, or nothing. It also gets `--out DIRECTORY`, and `--quick` in a quick run.
    script: &'static [&'static str],
    /// Script in lab/python. It gets the directory.
    shows: Option<&'static str>,
}

const fn part(name: &'static str) -> Part {
    Part { name, measures: None, script: &[], shows: None }
}

const PARTS: &[Part] = &[
    Part { measures: Some("accuracy"), ..part("accuracy") },
    Part { measures: Some("told"), script: &["surrogates.py"], ..part("told") },
    Part { measures: Some("learn"), ..part("learn") },
    Part { measures: Some("contacts"), ..part("contacts") },
    Part { measures: Some("combine"), ..part("combine") },
    Part { measures: Some("peers"), script: &["mujoco_peer.py"], ..part("peers") },
    Part { measures: Some("stability"), ..part("stability") },
    Part { measures: Some("pictures"), ..part("pictures") },
    Part { measures: Some("looks"), ..part("looks") },
    Part { measures: Some("speed"), ..part("speed") },
    Part { measures: Some("scene"), ..part("scene") },
    Part { measures: Some("crash"), script: &["film.py", "crash"], ..part("crash") },
    Part { measures: Some("crowd"), script: &["film.py", "crowd"], ..part("crowd") },
    Part { shows: Some("draw.py"), ..part("charts") },
    Part { shows: Some("report.py"), ..part("report") },
];

pub fn run(workspace: &Workspace, options: &Options) -> Result<()> {
    for name in &options.only {
        if !PARTS.iter().any(|part| part.name == name) {
            let names: Vec<&str> = PARTS.iter().map(|part| part.name).collect();
            bail!("there is no part {name:?}; there are: {}", names.join(", "));
        }
    }
    let wanted = |part: &&Part| options.only.is_empty() || options.only.iter().any(|name| name == part.name);
    let parts: Vec<&Part> = PARTS.iter().filter(wanted).collect();
    let out = if options.quick { workspace.target.join("lab-quick") } else { workspace.path("docs/lab") };
    if options.quick && options.only.is_empty() {
        empty_directory(&out)?;
    }

    let start = Instant::now();
    let program = timed("build", || program(workspace, &["--all-features"]))?;
    let python = timed("python", || python(workspace))?;
    let sh = &workspace.shell;
    let _no_cache = sh.push_env("PYTHONDONTWRITEBYTECODE", "1");
    for part in parts {
        timed(part.name, || {
            let quick = options.quick.then_some("--quick");
            if let Some(subcommand) = part.measures {
                let throws = (part.name == "contacts").then(|| engines::build(workspace)).transpose()?;
                let throws = throws.map(|folder| format!("--throws={}", folder.display()));
                cmd!(sh, "{program} {subcommand} {throws...} {quick...} --out {out}").quiet().run()?;
            }
            if let [script, arguments @ ..] = part.script {
                let path = script_path(workspace, script);
                if path.exists() {
                    cmd!(sh, "{python} {path} {arguments...} {quick...} --out {out}").quiet().run()?;
                } else {
                    println!("left out: there is no {}", path.display());
                }
            }
            if let Some(script) = part.shows {
                let path = script_path(workspace, script);
                cmd!(sh, "{python} {path} {out}").quiet().run()?;
            }
            Ok(())
        })
        .with_context(|| format!("part {0} failed; alone: cargo xtask lab --only {0}", part.name))?;
    }
    println!("== lab: {} after {:.0} s", out.display(), start.elapsed().as_secs_f64());
    Ok(())
}

/// Builds the lab with these features and returns its program.
pub fn program(workspace: &Workspace, features: &[&str]) -> Result<PathBuf> {
    workspace.cargo_anywhere(&["build", "--release", "--package", "crumple-lab"])?.args(features).run()?;
    Ok(workspace.target.join("release/crumple-lab").with_extension(std::env::consts::EXE_EXTENSION))
}

fn timed<T>(name: &str, work: impl FnOnce() -> Result<T>) -> Result<T> {
    let start = Instant::now();
    let done = work()?;
    println!("== {name}: {:.1} s", start.elapsed().as_secs_f64());
    Ok(done)
}

fn script_path(workspace: &Workspace, script: &str) -> PathBuf {
    workspace.path("lab/python").join(script)
}

/// A Python with the pinned packages that the scripts need.
pub fn python(workspace: &Workspace) -> Result<PathBuf> {
    python::environment(workspace, PYTHON3, "lab-venv", "lab/python/requirements.txt")
}
