//! The lab: measures how near to four truths predicted dents come and what they cost, how dents combine, and
//! where methods fail. `cargo xtask lab` runs all of it and draws the charts; each part writes CSV files.

// What only the engines and graphics devices need.
#![cfg_attr(not(all(feature = "engines", feature = "gpu")), allow(dead_code, unused_imports))]

mod accuracy;
mod bench;
#[cfg(feature = "engines")]
mod car;
mod combine;
#[cfg(feature = "engines")]
mod crash;
#[cfg(feature = "engines")]
mod crowd;
#[cfg(feature = "gpu")]
mod gpu;
mod looks;
mod machine;
mod metric;
#[cfg(feature = "engines")]
mod peers;
mod pictures;
mod scene;
mod stability;
mod street;
mod table;
mod timing;
mod truth;

use std::path::PathBuf;

use anyhow::Result;
use clap::{Args, Parser, Subcommand};

#[derive(Parser)]
#[command(name = "crumple-lab", about = "Measures Crumple against four truths, its peers and the classic rule")]
struct Cli {
    #[command(subcommand)]
    part: Part,
}

#[derive(Subcommand)]
enum Part {
    /// How near single dents come to the truth, and what they cost
    Accuracy(Options),
    /// The same on every body, by what a hit tells: displacement, depth, blow or impulse
    Told(Options),
    /// Error against the number of examples, up to hundreds: the rule that learns from all, beside 0.1.0's
    Learn(Options),
    /// How several dents combine
    Combine(Options),
    /// Where methods fail
    Stability(Options),
    /// Physics engines on the same impacts
    #[cfg(feature = "engines")]
    Peers(Options),
    /// Hits in an engine with the body rigid, and Crumple told its contacts
    #[cfg(feature = "engines")]
    Contacts(ContactsOptions),
    /// The paper's visual tests, classic beside ours
    Pictures(Options),
    /// How dents look: normals, roughness, pictures; after one hit and after 64
    Looks(Options),
    /// Time against the number of moved vertices and against threads
    Speed(Options),
    /// Fixed workloads beside references of the same run
    Bench(bench::Options),
    /// The same on graphics devices
    #[cfg(feature = "gpu")]
    Gpu(gpu::Options),
    /// What a graphics driver's compiler makes of the kernels, without a card
    #[cfg(feature = "gpu")]
    Compiled(gpu::compiled::Options),
    /// 1000 dented bodies before a camera: levels of detail, tolerances, vertex budgets
    Scene(Options),
    /// The frames of a film: a car into a post, and another into its side
    #[cfg(feature = "engines")]
    Crash(Options),
    /// The frames of a film: 200 cars meet; and what each frame costs
    #[cfg(feature = "engines")]
    Crowd(Options),
}

/// What every part is told.
#[derive(Args, Debug, Clone)]
pub struct Options {
    /// A few impacts and repetitions only: shows that it runs, not what is true
    #[arg(long)]
    pub quick: bool,
    /// Where the CSV files go
    #[arg(long, value_name = "DIR", default_value = "docs/lab")]
    pub out: PathBuf,
}

/// What the part `contacts` is told.
#[derive(Args, Debug, Clone)]
pub struct ContactsOptions {
    #[command(flatten)]
    all: Options,
    /// Folder of the programs of lab/throws; engines without one are left out
    #[arg(long, value_name = "DIR")]
    throws: Option<PathBuf>,
    /// Fail where the figures are worse than what the engines reach
    #[arg(long)]
    check: bool,
}

fn main() -> Result<()> {
    match Cli::parse().part {
        Part::Accuracy(options) => accuracy::run(&options),
        Part::Told(options) => accuracy::told::run(&options),
        Part::Learn(options) => accuracy::learn::run(&options),
        Part::Combine(options) => combine::run(&options),
        Part::Stability(options) => stability::run(&options),
        #[cfg(feature = "engines")]
        Part::Peers(options) => peers::run(&options),
        #[cfg(feature = "engines")]
        Part::Contacts(options) => peers::contacts(&options.all, options.throws.as_deref(), options.check),
        Part::Pictures(options) => pictures::run(&options),
        Part::Looks(options) => looks::run(&options),
        Part::Speed(options) => bench::speed(&options),
        Part::Bench(options) => bench::run(&options),
        #[cfg(feature = "gpu")]
        Part::Gpu(options) => gpu::run(&options),
        #[cfg(feature = "gpu")]
        Part::Compiled(options) => gpu::compiled::run(&options),
        Part::Scene(options) => street::run(&options),
        #[cfg(feature = "engines")]
        Part::Crash(options) => crash::run(&options),
        #[cfg(feature = "engines")]
        Part::Crowd(options) => crowd::run(&options),
    }
}
