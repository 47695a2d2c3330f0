//! Limits of a device: the bytes that it can bind, and the size of workgroups.

use super::BLOCK_VERTICES;
use crate::base::error::Error;

/// A device's limits on bound storage buffers.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BindingLimits {
    /// The largest binding in bytes, a multiple of 4.
    pub bytes: u64,
    /// The name of that limit in the graphics interface.
    pub name: &'static str,
    /// Alignment of a binding's offset in bytes, a multiple of 4.
    pub alignment: u64,
}

/// The smallest buffer for the data of a frame in bytes.
const SMALLEST_FRAME: u64 = 64 << 10;

/// Checks the invocations a workgroup. `most` is the largest size that the device supports.
pub(crate) fn check_workgroup_size(size: u32, most: u32) -> Result<(), Error> {
    // A workgroup lies within one block.
    let most = most.min(BLOCK_VERTICES);
    if !size.is_power_of_two() || !(32..=most).contains(&size) {
        return Err(Error::invalid("workgroup_size", size, &format!("a power of two, 32 to {most}")));
    }
    Ok(())
}

impl BindingLimits {
    /// The size of a new buffer for the data of a frame, which needs `bytes` bytes. It leaves room to grow.
    pub(crate) fn frame_buffer_size(&self, bytes: u64) -> u64 {
        bytes.next_power_of_two().max(SMALLEST_FRAME).min(self.bytes)
    }

    /// Fails if `bytes` bytes cannot be bound.
    pub(crate) fn check(&self, what: &str, bytes: u64) -> Result<(), Error> {
        if bytes <= self.bytes { Ok(()) } else { Err(self.exceeded(&format!("{what} of {bytes} bytes"))) }
    }

    pub(super) fn exceeded(&self, what: &str) -> Error {
        Error::Unsupported { what: format!("{what}; {} is {} on this device", self.name, self.bytes) }
    }
}
