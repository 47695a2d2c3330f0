//! The library's memory from the host's allocator (feature `host-allocator`).

use super::boundary::boundary;
use super::prelude::*;

/// Returns size bytes aligned to align (a power of two, at least 16), or null. Must be thread-safe. Must not call
/// Crumple, throw or longjmp out.
pub type CrumpleAlloc = Option<unsafe extern "C" fn(size: usize, align: usize, user: *mut c_void) -> *mut c_void>;

/// Frees memory from CrumpleAlloc; size and align are the values it was allocated with. Must be thread-safe. Must not
/// call Crumple, throw or longjmp out.
pub type CrumpleFree = Option<unsafe extern "C" fn(pointer: *mut c_void, size: usize, align: usize, user: *mut c_void)>;

/// The host's allocator. Both functions are required.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleAllocatorDef {
    pub struct_size: u32,
    pub alloc: CrumpleAlloc,
    pub free: CrumpleFree,
    /// Passed to both. May be null.
    pub user: *mut c_void,
}

defs!(CrumpleAllocatorDef);

#[unsafe(no_mangle)]
pub extern "C" fn crumple_allocator_def_default() -> CrumpleAllocatorDef {
    zeroed()
}

/// Makes the library allocate from your functions, in the whole process, at any time. Null restores the system's
/// allocator. Each block is freed by the functions that allocated it, so they must stay callable. Destroying all
/// contexts frees all blocks, except for a few kB per thread of Crumple's own, kept until process exit. If alloc returns
/// null, the call returns CRUMPLE_ERROR_OUT_OF_MEMORY and changes nothing, or completes with a block of the system's
/// allocator. Errors:
/// CRUMPLE_ERROR_INVALID_ARGUMENT (more than 15 different allocators in a process), CRUMPLE_ERROR_UNSUPPORTED (a build
/// without CRUMPLE_FEATURE_HOST_ALLOCATOR).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_allocator_set(allocator: *const CrumpleAllocatorDef) -> CrumpleResult {
    boundary("crumple_allocator_set", || {
        let allocator = if allocator.is_null() { None } else { Some(def(allocator, "allocator")?) };
        #[cfg(feature = "host-allocator")]
        return global::set(allocator);
        #[cfg(not(feature = "host-allocator"))]
        {
            let _ = allocator;
            let message = "this build has no host allocator: build the library with the feature host-allocator";
            Err(Failure::new(CrumpleResult::CrumpleErrorUnsupported, message))
        }
    })
}

#[cfg(feature = "host-allocator")]
mod global {
    //! Rust's global allocator. Memory may outlive the choice of an allocator, so each piece carries, just after its
    //! last byte, the number of the allocator it came from. (After, not before: pointers then point to the begin of
    //! what was allocated, which tools that look for leaks go by.)

    use super::super::result::Failure;
    use super::CrumpleAllocatorDef;
    use crate::base::memory::{is_fallible, refuse};
    use std::alloc::{GlobalAlloc, Layout, System};
    use std::ffi::c_void;
    use std::sync::OnceLock;
    use std::sync::atomic::{AtomicUsize, Ordering::*};

    /// Different hosts there may be; the system's allocator is number 0.
    const HOSTS: usize = 15;
    /// The least alignment asked of a host.
    const ALIGN: usize = 16;

    #[derive(Clone, Copy)]
    struct Host {
        alloc: unsafe extern "C" fn(usize, usize, *mut c_void) -> *mut c_void,
        free: unsafe extern "C" fn(*mut c_void, usize, usize, *mut c_void),
        user: *mut c_void,
    }

    // SAFETY: `user` is only handed back to the host, who promised that its functions may be called from any thread.
    unsafe impl Send for Host {}
    // SAFETY: as above.
    unsafe impl Sync for Host {}

    impl Host {
        fn is(&self, other: &Host) -> bool {
            let place = |host: &Host| (host.alloc as usize, host.free as usize, host.user);
            place(self) == place(other)
        }
    }

    /// Filled from the front, and never emptied.
    static TABLE: [OnceLock<Host>; HOSTS] = [const { OnceLock::new() }; HOSTS];
    /// The allocator of new memory: 0 the system's, otherwise a place in `TABLE` plus one.
    static CURRENT: AtomicUsize = AtomicUsize::new(0);

