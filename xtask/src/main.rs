//! `cargo xtask …`: one command for each thing that people and CI do with this repository,
//! the same on every platform.

mod abi;
mod bench;
mod ci;
mod command;
mod csharp;
mod declarations;
mod demo;
mod fuzz;
mod header;
mod install;
mod lab;
mod messages;
mod native;
mod package;
mod peers;
mod reference;
mod repo;
mod rooms;
mod stage;
mod test;
mod tools;
mod unity;
mod valgrind;
mod vulkan;
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
        /// Where the pictures and the GLB go
        #[arg(long, default_value = "out/demo")]
        out: PathBuf,
        /// Deform on the GPU: the fastest there is, or the one whose name holds this
        #[arg(long, value_name = "NAME", num_args = 0..=1, default_missing_value = "")]
        gpu: Option<String>,
    },
    /// Run every test: Rust, C and C++, under sanitizers and valgrind, and from outside the tree
    Test(test::Options),
    /// Write include/crumple.h from the Rust sources, and the C# declarations from the header
    Header {
        /// Write nothing; fail with a diff when the committed header is not what the sources say
        #[arg(long)]
        check: bool,
    },
    /// Build the C library and install it with its headers, CMake package and pkg-config file
    Install {
        /// Directory that gets lib/ and include/
        #[arg(long)]
        prefix: PathBuf,
        /// Install a debug build
        #[arg(long)]
        debug: bool,
    },
    /// Make the archives that people without Rust download
    Package(package::Options),
    /// Fuzz what reads files from outside, guided by coverage
    Fuzz(fuzz::Options),
    /// Measure accuracy, cost, stability and peers; write docs/lab with its tables, charts and report
    Lab(lab::Options),
    /// Measure fixed workloads beside references of the same run; write docs/bench
    Bench(bench::Options),
    /// Formatting, lints, docs, header and repository checks, then every test with nothing skipped
    Ci {
        /// Stop at the first stage that fails
        #[arg(long)]
        fail_fast: bool,
    },
    /// Only the checks of `ci` that build nothing: asset size, README snippet, changelog, .meta files of the Unity package
    Repo {
        /// Put the present quickstart programs into the pages that show them, and write missing .meta files
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
    let workspace = workspace::Workspace::open()?;
    match command {
        Command::Demo { out, gpu } => demo::run(&workspace, &out, gpu.as_deref()),
        Command::Test(options) => test::run(&workspace, &options),
        Command::Header { check } => header::run(&workspace, check),
        Command::Install { prefix, debug } => {
            let profile = if debug { install::Profile::Debug } else { install::Profile::Release };
            install::run(&workspace, &prefix, profile)
        }
        Command::Package(options) => package::run(&workspace, &options),
        Command::Fuzz(options) => fuzz::run(&workspace, &options),
        Command::Lab(options) => lab::run(&workspace, &options),
        Command::Bench(options) => bench::run(&workspace, &options),
        Command::Ci { fail_fast } => test::ci(&workspace, fail_fast),
        Command::Repo { fix } => repo::run(&workspace, fix),
    }
}
