//! The threads that build sets and deform meshes. They end before the library is unloaded.

use crumple::{Serial, TaskSystem, ThreadPool};
use std::sync::{Mutex, PoisonError};

static POOL: Mutex<Option<ThreadPool>> = Mutex::new(None);

/// Calls `work` with the pool, which the first call starts. A second thread that comes meanwhile works alone.
pub fn with<R>(work: impl FnOnce(&dyn TaskSystem) -> R) -> R {
    let Ok(mut pool) = POOL.try_lock() else { return work(&Serial) };
    if pool.is_none() {
        *pool = ThreadPool::new(0).ok();
    }
    match &*pool {
        Some(pool) => work(pool),
        None => work(&Serial),
    }
}

/// Ends the threads.
pub fn end() {
    POOL.lock().unwrap_or_else(PoisonError::into_inner).take();
}
