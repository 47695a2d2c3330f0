//! Deformation on the host's graphics device: recorded into the host's own Vulkan command buffers.

#[cfg(feature = "vulkan")]
#[path = "vulkan/attached.rs"]
mod attached;
#[cfg(not(feature = "vulkan"))]
#[path = "vulkan/absent.rs"]
mod attached;

pub(super) use attached::{Attached, VulkanMemory};

use super::buffer::{BufferEntry, Memory};
use super::check::{CEnum, Def, MadeBy, Out, array, def, enumerator, finite, write_array};
use super::context::{CrumpleContext, State, exclusive, recorded};
use super::result::{CrumpleResult, Failure};
use super::types::{CrumpleBuffer, CrumpleInstance, CrumpleVec3};
use std::ffi::c_void;
use std::mem::MaybeUninit;

/// Any Vulkan function, as PFN_vkVoidFunction: (CrumpleVulkanFunction)vkGetInstanceProcAddr.
pub type CrumpleVulkanFunction = Option<unsafe extern "C" fn()>;

/// Your Vulkan device, of Vulkan 1.1 or later. No extension and no feature needs to be enabled.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleVulkanAttachDef {
    /// Bytes of this struct, from crumple_vulkan_attach_def_default().
    pub struct_size: u32,
    /// Family of the queue that command buffers are submitted to; one that can compute. Required. Default UINT32_MAX.
    pub queue_family: u32,
    /// vkGetInstanceProcAddr of the loader that the instance was made with. Every function is taken from it; Crumple never
    /// opens a Vulkan library of its own accord. Required.
    pub get_instance_proc_addr: CrumpleVulkanFunction,
    /// The VkInstance. Required.
    pub instance: *mut c_void,
    /// The VkPhysicalDevice. Required.
    pub physical_device: *mut c_void,
    /// The VkDevice. Required.
    pub device: *mut c_void,
    /// What crumple_vulkan_get_pipeline_cache() gave at an earlier run; read during the call. Data of another driver is not
    /// used. Default null: none.
    pub pipeline_cache: *const c_void,
    /// Bytes at pipeline_cache.
    pub pipeline_cache_size: usize,
    /// Invocations a workgroup: 32, 64, 128 or 256, no more than the device can. Default 128.
    pub workgroup_size: u32,
}

// SAFETY: `repr(C)`, starts with its size, and any bytes are a value of it.
unsafe impl Def for CrumpleVulkanAttachDef {
    const DEFAULT: MadeBy<Self> = ("crumple_vulkan_attach_def_default", crumple_vulkan_attach_def_default);
}

/// Where the values of one attribute lie. Zero everywhere: the attribute is absent.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct CrumpleVulkanStream {
    /// Bytes from the range's begin to the first vertex's value; a multiple of 4.
    pub offset: u64,
    /// Bytes from one vertex's value to the next; a multiple of 4, at least those of one value.
    pub stride: u64,
    /// A VkFormat. Positions: R32G32B32_SFLOAT, R16G16B16A16_SFLOAT (the fourth is 1), R16G16B16A16_SNORM (see scale).
    /// Normals: R32G32B32_SFLOAT, R16G16B16A16_SNORM, R8G8B8A8_SNORM (the fourth is 0). Tangents: R32G32B32A32_SFLOAT,
    /// R16G16B16A16_SNORM, R8G8B8A8_SNORM.
    pub format: u32,
    /// Zero.
    pub reserved: u32,
}

