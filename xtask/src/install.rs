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

use anyhow::{Context, Result, bail, ensure};
use object::elf::{DF_1_NODELETE, DT_FLAGS_1, DT_SONAME, FileHeader32, FileHeader64};
use object::read::elf::{Dynamic, FileHeader};
use object::{Endianness, FileKind, Object};

use crate::abi;
use crate::declarations::{HEADERS, INCLUDE};
use crate::target::Target;
use crate::workspace::Workspace;

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Profile {
    Debug,
    Release,
    /// Release archives.
    Dist,
}

impl Profile {
    /// Name of Cargo's output directory.
    pub fn directory(self) -> &'static str {
        match self {
            Self::Debug => "debug",
            Self::Release => "release",
            Self::Dist => "dist",
        }
    }
}

/// Features of the library that C programs get: the default ones and the host's allocator.
pub const FEATURES: &[&str] = &["gltf", "obj", "vulkan", "host-allocator"];

/// The library as Cargo left it.
pub struct Built {
    pub target: Target,
    pub shared: PathBuf,
    static_library: PathBuf,
    /// Linker arguments that a program needs beside `static_library`, such as `-lpthread`.
    static_needs: Vec<String>,
    /// The features that it was built with.
    features: &'static [&'static str],
}

/// Builds the C library. Only `Profile::Dist` builds with just `features`. A debug build is the one that the tests use, with all
/// features.
pub fn build(
    workspace: &Workspace,
    target: Target,
    profile: Profile,
    features: &'static [&'static str],
) -> Result<Built> {
    match profile {
        Profile::Debug => workspace.build_as_tested(&["--lib"]).run()?,
        Profile::Release => {
            // As CMakeLists.txt calls it, so that Cargo builds once for both.
            let release = ["build", "--release", "--lib", "--package", "crumple", "--no-default-features"];
            let features = ["capi", &FEATURES.join(",")].join(",");
            workspace.cargo_anywhere(&release)?.args(["--features", &features]).run()?;
        }
        Profile::Dist => {
            let features = features.join(",");
            // Cargo skips link-time optimization if the Rust library is built along.
            let dist =
                ["rustc", "--profile", "dist", "--lib", "--crate-type", "cdylib,staticlib", "--package", "crumple"];
            target.cargo(workspace, &dist)?.args(["--no-default-features", "--features", &features]).run()?;
        }
    }
    built(workspace, target, profile, features)
}

/// What was built for a system.
pub fn built(
    workspace: &Workspace,
    target: Target,
    profile: Profile,
    features: &'static [&'static str],
) -> Result<Built> {
    let directory = target.directory(workspace, profile.directory());
    Ok(Built {
        shared: directory.join(target.shared()),
        static_library: directory.join(target.static_library()),
        static_needs: static_needs(workspace, &target)?,
        features,
        target,
    })
}

/// The release library in a folder that [`run`] filled. Another build may have taken its place in Cargo's folder.
pub fn installed(workspace: &Workspace, target: Target, prefix: &Path) -> Result<Built> {
    let (shared, static_library) = (shared(&target, prefix), prefix.join("lib").join(target.static_library()));
    Ok(Built { shared, static_library, ..built(workspace, target, Profile::Release, FEATURES)? })
}

/// The system libraries that Rust's standard library links, as `rustc` prints them for an empty static library.
fn static_needs(workspace: &Workspace, target: &Target) -> Result<Vec<String>> {
    if !target.has_standard_library(workspace) {
        // Compiling it for the question takes minutes.
        return Ok(target.static_needs().iter().map(|flag| (*flag).to_owned()).collect());
    }
    let scratch = tempfile::tempdir()?;
    let source = scratch.path().join("empty.rs");
    fs::write(&source, "")?;
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let (sh, triple) = (&workspace.shell, &target.triple);
    let output =
        xshell::cmd!(sh, "{rustc} --target {triple} --crate-type staticlib --print native-static-libs {source}")
            .arg("-o")
            .arg(scratch.path().join("empty.a"))
            .quiet()
            .read_stderr()?;
    let marker = "native-static-libs: ";
    let line = output.lines().find_map(|line| line.split(marker).nth(1));
    let line = line.with_context(|| format!("rustc printed no line with {marker:?}, but: {output}"))?;
    Ok(line.split_whitespace().map(str::to_owned).collect())
}

