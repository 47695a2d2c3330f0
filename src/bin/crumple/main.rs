//! The `crumple` command: dents a file's mesh with the file's own examples.

mod apply;
mod bake;
mod impacts;
mod info;
mod output;
mod picture;
mod sample;
mod source;
mod table;
mod units;
mod vertices;

use clap::{Parser, Subcommand};
use std::process::ExitCode;

/// Dents meshes. The input is a base mesh, a few examples of dents, and a list of impacts
#[derive(Parser)]
#[command(name = "crumple", version, arg_required_else_help = true)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Print what a file's mesh and examples are, and which part of the body the examples do not reach
    Info(info::Arguments),
    /// Build a mesh's example set and write it as a .crumple file, which loads without being built again
    Bake(bake::Arguments),
    /// Dent a mesh with a list of impacts and write it as a GLB
    Apply(apply::Arguments),
    /// Write a list of impacts to start from
    Sample(sample::Arguments),
}

fn main() -> ExitCode {
    let result = match Arguments::parse().command {
        Command::Info(a) => info::run(&a),
        Command::Bake(a) => bake::run(&a),
        Command::Apply(a) => apply::run(&a),
        Command::Sample(a) => sample::run(&a),
    };
    match result.and_then(|text| output::print(&text)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // The message must be one line, even if text from a file has line breaks.
            let line = format!("{error:#}").split_whitespace().collect::<Vec<_>>().join(" ");
            output::complain(&format!("error: {line}"));
            ExitCode::FAILURE
        }
    }
}
