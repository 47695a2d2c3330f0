//! Buffers, each with its memory.

use anyhow::{Context, Result};
use ash::vk;

use super::engine::Gpu;

/// Where a buffer's memory is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// Where the device reaches it best; the CPU need not see it.
    Device,
    /// Where the CPU writes it.
    Upload,
    /// Where the CPU reads it, cached if there is such memory.
    ReadBack,
}

/// A buffer that fills its memory.
pub struct Buffer<'g> {
    gpu: &'g Gpu,
    pub handle: vk::Buffer,
    /// Bytes.
    pub size: u64,
    memory: vk::DeviceMemory,
    /// Of what the CPU sees.
    mapped: *mut u32,
}

impl<'g> Buffer<'g> {
    /// Of all buffers here.
    pub const USAGE: vk::BufferUsageFlags = vk::BufferUsageFlags::from_raw(
        vk::BufferUsageFlags::STORAGE_BUFFER.as_raw()
            | vk::BufferUsageFlags::VERTEX_BUFFER.as_raw()
            | vk::BufferUsageFlags::TRANSFER_SRC.as_raw()
            | vk::BufferUsageFlags::TRANSFER_DST.as_raw(),
    );

    /// Of so many bytes, a multiple of 4, above 0.
    pub fn new(gpu: &'g Gpu, size: u64, place: Place) -> Result<Self> {
        let info = vk::BufferCreateInfo::default().size(size).usage(Self::USAGE);
        // SAFETY: valid arguments; what is made is destroyed in `drop`, from here on.
        let handle = unsafe { gpu.device.create_buffer(&info, None) }?;
        let (memory, mapped) = (vk::DeviceMemory::null(), std::ptr::null_mut());
        let mut buffer = Buffer { gpu, handle, size, memory, mapped };
        // SAFETY: the buffer was made just now.
        let needs = unsafe { gpu.device.get_buffer_memory_requirements(handle) };
        let type_ = memory_type(&gpu.memory, needs.memory_type_bits, place)
            .with_context(|| format!("{} has no memory for {place:?} buffers", gpu.name))?;
        let info = vk::MemoryAllocateInfo::default().allocation_size(needs.size).memory_type_index(type_);
        // SAFETY: memory of a type that suits the buffer, bound and mapped once.
        unsafe {
            let allocated = gpu.device.allocate_memory(&info, None);
            buffer.memory =
                allocated.with_context(|| format!("{size} bytes of memory for {place:?} on {}", gpu.name))?;
            gpu.device.bind_buffer_memory(handle, buffer.memory, 0)?;
            if place != Place::Device {
                let none = vk::MemoryMapFlags::empty();
                buffer.mapped = gpu.device.map_memory(buffer.memory, 0, vk::WHOLE_SIZE, none)?.cast();
            }
        }
        Ok(buffer)
    }

    /// On the device, with these words in it.
    pub fn filled(gpu: &'g Gpu, words: &[u32]) -> Result<Self> {
        let bytes = 4 * words.len() as u64;
        let (mut staging, buffer) = (Buffer::new(gpu, bytes, Place::Upload)?, gpu.local(bytes)?);
        staging.words_mut().copy_from_slice(words);
        gpu.timed(|commands| gpu.copy(commands, &staging, &buffer, bytes))?;
        Ok(buffer)
    }

    /// What the CPU sees; nothing is in flight.
    pub fn words(&self) -> &[u32] {
        assert!(!self.mapped.is_null(), "the CPU does not see this buffer");
        // SAFETY: so many words are mapped, and whoever submits waits.
        unsafe { std::slice::from_raw_parts(self.mapped, self.size as usize / 4) }
    }

    pub fn words_mut(&mut self) -> &mut [u32] {
        assert!(!self.mapped.is_null(), "the CPU does not see this buffer");
        // SAFETY: as above.
        unsafe { std::slice::from_raw_parts_mut(self.mapped, self.size as usize / 4) }
    }

    /// The same word everywhere, one that no work writes.
    pub fn poison(&self) -> Result<()> {
        let fill = |commands| {
            // SAFETY: the command buffer is recording.
            unsafe { self.gpu.device.cmd_fill_buffer(commands, self.handle, 0, vk::WHOLE_SIZE, 0xCDCD_CDCD) }
        };
        self.gpu.timed(fill).map(drop)
    }

    /// What is in it, through memory that the CPU sees.
    pub fn read(&self) -> Result<Vec<f32>> {
        let seen = Buffer::new(self.gpu, self.size, Place::ReadBack)?;
        self.gpu.timed(|commands| self.to_host(commands, &seen))?;
        Ok(bytemuck::cast_slice(seen.words()).to_vec())
    }

    /// Records a copy of all of it into memory that the CPU reads afterwards.
    pub fn to_host(&self, commands: vk::CommandBuffer, seen: &Buffer<'_>) {
        self.gpu.copy(commands, self, seen, self.size);
        let to_host = [vk::MemoryBarrier::default()
            .src_access_mask(vk::AccessFlags::TRANSFER_WRITE)
            .dst_access_mask(vk::AccessFlags::HOST_READ)];
        let (from, to) = (vk::PipelineStageFlags::TRANSFER, vk::PipelineStageFlags::HOST);
        let none = vk::DependencyFlags::empty();
        // SAFETY: the command buffer is recording.
        unsafe { self.gpu.device.cmd_pipeline_barrier(commands, from, to, none, &to_host, &[], &[]) };
    }
}

impl Drop for Buffer<'_> {
    fn drop(&mut self) {
        // SAFETY: every submission was waited for; null handles are ignored.
        unsafe {
            self.gpu.device.destroy_buffer(self.handle, None);
            self.gpu.device.free_memory(self.memory, None);
        }
    }
}

/// Of the types that `bits` allows, the one for this place.
fn memory_type(memory: &vk::PhysicalDeviceMemoryProperties, bits: u32, place: Place) -> Option<u32> {
    use vk::MemoryPropertyFlags as P;
    let has = |wanted: P| {
        (0..memory.memory_type_count)
            .find(|t| bits >> t & 1 == 1 && memory.memory_types[*t as usize].property_flags.contains(wanted))
    };
    let seen = P::HOST_VISIBLE | P::HOST_COHERENT;
    match place {
        Place::Device => has(P::DEVICE_LOCAL),
        Place::Upload => has(seen),
        Place::ReadBack => has(seen | P::HOST_CACHED).or_else(|| has(seen)),
    }
}
