//! The SPIR-V of the kernels, and the changes to it that make a variant.

use super::kernel::Variant;

/// In the order of [`Variant::source`].
#[cfg(feature = "vulkan")]
const MODULES: [Module; 2] = include!(concat!(env!("OUT_DIR"), "/vulkan_modules.rs"));

/// Returns the SPIR-V of a variant for hosts that ask for so many invocations a workgroup.
#[cfg(feature = "vulkan")]
pub(crate) fn compiled(variant: Variant, invocations: u32) -> Vec<u32> {
    MODULES[variant.source()].compiled(variant, variant.invocations(invocations))
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
