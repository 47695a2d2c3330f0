//! The kernels, and the variants in which they are compiled.

use super::BLOCK_VERTICES;

/// The attributes that a kernel writes. Each kernel writes those of the kernels before it too.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Kernel {
    Positions,
    Normals,
    Tangents,
}

/// What moves the vertices.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Case {
    /// Vertices follow nodes.
    Nodes,
    Classic,
}

impl Kernel {
    /// Bytes a vertex of a classic rule's state.
    pub(crate) fn state_bytes(self) -> u64 {
        if self > Kernel::Positions { 24 } else { 12 }
    }
}

/// What a kernel is compiled for. What it cannot do takes no instructions and no registers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Variant {
    pub kernel: Kernel,
    pub case: Case,
    /// Whether an output has another format than 32-bit floats.
    pub packed: bool,
}

impl Variant {
    /// All variants, in the order of their numbers.
    #[cfg(feature = "vulkan")]
    pub(crate) fn all() -> impl Iterator<Item = Variant> {
        let cases = [Case::Nodes, Case::Classic].into_iter();
        let both = [false, true].into_iter().flat_map(move |packed| cases.clone().map(move |case| (packed, case)));
        let kernels = [Kernel::Positions, Kernel::Normals, Kernel::Tangents];
        both.flat_map(move |(packed, case)| kernels.map(|kernel| Variant { kernel, case, packed }))
    }

    /// Index among all variants.
    pub(crate) fn number(self) -> usize {
        self.kernel as usize + 3 * self.case as usize + 6 * usize::from(self.packed)
    }

    /// The number of its source in build/kernels.rs.
    pub(crate) fn source(self) -> usize {
        self.case as usize
    }

    /// Vertices that an invocation computes.
    fn vertices_each(self) -> u32 {
        match self.case {
            Case::Nodes => 2,
            Case::Classic => 1,
        }
    }

    /// Invocations a workgroup where the host asks for so many: a workgroup lies within one block.
    pub(crate) fn invocations(self, asked: u32) -> u32 {
        asked.min(BLOCK_VERTICES / self.vertices_each())
    }

    /// Vertices of a workgroup of as many invocations as the host asks for.
    pub(crate) fn vertices(self, asked: u32) -> u32 {
        self.invocations(asked) * self.vertices_each()
    }

    /// Whether an override of the sources is on.
    pub(crate) fn on(self, name: &str) -> bool {
        match name {
            "NORMALS" => self.kernel >= Kernel::Normals,
            "TANGENTS" => self.kernel == Kernel::Tangents,
            _ => self.packed,
        }
    }
}

#[cfg(all(test, feature = "vulkan"))]
mod tests {
    use super::*;

    #[test]
    fn numbers_count_the_variants() {
        assert!(Variant::all().map(Variant::number).eq(0..12));
    }
}
