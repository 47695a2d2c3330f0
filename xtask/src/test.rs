//! `cargo xtask test`: the list of stages. A new kind of test is one more entry here.

use anyhow::{Result, bail};
use clap::Args;

use crate::stage::{self, Outcome, Stage};
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
    /// Only this stage; may be given several times
    #[arg(long, value_name = "STAGE")]
    pub only: Vec<String>,
}

/// In order: what prepares and what takes other programs first, the two test runners last, since theirs should be the last lines.
const STAGES: &[Stage] = &[
    Stage {
        name: "install",
        shows: "the C library, its headers, CMake package and pkg-config file go into target/prefix",
        needs: &[Tool::CCompiler],
        wants: &[],
        closing: false,
        run: native::install_release,
    },
    Stage {
        name: "package",
        shows: "the archive, unpacked elsewhere, is what it says; its examples run by CMake and by pkg-config, shared and static",
        needs: &[Tool::CCompiler, Tool::CppCompiler, Tool::CMake, Tool::PkgConfig],
        wants: &[Tool::Ode, Tool::VulkanHeaders, Tool::Png],
        closing: false,
        run: package::stage,
    },
    Stage {
        name: "abi",
        shows: "the binary interface is the committed one, and programs of the first header run with the library of today",
        needs: &[Tool::CCompiler, Tool::CppCompiler, Tool::CMake, Tool::Abigail],
        wants: &[],
        closing: false,
        run: abi::stage,
    },
    Stage {
        name: "csharp",
        shows: "the C# layer under Mono: dents, errors, threads, callbacks, ten thousand frames, libraries that do not fit",
        needs: &[Tool::CCompiler, Tool::Mono],
        wants: &[Tool::Vulkan, Tool::VulkanHeaders],
        closing: false,
        run: csharp::run,
    },
    Stage {
        name: "sanitizers",
        shows: "the C and C++ tests under gcc's address and undefined-behaviour sanitizers",
        needs: &[Tool::CCompiler, Tool::CppCompiler, Tool::CMake],
        wants: &[Tool::Ode, Tool::Vulkan, Tool::VulkanHeaders, Tool::Png],
        closing: false,
        run: native::sanitizers,
    },
    Stage {
        name: "valgrind-c",
        shows: "the C and C++ tests under valgrind",
        needs: &[Tool::CCompiler, Tool::CppCompiler, Tool::CMake, Tool::Valgrind],
        wants: &[Tool::Ode, Tool::Vulkan, Tool::VulkanHeaders, Tool::Png],
        closing: false,
        run: valgrind::c,
    },
    Stage {
        name: "valgrind-rust",
        shows: "the Rust tests under valgrind",
        needs: &[Tool::Valgrind],
        wants: &[],
        closing: false,
        run: valgrind::rust,
    },
    Stage {
        name: "demo",
        shows: "`cargo xtask demo` dents a hood and a drum",
        needs: &[],
        wants: &[],
        closing: false,
        run: demo::check,
    },
    Stage {
        name: "blender",
        shows: "Blender opens what the command exports",
        needs: &[Tool::Python311, Tool::BlenderLibraries],
        wants: &[],
        closing: false,
        run: peers::blender,
    },
    Stage {
        name: "gltf-validator",
        shows: "the Khronos validator finds nothing wrong with what the command exports",
        needs: &[Tool::Npm],
        wants: &[],
        closing: false,
        run: peers::gltf_validator,
    },
    Stage {
        name: "vulkan",
        shows: "what is recorded into Vulkan command buffers, and deformed through wgpu, on lavapipe and SwiftShader, under validation",
        needs: &[Tool::Vulkan],
        wants: &[],
        closing: false,
        run: vulkan::run,
    },
    Stage {
        name: "rust",
        shows: "the Rust tests, documentation examples among them",
        needs: &[],
        wants: &[],
        closing: true,
        run: rust,
    },
    Stage {
        name: "ctest",
        shows: "the C and C++ programs, and Unity's plugin and component, against the installed library",
        needs: &[Tool::CCompiler, Tool::CppCompiler, Tool::CMake],
        wants: &[Tool::Ode, Tool::Vulkan, Tool::VulkanHeaders, Tool::Png, Tool::Mono],
        closing: true,
        run: native::ctest,
    },
];

pub fn run(workspace: &Workspace, options: &Options) -> Result<()> {
    let wanted = |stage: &&Stage| match options {
        Options { quick: true, .. } => ["install", "vulkan", "rust", "ctest"].contains(&stage.name),
        Options { only, .. } if !only.is_empty() => only.iter().any(|name| name == stage.name),
        _ => true,
    };
    for name in &options.only {
        if !STAGES.iter().any(|stage| stage.name == name) {
            let names: Vec<&str> = STAGES.iter().map(|stage| stage.name).collect();
            bail!("there is no stage {name:?}; there are: {}", names.join(", "));
        }
    }
    let stages: Vec<&Stage> = STAGES.iter().filter(wanted).collect();
    let require_all = options.require_all || std::env::var("CI").is_ok_and(|value| value == "true" || value == "1");
    stage::run_all(workspace, &stages, require_all)
}

fn rust(workspace: &Workspace) -> Result<Outcome> {
    workspace.cargo(&["test", "--profile", "xtask", "--package", "xtask"]).run()?;
    // Vulkan has a stage of its own, with drivers of its own.
    workspace.tests(&[]).env("VK_DRIVER_FILES", workspace.path("no-driver")).run()?;
    Ok(Outcome::Passed)
}
