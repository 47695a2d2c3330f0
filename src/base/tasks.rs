//! Parallel-for, run by this library's rayon pool, by the host's job system or on the caller's thread. Results depend
//! neither on the task system nor on the number of threads.

use crate::base::error::Error;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

/// A parallel-for. An implementation calls `task(i)` exactly once for every `i` in `0..count`, on any threads, and
/// returns when all calls have returned. It panics if a task panics.
pub trait TaskSystem: Sync {
    /// Runs `task(0) … task(count - 1)`.
    fn parallel_for(&self, count: usize, task: &(dyn Fn(usize) + Sync));

    /// Number of threads that may work at once, at least 1. It only affects how finely work is split.
    fn workers(&self) -> usize {
        1
    }

    /// Whether the other threads sleep until there is work. Then work that takes no longer than waking them stays on
    /// the caller's thread. A host's job system decides for itself.
    fn sleeps(&self) -> bool {
        false
    }
}

/// Runs everything on the caller's thread.
#[derive(Debug, Clone, Copy, Default)]
pub struct Serial;

impl TaskSystem for Serial {
    fn parallel_for(&self, count: usize, task: &(dyn Fn(usize) + Sync)) {
        (0..count).for_each(task);
    }
}

/// The caller's thread and a private rayon pool. It does not use rayon's global pool. Dropping it waits until its
/// threads have ended.
#[derive(Debug)]
pub struct ThreadPool(Option<Threads>);

#[derive(Debug)]
struct Threads {
    pool: rayon::ThreadPool,
    /// Joined on drop, because a dropped rayon pool only asks its threads to end.
    _handles: Joined,
}

/// Threads that are joined on drop. Fields are dropped in order, so the pool has already asked the threads to end. A
/// pool thread never drops the pool itself, because pool threads run tasks only while the pool is borrowed.
#[derive(Debug, Default)]
struct Joined(Vec<std::thread::JoinHandle<()>>);

impl Drop for Joined {
    fn drop(&mut self) {
        for handle in self.0.drain(..) {
            let _ = handle.join();
        }
    }
}

impl ThreadPool {
    /// A pool that works on `threads` threads, of which the caller's is one. 0 is one for each core the process may
    /// use.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] above 1024 threads; [`Error::OutOfMemory`] if the system cannot start the threads.
    pub fn new(threads: usize) -> Result<Self, Error> {
        if threads > 1024 {
            return Err(Error::invalid("threads", threads, "0 (one for each core) or 1 to 1024"));
        }
        let threads =
            if threads == 0 { std::thread::available_parallelism().map_or(1, |n| n.get().min(1024)) } else { threads };
        if threads == 1 {
            return Ok(Self(None));
        }
        let mut handles = Joined::default();
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads - 1)
            .spawn_handler(|thread| {
                let name = format!("crumple {}", thread.index());
                handles.0.push(std::thread::Builder::new().name(name).spawn(|| thread.run())?);
                Ok(())
            })
            .build()
            .map_err(|e| Error::OutOfMemory { what: format!("{threads} threads ({e})"), bytes: 0 })?;
        Ok(Self(Some(Threads { pool, _handles: handles })))
    }
}

impl TaskSystem for ThreadPool {
    fn parallel_for(&self, count: usize, task: &(dyn Fn(usize) + Sync)) {
        match &self.0 {
            // The caller begins at once. The others help as soon as they are awake.
            Some(threads) if count > 1 => {
                let next = AtomicUsize::new(0);
                let work = || {
                    let take = || Some(next.fetch_add(1, Ordering::Relaxed)).filter(|i| *i < count);
                    std::iter::from_fn(take).for_each(task);
                };
                threads.pool.in_place_scope(|scope| {
                    (1..count.min(self.workers())).for_each(|_| scope.spawn(|_| work()));
                    work();
                });
            }
            _ => Serial.parallel_for(count, task),
        }
    }

