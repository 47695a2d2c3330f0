//! The library's memory from the host's allocator (feature `host-allocator`).

use super::boundary::boundary;
use super::check::{Def, def};
use super::result::CrumpleResult;
#[cfg(not(feature = "host-allocator"))]
use super::result::Failure;
use std::ffi::c_void;

/// Gives size bytes aligned to align (a power of two, at least 16), or null. Called from any thread, several at once. Must not
/// call Crumple, throw, or jump out.
pub type CrumpleAlloc = Option<unsafe extern "C" fn(size: usize, align: usize, user: *mut c_void) -> *mut c_void>;

/// Takes back what CrumpleAlloc gave, with the same size and align. Called from any thread, several at once. Must not call
/// Crumple, throw, or jump out.
pub type CrumpleFree = Option<unsafe extern "C" fn(pointer: *mut c_void, size: usize, align: usize, user: *mut c_void)>;

/// The host's allocator.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleAllocatorDef {
    /// Bytes of this struct, from crumple_default_allocator_def().
    pub struct_size: u32,
    /// Gives memory. Required.
    pub alloc: CrumpleAlloc,
    /// Takes memory back. Required.
    pub free: CrumpleFree,
    /// Handed to both, untouched. May be null.
    pub user: *mut c_void,
}

// SAFETY: `repr(C)`, starts with its size, and any bytes are a value of it.
unsafe impl Def for CrumpleAllocatorDef {
    const DEFAULT: &'static str = "crumple_default_allocator_def";
}

/// An allocator def without functions: set both. Never fails; any thread.
#[unsafe(no_mangle)]
pub extern "C" fn crumple_default_allocator_def() -> CrumpleAllocatorDef {
    CrumpleAllocatorDef {
        struct_size: size_of::<CrumpleAllocatorDef>() as u32,
        alloc: None,
        free: None,
        user: std::ptr::null_mut(),
    }
}

/// Makes the library take all further memory from the host's functions, for the whole process; null goes back to the system's.
/// May be called at any time: each piece of memory returns to the functions it came from, so those must stay callable until
/// the last piece is back (destroying all contexts returns nearly all; threads of your own that used the library return a
/// little when they end). At most 15 different allocators in the life of a process.
///
/// Any thread. Errors: CRUMPLE_ERROR_UNSUPPORTED (a build without CRUMPLE_FEATURE_HOST_ALLOCATOR; see crumple_features()),
/// CRUMPLE_ERROR_STRUCT_SIZE, CRUMPLE_ERROR_MISALIGNED, CRUMPLE_ERROR_NULL_POINTER (a function is missing),
/// CRUMPLE_ERROR_INVALID_ARGUMENT (a sixteenth allocator).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_set_allocator(allocator: *const CrumpleAllocatorDef) -> CrumpleResult {
    boundary("crumple_set_allocator", || {
        // SAFETY: null is taken out first; for the rest the caller vouches.
        let allocator = if allocator.is_null() { None } else { Some(unsafe { def(allocator, "allocator") }?) };
        #[cfg(feature = "host-allocator")]
        return global::set(allocator);
        #[cfg(not(feature = "host-allocator"))]
        {
            let _ = allocator;
            Err(Failure::new(
                CrumpleResult::CrumpleErrorUnsupported,
                "this build has no host allocator: build the library with the feature host-allocator",
            ))
        }
    })
}

#[cfg(feature = "host-allocator")]
mod global {
    //! Rust's global allocator. Memory may outlive the choice of an allocator, so each piece carries, just before its first
    //! byte, the number of the allocator it came from.

    use super::super::result::{CrumpleResult, Failure};
    use super::CrumpleAllocatorDef;
    use std::alloc::{GlobalAlloc, Layout, System};
    use std::ffi::c_void;
    use std::sync::atomic::{AtomicPtr, AtomicUsize, Ordering::*};

    /// The system's allocator is number 0.
    const HOSTS: usize = 15;
    /// Bytes of the header; also the least alignment asked of a host.
    const HEADER: usize = 16;

    struct Host {
        alloc: AtomicPtr<c_void>,
        free: AtomicPtr<c_void>,
        user: AtomicPtr<c_void>,
    }

    type Alloc = unsafe extern "C" fn(usize, usize, *mut c_void) -> *mut c_void;
    type Free = unsafe extern "C" fn(*mut c_void, usize, usize, *mut c_void);

    static TABLE: [Host; HOSTS] = [const {
        Host {
            alloc: AtomicPtr::new(std::ptr::null_mut()),
            free: AtomicPtr::new(std::ptr::null_mut()),
            user: AtomicPtr::new(std::ptr::null_mut()),
        }
    }; HOSTS];
    /// The allocator of new memory: 0 the system's, otherwise a place in `TABLE` plus one.
    static CURRENT: AtomicUsize = AtomicUsize::new(0);
    /// How many places of `TABLE` are taken; a lock while `usize::MAX`.
    static TAKEN: AtomicUsize = AtomicUsize::new(0);

