//! The same on graphics devices: fixed workloads on each device that the loader finds, each beside a copy of as many bytes and
//! the classic kernel on the same device in the same run. `cargo xtask bench --gpu` runs it.
//!
//! [`engine`] and [`buffer`] are the host, [`recorded`] the library in it, [`literature`] what it is held against, [`scene`] what
//! is dented, [`check`] holds results against the CPU path, [`aims`] and [`findings`] say what is found; the rest are workloads.

mod aims;
mod buffer;
mod check;
pub mod compiled;
mod copy;
mod engine;
mod findings;
mod groups;
mod impulses;
mod instances;
mod library;
mod literature;
mod recorded;
mod recording;
mod scene;
mod transfer;
mod vertices;

use std::cell::RefCell;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use anyhow::{Result, bail};
use clap::Args;
use crumple::ThreadPool;

use crate::bench::measure::{Contender, Plan, Times, interleaved};
use crate::machine::Machine;
use engine::{Gpu, Loader};
use findings::{Finding, Findings};

/// What the benchmark of devices is told.
#[derive(Args, Debug, Clone, Default)]
pub struct Options {
    /// Short runs and small sizes; writes no CSV files
    #[arg(long)]
    pub quick: bool,
    /// Only devices whose names begin like this; may be given several times
    #[arg(long, value_name = "NAME")]
    pub device: Vec<String>,
    /// Only these workloads; may be given several times
    #[arg(long, value_name = "WORKLOAD")]
    pub only: Vec<String>,
    /// The stripped library, whose size is shown
    #[arg(long, value_name = "FILE")]
    pub library: Option<PathBuf>,
    /// Where a full run writes its results as gpu-DEVICE.csv
    #[arg(long, value_name = "DIR", default_value = "docs/bench")]
    pub out: PathBuf,
}

/// How much is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Scale {
    /// On a graphics card.
    Card,
    /// On a driver that computes on the CPU.
    Software,
    Quick,
    /// That everything runs, and no more.
    #[cfg_attr(not(test), allow(dead_code))]
    Least,
}

/// What workloads share, on one device.
pub struct Bench<'g> {
    gpu: &'g Gpu,
    scale: Scale,
    plan: Plan,
    /// All cores.
    tasks: ThreadPool,
    library: Option<PathBuf>,
    findings: RefCell<Findings>,
}

