//! The benchmark: fixed workloads, each beside a reference of the same run. `cargo xtask bench` runs it.
//!
//! [`measure`] lets contenders take turns, [`report`] shows the rows, [`mod@reference`] has a copy and the classic kernel;
//! the other files are the workloads and what they are made of.

mod build;
mod collider;
mod crowd;
mod deform;
pub mod deformed;
mod idle;
mod impact;
pub mod marks;
pub mod measure;
mod nodes;
mod normals;
mod parts;
mod predict;
mod radial;
mod real;
pub mod reference;
pub mod report;
mod scaling;
pub mod sheet;
mod sheets;
mod worn;

use std::cell::RefCell;
use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Result, bail};
use clap::Args;
use crumple::{Serial, SetOptions, TaskSystem, ThreadPool};

use crate::machine::Machine;
use measure::Plan;
use report::{Report, Row};

/// What the benchmark is told.
#[derive(Args, Debug, Clone, Default)]
pub struct Options {
    /// Short runs, and without the largest meshes; writes no CSV files
    #[arg(long)]
    pub quick: bool,
    /// Writes the results as JSON: an array of name, value, unit, reference (in the unit) and ratio
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Only the results whose names begin like this; may be given several times
    #[arg(long, value_name = "NAME")]
    pub only: Vec<String>,
    /// Where a full run writes its results as MACHINE.csv
    #[arg(long, value_name = "DIR", default_value = "docs/bench")]
    pub out: PathBuf,
    /// Where a full run writes the tables that charts are drawn from
    #[arg(long, value_name = "DIR", default_value = "docs/lab")]
    pub lab: PathBuf,
}

/// What workloads share.
pub struct Bench {
    quick: bool,
    only: Vec<String>,
    plan: Plan,
    report: RefCell<Report>,
    /// By their number of threads; one thread needs none.
    pools: Vec<(usize, ThreadPool)>,
    /// Where the charts' tables go, if anywhere.
    lab: Option<PathBuf>,
}

/// About how many vertices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Size {
    K10,
    K30,
    K64,
    K100,
    K300,
    M1,
    M3,
    M10,
}

impl Size {
    fn name(self) -> &'static str {
        match self {
            Size::K10 => "10k",
            Size::K30 => "30k",
            Size::K64 => "64k",
            Size::K100 => "100k",
            Size::K300 => "300k",
            Size::M1 => "1m",
            Size::M3 => "3m",
            Size::M10 => "10m",
        }
    }

    fn vertices(self) -> usize {
        match self {
            Size::K10 => 10_000,
            Size::K30 => 30_000,
            Size::K64 => 65_536,
            Size::K100 => 100_000,
            Size::K300 => 300_000,
            Size::M1 => 1_000_000,
            Size::M3 => 3_000_000,
            Size::M10 => 10_000_000,
        }
    }
}

/// Options of a set as it is baked for a game: to 0.1 mm.
pub fn baked() -> SetOptions {
    SetOptions { tolerance: Some(1e-4), ..SetOptions::default() }
}

struct Workload {
    /// What the names of its results begin with.
    name: &'static str,
    about: &'static str,
    run: fn(&Bench) -> Result<()>,
}

const WORKLOADS: &[Workload] = &[
    Workload {
        name: "deform_1ex",
        about: "one example moves every vertex of a sheet (_local: a fifth of them), positions only",
        run: deform::one_example,
    },
    Workload {
        name: "deform_4ex",
        about: "four overlapping examples, against four passes of the kernel",
        run: deform::four_examples,
    },
    Workload {
        name: "limits",
        about: "a depth limit, or a stiffness, for every vertex against none: one example, positions only",
        run: deform::limits,
    },
    Workload {
        name: "batch_10",
        about: "a frame of ten impulses against one: repeating a body's ten marks, and on a fresh body",
        run: marks::batch,
    },
    Workload {
        name: "impact",
        about: "from the contact to positions, normals and bounds; the kernel does the positions alone",
        run: impact::run,
    },
    Workload {
        name: "worn",
        about: "one more hit on a body of about 20 000 vertices that was hit often, to positions and normals, against the first",
        run: worn::run,
    },
    Workload {
        name: "hit_hood",
        about: "one more hit on the demo's hood to positions and normals",
        run: nodes::hits_upon_hits,
    },
    Workload {
        name: "predict_12",
        about: "from a blow on the demo's hood to the displacements of its nodes",
        run: nodes::predictions,
    },
    Workload {
        name: "expand_cache",
        about: "positions of all vertices of the demo's hood with nine marks",
        run: nodes::every_vertex,
    },
    Workload {
        name: "bytes_vertex",
        about: "memory of the demo's hood from a file, with normals, without the mesh's own 48 bytes; 12 examples and 300",
        run: nodes::memory,
    },
    Workload { name: "normals", about: "positions and normals against positions alone", run: normals::run },
    Workload {
        name: "parts",
        about: "a hit on a body of 12 parts and 60 000 vertices, to positions and normals, against the same vertices as one mesh",
        run: parts::run,
    },
    Workload {
        name: "scaling",
        about: "a sheet of 10 k to 10 M vertices, all moved, and from one thread to two",
        run: |bench| {
            let lab = bench.lab.clone();
            scaling::run(bench, lab.as_deref())
        },
    },
    Workload {
        name: "predict_100",
        about: "one hit, 100 examples, without what it does to vertices",
        run: predict::run,
    },
    Workload {
        name: "collider",
        about: "one hit, from submission to the positions of a proxy of about 500 vertices, against those of the base mesh",
        run: collider::run,
    },
    Workload { name: "idle_1000", about: "1000 bodies, ten of them hit, against those ten alone", run: idle::run },
    Workload {
        name: "crowd_hood",
        about: "200 hoods drawn as four meshes each, ten blows a frame, one thread: from the blows to positions and normals",
        run: crowd::hoods,
    },
    Workload {
        name: "restore_200",
        about: "200 drums with 16 marks each: from saved bytes to all positions and normals, one thread and two",
        run: crowd::drums,
    },
    Workload { name: "load_1m_24ex", about: "a baked file, against copying its bytes", run: build::load },
    Workload {
        name: "build_1m_24ex",
        about: "a set from arrays, two threads, against copying them",
        run: build::build,
    },
    Workload {
        name: "index_build_1m",
        about: "indices of nearest vertices, one thread, against copying them",
        run: build::index,
    },
];

