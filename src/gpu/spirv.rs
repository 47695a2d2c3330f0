//! Sets the workgroup size in the SPIR-V of a kernel.

/// Returns the words of a module with this number of invocations a workgroup.
pub(crate) fn with_workgroup(module: &[u8], invocations: u32) -> Vec<u32> {
    const HEADER: usize = 5;
    const EXECUTION_MODE: u32 = 16;
    let mut words: Vec<u32> = module.chunks_exact(4).map(|w| u32::from_le_bytes([w[0], w[1], w[2], w[3]])).collect();
    let mut at = HEADER;
    while words[at] & 0xFFFF != EXECUTION_MODE {
        at += (words[at] >> 16) as usize;
    }
    // LocalSize: entry point, mode, x, y, z.
    words[at + 3] = invocations;
    words
}
