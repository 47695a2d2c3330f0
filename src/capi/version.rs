//! Which library this is.

use std::ffi::c_char;

/// Major version of this header. Programs built against another major version do not fit.
pub const CRUMPLE_VERSION_MAJOR: u32 = 0;

/// Minor version of this header. Before 1.0, programs built against another minor version do not fit.
pub const CRUMPLE_VERSION_MINOR: u32 = 1;

/// Patch version of this header.
pub const CRUMPLE_VERSION_PATCH: u32 = 0;

/// The three as one number, as crumple_version() gives it.
pub const CRUMPLE_VERSION: u32 = CRUMPLE_VERSION_MAJOR * 1000000 + CRUMPLE_VERSION_MINOR * 1000 + CRUMPLE_VERSION_PATCH;

/// Bit of crumple_features(): glTF 2.0 and GLB files can be loaded.
pub const CRUMPLE_FEATURE_GLTF: u64 = 1;

/// Bit of crumple_features(): OBJ files can be loaded.
pub const CRUMPLE_FEATURE_OBJ: u64 = 2;

/// Bit of crumple_features(): crumple_allocator_set() works.
pub const CRUMPLE_FEATURE_HOST_ALLOCATOR: u64 = 4;

/// Bit of crumple_features(): crumple_vulkan_attach() works.
pub const CRUMPLE_FEATURE_VULKAN: u64 = 8;

/// Evaluates to 0..=9 digits as a number; the package's version in a constant.
const fn number(text: &str) -> u32 {
    let (bytes, mut value, mut i) = (text.as_bytes(), 0, 0);
    while i < bytes.len() {
        value = value * 10 + (bytes[i] - b'0') as u32;
        i += 1;
    }
    value
}

const _: () = assert!(
    CRUMPLE_VERSION_MAJOR == number(env!("CARGO_PKG_VERSION_MAJOR"))
        && CRUMPLE_VERSION_MINOR == number(env!("CARGO_PKG_VERSION_MINOR"))
        && CRUMPLE_VERSION_PATCH == number(env!("CARGO_PKG_VERSION_PATCH")),
    "src/capi/version.rs and Cargo.toml disagree about the version"
);

/// The version of the library that runs: major * 1000000 + minor * 1000 + patch. Compare it with CRUMPLE_VERSION,
/// that of the header you compiled against. Never fails; any thread.
#[unsafe(no_mangle)]
pub extern "C" fn crumple_version() -> u32 {
    CRUMPLE_VERSION
}

/// The version of the library that runs as text, such as "0.1.0". Lives for ever. Never fails; any thread.
#[unsafe(no_mangle)]
pub extern "C" fn crumple_version_string() -> *const c_char {
    concat!(env!("CARGO_PKG_VERSION"), "\0").as_ptr().cast()
}

/// What this build of the library can do: the CRUMPLE_FEATURE_ bits, or-ed. Bits unknown to you may be set. Never
/// fails; any thread.
#[unsafe(no_mangle)]
pub extern "C" fn crumple_features() -> u64 {
    let bit = |on: bool, bit: u64| if on { bit } else { 0 };
    bit(cfg!(feature = "gltf"), CRUMPLE_FEATURE_GLTF)
        | bit(cfg!(feature = "obj"), CRUMPLE_FEATURE_OBJ)
        | bit(cfg!(feature = "host-allocator"), CRUMPLE_FEATURE_HOST_ALLOCATOR)
        | bit(cfg!(feature = "vulkan"), CRUMPLE_FEATURE_VULKAN)
}
