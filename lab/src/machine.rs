//! The machine and the versions that figures come from.

use std::fs;

pub struct Machine {
    pub cpu: String,
    pub cores: usize,
}

impl Machine {
    pub fn here() -> Self {
        let info = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let field = |name: &str| {
            let line = info.lines().find(|l| l.split(':').next().is_some_and(|k| k.trim() == name))?;
            Some(line.split_once(':')?.1.trim().to_owned())
        };
        let cpu = match (field("model name"), field("cpu family"), field("model")) {
            (Some(name), Some(family), Some(model)) => format!("{name} (family {family}, model {model})"),
            (Some(name), ..) => name,
            _ => std::env::consts::ARCH.to_owned(),
        };
        Self { cpu, cores: std::thread::available_parallelism().map_or(1, usize::from) }
    }

    /// How many tasks were running or waiting over the last minute, on the mean: what the machine is busy with besides. Nothing
    /// where the system does not tell.
    pub fn load() -> Option<f64> {
        fs::read_to_string("/proc/loadavg").ok()?.split_whitespace().next()?.parse().ok()
    }

    /// For the top of a CSV file; `threads` says on how many of them costs are.
    pub fn comments(&self, threads: &str) -> Vec<(&'static str, String)> {
        vec![
            ("machine", self.cpu.clone()),
            ("cores", format!("{} ({threads})", self.cores)),
            ("system", format!("{} {}", std::env::consts::OS, std::env::consts::ARCH)),
            ("rustc", env!("LAB_RUSTC").to_owned()),
            ("crumple", env!("CARGO_PKG_VERSION").to_owned()),
        ]
    }
}