/// A range of a VkBuffer for the deformed vertices of one instance, in the mesh's order and space.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleVulkanBufferDef {
    /// Bytes of this struct, from crumple_vulkan_buffer_def_default().
    pub struct_size: u32,
    /// The mesh whose vertices are written: 0 the base mesh, else a number from crumple_example_set_add_lod(). Default 0.
    pub lod: u32,
    /// The VkBuffer, bound to memory: (uint64_t)handle. Required. Any number of ranges may lie in it; this field and the
    /// seven below it are then the same for each.
    pub buffer: u64,
    /// Bytes of the whole VkBuffer. Required.
    pub buffer_size: u64,
    /// The VkBufferUsageFlags that it was made with; VK_BUFFER_USAGE_STORAGE_BUFFER_BIT must be among them. Required.
    pub usage: u32,
    /// The queue family that owns it before and after what Crumple records; not the device's own: each recording that names
    /// one of its ranges then begins with an acquire and ends with a release of the whole VkBuffer, even where no vertex
    /// changed, and the release and acquire of that other queue are yours. Default VK_QUEUE_FAMILY_IGNORED: that of the
    /// device owns it, or it is shared (VK_SHARING_MODE_CONCURRENT).
    pub queue_family: u32,
    /// The VkPipelineStageFlags in which you used the VkBuffer last before a recording, anything in it, since barriers are of
    /// the whole: indices, copies into it, read-backs; not 0. Default VK_PIPELINE_STAGE_VERTEX_INPUT_BIT.
    pub before_stages: u32,
    /// The VkAccessFlags of that use. Default VK_ACCESS_VERTEX_ATTRIBUTE_READ_BIT.
    pub before_access: u32,
    /// The VkPipelineStageFlags in which you use it next, anything in it; not 0. Default VK_PIPELINE_STAGE_VERTEX_INPUT_BIT.
    pub after_stages: u32,
    /// The VkAccessFlags of that use. Default VK_ACCESS_VERTEX_ATTRIBUTE_READ_BIT.
    pub after_access: u32,
    /// Bytes before the range; a multiple of 4.
    pub offset: u64,
    /// Bytes of the range: nothing outside it is written. Ranges may interleave; values must not overlap. Required.
    pub size: u64,
    /// Positions, m. Required.
    pub positions: CrumpleVulkanStream,
    /// Unit normals. Absent: none are written.
    pub normals: CrumpleVulkanStream,
    /// Tangents: xyz of unit length and orthogonal to the normal, w as in the base mesh. Absent: none are written.
    pub tangents: CrumpleVulkanStream,
    /// Of positions in R16G16B16A16_SNORM: a stored number s, -1 to 1, stands for s * scale + bias, m. What lies outside is
    /// held at the border, so take the mesh's bounds grown by the depth limit. Above 0. Default 1, 1, 1.
    pub scale: CrumpleVec3,
    /// See scale, m. Default 0, 0, 0.
    pub bias: CrumpleVec3,
}

// SAFETY: `repr(C)`, starts with its size, and any bytes are a value of it.
unsafe impl Def for CrumpleVulkanBufferDef {
    const DEFAULT: MadeBy<Self> = ("crumple_vulkan_buffer_def_default", crumple_vulkan_buffer_def_default);
}

/// What was recorded.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct CrumpleRecordReport {
    /// Vertices that will be written, over all buffers.
    pub vertices_written: u64,
    /// Blocks of consecutive vertices that will be written. 0: nothing was recorded, but what queue families ask for.
    pub blocks_written: u64,
    /// Blocks that were up to date already.
    pub blocks_skipped: u64,
    /// Examples of marks that tolerances left out, see crumple_instance_set_tolerance().
    pub parts_skipped: u64,
    /// Bytes that the commands copy to the device, those of meshes seen for the first time among them.
    pub bytes_copied: u64,
    /// Dispatches: one for each VkBuffer, and one for each buffer of an instance with one of the literature's rules.
    pub dispatches: u32,
    /// Zero.
    pub reserved0: u32,
    /// Zero; room for later.
    pub reserved: [u64; 4],
}

/// A device without handles; set them and the queue family. Never fails; any thread.
#[unsafe(no_mangle)]
pub extern "C" fn crumple_vulkan_attach_def_default() -> CrumpleVulkanAttachDef {
    CrumpleVulkanAttachDef {
        struct_size: size_of::<CrumpleVulkanAttachDef>() as u32,
        queue_family: u32::MAX,
        get_instance_proc_addr: None,
        instance: std::ptr::null_mut(),
        physical_device: std::ptr::null_mut(),
        device: std::ptr::null_mut(),
        pipeline_cache: std::ptr::null(),
        pipeline_cache_size: 0,
        workgroup_size: 128,
    }
}

