//! `cargo xtask install`: installs the C library in a folder that may be moved afterwards.
//!
//! ```text
//! PREFIX/include/crumple.h, crumple_*.h, crumple.hpp
//! PREFIX/lib/libcrumple.so.0.2.0, libcrumple.so.0.2, libcrumple.so, libcrumple.a, static-libraries.txt
//! PREFIX/lib/cmake/Crumple/*.cmake
//! PREFIX/lib/pkgconfig/crumple.pc
//! PREFIX/share/licenses/crumple/
//! ```
//!
//! On Windows the shared library is PREFIX/bin/crumple.dll, and programs link PREFIX/lib/crumple.dll.lib.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::sync::atomic::Ordering::Relaxed;

use anyhow::{Context, Result, ensure};
use object::Object;

use crate::declarations::INCLUDE;
use crate::files::{bytes, copy, copy_into, copy_licenses, copy_tree, empty, make, read, write};
use crate::target::Target;
use crate::workspace::{VERSION, build_as_tested, cargo_anywhere, cmd, in_root, in_target, run, rustc, said};
use crate::{abi, command};

pub struct Flavour {
    pub name: &'static str,
    /// The end of the archive's name.
    pub suffix: &'static str,
    /// The library's features. C has no functions for wgpu, so wgpu is not among them.
    pub library: &'static [&'static str],
    /// Whether the archive holds the command.
    pub command: bool,
}

pub const SLIM: Flavour =
    Flavour { name: "slim", suffix: "-slim", library: &["vulkan", "host-allocator"], command: false };
/// What C programs get: the default features and the host's allocator.
pub const FULL: Flavour =
    Flavour { name: "full", suffix: "", library: &["gltf", "obj", "vulkan", "host-allocator"], command: true };

/// What was built for a system.
pub struct Built {
    pub target: Target,
    pub flavour: &'static Flavour,
    pub shared: PathBuf,
    static_library: PathBuf,
    pub command: Option<PathBuf>,
    /// Whether this is a release. Otherwise the command is the tests' debug build, which is slow and may name folders of this machine.
    pub handed_out: bool,
}

impl Built {
    /// In Cargo's folder of a profile.
    pub fn new(target: Target, profile: &str, flavour: &'static Flavour) -> Self {
        let folder = target.folder(profile);
        let command = flavour.command.then(|| target.built(profile, "crumple"));
        let (shared, static_library) = (folder.join(target.shared()), folder.join(target.static_library()));
        Self { target, flavour, shared, static_library, command, handed_out: profile == "dist" }
    }

    /// The release library in a folder that [`run()`] filled, and the tests' command. Another build may have taken the library's place in
    /// Cargo's folder.
    pub fn tested() -> Result<Self> {
        let (target, prefix) = (Target::host()?, release_prefix()?);
        let (shared, static_library) = (target.shared_in(&prefix), prefix.join("lib").join(target.static_library()));
        let command = Some(command::tested()?);
        Ok(Self { target, flavour: &FULL, shared, static_library, command, handed_out: false })
    }
}

/// Whether this run has installed the release library already.
static INSTALLED: AtomicBool = AtomicBool::new(false);

/// Installs the release library of the present sources, once a run, and returns its folder.
pub fn release_prefix() -> Result<PathBuf> {
    let prefix = in_target("prefix");
    if !INSTALLED.load(Relaxed) {
        empty(&prefix)?;
        run(&prefix, "release")?;
        INSTALLED.store(true, Relaxed);
    }
    Ok(prefix)
}

/// Builds the C library. Only the profile "dist" builds with just the flavour's features. A debug build is the one that the tests
/// use, with all features.
fn build(target: &Target, profile: &str, flavour: &Flavour) -> Result<()> {
    let plain = ["--lib", "--package", "crumple", "--no-default-features", "--features"];
    let features = format!("capi,{}", flavour.library.join(","));
    let cargo = match profile {
        "debug" => build_as_tested(&["--lib"]),
        // As CMakeLists.txt calls it, so that Cargo builds once for both.
        "release" => cargo_anywhere(&["build", "--release"])?.args(plain).arg(features),
        // Cargo skips link-time optimization if the Rust library is built along.
        _ => target
            .cargo(&["rustc", "--profile", profile, "--crate-type", "cdylib,staticlib"])?
            .args(plain)
            .arg(features),
    };
    Ok(cargo.run()?)
}

/// Builds everything of a flavour for handing out.
pub fn dist(flavour: &'static Flavour, target: &Target) -> Result<Built> {
    println!("Building the {} flavour; it is optimized as a whole, which takes minutes.", flavour.name);
    if flavour.command {
        command::optimized(target, "dist", command::FEATURES)?;
    }
    // Built after the command, because building the command overwrites the library.
    build(target, "dist", flavour)?;
    Ok(Built::new(target.clone(), "dist", flavour))
}

/// What a program links beside the static library, such as `-lpthread`: `rustc` prints it for an empty one.
fn static_needs(target: &Target) -> Result<Vec<String>> {
    if !target.has_standard_library() {
        // Compiling it for the question takes minutes.
        return Ok(target.static_needs().split(' ').map(str::to_owned).collect());
    }
    let scratch = tempfile::tempdir()?;
    let (rustc, triple, empty) = (rustc(), &target.triple, scratch.path().join("empty.a"));
    let print = cmd!("{rustc} --target {triple} --crate-type staticlib --print native-static-libs -o {empty} -");
    let output = print.stdin("").quiet().read_stderr()?;
    let marker = "native-static-libs: ";
    let line = output.lines().find_map(|line| line.split(marker).nth(1));
    let line = line.with_context(|| format!("rustc printed no line with {marker:?}, but: {output}"))?;
    Ok(line.split_whitespace().map(str::to_owned).collect())
}

