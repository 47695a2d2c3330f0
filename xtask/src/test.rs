//! `cargo xtask test` and `cargo xtask ci`: the list of test stages, and which stages a command runs.

use anyhow::Result;
use clap::Args;
use clap::builder::PossibleValuesParser;

use crate::stage::{self, Rules, Stage, all_passed, stages, unless};
use crate::tools::{
    AARCH64_CC, AARCH64_RUST, ABIGAIL, ASSIMP, BLENDER_LIBRARIES, BULLET, CC, CHROMIUM, CMAKE, CXX, FOR_WINDOWS,
    I686_CC, I686_RUST, LLVM, MONO, NPM, ODE, PKG_CONFIG, PNG, PYTHON3, PYTHON311, QEMU, SWIFTSHADER, VALGRIND, VULKAN,
    VULKAN_HEADERS, WEB_RUST, XVFB,
};
use crate::workspace::{all, cargo, in_root, test_all, tests};
use crate::{
    abi, blender, car, csharp, exports, fuzz, godot, header, install, lab, native, nightly, package, platforms, python,
    repo, rooms, source, valgrind, vulkan, web,
};

#[derive(Args, Default)]
pub struct Options {
    /// Run every stage: also engines, other systems, sanitizers, fuzzing and packages
    #[arg(long)]
    pub all: bool,
    /// Run only this stage, or this check of `cargo xtask ci`; may be given several times
    #[arg(long, value_name = "STAGE", value_parser = PossibleValuesParser::new(every_stage().map(|stage| stage.name)))]
    pub only: Vec<String>,
    /// Stop at the first stage that fails
    #[arg(long)]
    pub fail_fast: bool,
}

/// The checks that `cargo xtask ci` runs before the tests.
const CHECKS: &[Stage] = stages! {
    "repository": || repo::run(false), "sizes, shown programs, changelog, .meta files and quoted messages are right";
    "rooms": rooms::stage, "the imports of src keep the order of its rooms";
    "header": || header::run(true), "the committed header and the C# and Python declarations match the sources";
    "format": || Ok(cargo(&["fmt", "--all", "--check"]).run()?), "rustfmt changes nothing";
    "lints": || clippy(&["--workspace", "--all-targets", "--all-features"]), "clippy finds nothing, with all features";
    "lints-slim": || clippy(&["--package", "crumple", "--lib", "--no-default-features"]),
        "clippy finds nothing in the library without features";
    "documentation": documentation, "rustdoc finds nothing";
};

/// The stages of `cargo xtask test` without options: everybody can run them within minutes.
const FOR_EVERYBODY: &[&str] = &["install", "cmake", "vulkan", "rust", "ctest"];

const LINUX: bool = cfg!(target_os = "linux");
const LINUX_X86_64: bool = cfg!(all(target_os = "linux", target_arch = "x86_64"));

