//! Imports memory and semaphores of the host's device into Crumple's own device.

use super::functions::{failed, not_made};
use super::host_buffers::{Access, BufferDef, BufferId};
use super::own::OwnDevice;
use super::shared::{ImportedBuffer, SemaphoreId, Shared, duplicate};
use crate::base::error::Error;
use crate::base::strided::Strided;
use ash::vk;
use std::mem::ManuallyDrop;
#[cfg(unix)]
use std::os::fd::AsRawFd;

#[cfg(not(windows))]
const MEMORY: vk::ExternalMemoryHandleTypeFlags = vk::ExternalMemoryHandleTypeFlags::OPAQUE_FD;
#[cfg(windows)]
const MEMORY: vk::ExternalMemoryHandleTypeFlags = vk::ExternalMemoryHandleTypeFlags::OPAQUE_WIN32;
#[cfg(not(windows))]
const SEMAPHORE: vk::ExternalSemaphoreHandleTypeFlags = vk::ExternalSemaphoreHandleTypeFlags::OPAQUE_FD;
#[cfg(windows)]
const SEMAPHORE: vk::ExternalSemaphoreHandleTypeFlags = vk::ExternalSemaphoreHandleTypeFlags::OPAQUE_WIN32;

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

impl OwnDevice {
    /// Makes a buffer in memory that the host's device exported, on the same physical device and driver. The host makes its own
    /// buffer with `VkExternalMemoryBufferCreateInfo`. It releases it to `VK_QUEUE_FAMILY_EXTERNAL` before each submission that
    /// writes it, and acquires it afterwards.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a bad handle (closed, a pipe, a file smaller than the memory) or a memory type that the buffer
    /// cannot have; [`Error::BufferTooSmall`] for a buffer that does not fit into the memory; the errors of
    /// [`super::Device::add_buffer`]; [`Error::Unsupported`] if the device cannot import such a buffer, or the handle is another
    /// system's;
    /// [`Error::OutOfMemory`], [`Error::Vulkan`], [`Error::DeviceLost`].
    ///
    /// # Safety
    /// The handle's memory was allocated as the definition says, and lives until the buffer is removed or the device dropped. Only
    /// some of this can be checked.
    pub unsafe fn import_buffer(&mut self, def: &ImportDef) -> Result<BufferId, Error> {
        let end = def.offset.saturating_add(def.size);
        if end > def.memory_size {
            let name = "the imported memory".to_owned();
            return Err(Error::BufferTooSmall { name, size: def.memory_size, needed: end });
        }
        self.importable(def.usage)?;
        // SAFETY: the caller's.
        let imported = unsafe { self.import(def)? };
        let anything = Access {
            stages: vk::PipelineStageFlags::ALL_COMMANDS,
            access: vk::AccessFlags::MEMORY_READ | vk::AccessFlags::MEMORY_WRITE,
        };
        let (size, usage, queue_family) = (def.size, def.usage, vk::QUEUE_FAMILY_EXTERNAL);
        let buffer =
            BufferDef { buffer: imported.buffer, size, usage, queue_family, before: anything, after: anything };
        // SAFETY: a buffer made just now, destroyed after the device or after it was removed.
        let id = unsafe { self.device().add_buffer(&buffer)? };
        self.buffers.push((id, imported));
        Ok(id)
    }

    /// Removes a buffer, and waits until the device is done with it.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a stale id; [`Error::Vulkan`], [`Error::DeviceLost`].
    pub fn remove_buffer(&mut self, id: BufferId) -> Result<(), Error> {
        self.device().remove_buffer(id)?;
        self.wait(self.last_submitted(), u64::MAX)?;
        self.buffers.retain(|(i, _)| *i != id);
        Ok(())
    }

    fn importable(&self, usage: vk::BufferUsageFlags) -> Result<(), Error> {
        let info = vk::PhysicalDeviceExternalBufferInfo::default().usage(usage).handle_type(MEMORY);
        let mut properties = vk::ExternalBufferProperties::default();
        let own = &self.own.instance;
        // SAFETY: a physical device of Vulkan 1.1.
        unsafe {
            own.instance.get_physical_device_external_buffer_properties(own.physical_device, &info, &mut properties);
        }
        let features = properties.external_memory_properties.external_memory_features;
        if features.contains(vk::ExternalMemoryFeatureFlags::IMPORTABLE) {
            return Ok(());
        }
        Err(Error::Unsupported { what: format!("a Vulkan device that cannot import buffers of usage {usage:?}") })
    }

