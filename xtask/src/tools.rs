//! Programs and libraries that the tests need beside Rust. `provide` finds them, and installs missing ones if it may.

use std::collections::BTreeSet;
use std::fmt;
use std::path::{Path, PathBuf};

use anyhow::Result;
use xshell::cmd;

use crate::target::{self, Target};
use crate::wine;
use crate::workspace::{Workspace, empty_directory};

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Tool {
    CMake,
    CCompiler,
    CppCompiler,
    PkgConfig,
    /// Open Dynamics Engine, the rigid bodies of `crash.cpp`.
    Ode,
    /// Bullet, the rigid bodies of `collider.cpp`.
    Bullet,
    Valgrind,
    /// CPython 3.11 with `venv`: the one version that Blender's `bpy` package is built for.
    Python311,
    /// Any CPython 3 with `venv`, for the lab's charts.
    Python3,
    /// The windowing libraries that `bpy` links, although it opens no window.
    BlenderLibraries,
    /// Node's package manager, for the Khronos glTF validator.
    Npm,
    /// Vulkan's loader and validation layers, and Mesa's software driver.
    Vulkan,
    /// Vulkan's headers for C.
    VulkanHeaders,
    /// libabigail's tools, which compare binary interfaces.
    Abigail,
    /// libpng, with which `vulkan_render.cpp` writes its picture.
    Png,
    /// A compiler and a runtime for C#, similar to Unity's.
    Mono,
    /// Rust's standard library for Windows, or its source.
    WindowsRust,
    /// GNU's compilers for Windows.
    Mingw,
    /// Runs programs for Windows.
    Wine,
    /// A display without a screen: Wine's Vulkan needs one.
    Xvfb,
    /// clang, and the linker and tools that behave as Microsoft's.
    Llvm,
    /// Rust's standard library for 64-bit ARM, or its source.
    AarchRust,
    /// GNU's compilers for 64-bit ARM.
    AarchCompiler,
    /// Rust's standard library for 32-bit x86, or its source.
    I686Rust,
    /// GNU's compilers for 32-bit x86.
    I686Compiler,
    /// Rust's standard library for WebAssembly, or its source.
    WebRust,
    /// The browser that the page is tested in.
    Chromium,
    /// Runs programs for 64-bit ARM.
    Qemu,
    /// assimp's command, which converts between file formats.
    Assimp,
}

/// What building and running programs for Windows takes.
pub const WINDOWS_TOOLS: &[Tool] = &[
    Tool::CCompiler,
    Tool::CMake,
    Tool::WindowsRust,
    Tool::Mingw,
    Tool::Wine,
    Tool::Xvfb,
    Tool::Llvm,
    Tool::Vulkan,
    Tool::VulkanHeaders,
];

/// This file shows that the validation layers are installed.
const VALIDATION: &str = "/usr/share/vulkan/explicit_layer.d/VkLayer_khronos_validation.json";

/// The libraries that `bpy` loads, each with its Debian package.
const BLENDER_LIBRARIES: &[(&str, &str)] = &[
    ("libGL.so.1", "libgl1"),
    ("libICE.so.6", "libice6"),
    ("libSM.so.6", "libsm6"),
    ("libX11.so.6", "libx11-6"),
    ("libXext.so.6", "libxext6"),
    ("libXfixes.so.3", "libxfixes3"),
    ("libXi.so.6", "libxi6"),
    ("libXrender.so.1", "libxrender1"),
    ("libxkbcommon.so.0", "libxkbcommon0"),
];