    pub(super) fn set(allocator: Option<CrumpleAllocatorDef>) -> Result<(), Failure> {
        let Some(def) = allocator else {
            CURRENT.store(0, Release);
            return Ok(());
        };
        let missing =
            |what: &str| Failure::new(CrumpleResult::CrumpleErrorNullPointer, format!("allocator.{what} is null"));
        let alloc = def.alloc.ok_or_else(|| missing("alloc"))? as *mut c_void;
        let free = def.free.ok_or_else(|| missing("free"))? as *mut c_void;
        let taken = loop {
            let taken = TAKEN.swap(usize::MAX, Acquire);
            if taken != usize::MAX {
                break taken;
            }
            std::hint::spin_loop();
        };
        let same = |host: &Host| {
            (host.alloc.load(Relaxed), host.free.load(Relaxed), host.user.load(Relaxed)) == (alloc, free, def.user)
        };
        let place = TABLE[..taken].iter().position(same).unwrap_or(taken);
        if let Some(host) = TABLE.get(place) {
            host.alloc.store(alloc, Relaxed);
            host.free.store(free, Relaxed);
            host.user.store(def.user, Relaxed);
            CURRENT.store(place + 1, Release);
        }
        TAKEN.store(taken.max((place + 1).min(HOSTS)), Release);
        if place == HOSTS {
            return Err(Failure::invalid(format!(
                "{HOSTS} different allocators were set already; set one of them again"
            )));
        }
        Ok(())
    }

    fn functions(number: usize) -> (Alloc, Free, *mut c_void) {
        let host = &TABLE[number - 1];
        let (alloc, free) = (host.alloc.load(Relaxed), host.free.load(Relaxed));
        // SAFETY: the place was filled with functions of these types before its number was published.
        unsafe {
            (
                std::mem::transmute::<*mut c_void, Alloc>(alloc),
                std::mem::transmute::<*mut c_void, Free>(free),
                host.user.load(Relaxed),
            )
        }
    }

    /// Bytes before the memory (a multiple of its alignment), and the layout of both together.
    fn whole(layout: Layout) -> Option<(usize, Layout)> {
        let align = layout.align().max(HEADER);
        let size = layout.size().checked_add(align)?;
        Some((align, Layout::from_size_align(size, align).ok()?))
    }

    pub(super) struct HostAllocator;

    #[global_allocator]
    static GLOBAL: HostAllocator = HostAllocator;

    impl HostAllocator {
        unsafe fn take(layout: Layout, zeroed: bool) -> *mut u8 {
            let Some((before, whole)) = whole(layout) else { return std::ptr::null_mut() };
            let number = CURRENT.load(Acquire);
            let base = match (number, zeroed) {
                // SAFETY: the size is not 0, a header is in it.
                (0, false) => unsafe { System.alloc(whole) },
                // SAFETY: as above.
                (0, true) => unsafe { System.alloc_zeroed(whole) },
                _ => {
                    let (alloc, free, user) = functions(number);
                    // SAFETY: the host promised that its functions may be called so.
                    let base = unsafe { alloc(whole.size(), whole.align(), user) }.cast::<u8>();
                    if !base.addr().is_multiple_of(whole.align()) {
                        // SAFETY: it came from the line above.
                        unsafe { free(base.cast(), whole.size(), whole.align(), user) };
                        return std::ptr::null_mut();
                    }
                    if zeroed && !base.is_null() {
                        // SAFETY: `whole.size()` bytes are there.
                        unsafe { base.write_bytes(0, whole.size()) };
                    }
                    base
                }
            };
            if base.is_null() {
                return base;
            }
            // SAFETY: `before` is at least the header's size and a multiple of the alignment, so both places are inside.
            unsafe {
                let memory = base.add(before);
                memory.sub(HEADER).cast::<usize>().write(number);
                memory
            }
        }
    }

    // SAFETY: memory comes from `System` or from a host that promises the same, large enough for the header and the layout, and
    // goes back where it came from with the layout it was taken with.
    unsafe impl GlobalAlloc for HostAllocator {
        unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
            // SAFETY: the caller's.
            unsafe { Self::take(layout, false) }
        }

        unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
            // SAFETY: the caller's.
            unsafe { Self::take(layout, true) }
        }

        unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
            let (before, whole) = whole(layout).expect("it was allocated with this layout");
            // SAFETY: `take` wrote the header there, and gave `base` with this layout.
            unsafe {
                let number = memory.sub(HEADER).cast::<usize>().read();
                let base = memory.sub(before);
                match number {
                    0 => System.dealloc(base, whole),
                    _ => {
                        let (_, free, user) = functions(number);
                        free(base.cast(), whole.size(), whole.align(), user);
                    }
                }
            }
        }

        unsafe fn realloc(&self, memory: *mut u8, layout: Layout, new_size: usize) -> *mut u8 {
            let Ok(new_layout) = Layout::from_size_align(new_size, layout.align()) else { return std::ptr::null_mut() };
            let (Some((before, old)), Some((_, new))) = (whole(layout), whole(new_layout)) else {
                return std::ptr::null_mut();
            };
            // SAFETY: `take` wrote the header there; the system's memory goes to the system with its layout, anything else is
            // copied to new memory that is large enough.
            unsafe {
                if memory.sub(HEADER).cast::<usize>().read() == 0 && CURRENT.load(Acquire) == 0 {
                    let base = System.realloc(memory.sub(before), old, new.size());
                    return if base.is_null() { base } else { base.add(before) };
                }
                let fresh = Self::take(new_layout, false);
                if !fresh.is_null() {
                    std::ptr::copy_nonoverlapping(memory, fresh, layout.size().min(new_size));
                    self.dealloc(memory, layout);
                }
                fresh
            }
        }
    }
}
