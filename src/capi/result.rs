//! What a call answers: a result, and a text that names what was wrong.

use super::check::CEnum;
use crate::ErrorKind;
use std::cell::RefCell;
use std::ffi::c_char;
use std::mem::MaybeUninit;

/// cbindgen:rename-all=ScreamingSnakeCase
/// What every fallible call returns. After anything but CRUMPLE_OK no output was written, crumple_last_error() tells
/// what was wrong and what would be right, and everything stays usable.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(clippy::enum_variant_names)] // the C names
pub enum CrumpleResult {
    /// The call did what it says.
    CrumpleOk = 0,
    /// A value lies outside its range.
    CrumpleErrorInvalidArgument = 1,
    /// A number is NaN or infinite.
    CrumpleErrorNotFinite = 2,
    /// An index points past the end of what it indexes.
    CrumpleErrorIndexOutOfRange = 3,
    /// The base mesh cannot be used.
    CrumpleErrorMesh = 4,
    /// An example does not fit the base mesh, or there is no example.
    CrumpleErrorExampleMismatch = 5,
    /// Memory is smaller than what must be read from it or written to it.
    CrumpleErrorBufferTooSmall = 6,
    /// A pointer, an offset or a stride is not a multiple of the alignment it needs.
    CrumpleErrorMisaligned = 7,
    /// A contact lies further from the body than the instance accepts: often a point in the wrong space.
    CrumpleErrorContactTooFar = 8,
    /// Valid input that this library, or this build of it, does not read.
    CrumpleErrorUnsupported = 9,
    /// A file or saved bytes are malformed.
    CrumpleErrorFormat = 10,
    /// The operating system refused to read or write a file.
    CrumpleErrorIo = 11,
    /// Damage belongs to another example set or to another version.
    CrumpleErrorDamageMismatch = 12,
    /// Memory ran out. Only memory whose size your counts decide is reported so; see "Memory" at the top of the
    /// header.
    CrumpleErrorOutOfMemory = 13,
    /// The call does not fit the instance's rule.
    CrumpleErrorWrongRule = 14,
    /// A call into the graphics driver failed.
    CrumpleErrorVulkan = 15,
    /// The graphics device is lost. Damage is not.
    CrumpleErrorDeviceLost = 16,
    /// A pointer is null that must not be.
    CrumpleErrorNullPointer = 64,
    /// The struct_size of a def is that of no version: take defs from their crumple_..._def_default function.
    CrumpleErrorStructSize = 65,
    /// An id or a context is null, was destroyed, or belongs to another context; the text says which.
    CrumpleErrorInvalidId = 66,
    /// Two threads were inside the same context at once, or a callback called back into it.
    CrumpleErrorConcurrentUse = 67,
    /// A defect of the library; the text is its message. Please report it.
    CrumpleErrorInternal = 68,
    /// Frames were recorded that crumple_vulkan_complete_frames() was not told of.
    CrumpleErrorFramesInFlight = 69,
}

impl CEnum for CrumpleResult {
    const ALL: &'static [Self] = {
        use CrumpleResult::*;
        &[
            CrumpleOk,
            CrumpleErrorInvalidArgument,
            CrumpleErrorNotFinite,
            CrumpleErrorIndexOutOfRange,
            CrumpleErrorMesh,
            CrumpleErrorExampleMismatch,
            CrumpleErrorBufferTooSmall,
            CrumpleErrorMisaligned,
            CrumpleErrorContactTooFar,
            CrumpleErrorUnsupported,
            CrumpleErrorFormat,
            CrumpleErrorIo,
            CrumpleErrorDamageMismatch,
            CrumpleErrorOutOfMemory,
            CrumpleErrorWrongRule,
            CrumpleErrorVulkan,
            CrumpleErrorDeviceLost,
            CrumpleErrorNullPointer,
            CrumpleErrorStructSize,
            CrumpleErrorInvalidId,
            CrumpleErrorConcurrentUse,
            CrumpleErrorInternal,
            CrumpleErrorFramesInFlight,
        ]
    };
}

/// Why a call failed.
#[derive(Debug)]
pub(super) struct Failure {
    pub(super) result: CrumpleResult,
    pub(super) message: String,
}

impl Failure {
    pub(super) fn new(result: CrumpleResult, message: impl Into<String>) -> Self {
        Self { result, message: message.into() }
    }

    pub(super) fn invalid(message: impl Into<String>) -> Self {
        Self::new(CrumpleResult::CrumpleErrorInvalidArgument, message)
    }
}