impl Tool {
    pub fn here(self, workspace: &Workspace) -> bool {
        let sh = &workspace.shell;
        let answers = |program: &str| cmd!(sh, "{program} --version").quiet().ignore_stderr().read().is_ok();
        match self {
            Self::WindowsRust | Self::AarchRust | Self::I686Rust | Self::WebRust => {
                self.rust_target().is_some_and(|triple| Target::other(triple).has_rust(workspace))
            }
            Self::Mingw => ["gcc", "g++"].iter().all(|name| answers(&format!("x86_64-w64-mingw32-{name}-posix"))),
            Self::Wine => wine::program().is_some(),
            // It has no option that answers and succeeds.
            Self::Xvfb => std::path::Path::new("/usr/bin/Xvfb").exists(),
            Self::Llvm => ["clang", "lld-link"].iter().all(|name| answers(name)) && answers("llvm-strip"),
            Self::AarchCompiler => ["gcc", "g++"].iter().all(|name| answers(&format!("aarch64-linux-gnu-{name}"))),
            Self::I686Compiler => ["gcc", "g++"].iter().all(|name| answers(&format!("i686-linux-gnu-{name}"))),
            Self::Qemu => answers("qemu-aarch64"),
            Self::Assimp => cmd!(sh, "assimp version").quiet().ignore_stderr().read().is_ok(),
            Self::Chromium => answers("/usr/bin/chromium"),
            Self::CMake => cmd!(sh, "cmake --version").quiet().ignore_stderr().read().is_ok(),
            Self::CCompiler => cmd!(sh, "cc --version").quiet().ignore_stderr().read().is_ok(),
            Self::CppCompiler => cmd!(sh, "c++ --version").quiet().ignore_stderr().read().is_ok(),
            Self::PkgConfig => cmd!(sh, "pkg-config --version").quiet().ignore_stderr().read().is_ok(),
            Self::Ode => package(workspace, "ode"),
            Self::Bullet => package(workspace, "bullet"),
            Self::VulkanHeaders => package(workspace, "vulkan"),
            Self::Png => package(workspace, "libpng"),
            Self::Mono => {
                cmd!(sh, "mcs --version").quiet().ignore_stderr().read().is_ok()
                    && cmd!(sh, "mono --version").quiet().ignore_stderr().read().is_ok()
            }
            Self::Abigail => cmd!(sh, "abidiff --version").quiet().ignore_stderr().read().is_ok(),
            Self::Valgrind => cmd!(sh, "valgrind --version").quiet().ignore_stderr().read().is_ok(),
            Self::Python311 => {
                cmd!(sh, "python3.11 -c 'import ensurepip, venv'").quiet().ignore_stderr().read().is_ok()
            }
            Self::Python3 => cmd!(sh, "python3 -c 'import ensurepip, venv'").quiet().ignore_stderr().read().is_ok(),
            Self::BlenderLibraries if cfg!(not(target_os = "linux")) => true,
            Self::BlenderLibraries => cmd!(sh, "/sbin/ldconfig -p").quiet().read().is_ok_and(|known| {
                BLENDER_LIBRARIES.iter().all(|(file, _)| known.lines().any(|line| line.trim_start().starts_with(file)))
            }),
            Self::Npm => cmd!(sh, "npm --version").quiet().ignore_stderr().read().is_ok(),
            Self::Vulkan => {
                let known = cmd!(sh, "/sbin/ldconfig -p").quiet().ignore_stderr().read().unwrap_or_default();
                known.contains("libvulkan.so.1")
                    && known.contains("libvulkan_lvp.so")
                    && std::path::Path::new(VALIDATION).exists()
            }
        }
    }

    /// Whether `cargo xtask test` installs it without `--all`. Together these are under 200 MB of Debian packages.
    pub fn for_everybody(self) -> bool {
        use Tool::{CCompiler, CMake, CppCompiler, PkgConfig, Png, Vulkan, VulkanHeaders};
        matches!(self, CMake | CCompiler | CppCompiler | PkgConfig | Png | Vulkan | VulkanHeaders)
    }

