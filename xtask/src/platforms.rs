//! Tests of the builds for other systems: Windows under Wine, Linux on 64-bit ARM under qemu, 32-bit Linux. What the command writes
//! there must equal, byte for byte, what it writes here; the golden hashes of `promises` hold the rest. Vulkan under Wine uses this
//! machine's drivers.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use regex_lite::Regex;

use crate::declarations::{self, HEADERS, INCLUDE};
use crate::files::{copy_into, empty, files, write};
use crate::install::{self, Built, FULL};
use crate::native::{self, Build};
use crate::stage::all_passed;
use crate::target::{AARCH64, I686, Target, WINDOWS, launch};
use crate::wine::Wine;
use crate::workspace::{in_root, in_target, run, sh};
use crate::{abi, command, package, vulkan};

/// Features of the build whose library, command and tests are all used.
const FEATURES: &str = "cli,host-allocator";
/// The Rust programs whose tests run for each system. Others take many minutes under qemu.
const TESTS: [(&str, &str); 3] = [
    (WINDOWS, "--test=cli --test=format --test=promises --test=budget --test=vulkan"),
    (AARCH64, "--test=promises --test=stability"),
    (I686, "--test=format --test=promises --test=budget"),
];
/// Of these, the tests that run under qemu: those whose names contain one of these.
const QUICK: &str = "quick_ a_body_dents_alike_in_any_unit far_from";

