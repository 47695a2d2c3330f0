//! `cargo xtask test` and `cargo xtask ci`: the list of test stages, and which stages a command runs.

use anyhow::{Result, bail};
use clap::Args;

use crate::ci::CHECKS;
use crate::stage::{self, Outcome, Rules, Stage};
use crate::tools::{self, Tool};
use crate::workspace::Workspace;
use crate::{
    abi, blender, car, csharp, demo, engines, exporters, fuzz, godot, native, nightly, package, peers, platforms,
    python, source, valgrind, vulkan, web,
};

#[derive(Args, Default)]
pub struct Options {
    /// Run every stage: also engines, other systems, sanitizers, fuzzing and packages
    #[arg(long)]
    pub all: bool,
    /// Fail a stage if a program that it needs is missing; CI=true sets this too
    #[arg(long)]
    pub require_all: bool,
    /// The same as without options
    #[arg(long, hide = true, conflicts_with_all = ["all", "only"])]
    pub quick: bool,
    /// Run only this stage, or this check of `cargo xtask ci`; may be given several times
    #[arg(long, value_name = "STAGE")]
    pub only: Vec<String>,
    /// Stop at the first stage that fails
    #[arg(long)]
    pub fail_fast: bool,
}

/// The stages of `cargo xtask test` without options: everybody can run them within minutes.
const FOR_EVERYBODY: &[&str] = &["install", "cmake", "vulkan", "rust", "ctest"];

