//! Deformation on `wgpu` devices: the host's own device, a Vulkan device of an engine, or a device made here, which may be Vulkan,
//! Metal or D3D12.
//!
//! 1. [`Device::new`] takes the host's [`wgpu::Device`] and [`wgpu::Queue`]. [`Device::headless`] makes its own. [`Device::adopt`]
//!    wraps an engine's VkDevice.
//! 2. [`Device::add_target`] says where in a [`wgpu::Buffer`] the vertices of one mesh lie, and in which formats.
//! 3. [`Device::encode`] encodes everything that changed, of all targets, into the host's command encoder; [`Device::submit`] submits
//!    it too. Call one of them once a frame. It makes one copy, and a dispatch for each buffer. Nothing waits for the device.
//!
//! Engines with a Vulkan command buffer should record into that: [`crate::vulkan`](../vulkan/index.html). It is smaller, costs
//! less a frame and gives the CPU's bits on more devices.
//!
//! # What the device needs
//! Compute shaders, four storage buffers a stage and three bind groups. WebGPU guarantees these. No feature is needed: what differs
//! from dispatch to dispatch is in a uniform buffer, not in immediates (push constants).
//!
//! # How exact it is
//! The kernels are those of [`crate::vulkan`](../vulkan/index.html), from the same WGSL. Vulkan devices with
//! [`wgpu::Features::PASSTHROUGH_SHADERS`] get the same SPIR-V. If they also round additions, multiplications, divisions and square
//! roots as IEEE 754 says (lavapipe and SwiftShader do), the vertices have the bits of [`crate::deform`]. Devices that are made or
//! adopted here have that feature; a host must ask for it.
//!
//! For other devices wgpu translates the WGSL. It does not forbid drivers to fuse or reorder operations. Lavapipe does so with the
//! classic rule "blend", and not with the default rule. The tests accept 4 units in the last place of the body's largest coordinate,
//! and 32 units of 1 for normals and tangents; a tolerance above 0 adds to that. Classic rules compare lengths, and may choose
//! otherwise if they are nearly equal. On one device vertices with equal inputs are equal, so that seams stay shut.
//!
//! # Threads
//! A [`Device`] may move between threads. Command buffers are submitted in the order of encoding.

#[cfg(any(windows, target_os = "linux", target_os = "android", target_os = "freebsd"))]
mod adopt;
mod belt;
mod device;
mod encode;
mod headless;
mod pipelines;
mod read;
mod target;
mod wgpu_device;

pub use crate::gpu::{FrameReport, Job, Target as AnyTarget};
#[cfg(any(windows, target_os = "linux", target_os = "android", target_os = "freebsd"))]
pub use adopt::VulkanDef;
pub use device::Device;
pub use headless::{HeadlessDef, adapters};
pub use target::{Stream, Target, TargetDef};
/// The crate whose types are used here.
pub use wgpu;
pub use wgpu_device::DeviceDef;

#[doc(hidden)]
pub use crate::gpu::{Attribute, Encoding};
