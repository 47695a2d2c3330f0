//! The data of a frame that the kernels read. `layout.wgsl` declares the same structs; the build asserts that both agree.

use bytemuck::{Pod, Zeroable};

include!(concat!(env!("OUT_DIR"), "/layout.rs"));

const _: () = assert!(BLOCK as usize == crate::mesh::vertex_blocks::BLOCK);

/// Four words, which a kernel reads at once.
pub(super) type Row = [u32; 4];

/// What differs from dispatch to dispatch.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Call {
    pub blocks: u32,
    pub targets: u32,
    pub parts: u32,
    pub states: u32,
    pub row: u32,
    pub count: u32,
    pub split: u32,
}

/// A block to write.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct BlockWork {
    pub target_index: u32,
    pub block: u32,
}

/// A target with a block to write.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct TargetWork {
    pub base_positions: u32,
    pub base_normals: u32,
    pub base_tangents: u32,
    pub vertices: u32,
    pub position_at: u32,
    pub position_stride: u32,
    pub normal_at: u32,
    pub normal_stride: u32,
    pub tangent_at: u32,
    pub tangent_stride: u32,
    pub formats: u32,
    pub flags: u32,
    pub bias: [f32; 3],
    pub limit: f32,
    pub scale: [f32; 3],
    pub given_state: u32,
    pub parts_begin: u32,
    pub parts_end: u32,
    pub depths: u32,
    pub gives: u32,
    pub tiles: u32,
    pub node_step: f32,
    pub padding: [u32; 2],
}

/// A hit on a body with a classic rule.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct ClassicHit {
    pub example: u32,
    pub position_step: f32,
    pub normal_step: f32,
    pub weight: f32,
}