/// In the order in which they run: what is compiled ahead runs late. A new kind of test is one more entry here.
const STAGES: &[Stage] = &[
    Stage {
        name: "install",
        shows: "the C library installs into target/prefix and exports what the header declares",
        needs: &[Tool::CCompiler],
        wants: &[],
        leaves: &[],
        run: native::install_release,
    },
    Stage {
        name: "cmake",
        shows: "a CMake project that fetches the source builds it by Cargo, and installs what the installer does",
        needs: &[Tool::CCompiler, Tool::CppCompiler, Tool::CMake],
        wants: &[],
        leaves: &["cmake"],
        run: source::cmake,
    },
    Stage {
        name: "conan",
        shows: "Conan makes a package from the source, and a program finds it",
        needs: &[Tool::CCompiler, Tool::CppCompiler, Tool::CMake, Tool::Python3],
        wants: &[],
        leaves: &["conan", "conan-venv"],
        run: source::conan,
    },
    Stage {
        name: "package",
        shows: "the unpacked archive matches its manifest, and its examples run by CMake and pkg-config, shared and static",
        needs: &[Tool::CCompiler, Tool::CppCompiler, Tool::CMake, Tool::PkgConfig],
        wants: &[Tool::Ode, Tool::Bullet, Tool::VulkanHeaders, Tool::Png],
        leaves: &[],
        run: package::stage,
    },
    Stage {
        name: "abi",
        shows: "programs built against the last release fit the header of today",
        needs: &[Tool::CCompiler, Tool::Abigail],
        wants: &[],
        leaves: &[],
        run: abi::stage,
    },
    Stage {
        name: "csharp",
        shows: "the C# layer works under Mono and rejects libraries that do not fit",
        needs: &[Tool::CCompiler, Tool::Mono],
        wants: &[],
        leaves: &[],
        run: csharp::run,
    },
    Stage {
        name: "python",
        shows: "the Python package works as a wheel in an environment of its own, and makes examples for bare meshes",
        needs: &[Tool::CCompiler, Tool::Python311],
        wants: &[],
        leaves: &[],
        run: python::stage,
    },
    Stage {
        name: "sanitizers",
        shows: "the C and C++ tests pass under gcc's address and undefined behaviour sanitizers",
        needs: &[Tool::CCompiler, Tool::CppCompiler, Tool::CMake],
        wants: &[Tool::Ode, Tool::Bullet, Tool::Vulkan, Tool::VulkanHeaders, Tool::Png],
        leaves: &["ctest/sanitizers"],
        run: native::sanitizers,
    },
    Stage {
        name: "valgrind-c",
        shows: "valgrind finds no error and no leak in the C and C++ tests",
        needs: &[Tool::CCompiler, Tool::CppCompiler, Tool::CMake, Tool::Valgrind],
        wants: &[Tool::Ode, Tool::Bullet, Tool::Vulkan, Tool::VulkanHeaders, Tool::Png],
        leaves: &[],
        run: valgrind::c,
    },
    Stage {
        name: "valgrind-rust",
        shows: "valgrind finds no error and no leak in the Rust tests",
        needs: &[Tool::Valgrind],
        wants: &[],
        leaves: &[],
        run: valgrind::rust,
    },
    Stage {
        name: "engines",
        shows: "every truth's hits thrown in rapier, Bullet and Jolt leave what their blows leave",
        needs: &[Tool::CCompiler, Tool::CppCompiler, Tool::CMake, Tool::Bullet],
        wants: &[],
        leaves: &["jolt", "throws"],
        run: engines::stage,
    },
    Stage {
        name: "demo",
        shows: "`cargo xtask demo` crashes the car",
        needs: &[],
        wants: &[],
        leaves: &[],
        run: demo::check,
    },
    Stage {
        name: "car",
        shows: "the car's script makes a car: parts, sizes, closed inner solids, normals, symmetry, valid glTF",
        needs: &[Tool::Python3],
        wants: &[Tool::Npm],
        leaves: &[],
        run: car::stage,
    },
    Stage {
        name: "blender",
        shows: "Blender opens what the command exports",
        needs: &[Tool::Python311, Tool::BlenderLibraries],
        wants: &[],
        leaves: &[],
        run: peers::opens_exports,
    },
    Stage {
        name: "extension",
        shows: "the packed Blender extension works in two Blenders without a window and in one with a window",
        needs: &[Tool::CCompiler, Tool::Python311, Tool::BlenderLibraries],
        wants: &[Tool::Xvfb],
        leaves: &["blender-bpy50", "blender-window"],
        run: blender::stage,
    },
    Stage {
        name: "gltf-validator",
        shows: "the Khronos validator finds nothing wrong with what the command exports",
        needs: &[Tool::Npm],
        wants: &[],
        leaves: &[],
        run: peers::gltf_validator,
    },
    Stage {
        name: "crate",
        shows: "the crate builds from the files that crates.io gets",
        needs: &[],
        wants: &[],
        leaves: &["crate"],
        run: source::crates_io,
    },
    Stage {
        name: "godot",
        shows: "the extension dents meshes in Godot itself: its classes, both physics engines, the editor's import, a picture",
        needs: &[Tool::CCompiler, Tool::Xvfb],
        wants: &[],
        leaves: &["godot"],
        run: godot::run,
    },
    Stage {
        name: "exporters",
        shows: "what Blender, three.js, assimp, trimesh and Godot write is read, and everything that no dent reached is kept",
        needs: &[Tool::Python311, Tool::BlenderLibraries, Tool::Npm, Tool::Assimp],
        wants: &[],
        leaves: &["blender-bpy42", "godot-engine"],
        run: exporters::stage,
    },
    Stage {
        name: "web",
        shows: "the WebAssembly module gives the same bits under Node, and its page dents a hood in Chromium",
        needs: &[Tool::WebRust, Tool::Llvm, Tool::Npm, Tool::Chromium],
        wants: &[],
        leaves: &[],
        run: web::stage,
    },
    Stage {
        name: "fuzz",
        shows: "ten seconds of fuzzing find nothing at any door",
        needs: &[Tool::CppCompiler],
        wants: &[],
        leaves: &["fuzz"],
        run: fuzz::stage,
    },
    Stage {
        name: "threads",
        shows: "ThreadSanitizer finds no data race where threads share a context",
        needs: &[Tool::CCompiler],
        wants: &[],
        leaves: &["sanitizers"],
        run: nightly::threads,
    },
    Stage {
        name: "windows",
        shows: "the library, the command and the archive for Windows work under Wine, and write the same bytes as here",
        needs: tools::WINDOWS_TOOLS,
        wants: &[],
        leaves: &["cross/x86_64-pc-windows-gnu", "wine"],
        run: platforms::windows,
    },
    Stage {
        name: "aarch64",
        shows: "the library and the command for 64-bit ARM work under qemu, and write the same bytes as here",
        needs: platforms::AARCH64_TOOLS,
        wants: &[],
        leaves: &["cross/aarch64-unknown-linux-gnu"],
        run: platforms::aarch64,
    },
    Stage {
        name: "i686",
        shows: "the library and the command for 32-bit x86 work, and write the same bytes as here",
        needs: platforms::I686_TOOLS,
        wants: &[],
        leaves: &["cross/i686-unknown-linux-gnu"],
        run: platforms::i686,
    },
    Stage {
        name: "vulkan",
        shows: "the Vulkan tests pass on lavapipe under validation; with --all also on SwiftShader, and those of wgpu",
        needs: &[Tool::Vulkan],
        wants: &[],
        leaves: &[],
        run: vulkan::run,
    },
    Stage {
        name: "rust",
        shows: "the Rust tests and documentation examples pass; with --all also those of wgpu, the lab and xtask",
        needs: &[],
        wants: &[],
        leaves: &[],
        run: rust,
    },
    Stage {
        name: "ctest",
        shows: "the C and C++ tests pass with the installed library; with --all also Unity's renderer plugin",
        needs: &[Tool::CCompiler, Tool::CppCompiler, Tool::CMake],
        wants: &[Tool::Ode, Tool::Bullet, Tool::Vulkan, Tool::VulkanHeaders, Tool::Png],
        leaves: &[],
        run: native::ctest,
    },
];