    pub(super) fn set(allocator: Option<CrumpleAllocatorDef>) -> Result<(), Failure> {
        let Some(def) = allocator else {
            CURRENT.store(0, Release);
            return Ok(());
        };
        let alloc = def.alloc.ok_or_else(|| Failure::null("allocator.alloc"))?;
        let free = def.free.ok_or_else(|| Failure::null("allocator.free"))?;
        let host = Host { alloc, free, user: def.user };
        // The first place that holds it already, or that it fills.
        let place = TABLE.iter().position(|known| known.get_or_init(|| host).is(&host)).ok_or_else(|| {
            Failure::invalid(format!("{HOSTS} different allocators were set already; set one of them again"))
        })?;
        CURRENT.store(place + 1, Release);
        Ok(())
    }

    fn host(number: usize) -> &'static Host {
        TABLE[number - 1].get().expect("its place was filled before its number was published")
    }

    /// The memory with the number after it, and where that lies.
    fn whole(layout: Layout) -> Option<(Layout, usize)> {
        let (whole, after) = layout.extend(Layout::new::<usize>()).ok()?;
        Some((whole.align_to(ALIGN).ok()?.pad_to_align(), after))
    }

    struct HostAllocator;

    #[global_allocator]
    static GLOBAL: HostAllocator = HostAllocator;

    impl HostAllocator {
        unsafe fn from_host(host: &Host, whole: Layout, zeroed: bool) -> *mut u8 {
            // SAFETY: the host promised that its functions may be called so; the memory has `whole.size()` bytes, and goes back as
            // it came.
            unsafe {
                let memory = (host.alloc)(whole.size(), whole.align(), host.user).cast::<u8>();
                if !memory.addr().is_multiple_of(whole.align()) {
                    (host.free)(memory.cast(), whole.size(), whole.align(), host.user);
                    return std::ptr::null_mut();
                }
                if zeroed && !memory.is_null() {
                    memory.write_bytes(0, whole.size());
                }
                memory
            }
        }

        unsafe fn take(layout: Layout, zeroed: bool) -> *mut u8 {
            let Some((whole, after)) = whole(layout) else { return std::ptr::null_mut() };
            let mut number = CURRENT.load(Acquire);
            let mut memory = std::ptr::null_mut();
            if number != 0 {
                memory = Self::from_host(host(number), whole, zeroed);
                if memory.is_null() {
                    if is_fallible() {
                        return memory;
                    }
                    refuse();
                    number = 0;
                }
            }
            if number == 0 {
                // SAFETY: the size is not 0, a number is in it.
                memory = unsafe { if zeroed { System.alloc_zeroed(whole) } else { System.alloc(whole) } };
            }
            if !memory.is_null() {
                // SAFETY: `whole` has room for the number there, aligned.
                unsafe { memory.add(after).cast::<usize>().write(number) };
            }
            memory
        }
    }

    // SAFETY: memory comes from `System` or from a host that promises the same, large enough for the layout and the
    // number, and goes back where it came from with the layout it was taken with.
    unsafe impl GlobalAlloc for HostAllocator {
        unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
            Self::take(layout, false)
        }

        unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
            Self::take(layout, true)
        }

        unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
            let Some((whole, after)) = whole(layout) else { return }; // then it never was allocated
            // SAFETY: `take` wrote the number there, and gave `memory` with this layout.
            unsafe {
                match memory.add(after).cast::<usize>().read() {
                    0 => System.dealloc(memory, whole),
                    number => {
                        let host = host(number);
                        (host.free)(memory.cast(), whole.size(), whole.align(), host.user);
                    }
                }
            }
        }

        unsafe fn realloc(&self, memory: *mut u8, layout: Layout, new_size: usize) -> *mut u8 {
            let Ok(new_layout) = Layout::from_size_align(new_size, layout.align()) else { return std::ptr::null_mut() };
            let (Some((old, after)), Some((new, new_after))) = (whole(layout), whole(new_layout)) else {
                return std::ptr::null_mut();
            };
            // SAFETY: `take` wrote the number there; the system's memory goes to the system with its layout, anything
            // else is copied to new memory that is large enough.
            unsafe {
                if memory.add(after).cast::<usize>().read() == 0 && CURRENT.load(Acquire) == 0 {
                    let memory = System.realloc(memory, old, new.size());
                    if !memory.is_null() {
                        memory.add(new_after).cast::<usize>().write(0);
                    }
                    return memory;
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