/// Builds and installs.
pub fn run(workspace: &Workspace, prefix: &Path, profile: Profile) -> Result<()> {
    let built = build(workspace, Target::host(workspace)?, profile, FEATURES)?;
    let prefix = workspace.path(prefix);
    lay_out(workspace, &built, &prefix)?;
    println!("installed Crumple {} ({}) in {}", workspace.version, profile.directory(), prefix.display());
    Ok(())
}

/// Copies the library, headers, licenses and package files below `prefix`.
pub fn lay_out(workspace: &Workspace, built: &Built, prefix: &Path) -> Result<()> {
    let lib = prefix.join("lib");
    copy_shared(workspace, built, prefix)?;
    copy(&built.static_library, &lib)?;
    for header in HEADERS.iter().chain(&["crumple.hpp"]) {
        copy(&workspace.path(INCLUDE).join(header), &prefix.join("include"))?;
    }
    for license in ["LICENSE-MIT", "LICENSE-APACHE"] {
        copy(&workspace.path(license), &prefix.join("share/licenses/crumple"))?;
    }
    for (template, directory) in [
        ("cmake/CrumpleConfig.cmake.in", "lib/cmake/Crumple"),
        ("cmake/CrumpleConfigVersion.cmake.in", "lib/cmake/Crumple"),
        ("cmake/crumple.pc.in", "lib/pkgconfig"),
        ("cmake/static-libraries.txt.in", "lib"),
    ] {
        fill(workspace, built, template, &prefix.join(directory))?;
    }
    Ok(())
}

fn copy_shared(workspace: &Workspace, built: &Built, prefix: &Path) -> Result<()> {
    let lib = prefix.join("lib");
    if built.target.is_windows() {
        let shared = copy(&built.shared, &prefix.join("bin"))?;
        return import_library(workspace, built, &shared, &lib);
    }
    if built.target.is_macos() {
        return copy(&built.shared, &lib).map(drop);
    }
    let real = format!("libcrumple.so.{}", workspace.version);
    copy_as(&built.shared, &lib, &real)?;
    for link in [soname(&built.shared)?, "libcrumple.so".to_owned()] {
        let link = lib.join(link);
        if link.symlink_metadata().is_ok() {
            fs::remove_file(&link)?;
        }
        symlink(&real, &link).with_context(|| format!("linking {}", link.display()))?;
    }
    Ok(())
}

#[cfg(unix)]
use std::os::unix::fs::symlink;
#[cfg(windows)]
use std::os::windows::fs::symlink_file as symlink;

/// Puts the import library of a DLL into `lib`. MinGW's compiler and Microsoft's link the same file.
fn import_library(workspace: &Workspace, built: &Built, shared: &Path, lib: &Path) -> Result<()> {
    let name = "crumple.dll.lib";
    if !built.target.is_mingw() {
        return copy(&built.shared.with_file_name(name), lib).map(drop);
    }
    fs::create_dir_all(lib)?;
    let exports = lib.join("crumple.def");
    fs::write(&exports, format!("LIBRARY crumple.dll\nEXPORTS\n{}\n", abi::exports(shared)?.join("\n")))?;
    let import = lib.join(name);
    xshell::cmd!(workspace.shell, "llvm-dlltool -m i386:x86-64 -d {exports} -l {import}").quiet().run()?;
    // The name that MinGW's linker finds for -lcrumple before the static library's.
    copy_as(&import, lib, "libcrumple.dll.a")?;
    fs::remove_file(&exports).with_context(|| format!("removing {}", exports.display()))
}

/// The name under which programs load the library; `build.rs` sets it.
pub fn soname(library: &Path) -> Result<String> {
    let name = dynamic(library)?.into_iter().find(|(entry, _)| entry.tag == DT_SONAME).map(|(_, text)| text);
    name.with_context(|| format!("{} has no SONAME; build.rs gives it one", library.display()))
}

/// Where the shared library is in a prefix.
pub fn shared(target: &Target, prefix: &Path) -> PathBuf {
    prefix.join(if target.is_windows() { "bin" } else { "lib" }).join(target.shared())
}

/// Checks that a host cannot unload the library while its threads are still ending; `build.rs` sets the flag.
pub fn stays_loaded(library: &Path) -> Result<()> {
    let flags = dynamic(library)?.into_iter().find(|(entry, _)| entry.tag == DT_FLAGS_1);
    let flags = flags.map_or(0, |(entry, _)| entry.val);
    ensure!(flags & u64::from(DF_1_NODELETE) != 0, "{} is not NODELETE; build.rs makes it so", library.display());
    Ok(())
}