/// The command's input, below the repository's root.
const INPUT: &[&str] = &["assets/demo/drum.glb", "assets/demo/drum.json"];
/// The name of the file that gets the command's answer, and the command's arguments.
type Question = (&'static str, &'static [&'static str]);
/// None draws: pictures take minutes under qemu, and their pixels depend on the system's sine and power. Only the first makes a set.
const QUESTIONS: &[Question] = &[
    ("bake.txt", &["bake", "drum.glb", "-o", "drum.crumple", "--tolerance", "0.1mm"]),
    ("info.txt", &["info", "drum.crumple"]),
    ("apply.txt", &["apply", "drum.crumple", "--impacts", "drum.json", "-o", "dented.glb"]),
    ("sample.txt", &["sample", "drum.crumple", "--count", "20", "-o", "sample.json"]),
];

/// The C programs that are left out under qemu, where they take minutes: they build sets or deform thousands of times.
const SLOW: &str = "^(allocator|allocator_static|job_system|many_instances|refusals)$";

/// A system and the program that runs its programs here, with arguments.
struct Platform {
    target: Target,
    runner: Vec<&'static str>,
    prefix: PathBuf,
}

pub fn windows() -> Result<()> {
    let wine = Wine::start()?;
    let platform = Platform::install(WINDOWS, wine.program)?;
    let _found = wine.libraries(&[&platform.prefix.join("bin")]);
    let _driver = sh().push_env("VK_DRIVER_FILES", vulkan::lavapipe()?);
    all_passed(vec![
        ("the archive", package::packed(&platform.built(), Some(&wine))),
        ("Microsoft's linker", platform.microsoft()),
        ("the tests", platform.test()),
    ])
}

pub fn aarch64() -> Result<()> {
    Platform::install(AARCH64, "qemu-aarch64 -L /usr/aarch64-linux-gnu")?.test()
}

pub fn i686() -> Result<()> {
    // The processor runs them. The cross compiler's package has the libraries, not where the system looks for them.
    let runner = "/usr/i686-linux-gnu/lib/ld-linux.so.2 --library-path /usr/i686-linux-gnu/lib";
    Platform::install(I686, runner)?.test()
}

pub fn build() -> Result<()> {
    all_passed(TESTS.map(|(triple, _)| (triple, compile(&Target::other(triple)))).into())
}

fn programs(target: &Target) -> impl Iterator<Item = &'static str> {
    TESTS.into_iter().filter(|(triple, _)| target.triple == *triple).flat_map(|(_, tests)| tests.split(' '))
}

/// Builds the library, the command and tests.
fn compile(target: &Target) -> Result<()> {
    let what = ["build", "--package", "crumple", "--features", FEATURES, "--lib", "--bin", "crumple"];
    Ok(target.cargo(&what)?.args(programs(target)).run()?)
}

impl Platform {
    fn install(triple: &str, runner: &'static str) -> Result<Self> {
        let (target, prefix) = (Target::other(triple), empty(in_target(format!("prefix-{triple}")))?);
        compile(&target)?;
        let platform = Self { target, runner: runner.split(' ').collect(), prefix };
        install::lay_out(&platform.built(), &platform.prefix)?;
        let shared = platform.target.shared_in(&platform.prefix);
        abi::exported(Path::new(INCLUDE), &shared)?;
        install::loads_well(&platform.target, &shared)?;
        Ok(platform)
    }

    fn test(&self) -> Result<()> {
        all_passed(vec![
            ("the C and C++ tests", self.c()),
            ("the Rust tests", self.rust()),
            ("the same files", self.same_files()),
        ])
    }

    fn built(&self) -> Built {
        Built::new(self.target.clone(), "debug", &FULL)
    }

    fn c(&self) -> Result<()> {
        native::test_projects(&Build {
            projects: native::OURS,
            launcher: self.runner.join(";"),
            // Wine has no validation layer.
            validation: false,
            left_out: if self.target.triple == AARCH64 { SLOW } else { "" },
            drivers: if self.target.is_windows() { vulkan::one_driver()? } else { Vec::new() },
            ..Build::on(&self.target, &self.target.triple, &self.prefix)?
        })
    }

    fn rust(&self) -> Result<()> {
        let what = ["test", "--no-fail-fast", "--package", "crumple", "--features", FEATURES];
        let quick = QUICK.split(' ').filter(|_| self.target.triple == AARCH64);
        let tests = self.target.cargo(&what)?.args(programs(&self.target)).arg("--").args(quick);
        Ok(tests.env(self.target.variable("RUNNER"), self.runner.join(" ")).env("PROPTEST_CASES", "4").run()?)
    }

    /// The command writes the same files and prints the same reports.
    fn same_files(&self) -> Result<()> {
        let folder = in_target("same");
        let (here, there) = (folder.join("host"), folder.join(&self.target.triple));
        ask(&here, &[], &command::tested()?)?;
        ask(&there, &self.runner, &self.built().command.context("it is whole")?)?;
        run!("diff --recursive {here} {there}")?;
        let files = files(&here)?.len();
        ensure!(files > INPUT.len() + QUESTIONS.len(), "the command wrote only {files} files");
        println!("{} files of the command are the same bytes as this machine's", files - INPUT.len());
        Ok(())
    }

    /// Compiles and links a program as for Microsoft's tools, with every function of the headers, and runs it.
    fn microsoft(&self) -> Result<()> {
        let folder = empty(in_target("msvc"))?;
        let (include, import) = (self.prefix.join("include"), self.prefix.join("lib/crumple.dll.lib"));
        let (source, object) = (in_root("xtask/platforms/msvc.c"), folder.join("client.obj"));
        let functions = Vec::from_iter(declarations::names(INCLUDE)?);
        let all = format!("-DALL={}", functions.join(","));
        let microsoft = ["--target=x86_64-pc-windows-msvc", "-ffreestanding", "-Wall", "-Wextra", "-Werror"];
        for (language, standard) in [("c", "-std=c99"), ("c++", "-std=c++17")] {
            for header in HEADERS.iter().map(|name| include.join(name)) {
                run!("clang {microsoft...} -x {language} {standard} -fsyntax-only {header}")?;
            }
        }
        run!("clang {microsoft...} -std=c99 -I {include} {all} -c {source} -o {object}")?;
        let program = folder.join("client.exe");
        let out = format!("/out:{}", program.display());
        let options = ["/nologo", "/nodefaultlib", "/entry:start", "/subsystem:console"];
        run!("lld-link {options...} {object} {import} {out}")?;
        let ended = launch(&self.runner, &program).ignore_status().output()?.status;
        ensure!(ended.code() == Some(42), "{} ends with {ended}", program.display());
        println!("a program of lld-link uses all {} functions through crumple.dll.lib", functions.len());
        Ok(())
    }
}

/// Asks the command everything in an empty folder.
fn ask(folder: &Path, runner: &[&str], program: &Path) -> Result<()> {
    empty(folder)?;
    for file in INPUT {
        copy_into(file, folder)?;
    }
    let times = Regex::new(r"[0-9.]+ ms\b")?;
    let _there = sh().push_dir(folder);
    for (file, question) in QUESTIONS {
        let answer = launch(runner, program).args(*question).read()?.replace('\r', "");
        // Windows' separator.
        write(folder.join(file), times.replace_all(&answer, "_ ms").replace('\\', "/"))?;
    }
    Ok(())
}
