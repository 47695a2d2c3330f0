//! Tests of the installed C library by C and C++ programs, plain and under gcc's sanitizers.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use anyhow::{Result, ensure};
use regex_lite::Regex;

use crate::files::{copy_into, empty, files, read};
use crate::stage::all_passed;
use crate::target::Target;
use crate::tools::{BULLET, ODE, PNG, Tool, VULKAN, VULKAN_HEADERS};
use crate::workspace::{all, cmd, in_root, in_target, jobs, said, sh, silent};
use crate::{install, vulkan};

/// CMake projects whose programs are tests, each with the name of its build folder.
pub const OURS: &[(&str, &str)] = &[("examples-c", "examples-c"), ("tests/c", "tests-c")];
/// The one that makes every call of the library.
pub const TESTS: &[(&str, &str)] = &[OURS[1]];
/// All projects: ours and Unity's renderer plugin.
const ALL: &[(&str, &str)] = &[OURS[0], OURS[1], ("bindings/unity/native~", "unity")];

/// How a set of projects is built and run.
pub struct Build<'a> {
    /// The projects to build.
    pub projects: &'static [(&'static str, &'static str)],
    /// Name of the folder that holds this kind's builds. Stages that compile alike share one.
    pub kind: &'a str,
    pub prefix: &'a Path,
    /// Whether programs run on drivers under Vulkan's validation layer.
    pub validation: bool,
    /// Further arguments for CMake.
    pub options: Vec<String>,
    /// Whether the programs are for another system. They then use no library of this one.
    pub cross: bool,
    /// The program that runs each test program, with its arguments, separated by semicolons; empty for none.
    pub launcher: String,
    /// Manifests of the Vulkan drivers that programs run on; may be empty.
    pub drivers: Vec<PathBuf>,
    /// A regular expression for names of tests that are not run; empty for none.
    pub left_out: &'static str,
}

impl<'a> Build<'a> {
    /// All projects, without launcher and without Vulkan drivers.
    pub fn new(kind: &'a str, prefix: &'a Path) -> Self {
        let (options, launcher, drivers) = (Vec::new(), String::new(), Vec::new());
        Self { projects: ALL, kind, prefix, validation: true, options, cross: false, launcher, drivers, left_out: "" }
    }

    /// The same for a system, this one or another.
    pub fn on(target: &Target, kind: &'a str, prefix: &'a Path) -> Result<Self> {
        Ok(Self { options: cross_options(target)?, cross: target.cross, ..Self::new(kind, prefix) })
    }
}

/// Builds every project against an installed library and runs its tests. A project that fails does not hide the others.
pub fn test_projects(build: &Build<'_>) -> Result<()> {
    let left_out = [build.left_out].into_iter().filter(|names| !names.is_empty());
    let left_out: Vec<&str> = left_out.flat_map(|names| ["--exclude-regex", names]).collect();
    let test = |project: &str, name: &str| -> Result<()> {
        let folder = in_target("ctest").join(build.kind).join(name);
        compile(build, Path::new(project), &folder)?;
        run_tests(&folder, &left_out)
    };
    all_passed(build.projects.iter().map(|(project, name)| (*project, test(project, name))).collect())
}

/// Runs the tests of a project that CMake built.
pub fn run_tests(folder: &Path, options: &[&str]) -> Result<()> {
    let jobs = jobs().to_string();
    cmd!("ctest --test-dir {folder} --parallel {jobs} --output-on-failure --no-tests=error {options...}").run()?;
    Ok(())
}

/// Builds a project against an installed library.
pub fn compile(build: &Build<'_>, source: &Path, folder: &Path) -> Result<()> {
    let Build { prefix, options, launcher, validation, .. } = build;
    let (jobs, on) = (jobs().to_string(), |on: bool| if on { "ON" } else { "OFF" });
    let drivers: Vec<_> = build.drivers.iter().map(|manifest| manifest.to_string_lossy()).collect();
    let (drivers, validation) = (drivers.join(";"), on(*validation));
    // A program must not be left out if what it needs is installed.
    let here = |tools: &[Tool]| on(!build.cross && tools.iter().all(|tool| tool.here()));
    let (ode, bullet, vulkan) = (here(&[ODE]), here(&[BULLET]), here(&[VULKAN_HEADERS, PNG]));
    silent!(
        "cmake -S {source} -B {folder} -DCMAKE_PREFIX_PATH={prefix} -DCMAKE_BUILD_TYPE=RelWithDebInfo {options...}
         -DCRUMPLE_REQUIRE_ODE={ode} -DCRUMPLE_REQUIRE_BULLET={bullet} -DCRUMPLE_REQUIRE_VULKAN={vulkan}
         -DCRUMPLE_VULKAN_DRIVERS={drivers} -DCRUMPLE_VULKAN_VALIDATION={validation}
         -DCMAKE_CROSSCOMPILING_EMULATOR={launcher} -DCMAKE_POLICY_DEFAULT_CMP0158=OLD --no-warn-unused-cli"
    )?;
    Ok(cmd!("cmake --build {folder} --config RelWithDebInfo --parallel {jobs}").ignore_stdout().run()?)
}

