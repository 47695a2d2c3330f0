//! What the host's device shares: handles of exported memory and semaphores, and what is made of them.

use super::own_handles::OwnHandles;
use crate::base::error::Error;
use ash::vk;
use std::sync::Arc;

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

/// The id of an imported semaphore.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SemaphoreId(
    /// The index plus one; in the upper half the device's id.
    pub(crate) u64,
);

/// A buffer in imported memory. It is dropped once nothing uses it.
pub(super) struct ImportedBuffer {
    pub own: Arc<OwnHandles>,
    pub buffer: vk::Buffer,
    pub memory: vk::DeviceMemory,
}

impl Drop for ImportedBuffer {
    fn drop(&mut self) {
        // SAFETY: nothing uses it any more; null handles are ignored.
        unsafe {
            self.own.device.destroy_buffer(self.buffer, None);
            self.own.device.free_memory(self.memory, None);
        }
    }
}

/// A duplicate of the host's handle. Dropping it closes it.
#[cfg(unix)]
pub(super) type OwnedHandle = std::os::fd::OwnedFd;

/// The host's handle. Vulkan does not take ownership of it.
#[cfg(not(unix))]
pub(super) type OwnedHandle = isize;

/// Duplicates the host's handle. `memory` is the size in bytes if it is memory's.
#[cfg(unix)]
pub(super) fn duplicate(shared: Shared, memory: Option<u64>) -> Result<OwnedHandle, Error> {
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
    Ok(file.into())
}

#[cfg(not(unix))]
pub(super) fn duplicate(shared: Shared, _: Option<u64>) -> Result<OwnedHandle, Error> {
    match shared {
        Shared::OpaqueWin32(handle) if handle != 0 && handle != -1 => Ok(handle),
        Shared::OpaqueWin32(handle) => Err(Error::invalid("the handle", handle, "a valid handle")),
        _ => Err(Error::Unsupported { what: format!("{shared:?}: this system has Windows handles") }),
    }
}
