//! Error types. Every error names the wrong value and what would be right.

use super::memory::may_fail;

/// The coarse kind of an [`Error`]. Its number is that of the result in the C interface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ErrorKind {
    /// A value lies outside its range.
    InvalidArgument = 1,
    /// A number is NaN or infinite.
    NotFinite,
    /// An index is out of range.
    IndexOutOfRange,
    /// The base mesh cannot be used (no vertices, arrays of different lengths …).
    Mesh,
    /// An example does not fit the base mesh.
    ExampleMismatch,
    /// A buffer is smaller than the data to read from it or write to it.
    BufferTooSmall,
    /// A pointer, an offset or a stride is not a multiple of four bytes.
    Misaligned,
    /// A contact lies further from the body than the instance accepts.
    ContactTooFar,
    /// Valid input that this library does not read.
    Unsupported,
    /// Malformed input.
    Format,
    /// The operating system refused to read or write.
    Io,
    /// Saved damage belongs to another example set or another version.
    DamageMismatch,
    /// Memory ran out.
    OutOfMemory,
    /// The call is not available with the instance's rule.
    WrongRule,
    /// A call into the graphics driver failed.
    Vulkan,
    /// The graphics device is lost. Damage is kept.
    DeviceLost,
    /// A contact id that no hit opened, or that was ended.
    UnknownContact,
}

/// Any error of the library. The message names the wrong value and what would be right.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A value lies outside its range.
    #[error("{name} is {value}; it must be {expected}")]
    InvalidArgument {
        /// Name of the value in the interface.
        name: String,
        /// The value that was given.
        value: String,
        /// What would be right.
        expected: String,
    },
    /// A number is NaN or infinite.
    #[error("{name} is {value}; every component must be finite")]
    NotFinite {
        /// Name of the value, with its index if it has one.
        name: String,
        /// The value that was given.
        value: String,
    },
    /// An index is out of range.
    #[error("{name} is {index}; it must be below {len}")]
    IndexOutOfRange {
        /// Name of the index.
        name: String,
        /// The index that was given.
        index: u64,
        /// The number of elements.
        len: u64,
    },
    /// The base mesh, or one of its levels of detail, cannot be used.
    #[error("mesh: {what}")]
    Mesh {
        /// What is wrong with it and what would be right.
        what: String,
    },
    /// An example does not fit the base mesh.
    #[error("example {index} '{name}': {what}")]
    ExampleMismatch {
        /// Index of the example in the order given.
        index: usize,
        /// Its name.
        name: String,
        /// What does not fit and what would be right.
        what: String,
    },
    /// No example can be used.
    #[error("no examples: {what}")]
    NoExamples {
        /// Why none can be used and what would be right.
        what: String,
    },
    /// A buffer is smaller than the data to read from it or write to it.
    #[error("{name} holds {size} bytes; {needed} are needed")]
    BufferTooSmall {
        /// Name of the buffer.
        name: String,
        /// Its size in bytes.
        size: u64,
        /// The bytes needed.
        needed: u64,
    },
    /// A pointer, an offset or a stride is not aligned.
    #[error("{name} is {value}; it must be a multiple of {align} bytes")]
    Misaligned {
        /// What is not aligned.
        name: String,
        /// Its value.
        value: u64,
        /// The alignment needed, bytes.
        align: u64,
    },
    /// A contact lies further from the body than the instance accepts.
    #[error(
        "the contact point ({x}, {y}, {z}) lies {distance} m from the nearest vertex; at most {limit} m is accepted (max_contact_distance): is it in the right space?",
        x = point[0], y = point[1], z = point[2]
    )]
    ContactTooFar {
        /// The contact point in the mesh's space, m.
        point: [f32; 3],
        /// Its distance from the nearest vertex, m.
        distance: f32,
        /// The greatest distance accepted, m.
        limit: f32,
    },
    /// Valid input that this library does not read.
    #[error("unsupported: {what}")]
    Unsupported {
        /// What is not supported and what is.
        what: String,
    },
    /// Malformed input.
    #[error("malformed: {what}")]
    Format {
        /// What is malformed and what would be right.
        what: String,
    },
    /// The file has no mesh with that name or index.
    #[error("no mesh {wanted}; the file has {available}")]
    NoSuchMesh {
        /// The mesh asked for.
        wanted: String,
        /// The meshes in the file.
        available: String,
    },
    /// The operating system refused to read or write.
    #[error("{path}: {message}")]
    Io {
        /// The file.
        path: String,
        /// The system's message.
        message: String,
    },
    /// Saved damage belongs to another example set or another version.
    #[error("saved damage: {what}")]
    DamageMismatch {
        /// What does not match.
        what: String,
    },
    /// Memory ran out.
    #[error("out of memory: {bytes} bytes for {what}")]
    OutOfMemory {
        /// What the memory was for.
        what: String,
        /// The size asked for, bytes; 0 if unknown.
        bytes: u64,
    },
    /// The call is not available with the instance's rule.
    #[error("{call} needs {needed}; this instance's rule is {rule}")]
    WrongRule {
        /// The call.
        call: String,
        /// The rule it needs.
        needed: String,
        /// The instance's rule.
        rule: String,
    },
    /// A contact id that no hit has, or that was ended.
    #[error("contact_id is {id}; it must be that of hits of this instance whose contact was not ended")]
    UnknownContact {
        /// The id.
        id: u64,
    },
    /// A call into the graphics driver failed.
    #[error("{call} answers {result}")]
    Vulkan {
        /// The Vulkan function.
        call: String,
        /// The result it returned.
        result: String,
    },
    /// A call to wgpu failed.
    #[error("{call}: wgpu says: {what}")]
    Wgpu {
        /// The function called.
        call: String,
        /// The message from wgpu.
        what: String,
    },
    /// The graphics device is lost. Damage is kept: register the same instances with a new device.
    #[error("{call} says that the device is lost; damage is not: make another device and register its buffers there")]
    DeviceLost {
        /// The function that reported it.
        call: String,
    },
}

