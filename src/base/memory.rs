//! Which allocations may fail.

use std::cell::Cell;

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
