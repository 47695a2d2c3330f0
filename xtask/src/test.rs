//! `cargo xtask test` and `cargo xtask ci`: the list of test stages, and which stages a command runs.

use anyhow::{Result, bail};
use clap::Args;

use crate::ci::CHECKS;
use crate::stage::{self, Outcome, Rules, Stage};
use crate::tools::Tool;
use crate::workspace::Workspace;
use crate::{abi, csharp, demo, native, package, peers, valgrind, vulkan};

#[derive(Args, Default)]
pub struct Options {
    /// Fail where a stage would be skipped; also on where CI=true
    #[arg(long)]
    pub require_all: bool,
    /// Only the Rust tests, those of Vulkan among them, and CTest
    #[arg(long, conflicts_with = "only")]
    pub quick: bool,
    /// Only this stage or check of `cargo xtask ci`; may be given several times
    #[arg(long, value_name = "STAGE")]
    pub only: Vec<String>,
    /// Stop at the first stage that fails
    #[arg(long)]
    pub fail_fast: bool,
}

/// In the order in which they run. A new kind of test is one more entry here.
const STAGES: &[Stage] = &[
    Stage {
        name: "install",
        shows: "the C library, its headers, CMake package and pkg-config file go into target/prefix",
        needs: &[Tool::CCompiler],
        wants: &[],
        run: native::install_release,
    },
    Stage {
        name: "package",
        shows: "the archive, unpacked elsewhere, is what it says; its examples run by CMake and by pkg-config, shared and static",
        needs: &[Tool::CCompiler, Tool::CppCompiler, Tool::CMake, Tool::PkgConfig],
        wants: &[Tool::Ode, Tool::VulkanHeaders, Tool::Png],
        run: package::stage,
    },
    Stage {
        name: "abi",
        shows: "programs built against the last release fit the header of today",
        needs: &[Tool::CCompiler, Tool::Abigail],
        wants: &[],
        run: abi::stage,
    },
    Stage {
        name: "csharp",
        shows: "the C# layer under Mono: dents, errors, threads, callbacks, ten thousand frames, libraries that do not fit",
        needs: &[Tool::CCompiler, Tool::Mono],
        wants: &[Tool::Vulkan, Tool::VulkanHeaders],
        run: csharp::run,
    },
    Stage {
        name: "sanitizers",
        shows: "the C and C++ tests under gcc's address and undefined-behaviour sanitizers",
        needs: &[Tool::CCompiler, Tool::CppCompiler, Tool::CMake],
        wants: &[Tool::Ode, Tool::Vulkan, Tool::VulkanHeaders, Tool::Png],
        run: native::sanitizers,
    },
    Stage {
        name: "valgrind-c",
        shows: "the C and C++ tests under valgrind",
        needs: &[Tool::CCompiler, Tool::CppCompiler, Tool::CMake, Tool::Valgrind],
        wants: &[Tool::Ode, Tool::Vulkan, Tool::VulkanHeaders, Tool::Png],
        run: valgrind::c,
    },
    Stage {
        name: "valgrind-rust",
        shows: "the Rust tests under valgrind",
        needs: &[Tool::Valgrind],
        wants: &[],
        run: valgrind::rust,
    },
    Stage {
        name: "demo",
        shows: "`cargo xtask demo` dents a hood and a drum",
        needs: &[],
        wants: &[],
        run: demo::check,
    },
    Stage {
        name: "blender",
        shows: "Blender opens what the command exports",
        needs: &[Tool::Python311, Tool::BlenderLibraries],
        wants: &[],
        run: peers::blender,
    },
    Stage {
        name: "gltf-validator",
        shows: "the Khronos validator finds nothing wrong with what the command exports",
        needs: &[Tool::Npm],
        wants: &[],
        run: peers::gltf_validator,
    },
    Stage {
        name: "vulkan",
        shows: "what is recorded into Vulkan command buffers, and deformed through wgpu, on lavapipe and SwiftShader, under validation",
        needs: &[Tool::Vulkan],
        wants: &[],
        run: vulkan::run,
    },
    Stage {
        name: "rust",
        shows: "the Rust tests, documentation examples among them",
        needs: &[],
        wants: &[],
        run: rust,
    },
    Stage {
        name: "ctest",
        shows: "the C and C++ programs, and Unity's plugin and component, against the installed library",
        needs: &[Tool::CCompiler, Tool::CppCompiler, Tool::CMake],
        wants: &[Tool::Ode, Tool::Vulkan, Tool::VulkanHeaders, Tool::Png, Tool::Mono],
        run: native::ctest,
    },
];

/// The stages that `options` choose; all of them without options.
pub fn run(workspace: &Workspace, options: &Options) -> Result<()> {
    let all = || CHECKS.iter().chain(STAGES);
    for name in &options.only {
        if !all().any(|stage| stage.name == name) {
            let names: Vec<&str> = all().map(|stage| stage.name).collect();
            bail!("there is no stage {name:?}; there are: {}", names.join(", "));
        }
    }
    let stages: Vec<&Stage> = if options.quick {
        STAGES.iter().filter(|stage| ["install", "vulkan", "rust", "ctest"].contains(&stage.name)).collect()
    } else if options.only.is_empty() {
        STAGES.iter().collect()
    } else {
        all().filter(|stage| options.only.iter().any(|name| name == stage.name)).collect()
    };
    let require_all = options.require_all || std::env::var("CI").is_ok_and(|value| value == "true" || value == "1");
    stage::run_all(workspace, &stages, Rules { require_all, fail_fast: options.fail_fast })
}

/// `cargo xtask ci`: every check and every test, with nothing left out.
pub fn ci(workspace: &Workspace, fail_fast: bool) -> Result<()> {
    let stages: Vec<&Stage> = CHECKS.iter().chain(STAGES).collect();
    stage::run_all(workspace, &stages, Rules { require_all: true, fail_fast })
}

fn rust(workspace: &Workspace) -> Result<Outcome> {
    let helper = workspace.cargo(&["test", "--profile", "xtask", "--package", "xtask"]).run();
    // Vulkan has a stage of its own, with drivers of its own.
    let library = workspace.tests(&[]).env("VK_DRIVER_FILES", workspace.path("no-driver")).run();
    stage::all_passed(vec![("xtask", helper.map_err(Into::into)), ("the library", library.map_err(Into::into))])?;
    Ok(Outcome::Passed)
}
