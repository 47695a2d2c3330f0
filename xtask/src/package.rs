//! `cargo xtask package`: release archives, `crumple-VERSION-TARGET[-slim].tar.gz` (`.zip` on Windows), each with its debug symbols
//! in an archive beside it. The same libraries give the same bytes.

pub mod archive;
mod check;
mod contents;
pub mod licenses;
pub mod manifest;
pub mod markdown;
mod paths;
mod symbols;

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use clap::{Args, ValueEnum};
use xshell::cmd;

use crate::command::Command;
use crate::install::{self, Built, Profile};
use crate::native;
use crate::target::{self, Target};
use crate::tools::{self, Tool};
use crate::wine::Wine;
use crate::workspace::{Workspace, empty_directory, files};

pub use check::{stage, windows};

#[derive(Args)]
pub struct Options {
    /// Which archives
    #[arg(long, value_enum, default_value = "all")]
    flavour: Choice,
    /// Folder for the archives
    #[arg(long, value_name = "DIR", default_value = "out/package")]
    out: PathBuf,
    /// Unpack each archive elsewhere, and build and run its examples
    #[arg(long)]
    check: bool,
    /// Make the archives for Windows on Linux, with MinGW
    #[arg(long)]
    windows: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Choice {
    /// For shipping with a game: reads baked sets only, no command
    Slim,
    /// Importers of glTF and OBJ, and the `crumple` command
    Full,
    All,
}

pub struct Flavour {
    name: &'static str,
    /// The end of the archive's name.
    suffix: &'static str,
    /// The library's features. C has no functions for wgpu, so wgpu is not among them.
    pub library: &'static [&'static str],
    /// Whether the archive holds the command.
    command: bool,
}

pub const SLIM: Flavour =
    Flavour { name: "slim", suffix: "-slim", library: &["vulkan", "host-allocator"], command: false };
pub const FULL: Flavour = Flavour { name: "full", suffix: "", library: install::FEATURES, command: true };

/// The builds that an archive is made of.
pub struct Parts {
    flavour: &'static Flavour,
    library: Built,
    command: Option<PathBuf>,
    /// Whether this is a release. Otherwise the command is the tests' debug build, which is slow and may name folders of this machine.
    handed_out: bool,
}

struct Packed {
    /// The name of the archive without its extension, and of the one folder in it.
    name: String,
    archive: PathBuf,
    /// As in `Parts`.
    handed_out: bool,
    target: Target,
}

pub fn run(workspace: &Workspace, options: &Options) -> Result<()> {
    let out = workspace.path(&options.out);
    let target = if options.windows { Target::other(target::WINDOWS) } else { Target::host(workspace)? };
    let missing = tools::provide(workspace, &tools_for(&target))?;
    ensure!(missing.is_empty(), "{}", tools::advice(&missing));
    for flavour in [&SLIM, &FULL] {
        if ![Choice::All, if flavour.suffix.is_empty() { Choice::Full } else { Choice::Slim }]
            .contains(&options.flavour)
        {
            continue;
        }
        let packed = pack(workspace, &build(workspace, flavour, &target)?, &out)?;
        if options.check && target.cross {
            check::under_wine(workspace, flavour, &packed, &Wine::start(workspace)?)?;
        } else if options.check {
            check::check(workspace, flavour, &packed)?;
        }
    }
    Ok(())
}

/// The programs that make archives for another system.
fn tools_for(target: &Target) -> BTreeSet<Tool> {
    if target.cross { tools::WINDOWS_TOOLS.iter().copied().collect() } else { BTreeSet::new() }
}

fn build(workspace: &Workspace, flavour: &'static Flavour, target: &Target) -> Result<Parts> {
    println!("Building the {} flavour; it is optimized as a whole, which takes minutes.", flavour.name);
    let mut command = None;
    if flavour.command {
        command = Some(Command::handed_out(workspace, target)?.program().to_owned());
    }
    // Built after the command, because building the command overwrites the library.
    let library = install::build(workspace, target.clone(), Profile::Dist, flavour.library)?;
    Ok(Parts { flavour, library, command, handed_out: true })
}

