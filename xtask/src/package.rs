//! `cargo xtask package`: release archives, `crumple-VERSION-TARGET[-slim].tar.gz` (`.zip` on Windows), each with its debug symbols
//! in an archive beside it. The same libraries give the same bytes.

use crate::prelude::*;

pub mod archive;
mod check;
mod contents;
pub mod licenses;
pub mod manifest;
pub mod markdown;
mod symbols;

pub use check::{CLIENT, stage, windows};

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

impl Parts {
    /// Those that tests have, of the full flavour.
    fn tested(library: Built, command: PathBuf) -> Self {
        Self { flavour: &FULL, library, command: Some(command), handed_out: false }
    }

    /// The name of the archive without its extension, and of the one folder in it.
    fn name(&self) -> String {
        format!("crumple-{}-{}{}", VERSION, self.library.target.triple, self.flavour.suffix)
    }
}

pub fn run(options: &Options) -> Result<()> {
    let out = in_root(&options.out);
    let target = if options.windows { Target::other(WINDOWS) } else { Target::host()? };
    if target.cross {
        tools::require(tools::FOR_WINDOWS)?;
    }
    for flavour in [&SLIM, &FULL].into_iter().filter(|flavour| ["all", flavour.name].contains(&&*options.flavour)) {
        let parts = build(flavour, &target)?;
        let archive = pack(&parts, &out)?;
        if options.check && target.cross {
            check::under_wine(&parts, &archive, &Wine::start()?)?;
        } else if options.check {
            check::check(&parts, &archive)?;
        }
    }
    Ok(())
}

fn build(flavour: &'static Flavour, target: &Target) -> Result<Parts> {
    println!("Building the {} flavour; it is optimized as a whole, which takes minutes.", flavour.name);
    let mut command = None;
    if flavour.command {
        command = Some(command::handed_out(target)?);
    }
    // Built after the command, because building the command overwrites the library.
    let library = install::build(target.clone(), Profile::Dist, flavour.library)?;
    Ok(Parts { flavour, library, command, handed_out: true })
}

/// The folder of the full flavour for this system. For handing out, everything in it is optimized as a whole, which takes minutes.
/// Otherwise it has the release library and the tests' command, which other stages build too.
pub fn full(handed_out: bool) -> Result<PathBuf> {
    let parts = if handed_out { build(&FULL, &Target::host()?)? } else { tested()? };
    Ok(lay_out(&parts)?.0)
}

fn tested() -> Result<Parts> {
    let library = install::installed(Target::host()?, &native::release_prefix()?);
    Ok(Parts::tested(library, command::tested()?))
}

/// Lays out the folder and the folder with its debug symbols, both named like their archives.
fn lay_out(parts: &Parts) -> Result<(PathBuf, PathBuf)> {
    let (target, name) = (&parts.library.target, parts.name());
    let stage = in_target("package").join(&target.triple).join(parts.flavour.name);
    empty_directory(&stage)?;
    let (folder, debug) = (stage.join(&name), stage.join(format!("{name}-symbols")));

    install::lay_out(&parts.library, &folder)?;
    if let Some(command) = &parts.command {
        copy_into(command, &folder.join("bin"))?;
    }
    symbols::separate(parts, &folder, &debug)?;
    let linked = licenses::linked(parts)?;
    licenses::nothing_unlicensed(parts, &folder, &linked, &target.standard_packages()?)?;
    licenses::write_all(&linked, &folder)?;
    contents::copy_all(parts, &folder)?;
    let mut all = files(&folder)?;
    all.retain(|file| parts.handed_out || file.parent() != Some(&*folder.join("bin")));
    nothing_of_this_machine(&all)?;
    manifest::write_of(parts, &folder)?;
    Ok((folder, debug))
}

/// Lays out the folder and writes the archives to `out`. Returns the one that does not hold the symbols.
fn pack(parts: &Parts, out: &Path) -> Result<PathBuf> {
    let (folder, debug) = lay_out(parts)?;
    make(out)?;
    let (time, target) = (time()?, &parts.library.target);
    let [archive, debug] = [archive::pack(&folder, out, time, target)?, archive::pack(&debug, out, time, target)?];
    announce(&archive)?;
    announce(&debug)?;
    Ok(archive)
}

/// The modification time of every entry: `SOURCE_DATE_EPOCH`, or the time of the commit.
pub fn time() -> Result<u64> {
    if let Ok(seconds) = std::env::var("SOURCE_DATE_EPOCH") {
        return seconds
            .parse()
            .with_context(|| format!("SOURCE_DATE_EPOCH is {seconds:?}; it must be seconds since 1970"));
    }
    let seconds = git(&["log", "-1", "--format=%ct"])?;
    Ok(seconds.trim().parse()?)
}

/// Fails if a file contains the path of a folder of this machine.
pub fn nothing_of_this_machine(files: &[PathBuf]) -> Result<()> {
    let known = [root().to_owned(), in_target(""), cargo_home()?, sysroot()?];
    for file in files {
        let bytes = bytes(file)?;
        for path in known.iter().map(|path| path.to_string_lossy()) {
            let found = memmem::find(&bytes, path.as_bytes());
            ensure!(found.is_none(), "{} names {path}, a folder of this machine", file.display());
        }
    }
    Ok(())
}
