//! What the host's device shares: exported memory and semaphores.

use super::own_handles::OwnHandles;
use crate::base::error::Error;
use ash::vk;
use std::ptr::null;

/// An exported handle of the host.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Shared {
    /// A file descriptor, `VK_EXTERNAL_MEMORY_HANDLE_TYPE_OPAQUE_FD_BIT` (or the same of a semaphore). It is duplicated, so the host
    /// may close its own at any time.
    OpaqueFd(i32),
    /// A Windows handle, `…_OPAQUE_WIN32_BIT`. Windows only. This was never run.
    OpaqueWin32(isize),
}

/// A buffer of the host's device in exported memory.
#[derive(Debug, Clone, Copy)]
pub struct ImportDef {
    /// The memory.
    pub memory: Shared,
    /// `allocationSize` of the host's allocation, bytes.
    pub memory_size: u64,
    /// `memoryTypeIndex` of the host's allocation.
    pub memory_type: u32,
    /// Whether the host allocated it for this buffer alone (`VkMemoryDedicatedAllocateInfo`).
    pub dedicated: bool,
    /// Offset in the memory that the host bound the buffer to, bytes.
    pub offset: u64,
    /// The buffer's size in bytes.
    pub size: u64,
    /// The usage that the host made the buffer with. It must have the flag `STORAGE_BUFFER`.
    pub usage: vk::BufferUsageFlags,
}

/// The id of an imported semaphore.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SemaphoreId(
    /// The index plus one; in the upper half the device's id.
    pub(crate) u64,
);

/// A buffer in imported memory.
pub(super) struct ImportedBuffer {
    pub buffer: vk::Buffer,
    pub memory: vk::DeviceMemory,
}

impl ImportedBuffer {
    /// # Safety
    /// Nothing uses it any more.
    pub(super) unsafe fn destroy(&self, own: &OwnHandles) {
        // SAFETY: the caller's promise; null handles are ignored.
        unsafe {
            (own.functions.destroy_buffer)(own.device, self.buffer, null());
            (own.functions.free_memory)(own.device, self.memory, null());
        }
    }
}

/// A duplicate of the host's handle. Dropping it closes it.
#[cfg(unix)]
pub(super) struct OwnedHandle(std::os::fd::OwnedFd);

#[cfg(unix)]
impl OwnedHandle {
    pub(super) fn raw(&self) -> i32 {
        use std::os::fd::AsRawFd;
        self.0.as_raw_fd()
    }

    /// Gives up ownership.
    pub(super) fn forget(self) {
        use std::os::fd::IntoRawFd;
        let _ = self.0.into_raw_fd();
    }
}

#[cfg(unix)]
impl OwnedHandle {
    /// Duplicates the host's handle. `memory` is the size in bytes if it is memory's.
    pub(super) fn duplicate(shared: Shared, memory: Option<u64>) -> Result<Self, Error> {
        use std::os::fd::BorrowedFd;
        use std::os::unix::fs::FileTypeExt;
        let refused = |expected: &str| Err(Error::invalid("the handle", format!("{shared:?}"), expected));
        let Shared::OpaqueFd(fd) = shared else {
            return Err(Error::Unsupported { what: format!("{shared:?}: this system has file descriptors") });
        };
        if fd < 0 {
            return refused("an open file descriptor");
        }
        // SAFETY: it is not -1. If it is not open, the system reports that.
        let Ok(own) = unsafe { BorrowedFd::borrow_raw(fd) }.try_clone_to_owned() else {
            return refused("an open file descriptor");
        };
        let file = std::fs::File::from(own);
        if let Ok(metadata) = file.metadata() {
            let kind = metadata.file_type();
            if kind.is_fifo() || kind.is_socket() || kind.is_dir() {
                return refused("one from vkGetMemoryFdKHR or vkGetSemaphoreFdKHR; this is a pipe, socket or folder");
            }
            // Software drivers export memory as files.
            if let Some(size) = memory.filter(|size| kind.is_file() && metadata.len() < *size) {
                return refused(&format!("memory of {size} bytes; this is a file of {}", metadata.len()));
            }
        }
        Ok(OwnedHandle(file.into()))
    }
}

/// The host's handle. Vulkan does not take ownership of it.
#[cfg(not(unix))]
pub(super) struct OwnedHandle(isize);

#[cfg(not(unix))]
impl OwnedHandle {
    pub(super) fn raw(&self) -> isize {
        self.0
    }

    pub(super) fn forget(self) {}
}

#[cfg(not(unix))]
impl OwnedHandle {
    pub(super) fn duplicate(shared: Shared, _: Option<u64>) -> Result<Self, Error> {
        match shared {
            Shared::OpaqueWin32(handle) if handle != 0 && handle != -1 => Ok(OwnedHandle(handle)),
            Shared::OpaqueWin32(handle) => Err(Error::invalid("the handle", handle, "a valid handle")),
            _ => Err(Error::Unsupported { what: format!("{shared:?}: this system has Windows handles") }),
        }
    }
}
