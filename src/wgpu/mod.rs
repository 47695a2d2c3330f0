//! Deformation on `wgpu` devices: the host's own, a Vulkan device of an engine, or one made here, which may be Vulkan, Metal
//! or D3D12.
//!
//! 1. [`Device::new`] takes the host's [`wgpu::Device`] and [`wgpu::Queue`], [`Device::headless`] makes its own, and
//!    [`Device::adopt`] wraps an engine's VkDevice.
//! 2. [`Device::add_target`]: where in a [`wgpu::Buffer`] one mesh's vertices lie, and in which formats.
//! 3. [`Device::encode`], once a frame, into the host's command encoder, or [`Device::submit`]: everything that changed
//!    since, of all targets. One copy, and a dispatch for each buffer; nothing waits for the device.
//!
//! Engines with a Vulkan command buffer at hand should rather record into that: [`crate::vulkan`](../vulkan/index.html), which is smaller, costs less
//! a frame and gives the CPU's bits on more devices.
//!
//! # What the device needs
//! Compute shaders, four storage buffers a stage and three bind groups: what WebGPU guarantees, and no feature. Numbers that
//! differ from dispatch to dispatch go by a uniform buffer for that reason, and not by immediates (push constants).
//!
//! # How exact it is
//! The kernels are those of the Vulkan way, from the same WGSL. Vulkan devices with [`wgpu::Features::PASSTHROUGH_SHADERS`]
//! get the very same SPIR-V, and vertices that are what [`crate::deform`] writes, by bits, where the device rounds additions,
//! multiplications, divisions and square roots as IEEE 754 says (lavapipe and SwiftShader do). Devices that are made or adopted
//! here have that feature; a host that wants it asks for it when it makes its own.
//!
//! Other devices get the WGSL, translated by wgpu, which does not tell drivers to leave the order of operations alone: they may
//! fuse or reorder them. Lavapipe does so with the classic rule "blend", not with the default rule, of which the tests accept 4
//! units in the last place of the body's largest coordinate, and 16 units of 1 for normals and tangents; a tolerance above 0
//! comes on top where a device cuts off otherwise. Classic rules compare lengths that may be nearly equal, and may choose
//! otherwise then. Vertices with equal inputs are equal on any one device, so that seams stay shut.
//!
//! # Threads
//! A [`Device`] may go from thread to thread; `&mut self` says what must not happen at once. Command buffers that were encoded
//! are submitted in the order of encoding.

#[cfg(any(windows, target_os = "linux", target_os = "android", target_os = "freebsd"))]
mod adopt;
mod arena;
mod belt;
mod device;
mod encode;
mod headless;
mod pipelines;
mod read;
mod target;

#[cfg(any(windows, target_os = "linux", target_os = "android", target_os = "freebsd"))]
pub use adopt::VulkanDef;
pub use device::{Device, DeviceDef};
pub use encode::{EncodeJob, EncodeReport};
pub use headless::{HeadlessDef, adapters};
pub use target::{Stream, Target, TargetDef};
/// The crate whose types are used here.
pub use wgpu;

#[doc(hidden)]
pub use crate::gpu::{Attribute, Encoding, encode};
