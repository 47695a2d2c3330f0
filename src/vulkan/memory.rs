//! Crumple's own buffers. Each has its memory.

use super::functions::checked;
use super::vulkan_device::VulkanDevice;
use crate::base::error::Error;
use ash::vk;

/// The use of a buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum BufferUse {
    /// Written by copies and read by kernels.
    Storage,
    /// Written by the CPU and copied from.
    Staging,
}

/// A buffer with memory of its own.
#[derive(Debug)]
pub(super) struct OwnBuffer {
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

impl VulkanDevice {
    /// A buffer of `size` bytes, a multiple of 4.
    pub(super) fn buffer(&self, size: u64, for_: BufferUse) -> Result<OwnBuffer, Error> {
        let usage = match for_ {
            BufferUse::Storage => vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::TRANSFER_DST,
            BufferUse::Staging => vk::BufferUsageFlags::TRANSFER_SRC,
        };
        let f = &self.functions;
        let info = vk::BufferCreateInfo::default().size(size).usage(usage).sharing_mode(vk::SharingMode::EXCLUSIVE);
        let mut buffer = OwnBuffer {
            handle: vk::Buffer::null(),
            memory: vk::DeviceMemory::null(),
            size,
            mapped: std::ptr::null_mut(),
            coherent: true,
        };
        self.count();
        // SAFETY: the device is valid, as `Device::new` demands. So everywhere in this file.
        let result = unsafe { (f.create_buffer)(self.device, &info, std::ptr::null(), &mut buffer.handle) };
        out_of_memory("vkCreateBuffer", result, size)?;
        let filled = self.fill(&mut buffer, for_);
        if filled.is_err() {
            // SAFETY: nothing uses it yet.
            unsafe { self.destroy(&buffer) };
        }
        filled.map(|()| buffer)
    }

    /// Allocates a new buffer's memory.
    fn fill(&self, buffer: &mut OwnBuffer, for_: BufferUse) -> Result<(), Error> {
        let f = &self.functions;
        let mut needs = vk::MemoryRequirements::default();
        // SAFETY: the buffer was made just now.
        unsafe { (f.get_buffer_memory_requirements)(self.device, buffer.handle, &mut needs) };
        let flags = |type_: u32| self.memory.memory_types[type_ as usize].property_flags;
        let has = |wanted: vk::MemoryPropertyFlags| {
            (0..self.memory.memory_type_count)
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
        self.count();
        // SAFETY: as above.
        let result = unsafe { (f.allocate_memory)(self.device, &info, std::ptr::null(), &mut buffer.memory) };
        out_of_memory("vkAllocateMemory", result, needs.size)?;
        // SAFETY: memory of a type that suits the buffer, bound once.
        let result = unsafe { (f.bind_buffer_memory)(self.device, buffer.handle, buffer.memory, 0) };
        out_of_memory("vkBindBufferMemory", result, needs.size)?;
        if for_ == BufferUse::Staging {
            let mut data = std::ptr::null_mut();
            let (all, none) = (vk::WHOLE_SIZE, vk::MemoryMapFlags::empty());
            // SAFETY: the memory is visible to the host and not mapped yet.
            let result = unsafe { (f.map_memory)(self.device, buffer.memory, 0, all, none, &mut data) };
            out_of_memory("vkMapMemory", result, needs.size)?;
            buffer.mapped = data.cast();
            buffer.coherent = flags(type_).contains(P::HOST_COHERENT);
        }
        Ok(())
    }

    /// Lets `write` fill the first `words` words of a staging buffer, and makes them visible to the next submission.
    pub(super) fn write(&self, to: &mut OwnBuffer, words: usize, write: impl FnOnce(&mut [u32])) -> Result<(), Error> {
        assert!(!to.mapped.is_null() && 4 * words as u64 <= to.size);
        // SAFETY: as many words are mapped, at an address that Vulkan aligns to at least 64 bytes. The device does not use them:
        // a buffer is written before its first use or after the frame that used it.
        let words = unsafe { std::slice::from_raw_parts_mut(to.mapped, words) };
        write(words);
        if to.coherent {
            return Ok(());
        }
        let range = vk::MappedMemoryRange::default().memory(to.memory).size(vk::WHOLE_SIZE);
        // SAFETY: the memory is mapped.
        checked("vkFlushMappedMemoryRanges", unsafe {
            (self.functions.flush_mapped_memory_ranges)(self.device, 1, &range)
        })
    }

    /// # Safety
    /// Nothing uses the buffer any more.
    pub(super) unsafe fn destroy(&self, buffer: &OwnBuffer) {
        // SAFETY: the caller's promise; null handles are ignored.
        unsafe {
            (self.functions.destroy_buffer)(self.device, buffer.handle, std::ptr::null());
            (self.functions.free_memory)(self.device, buffer.memory, std::ptr::null());
        }
    }
}

fn out_of_memory(call: &str, result: vk::Result, bytes: u64) -> Result<(), Error> {
    match result {
        vk::Result::ERROR_OUT_OF_DEVICE_MEMORY | vk::Result::ERROR_OUT_OF_HOST_MEMORY => {
            Err(Error::OutOfMemory { what: format!("a buffer ({call})"), bytes })
        }
        other => checked(call, other),
    }
}
