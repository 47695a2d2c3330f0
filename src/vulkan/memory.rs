//! Crumple's own buffers. Each has its memory.

use super::functions::{failed, not_made};
use super::vulkan_device::VulkanDevice;
use crate::base::error::Error;
use ash::vk;
use std::sync::Arc;

/// The use of a buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum BufferUse {
    /// Written by copies and read by kernels.
    Storage,
    /// Written by the CPU and copied from.
    Staging,
}

/// A buffer with memory of its own. It is dropped once no frame uses it.
pub(super) struct OwnBuffer {
    gpu: Arc<VulkanDevice>,
    pub handle: vk::Buffer,
    memory: vk::DeviceMemory,
    pub size: u64,
    /// The memory of a staging buffer; null for others.
    mapped: *mut u32,
    coherent: bool,
}

// SAFETY: the memory is mapped for the whole process, and only reached through `&mut self`.
unsafe impl Send for OwnBuffer {}
// SAFETY: the same.
unsafe impl Sync for OwnBuffer {}

impl OwnBuffer {
    /// A buffer of `size` bytes, a multiple of 4.
    pub(super) fn new(gpu: &Arc<VulkanDevice>, size: u64, for_: BufferUse) -> Result<Self, Error> {
        let usage = match for_ {
            BufferUse::Storage => vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::TRANSFER_DST,
            BufferUse::Staging => vk::BufferUsageFlags::TRANSFER_SRC,
        };
        let info = vk::BufferCreateInfo::default().size(size).usage(usage).sharing_mode(vk::SharingMode::EXCLUSIVE);
        gpu.count();
        // SAFETY: the device is valid, as `Device::new` demands. So everywhere in this file.
        let handle = unsafe { gpu.device.create_buffer(&info, None) };
        let handle = handle.map_err(not_made("a buffer", "vkCreateBuffer", size))?;
        let (memory, mapped) = (vk::DeviceMemory::null(), std::ptr::null_mut());
        let mut buffer = OwnBuffer { gpu: gpu.clone(), handle, memory, size, mapped, coherent: true };
        buffer.fill(for_)?;
        Ok(buffer)
    }

    /// Allocates a new buffer's memory.
    fn fill(&mut self, for_: BufferUse) -> Result<(), Error> {
        let (gpu, device) = (&self.gpu, &self.gpu.device);
        // SAFETY: the buffer was made just now.
        let needs = unsafe { device.get_buffer_memory_requirements(self.handle) };
        let flags = |type_: u32| gpu.memory.memory_types[type_ as usize].property_flags;
        let has = |wanted: vk::MemoryPropertyFlags| {
            (0..gpu.memory.memory_type_count)
                .find(|t| needs.memory_type_bits >> t & 1 == 1 && flags(*t).contains(wanted))
        };
        use vk::MemoryPropertyFlags as P;
        let type_ = match for_ {
            BufferUse::Storage => has(P::DEVICE_LOCAL),
            BufferUse::Staging => has(P::HOST_VISIBLE | P::HOST_COHERENT).or_else(|| has(P::HOST_VISIBLE)),
        };
        let type_ = type_.ok_or_else(|| Error::Unsupported {
            what: format!("a Vulkan device without memory for {for_:?} buffers (types {:#x})", needs.memory_type_bits),
        })?;
        let info = vk::MemoryAllocateInfo::default().allocation_size(needs.size).memory_type_index(type_);
        let not_made = |call| not_made("a buffer", call, needs.size);
        gpu.count();
        // SAFETY: memory of a type that suits the buffer, bound once.
        unsafe {
            self.memory = device.allocate_memory(&info, None).map_err(not_made("vkAllocateMemory"))?;
            device.bind_buffer_memory(self.handle, self.memory, 0).map_err(not_made("vkBindBufferMemory"))?;
        }
        if for_ == BufferUse::Staging {
            let (all, none) = (vk::WHOLE_SIZE, vk::MemoryMapFlags::empty());
            // SAFETY: the memory is visible to the host and not mapped yet.
            let mapped = unsafe { device.map_memory(self.memory, 0, all, none) };
            self.mapped = mapped.map_err(not_made("vkMapMemory"))?.cast();
            self.coherent = flags(type_).contains(P::HOST_COHERENT);
        }
        Ok(())
    }

    /// Lets `write` fill the first `words` words of a staging buffer, and makes them visible to the next submission.
    pub(super) fn write(&mut self, words: usize, write: impl FnOnce(&mut [u32])) -> Result<(), Error> {
        assert!(!self.mapped.is_null() && 4 * words as u64 <= self.size);
        // SAFETY: as many words are mapped, at an address that Vulkan aligns to at least 64 bytes. The device does not use them:
        // a buffer is written before its first use or after the frame that used it.
        write(unsafe { std::slice::from_raw_parts_mut(self.mapped, words) });
        if self.coherent {
            return Ok(());
        }
        let range = vk::MappedMemoryRange::default().memory(self.memory).size(vk::WHOLE_SIZE);
        // SAFETY: the memory is mapped.
        let flushed = unsafe { self.gpu.device.flush_mapped_memory_ranges(&[range]) };
        flushed.map_err(failed("vkFlushMappedMemoryRanges"))
    }
}

impl Drop for OwnBuffer {
    fn drop(&mut self) {
        self.gpu.destroy(|device| {
            // SAFETY: no frame uses it any more; null handles are ignored.
            unsafe {
                device.destroy_buffer(self.handle, None);
                device.free_memory(self.memory, None);
            }
        });
    }
}
