//! `cargo xtask addon`: the Godot extension as an archive to unpack into a project.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use clap::Args;

use crate::godot::{BINDING, lay_out_generated};
use crate::package::{archive, licenses, markdown};
use crate::target::{self, Target};
use crate::tools::{self, Tool};
use crate::workspace::{Workspace, cargo_home, empty_directory, files};

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
        let missing = tools::provide(workspace, &[Tool::WindowsRust, Tool::Mingw].into())?;
        ensure!(missing.is_empty(), "{}", tools::advice(&missing));
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
        let library = build(workspace, target)?;
        let name = library.file_name().context("libraries have names")?;
        copy(&library, &addon.join("bin").join(name))?;
    }
    let page = workspace.path(BINDING).join("README.md");
    let page = fs::read_to_string(&page).with_context(|| format!("reading {}", page.display()))?;
    fs::write(addon.join("README.md"), markdown::without_dead_links(&page, &addon))?;
    for license in ["LICENSE-MIT", "LICENSE-APACHE"] {
        copy(&workspace.path(license), &addon.join(license))?;
    }
    let linked = licenses::linked_of(workspace, &manifest(workspace), &targets)?;
    licenses::write(workspace, &linked, &addon.join(licenses::FILE))?;

    let out = workspace.path(&options.out);
    fs::create_dir_all(&out).with_context(|| format!("creating {}", out.display()))?;
    let archive = out.join(format!("crumple-godot-{}.zip", workspace.version));
    let file = fs::File::create(&archive).with_context(|| format!("creating {}", archive.display()))?;
    archive::zip(&stage.join("addons"), file).with_context(|| format!("packing {}", archive.display()))?;
    if options.demo {
        let (from, project) = (workspace.path(BINDING).join("project"), out.join("demo"));
        empty_directory(&project)?;
        copy(&from.join("project.godot"), &project.join("project.godot"))?;
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
    let bytes = fs::read(&library).with_context(|| format!("reading {}", library.display()))?;
    for place in [workspace.root.clone(), cargo_home()?] {
        let found = memchr::memmem::find(&bytes, place.display().to_string().as_bytes());
        ensure!(found.is_none(), "{} names {}, a folder of this machine", library.display(), place.display());
    }
    Ok(library)
}

fn copy(from: &Path, to: &Path) -> Result<()> {
    fs::create_dir_all(to.parent().context("files lie in folders")?)?;
    fs::copy(from, to).with_context(|| format!("copying {} to {}", from.display(), to.display()))?;
    Ok(())
}