    /// The system whose standard library this is.
    fn rust_target(self) -> Option<&'static str> {
        match self {
            Self::WindowsRust => Some(target::WINDOWS),
            Self::AarchRust => Some(target::AARCH64),
            Self::I686Rust => Some(target::I686),
            Self::WebRust => Some(target::WEB),
            _ => None,
        }
    }

    fn debian_packages(self) -> Vec<&'static str> {
        let packages: &[&str] = match self {
            Self::BlenderLibraries => return BLENDER_LIBRARIES.iter().map(|(_, package)| *package).collect(),
            Self::CMake => &["cmake", "make"],
            Self::CCompiler => &["gcc", "libc6-dev"],
            Self::CppCompiler => &["g++"],
            Self::PkgConfig => &["pkg-config"],
            Self::Ode => &["pkg-config", "libode-dev"],
            Self::Bullet => &["pkg-config", "libbullet-dev"],
            Self::Valgrind => &["valgrind", "libc6-dbg"],
            Self::Python311 => &["python3.11", "python3.11-venv"],
            Self::Python3 => &["python3", "python3-venv"],
            Self::Npm => &["nodejs", "npm"],
            Self::VulkanHeaders => &["pkg-config", "libvulkan-dev"],
            Self::Png => &["pkg-config", "libpng-dev"],
            Self::Mono => &["mono-mcs", "mono-runtime"],
            Self::WindowsRust | Self::AarchRust | Self::I686Rust | Self::WebRust => {
                &["rustc-web", "cargo-web", "rust-web-src"]
            }
            Self::Mingw => &["g++-mingw-w64-x86-64-posix", "mingw-w64-x86-64-dev"],
            Self::Wine => &["wine64"],
            Self::Xvfb => &["xvfb"],
            Self::Llvm => &["clang", "lld", "llvm"],
            Self::AarchCompiler => &["g++-aarch64-linux-gnu"],
            Self::I686Compiler => &["g++-i686-linux-gnu"],
            Self::Qemu => &["qemu-user"],
            Self::Assimp => &["assimp-utils"],
            Self::Chromium => &["chromium"],
            Self::Abigail => &["abigail-tools"],
            Self::Vulkan => &["libvulkan1", "mesa-vulkan-drivers", "vulkan-validationlayers"],
        };
        packages.to_vec()
    }
}

/// Whether pkg-config knows a library.
fn package(workspace: &Workspace, name: &str) -> bool {
    cmd!(workspace.shell, "pkg-config --exists {name}").quiet().ignore_stderr().run().is_ok()
}

impl fmt::Display for Tool {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::CMake => "CMake",
            Self::CCompiler => "a C compiler",
            Self::CppCompiler => "a C++ compiler",
            Self::PkgConfig => "pkg-config",
            Self::Ode => "the Open Dynamics Engine's headers",
            Self::Bullet => "Bullet's headers",
            Self::Valgrind => "valgrind",
            Self::Python311 => "Python 3.11 with venv",
            Self::Python3 => "Python 3 with venv",
            Self::BlenderLibraries => "X11 and OpenGL libraries for Blender",
            Self::Npm => "npm",
            Self::Vulkan => "Vulkan with Mesa's software driver and the validation layers",
            Self::VulkanHeaders => "Vulkan's headers",
            Self::Png => "libpng's headers",
            Self::Mono => "Mono with its C# compiler",
            Self::Abigail => "libabigail's abidiff",
            Self::WindowsRust => "Rust for Windows (or: rustup target add x86_64-pc-windows-gnu)",
            Self::Mingw => "MinGW's compilers",
            Self::Wine => "Wine",
            Self::Xvfb => "Xvfb",
            Self::Llvm => "LLVM's clang, lld-link and llvm-dlltool",
            Self::AarchRust => "Rust for 64-bit ARM (or: rustup target add aarch64-unknown-linux-gnu)",
            Self::AarchCompiler => "GNU's compilers for 64-bit ARM",
            Self::I686Rust => "Rust for 32-bit x86 (or: rustup target add i686-unknown-linux-gnu)",
            Self::I686Compiler => "GNU's compilers for 32-bit x86",
            Self::Qemu => "qemu-aarch64",
            Self::Assimp => "assimp",
            Self::WebRust => "Rust for WebAssembly (or: rustup target add wasm32-unknown-unknown)",
            Self::Chromium => "Chromium",
        })
    }
}

