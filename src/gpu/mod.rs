//! What every way onto a graphics device shares: how meshes and a frame's work lie in words of 32 bits, and how vertices are
//! stored. The CPU decides what moves which block, makes every matrix and hands over a few words a block; the kernels beside
//! this file (`*.wgsl`) evaluate the vertices, operation by operation as [`crate::deform`] does.

mod format;
mod frame;
mod skin;
mod spirv;
mod target;

pub use format::{Attribute, Encoding, encode};
pub(crate) use format::{Layout, Stream};
pub(crate) use frame::{Frame, Offsets, Shown};
pub(crate) use skin::{Place, SkinWords, StampWords};
pub(crate) use spirv::with_workgroup;
pub(crate) use target::{Call, Kernel, check_scale, stream};

/// Of nothing, where a word offset is expected.
const NONE: u32 = u32::MAX;