/// A range of no buffer, read as vertices before and after; set the buffer, its size and usage, the range and its streams.
/// Never fails; any thread.
#[unsafe(no_mangle)]
pub extern "C" fn crumple_vulkan_buffer_def_default() -> CrumpleVulkanBufferDef {
    // VK_PIPELINE_STAGE_VERTEX_INPUT_BIT, VK_ACCESS_VERTEX_ATTRIBUTE_READ_BIT.
    let (stages, access) = (0x4, 0x4);
    CrumpleVulkanBufferDef {
        struct_size: size_of::<CrumpleVulkanBufferDef>() as u32,
        lod: 0,
        buffer: 0,
        buffer_size: 0,
        usage: 0,
        queue_family: u32::MAX,
        before_stages: stages,
        before_access: access,
        after_stages: stages,
        after_access: access,
        offset: 0,
        size: 0,
        positions: CrumpleVulkanStream::default(),
        normals: CrumpleVulkanStream::default(),
        tangents: CrumpleVulkanStream::default(),
        scale: CrumpleVec3 { x: 1.0, y: 1.0, z: 1.0 },
        bias: CrumpleVec3::default(),
    }
}

/// Takes your Vulkan device: loads functions, some tenths of a millisecond. A context has one at a time. The handles must be
/// valid, belong together, and stay so until crumple_vulkan_detach() or crumple_context_destroy().
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED, CRUMPLE_ERROR_STRUCT_SIZE,
/// CRUMPLE_ERROR_INVALID_ARGUMENT (one is attached already, a queue family that is not there or cannot compute,
/// workgroup_size), CRUMPLE_ERROR_UNSUPPORTED (a device below Vulkan 1.1; a loader that lacks a function, which is named; a
/// build without CRUMPLE_FEATURE_VULKAN), CRUMPLE_ERROR_VULKAN, CRUMPLE_ERROR_DEVICE_LOST, CRUMPLE_ERROR_CONCURRENT_USE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_vulkan_attach(
    context: *mut CrumpleContext,
    def: *const CrumpleVulkanAttachDef,
) -> CrumpleResult {
    exclusive("crumple_vulkan_attach", context, |_, state| {
        // SAFETY: the caller's.
        let def = unsafe { self::def(def, "def") }?;
        if state.vulkan.is_some() {
            return Err(Failure::invalid("a device is attached already; crumple_vulkan_detach() first"));
        }
        // SAFETY: the caller's.
        let cache = unsafe { array(def.pipeline_cache.cast::<u8>(), def.pipeline_cache_size, "def.pipeline_cache") }?;
        // SAFETY: the caller's.
        state.vulkan = Some(unsafe { Attached::new(&def, cache) }?);
        Ok(())
    })
}

/// Lets go of the Vulkan device, unregisters all Vulkan buffers, whose ids end, and destroys what Crumple made there. Damage
/// stays. After a loss of the device (CRUMPLE_ERROR_DEVICE_LOST): crumple_vulkan_complete_frames() with UINT64_MAX, since a lost
/// device runs nothing any more, this call, vkDestroyDevice, then attach the new one and register again.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_INVALID_ID, CRUMPLE_ERROR_INVALID_ARGUMENT (none
/// is attached), CRUMPLE_ERROR_FRAMES_IN_FLIGHT, CRUMPLE_ERROR_CONCURRENT_USE. Nothing changes then.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_vulkan_detach(context: *mut CrumpleContext) -> CrumpleResult {
    exclusive("crumple_vulkan_detach", context, |_, state| {
        attached(state)?.check_idle()?;
        let of_vulkan = |(id, entry): (CrumpleBuffer, &BufferEntry)| {
            matches!(entry.memory, Memory::Vulkan(_)).then_some((id, entry.owner))
        };
        let theirs: Vec<_> = state.buffers.iter().filter_map(of_vulkan).collect();
        for (id, owner) in theirs {
            state.remove_buffer(id)?;
            state.instances.get_mut(owner, "instance")?.buffers.retain(|b| *b != id);
        }
        state.vulkan = None;
        Ok(())
    })
}

