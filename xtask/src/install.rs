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

use crate::prelude::*;

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
    /// The features that it was built with.
    features: &'static [&'static str],
}

/// Builds the C library. Only `Profile::Dist` builds with just `features`. A debug build is the one that the tests use, with all
/// features.
pub fn build(target: Target, profile: Profile, features: &'static [&'static str]) -> Result<Built> {
    match profile {
        Profile::Debug => build_as_tested(&["--lib"]).run()?,
        Profile::Release => {
            // As CMakeLists.txt calls it, so that Cargo builds once for both.
            let release = ["build", "--release", "--lib", "--package", "crumple", "--no-default-features"];
            let features = ["capi", &FEATURES.join(",")].join(",");
            cargo_anywhere(&release)?.args(["--features", &features]).run()?;
        }
        Profile::Dist => {
            let features = features.join(",");
            // Cargo skips link-time optimization if the Rust library is built along.
            let dist =
                ["rustc", "--profile", "dist", "--lib", "--crate-type", "cdylib,staticlib", "--package", "crumple"];
            target.cargo(&dist)?.args(["--no-default-features", "--features", &features]).run()?;
        }
    }
    Ok(built(target, profile, features))
}

/// What was built for a system.
pub fn built(target: Target, profile: Profile, features: &'static [&'static str]) -> Built {
    let directory = target.directory(profile.directory());
    let (shared, static_library) = (directory.join(target.shared()), directory.join(target.static_library()));
    Built { target, shared, static_library, features }
}

/// The release library in a folder that [`run`] filled. Another build may have taken its place in Cargo's folder.
pub fn installed(target: Target, prefix: &Path) -> Built {
    let (shared, static_library) = (shared(&target, prefix), prefix.join("lib").join(target.static_library()));
    Built { target, shared, static_library, features: FEATURES }
}

/// What a program links beside the static library, such as `-lpthread`: `rustc` prints it for an empty one.
fn static_needs(target: &Target) -> Result<Vec<String>> {
    if !target.has_standard_library() {
        // Compiling it for the question takes minutes.
        return Ok(target.static_needs().iter().map(|flag| (*flag).to_owned()).collect());
    }
    let scratch = tempfile::tempdir()?;
    let source = scratch.path().join("empty.rs");
    fs::write(&source, "")?;
    let (rustc, triple, empty) = (rustc(), &target.triple, scratch.path().join("empty.a"));
    let print = ["--crate-type", "staticlib", "--print", "native-static-libs", "-o"];
    let output = cmd!("{rustc} --target {triple} {print...} {empty} {source}").quiet().read_stderr()?;
    let marker = "native-static-libs: ";
    let line = output.lines().find_map(|line| line.split(marker).nth(1));
    let line = line.with_context(|| format!("rustc printed no line with {marker:?}, but: {output}"))?;
    Ok(line.split_whitespace().map(str::to_owned).collect())
}

/// Builds and installs.
pub fn run(prefix: &Path, profile: Profile) -> Result<()> {
    let built = build(Target::host()?, profile, FEATURES)?;
    let prefix = in_root(prefix);
    lay_out(&built, &prefix)?;
    println!("installed Crumple {} ({}) in {}", VERSION, profile.directory(), prefix.display());
    Ok(())
}

