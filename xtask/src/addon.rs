//! `cargo xtask addon`: the Godot extension as an archive to unpack into a project.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use clap::Args;

use crate::files::{copy, copy_into, empty_directory, files, read, write};
use crate::godot::{BINDING, lay_out_generated};
use crate::package::{archive, licenses, markdown, nothing_of_this_machine};
use crate::target::{self, Target};
use crate::tools::{self, MINGW, WINDOWS_RUST};
use crate::workspace::Workspace;

#[derive(Args)]
pub struct Options {
    /// Folder for the archive
    #[arg(long, value_name = "DIR", default_value = "out/addon")]
    out: PathBuf,
    /// Build the extension for Windows too, with MinGW
    #[arg(long)]
    windows: bool,
    /// Also write the demo project to DIR/demo, ready to run
    #[arg(long)]
    demo: bool,
}

/// The addon's folder in a project.
const ADDON: &str = "addons/crumple";

pub fn run(workspace: &Workspace, options: &Options) -> Result<()> {
    let mut targets = vec![Target::host(workspace)?];
    if options.windows {
        tools::require(workspace, &[WINDOWS_RUST, MINGW])?;
        targets.push(Target::other(target::WINDOWS));
    }
    let stage = workspace.target.join("package/godot");
    empty_directory(&stage)?;
    let addon = stage.join(ADDON);
    let source = workspace.path(BINDING).join("project").join(ADDON);
    let built = source.join("bin");
    for file in files(&source)?.iter().filter(|file| !file.starts_with(&built)) {
        // The editor writes these beside files; each project has its own.
        if !["import", "uid"].iter().any(|own| file.extension().is_some_and(|extension| extension == *own)) {
            copy(file, &addon.join(file.strip_prefix(&source)?))?;
        }
    }
    for target in &targets {
        println!("Building for {}; the bindings of the whole engine take minutes.", target.triple);
        copy_into(&build(workspace, target)?, &addon.join("bin"))?;
    }
    let page = read(&workspace.path(BINDING).join("README.md"))?;
    write(&addon.join("README.md"), markdown::without_dead_links(&page, &addon))?;
    for license in ["LICENSE-MIT", "LICENSE-APACHE"] {
        copy_into(&workspace.path(license), &addon)?;
    }
    let linked = licenses::linked_of(workspace, &manifest(workspace), &targets)?;
    licenses::write_all(workspace, &linked, &addon)?;

    let out = workspace.path(&options.out);
    fs::create_dir_all(&out).with_context(|| format!("creating {}", out.display()))?;
    let archive = out.join(format!("crumple-godot-{}.zip", workspace.version));
    archive::zip(&stage.join("addons"), &archive)?;
    if options.demo {
        let (from, project) = (workspace.path(BINDING).join("project"), out.join("demo"));
        empty_directory(&project)?;
        copy_into(&from.join("project.godot"), &project)?;
        for (folder, within) in [(&from, "demo"), (&stage, "addons")] {
            for file in files(&folder.join(within))? {
                copy(&file, &project.join(file.strip_prefix(folder)?))?;
            }
        }
        lay_out_generated(workspace, &project)?;
        println!("{0} is the demo: godot --path {0}", project.display());
    }
    println!("{} ({:.1} MB)", archive.display(), fs::metadata(&archive)?.len() as f64 / 1e6);
    Ok(())
}

fn manifest(workspace: &Workspace) -> PathBuf {
    workspace.path(BINDING).join("Cargo.toml")
}

/// The library of a release build, without paths of this machine.
fn build(workspace: &Workspace, target: &Target) -> Result<PathBuf> {
    let (manifest, directory) = (manifest(workspace), workspace.target.join("godot"));
    let text = |path: &Path| path.display().to_string();
    let (manifest, directory_text) = (text(&manifest), text(&directory));
    let what = ["build", "--release", "--locked", "--manifest-path", &manifest, "--target-dir", &directory_text];
    target.cargo(workspace, &what)?.run()?;
    let name = if target.is_windows() { "crumple_godot.dll" } else { "libcrumple_godot.so" };
    let library = if target.cross { directory.join(&target.triple) } else { directory }.join("release").join(name);
    nothing_of_this_machine(workspace, std::slice::from_ref(&library))?;
    Ok(library)
}