/// Gives what the driver would like to have again at the next start: hand it to crumple_vulkan_attach(). data has room for
/// capacity bytes, of any alignment; with null and 0 only their number is told, which may grow until all kinds of buffers were
/// registered.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED (out_size),
/// CRUMPLE_ERROR_INVALID_ARGUMENT (no device is attached), CRUMPLE_ERROR_BUFFER_TOO_SMALL, CRUMPLE_ERROR_VULKAN,
/// CRUMPLE_ERROR_DEVICE_LOST, CRUMPLE_ERROR_CONCURRENT_USE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_vulkan_get_pipeline_cache(
    context: *mut CrumpleContext,
    data: *mut c_void,
    capacity: usize,
    out_size: *mut usize,
) -> CrumpleResult {
    exclusive("crumple_vulkan_get_pipeline_cache", context, |_, state| {
        // SAFETY: the caller's.
        let out = unsafe { Out::new(out_size, "out_size") }?;
        let bytes = attached(state)?.pipeline_cache()?;
        // SAFETY: the caller's.
        unsafe { write_array(&bytes, data.cast::<u8>(), capacity, "data") }?;
        out.write(bytes.len());
        Ok(())
    })
}

/// Registers a range of a VkBuffer of yours that crumple_vulkan_record() writes an instance's vertices to. An instance may have
/// several, such as the members of a ring. Nothing is written yet; the first recording writes every vertex. The first range of a
/// mesh has its vertices and examples copied: into a staging buffer now, from there to the device by the next recording; other
/// instances and ranges share them. The VkBuffer must live until its last range is unregistered (or its instance, the device or
/// the context gone) and the frames that wrote it are done.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED (offsets and strides that are not
/// multiples of 4), CRUMPLE_ERROR_STRUCT_SIZE, CRUMPLE_ERROR_INVALID_ID, CRUMPLE_ERROR_INVALID_ARGUMENT (no device is attached, no
/// buffer, a usage without STORAGE_BUFFER, stages of 0, a format that is not one of those named, a stride smaller than a value,
/// attributes that overlap, a scale that is not above 0, another description of a VkBuffer that is registered already),
/// CRUMPLE_ERROR_NOT_FINITE, CRUMPLE_ERROR_BUFFER_TOO_SMALL, CRUMPLE_ERROR_INDEX_OUT_OF_RANGE (def.lod),
/// CRUMPLE_ERROR_WRONG_RULE (def.lod above 0 for an instance with one of the literature's rules), CRUMPLE_ERROR_UNSUPPORTED
/// (normals or tangents of a mesh that has none; more bytes than the device can bind), CRUMPLE_ERROR_OUT_OF_MEMORY,
/// CRUMPLE_ERROR_VULKAN, CRUMPLE_ERROR_DEVICE_LOST, CRUMPLE_ERROR_CONCURRENT_USE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_buffer_register_vulkan(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    def: *const CrumpleVulkanBufferDef,
    out_buffer: *mut CrumpleBuffer,
) -> CrumpleResult {
    recorded("crumple_buffer_register_vulkan", context, |_, state, log| {
        // SAFETY: the caller's.
        let (def, out) = unsafe { (self::def(def, "def")?, Out::new(out_buffer, "out_buffer")?) };
        finite(def.scale.array(), "def.scale")?;
        finite(def.bias.array(), "def.bias")?;
        let owner = &state.instances.get(instance, "instance")?.instance;
        let vulkan = state.vulkan.as_mut().ok_or_else(not_attached)?;
        // SAFETY: the caller's.
        let memory = Memory::Vulkan(unsafe { vulkan.register(owner, &def) }?);
        state.add_buffer(log, BufferEntry { owner: instance, lod: def.lod as usize, memory }, out)
    })
}