/// The folder of the full flavour for this system. For handing out, everything in it is optimized as a whole, which takes minutes.
/// Otherwise it has the release library and the tests' command, which other stages build too.
pub fn full(workspace: &Workspace, handed_out: bool) -> Result<PathBuf> {
    let target = Target::host(workspace)?;
    let parts = if handed_out { build(workspace, &FULL, &target)? } else { tested(workspace, target)? };
    Ok(lay_out(workspace, &parts)?.0)
}

/// The parts of the full flavour that tests have.
fn tested(workspace: &Workspace, target: Target) -> Result<Parts> {
    Ok(Parts {
        flavour: &FULL,
        library: install::installed(workspace, target, &native::release_prefix(workspace)?)?,
        command: Some(Command::build(workspace, Profile::Debug, None)?.program().to_owned()),
        handed_out: false,
    })
}

/// Lays out the folder and the folder with its debug symbols, both named like their archives.
fn lay_out(workspace: &Workspace, parts: &Parts) -> Result<(PathBuf, PathBuf)> {
    let flavour = parts.flavour;
    let (target, triple) = (&parts.library.target, &parts.library.target.triple);
    let name = format!("crumple-{}-{triple}{}", workspace.version, flavour.suffix);
    let stage = workspace.target.join("package").join(triple).join(flavour.name);
    empty_directory(&stage)?;
    let (folder, debug) = (stage.join(&name), stage.join(format!("{name}-symbols")));

    install::lay_out(workspace, &parts.library, &folder)?;
    if let Some(command) = &parts.command {
        let name = command.file_name().context("programs have names")?;
        install::copy_as(command, &folder.join("bin"), &name.to_string_lossy())?;
    }
    symbols::separate(workspace, parts, &folder, &debug)?;
    let linked = licenses::linked(workspace, parts)?;
    paths::nothing_unlicensed(parts, &folder, &linked, &target.standard_packages(workspace)?)?;
    licenses::write(workspace, &linked, &folder.join(licenses::FILE))?;
    contents::copy(workspace, parts, &folder)?;
    paths::nothing_of_this_machine(workspace, parts, &folder)?;
    manifest::write(workspace, parts, &folder)?;
    Ok((folder, debug))
}

/// Lays out the folder and writes the archives to `out`.
fn pack(workspace: &Workspace, parts: &Parts, out: &Path) -> Result<Packed> {
    let (folder, debug) = lay_out(workspace, parts)?;
    let target = &parts.library.target;
    let name = folder.file_name().context("the folder has a name")?.to_string_lossy().into_owned();
    fs::create_dir_all(out).with_context(|| format!("creating {}", out.display()))?;
    let time = time(workspace)?;
    let archive = archive::pack(&folder, out, time, target)?;
    let debug = archive::pack(&debug, out, time, target)?;
    for file in [&archive, &debug] {
        println!("{} ({:.1} MB)", file.display(), fs::metadata(file)?.len() as f64 / 1e6);
    }
    Ok(Packed { name, archive, handed_out: parts.handed_out, target: target.clone() })
}

/// The modification time of every entry: `SOURCE_DATE_EPOCH`, or the time of the commit.
fn time(workspace: &Workspace) -> Result<u64> {
    if let Ok(seconds) = std::env::var("SOURCE_DATE_EPOCH") {
        return seconds
            .parse()
            .with_context(|| format!("SOURCE_DATE_EPOCH is {seconds:?}; it must be seconds since 1970"));
    }
    let seconds = git(workspace, &["log", "-1", "--format=%ct"])?;
    Ok(seconds.trim().parse()?)
}

/// The output of git. Archives hold only files that git tracks.
fn git(workspace: &Workspace, arguments: &[&str]) -> Result<String> {
    // Another user may own the checkout.
    let trusted = "safe.directory=*";
    let printed = cmd!(workspace.shell, "git -c {trusted} {arguments...}").quiet().read();
    printed.context("archives need a git checkout: they hold the files that git tracks")
}

/// A path relative to a folder, with slashes on every system.
fn within(folder: &Path, path: &Path) -> Result<String> {
    let inner =
        path.strip_prefix(folder).with_context(|| format!("{} is not in {}", path.display(), folder.display()))?;
    let parts: Vec<_> = inner.iter().map(|part| part.to_string_lossy()).collect();
    ensure!(!parts.is_empty(), "{} is the folder itself", path.display());
    Ok(parts.join("/"))
}
