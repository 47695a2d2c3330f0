//! Link arguments of the shared C library: its name for the loader, and that it stays loaded, since its threads may still be
//! ending when a host unloads it. On Windows the library does the latter itself (`capi/context.rs`). With the feature
//! `vulkan` or `wgpu` it compiles the kernels in `src/gpu`.

#[cfg(feature = "gpu")]
#[path = "build/kernels.rs"]
mod kernels;
#[cfg(feature = "gpu")]
#[path = "build/layout.rs"]
mod layout;
#[cfg(feature = "gpu")]
#[path = "build/spirv.rs"]
mod spirv;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=build");
    // Cargo also hands these arguments to dynamic libraries that use this one as a crate (rust-lang/cargo#9562). Those have a
    // name of their own, and may be unloaded. Only builds with the C interface are the C library.
    let target = std::env::var("CARGO_CFG_TARGET_OS").unwrap_or_default();
    let c_library = std::env::var_os("CARGO_FEATURE_CAPI").is_some();
    if c_library && target == "linux" {
        // The part of the version that a program built against it depends on: before 1.0 the minor number too.
        let (major, minor) = (env!("CARGO_PKG_VERSION_MAJOR"), env!("CARGO_PKG_VERSION_MINOR"));
        let version = if major == "0" { format!("{major}.{minor}") } else { major.to_owned() };
        println!("cargo::rustc-cdylib-link-arg=-Wl,-soname,libcrumple.so.{version}");
        println!("cargo::rustc-cdylib-link-arg=-Wl,-z,nodelete");
    }
    if c_library && target == "macos" {
        // The compiler's name is a path of the machine that built it; this one is looked for where the program says.
        println!("cargo::rustc-cdylib-link-arg=-Wl,-install_name,@rpath/libcrumple.dylib");
    }
    #[cfg(feature = "gpu")]
    kernels::build();
}
