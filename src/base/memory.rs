//! Which allocations may fail, and which a host's allocator has refused.

use std::cell::Cell;
#[cfg(feature = "capi")]
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

thread_local! {
    static MAY_FAIL: Cell<bool> = const { Cell::new(false) };
}

/// Runs an allocation that may fail, such as `try_reserve`. All others of Rust end the process when memory runs out. So a
/// global allocator may have to find memory for them where it may refuse this one.
pub(crate) fn may_fail<T>(allocate: impl FnOnce() -> T) -> T {
    let before = MAY_FAIL.replace(true);
    let result = allocate();
    MAY_FAIL.set(before);
    result
}

/// Whether the allocation that the thread is in may fail.
#[cfg(feature = "host-allocator")]
pub(crate) fn is_fallible() -> bool {
    MAY_FAIL.get()
}

/// How many blocks hosts refused that the system gave instead, on all threads.
#[cfg(feature = "capi")]
static REFUSED: AtomicUsize = AtomicUsize::new(0);

#[cfg(feature = "capi")]
thread_local! {
    /// `REFUSED` when the thread's call began.
    static AT_BEGIN: Cell<usize> = const { Cell::new(0) };
}

/// Counts a refused block.
#[cfg(feature = "host-allocator")]
pub(crate) fn refuse() {
    REFUSED.fetch_add(1, Relaxed);
}

/// From here on `was_refused` asks about a call of the thread.
#[cfg(feature = "capi")]
pub(crate) fn begin_call() {
    AT_BEGIN.set(REFUSED.load(Relaxed));
}

/// Whether a block was refused since the thread's call began.
#[cfg(feature = "capi")]
pub(crate) fn was_refused() -> bool {
    AT_BEGIN.get() != REFUSED.load(Relaxed)
}
