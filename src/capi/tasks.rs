//! The host's job system as this library's parallel-for.

use super::boundary::quietly;
use crate::base::error::reserve;
use crate::base::tasks::{Serial, TaskSystem};
use std::cell::Cell;
use std::ffi::c_void;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError, RwLock};

/// A task of a parallel-for. Call it with an index below count and with the task_data of CrumpleParallelFor.
pub type CrumpleTask = Option<unsafe extern "C" fn(index: u32, task_data: *mut c_void)>;

/// Your parallel-for. Calls task(index, task_data) once for each index below count, on any threads and in any order,
/// and returns when all calls have returned. Tasks may run concurrently, and do not block or throw. Crumple runs any
/// index that you skip, and ignores repeated ones. Runs on the thread that called Crumple; must not throw or longjmp
/// out. With the same context it may call only functions for any thread; see "Threads".
pub type CrumpleParallelFor =
    Option<unsafe extern "C" fn(count: u32, task: CrumpleTask, task_data: *mut c_void, user: *mut c_void)>;

/// The host's job system. All fields zero: Crumple uses its own threads.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleTaskSystem {
    pub parallel_for: CrumpleParallelFor,
    pub user: *mut c_void,
    /// Number of threads that can work at the same time; 0 counts as 1. It affects how work is split, never the result.
    pub workers: u32,
}

type Call = unsafe extern "C" fn(count: u32, task: CrumpleTask, task_data: *mut c_void, user: *mut c_void);

/// The adapter. The host is not trusted to run every index once, nor to have stopped when it returns: each index is
/// claimed, and leaving waits for those inside. `door` lives as long as the context, so a call that comes late finds
/// it empty.
pub(super) struct HostTasks {
    call: Call,
    user: *mut c_void,
    workers: usize,
    door: Box<RwLock<Option<Job>>>,
    /// One parallel-for at a time.
    turn: Mutex<()>,
}

// SAFETY: `user` is only handed back to the host, who promised that its function may be called from any thread.
unsafe impl Send for HostTasks {}
// SAFETY: as above.
unsafe impl Sync for HostTasks {}

/// What is to be done. The reference to the task lives until `parallel_for` has emptied the door again.
struct Job {
    task: *const (dyn Fn(usize) + Sync),
    claimed: Vec<AtomicBool>,
    /// The first message.
    panicked: Mutex<Option<String>>,
}

// SAFETY: the task may be called from any thread.
unsafe impl Send for Job {}
// SAFETY: as above.
unsafe impl Sync for Job {}

thread_local! {
    /// Whether the thread runs a task now: a parallel-for inside one runs serially.
    static INSIDE: Cell<bool> = const { Cell::new(false) };
}

impl HostTasks {
    pub(super) fn new(call: Call, user: *mut c_void, workers: u32) -> Self {
        let workers = (workers as usize).clamp(1, 1024);
        Self { call, user, workers, door: Box::new(RwLock::new(None)), turn: Mutex::new(()) }
    }
}

/// Runs one task unless somebody else did or does.
unsafe extern "C" fn run_task(index: u32, door: *mut c_void) {
    // SAFETY: the door of a context, which lives as long as the context.
    let door = unsafe { &*door.cast::<RwLock<Option<Job>>>() };
    let door = door.read().unwrap_or_else(PoisonError::into_inner);
    let Some(job) = &*door else { return };
    if job.claimed.get(index as usize).is_none_or(|c| c.swap(true, Ordering::AcqRel)) {
        return;
    }
    let outer = INSIDE.replace(true);
    // SAFETY: the door is held, and is emptied before the task goes.
    let done = quietly(|| unsafe { (*job.task)(index as usize) });
    INSIDE.set(outer);
    if let Err(message) = done {
        job.panicked.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(message);
    }
}