/// Records what brings Vulkan buffers up to date: count ids at buffers, each once; with null and 0 all of the context. Hits
/// are folded; then, for the blocks that changed since each buffer was last written, there is a copy of a few bytes a block, a
/// barrier, one dispatch a VkBuffer, a barrier. Nothing is submitted, nothing waited for, and nothing allocated once as much has
/// changed in a frame, and as many frames were in flight, as ever will. What is read on the CPU is read by this call; damage
/// may change at once after it.
///
/// command_buffer is a VkCommandBuffer, primary or secondary, in the recording state, outside a render pass, of a pool of the
/// queue family that was attached and that no other thread uses meanwhile. It is submitted once, in the order of recording; not
/// simultaneously, not again. frame is your number of the frame, from 1 on; it never falls, and several recordings may have the
/// same one. out_report may be null.
///
/// Left changed in the command buffer: the compute pipeline, the compute descriptor sets 0 to 2, and the first 24 bytes of the
/// push constants of stage compute. Nothing else.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED, CRUMPLE_ERROR_INVALID_ID,
/// CRUMPLE_ERROR_INVALID_ARGUMENT (no device of yours is attached, a buffer twice or a host buffer, a frame that is done or
/// below the last), CRUMPLE_ERROR_UNSUPPORTED (more work than the device can bind), CRUMPLE_ERROR_OUT_OF_MEMORY, CRUMPLE_ERROR_VULKAN,
/// CRUMPLE_ERROR_DEVICE_LOST, CRUMPLE_ERROR_CONCURRENT_USE. Nothing was recorded then.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_vulkan_record(
    context: *mut CrumpleContext,
    command_buffer: *mut c_void,
    frame: u64,
    buffers: *const CrumpleBuffer,
    count: u32,
    out_report: *mut CrumpleRecordReport,
) -> CrumpleResult {
    recorded("crumple_vulkan_record", context, |_, state, log| {
        // SAFETY: the caller's.
        let (out, given) =
            unsafe { (Out::optional(out_report, "out_report")?, array(buffers, count as usize, "buffers")?) };
        if command_buffer.is_null() {
            return Err(Failure::new(CrumpleResult::CrumpleErrorNullPointer, "command_buffer is null"));
        }
        let State { instances, buffers: entries, vulkan, .. } = state;
        let vulkan = vulkan.as_mut().ok_or_else(not_attached)?;
        // SAFETY: the caller's.
        out.write(unsafe { vulkan.record((command_buffer, frame), (buffers, given), (entries, instances), log) }?);
        Ok(())
    })
}

/// Says that the device is done with frame and all before it: what was submitted for them has completed, as a fence or
/// timeline semaphore says. What they used is used again, or freed. A number above the last recorded frame's counts as that.
/// Cheap; once a frame.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_INVALID_ID, CRUMPLE_ERROR_INVALID_ARGUMENT (no
/// device of yours is attached), CRUMPLE_ERROR_CONCURRENT_USE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_vulkan_complete_frames(context: *mut CrumpleContext, frame: u64) -> CrumpleResult {
    exclusive("crumple_vulkan_complete_frames", context, |_, state| attached(state)?.complete(frame))
}

/// Says that what was recorded for frame and those after it will not be submitted: the buffers that it wrote are written
/// whole by their next recording.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_INVALID_ID, CRUMPLE_ERROR_INVALID_ARGUMENT (no
/// device of yours is attached), CRUMPLE_ERROR_CONCURRENT_USE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_vulkan_discard_frames(context: *mut CrumpleContext, frame: u64) -> CrumpleResult {
    exclusive("crumple_vulkan_discard_frames", context, |_, state| {
        attached(state)?.discard(frame)?;
        for (_, entry) in state.buffers.iter_mut::<CrumpleBuffer>() {
            if let Memory::Vulkan(memory) = &mut entry.memory {
                memory.discard(frame);
            }
        }
        Ok(())
    })
}

/// A Vulkan device that Crumple makes for itself, beside yours on the same physical device.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleVulkanOpenDef {
    /// Bytes of this struct, from crumple_vulkan_open_def_default().
    pub struct_size: u32,
    /// As in CrumpleVulkanAttachDef. Default 128.
    pub workgroup_size: u32,
    /// vkGetInstanceProcAddr of a loader. Required; it stays loaded.
    pub get_instance_proc_addr: CrumpleVulkanFunction,
    /// deviceUUID of your physical device (VkPhysicalDeviceIDProperties): memory can be shared within it alone. Zero
    /// everywhere: the first that can compute. Default zero.
    pub device_uuid: [u8; 16],
    /// As in CrumpleVulkanAttachDef. Default null.
    pub pipeline_cache: *const c_void,
    /// Bytes at pipeline_cache.
    pub pipeline_cache_size: usize,
}