/// Copies the library, headers, licenses and package files below `prefix`.
pub fn lay_out(built: &Built, prefix: &Path) -> Result<()> {
    let lib = prefix.join("lib");
    copy_shared(built, prefix)?;
    copy_into(&built.static_library, &lib)?;
    for header in HEADERS.iter().chain(&["crumple.hpp"]) {
        copy_into(&in_root(INCLUDE).join(header), &prefix.join("include"))?;
    }
    copy_licenses(&prefix.join("share/licenses/crumple"))?;
    let needs = static_needs(&built.target)?;
    let libraries: Vec<&str> = needs.iter().map(|flag| flag.strip_prefix("-l").unwrap_or(flag)).collect();
    let values = [
        ("VERSION", VERSION.to_owned()),
        ("SONAME", if built.target.is_linux() { abi::soname(&VERSION) } else { String::new() }),
        ("STATIC", built.target.static_library().to_owned()),
        ("STATIC_LIBS", needs.join(" ")),
        ("STATIC_LIBS_CMAKE", libraries.join(";")),
        ("POINTER_BYTES", built.target.pointer_bytes().to_string()),
        ("FEATURES", built.features.join(" ")),
        ("FEATURES_CMAKE", built.features.join(";")),
    ];
    for (name, directory) in [
        ("CrumpleConfig.cmake", lib.join("cmake/Crumple")),
        ("CrumpleConfigVersion.cmake", lib.join("cmake/Crumple")),
        ("crumple.pc", lib.join("pkgconfig")),
        ("static-libraries.txt", lib),
    ] {
        let template = read(&in_root("cmake").join(format!("{name}.in")))?;
        let text = values.iter().fold(template, |text, (key, value)| text.replace(&format!("@CRUMPLE_{key}@"), value));
        ensure!(!text.contains("@CRUMPLE_"), "cmake/{name}.in asks for what the installer does not know");
        make(&directory)?;
        write(&directory.join(name), text)?;
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
            return copy_into(&shared.with_file_name(import), &lib);
        }
        make(&lib)?;
        import_library("crumple.dll", &abi::exports(shared)?, &lib.join(import))?;
        // The name that MinGW's linker finds for -lcrumple before the static library's.
        return copy(&lib.join(import), &lib.join("libcrumple.dll.a"));
    }
    if built.target.is_macos() {
        return copy_into(shared, &lib);
    }
    let real = format!("libcrumple.so.{}", VERSION);
    copy(shared, &lib.join(&real))?;
    for link in [abi::soname(&VERSION), "libcrumple.so".to_owned()] {
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

/// Writes the import library of a DLL that exports these names.
pub fn import_library(dll: &str, exports: &[String], library: &Path) -> Result<()> {
    let definition = library.with_extension("def");
    write(&definition, format!("LIBRARY {dll}\nEXPORTS\n{}\n", exports.join("\n")))?;
    run!("llvm-dlltool -m i386:x86-64 -d {definition} -l {library}")?;
    fs::remove_file(&definition).with_context(|| format!("removing {}", definition.display()))
}

/// Where the shared library is in a prefix.
pub fn shared(target: &Target, prefix: &Path) -> PathBuf {
    prefix.join(if target.is_windows() { "bin" } else { "lib" }).join(target.shared())
}

/// Checks that a host cannot unload a library for Linux while its threads are still ending, and that a DLL needs only libraries that
/// Windows has.
pub fn loads_well(target: &Target, library: &Path) -> Result<()> {
    if target.is_windows() {
        return needs_windows_alone(library);
    }
    let table = said!("readelf -d {library}")?;
    ensure!(table.contains("NODELETE"), "{} is not NODELETE; build.rs makes it so", library.display());
    Ok(())
}

pub fn needs_windows_alone(library: &Path) -> Result<()> {
    const WINDOWS: &[&str] =
        &["bcryptprimitives.dll", "kernel32.dll", "msvcrt.dll", "ntdll.dll", "userenv.dll", "ws2_32.dll"];
    let bytes = bytes(library)?;
    let imports = object::File::parse(&*bytes)?.imports()?;
    let names: BTreeSet<String> =
        imports.iter().map(|import| String::from_utf8_lossy(import.library()).to_lowercase()).collect();
    let known = |name: &String| WINDOWS.contains(&name.as_str()) || name.starts_with("api-ms-win-");
    let foreign: Vec<_> = names.iter().filter(|name| !known(name)).collect();
    ensure!(foreign.is_empty() && !names.is_empty(), "{} needs {foreign:?}", library.display());
    Ok(())
}
