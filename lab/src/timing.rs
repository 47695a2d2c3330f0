//! How long something takes: on the calling thread, warmed, the median of several runs.

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
