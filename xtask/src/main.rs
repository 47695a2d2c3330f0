//! `cargo xtask`: one command for each thing that developers and CI do with this repository, the same on every platform.

mod abi;
mod blender;
mod car;
mod command;
mod csharp;
mod debian;
mod declarations;
mod exports;
mod files;
mod fuzz;
mod godot;
mod header;
mod install;
mod lab;
mod native;
mod nightly;
mod node;
mod package;
mod platforms;
mod python;
mod repo;
mod rooms;
mod source;
mod stage;
mod target;
mod test;
mod tools;
mod valgrind;
mod vulkan;
mod web;
mod wine;
mod workspace;

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Result;
use clap::{Parser, Subcommand};

#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask", about = "Builds, tests and shows Crumple")]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Dent a real mesh with real impacts: pictures and a deformed GLB
    Demo {
        /// Folder for the pictures and the GLB
        #[arg(long, default_value = "out/demo")]
        out: PathBuf,
        /// Deform on the GPU: the fastest one, or the one whose name contains NAME
        #[arg(long, value_name = "NAME", num_args = 0..=1, default_missing_value = "")]
        gpu: Option<String>,
    },
    /// Run the Rust, C and C++ tests, with Vulkan on Mesa's software driver; --all: every test stage
    Test(test::Options),
    /// Write the headers from the Rust sources, and the C# and Python declarations from the headers
    Header {
        /// Write nothing; fail with a diff if a committed file does not match the sources
        #[arg(long)]
        check: bool,
        /// Keep the headers as those of a release, with which stage "abi" compares later ones
        #[arg(long, conflicts_with = "check")]
        keep: bool,
    },
    /// Build the C library and install it with its headers, CMake package and pkg-config file
    Install {
        /// Folder that gets lib/ and include/
        #[arg(long)]
        prefix: PathBuf,
        /// Install a debug build
        #[arg(long)]
        debug: bool,
    },
    /// Make the release archives, for users without Rust
    Package(package::Options),
    /// Make the Python wheel for this system, with the library and the command inside
    Wheel {
        /// Folder for the wheel
        #[arg(long, value_name = "DIR", default_value = "out/wheel")]
        out: PathBuf,
    },
    /// Make the archive of the Godot extension
    Addon(godot::Options),
    /// Make the archive of the Blender extension, for this system
    Extension(blender::Options),
    /// Make the npm package and its page
    Web {
        /// Folder for the package and the page
        #[arg(long, value_name = "DIR", default_value = "out/web")]
        out: PathBuf,
    },
    /// Fuzz every door of the library, guided by coverage
    Fuzz(fuzz::Options),
    /// Run unit tests in Miri, which finds undefined behaviour; needs a nightly toolchain
    Miri,
    /// Run unit tests under MemorySanitizer, which finds reads of memory that nobody wrote; needs a nightly toolchain
    Msan,
    /// Run tests of threads in thousands of orders of their steps
    Schedules,
    /// Measure accuracy, cost, stability and peers; write docs/lab with its tables, charts and report
    Lab(lab::Options),
    /// Measure fixed workloads and references in the same run; write docs/bench
    Bench(lab::BenchOptions),
    /// Run info, bake, sample and apply over a folder of glTF and OBJ files, and compare everything that no dent reached
    Sweep {
        /// The folder. An OBJ's examples are the files beside it whose names begin with its name and _
        #[arg(value_parser = workspace::absolute)]
        folder: PathBuf,
        /// Options for each of the commands, such as --join
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        options: Vec<String>,
    },
    /// Run every check and every test stage; a missing program fails its stage, and what fails runs once more
    Ci {
        /// Stop at the first stage that fails
        #[arg(long)]
        fail_fast: bool,
    },
    /// Compile what stages of `test --all` need in folders of their own
    #[command(hide = true)]
    Ahead,
    /// Make the passenger car: panels, wheels, inner structure, a coarse level and a collider as glTF
    Car(car::Options),
    /// Run the checks of `ci` that build nothing: asset sizes, README snippets, changelog, Unity's .meta files, quoted messages
    Repo {
        /// Copy the quickstart programs into the pages that show them, and write missing .meta files
        #[arg(long)]
        fix: bool,
    },
}

fn main() -> ExitCode {
    match run(Cli::parse().command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run(command: Command) -> Result<()> {
    workspace::enter()?;
    match command {
        Command::Demo { out, gpu } => car::demo(&out, gpu.as_deref()),
        Command::Test(options) => test::run(&options, false),
        Command::Header { keep: true, .. } => abi::keep(),
        Command::Header { check, .. } => header::run(check),
        Command::Install { prefix, debug } => install::run(&prefix, if debug { "debug" } else { "release" }),
        Command::Package(options) => package::run(&options),
        Command::Wheel { out } => python::run(&out),
        Command::Addon(options) => godot::run(&options),
        Command::Extension(options) => blender::run(&options),
        Command::Web { out } => web::run(&out),
        Command::Fuzz(options) => fuzz::run(&options),
        Command::Miri => nightly::miri(),
        Command::Msan => nightly::memory(),
        Command::Schedules => nightly::schedules(),
        Command::Lab(options) => lab::run(&options),
        Command::Bench(options) => lab::bench(&options),
        Command::Sweep { folder, options } => {
            let test = workspace::cargo(&["test", "--quiet", "--package", "crumple", "--features", "cli"]);
            exports::sweep(test, &folder, &options.join(" "))
        }
        Command::Ci { fail_fast } => test::run(&test::Options { fail_fast, ..Default::default() }, true),
        Command::Ahead => test::ahead(),
        Command::Car(options) => car::run(&options),
        Command::Repo { fix } => repo::run(fix),
    }
}
