//! The data of a frame that the kernels read. The build writes it in Rust from `layout.wgsl`, which says what each member is.

use bytemuck::{Pod, Zeroable};

include!(concat!(env!("OUT_DIR"), "/layout.rs"));

/// Four words, which a kernel reads at once.
pub(super) type Row = [u32; 4];

const _: () = assert!(BLOCK as usize == crate::mesh::vertex_blocks::BLOCK);
const _: () = assert!(size_of::<TargetWork>() == TARGET_ROWS as usize * size_of::<Row>());
const _: () = assert!(size_of::<ClassicHit>() == size_of::<Row>() && 2 * size_of::<BlockWork>() == size_of::<Row>());
