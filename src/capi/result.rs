//! What a call answers: a result, and a text that names what was wrong.

use super::c_enum::number;
use crate::base::error::Error;
use std::cell::RefCell;
use std::ffi::{CStr, c_char};
use std::mem::MaybeUninit;

/// cbindgen:rename-all=ScreamingSnakeCase
/// The result of a call. See "Results" at the top.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(clippy::enum_variant_names)] // the C names
pub enum CrumpleResult {
    CrumpleOk = 0,
    /// A number outside its range, no enumerator, a stride that is too small, streams that overlap, text that is not
    /// UTF-8, or a call that is not allowed in the current state.
    CrumpleErrorInvalidArgument = 1,
    CrumpleErrorNotFinite = 2,
    CrumpleErrorIndexOutOfRange = 3,
    /// The base mesh cannot be used.
    CrumpleErrorMesh = 4,
    /// An example does not fit the base mesh, or there is no example.
    CrumpleErrorExampleMismatch = 5,
    /// An array has fewer bytes or elements than the call needs.
    CrumpleErrorBufferTooSmall = 6,
    /// A pointer, offset or stride is not a multiple of its alignment.
    CrumpleErrorMisaligned = 7,
    /// A hit is further from the body than max_contact_distance. Often its point is in the wrong space.
    CrumpleErrorContactTooFar = 8,
    /// The input is valid, but this library or this build does not support it.
    CrumpleErrorUnsupported = 9,
    /// A file is malformed, or bytes in memory are.
    CrumpleErrorFormat = 10,
    /// The system refused to read or write a file.
    CrumpleErrorIo = 11,
    /// The damage belongs to another example set, rule or version.
    CrumpleErrorDamageMismatch = 12,
    CrumpleErrorOutOfMemory = 13,
    /// The call does not work with the instance's rule.
    CrumpleErrorWrongRule = 14,
    CrumpleErrorVulkan = 15,
    /// The Vulkan device is lost. Damage is not lost.
    CrumpleErrorDeviceLost = 16,
    /// A contact id that no hit has, or that was ended.
    CrumpleErrorUnknownContact = 17,
    CrumpleErrorNullPointer = 64,
    /// The struct_size of a def is wrong. Start from the def's crumple_..._def_default function.
    CrumpleErrorStructSize = 65,
    /// An id is null or of another context, or its object or the context was destroyed.
    CrumpleErrorInvalidId = 66,
    /// Two threads used one context at once, or a callback called back into its context.
    CrumpleErrorConcurrentUse = 67,
    /// A defect of the library. Please report it with the text of crumple_last_error().
    CrumpleErrorInternal = 68,
    /// Recorded frames were not reported to crumple_vulkan_complete_frames().
    CrumpleErrorFramesInFlight = 69,
}

