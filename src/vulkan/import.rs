//! Imports memory and semaphores of the host's device into Crumple's own device.

use super::functions::checked;
use super::host_buffers::{Access, BufferDef, BufferId};
use super::own::OwnDevice;
use super::shared::{ImportDef, ImportedBuffer, OwnedHandle, SemaphoreId, Shared};
use crate::base::error::Error;
use ash::vk;
use std::ptr::null;

#[cfg(not(windows))]
const MEMORY: vk::ExternalMemoryHandleTypeFlags = vk::ExternalMemoryHandleTypeFlags::OPAQUE_FD;
#[cfg(windows)]
const MEMORY: vk::ExternalMemoryHandleTypeFlags = vk::ExternalMemoryHandleTypeFlags::OPAQUE_WIN32;

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
        let mut imported = ImportedBuffer { buffer: vk::Buffer::null(), memory: vk::DeviceMemory::null() };
        // SAFETY: the caller's.
        let made = unsafe { self.import(def, &mut imported) }.and_then(|()| {
            let anything = Access {
                stages: vk::PipelineStageFlags::ALL_COMMANDS,
                access: vk::AccessFlags::MEMORY_READ | vk::AccessFlags::MEMORY_WRITE,
            };
            let (size, usage, queue_family) = (def.size, def.usage, vk::QUEUE_FAMILY_EXTERNAL);
            let buffer =
                BufferDef { buffer: imported.buffer, size, usage, queue_family, before: anything, after: anything };
            // SAFETY: a buffer made just now, destroyed after the device or after it was removed.
            unsafe { self.device().add_buffer(&buffer) }
        });
        match made {
            Ok(id) => {
                self.buffers.push((id, imported));
                Ok(id)
            }
            Err(error) => {
                // SAFETY: nothing uses it.
                unsafe { imported.destroy(&self.own) };
                Err(error)
            }
        }
    }

    /// Removes a buffer, and waits until the device is done with it.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a stale id; [`Error::Vulkan`], [`Error::DeviceLost`].
    pub fn remove_buffer(&mut self, id: BufferId) -> Result<(), Error> {
        self.device().remove_buffer(id)?;
        self.wait(self.last_submitted(), u64::MAX)?;
        for (_, imported) in self.buffers.extract_if(.., |(i, _)| *i == id) {
            // SAFETY: all that was submitted is done.
            unsafe { imported.destroy(&self.own) };
        }
        Ok(())
    }

    fn importable(&self, usage: vk::BufferUsageFlags) -> Result<(), Error> {
        let info = vk::PhysicalDeviceExternalBufferInfo::default().usage(usage).handle_type(MEMORY);
        let mut properties = vk::ExternalBufferProperties::default();
        // SAFETY: a physical device of Vulkan 1.1.
        unsafe {
            (self.own.instance_functions.1.get_physical_device_external_buffer_properties)(
                self.own.physical_device,
                &info,
                &mut properties,
            );
        }
        let features = properties.external_memory_properties.external_memory_features;
        if features.contains(vk::ExternalMemoryFeatureFlags::IMPORTABLE) {
            return Ok(());
        }
        Err(Error::Unsupported { what: format!("a Vulkan device that cannot import buffers of usage {usage:?}") })
    }

    /// # Safety
    /// As [`OwnDevice::import_buffer`].
    unsafe fn import(&self, def: &ImportDef, to: &mut ImportedBuffer) -> Result<(), Error> {
        let (own, f) = (&self.own, &self.own.functions);
        let mut external = vk::ExternalMemoryBufferCreateInfo::default().handle_types(MEMORY);
        let info = vk::BufferCreateInfo::default().size(def.size).usage(def.usage).push_next(&mut external);
        if def.size == 0 {
            return Err(Error::invalid("the buffer's size", 0, "at least 4 bytes"));
        }
        // SAFETY: valid arguments, here and below.
        checked("vkCreateBuffer", unsafe { (f.create_buffer)(own.device, &info, null(), &mut to.buffer) })?;
        let mut needs = vk::MemoryRequirements::default();
        // SAFETY: the buffer was made just now.
        unsafe { (f.get_buffer_memory_requirements)(own.device, to.buffer, &mut needs) };
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
        if !def.offset.is_multiple_of(needs.alignment) {
            let name = "the buffer's offset in its memory".to_owned();
            return Err(Error::Misaligned { name, value: def.offset, align: needs.alignment });
        }
        let mut dedicated = vk::MemoryDedicatedAllocateInfo::default().buffer(to.buffer);
        let mut info =
            vk::MemoryAllocateInfo::default().allocation_size(def.memory_size).memory_type_index(def.memory_type);
        if def.dedicated {
            info = info.push_next(&mut dedicated);
        }
        let handle = OwnedHandle::duplicate(def.memory, Some(def.memory_size))?;
        #[cfg(not(windows))]
        let mut import = vk::ImportMemoryFdInfoKHR::default().handle_type(MEMORY).fd(handle.raw());
        #[cfg(windows)]
        let mut import = vk::ImportMemoryWin32HandleInfoKHR::default().handle_type(MEMORY).handle(handle.raw());
        info = info.push_next(&mut import);
        // SAFETY: the caller's handle.
        match unsafe { (f.allocate_memory)(own.device, &info, null(), &mut to.memory) } {
            vk::Result::ERROR_INVALID_EXTERNAL_HANDLE => {
                let expected = "memory that a device of the same driver exported, as it was allocated";
                return Err(Error::invalid("the memory's handle", format!("{:?}", def.memory), expected));
            }
            vk::Result::ERROR_OUT_OF_DEVICE_MEMORY | vk::Result::ERROR_OUT_OF_HOST_MEMORY => {
                let what = "an imported buffer (vkAllocateMemory)".into();
                return Err(Error::OutOfMemory { what, bytes: def.memory_size });
            }
            other => checked("vkAllocateMemory", other)?,
        }
        // Vulkan owns it now.
        handle.forget();
        // SAFETY: memory of a type that suits the buffer, bound once.
        let bound = unsafe { (f.bind_buffer_memory)(own.device, to.buffer, to.memory, def.offset) };
        checked("vkBindBufferMemory", bound)
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
        let own = &self.own;
        let Some(import) = own.import_semaphore else {
            let what = "a Vulkan device without external semaphores: wait for a fence instead";
            return Err(Error::Unsupported { what: what.into() });
        };
        let handle = OwnedHandle::duplicate(shared, None)?;
        let mut semaphore = vk::Semaphore::null();
        let info = vk::SemaphoreCreateInfo::default();
        // SAFETY: valid arguments.
        let made = unsafe { (own.functions.create_semaphore)(own.device, &info, null(), &mut semaphore) };
        checked("vkCreateSemaphore", made)?;
        #[cfg(not(windows))]
        // SAFETY: by its name the function is of this type, and the handle is the caller's.
        let imported = unsafe {
            let info = vk::ImportSemaphoreFdInfoKHR::default()
                .semaphore(semaphore)
                .handle_type(vk::ExternalSemaphoreHandleTypeFlags::OPAQUE_FD)
                .fd(handle.raw());
            let import = std::mem::transmute::<unsafe extern "system" fn(), vk::PFN_vkImportSemaphoreFdKHR>(import);
            import(own.device, &info)
        };
        #[cfg(windows)]
        // SAFETY: as above.
        let imported = unsafe {
            let info = vk::ImportSemaphoreWin32HandleInfoKHR::default()
                .semaphore(semaphore)
                .handle_type(vk::ExternalSemaphoreHandleTypeFlags::OPAQUE_WIN32)
                .handle(handle.raw());
            let import =
                std::mem::transmute::<unsafe extern "system" fn(), vk::PFN_vkImportSemaphoreWin32HandleKHR>(import);
            import(own.device, &info)
        };
        if imported != vk::Result::SUCCESS {
            // SAFETY: nothing uses it.
            unsafe { (own.functions.destroy_semaphore)(own.device, semaphore, null()) };
        }
        if imported == vk::Result::ERROR_INVALID_EXTERNAL_HANDLE {
            let expected = "a semaphore that a device of the same driver exported";
            return Err(Error::invalid("the semaphore's handle", format!("{shared:?}"), expected));
        }
        checked("vkImportSemaphore", imported)?;
        handle.forget();
        self.semaphores.push(semaphore);
        Ok(SemaphoreId(self.device().id << 32 | self.semaphores.len() as u64))
    }
}
