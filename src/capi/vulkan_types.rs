//! Vulkan's part of the header: devices, buffers, reports.

use super::c_enum::c_enums;
use super::check::defs;
use super::types::CrumpleVec3;
use std::ffi::c_void;
use std::mem::MaybeUninit;

defs!(CrumpleVulkanAttachDef, CrumpleVulkanBufferDef, CrumpleVulkanImportDef, CrumpleVulkanOpenDef);
c_enums!(CrumpleHandleType::OpaqueWin32);

/// Any Vulkan function, like PFN_vkVoidFunction. Cast to it: (CrumpleVulkanFunction)vkGetInstanceProcAddr.
pub type CrumpleVulkanFunction = Option<unsafe extern "C" fn()>;

/// Your Vulkan device, Vulkan 1.1 or later: a VkInstance, a VkPhysicalDevice and a VkDevice, all required. No extension
/// or feature needs to be enabled.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleVulkanAttachDef {
    pub struct_size: u32,
    /// Family of the queue that executes the command buffers, with compute. Required. Default UINT32_MAX (invalid).
    pub queue_family: u32,
    /// vkGetInstanceProcAddr of the instance's loader. Crumple gets every function from it and never opens a Vulkan
    /// library. Required.
    pub get_instance_proc_addr: CrumpleVulkanFunction,
    pub instance: *mut c_void,
    pub physical_device: *mut c_void,
    pub device: *mut c_void,
    /// Data of crumple_vulkan_get_pipeline_cache() from an earlier run, read during the call. Data of another driver is
    /// ignored. Default null.
    pub pipeline_cache: *const c_void,
    /// Bytes at pipeline_cache.
    pub pipeline_cache_size: usize,
    /// Invocations per workgroup: 32, 64 or 128, within the device's limit. Default 128. Where an
    /// invocation writes two vertices, workgroups have at most 64.
    pub workgroup_size: u32,
}

/// Where the values of one attribute are stored. All fields zero: absent.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct CrumpleVulkanStream {
    /// Bytes from the start of the range to the first value, a multiple of 4.
    pub offset: u64,
    /// Bytes from one value to the next: at least the size of a value, a multiple of 4.
    pub stride: u64,
    /// A VkFormat. Positions: R32G32B32_SFLOAT, R16G16B16A16_SFLOAT (w is 1), R16G16B16A16_SNORM (see
    /// CrumpleVulkanBufferDef.scale). Normals: R32G32B32_SFLOAT, R16G16B16A16_SNORM, R8G8B8A8_SNORM (w is 0),
    /// R16G16_UNORM (octahedral, see CRUMPLE_DIRECTION_FORMAT_OCTAHEDRAL). Tangents: R32G32B32A32_SFLOAT,
    /// R16G16B16A16_SNORM, R8G8B8A8_SNORM, R16G16_UNORM (octahedral).
    pub format: u32,
    pub reserved: u32,
}

/// A range of a VkBuffer for the deformed vertices of one instance, in the mesh's order and space. Fields without a
/// comment are as in CrumpleHostBufferDef.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleVulkanBufferDef {
    pub struct_size: u32,
    pub lod: u32,
    pub user_data: u64,
    /// The VkBuffer, bound to memory: (uint64_t)handle. Required. One VkBuffer may hold any number of ranges; their
    /// buffer_size, usage, queue_family and four stage and access fields must be equal.
    pub buffer: u64,
    /// Bytes of the whole VkBuffer. Required.
    pub buffer_size: u64,
    /// VkBufferUsageFlags of the VkBuffer. They must include VK_BUFFER_USAGE_STORAGE_BUFFER_BIT. Required.
    pub usage: u32,
    /// The other queue family that owns the VkBuffer. Default VK_QUEUE_FAMILY_IGNORED: the attached queue family owns
    /// it, or it is VK_SHARING_MODE_CONCURRENT. With another owner, each recording that includes one of its ranges
    /// begins with an acquire and ends with a release of the whole VkBuffer, even without changes. You record the
    /// matching release and acquire on the other queue.
    pub queue_family: u32,
    /// VkPipelineStageFlags of your last uses of the VkBuffer before a recording, not 0. Barriers cover the whole
    /// VkBuffer, so include the stages of index reads, copies and read-backs. Default
    /// VK_PIPELINE_STAGE_VERTEX_INPUT_BIT.
    pub before_stages: u32,
    /// VkAccessFlags of those uses. Default VK_ACCESS_VERTEX_ATTRIBUTE_READ_BIT.
    pub before_access: u32,
    /// VkPipelineStageFlags of your next uses of anything in the VkBuffer, not 0. Default
    /// VK_PIPELINE_STAGE_VERTEX_INPUT_BIT.
    pub after_stages: u32,
    /// VkAccessFlags of those uses. Default VK_ACCESS_VERTEX_ATTRIBUTE_READ_BIT.
    pub after_access: u32,
    /// Start of the range, bytes, a multiple of 4.
    pub offset: u64,
    /// Bytes of the range. Nothing outside is written. Ranges may interleave, but values must not overlap. Required.
    pub size: u64,
    pub positions: CrumpleVulkanStream,
    pub normals: CrumpleVulkanStream,
    pub tangents: CrumpleVulkanStream,
    /// For positions in R16G16B16A16_SNORM: a stored value s in -1 to 1 means s * scale + bias, m. Positions outside
    /// that range are clamped, so it must cover the mesh's bounds grown by the depth limit. Above 0. Default 1, 1, 1.
    pub scale: CrumpleVec3,
    pub bias: CrumpleVec3,
}

