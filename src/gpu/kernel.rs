//! The kernels, the variants in which they are compiled, and their SPIR-V.

use super::BLOCK_VERTICES;

/// The attributes that a kernel writes. Each kernel writes those of the kernels before it too.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Kernel {
    Positions,
    Normals,
    Tangents,
}

/// What moves the vertices, in the order of the sources in build/kernels.rs.
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
        let of = |packed, case| {
            [Kernel::Positions, Kernel::Normals, Kernel::Tangents].map(|kernel| Variant { kernel, case, packed })
        };
        [false, true].into_iter().flat_map(move |packed| [of(packed, Case::Nodes), of(packed, Case::Classic)]).flatten()
    }

    /// Index among all variants.
    #[cfg(feature = "vulkan")]
    pub(crate) fn number(self) -> u32 {
        (0..).zip(Self::all()).find(|(_, variant)| *variant == self).map_or(u32::MAX, |(number, _)| number)
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

/// In the order of [`Case`].
#[cfg(feature = "vulkan")]
const MODULES: [Module; 2] = include!(concat!(env!("OUT_DIR"), "/vulkan_modules.rs"));

/// Returns the SPIR-V of a variant for hosts that ask for so many invocations a workgroup.
#[cfg(feature = "vulkan")]
pub(crate) fn compiled(variant: Variant, invocations: u32) -> Vec<u32> {
    MODULES[variant.case as usize].compiled(variant, variant.invocations(invocations))
}

/// The SPIR-V of a source.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Module {
    /// With all overrides on.
    pub words: &'static [u8],
    /// For each override the words to change where it is off: index and value.
    pub off: &'static [(&'static str, &'static [(u32, u32)])],
}

impl Module {
    /// Returns the words of a variant with this number of invocations a workgroup.
    pub(crate) fn compiled(&self, variant: Variant, invocations: u32) -> Vec<u32> {
        const HEADER: usize = 5;
        const EXECUTION_MODE: u32 = 16;
        let bytes = self.words.chunks_exact(4);
        let mut words: Vec<u32> = bytes.map(|w| u32::from_le_bytes([w[0], w[1], w[2], w[3]])).collect();
        for (_, changes) in self.off.iter().filter(|(name, _)| !variant.on(name)) {
            changes.iter().for_each(|(at, word)| words[*at as usize] = *word);
        }
        let mut at = HEADER;
        while words[at] & 0xFFFF != EXECUTION_MODE {
            at += (words[at] >> 16) as usize;
        }
        // LocalSize: entry point, mode, x, y, z.
        words[at + 3] = invocations;
        words
    }
}