/// In the order in which they run: what is compiled ahead runs late. A new kind of test is one more entry here.
const STAGES: &[Stage] = stages! {
    "install": install::stage,
        "the C library installs into target/prefix and exports what the header declares", needs: &[CC];
    "cmake": source::cmake,
        "a CMake project that fetches the source builds it by Cargo, and installs what the installer does",
        needs: &[CC, CXX, CMAKE], leaves: &["cmake"], elsewhere: unless(cfg!(not(windows)), "not tried on Windows");
    "conan": source::conan, "Conan makes a package from the source, and a program finds it",
        needs: &[CC, CXX, CMAKE, PYTHON3], leaves: &["conan", "conan-venv"];
    "package": package::stage,
        "the unpacked archive is as its manifest says; its examples run by CMake and pkg-config, both ways",
        needs: &[CC, CXX, CMAKE, PKG_CONFIG], wants: &[ODE, BULLET, VULKAN_HEADERS, PNG],
        elsewhere: unless(cfg!(not(windows)), "not done on Windows, where pkg-config is rare");
    "abi": abi::stage, "programs built against the last release fit the header of today", needs: &[CC, ABIGAIL];
    "csharp": csharp::stage, "the C# layer works under Mono and rejects libraries that do not fit", needs: &[CC, MONO],
        elsewhere: unless(LINUX, "done with Debian's Mono on Linux only");
    "python": python::stage,
        "the Python package works as a wheel in an environment of its own, and makes examples for bare meshes",
        needs: &[CC, PYTHON311], elsewhere: unless(LINUX, "the wheel was built and tried on Linux only");
    "sanitizers": native::sanitizers, "the C and C++ tests pass under gcc's address and undefined behaviour sanitizers",
        needs: &[CC, CXX, CMAKE], wants: &[ODE, BULLET, VULKAN, VULKAN_HEADERS, PNG], leaves: &["ctest/sanitizers"],
        elsewhere: unless(LINUX, "done with gcc on Linux only");
    "valgrind-c": valgrind::c, "valgrind finds no error and no leak in the C and C++ tests",
        needs: &[CC, CXX, CMAKE, VALGRIND], wants: &[ODE, BULLET, VULKAN, VULKAN_HEADERS, PNG];
    "valgrind-rust": valgrind::rust, "valgrind finds no error and no leak in the Rust tests", needs: &[VALGRIND];
    "engines": lab::engines, "every truth's hits thrown in rapier, Bullet and Jolt leave what their blows leave",
        needs: &[CC, CXX, CMAKE, BULLET], leaves: &["jolt", "throws"];
    "demo": car::demo_stage, "`cargo xtask demo` crashes the car";
    "car": car::stage, "the car's script makes a car: parts, sizes, closed inner solids, normals, symmetry, valid glTF",
        needs: &[PYTHON3], wants: &[NPM];
    "blender": exports::opened_by_blender, "Blender opens what the command exports",
        needs: &[PYTHON311, BLENDER_LIBRARIES];
    "extension": blender::stage,
        "the packed Blender extension works in two Blenders without a window and in one with a window",
        needs: &[CC, PYTHON311, BLENDER_LIBRARIES], wants: &[XVFB], leaves: &["blender-bpy50", "blender-window"],
        elsewhere: unless(LINUX_X86_64, "Blender is fetched for Linux on x86-64 only");
    "gltf-validator": exports::valid, "the Khronos validator finds nothing wrong with what the command exports",
        needs: &[NPM];
    "crate": source::crates_io, "the crate builds from the files that crates.io gets";
    "godot": godot::stage,
        "the extension dents meshes in Godot: its classes, both physics engines, the editor's import, a picture",
        needs: &[CC, XVFB], leaves: &["godot"],
        elsewhere: unless(LINUX_X86_64, "the engine is fetched for Linux on x86-64 only");
    "exporters": exports::of_others,
        "what Blender, three.js, assimp, trimesh and Godot write is read, and what no dent reached is kept",
        needs: &[PYTHON311, BLENDER_LIBRARIES, NPM, ASSIMP], leaves: &["blender-bpy42", "godot-engine"],
        elsewhere: unless(LINUX_X86_64, "Blender and Godot are fetched for Linux on x86-64 only");
    "web": web::stage, "the WebAssembly module gives the same bits under Node, and its page dents a hood in Chromium",
        needs: &[WEB_RUST, LLVM, NPM, CHROMIUM];
    "fuzz": fuzz::stage, "ten seconds of fuzzing find nothing at any door", needs: &[CXX], leaves: &["fuzz"];
    "threads": nightly::threads, "ThreadSanitizer finds no data race where threads share a context", needs: &[CC],
        leaves: &["sanitizers"];
    "windows": platforms::windows,
        "library, command and archive for Windows work under Wine, and write the same bytes as here",
        needs: FOR_WINDOWS, leaves: &["cross/x86_64-pc-windows-gnu", "wine"];
    "aarch64": platforms::aarch64,
        "the library and the command for 64-bit ARM work under qemu, and write the same bytes as here",
        needs: &[CC, CMAKE, AARCH64_RUST, AARCH64_CC, QEMU], leaves: &["cross/aarch64-unknown-linux-gnu"];
    "i686": platforms::i686, "the library and the command for 32-bit x86 work, and write the same bytes as here",
        needs: &[CC, CMAKE, I686_RUST, I686_CC], leaves: &["cross/i686-unknown-linux-gnu"];
    "vulkan": vulkan::stage,
        "the Vulkan tests pass on lavapipe under validation; with --all also on SwiftShader, and those of wgpu",
        needs: &[VULKAN], wants: &[SWIFTSHADER];
    "rust": rust, "the Rust tests and documentation examples pass; with --all also those of wgpu, the lab and xtask";
    "ctest": native::ctest,
        "the C and C++ tests pass with the installed library; with --all also Unity's renderer plugin",
        needs: &[CC, CXX, CMAKE], wants: &[ODE, BULLET, VULKAN, SWIFTSHADER, VULKAN_HEADERS, PNG];
};

fn every_stage() -> impl Iterator<Item = &'static Stage> {
    CHECKS.iter().chain(STAGES)
}

/// Runs the stages that `options` choose, or `every` check and every test. Without `every`, CI=true in the environment asks for the rules
/// of CI. A stage that is not everybody's always runs whole; those that are run whole with `--all`.
pub fn run(options: &Options, every: bool) -> Result<()> {
    let everybodys = |stage: &&Stage| FOR_EVERYBODY.contains(&stage.name);
    let stages: Vec<&Stage> = match (options.only.is_empty(), options.all) {
        _ if every => every_stage().collect(),
        (false, _) => every_stage().filter(|stage| options.only.iter().any(|name| name == stage.name)).collect(),
        (true, true) => STAGES.iter().collect(),
        (true, false) => STAGES.iter().filter(everybodys).collect(),
    };
    test_all(options.all || !stages.iter().all(everybodys));
    let ci = every || std::env::var("CI").is_ok_and(|value| value == "true" || value == "1");
    let ahead = every || options.all && options.only.is_empty();
    stage::run_all(&stages, Rules { ci, fail_fast: options.fail_fast, ahead })
}

/// Compiles what stages need in target folders of their own, in their order. A stage finds it ready, or waits for Cargo's lock, and
/// says again what fails.
pub fn ahead() -> Result<()> {
    let builds = [godot::build, web::build, fuzz::build_for_stage, nightly::build, platforms::build];
    builds.iter().for_each(|build| drop(build()));
    Ok(())
}

fn rust() -> Result<()> {
    // Stage "vulkan" runs these tests with drivers.
    let library = tests(&[]).env("VK_DRIVER_FILES", in_root("no-driver")).run();
    let helper = || cargo(&["test", "--profile", "xtask", "--package", "xtask"]).run();
    let helper = if all() { helper() } else { Ok(()) };
    all_passed(vec![("the library", library.map_err(Into::into)), ("xtask", helper.map_err(Into::into))])
}

fn documentation() -> Result<()> {
    // The whole workspace with all features: stage "lints" has checked its dependencies so.
    let what = ["doc", "--no-deps", "--workspace", "--all-features"];
    Ok(cargo(&what).env("RUSTDOCFLAGS", "--deny warnings").run()?)
}

fn clippy(what: &[&str]) -> Result<()> {
    let deny = ["--", "--deny", "warnings", "--deny", "clippy::undocumented_unsafe_blocks"];
    Ok(cargo(&["clippy"]).args(what).args(deny).run()?)
}