/// Runs the stages that `options` choose. A stage that is not everybody's always runs whole; those that are run whole with `--all`.
pub fn run(workspace: &mut Workspace, options: &Options) -> Result<()> {
    let every = || CHECKS.iter().chain(STAGES);
    for name in &options.only {
        if !every().any(|stage| stage.name == name) {
            let names: Vec<&str> = every().map(|stage| stage.name).collect();
            bail!("there is no stage {name:?}; there are: {}", names.join(", "));
        }
    }
    let everybodys = |stage: &&Stage| FOR_EVERYBODY.contains(&stage.name);
    let stages: Vec<&Stage> = if !options.only.is_empty() {
        every().filter(|stage| options.only.iter().any(|name| name == stage.name)).collect()
    } else if options.all {
        STAGES.iter().collect()
    } else {
        STAGES.iter().filter(everybodys).collect()
    };
    workspace.all = options.all || !stages.iter().all(everybodys);
    let in_ci = std::env::var("CI").is_ok_and(|value| value == "true" || value == "1");
    let require_all = options.require_all || in_ci;
    let ahead = options.all && options.only.is_empty();
    stage::run_all(
        workspace,
        &stages,
        Rules { require_all, fail_fast: options.fail_fast, retry: in_ci, tidy: false, ahead },
    )
}

/// `cargo xtask ci`: runs every check and every test. A missing program fails its stage.
pub fn ci(workspace: &Workspace, fail_fast: bool) -> Result<()> {
    let stages: Vec<&Stage> = CHECKS.iter().chain(STAGES).collect();
    stage::run_all(workspace, &stages, Rules { require_all: true, fail_fast, retry: true, tidy: true, ahead: true })
}

/// Compiles what stages need in target folders of their own, in their order. A stage finds it ready, or waits for Cargo's lock.
pub fn ahead(workspace: &Workspace) {
    let builds: [fn(&Workspace) -> Result<()>; 6] = [
        |workspace| source::crates_io(workspace).map(drop),
        godot::build,
        web::build,
        fuzz::build_for_stage,
        nightly::build,
        platforms::build,
    ];
    for build in builds {
        // The stage says again what fails.
        let _ = build(workspace);
    }
}

fn rust(workspace: &Workspace) -> Result<Outcome> {
    // Stage "vulkan" runs these tests with drivers.
    let library = workspace.tests(&[]).env("VK_DRIVER_FILES", workspace.path("no-driver")).run();
    let mut results = vec![("the library", library.map_err(Into::into))];
    if workspace.all {
        let helper = workspace.cargo(&["test", "--profile", "xtask", "--package", "xtask"]).run();
        results.push(("xtask", helper.map_err(Into::into)));
    }
    stage::all_passed(results)?;
    Ok(Outcome::Passed)
}
