//! Tests of the builds for other systems: Windows under Wine, Linux on 64-bit ARM under qemu, 32-bit Linux. What their programs write
//! must equal, byte for byte, what the programs of this machine write. Vulkan under Wine uses this machine's drivers.

use crate::prelude::*;

/// Features of the build whose library, command and tests are all used.
const FEATURES: &str = "cli,host-allocator";
/// The Rust tests that run for each system. Others take many minutes under qemu.
const WINDOWS_TESTS: &[&str] = &["--test=cli", "--test=format", "--test=promises", "--test=budget"];
const VULKAN_TESTS: &[&str] = &["--test=vulkan"];
const AARCH64_TESTS: &[&str] = &["--test=promises", "--test=stability"];
const I686_TESTS: &[&str] = &["--test=format", "--test=promises", "--test=budget"];

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
const SLOW: &str = "^(allocator|allocator_static|job_system|many_instances|refusals|times)$";

/// A system and the program that runs its programs here, with arguments.
struct Platform {
    target: Target,
    runner: Vec<&'static str>,
    prefix: PathBuf,
}

pub fn windows() -> Result<()> {
    let wine = Wine::start()?;
    let platform = Platform::install(WINDOWS, vec![wine.program])?;
    let _found = wine.libraries(&[&platform.prefix.join("bin")]);
    all_passed(vec![
        ("the archive", package::packed(&platform.built(), Some(&wine))),
        ("Microsoft's linker", platform.microsoft()),
        ("the Vulkan tests", {
            let _driver = sh().push_env("VK_DRIVER_FILES", vulkan::lavapipe()?);
            platform.rust(VULKAN_TESTS, &[])
        }),
        ("the other tests", platform.test(WINDOWS_TESTS, &[])),
    ])
}

pub fn aarch64() -> Result<()> {
    let runner = vec!["qemu-aarch64", "-L", "/usr/aarch64-linux-gnu"];
    let platform = Platform::install(AARCH64, runner)?;
    platform.test(AARCH64_TESTS, &["quick_", "a_body_dents_alike_in_any_unit", "far_from"])
}

pub fn i686() -> Result<()> {
    // The processor runs them. The cross compiler's package has the libraries, not where the system looks for them.
    let runner = vec!["/usr/i686-linux-gnu/lib/ld-linux.so.2", "--library-path", "/usr/i686-linux-gnu/lib"];
    Platform::install(I686, runner)?.test(I686_TESTS, &[])
}

pub fn build() -> Result<()> {
    let compile = |triple| (triple, compile(&Target::other(triple)));
    all_passed([WINDOWS, AARCH64, I686].map(compile).into())
}

/// Builds the library, the command and tests.
fn compile(target: &Target) -> Result<()> {
    let tests: &[&[&str]] = match target.triple.as_str() {
        WINDOWS => &[WINDOWS_TESTS, VULKAN_TESTS],
        AARCH64 => &[AARCH64_TESTS],
        _ => &[I686_TESTS],
    };
    let what = ["build", "--package", "crumple", "--features", FEATURES, "--lib", "--bin", "crumple"];
    Ok(target.cargo(&[&what[..], &tests.concat()].concat())?.run()?)
}

impl Platform {
    fn install(triple: &str, runner: Vec<&'static str>) -> Result<Self> {
        let (target, prefix) = (Target::other(triple), empty(in_target(format!("prefix-{triple}")))?);
        compile(&target)?;
        let platform = Self { target, runner, prefix };
        install::lay_out(&platform.built(), &platform.prefix)?;
        let shared = install::shared(&platform.target, &platform.prefix);
        abi::exported(&in_root(INCLUDE), &shared)?;
        install::loads_well(&platform.target, &shared)?;
        Ok(platform)
    }

    /// `programs` are Rust's; of their tests those run whose names contain one of `names`.
    fn test(&self, programs: &[&str], names: &[&str]) -> Result<()> {
        all_passed(vec![
            ("the C and C++ tests", self.c()),
            ("the Rust tests", self.rust(programs, names)),
            ("the same files", self.same_files()),
        ])
    }

    fn built(&self) -> Built {
        Built::new(self.target.clone(), "debug", &FULL, true)
    }

    fn c(&self) -> Result<()> {
        native::test_projects(&Build {
            projects: native::OURS,
            options: native::cross_options(&self.target)?,
            launcher: self.runner.join(";"),
            cross: true,
            // Wine has no validation layer.
            validation: false,
            left_out: if self.target.triple == AARCH64 { SLOW } else { "" },
            drivers: if self.target.is_windows() { native::one_driver()? } else { Vec::new() },
            ..Build::new(&self.target.triple, &self.prefix)
        })
    }

    /// Runs Rust tests: `programs`, and of these the tests whose names contain one of `names`, if there are any.
    fn rust(&self, programs: &[&str], names: &[&str]) -> Result<()> {
        let what = ["test", "--no-fail-fast", "--package", "crumple", "--features", FEATURES];
        let tests = self.target.cargo(&[&what[..], programs, &["--"], names].concat())?;
        Ok(tests.env(self.target.variable("RUNNER"), self.runner.join(" ")).env("PROPTEST_CASES", "4").run()?)
    }

    /// The command writes the same files and prints the same reports.
    fn same_files(&self) -> Result<()> {
        let folder = in_target("same");
        let (here, there) = (folder.join("host"), folder.join(&self.target.triple));
        ask(&here, &[], &command::tested()?)?;
        ask(&there, &self.runner, &self.built().command.context("it is whole")?)?;
        let files = same_files(&here, &there)?;
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
