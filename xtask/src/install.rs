//! `cargo xtask install`: the C library as others want to find it, in a tree that may be moved anywhere afterwards.
//!
//! ```text
//! PREFIX/include/crumple.h, crumple.hpp
//! PREFIX/lib/libcrumple.so.0.1.0, libcrumple.so.0.1, libcrumple.so, libcrumple.a, static-libraries.txt
//! PREFIX/lib/cmake/Crumple/*.cmake
//! PREFIX/lib/pkgconfig/crumple.pc
//! PREFIX/share/licenses/crumple/
//! ```

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use object::Endianness;
use object::elf::{DF_1_NODELETE, DT_FLAGS_1, DT_SONAME, FileHeader64};
use object::read::elf::{Dynamic, FileHeader};

use crate::workspace::Workspace;

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Profile {
    Debug,
    Release,
    /// What archives hold.
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
    pub shared: PathBuf,
    /// What a program links with to use `shared`: another file only on Windows.
    #[cfg_attr(not(windows), expect(dead_code, reason = "read where there are DLLs"))]
    import: Option<PathBuf>,
    static_library: PathBuf,
    /// Linker arguments that a program needs beside `static_library`, such as `-lpthread`.
    static_needs: Vec<String>,
    /// What of `FEATURES` it has.
    features: &'static [&'static str],
}

/// Builds the library that C programs get. A debug build is the one that the tests use, which has all features. `features`: what a
/// package has; the others have `FEATURES`.
pub fn build(workspace: &Workspace, profile: Profile, features: &'static [&'static str]) -> Result<Built> {
    match profile {
        Profile::Debug => workspace.build_as_tested(&["--lib"]).run()?,
        Profile::Release => {
            let release = ["build", "--release", "--lib", "--package", "crumple", "--features", "host-allocator"];
            workspace.cargo_anywhere(&release)?.run()?;
        }
        Profile::Dist => {
            let features = features.join(",");
            // Only a library for other languages alone is optimized at link time.
            let dist =
                ["rustc", "--profile", "dist", "--lib", "--crate-type", "cdylib,staticlib", "--package", "crumple"];
            workspace.cargo_anywhere(&dist)?.args(["--no-default-features", "--features", &features]).run()?;
        }
    }
    let directory = workspace.target.join(profile.directory());
    let (shared, import, static_library) = if cfg!(windows) {
        ("crumple.dll", Some("crumple.dll.lib"), "crumple.lib")
    } else if cfg!(target_os = "macos") {
        ("libcrumple.dylib", None, "libcrumple.a")
    } else {
        ("libcrumple.so", None, "libcrumple.a")
    };
    Ok(Built {
        shared: directory.join(shared),
        import: import.map(|name| directory.join(name)),
        static_library: directory.join(static_library),
        static_needs: static_needs(workspace)?,
        features,
    })
}

/// What Rust's standard library itself links with, as `rustc` says it for an empty static library.
fn static_needs(workspace: &Workspace) -> Result<Vec<String>> {
    let scratch = tempfile::tempdir()?;
    let source = scratch.path().join("empty.rs");
    fs::write(&source, "")?;
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let output = xshell::cmd!(workspace.shell, "{rustc} --crate-type staticlib --print native-static-libs {source} -o")
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
    let built = build(workspace, profile, FEATURES)?;
    let prefix = workspace.path(prefix);
    lay_out(workspace, &built, &prefix)?;
    println!("installed Crumple {} ({}) in {}", workspace.version, profile.directory(), prefix.display());
    Ok(())
}

