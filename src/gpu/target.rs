//! What every way asks of a target, and tells a kernel at a dispatch.

use super::frame::{BLOCK_WORDS, Offsets};
use super::{Encoding, Layout, Stream};
use crate::Error;
use crate::mesh::Mesh;
use crate::mesh::vertex_blocks::BLOCK;
use std::fmt::Debug;
use std::ops::Range;

/// How much of a vertex a kernel writes; each writes what those before it do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Kernel {
    Positions,
    Normals,
    Tangents,
}

impl Kernel {
    /// The one that writes what a layout asks for.
    ///
    /// # Errors
    /// [`Error::Unsupported`] for what the mesh does not have.
    pub(crate) fn of(layout: &Layout, mesh: &Mesh) -> Result<Self, Error> {
        let kernel = match (layout.normals, layout.tangents) {
            (_, Some(_)) => Kernel::Tangents,
            (Some(_), None) => Kernel::Normals,
            (None, None) => Kernel::Positions,
        };
        if kernel > Kernel::Positions && mesh.normals().is_none() {
            let what = "a normal or tangent output: the mesh has neither normals nor triangles to compute them from";
            return Err(Error::Unsupported { what: what.into() });
        }
        if kernel == Kernel::Tangents && mesh.tangents().is_none() {
            return Err(Error::Unsupported { what: "a tangent output: the mesh has no tangents".into() });
        }
        Ok(kernel)
    }

    /// Its place among all: those of the default rule, then of the classic ones.
    pub(crate) fn number(self, classic: bool) -> usize {
        self as usize + if classic { 3 } else { 0 }
    }

    /// Bytes a vertex of a classic rule's state.
    pub(crate) fn state_bytes(self) -> u64 {
        if self > Kernel::Positions { 24 } else { 12 }
    }
}

/// A stream whose format, in the words of the interface, is one of those allowed.
///
/// # Errors
/// [`Error::InvalidArgument`] naming them.
pub(crate) fn stream<F: PartialEq + Debug>(
    name: &str,
    (offset, stride, format): (u64, u64, F),
    allowed: &[(F, Encoding)],
) -> Result<Stream, Error> {
    let Some((_, encoding)) = allowed.iter().find(|(allowed, _)| *allowed == format) else {
        let names: Vec<String> = allowed.iter().map(|(format, _)| format!("{format:?}")).collect();
        let name = format!("the {name} format");
        return Err(Error::invalid(&name, format!("{format:?}"), &format!("one of {}", names.join(", "))));
    };
    Ok(Stream { offset, stride, encoding: *encoding })
}

/// Refuses what no stored number could be turned back with.
///
/// # Errors
/// [`Error::InvalidArgument`].
pub(crate) fn check_scale(positions: &Stream, scale: [f32; 3], bias: [f32; 3]) -> Result<(), Error> {
    let good = scale.iter().all(|s| *s > 0.0 && s.is_finite()) && bias.iter().all(|b| b.is_finite());
    if positions.encoding == Encoding::Snorm16x4 && !good {
        let value = format!("{scale:?}, bias {bias:?}");
        return Err(Error::invalid("the scale", value, "above 0 and finite, the bias finite, m"));
    }
    Ok(())
}

/// What a kernel is told at a dispatch: `Call` in common.wgsl.
pub(crate) type Call = [u32; 6];

impl Offsets {
    /// What a dispatch of these blocks is told, and its workgroups in a row, at most `most`, and rows.
    pub(crate) fn call(&self, blocks: &Range<usize>, workgroup: u32, most: u32) -> (Call, [u32; 2]) {
        // Checked to be less than 2^32.
        let count = (blocks.len() * BLOCK) as u32;
        let groups = count.div_ceil(workgroup);
        let across = groups.min(most);
        let call = [
            (self.blocks + blocks.start * BLOCK_WORDS) as u32,
            self.targets as u32,
            self.parts as u32,
            self.carried as u32,
            // One row never reaches it.
            across.saturating_mul(workgroup),
            count,
        ];
        (call, [across, groups.div_ceil(across)])
    }
}
