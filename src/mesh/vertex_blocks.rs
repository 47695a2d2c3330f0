//! Vertices keep the engine's order and are cut into blocks: the unit that is tracked, skipped and evaluated.

use std::ops::Range;

/// Vertices in a block.
pub(crate) const BLOCK: usize = 128;

/// The vertices of block `b` in a mesh of `n`.
pub(crate) fn block_range(b: usize, n: usize) -> Range<usize> {
    b * BLOCK..((b + 1) * BLOCK).min(n)
}
