//! The data of a frame that the kernels read. `layout.wgsl` declares the same structs; the build asserts that both agree.

use crate::deform::kernel;
use crate::example::stamp;
use bytemuck::{Pod, Zeroable};

include!(concat!(env!("OUT_DIR"), "/layout.rs"));

const _: () = assert!(BLOCK as usize == crate::mesh::vertex_blocks::BLOCK);
const _: () = assert!(TURN_STEP == kernel::TURN_STEP && MOST_STEPS == kernel::MOST_STEPS);
const _: () = assert!(WEIGHTS == stamp::WEIGHTS && FACING == stamp::FACING);

/// Four words, which a kernel reads at once.
pub(super) type Row = [u32; 4];

/// What differs from dispatch to dispatch.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Call {
    pub blocks: u32,
    pub targets: u32,
    pub parts: u32,
    pub carried: u32,
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
    pub block_bounds: u32,
    pub position_at: u32,
    pub position_stride: u32,
    pub normal_at: u32,
    pub normal_stride: u32,
    pub tangent_at: u32,
    pub tangent_stride: u32,
    pub formats: u32,
    pub vertices: u32,
    pub bias: [f32; 3],
    pub limit: f32,
    pub scale: [f32; 3],
    pub flags: u32,
    pub parts_begin: u32,
    pub parts_end: u32,
    pub windows: u32,
    pub given_state: u32,
    pub depths: u32,
    pub gives: u32,
    pub step: f32,
    pub per_step: f32,
    pub coarse: f32,
    pub tiles: u32,
    pub node_step: f32,
    pub padding: u32,
}

/// A dent. Its parts follow.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct DentHead {
    pub contact: [f32; 3],
    pub reach_square: f32,
    pub parts: u32,
    pub padding: [u32; 3],
}

/// What moves vertices in a dent.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct DentPart {
    pub scale: f32,
    pub normal_scale: f32,
    pub dropped_square: f32,
    pub lookups: u32,
    pub source: u32,
    pub padding: [u32; 3],
}

/// Carried examples at one contact. Their look-ups follow.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct CarriedWork {
    pub contact: [f32; 3],
    pub padding_contact: u32,
    pub to_frame_x: [f32; 3],
    pub padding_x: u32,
    pub to_frame_y: [f32; 3],
    pub padding_y: u32,
    pub to_frame_z: [f32; 3],
    pub padding_z: u32,
}

/// A carried example.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct LookupWork {
    pub to_grid_x: [f32; 2],
    pub to_grid_y: [f32; 2],
    pub origin: [f32; 2],
    pub last: [f32; 2],
    pub nodes: u32,
    pub columns: u32,
    pub stretch_square: f32,
    pub height: f32,
    pub displacement_x: [f32; 2],
    pub displacement_y: [f32; 2],
    pub displacement_z: f32,
    pub fade: f32,
    pub normal_z: f32,
    pub padding: u32,
    pub normal_x: [f32; 2],
    pub normal_y: [f32; 2],
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