impl TaskSystem for HostTasks {
    fn parallel_for(&self, count: usize, task: &(dyn Fn(usize) + Sync)) {
        let flags = reserve::<AtomicBool>(count, "task flags");
        let (Ok(mut claimed), Ok(number), false, true) = (flags, u32::try_from(count), INSIDE.get(), count > 1) else {
            return Serial.parallel_for(count, task);
        };
        claimed.resize_with(count, || AtomicBool::new(false));
        let _turn = self.turn.lock().unwrap_or_else(PoisonError::into_inner);
        // SAFETY: only the lifetime changes; the door is emptied below before `task` goes.
        let task = unsafe { std::mem::transmute::<*const (dyn Fn(usize) + Sync), *const (dyn Fn(usize) + Sync)>(task) };
        let write = || self.door.write().unwrap_or_else(PoisonError::into_inner);
        *write() = Some(Job { task, claimed, panicked: Mutex::default() });
        let door = (&raw const *self.door).cast_mut().cast();
        // SAFETY: the host promised that its function may be called so; `run_task` may be called with the door as
        // data from any thread, any number of times, with any index.
        unsafe {
            (self.call)(number, Some(run_task), door, self.user);
            // Those that the host left out.
            (0..number).for_each(|index| run_task(index, door));
        }
        // Waits for tasks that still run on the host's threads: each holds the door while it does.
        let panicked = write().take().map(|job| job.panicked);
        let message = panicked.and_then(|message| message.into_inner().unwrap_or_else(PoisonError::into_inner));
        if let Some(message) = message {
            std::panic::resume_unwind(Box::new(message));
        }
    }

    fn workers(&self) -> usize {
        self.workers
    }
}

/// Makes the panics of tasks as silent as those of the entry point that waits for them.
pub(super) struct Quiet(pub(super) Box<dyn TaskSystem + Send + Sync>);

impl TaskSystem for Quiet {
    fn parallel_for(&self, count: usize, task: &(dyn Fn(usize) + Sync)) {
        self.0.parallel_for(count, &|index| {
            if let Err(message) = quietly(|| task(index)) {
                std::panic::resume_unwind(Box::new(message));
            }
        });
    }

    fn workers(&self) -> usize {
        self.0.workers()
    }

    fn sleeps(&self) -> bool {
        self.0.sleeps()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::AtomicUsize;

    /// Runs odd indices twice, from threads that it does not wait for, and forgets those that 4 divides.
    unsafe extern "C" fn careless(count: u32, task: CrumpleTask, data: *mut c_void, _user: *mut c_void) {
        let data = data.expose_provenance();
        for index in (0..count + 7).filter(|i| i % 4 != 0) {
            let run = move || {
                // SAFETY: as the header allows.
                unsafe { task.unwrap()(index, std::ptr::with_exposed_provenance_mut(data)) }
            };
            for _ in 0..1 + index % 2 {
                std::thread::spawn(run);
            }
        }
    }

    #[test]
    fn a_careless_host_runs_every_task_once() {
        let host = HostTasks::new(careless, std::ptr::null_mut(), 4);
        for count in [0, 1, 2, 37] {
            let runs: Vec<_> = (0..count).map(|_| AtomicUsize::new(0)).collect();
            host.parallel_for(count, &|i| {
                host.parallel_for(2, &|_| {
                    runs[i].fetch_add(1, Ordering::Relaxed);
                });
            });
            assert!(runs.iter().all(|r| r.load(Ordering::Relaxed) == 2), "{runs:?}");
        }
        // Late callers still hold the door's address.
        std::thread::sleep(std::time::Duration::from_millis(200));
    }

    #[test]
    fn a_panic_in_a_task_comes_back_to_the_caller() {
        let host = HostTasks::new(careless, std::ptr::null_mut(), 4);
        let caught = quietly(|| host.parallel_for(5, &|i| assert!(i != 3, "task three")));
        assert_eq!(caught.unwrap_err(), "task three");
        std::thread::sleep(std::time::Duration::from_millis(200));
    }
}