pub fn stage() -> Result<()> {
    abi::exported(&in_root(INCLUDE), &Target::host()?.shared_in(&release_prefix()?))
}

pub fn run(prefix: &Path, profile: &str) -> Result<()> {
    let (target, prefix) = (Target::host()?, in_root(prefix));
    build(&target, profile, &FULL)?;
    lay_out(&Built::new(target, profile, &FULL), &prefix)?;
    println!("installed Crumple {VERSION} ({profile}) in {}", prefix.display());
    Ok(())
}

/// Copies the library, headers, licenses and package files below `prefix`.
pub fn lay_out(built: &Built, prefix: &Path) -> Result<()> {
    let lib = prefix.join("lib");
    copy_shared(built, prefix)?;
    copy_into(&built.static_library, &lib)?;
    copy_tree(INCLUDE, &prefix.join("include"))?;
    copy_licenses(&prefix.join("share/licenses/crumple"))?;
    let needs = static_needs(&built.target)?;
    let libraries: Vec<&str> = needs.iter().map(|flag| flag.strip_prefix("-l").unwrap_or(flag)).collect();
    let values = [
        ("VERSION", VERSION.to_owned()),
        ("SONAME", if built.target.is_linux() { abi::soname(VERSION) } else { String::new() }),
        ("STATIC", built.target.static_library().to_owned()),
        ("STATIC_LIBS", needs.join(" ")),
        ("STATIC_LIBS_CMAKE", libraries.join(";")),
        ("POINTER_BYTES", built.target.pointer_bytes().to_string()),
        ("FEATURES", built.flavour.library.join(" ")),
        ("FEATURES_CMAKE", built.flavour.library.join(";")),
    ];
    for (name, folder) in [
        ("CrumpleConfig.cmake", lib.join("cmake/Crumple")),
        ("CrumpleConfigVersion.cmake", lib.join("cmake/Crumple")),
        ("crumple.pc", lib.join("pkgconfig")),
        ("static-libraries.txt", lib),
    ] {
        let template = read(format!("cmake/{name}.in"))?;
        let text = values.iter().fold(template, |text, (key, value)| text.replace(&format!("@CRUMPLE_{key}@"), value));
        ensure!(!text.contains("@CRUMPLE_"), "cmake/{name}.in asks for what the installer does not know");
        make(&folder)?;
        write(folder.join(name), text)?;
    }
    Ok(())
}

fn copy_shared(built: &Built, prefix: &Path) -> Result<()> {
    let (lib, shared) = (prefix.join("lib"), &built.shared);
    if built.target.is_windows() {
        copy_into(shared, &prefix.join("bin"))?;
        // MinGW's compiler and Microsoft's link the same file.
        let import = "crumple.dll.lib";
        if !built.target.is_mingw() {
            return copy_into(shared.with_file_name(import), &lib);
        }
        make(&lib)?;
        import_library("crumple.dll", &abi::exports(shared)?, &lib.join(import))?;
        // The name that MinGW's linker finds for -lcrumple before the static library's.
        return copy(lib.join(import), &lib.join("libcrumple.dll.a"));
    }
    if built.target.is_macos() {
        return copy_into(shared, &lib);
    }
    let real = format!("libcrumple.so.{VERSION}");
    copy(shared, &lib.join(&real))?;
    for link in [abi::soname(VERSION), "libcrumple.so".to_owned()] {
        run!("ln -s -f {real} {lib}/{link}")?;
    }
    Ok(())
}

/// Writes the import library of a DLL that exports these names.
pub fn import_library(dll: &str, exports: &[String], library: &Path) -> Result<()> {
    let definition = library.with_extension("def");
    write(&definition, format!("LIBRARY {dll}\nEXPORTS\n{}\n", exports.join("\n")))?;
    run!("llvm-dlltool -m i386:x86-64 -d {definition} -l {library}")?;
    fs::remove_file(&definition).with_context(|| format!("removing {}", definition.display()))
}

/// Checks that a host cannot unload a library for Linux while its threads are still ending, and that a DLL needs only libraries that
/// Windows has.
pub fn loads_well(target: &Target, library: &Path) -> Result<()> {
    const WINDOWS: &str = "bcryptprimitives.dll kernel32.dll msvcrt.dll ntdll.dll userenv.dll ws2_32.dll";
    if target.is_linux() {
        let table = said!("readelf -d {library}")?;
        ensure!(table.contains("NODELETE"), "{} is not NODELETE; build.rs makes it so", library.display());
    } else if target.is_windows() {
        let bytes = bytes(library)?;
        let imports = object::File::parse(&*bytes)?.imports()?;
        let names = imports.iter().map(|import| String::from_utf8_lossy(import.library()).to_lowercase());
        let known = |name: &String| WINDOWS.split(' ').any(|known| known == name) || name.starts_with("api-ms-win-");
        let foreign: BTreeSet<_> = names.filter(|name| !known(name)).collect();
        ensure!(foreign.is_empty() && !imports.is_empty(), "{} needs {foreign:?}", library.display());
    }
    Ok(())
}