pub fn ctest() -> Result<()> {
    let prefix = install::release_prefix()?;
    let projects = if all() { ALL } else { OURS };
    let mut build = Build { projects, ..Build::new("release", &prefix) };
    if VULKAN.here() {
        build.drivers = vulkan::drivers()?;
        if all() {
            engine(&build)?;
        }
    }
    test_projects(&build)
}

/// Builds and tests the VulkanSceneGraph client if CMake finds that engine. No distribution packages it, so the environment's
/// `CMAKE_PREFIX_PATH` must name it.
fn engine(build: &Build<'_>) -> Result<()> {
    let folder = in_target("ctest").join(build.kind).join("vsg");
    compile(build, &in_root("bindings/vsg"), &folder)?;
    if folder.join("vsg_hood").exists() {
        return run_tests(&folder, &[]);
    }
    println!("bindings/vsg is left out: it needs VulkanSceneGraph in CMAKE_PREFIX_PATH, and libpng");
    Ok(())
}

/// Runs the C and C++ tests under gcc's sanitizers, against a debug build of the library, which has its own checks on.
pub fn sanitizers() -> Result<()> {
    let prefix = empty(in_target("prefix-debug"))?;
    install::run(&prefix, "debug")?;
    let _asan = sh().push_env("ASAN_OPTIONS", "detect_leaks=1:strict_string_checks=1:detect_stack_use_after_return=1");
    let _ubsan = sh().push_env("UBSAN_OPTIONS", "print_stacktrace=1");
    let sanitizers = format!("-DCMAKE_PROJECT_INCLUDE={}", in_root("tests/c/sanitizers.cmake").display());
    // The validation layer leaks memory of its own; stage "ctest" runs with it.
    let (validation, drivers) = (false, vulkan::one_driver()?);
    let build = Build { options: vec![sanitizers], validation, drivers, ..Build::new("sanitizers", &prefix) };
    test_projects(&build)
}

/// What tells CMake to compile for another system; nothing for this one. Programs for Windows find Vulkan's headers and loader.
fn cross_options(target: &Target) -> Result<Vec<String>> {
    if !target.cross {
        return Ok(Vec::new());
    }
    let file = in_root(format!("xtask/platforms/{}.cmake", target.triple));
    let mut options = vec![format!("-DCMAKE_TOOLCHAIN_FILE={}", file.display())];
    if target.is_windows() {
        let (include, library) = vulkan_for_windows()?;
        options.push(format!("-DVulkan_INCLUDE_DIR={}", include.display()));
        options.push(format!("-DVulkan_LIBRARY={}", library.display()));
    }
    Ok(options)
}

/// Vulkan's headers, which are the same everywhere, and an import library of Windows' loader.
fn vulkan_for_windows() -> Result<(PathBuf, PathBuf)> {
    let folder = empty(in_target("windows-vulkan"))?;
    let (include, library) = (folder.join("include"), folder.join("libvulkan-1.a"));
    let found = said!("pkg-config --variable=includedir vulkan")?;
    let (mut names, declared) = (BTreeSet::new(), Regex::new(r"VKAPI_CALL +(vk\w+)\(")?);
    for part in ["vulkan", "vk_video"] {
        for file in files(Path::new(&found).join(part))? {
            names.extend(declared.captures_iter(&read(&file)?).map(|found| found[1].to_owned()));
            copy_into(&file, &include.join(part))?;
        }
    }
    ensure!(names.len() >= 100, "{found}/vulkan declares {} functions; that cannot be all", names.len());
    install::import_library("vulkan-1.dll", &Vec::from_iter(names), &library)?;
    Ok((include, library))
}