/// Installs the missing tools of `wanted` on Debian and its derivatives, as root or by sudo. Returns the tools that are still missing.
pub fn provide(workspace: &Workspace, wanted: &BTreeSet<Tool>) -> Result<BTreeSet<Tool>> {
    for triple in still_missing(workspace, wanted).iter().filter_map(|tool| tool.rust_target()) {
        // Where there is no rustup, or it reaches nothing, a package of the distribution follows.
        let _ = cmd!(workspace.shell, "rustup target add {triple}").ignore_stderr().run();
    }
    let missing = still_missing(workspace, wanted);
    if missing.is_empty() {
        return Ok(missing);
    }
    let packages = packages_of(&missing);
    if let Some(apt) = apt(workspace) {
        println!("installing what is missing: {}", packages.join(" "));
        // Errors are ignored here: one package that the release lacks must not stop the others, and missing tools are reported below.
        let _ = apt(&["update"]);
        if apt(&install_arguments(&packages)).is_err() {
            for package in &packages {
                let _ = apt(&install_arguments(&[package]));
            }
        }
    }
    let missing = still_missing(workspace, wanted);
    if !missing.is_empty() {
        println!("{}", advice(&missing));
    }
    Ok(missing)
}

/// The command that installs the missing tools.
pub fn advice(missing: &BTreeSet<Tool>) -> String {
    let names: Vec<String> = missing.iter().map(Tool::to_string).collect();
    let packages = packages_of(missing).join(" ");
    format!("missing: {}. On Debian or Ubuntu type: sudo apt-get install {packages}", names.join(", "))
}

fn install_arguments<'a>(packages: &[&'a str]) -> Vec<&'a str> {
    ["install", "--no-install-recommends"].into_iter().chain(packages.iter().copied()).collect()
}

fn packages_of(tools: &BTreeSet<Tool>) -> Vec<&'static str> {
    let set: BTreeSet<&str> = tools.iter().flat_map(|tool| tool.debian_packages()).collect();
    set.into_iter().collect()
}

fn still_missing(workspace: &Workspace, wanted: &BTreeSet<Tool>) -> BTreeSet<Tool> {
    wanted.iter().copied().filter(|tool| !tool.here(workspace)).collect()
}

/// Installs packages of npm, `NAME@VERSION`, below a folder that has nothing else, if they are not there. Returns their folder.
pub fn npm(workspace: &Workspace, directory: &Path, packages: &[&str]) -> Result<PathBuf> {
    let modules = directory.join("node_modules");
    let name = |package: &str| package.split('@').next().unwrap_or_default().to_owned();
    if !packages.iter().all(|package| modules.join(name(package)).is_dir()) {
        empty_directory(directory)?;
        let install = ["install", "--loglevel=error", "--no-audit", "--no-fund", "--prefix"];
        cmd!(workspace.shell, "npm {install...} {directory} {packages...}").run()?;
    }
    Ok(modules)
}

/// Updates the list of packages if we may.
pub fn refresh(workspace: &Workspace) {
    if let Some(apt) = apt(workspace) {
        let _ = apt(&["update"]);
    }
}

/// Runs `apt-get` with these arguments. `None` if we may not.
fn apt(workspace: &Workspace) -> Option<impl Fn(&[&str]) -> xshell::Result<()>> {
    let privilege = privilege(workspace)?;
    let sh = &workspace.shell;
    Some(move |arguments: &[&str]| {
        let (program, rest) = (privilege[0], &privilege[1..]);
        cmd!(sh, "{program} {rest...} DEBIAN_FRONTEND=noninteractive apt-get -q -y {arguments...}").run()
    })
}

/// The words before `NAME=value apt-get`: `env` for root, `sudo -n env` if sudo needs no password, otherwise `None`.
fn privilege(workspace: &Workspace) -> Option<&'static [&'static str]> {
    let sh = &workspace.shell;
    if cfg!(not(target_os = "linux")) || cmd!(sh, "apt-get --version").quiet().ignore_stderr().read().is_err() {
        return None;
    }
    let root = cmd!(sh, "id -u").quiet().read().is_ok_and(|id| id.trim() == "0");
    if root {
        return Some(&["env"]);
    }
    let sudo = cmd!(sh, "sudo -n true").quiet().ignore_stderr().run().is_ok();
    sudo.then_some(&["sudo", "-n", "env"])
}
