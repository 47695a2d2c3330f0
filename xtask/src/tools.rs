//! Programs and libraries that the tests need beside Rust. `provide` finds them, and installs missing ones if it may.

use std::collections::BTreeSet;
use std::path::Path;

use anyhow::{Result, ensure};

use crate::target::{AARCH64, I686, Target, WEB, WINDOWS};
use crate::wine;
use crate::workspace::{cmd, said, silent};

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub struct Tool {
    name: &'static str,
    /// The packages of Debian that have it.
    packages: &'static str,
    sign: Sign,
}

/// What shows that a tool is here.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
enum Sign {
    /// Calls of programs that all end well, separated by commas. A program alone is asked for its `--version`.
    Calls(&'static str),
    /// Libraries that the system's loader finds.
    Loaded(&'static str),
    /// A system that Rust can compile for.
    Rust(&'static str),
    /// One of these files.
    File(&'static [&'static str]),
}

use Sign::{Calls, File, Loaded, Rust};

macro_rules! tools {
    ($($(#[$doc:meta])* $constant:ident: $name:expr, $packages:expr, $sign:expr;)*) => {
        $($(#[$doc])* pub const $constant: Tool = Tool { name: $name, packages: $packages, sign: $sign };)*
    };
}

const FOR_RUST: &str = "rustc-web cargo-web rust-web-src";
pub const SWIFTSHADER_LIBRARY: &str = "/usr/lib/chromium/libvk_swiftshader.so";

tools! {
    CMAKE: "CMake", "cmake make", Calls("cmake");
    CC: "a C compiler", "gcc libc6-dev", Calls("cc");
    CXX: "a C++ compiler", "g++", Calls("c++");
    PKG_CONFIG: "pkg-config", "pkg-config", Calls("pkg-config");
    /// The rigid bodies of `crash.cpp`.
    ODE: "the Open Dynamics Engine's headers", "pkg-config libode-dev", Calls("pkg-config --exists ode");
    /// The rigid bodies of `collider.cpp`.
    BULLET: "Bullet's headers", "pkg-config libbullet-dev", Calls("pkg-config --exists bullet");
    VALGRIND: "valgrind", "valgrind libc6-dbg", Calls("valgrind");
    /// The one version that Blender's `bpy` package is built for.
    PYTHON311: "Python 3.11 with venv", "python3.11 python3.11-venv", Calls("python3.11 -m ensurepip --version");
    /// Any version, for the lab's charts.
    PYTHON3: "Python 3 with venv", "python3 python3-venv", Calls("python3 -m ensurepip --version");
    /// The windowing libraries that `bpy` links, although it opens no window.
    BLENDER_LIBRARIES: "X11 and OpenGL libraries for Blender",
        "libgl1 libice6 libsm6 libx11-6 libxext6 libxfixes3 libxi6 libxkbcommon0 libxrender1",
        Loaded("libGL.so.1 libICE.so.6 libSM.so.6 libX11.so.6 libXext.so.6 libXfixes.so.3 libXi.so.6 libXrender.so.1 \
                libxkbcommon.so.0");
    /// Installs the Khronos glTF validator and what the page draws with.
    NPM: "npm", "nodejs npm", Calls("npm");
    VULKAN: "Vulkan with Mesa's software driver and the validation layers",
        "libvulkan1 mesa-vulkan-drivers vulkan-validationlayers",
        Loaded("libvulkan.so.1 libvulkan_lvp.so libVkLayer_khronos_validation.so");
    /// Vulkan's other software driver, in Debian's Chromium.
    SWIFTSHADER: "SwiftShader", "chromium-common", File(&[SWIFTSHADER_LIBRARY]);
    VULKAN_HEADERS: "Vulkan's headers", "pkg-config libvulkan-dev", Calls("pkg-config --exists vulkan");
    /// Its tools compare binary interfaces.
    ABIGAIL: "libabigail's abidiff", "abigail-tools", Calls("abidiff");
    /// `vulkan_render.cpp` writes its picture with it.
    PNG: "libpng's headers", "pkg-config libpng-dev", Calls("pkg-config --exists libpng");
    /// Similar to Unity's C#.
    MONO: "Mono with its C# compiler", "mono-mcs mono-runtime", Calls("mcs, mono");
    WINDOWS_RUST: "Rust for Windows (or: rustup target add x86_64-pc-windows-gnu)", FOR_RUST, Rust(WINDOWS);
    MINGW: "MinGW's compilers", "g++-mingw-w64-x86-64-posix mingw-w64-x86-64-dev",
        Calls("x86_64-w64-mingw32-gcc-posix, x86_64-w64-mingw32-g++-posix");
    WINE: "Wine", "wine64", File(wine::PROGRAMS);
    XVFB: "Xvfb", "xvfb", File(&["/usr/bin/Xvfb"]);
    LLVM: "LLVM's clang, lld-link and llvm-dlltool", "clang lld llvm", Calls("clang, lld-link, llvm-strip");
    AARCH64_RUST: "Rust for 64-bit ARM (or: rustup target add aarch64-unknown-linux-gnu)", FOR_RUST, Rust(AARCH64);
    AARCH64_CC: "GNU's compilers for 64-bit ARM", "g++-aarch64-linux-gnu",
        Calls("aarch64-linux-gnu-gcc, aarch64-linux-gnu-g++");
    I686_RUST: "Rust for 32-bit x86 (or: rustup target add i686-unknown-linux-gnu)", FOR_RUST, Rust(I686);
    I686_CC: "GNU's compilers for 32-bit x86", "g++-i686-linux-gnu", Calls("i686-linux-gnu-gcc, i686-linux-gnu-g++");
    WEB_RUST: "Rust for WebAssembly (or: rustup target add wasm32-unknown-unknown)", FOR_RUST, Rust(WEB);
    CHROMIUM: "Chromium", "chromium", Calls("/usr/bin/chromium");
    QEMU: "qemu-aarch64", "qemu-user", Calls("qemu-aarch64");
    ASSIMP: "assimp", "assimp-utils", Calls("assimp version");
}

/// What building and running programs for Windows takes.
pub const FOR_WINDOWS: &[Tool] = &[CC, CMAKE, WINDOWS_RUST, MINGW, WINE, XVFB, LLVM, VULKAN, VULKAN_HEADERS];
/// What stages of everybody want, and get with `--all` only. The rest of what they use is under 200 MB of Debian packages.
pub const FOR_ALL: &[Tool] = &[ODE, BULLET, SWIFTSHADER];

impl Tool {
    pub fn here(self) -> bool {
        let ends_well = |call: &str| {
            let mut words = call.split(' ');
            let (program, version) = (words.next(), (!call.contains(' ')).then_some("--version"));
            let quiet =
                |program: &str| cmd!("{program} {words...} {version...}").quiet().ignore_stdout().ignore_stderr();
            program.is_some_and(|program| quiet(program).run().is_ok())
        };
        match self.sign {
            Calls(calls) => calls.split(", ").all(ends_well),
            Loaded(names) => said!("/sbin/ldconfig -p").is_ok_and(|known| {
                names.split(' ').all(|name| known.lines().any(|line| line.trim_start().starts_with(name)))
            }),
            Rust(triple) => Target::other(triple).has_rust(),
            File(paths) => paths.iter().any(|path| Path::new(path).exists()),
        }
    }
}

/// Installs the missing tools of `wanted` on Debian and its derivatives, as root or by sudo. Returns the tools that are still missing.
pub fn provide<'t>(wanted: impl IntoIterator<Item = &'t Tool>) -> Vec<Tool> {
    let mut missing: Vec<Tool> = wanted.into_iter().copied().collect::<BTreeSet<_>>().into_iter().collect();
    missing.retain(|tool| !tool.here());
    for tool in &missing {
        if let Rust(triple) = tool.sign {
            // Where there is no rustup, or it reaches nothing, a package of the distribution follows.
            let _ = cmd!("rustup target add {triple}").ignore_stderr().run();
        }
    }
    missing.retain(|tool| !tool.here());
    let packages = packages_of(&missing);
    if let Some(privilege) = privilege().filter(|_| !packages.is_empty()) {
        println!("installing what is missing: {}", packages.join(" "));
        let apt = |what: &[&str], packages: &[&str]| {
            cmd!("env {privilege...} env DEBIAN_FRONTEND=noninteractive apt-get -q -y {what...} {packages...}").run()
        };
        // Errors are ignored here: one package that the release lacks must not stop the others, and missing tools are reported below.
        let _ = apt(&["update"], &[]);
        let install = ["install", "--no-install-recommends"];
        if apt(&install, &packages).is_err() {
            packages.iter().for_each(|package| drop(apt(&install, &[package])));
        }
        missing.retain(|tool| !tool.here());
    }
    if !missing.is_empty() {
        println!("{}", advice(&missing));
    }
    missing
}

pub fn require(wanted: &[Tool]) -> Result<()> {
    let missing = provide(wanted);
    ensure!(missing.is_empty(), "{}", advice(&missing));
    Ok(())
}

/// The command that installs the missing tools.
pub fn advice(missing: &[Tool]) -> String {
    let names: Vec<&str> = missing.iter().map(|tool| tool.name).collect();
    let packages = packages_of(missing).join(" ");
    format!("missing: {}. On Debian or Ubuntu type: sudo apt-get install {packages}", names.join(", "))
}

fn packages_of(tools: &[Tool]) -> Vec<&'static str> {
    tools.iter().flat_map(|tool| tool.packages.split(' ')).collect::<BTreeSet<_>>().into_iter().collect()
}

/// What `apt-get` is called with: nothing as root, or a sudo that needs no password. `None` if there is neither, or no `apt-get`.
fn privilege() -> Option<&'static [&'static str]> {
    silent!("apt-get --version").ok()?;
    let root = said!("id -u").is_ok_and(|id| id.trim() == "0");
    let sudo = || cmd!("sudo -n true").quiet().ignore_stderr().run().ok().map(|()| &["sudo", "-n"][..]);
    if root { Some(&[]) } else { sudo() }
}