/// All results with their names.
const NAMES: [(CrumpleResult, &CStr); 24] = {
    use CrumpleResult::*;
    [
        (CrumpleOk, c"CRUMPLE_OK"),
        (CrumpleErrorInvalidArgument, c"CRUMPLE_ERROR_INVALID_ARGUMENT"),
        (CrumpleErrorNotFinite, c"CRUMPLE_ERROR_NOT_FINITE"),
        (CrumpleErrorIndexOutOfRange, c"CRUMPLE_ERROR_INDEX_OUT_OF_RANGE"),
        (CrumpleErrorMesh, c"CRUMPLE_ERROR_MESH"),
        (CrumpleErrorExampleMismatch, c"CRUMPLE_ERROR_EXAMPLE_MISMATCH"),
        (CrumpleErrorBufferTooSmall, c"CRUMPLE_ERROR_BUFFER_TOO_SMALL"),
        (CrumpleErrorMisaligned, c"CRUMPLE_ERROR_MISALIGNED"),
        (CrumpleErrorContactTooFar, c"CRUMPLE_ERROR_CONTACT_TOO_FAR"),
        (CrumpleErrorUnsupported, c"CRUMPLE_ERROR_UNSUPPORTED"),
        (CrumpleErrorFormat, c"CRUMPLE_ERROR_FORMAT"),
        (CrumpleErrorIo, c"CRUMPLE_ERROR_IO"),
        (CrumpleErrorDamageMismatch, c"CRUMPLE_ERROR_DAMAGE_MISMATCH"),
        (CrumpleErrorOutOfMemory, c"CRUMPLE_ERROR_OUT_OF_MEMORY"),
        (CrumpleErrorWrongRule, c"CRUMPLE_ERROR_WRONG_RULE"),
        (CrumpleErrorVulkan, c"CRUMPLE_ERROR_VULKAN"),
        (CrumpleErrorDeviceLost, c"CRUMPLE_ERROR_DEVICE_LOST"),
        (CrumpleErrorUnknownContact, c"CRUMPLE_ERROR_UNKNOWN_CONTACT"),
        (CrumpleErrorNullPointer, c"CRUMPLE_ERROR_NULL_POINTER"),
        (CrumpleErrorStructSize, c"CRUMPLE_ERROR_STRUCT_SIZE"),
        (CrumpleErrorInvalidId, c"CRUMPLE_ERROR_INVALID_ID"),
        (CrumpleErrorConcurrentUse, c"CRUMPLE_ERROR_CONCURRENT_USE"),
        (CrumpleErrorInternal, c"CRUMPLE_ERROR_INTERNAL"),
        (CrumpleErrorFramesInFlight, c"CRUMPLE_ERROR_FRAMES_IN_FLIGHT"),
    ]
};

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

    pub(super) fn null(name: &str) -> Self {
        Self::null_pointer(format!("{name} is null"))
    }

    pub(super) fn null_pointer(message: impl Into<String>) -> Self {
        Self::new(CrumpleResult::CrumpleErrorNullPointer, message)
    }

    pub(super) fn mesh(what: impl Into<String>) -> Self {
        Error::Mesh { what: what.into() }.into()
    }

    #[cfg(not(all(feature = "gltf", feature = "obj")))]
    pub(super) fn not_built(feature: &str) -> Self {
        let message = format!("this build cannot: build the library with the feature {feature}");
        Self::new(CrumpleResult::CrumpleErrorUnsupported, message)
    }

    pub(super) fn out_of_memory(what: &str) -> Self {
        Self::new(CrumpleResult::CrumpleErrorOutOfMemory, format!("no memory for {what}"))
    }

    pub(super) fn invalid(message: impl Into<String>) -> Self {
        Self::new(CrumpleResult::CrumpleErrorInvalidArgument, message)
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        let numbered = NAMES.iter().find(|(result, _)| *result as u32 == error.kind() as u32);
        Self::new(numbered.map_or(CrumpleResult::CrumpleErrorInternal, |(result, _)| *result), error.to_string())
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

/// Returns the message of the calling thread's last failed call, UTF-8: "crumple_instance_create: ...". It names the
/// wrong value and what would be right. Empty before the first failure; calls that succeed leave it unchanged. Valid
/// until the thread's next failed call; at most 1023 bytes, never null.
#[unsafe(no_mangle)]
pub extern "C" fn crumple_last_error() -> *const c_char {
    // A thread that is ending has lost its text already.
    LAST_ERROR.try_with(|text| text.as_ptr().cast::<c_char>().cast_const()).unwrap_or(c"".as_ptr())
}

/// Returns the name of a result, such as "CRUMPLE_ERROR_FORMAT", or "unknown result". The text stays valid for ever.
#[unsafe(no_mangle)]
pub extern "C" fn crumple_result_name(result: MaybeUninit<CrumpleResult>) -> *const c_char {
    let number = number(result);
    let found = NAMES.iter().find(|(known, _)| *known as u32 == number);
    found.map_or(c"unknown result", |(_, name)| name).as_ptr()
}