/// Copies what was built, and what goes with it, to where others look for it.
pub fn lay_out(workspace: &Workspace, built: &Built, prefix: &Path) -> Result<()> {
    let lib = prefix.join("lib");
    copy_shared(workspace, built, prefix)?;
    copy(&built.static_library, &lib)?;
    for header in ["include/crumple.h", "include/crumple.hpp"] {
        copy(&workspace.path(header), &prefix.join("include"))?;
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

#[cfg(unix)]
fn copy_shared(workspace: &Workspace, built: &Built, prefix: &Path) -> Result<()> {
    let lib = prefix.join("lib");
    if cfg!(target_os = "macos") {
        return copy(&built.shared, &lib).map(drop);
    }
    let real = format!("libcrumple.so.{}", workspace.version);
    copy_as(&built.shared, &lib, &real)?;
    for link in [soname(&built.shared)?, "libcrumple.so".to_owned()] {
        let link = lib.join(link);
        if link.symlink_metadata().is_ok() {
            fs::remove_file(&link)?;
        }
        std::os::unix::fs::symlink(&real, &link).with_context(|| format!("linking {}", link.display()))?;
    }
    Ok(())
}

#[cfg(windows)]
fn copy_shared(_: &Workspace, built: &Built, prefix: &Path) -> Result<()> {
    copy(&built.shared, &prefix.join("bin"))?;
    let import = built.import.as_ref().context("a DLL has an import library")?;
    copy(import, &prefix.join("lib")).map(drop)
}

/// The name that programs built with `library` ask the loader for; `build.rs` gave it that.
pub fn soname(library: &Path) -> Result<String> {
    let name = dynamic(library)?.into_iter().find(|(entry, _)| entry.tag == DT_SONAME).map(|(_, text)| text);
    name.with_context(|| format!("{} has no SONAME; build.rs gives it one", library.display()))
}

/// A library whose threads may still be ending is not to be taken out of memory; `build.rs` sees to it.
pub fn stays_loaded(library: &Path) -> Result<()> {
    let flags = dynamic(library)?.into_iter().find(|(entry, _)| entry.tag == DT_FLAGS_1);
    let flags = flags.map_or(0, |(entry, _)| entry.val);
    ensure!(flags & u64::from(DF_1_NODELETE) != 0, "{} is not NODELETE; build.rs makes it so", library.display());
    Ok(())
}

/// What a library tells the loader, each entry with its text where it is one.
fn dynamic(library: &Path) -> Result<Vec<(Dynamic, String)>> {
    let bytes = fs::read(library).with_context(|| format!("reading {}", library.display()))?;
    let header = FileHeader64::<Endianness>::parse(&*bytes)?;
    let endian = header.endian()?;
    let table = header.sections(endian, &*bytes)?.dynamic_table(endian, &*bytes)?;
    let text = |entry: Dynamic| if entry.is_string() { table.string(entry).unwrap_or_default() } else { &[] };
    Ok(table.iter().map(|entry| (entry, String::from_utf8_lossy(text(entry)).into_owned())).collect())
}

/// Copies `cmake/NAME.in` to `directory/NAME` with every `@KEY@` replaced.
fn fill(workspace: &Workspace, built: &Built, template: &str, directory: &Path) -> Result<()> {
    let text = fs::read_to_string(workspace.path(template)).with_context(|| format!("reading {template}"))?;
    let libraries: Vec<&str> = built.static_needs.iter().map(|flag| flag.strip_prefix("-l").unwrap_or(flag)).collect();
    let values = [
        ("@CRUMPLE_VERSION@", workspace.version.clone()),
        ("@CRUMPLE_SONAME@", if cfg!(target_os = "linux") { soname(&built.shared)? } else { String::new() }),
        ("@CRUMPLE_STATIC_LIBS@", built.static_needs.join(" ")),
        ("@CRUMPLE_STATIC_LIBS_CMAKE@", libraries.join(";")),
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

fn copy(file: &Path, directory: &Path) -> Result<PathBuf> {
    let name = file.file_name().with_context(|| format!("{} has no file name", file.display()))?;
    copy_as(file, directory, &name.to_string_lossy())
}

pub fn copy_as(file: &Path, directory: &Path, name: &str) -> Result<PathBuf> {
    fs::create_dir_all(directory).with_context(|| format!("creating {}", directory.display()))?;
    let to = directory.join(name);
    // A program that runs from the old file keeps it: the new one must be a new file, not the same one overwritten.
    if to.exists() {
        fs::remove_file(&to).with_context(|| format!("replacing {}", to.display()))?;
    }
    fs::copy(file, &to).with_context(|| format!("copying {} to {}", file.display(), to.display()))?;
    Ok(to)
}