    /// # Safety
    /// As [`OwnDevice::import_buffer`].
    unsafe fn import(&self, def: &ImportDef) -> Result<ImportedBuffer, Error> {
        let device = &self.own.device;
        let mut external = vk::ExternalMemoryBufferCreateInfo::default().handle_types(MEMORY);
        let info = vk::BufferCreateInfo::default().size(def.size).usage(def.usage).push_next(&mut external);
        if def.size == 0 {
            return Err(Error::invalid("the buffer's size", 0, "at least 4 bytes"));
        }
        // SAFETY: valid arguments, here and below.
        let buffer = unsafe { device.create_buffer(&info, None) }.map_err(failed("vkCreateBuffer"))?;
        let mut imported = ImportedBuffer { own: self.own.clone(), buffer, memory: vk::DeviceMemory::null() };
        // SAFETY: the buffer was made just now.
        let needs = unsafe { device.get_buffer_memory_requirements(buffer) };
        if def.memory_type >= 32 || needs.memory_type_bits >> def.memory_type & 1 == 0 {
            let good: Vec<String> =
                (0..32).filter(|t| needs.memory_type_bits >> t & 1 == 1).map(|t| t.to_string()).collect();
            let expected = format!("one that the buffer can lie in: {}", good.join(", "));
            return Err(Error::invalid("the memory type", def.memory_type, &expected));
        }
        if def.offset.saturating_add(needs.size) > def.memory_size {
            let (name, needed) = ("the imported memory".to_owned(), def.offset.saturating_add(needs.size));
            return Err(Error::BufferTooSmall { name, size: def.memory_size, needed });
        }
        Strided::check_aligned("the buffer's offset in its memory", def.offset, needs.alignment)?;
        let mut dedicated = vk::MemoryDedicatedAllocateInfo::default().buffer(buffer);
        let mut info =
            vk::MemoryAllocateInfo::default().allocation_size(def.memory_size).memory_type_index(def.memory_type);
        if def.dedicated {
            info = info.push_next(&mut dedicated);
        }
        let handle = duplicate(def.memory, Some(def.memory_size))?;
        #[cfg(not(windows))]
        let mut import = vk::ImportMemoryFdInfoKHR::default().handle_type(MEMORY).fd(handle.as_raw_fd());
        #[cfg(windows)]
        let mut import = vk::ImportMemoryWin32HandleInfoKHR::default().handle_type(MEMORY).handle(handle);
        info = info.push_next(&mut import);
        // SAFETY: the caller's handle.
        let memory = unsafe { device.allocate_memory(&info, None) };
        imported.memory = memory.map_err(|result| match result {
            vk::Result::ERROR_INVALID_EXTERNAL_HANDLE => {
                let expected = "memory that a device of the same driver exported, as it was allocated";
                Error::invalid("the memory's handle", format!("{:?}", def.memory), expected)
            }
            other => not_made("an imported buffer", "vkAllocateMemory", def.memory_size)(other),
        })?;
        // Vulkan owns it now.
        let _ = ManuallyDrop::new(handle);
        // SAFETY: memory of a type that suits the buffer, bound once.
        let bound = unsafe { device.bind_buffer_memory(buffer, imported.memory, def.offset) };
        bound.map_err(failed("vkBindBufferMemory"))?;
        Ok(imported)
    }

    /// Imports a binary semaphore that the host's device exported. It lives until the device is dropped.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the driver cannot import semaphores (use [`OwnDevice::wait`] and a fence of the host instead), or the
    /// handle is another system's; [`Error::InvalidArgument`] for a bad handle; [`Error::Vulkan`], [`Error::DeviceLost`].
    ///
    /// # Safety
    /// The handle is a binary semaphore's, of the same driver.
    pub unsafe fn import_semaphore(&mut self, shared: Shared) -> Result<SemaphoreId, Error> {
        let device = &self.own.device;
        let Some(semaphores) = &self.own.semaphores else {
            let what = "a Vulkan device without external semaphores: wait for a fence instead";
            return Err(Error::Unsupported { what: what.into() });
        };
        let handle = duplicate(shared, None)?;
        // SAFETY: valid arguments.
        let semaphore = unsafe { device.create_semaphore(&vk::SemaphoreCreateInfo::default(), None) };
        let semaphore = semaphore.map_err(failed("vkCreateSemaphore"))?;
        #[cfg(not(windows))]
        let imported = {
            let info = vk::ImportSemaphoreFdInfoKHR::default().semaphore(semaphore).handle_type(SEMAPHORE);
            // SAFETY: the caller's handle.
            unsafe { semaphores.import_semaphore_fd(&info.fd(handle.as_raw_fd())) }
        };
        #[cfg(windows)]
        let imported = {
            let info = vk::ImportSemaphoreWin32HandleInfoKHR::default().semaphore(semaphore).handle_type(SEMAPHORE);
            // SAFETY: the caller's handle.
            unsafe { semaphores.import_semaphore_win32_handle(&info.handle(handle)) }
        };
        imported.map_err(|result| {
            // SAFETY: nothing uses it.
            unsafe { device.destroy_semaphore(semaphore, None) };
            match result {
                vk::Result::ERROR_INVALID_EXTERNAL_HANDLE => {
                    let expected = "a semaphore that a device of the same driver exported";
                    Error::invalid("the semaphore's handle", format!("{shared:?}"), expected)
                }
                other => failed("vkImportSemaphore")(other),
            }
        })?;
        let _ = ManuallyDrop::new(handle);
        self.semaphores.push(semaphore);
        Ok(SemaphoreId(self.id() << 32 | self.semaphores.len() as u64))
    }
}
