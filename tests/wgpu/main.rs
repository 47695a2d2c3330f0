//! Deformation on wgpu devices, on every Vulkan driver there is. The vertices are the CPU's (see `tests/gpu/compare.rs`), and nothing
//! else is written.

#[cfg(any(windows, target_os = "linux", target_os = "android", target_os = "freebsd"))]
mod adopted;
mod backend;
#[cfg(feature = "cli")]
mod command;
mod errors;
#[path = "../gpu/mod.rs"]
mod gpu;
mod read;
#[path = "../scenes/mod.rs"]
mod scenes;
mod translated;
