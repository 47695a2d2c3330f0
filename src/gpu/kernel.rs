//! The kernels. Each comes for marks and for the classic rules.

/// The attributes that a kernel writes. Each kernel writes those of the kernels before it too.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Kernel {
    Positions,
    Normals,
    Tangents,
}

impl Kernel {
    /// Index among all kernels: three for marks, then three for the classic rules.
    pub(crate) fn number(self, classic: bool) -> usize {
        self as usize + if classic { 3 } else { 0 }
    }

    /// Bytes a vertex of a classic rule's state.
    pub(crate) fn state_bytes(self) -> u64 {
        if self > Kernel::Positions { 24 } else { 12 }
    }
}