/// The recorded work. Fields without a comment are as in CrumpleDeformReport.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct CrumpleRecordReport {
    pub vertices_written: u64,
    /// Blocks that will be written. 0: only queue-family transfers were recorded, if any.
    pub blocks_written: u64,
    pub blocks_skipped: u64,
    /// Bytes that the commands copy to the device, including meshes used for the first time.
    pub bytes_copied: u64,
    /// Dispatches: one per VkBuffer, and one per buffer of an instance with a classic rule.
    pub dispatches: u32,
    pub reserved0: u32,
    pub vertices_waiting: u64,
    pub reserved: [u64; 3],
}

impl From<crate::gpu::FrameReport> for CrumpleRecordReport {
    fn from(report: crate::gpu::FrameReport) -> Self {
        CrumpleRecordReport {
            vertices_written: report.vertices_written,
            blocks_written: report.blocks_written,
            blocks_skipped: report.blocks_skipped,
            bytes_copied: report.bytes_copied,
            dispatches: report.dispatches,
            vertices_waiting: report.vertices_waiting,
            ..CrumpleRecordReport::default()
        }
    }
}

/// A Vulkan device that Crumple creates beside yours, on the same physical device. Fields without a comment are as in
/// CrumpleVulkanAttachDef.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleVulkanOpenDef {
    pub struct_size: u32,
    pub workgroup_size: u32,
    /// vkGetInstanceProcAddr of a loader that stays loaded. Required.
    pub get_instance_proc_addr: CrumpleVulkanFunction,
    /// deviceUUID of your physical device (VkPhysicalDeviceIDProperties). Devices with equal UUIDs can share memory.
    /// Default zero: the first device that supports compute.
    pub device_uuid: [u8; 16],
    pub pipeline_cache: *const c_void,
    /// Bytes at pipeline_cache.
    pub pipeline_cache_size: usize,
}

/// The type of a handle to shared memory or to a semaphore.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(dead_code)] // made by C
pub enum CrumpleHandleType {
    /// A file descriptor, VK_EXTERNAL_MEMORY_HANDLE_TYPE_OPAQUE_FD_BIT. Crumple duplicates it; you close yours. Linux
    /// and Android.
    OpaqueFd = 0,
    /// A HANDLE, VK_EXTERNAL_MEMORY_HANDLE_TYPE_OPAQUE_WIN32_BIT. Windows. Untested.
    OpaqueWin32 = 1,
}

/// A VkBuffer of your device that Crumple imports. Create it with VkExternalMemoryBufferCreateInfo, and its memory with
/// VkExportMemoryAllocateInfo, both with handle_type (default CRUMPLE_HANDLE_TYPE_OPAQUE_FD). offset is where the
/// VkBuffer starts in the memory (default 0) and size is its size, bytes. usage is as in CrumpleVulkanBufferDef.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleVulkanImportDef {
    pub struct_size: u32,
    pub handle_type: MaybeUninit<CrumpleHandleType>,
    /// Handle of the memory. Required. Default -1.
    pub handle: i64,
    /// allocationSize of the memory, bytes. Required.
    pub memory_size: u64,
    /// memoryTypeIndex of the memory. Required.
    pub memory_type: u32,
    pub usage: u32,
    pub offset: u64,
    pub size: u64,
    /// Whether the memory is dedicated to this buffer (VkMemoryDedicatedAllocateInfo). Default false.
    pub dedicated: MaybeUninit<bool>,
}
