//! `cargo xtask package`: release archives, `crumple-VERSION-TARGET[-slim].tar.gz` (`.zip` on Windows), each with its debug symbols
//! in an archive beside it. The same libraries give the same bytes.

use std::path::{Path, PathBuf};

use anyhow::{Result, ensure};
use clap::Args;
use memchr::memmem;

use crate::files::{bytes, copy_into, empty, files, name};
use crate::install::{self, Built, FULL, SLIM};
use crate::target::{Target, WINDOWS};
use crate::tools;
use crate::wine::Wine;
use crate::workspace::{VERSION, cargo_home, in_root, in_target, root, sysroot, target_folder};

pub mod archive;
mod check;
mod contents;
pub mod licenses;
pub mod manifest;
pub mod markdown;
mod reference;
mod symbols;

pub use check::{CLIENT, packed, stage};

#[derive(Args)]
pub struct Options {
    /// Which archives: slim for shipping with a game (it reads baked sets only, and has no command), full with the importers of glTF and
    /// OBJ and the `crumple` command
    #[arg(long, value_parser = ["slim", "full", "all"], default_value = "all")]
    flavour: String,
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

/// The name of an archive without its extension, and of the one folder in it.
fn name_of(built: &Built) -> String {
    format!("crumple-{VERSION}-{}{}", built.target.triple, built.flavour.suffix)
}

pub fn run(options: &Options) -> Result<()> {
    let out = in_root(&options.out);
    let target = if options.windows { Target::other(WINDOWS) } else { Target::host()? };
    if target.cross {
        tools::require(tools::FOR_WINDOWS)?;
    }
    for flavour in [&SLIM, &FULL].into_iter().filter(|flavour| ["all", flavour.name].contains(&&*options.flavour)) {
        let built = install::dist(flavour, &target)?;
        let archive = pack(&built, &out)?;
        if options.check {
            check::check(&built, &archive, target.cross.then(Wine::start).transpose()?.as_ref())?;
        }
    }
    Ok(())
}

/// The folder of the full flavour for this system. For handing out, everything in it is optimized as a whole, which takes minutes.
/// Otherwise it has the release library and the tests' command, which other stages build too.
pub fn full(handed_out: bool) -> Result<PathBuf> {
    let built = if handed_out { install::dist(&FULL, &Target::host()?)? } else { Built::tested()? };
    Ok(lay_out(&built)?.0)
}

/// Lays out the folder and the folder with its debug symbols, both named like their archives.
fn lay_out(built: &Built) -> Result<(PathBuf, PathBuf)> {
    let (target, name) = (&built.target, name_of(built));
    let stage = empty(in_target("package").join(&target.triple).join(built.flavour.name))?;
    let (folder, debug) = (stage.join(&name), stage.join(format!("{name}-symbols")));
    install::lay_out(built, &folder)?;
    if let Some(command) = &built.command {
        copy_into(command, &folder.join("bin"))?;
    }
    symbols::separate(built, &folder, &debug)?;
    let linked = licenses::linked(built)?;
    licenses::nothing_unlicensed(built, &folder, &linked, &target.standard_packages()?)?;
    licenses::write_all(&linked, &folder)?;
    contents::copy_all(built, &folder)?;
    let mut all = files(&folder)?;
    all.retain(|file| built.handed_out || file.parent() != Some(&*folder.join("bin")));
    nothing_of_this_machine(&all)?;
    manifest::write_of(built, &folder)?;
    Ok((folder, debug))
}

/// Lays out the folder and writes the archives to `out`. Returns the one that does not hold the symbols.
fn pack(built: &Built, out: &Path) -> Result<PathBuf> {
    let (folder, debug) = lay_out(built)?;
    let end = if built.target.is_windows() { "zip" } else { "tar.gz" };
    archive::write(&debug, &out.join(format!("{}.{end}", name(&debug)?)))?;
    let archive = out.join(format!("{}.{end}", name(&folder)?));
    archive::write(&folder, &archive)?;
    Ok(archive)
}

/// Fails if a file contains the path of a folder of this machine.
pub fn nothing_of_this_machine(files: &[PathBuf]) -> Result<()> {
    let known = [root().to_owned(), target_folder(), cargo_home()?, sysroot()?];
    for file in files {
        let bytes = bytes(file)?;
        let found = known.iter().find(|path| memmem::find(&bytes, path.to_string_lossy().as_bytes()).is_some());
        ensure!(found.is_none(), "{} names {found:?}, a folder of this machine", file.display());
    }
    Ok(())
}
