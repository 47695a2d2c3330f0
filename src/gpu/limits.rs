//! How much of a buffer a device can bind.

use crate::Error;

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

impl BindingLimits {
    /// Fails if `bytes` bytes cannot be bound.
    pub(crate) fn check(&self, what: &str, bytes: u64) -> Result<(), Error> {
        if bytes <= self.bytes { Ok(()) } else { Err(self.exceeded(&format!("{what} of {bytes} bytes"))) }
    }

    pub(super) fn exceeded(&self, what: &str) -> Error {
        Error::Unsupported { what: format!("{what}; {} is {} on this device", self.name, self.bytes) }
    }
}
