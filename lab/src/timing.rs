//! How long something takes: on the calling thread, warmed, the median of several runs.

use std::fs;
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use crate::metric::median;

/// Median time of one call of `work`, µs. `prepare` runs before each call and is not counted. The first call warms and is
/// not counted; at least `runs` are, and more as long as they take less than `budget` together (at most ten times `runs`).
pub fn median_us<S>(
    runs: usize,
    budget: Duration,
    mut prepare: impl FnMut() -> S,
    mut work: impl FnMut(&mut S),
) -> f64 {
    let mut times = Vec::with_capacity(runs);
    let start = Instant::now();
    for i in 0..=10 * runs {
        let mut state = prepare();
        let at = Instant::now();
        work(&mut state);
        let took = at.elapsed();
        if i > 0 {
            times.push(took.as_secs_f64() * 1e6);
        }
        if times.len() >= runs && start.elapsed() > budget {
            break;
        }
    }
    median(&times)
}

/// Processor time of this thread so far, ms: what others do on the machine does not count. Where the system does not tell, wall
/// time since the first call.
pub fn thread_ms() -> f64 {
    static FIRST: OnceLock<Instant> = OnceLock::new();
    let told = fs::read_to_string("/proc/thread-self/schedstat").ok();
    let told = told.and_then(|t| t.split_whitespace().next()?.parse::<f64>().ok());
    told.map_or_else(|| FIRST.get_or_init(Instant::now).elapsed().as_secs_f64() * 1e3, |ns| ns / 1e6)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_work_counts() {
        let slow = || std::thread::sleep(Duration::from_millis(3));
        let us = median_us(3, Duration::ZERO, slow, |()| ());
        assert!(us < 1000.0, "{us}");
    }
}