/// Checks that a DLL needs only libraries that Windows has.
pub fn needs_windows_alone(library: &Path) -> Result<()> {
    const WINDOWS: &[&str] =
        &["bcryptprimitives.dll", "kernel32.dll", "msvcrt.dll", "ntdll.dll", "userenv.dll", "ws2_32.dll"];
    let bytes = fs::read(library).with_context(|| format!("reading {}", library.display()))?;
    let imports = object::File::parse(&*bytes)?.imports()?;
    let names: BTreeSet<String> =
        imports.iter().map(|import| String::from_utf8_lossy(import.library()).to_lowercase()).collect();
    let known = |name: &String| WINDOWS.contains(&name.as_str()) || name.starts_with("api-ms-win-");
    let foreign: Vec<_> = names.iter().filter(|name| !known(name)).collect();
    ensure!(foreign.is_empty() && !names.is_empty(), "{} needs {foreign:?}", library.display());
    Ok(())
}

/// The entries of the dynamic table, each with its string if it has one.
fn dynamic(library: &Path) -> Result<Vec<(Dynamic, String)>> {
    let bytes = fs::read(library).with_context(|| format!("reading {}", library.display()))?;
    match FileKind::parse(&*bytes)? {
        FileKind::Elf32 => dynamic_of(FileHeader32::<Endianness>::parse(&*bytes)?, &bytes),
        _ => dynamic_of(FileHeader64::<Endianness>::parse(&*bytes)?, &bytes),
    }
}

fn dynamic_of<H: FileHeader>(header: &H, bytes: &[u8]) -> Result<Vec<(Dynamic, String)>> {
    let endian = header.endian()?;
    let table = header.sections(endian, bytes)?.dynamic_table(endian, bytes)?;
    let text = |entry: Dynamic| if entry.is_string() { table.string(entry).unwrap_or_default() } else { &[] };
    Ok(table.iter().map(|entry| (entry, String::from_utf8_lossy(text(entry)).into_owned())).collect())
}

/// Copies `cmake/NAME.in` to `directory/NAME` with every `@KEY@` replaced.
fn fill(workspace: &Workspace, built: &Built, template: &str, directory: &Path) -> Result<()> {
    let text = fs::read_to_string(workspace.path(template)).with_context(|| format!("reading {template}"))?;
    let libraries: Vec<&str> = built.static_needs.iter().map(|flag| flag.strip_prefix("-l").unwrap_or(flag)).collect();
    let values = [
        ("@CRUMPLE_VERSION@", workspace.version.clone()),
        ("@CRUMPLE_SONAME@", if built.target.is_linux() { soname(&built.shared)? } else { String::new() }),
        ("@CRUMPLE_STATIC@", built.target.static_library().to_owned()),
        ("@CRUMPLE_STATIC_LIBS@", built.static_needs.join(" ")),
        ("@CRUMPLE_STATIC_LIBS_CMAKE@", libraries.join(";")),
        ("@CRUMPLE_POINTER_BYTES@", built.target.pointer_bytes().to_string()),
        ("@CRUMPLE_FEATURES@", built.features.join(" ")),
        ("@CRUMPLE_FEATURES_CMAKE@", built.features.join(";")),
    ];
    let text = values.iter().fold(text, |text, (key, value)| text.replace(key, value));
    if let Some(key) = text.split("@CRUMPLE_").nth(1) {
        let key = key.split('@').next().unwrap_or(key);
        bail!("{template} asks for @CRUMPLE_{key}@, which the installer does not know");
    }
    let name = Path::new(template).file_stem().context("templates have names")?;
    fs::create_dir_all(directory)?;
    let path = directory.join(name);
    fs::write(&path, text).with_context(|| format!("writing {}", path.display()))
}

pub fn copy(file: &Path, directory: &Path) -> Result<PathBuf> {
    let name = file.file_name().with_context(|| format!("{} has no file name", file.display()))?;
    copy_as(file, directory, &name.to_string_lossy())
}

pub fn copy_as(file: &Path, directory: &Path, name: &str) -> Result<PathBuf> {
    fs::create_dir_all(directory).with_context(|| format!("creating {}", directory.display()))?;
    let to = directory.join(name);
    // A running program keeps the old file: overwriting it would change the program's memory.
    if to.exists() {
        fs::remove_file(&to).with_context(|| format!("replacing {}", to.display()))?;
    }
    fs::copy(file, &to).with_context(|| format!("copying {} to {}", file.display(), to.display()))?;
    Ok(to)
}