impl Error {
    /// The coarse kind, for callers that only branch on it.
    pub fn kind(&self) -> ErrorKind {
        match self {
            Error::InvalidArgument { .. } => ErrorKind::InvalidArgument,
            Error::NotFinite { .. } => ErrorKind::NotFinite,
            Error::IndexOutOfRange { .. } => ErrorKind::IndexOutOfRange,
            Error::Mesh { .. } => ErrorKind::Mesh,
            Error::ExampleMismatch { .. } | Error::NoExamples { .. } => ErrorKind::ExampleMismatch,
            Error::BufferTooSmall { .. } => ErrorKind::BufferTooSmall,
            Error::Misaligned { .. } => ErrorKind::Misaligned,
            Error::ContactTooFar { .. } => ErrorKind::ContactTooFar,
            Error::Unsupported { .. } => ErrorKind::Unsupported,
            Error::Format { .. } | Error::NoSuchMesh { .. } => ErrorKind::Format,
            Error::Io { .. } => ErrorKind::Io,
            Error::DamageMismatch { .. } => ErrorKind::DamageMismatch,
            Error::OutOfMemory { .. } => ErrorKind::OutOfMemory,
            Error::WrongRule { .. } => ErrorKind::WrongRule,
            Error::UnknownContact { .. } => ErrorKind::UnknownContact,
            Error::Vulkan { .. } | Error::Wgpu { .. } => ErrorKind::Vulkan,
            Error::DeviceLost { .. } => ErrorKind::DeviceLost,
        }
    }

    pub(crate) fn invalid(name: &str, value: impl std::fmt::Display, expected: &str) -> Self {
        Error::InvalidArgument { name: name.into(), value: value.to_string(), expected: expected.into() }
    }
}

/// Fails unless `x` is finite and above 0. The message ends with `unit`.
pub(crate) fn positive(name: &str, x: f32, unit: &str) -> Result<(), Error> {
    if x > 0.0 && x.is_finite() { Ok(()) } else { Err(Error::invalid(name, x, &format!("above 0 and finite, {unit}"))) }
}

/// Fails if `x` is negative or not finite. The message ends with `unit`.
pub(crate) fn at_least_zero(name: &str, x: f32, unit: &str) -> Result<(), Error> {
    if x >= 0.0 && x.is_finite() {
        Ok(())
    } else {
        Err(Error::invalid(name, x, &format!("at least 0 and finite, {unit}")))
    }
}

/// Returns an empty vector with room for `n` elements, or [`Error::OutOfMemory`]. For allocations whose size depends on
/// the caller's input.
pub(crate) fn reserve<T>(n: usize, what: &str) -> Result<Vec<T>, Error> {
    let mut v = Vec::new();
    may_fail(|| v.try_reserve_exact(n)).map_err(|_| Error::OutOfMemory {
        what: what.into(),
        bytes: (n as u64).saturating_mul(std::mem::size_of::<T>() as u64),
    })?;
    Ok(v)
}
