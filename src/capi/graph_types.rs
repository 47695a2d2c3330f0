//! The render graph's part of the header: what a plan returns.

use std::ffi::c_void;

/// Bytes to copy into a storage of the render graph.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleGraphUpload {
    /// Number of the storage. Create a storage buffer of storage_size bytes for a number that is new to you.
    pub storage: u32,
    pub reserved: u32,
    pub storage_size: u64,
    /// Where the bytes go, from the start of the storage.
    pub offset: u64,
    pub data: *const c_void,
    /// Bytes at data.
    pub size: usize,
}

/// A compute dispatch of the render graph.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleGraphDispatch {
    /// Number of the kernel; see crumple_graph_get_kernel().
    pub kernel: u32,
    /// Number of the storage to bind.
    pub storage: u32,
    /// The vertex buffer to bind: the buffer field of its CrumpleVulkanBufferDef.
    pub buffer: u64,
    /// Workgroups along x and y. Use 1 along z.
    pub groups: [u32; 2],
    /// The push constants, 32 bytes. Kernels read the first 28; some engines take multiples of 16 only.
    pub constants: [u32; 8],
}

/// The passes of a frame. All pointers are valid until the next crumple_graph_plan() of the context.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleGraphPlan {
    /// Numbers of storages that you may destroy once earlier frames are complete. Ignore those that you do not know.
    pub freed: *const u32,
    /// Copies that you do before the dispatches, in any case.
    pub uploads: *const CrumpleGraphUpload,
    /// Dispatches in any order; they write different vertices.
    pub dispatches: *const CrumpleGraphDispatch,
    /// The work of the frame, for all dispatches.
    pub work: *const c_void,
    /// Bytes at work. 0 if there are no dispatches.
    pub work_size: usize,
    pub freed_count: u32,
    pub upload_count: u32,
    pub dispatch_count: u32,
    pub reserved: u32,
}

/// A context's render graph, and what its last plan returned.
#[derive(Default)]
pub(super) struct GraphState {
    pub(super) graph: crate::graph::Graph,
    pub(super) uploads: Vec<CrumpleGraphUpload>,
    pub(super) dispatches: Vec<CrumpleGraphDispatch>,
}
