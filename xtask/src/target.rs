//! The system that a library is built for: this machine's, or one of those that this machine only compiles for.

use std::path::{Path, PathBuf};

use anyhow::Result;
use xshell::Cmd;

use crate::workspace::{FLAGS, anywhere, cargo, cargo_anywhere, cmd, in_target, rustc_says, target_folder};

pub const WINDOWS: &str = "x86_64-pc-windows-gnu";
pub const AARCH64: &str = "aarch64-unknown-linux-gnu";
pub const I686: &str = "i686-unknown-linux-gnu";
pub const WEB: &str = "wasm32-unknown-unknown";

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

    /// A variable by which Cargo is told something about this system: `LINKER`, `RUNNER`.
    pub fn variable(&self, what: &str) -> String {
        format!("CARGO_TARGET_{}_{what}", self.triple.to_uppercase().replace('-', "_"))
    }

    /// Cargo with these arguments, building for this system with no path of this machine in the binaries.
    pub fn cargo(&self, arguments: &[&str]) -> Result<Cmd<'static>> {
        if !self.cross {
            return cargo_anywhere(arguments);
        }
        // A warning here is one that the lints of this machine's system do not see. Every browser of the last years has vectors.
        let web = self.triple == WEB;
        let own = if web { "\u{1f}-Ctarget-feature=+simd128" } else { "" };
        let flags = format!("{}\u{1f}--deny=warnings{own}", anywhere()?);
        // Builds for this system do not wait for it.
        let cargo =
            cargo(arguments).args(["--target", &self.triple]).env("CARGO_TARGET_DIR", cross()).env(FLAGS, flags);
        Ok(if web { cargo } else { cargo.env(self.variable("LINKER"), self.gnu("gcc")) })
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