impl From<crate::Error> for Failure {
    fn from(error: crate::Error) -> Self {
        use CrumpleResult::*;
        let result = match error.kind() {
            ErrorKind::InvalidArgument => CrumpleErrorInvalidArgument,
            ErrorKind::NotFinite => CrumpleErrorNotFinite,
            ErrorKind::IndexOutOfRange => CrumpleErrorIndexOutOfRange,
            ErrorKind::Mesh => CrumpleErrorMesh,
            ErrorKind::ExampleMismatch => CrumpleErrorExampleMismatch,
            ErrorKind::BufferTooSmall => CrumpleErrorBufferTooSmall,
            ErrorKind::Misaligned => CrumpleErrorMisaligned,
            ErrorKind::ContactTooFar => CrumpleErrorContactTooFar,
            ErrorKind::Unsupported => CrumpleErrorUnsupported,
            ErrorKind::Format => CrumpleErrorFormat,
            ErrorKind::Io => CrumpleErrorIo,
            ErrorKind::DamageMismatch => CrumpleErrorDamageMismatch,
            ErrorKind::OutOfMemory => CrumpleErrorOutOfMemory,
            ErrorKind::WrongRule => CrumpleErrorWrongRule,
            ErrorKind::Vulkan => CrumpleErrorVulkan,
            ErrorKind::DeviceLost => CrumpleErrorDeviceLost,
        };
        Self::new(result, error.to_string())
    }
}

/// Bytes of the last error's text, its final zero among them. In place, so that it can be written when memory ran out
/// and nothing is left behind when a thread ends.
const TEXT: usize = 1024;

thread_local! {
    static LAST_ERROR: RefCell<[u8; TEXT]> = const { RefCell::new([0; TEXT]) };
}

/// Keeps the text for `crumple_last_error`: "call: message", cut at a character's border, zeros inside made visible.
pub(super) fn remember(call: &str, message: &str) {
    LAST_ERROR.with_borrow_mut(|text| {
        let mut len = 0;
        for character in call.chars().chain(": ".chars()).chain(message.chars()) {
            let character = if character == '\0' { '\u{fffd}' } else { character };
            if len + character.len_utf8() >= TEXT {
                break;
            }
            character.encode_utf8(&mut text[len..]);
            len += character.len_utf8();
        }
        text[len] = 0;
    });
}

/// What was wrong in the calling thread's last failed call, and what would be right, as UTF-8:
/// "crumple_instance_create: ...". Empty before the first failure; a call that succeeds leaves it. Valid until the
/// thread's next failed call. At most 1023 bytes. Never null, never fails; any thread, each has its own text.
#[unsafe(no_mangle)]
pub extern "C" fn crumple_last_error() -> *const c_char {
    // A thread that is ending has lost its text already.
    LAST_ERROR.try_with(|text| text.as_ptr().cast::<c_char>().cast_const()).unwrap_or(c"".as_ptr())
}

/// The name of a result, such as "CRUMPLE_ERROR_FORMAT"; "unknown result" for a number that is none. Lives for ever.
/// Never fails; any thread.
#[unsafe(no_mangle)]
pub extern "C" fn crumple_result_name(result: MaybeUninit<CrumpleResult>) -> *const c_char {
    use CrumpleResult::*;
    let Some(result) = CrumpleResult::read(result) else { return c"unknown result".as_ptr() };
    match result {
        CrumpleOk => c"CRUMPLE_OK",
        CrumpleErrorInvalidArgument => c"CRUMPLE_ERROR_INVALID_ARGUMENT",
        CrumpleErrorNotFinite => c"CRUMPLE_ERROR_NOT_FINITE",
        CrumpleErrorIndexOutOfRange => c"CRUMPLE_ERROR_INDEX_OUT_OF_RANGE",
        CrumpleErrorMesh => c"CRUMPLE_ERROR_MESH",
        CrumpleErrorExampleMismatch => c"CRUMPLE_ERROR_EXAMPLE_MISMATCH",
        CrumpleErrorBufferTooSmall => c"CRUMPLE_ERROR_BUFFER_TOO_SMALL",
        CrumpleErrorMisaligned => c"CRUMPLE_ERROR_MISALIGNED",
        CrumpleErrorContactTooFar => c"CRUMPLE_ERROR_CONTACT_TOO_FAR",
        CrumpleErrorUnsupported => c"CRUMPLE_ERROR_UNSUPPORTED",
        CrumpleErrorFormat => c"CRUMPLE_ERROR_FORMAT",
        CrumpleErrorIo => c"CRUMPLE_ERROR_IO",
        CrumpleErrorDamageMismatch => c"CRUMPLE_ERROR_DAMAGE_MISMATCH",
        CrumpleErrorOutOfMemory => c"CRUMPLE_ERROR_OUT_OF_MEMORY",
        CrumpleErrorWrongRule => c"CRUMPLE_ERROR_WRONG_RULE",
        CrumpleErrorVulkan => c"CRUMPLE_ERROR_VULKAN",
        CrumpleErrorDeviceLost => c"CRUMPLE_ERROR_DEVICE_LOST",
        CrumpleErrorNullPointer => c"CRUMPLE_ERROR_NULL_POINTER",
        CrumpleErrorStructSize => c"CRUMPLE_ERROR_STRUCT_SIZE",
        CrumpleErrorInvalidId => c"CRUMPLE_ERROR_INVALID_ID",
        CrumpleErrorConcurrentUse => c"CRUMPLE_ERROR_CONCURRENT_USE",
        CrumpleErrorInternal => c"CRUMPLE_ERROR_INTERNAL",
        CrumpleErrorFramesInFlight => c"CRUMPLE_ERROR_FRAMES_IN_FLIGHT",
    }
    .as_ptr()
}
