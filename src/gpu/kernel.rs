//! The kernels. Each comes in three cases.

/// The attributes that a kernel writes. Each kernel writes those of the kernels before it too.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Kernel {
    Positions,
    Normals,
    Tangents,
}

/// What moves the vertices. Without look-ups in stamps a kernel needs fewer registers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Case {
    /// Marks, none of them with a carried example.
    Anchored,
    /// Any marks.
    Marks,
    Classic,
}

impl Kernel {
    /// Number of kernels in all.
    pub(crate) const COUNT: usize = 9;

    /// Index among all kernels: three of each case.
    pub(crate) fn number(self, case: Case) -> usize {
        self as usize + 3 * case as usize
    }

    /// Bytes a vertex of a classic rule's state.
    pub(crate) fn state_bytes(self) -> u64 {
        if self > Kernel::Positions { 24 } else { 12 }
    }
}