// SAFETY: `repr(C)`, starts with its size, and any bytes are a value of it.
unsafe impl Def for CrumpleVulkanOpenDef {
    const DEFAULT: MadeBy<Self> = ("crumple_vulkan_open_def_default", crumple_vulkan_open_def_default);
}

/// How a device hands memory or a semaphore to another one.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CrumpleHandleType {
    /// A file descriptor, VK_EXTERNAL_MEMORY_HANDLE_TYPE_OPAQUE_FD_BIT. It is duplicated: yours stays yours, to be closed when
    /// you like. Linux, Android and their kind.
    OpaqueFd = 0,
    /// A HANDLE, VK_EXTERNAL_MEMORY_HANDLE_TYPE_OPAQUE_WIN32_BIT. Windows. Untested.
    OpaqueWin32 = 1,
}

impl CEnum for CrumpleHandleType {
    const ALL: &'static [Self] = &[Self::OpaqueFd, Self::OpaqueWin32];
}

/// A VkBuffer of your device, in memory that it exported. You made it with VkExternalMemoryBufferCreateInfo, and its memory with
/// VkExportMemoryAllocateInfo, both of the same type of handle.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleVulkanImportDef {
    /// Bytes of this struct, from crumple_vulkan_import_def_default().
    pub struct_size: u32,
    /// What handle is. Default CRUMPLE_HANDLE_TYPE_OPAQUE_FD.
    pub handle_type: MaybeUninit<CrumpleHandleType>,
    /// The handle of the memory. Required. Default -1.
    pub handle: i64,
    /// allocationSize of the memory, bytes. Required.
    pub memory_size: u64,
    /// memoryTypeIndex of the memory. Required.
    pub memory_type: u32,
    /// VkBufferUsageFlags that the buffer was made with; VK_BUFFER_USAGE_STORAGE_BUFFER_BIT must be among them. Required.
    pub usage: u32,
    /// Where in the memory the buffer was bound, bytes. Default 0.
    pub offset: u64,
    /// The buffer's size, bytes. Required.
    pub size: u64,
    /// Whether the memory was allocated for this buffer alone (VkMemoryDedicatedAllocateInfo). Default false.
    pub dedicated: MaybeUninit<bool>,
}

// SAFETY: `repr(C)`, starts with its size, and any bytes are a value of it.
unsafe impl Def for CrumpleVulkanImportDef {
    const DEFAULT: MadeBy<Self> = ("crumple_vulkan_import_def_default", crumple_vulkan_import_def_default);
}

/// Any device, by no loader; set that, and the UUID. Never fails; any thread.
#[unsafe(no_mangle)]
pub extern "C" fn crumple_vulkan_open_def_default() -> CrumpleVulkanOpenDef {
    CrumpleVulkanOpenDef {
        struct_size: size_of::<CrumpleVulkanOpenDef>() as u32,
        workgroup_size: 128,
        get_instance_proc_addr: None,
        device_uuid: [0; 16],
        pipeline_cache: std::ptr::null(),
        pipeline_cache_size: 0,
    }
}

/// No memory; set its handle, sizes, type and usage. Never fails; any thread.
#[unsafe(no_mangle)]
pub extern "C" fn crumple_vulkan_import_def_default() -> CrumpleVulkanImportDef {
    CrumpleVulkanImportDef {
        struct_size: size_of::<CrumpleVulkanImportDef>() as u32,
        handle_type: MaybeUninit::new(CrumpleHandleType::OpaqueFd),
        handle: -1,
        memory_size: 0,
        memory_type: 0,
        usage: 0,
        offset: 0,
        size: 0,
        dedicated: MaybeUninit::new(false),
    }
}