    fn workers(&self) -> usize {
        self.0.as_ref().map_or(1, |t| t.pool.current_num_threads() + 1)
    }

    fn sleeps(&self) -> bool {
        true
    }
}

/// Runs `task(0) … task(count - 1)` exactly once each, so that a mistake in the host's task system causes neither a
/// data race nor missing results. A second call of the same task does nothing. A task that was not called runs here
/// afterwards.
pub(crate) fn run_each(tasks: &dyn TaskSystem, count: usize, task: &(dyn Fn(usize) + Sync)) {
    if count <= 1 {
        return Serial.parallel_for(count, task);
    }
    let claimed: Vec<AtomicBool> = (0..count).map(|_| AtomicBool::new(false)).collect();
    let once = |i: usize| {
        if claimed.get(i).is_some_and(|c| !c.swap(true, Ordering::AcqRel)) {
            task(i);
        }
    };
    tasks.parallel_for(count, &once);
    (0..count).for_each(once);
}

/// Applies `f` to each item and returns the results in the items' order. Each item is one task. Items may be mutable
/// borrows.
pub(crate) fn map<T: Send, U: Send>(
    tasks: &dyn TaskSystem,
    items: impl IntoIterator<Item = T>,
    f: impl Fn(T) -> U + Sync,
) -> Vec<U> {
    let items = items.into_iter();
    if items.size_hint() == (1, Some(1)) {
        return items.map(f).collect();
    }
    let slots: Vec<_> = items.map(|item| Mutex::new((Some(item), None))).collect();
    run_each(tasks, slots.len(), &|i| {
        let mut slot = slots[i].lock().unwrap_or_else(PoisonError::into_inner);
        slot.1 = slot.0.take().map(&f);
    });
    let made = slots.into_iter().map(|s| s.into_inner().unwrap_or_else(PoisonError::into_inner).1);
    made.map(|made| made.expect("all ran; a task system must pass on the panic of one")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Sloppy;
    impl TaskSystem for Sloppy {
        fn parallel_for(&self, count: usize, task: &(dyn Fn(usize) + Sync)) {
            (0..count + 3).chain(0..count).filter(|i| *i != 2).for_each(task);
        }
    }

    #[test]
    fn each_task_runs_once_whatever_the_system_does() {
        for tasks in [&Sloppy as &dyn TaskSystem, &Serial, &ThreadPool::new(3).unwrap()] {
            let runs: Vec<AtomicUsize> = (0..20).map(|_| AtomicUsize::new(0)).collect();
            run_each(tasks, 20, &|i| {
                runs[i].fetch_add(1, Ordering::Relaxed);
            });
            assert!(runs.iter().all(|r| r.load(Ordering::Relaxed) == 1));
        }
    }

    #[test]
    fn what_tasks_make_is_in_the_order_of_the_items() {
        for tasks in [&Sloppy as &dyn TaskSystem, &Serial, &ThreadPool::new(3).unwrap()] {
            for count in [0, 1, 2, 20] {
                let mut numbers: Vec<usize> = (0..count).collect();
                let made = map(tasks, numbers.iter_mut().enumerate(), |(i, n)| {
                    *n += 1;
                    format!("{i}")
                });
                assert_eq!(made, (0..count).map(|i| i.to_string()).collect::<Vec<_>>());
                assert!(numbers.into_iter().eq(1..=count));
            }
        }
    }

    #[test]
    #[should_panic(expected = "panic of one")]
    fn a_result_that_a_swallowed_panic_left_out_is_not_passed_over() {
        struct Swallows;
        impl TaskSystem for Swallows {
            fn parallel_for(&self, count: usize, task: &(dyn Fn(usize) + Sync)) {
                let run = |i| std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| task(i)));
                (0..count).for_each(|i| drop(run(i)));
            }
        }
        map(&Swallows, 0..4, |i| assert!(i != 2, "task two"));
    }
}
