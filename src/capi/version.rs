//! Which library this is.

use std::ffi::c_char;

/// The version of this header. Libraries of another major or, before 1.0, minor version do not fit.
pub const CRUMPLE_VERSION_MAJOR: u32 = 0;

pub const CRUMPLE_VERSION_MINOR: u32 = 2;

pub const CRUMPLE_VERSION_PATCH: u32 = 0;

/// The version of this header as one number, in the format of crumple_version().
pub const CRUMPLE_VERSION: u32 = CRUMPLE_VERSION_MAJOR * 1000000 + CRUMPLE_VERSION_MINOR * 1000 + CRUMPLE_VERSION_PATCH;

/// Bits of crumple_features(): what the library was built with.
pub const CRUMPLE_FEATURE_GLTF: u64 = 1;

pub const CRUMPLE_FEATURE_OBJ: u64 = 2;

pub const CRUMPLE_FEATURE_HOST_ALLOCATOR: u64 = 4;

pub const CRUMPLE_FEATURE_VULKAN: u64 = 8;

/// A part of the package's version.
const fn number(text: &str) -> u32 {
    match u32::from_str_radix(text, 10) {
        Ok(number) => number,
        Err(_) => panic!("a version has numbers only"),
    }
}

const _: () = assert!(
    CRUMPLE_VERSION_MAJOR == number(env!("CARGO_PKG_VERSION_MAJOR"))
        && CRUMPLE_VERSION_MINOR == number(env!("CARGO_PKG_VERSION_MINOR"))
        && CRUMPLE_VERSION_PATCH == number(env!("CARGO_PKG_VERSION_PATCH")),
    "src/capi/version.rs and Cargo.toml disagree about the version"
);

/// Returns the version of the running library: major * 1000000 + minor * 1000 + patch. Compare it with CRUMPLE_VERSION.
#[unsafe(no_mangle)]
pub extern "C" fn crumple_version() -> u32 {
    CRUMPLE_VERSION
}

/// Returns the version of the running library as text, such as "0.2.0". The text stays valid for ever.
#[unsafe(no_mangle)]
pub extern "C" fn crumple_version_string() -> *const c_char {
    concat!(env!("CARGO_PKG_VERSION"), "\0").as_ptr().cast()
}

/// Returns the CRUMPLE_FEATURE_ bits of this build, combined with or. Ignore bits that you do not know.
#[unsafe(no_mangle)]
pub extern "C" fn crumple_features() -> u64 {
    let bit = |on: bool, bit: u64| if on { bit } else { 0 };
    bit(cfg!(feature = "gltf"), CRUMPLE_FEATURE_GLTF)
        | bit(cfg!(feature = "obj"), CRUMPLE_FEATURE_OBJ)
        | bit(cfg!(feature = "host-allocator"), CRUMPLE_FEATURE_HOST_ALLOCATOR)
        | CRUMPLE_FEATURE_VULKAN
}