/// Makes a Vulkan device of Crumple's own, for engines that cannot hand out a command buffer but can share memory, perhaps with
/// another process: some milliseconds to tenths of a second. It takes the place of crumple_vulkan_attach(): buffers are
/// imported by crumple_vulkan_import_buffer(), registered by crumple_buffer_register_vulkan() and written by
/// crumple_vulkan_submit(). crumple_vulkan_detach() and crumple_context_destroy() wait for it, and destroy it.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED, CRUMPLE_ERROR_STRUCT_SIZE,
/// CRUMPLE_ERROR_INVALID_ARGUMENT (a device is attached already, workgroup_size), CRUMPLE_ERROR_UNSUPPORTED (no such device, which
/// names those there are; one that cannot import memory; a build without CRUMPLE_FEATURE_VULKAN), CRUMPLE_ERROR_VULKAN,
/// CRUMPLE_ERROR_DEVICE_LOST, CRUMPLE_ERROR_CONCURRENT_USE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_vulkan_open(
    context: *mut CrumpleContext,
    def: *const CrumpleVulkanOpenDef,
) -> CrumpleResult {
    exclusive("crumple_vulkan_open", context, |_, state| {
        // SAFETY: the caller's.
        let def = unsafe { self::def(def, "def") }?;
        if state.vulkan.is_some() {
            return Err(Failure::invalid("a device is attached already; crumple_vulkan_detach() first"));
        }
        // SAFETY: the caller's.
        let cache = unsafe { array(def.pipeline_cache.cast::<u8>(), def.pipeline_cache_size, "def.pipeline_cache") }?;
        // SAFETY: the caller's.
        state.vulkan = Some(unsafe { Attached::open(&def, cache) }?);
        Ok(())
    })
}

/// Makes a buffer of your device known to Crumple's own, and gives what stands for it as buffer of CrumpleVulkanBufferDef; that
/// def's buffer_size, usage, queue family, stages and accesses are not looked at then. On your queue, before each submission you
/// release the VkBuffer to VK_QUEUE_FAMILY_EXTERNAL, and afterwards you acquire it from there. The memory must live until
/// crumple_vulkan_unimport_buffer(), crumple_vulkan_detach() or crumple_context_destroy().
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED, CRUMPLE_ERROR_STRUCT_SIZE,
/// CRUMPLE_ERROR_INVALID_ARGUMENT (no device of crumple_vulkan_open(), a handle that is none or not of memory, a memory type that
/// the buffer cannot lie in, a usage without STORAGE_BUFFER), CRUMPLE_ERROR_BUFFER_TOO_SMALL (the memory),
/// CRUMPLE_ERROR_UNSUPPORTED (a handle of another system, or a buffer that the device cannot import),
/// CRUMPLE_ERROR_OUT_OF_MEMORY, CRUMPLE_ERROR_VULKAN, CRUMPLE_ERROR_DEVICE_LOST, CRUMPLE_ERROR_CONCURRENT_USE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_vulkan_import_buffer(
    context: *mut CrumpleContext,
    def: *const CrumpleVulkanImportDef,
    out_buffer: *mut u64,
) -> CrumpleResult {
    exclusive("crumple_vulkan_import_buffer", context, |_, state| {
        // SAFETY: the caller's.
        let (def, out) = unsafe { (self::def(def, "def")?, Out::new(out_buffer, "out_buffer")?) };
        // SAFETY: the caller's.
        out.write(unsafe { attached(state)?.import_buffer(&def) }?);
        Ok(())
    })
}

/// Forgets an imported buffer that no range is registered of, and waits until the device is done with it.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_INVALID_ARGUMENT (no device of
/// crumple_vulkan_open(), no such buffer, ranges of it are registered), CRUMPLE_ERROR_VULKAN, CRUMPLE_ERROR_DEVICE_LOST,
/// CRUMPLE_ERROR_CONCURRENT_USE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_vulkan_unimport_buffer(context: *mut CrumpleContext, buffer: u64) -> CrumpleResult {
    exclusive("crumple_vulkan_unimport_buffer", context, |_, state| attached(state)?.release_buffer(buffer))
}

