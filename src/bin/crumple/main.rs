//! The `crumple` command: dents a file's mesh with the file's own examples.

mod apply;
mod bake;
mod gpu;
mod impacts;
mod info;
mod output;
mod picture;
mod replay;
mod sample;
mod source;
mod table;

use anyhow::Result;
use clap::{Parser, Subcommand};
use std::process::ExitCode;

/// Dents meshes by example: a base mesh, a few dents made by an artist or a solver, and a list of impacts.
#[derive(Parser)]
#[command(name = "crumple", version, arg_required_else_help = true)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Tell what a file's mesh and examples are, and which part of the body the examples do not reach
    Info(info::Arguments),
    /// Make a mesh's example set ready once and write it as a .crumple file, which loads at once
    Bake(bake::Arguments),
    /// Dent a mesh by a list of impacts and write it as a GLB
    Apply(apply::Arguments),
    /// Write a list of impacts to start from
    Sample(sample::Arguments),
    /// Make the calls of a recording again and compare what they give
    Replay(replay::Arguments),
}

fn main() -> ExitCode {
    let result = match Arguments::parse().command {
        Command::Info(a) => info::run(&a),
        Command::Bake(a) => bake::run(&a),
        Command::Apply(a) => apply::run(&a),
        Command::Sample(a) => sample::run(&a),
        Command::Replay(a) => replay::run(&a),
    };
    match result.and_then(|text| print(&text)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // One line, whatever the text came from.
            let line = format!("{error:#}").split_whitespace().collect::<Vec<_>>().join(" ");
            output::complain(&format!("error: {line}"));
            ExitCode::FAILURE
        }
    }
}

/// Prints a report. A reader that has gone away (`| head`) is no error.
fn print(text: &str) -> Result<()> {
    use std::io::Write;
    match std::io::stdout().lock().write_all(text.as_bytes()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Err(e.into()),
        _ => Ok(()),
    }
}
