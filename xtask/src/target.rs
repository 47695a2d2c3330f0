//! The system that a library is built for: this machine's, or one of those that this machine only compiles for.

use std::path::{Path, PathBuf};

use anyhow::Result;
use regex_lite::Regex;
use xshell::Cmd;

use crate::files::read;
use crate::workspace::{FLAGS, anywhere, cargo_anywhere, cmd, in_target, rustc_says, sysroot, target_folder};

pub const WINDOWS: &str = "x86_64-pc-windows-gnu";
pub const AARCH64: &str = "aarch64-unknown-linux-gnu";
pub const I686: &str = "i686-unknown-linux-gnu";
pub const WEB: &str = "wasm32-unknown-unknown";

/// Rust as Debian packages it. With the source of the standard library (rust-web-src) it compiles for any system.
const DEBIAN_CARGO: &str = "/usr/bin/cargo";
const DEBIAN_RUSTC: &str = "/usr/bin/rustc";
const DEBIAN_SOURCE: &str = "/usr/lib/rustlib/src/rust/library";

#[derive(Clone)]
pub struct Target {
    pub triple: String,
    /// Whether it is another system than this machine's.
    pub cross: bool,
}

impl Target {
    pub fn host() -> Result<Self> {
        Ok(Self { triple: rustc_says("host")?, cross: false })
    }

    pub fn other(triple: &str) -> Self {
        Self { triple: triple.to_owned(), cross: true }
    }

    pub fn is_windows(&self) -> bool {
        self.triple.contains("-windows")
    }

    /// Windows with the tools of MinGW instead of Microsoft's.
    pub fn is_mingw(&self) -> bool {
        self.triple.ends_with("-windows-gnu")
    }

    pub fn is_macos(&self) -> bool {
        self.triple.contains("-apple-darwin")
    }

    pub fn is_linux(&self) -> bool {
        self.triple.contains("-linux")
    }

    pub fn pointer_bytes(&self) -> u32 {
        if ["i686-", "wasm32-"].iter().any(|start| self.triple.starts_with(start)) { 4 } else { 8 }
    }

    /// The file of the shared library, as Cargo names it.
    pub fn shared(&self) -> &'static str {
        let unix = if self.is_macos() { "libcrumple.dylib" } else { "libcrumple.so" };
        if self.is_windows() { "crumple.dll" } else { unix }
    }

    /// The shared library in an installed folder.
    pub fn shared_in(&self, prefix: &Path) -> PathBuf {
        prefix.join(if self.is_windows() { "bin" } else { "lib" }).join(self.shared())
    }

    /// The file of the static library, as Cargo names it.
    pub fn static_library(&self) -> &'static str {
        if self.is_windows() && !self.is_mingw() { "crumple.lib" } else { "libcrumple.a" }
    }

    pub fn program(&self, name: &str) -> String {
        if self.is_windows() { format!("{name}.exe") } else { name.to_owned() }
    }

    /// The folder that holds the builds of a profile.
    pub fn folder(&self, profile: &str) -> PathBuf {
        if self.cross { cross().join(&self.triple) } else { target_folder() }.join(profile)
    }

    /// A program that Cargo built.
    pub fn built(&self, profile: &str, program: &str) -> PathBuf {
        self.folder(profile).join(self.program(program))
    }

    /// A program of GNU's compiler or binutils for this system: `gcc`, `strip`.
    pub fn gnu(&self, program: &str) -> String {
        let known = [(WINDOWS, "x86_64-w64-mingw32-"), (AARCH64, "aarch64-linux-gnu-"), (I686, "i686-linux-gnu-")];
        let prefix = known.iter().find(|(triple, _)| self.cross && self.triple == *triple).map_or("", |known| known.1);
        format!("{prefix}{program}")
    }

    /// Whether Rust can compile for it, with its own standard library or from Debian's source of it.
    pub fn has_rust(&self) -> bool {
        let exists = |path: &&str| Path::new(path).exists();
        self.has_standard_library() || [DEBIAN_CARGO, DEBIAN_RUSTC, DEBIAN_SOURCE].iter().all(exists)
    }

    /// Whether the toolchain that runs this program has the standard library for it: rustup installs that.
    pub fn has_standard_library(&self) -> bool {
        !self.cross || sysroot().is_ok_and(|root| root.join("lib/rustlib").join(&self.triple).join("lib").is_dir())
    }

    /// `NAME-VERSION` of the packages that the standard library is compiled from, if it is compiled here.
    pub fn standard_packages(&self) -> Result<Vec<String>> {
        if self.has_standard_library() {
            return Ok(Vec::new());
        }
        let lock = read(Path::new(DEBIAN_SOURCE).join("Cargo.lock"))?;
        let package = Regex::new("name = \"(.+)\"\nversion = \"(.+)\"")?;
        Ok(package.captures_iter(&lock).map(|found| format!("{}-{}", &found[1], &found[2])).collect())
    }

    /// A variable by which Cargo is told something about this system: `LINKER`, `RUNNER`.
    pub fn variable(&self, what: &str) -> String {
        format!("CARGO_TARGET_{}_{what}", self.triple.to_uppercase().replace('-', "_"))
    }

    /// The system libraries that Rust's standard library links there.
    pub fn static_needs(&self) -> &'static str {
        let windows = "-lkernel32 -lntdll -luserenv -lws2_32 -ldbghelp";
        if self.is_windows() { windows } else { "-lgcc_s -lutil -lrt -lpthread -lm -ldl -lc" }
    }

    /// Cargo with these arguments, building for this system with no path of this machine in the binaries.
    pub fn cargo(&self, arguments: &[&str]) -> Result<Cmd<'static>> {
        if !self.cross {
            return cargo_anywhere(arguments);
        }
        // A warning here is one that the lints of this machine's system do not see. Every browser of the last years has vectors.
        let (web, triple) = (self.triple == WEB, &self.triple);
        let own = if web { "\u{1f}-Ctarget-feature=+simd128" } else { "" };
        let flags = format!("{}\u{1f}--deny=warnings{own}", anywhere()?);
        let (first, rest) = arguments.split_first().unwrap_or((&"", &[]));
        let cargo = if self.has_standard_library() {
            cmd!("cargo {first} --target {triple}")
        } else {
            // Cargo calls this unstable. Debian's Rust has no compiled standard library for other systems.
            let source = format!("-Zbuild-std=std,{},test", if web { "panic_abort" } else { "panic_unwind" });
            let cargo = cmd!("{DEBIAN_CARGO} {first} {source} --target {triple}");
            cargo.env("RUSTC", DEBIAN_RUSTC).env("RUSTC_BOOTSTRAP", "1")
        };
        let linker = if web { "wasm-ld".to_owned() } else { self.gnu("gcc") };
        // Builds for this system do not wait for it.
        let cargo = cargo.env("CARGO_TARGET_DIR", cross()).env(self.variable("LINKER"), linker);
        Ok(cargo.env(FLAGS, flags).args(rest))
    }
}

/// Cargo's target directory for other systems.
fn cross() -> PathBuf {
    in_target("cross")
}

/// Runs a program in the shell's folder. `runner` is a program that runs it, with arguments, or empty.
pub fn launch(runner: &[&str], program: &Path) -> Cmd<'static> {
    cmd!("env {runner...} {program}").quiet()
}
