//! How long things take beside each other: they run in turn (A, B, C, A, B, C …), so that noise hits all alike.

use std::time::{Duration, Instant};

use crate::metric::quantile;

/// One of the things that are measured in turn.
pub struct Contender<'a> {
    /// Prepares, works, and says how long the work alone took. Each call does the same work.
    run: Box<dyn FnMut() -> Duration + 'a>,
}

impl<'a> Contender<'a> {
    pub fn new(run: impl FnMut() -> Duration + 'a) -> Self {
        Self { run: Box::new(run) }
    }
}

/// How much is measured.
#[derive(Debug, Clone, Copy)]
pub struct Plan {
    /// For all contenders of a case together, preparation included.
    pub budget: Duration,
    /// Rounds, whatever they cost …
    pub least: usize,
    /// … and however little.
    pub most: usize,
}

impl Plan {
    pub fn new(quick: bool) -> Self {
        if quick {
            Plan { budget: Duration::from_millis(250), least: 3, most: 31 }
        } else {
            Plan { budget: Duration::from_secs(2), least: 7, most: 301 }
        }
    }
}

/// Work shorter than this runs several times before the next contender's turn: what fits a cache should find itself there.
const TURN: Duration = Duration::from_micros(300);
const RUNS_A_TURN: usize = 32;

/// The measured times of one contender.
#[derive(Debug, Clone)]
pub struct Times(Vec<f64>);

impl Times {
    /// From times in seconds.
    pub fn new(seconds: Vec<f64>) -> Self {
        Self(seconds)
    }

    /// s.
    pub fn median(&self) -> f64 {
        self.quantile(0.5)
    }

    /// s.
    pub fn quantile(&self, q: f64) -> f64 {
        quantile(&self.0, q)
    }

    /// How many.
    pub fn runs(&self) -> usize {
        self.0.len()
    }

    /// The same per piece of work, where each time is that of `pieces`.
    pub fn per(&self, pieces: f64) -> Self {
        Self(self.0.iter().map(|t| t / pieces).collect())
    }
}

/// Times of the contenders, in their order. The first run of each warms and is not counted.
pub fn interleaved(plan: &Plan, contenders: &mut [Contender]) -> Vec<Times> {
    let start = Instant::now();
    let first: Vec<Duration> = contenders.iter_mut().map(|c| (c.run)()).collect();
    let round = start.elapsed().max(Duration::from_nanos(1));
    let longest = first.iter().max().copied().unwrap_or_default().as_secs_f64().max(1e-9);
    let turn = ((TURN.as_secs_f64() / longest) as usize).clamp(1, RUNS_A_TURN);
    // A turn of several runs begins with one that is not counted.
    let uncounted = usize::from(turn > 1);
    let affordable = plan.budget.as_secs_f64() / (round.as_secs_f64() * (turn + uncounted) as f64);
    let rounds = (affordable as usize).clamp(plan.least, plan.most);
    let mut times = vec![Vec::with_capacity(rounds * turn); contenders.len()];
    for _ in 0..rounds {
        for (contender, times) in contenders.iter_mut().zip(&mut times) {
            for i in 0..turn + uncounted {
                let took = (contender.run)();
                if i >= uncounted {
                    times.push(took.as_secs_f64());
                }
            }
        }
    }
    times.into_iter().map(Times).collect()
}

/// How long `work` takes.
pub fn timed(work: impl FnOnce()) -> Duration {
    let start = Instant::now();
    work();
    start.elapsed()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::RefCell;

    #[test]
    fn contenders_alternate_and_only_their_work_counts() {
        let order = RefCell::new(Vec::new());
        let contender = |name: &'static str, ms: u64| {
            let order = &order;
            Contender::new(move || {
                order.borrow_mut().push(name);
                std::thread::sleep(Duration::from_millis(1));
                Duration::from_millis(ms)
            })
        };
        let plan = Plan { budget: Duration::ZERO, least: 3, most: 5 };
        let times = interleaved(&plan, &mut [contender("a", 1), contender("b", 2)]);
        assert_eq!(*order.borrow(), ["a", "b"].repeat(4));
        assert_eq!(times.iter().map(Times::runs).collect::<Vec<_>>(), [3, 3]);
        assert_eq!(times[1].median(), 0.002);
        assert_eq!(times[1].per(4.0).median(), 0.0005);
    }

    #[test]
    fn short_work_runs_several_times_a_turn() {
        let mut calls = 0;
        let plan = Plan { budget: Duration::ZERO, least: 1, most: 1 };
        let short = Contender::new(|| {
            calls += 1;
            Duration::from_micros(90)
        });
        let times = interleaved(&plan, &mut [short]);
        assert_eq!(times[0].runs(), 3);
        assert_eq!(calls, 1 + 1 + 3);
    }
}