/// Makes a binary semaphore of your device, exported with the same type of handle, known to Crumple's own, and gives its number
/// for crumple_vulkan_submit(). It lives until crumple_vulkan_detach() or crumple_context_destroy().
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED, CRUMPLE_ERROR_INVALID_ARGUMENT (no
/// device of crumple_vulkan_open(), handle_type, a handle that is none or not of a semaphore), CRUMPLE_ERROR_UNSUPPORTED (a driver
/// without external semaphores: order by fences and crumple_vulkan_wait_frame() then), CRUMPLE_ERROR_VULKAN, CRUMPLE_ERROR_DEVICE_LOST,
/// CRUMPLE_ERROR_CONCURRENT_USE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_vulkan_import_semaphore(
    context: *mut CrumpleContext,
    handle_type: MaybeUninit<CrumpleHandleType>,
    handle: i64,
    out_semaphore: *mut u64,
) -> CrumpleResult {
    exclusive("crumple_vulkan_import_semaphore", context, |_, state| {
        // SAFETY: the caller's.
        let out = unsafe { Out::new(out_semaphore, "out_semaphore") }?;
        let kind = enumerator(handle_type, "handle_type")?;
        // SAFETY: the caller's.
        out.write(unsafe { attached(state)?.import_semaphore(kind, handle) }?);
        Ok(())
    })
}

/// What crumple_vulkan_record() is for a device of Crumple's own: records what brings Vulkan buffers up to date, and submits
/// that. count ids at buffers, each once; with null and 0 all of the context. The device waits for wait_count semaphores at
/// waits before and signals signal_count at signals after, also where nothing changed; nothing is waited for by this call.
/// out_frame gets the number of the frame, for crumple_vulkan_wait_frame(). out_frame and out_report may be null.
///
/// Externally synchronised. Errors: those of crumple_vulkan_record(), and CRUMPLE_ERROR_INVALID_ARGUMENT where there is no device
/// of crumple_vulkan_open(), or no such semaphore. Nothing was submitted then.
#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments)] // three arrays
pub unsafe extern "C" fn crumple_vulkan_submit(
    context: *mut CrumpleContext,
    buffers: *const CrumpleBuffer,
    count: u32,
    waits: *const u64,
    wait_count: u32,
    signals: *const u64,
    signal_count: u32,
    out_frame: *mut u64,
    out_report: *mut CrumpleRecordReport,
) -> CrumpleResult {
    recorded("crumple_vulkan_submit", context, |_, state, log| {
        // SAFETY: the caller's.
        let outs = unsafe { (Out::optional(out_frame, "out_frame")?, Out::optional(out_report, "out_report")?) };
        // SAFETY: the caller's.
        let (given, waits, signals) = unsafe {
            (
                array(buffers, count as usize, "buffers")?,
                array(waits, wait_count as usize, "waits")?,
                array(signals, signal_count as usize, "signals")?,
            )
        };
        let State { instances, buffers: entries, vulkan, .. } = state;
        let vulkan = vulkan.as_mut().ok_or_else(not_attached)?;
        let (frame, report) = vulkan.submit((buffers, given), (entries, instances), (waits, signals), log)?;
        outs.0.write(frame);
        outs.1.write(report);
        Ok(())
    })
}

/// Waits until Crumple's own device is done with a frame of crumple_vulkan_submit() and all before it, or for timeout
/// nanoseconds (UINT64_MAX: as long as it takes). out_done tells whether it is done. The context is in use meanwhile.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_INVALID_ARGUMENT (no device of
/// crumple_vulkan_open(), a frame that was not submitted), CRUMPLE_ERROR_VULKAN, CRUMPLE_ERROR_DEVICE_LOST,
/// CRUMPLE_ERROR_CONCURRENT_USE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_vulkan_wait_frame(
    context: *mut CrumpleContext,
    frame: u64,
    timeout: u64,
    out_done: *mut bool,
) -> CrumpleResult {
    exclusive("crumple_vulkan_wait_frame", context, |_, state| {
        // SAFETY: the caller's.
        let out = unsafe { Out::new(out_done, "out_done") }?;
        out.write(attached(state)?.wait(frame, timeout)?);
        Ok(())
    })
}

fn attached(state: &mut State) -> Result<&mut Attached, Failure> {
    state.vulkan.as_mut().ok_or_else(not_attached)
}

fn not_attached() -> Failure {
    Failure::invalid("no Vulkan device is attached; crumple_vulkan_attach() or crumple_vulkan_open() first")
}
