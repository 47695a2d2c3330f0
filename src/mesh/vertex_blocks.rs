//! Blocks of consecutive vertices, in the engine's order. A block is the unit that is tracked, skipped and evaluated.

use std::ops::Range;

/// Vertices per block.
pub(crate) const BLOCK: usize = 128;

/// The vertices of block `b` in a mesh with `n` vertices.
pub(crate) fn block_range(b: usize, n: usize) -> Range<usize> {
    b * BLOCK..((b + 1) * BLOCK).min(n)
}