pub fn run(options: &Options) -> Result<()> {
    let start = Instant::now();
    // Tables of a part of the workloads would replace whole ones.
    let whole = !options.quick && options.only.is_empty();
    let mut bench = Bench::new(options.quick, &options.only)?;
    bench.lab = whole.then(|| options.lab.clone());
    let recipe = recipe(options);
    for (key, value) in Machine::here().comments("threads as the names say: t1, t2; one where they do not") {
        println!("{key}: {value}");
    }
    println!("command: {recipe}");
    println!("ratio: \"x speed\" is reference over value (how many times as fast), \"x cost\" is value over reference");
    println!("times: medians of interleaved runs; a reference takes turns with what is held against it");
    reference::verify()?;
    println!("classic: agrees with the library's own rule to 1e-6 m");
    for workload in WORKLOADS.iter().filter(|w| bench.wanted(w.name)) {
        bench.report.borrow_mut().group(workload.name, workload.about);
        (workload.run)(&bench)?;
    }
    if bench.report.borrow().rows().is_empty() {
        let names: Vec<&str> = WORKLOADS.iter().map(|w| w.name).collect();
        bail!("no result's name begins with {}; they begin with: {}", options.only.join(" or "), names.join(", "));
    }
    bench.report.borrow().summary();
    if let Some(path) = &options.json {
        bench.report.borrow().write_json(path)?;
        println!("json: {}", path.display());
    }
    if whole {
        println!("csv: {}", bench.report.borrow().write_csv(&options.out, &recipe)?.display());
    }
    println!("bench: {:.0} s", start.elapsed().as_secs_f64());
    Ok(())
}

/// The lab's part `speed`: the tables of time against vertices and threads.
pub fn speed(options: &crate::Options) -> Result<()> {
    let bench = Bench::new(options.quick, &[])?;
    reference::verify()?;
    bench.report.borrow_mut().group("speed", "a sheet, all vertices moved");
    scaling::run(&bench, Some(&options.out))
}

fn recipe(options: &Options) -> String {
    let quick = if options.quick { " --quick" } else { "" };
    let only: String = options.only.iter().map(|o| format!(" --only {o}")).collect();
    format!("cargo xtask bench{quick}{only}")
}

impl Bench {
    fn new(quick: bool, only: &[String]) -> Result<Self> {
        let counts = thread_counts(quick).into_iter().filter(|n| *n > 1);
        Ok(Self {
            quick,
            only: only.to_vec(),
            plan: Plan::new(quick),
            report: RefCell::default(),
            pools: counts.map(|n| Ok((n, ThreadPool::new(n)?))).collect::<Result<_>>()?,
            lab: None,
        })
    }

    /// Of so many threads: one of [`thread_counts`].
    fn tasks(&self, threads: usize) -> &dyn TaskSystem {
        self.pools.iter().find(|(n, _)| *n == threads).map_or(&Serial as &dyn TaskSystem, |(_, pool)| pool)
    }

    /// Whether results of this name, or of one that begins with it, are asked for.
    fn wanted(&self, name: &str) -> bool {
        self.only.is_empty() || self.only.iter().any(|o| name.starts_with(o.as_str()) || o.starts_with(name))
    }

    fn add(&self, row: Row) {
        if self.only.is_empty() || self.only.iter().any(|o| row.name.starts_with(o.as_str())) {
            self.report.borrow_mut().add(row);
        }
    }
}

/// 1, 2, and on larger machines every doubling and all cores.
fn thread_counts(quick: bool) -> Vec<usize> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let mut counts = vec![1, 2];
    if !quick {
        counts.extend(std::iter::successors(Some(4), |n| Some(2 * n)).take_while(|n| *n < cores));
        counts.extend((cores > 2).then_some(cores));
    }
    counts
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(only: &str) -> Vec<Row> {
        let bench = Bench::new(true, &[only.to_owned()]).unwrap();
        WORKLOADS.iter().filter(|w| bench.wanted(w.name)).for_each(|w| (w.run)(&bench).unwrap());
        bench.report.take().rows().to_vec()
    }

    #[test]
    fn only_what_is_asked_for_runs() {
        let found = rows("scaling_crumple_10k_t1");
        let names: Vec<&str> = found.iter().map(|r| r.name.as_str()).collect();
        assert_eq!(names, ["scaling_crumple_10k_t1", "scaling_crumple_10k_t1_t2"]);
        assert!(found[0].value > 0.0, "{found:?}");
    }

    #[test]
    fn the_same_input_gives_the_same_hash_on_any_threads() {
        let found = rows("scaling_crumple_10k");
        let hashes: Vec<u64> = found.iter().filter_map(|r| r.hash).collect();
        assert!(hashes.len() == 3 && hashes.iter().all(|h| *h == hashes[0]), "{found:?}");
    }
}