struct Workload {
    /// What the names of its results begin with.
    name: &'static str,
    about: &'static str,
    /// Of each [`Scale`] what it is done with: numbers of vertices, of instances where `about` says so.
    sizes: [&'static [usize]; 4],
    run: fn(&Bench<'_>, &[usize]) -> Result<()>,
}

const K: usize = 1000;
const M: usize = 1_000_000;

const WORKLOADS: &[Workload] = &[
    Workload {
        name: "vertices",
        about: "one mark moves every vertex of a sheet; the classic kernel with one example; the CPU path, all cores",
        sizes: [
            &[K, 3 * K, 10 * K, 30 * K, 100 * K, 300 * K, M, 3 * M, 10 * M],
            &[K, 3 * K, 10 * K, 30 * K, 100 * K, 300 * K, M],
            &[10 * K, 100 * K],
            &[256],
        ],
        run: vertices::run,
    },
    Workload {
        name: "groups",
        about: "the same in workgroups of 32 to 128",
        sizes: [&[10 * K, 100 * K, M, 10 * M], &[10 * K, 100 * K], &[10 * K], &[256]],
        run: groups::run,
    },
    Workload {
        name: "impulses",
        about: "one, three and ten impulses that overlap, on a fresh body; and ten that repeat a body's ten marks",
        sizes: [&[100 * K, 10 * M], &[100 * K], &[10 * K], &[256]],
        run: impulses::run,
    },
    Workload {
        name: "instances",
        about: "1000 instances in one buffer, of so many vertices each: 100 hit, and all, against as many vertices in one",
        sizes: [&[10 * K], &[K], &[256], &[64]],
        run: instances::run,
    },
    Workload {
        name: "record",
        about: "the CPU's cost of recording so many instances, each with a mark that changed",
        sizes: [&[1, 10, 100, 1000], &[1, 10, 100, 1000], &[1, 1000], &[1, 10]],
        run: recording::run,
    },
    Workload {
        name: "transfer",
        about: "the upload of a set with its first target, and reading the vertices back",
        sizes: [&[10 * K, 100 * K, M, 10 * M], &[10 * K, 100 * K, M], &[10 * K], &[256]],
        run: transfer::run,
    },
    Workload { name: "library", about: "what an engine links", sizes: [&[]; 4], run: library::run },
];

pub fn run(options: &Options) -> Result<()> {
    for name in &options.only {
        if !WORKLOADS.iter().any(|w| w.name == name) {
            let names: Vec<&str> = WORKLOADS.iter().map(|w| w.name).collect();
            bail!("there is no workload {name:?}; there are: {}", names.join(", "));
        }
    }
    let devices = Loader::open()?.devices()?;
    let wanted = |g: &&Gpu| options.device.is_empty() || options.device.iter().any(|d| g.name.starts_with(d.as_str()));
    let names: Vec<&str> = devices.iter().map(|g| g.name.as_str()).collect();
    println!("devices: {}", names.join("; "));
    if !devices.iter().any(|g| wanted(&g)) {
        bail!("no device's name begins with {}", options.device.join(" or "));
    }
    for gpu in devices.iter().filter(wanted) {
        on(gpu, options)?;
    }
    Ok(())
}

fn on(gpu: &Gpu, options: &Options) -> Result<()> {
    let start = Instant::now();
    let scale = match (options.quick, gpu.software) {
        (true, _) => Scale::Quick,
        (false, true) => Scale::Software,
        (false, false) => Scale::Card,
    };
    let bench = Bench::new(gpu, scale, options.library.clone())?;
    bench.findings.borrow_mut().load = Machine::load();
    let recipe = recipe(options);
    println!("\ndevice: {}", gpu.name);
    println!("driver: {}", gpu.driver);
    println!("clock: {}", gpu.clock());
    for (key, value) in Machine::here().comments("the CPU path takes all") {
        println!("{key}: {value}");
    }
    println!("command: {recipe}");
    println!("times: medians of interleaved runs on the device; results are held against the CPU path's");
    for workload in WORKLOADS.iter().filter(|w| options.only.is_empty() || options.only.iter().any(|o| o == w.name)) {
        bench.run(workload)?;
    }
    bench.findings.borrow().summary();
    if !options.quick && options.only.is_empty() {
        println!("csv: {}", bench.findings.borrow().write(gpu, &options.out, &recipe)?.display());
    }
    println!("{}: {:.0} s", gpu.name, start.elapsed().as_secs_f64());
    Ok(())
}

fn recipe(options: &Options) -> String {
    let quick = if options.quick { " --quick" } else { "" };
    let only: String = options.only.iter().map(|o| format!(" --only {o}")).collect();
    format!("cargo xtask bench --gpu{quick}{only}")
}

impl<'g> Bench<'g> {
    fn new(gpu: &'g Gpu, scale: Scale, library: Option<PathBuf>) -> Result<Self> {
        let plan = |ms, least, most| Plan { budget: Duration::from_millis(ms), least, most };
        let plan = match scale {
            Scale::Card => plan(2000, 15, 301),
            Scale::Software => plan(1500, 4, 101),
            Scale::Quick => plan(250, 3, 31),
            Scale::Least => plan(0, 1, 1),
        };
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let tasks = ThreadPool::new(cores)?;
        Ok(Bench { gpu, scale, plan, tasks, library, findings: RefCell::default() })
    }

    fn run(&self, workload: &Workload) -> Result<()> {
        self.findings.borrow_mut().group(workload.name, workload.about);
        (workload.run)(self, workload.sizes[self.scale as usize])
    }

    /// Times of the contenders in turn, warmed.
    fn measure<const N: usize>(&self, mut contenders: [Contender<'_>; N]) -> [Times; N] {
        let times = interleaved(&self.plan, &mut contenders);
        times.try_into().unwrap_or_else(|t: Vec<Times>| panic!("{} times of {N} contenders", t.len()))
    }

    fn add(&self, finding: Finding) {
        self.findings.borrow_mut().add(self.gpu, finding);
    }

    /// What `made` is, or `None` where the device is too small for it, aloud.
    fn fits<T>(&self, what: &str, made: Result<T>) -> Result<Option<T>> {
        match made {
            Ok(t) => Ok(Some(t)),
            Err(e) if too_large(&e) => {
                self.findings.borrow_mut().leave_out(format!("{what}: {e:#}"));
                Ok(None)
            }
            Err(e) => Err(e),
        }
    }
}

/// Whether a device can bind or hold less than was asked for.
fn too_large(error: &anyhow::Error) -> bool {
    use ash::vk::Result as R;
    use crumple::ErrorKind as K;
    let ours = error.downcast_ref::<crumple::Error>().map(crumple::Error::kind);
    let vulkan = error.downcast_ref::<R>();
    matches!(ours, Some(K::Unsupported | K::OutOfMemory))
        || matches!(vulkan, Some(&(R::ERROR_OUT_OF_DEVICE_MEMORY | R::ERROR_OUT_OF_HOST_MEMORY)))
}

#[cfg(test)]
mod tests;
