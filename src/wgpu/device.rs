//! The device that hosts use: everything that is made on the wgpu device.

use super::belt::Belt;
use super::bound_buffers::BoundBuffers;
use super::frame_encoding::FrameEncoding;
use super::pipelines::WgpuPipelines;
use super::readback::Readback;
use super::wgpu_device::{DeviceDef, DeviceEvents, WgpuDevice};
use crate::base::error::Error;
use crate::gpu::Arena;
use std::fmt;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

/// A `wgpu` device that deforms.
pub struct Device {
    pub(super) gpu: WgpuDevice,
    /// Distinguishes its targets from those of other devices.
    pub(super) id: u64,
    pub(super) pipelines: WgpuPipelines,
    pub(super) workgroup: u32,
    pub(super) bound: BoundBuffers,
    pub(super) arena: Arena<wgpu::Buffer>,
    pub(super) belt: Belt,
    pub(super) reader: Readback,
    pub(super) encoding: FrameEncoding,
}

impl fmt::Debug for Device {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Device").field("device", &self.gpu.device).finish_non_exhaustive()
    }
}

impl Device {
    /// Takes the host's device and its queue. It needs no features, and no limits above those of WebGPU. With a higher
    /// [`wgpu::Limits::max_storage_buffer_binding_size`] one dispatch can write larger buffers.
    ///
    /// The errors of calls here are returned, and do not reach the host's handler of uncaptured errors. But an encoder of another
    /// device than the targets' fails when the host finishes or submits it.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a bad workgroup size; [`Error::Unsupported`] for a limit that is too low; [`Error::Wgpu`].
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue, def: &DeviceDef) -> Result<Self, Error> {
        Self::with(device.clone(), queue.clone(), def, None)
    }

    pub(super) fn with(
        device: wgpu::Device,
        queue: wgpu::Queue,
        def: &DeviceDef,
        events: Option<Arc<Mutex<DeviceEvents>>>,
    ) -> Result<Self, Error> {
        static NEXT: AtomicU64 = AtomicU64::new(1);
        let gpu = WgpuDevice::new(device, queue, def, events)?;
        Ok(Device {
            pipelines: WgpuPipelines::new(&gpu, def.workgroup_size)?,
            gpu,
            id: NEXT.fetch_add(1, Ordering::Relaxed),
            workgroup: def.workgroup_size,
            bound: BoundBuffers::default(),
            arena: Arena::new(),
            belt: Belt::default(),
            reader: Readback::default(),
            encoding: FrameEncoding::default(),
        })
    }

    /// The wgpu device.
    pub fn device(&self) -> &wgpu::Device {
        &self.gpu.device
    }

    /// Its queue.
    pub fn queue(&self) -> &wgpu::Queue {
        &self.gpu.queue
    }

    /// Returns how many buffers and bind groups were made so far. The number does not grow in steady state.
    pub fn objects_made(&self) -> u64 {
        self.gpu.made.load(Ordering::Relaxed)
    }

    /// Fails if the device has reported an error outside of calls. Only devices that were made here are listened to.
    pub(super) fn reported_error(&self) -> Result<(), Error> {
        self.gpu.reported_error()
    }

    /// Sets the most vertices that a frame writes; see [`crate::deform_within`]. At first there is no limit (`u64::MAX`).
    pub fn set_vertex_budget(&mut self, vertices: u64) {
        self.encoding.plan.budget = vertices;
    }

    /// Frees meshes that no target shows.
    pub(super) fn free_meshes(&mut self) {
        self.arena.collect(0, |chunk, _| self.belt.remove_group(chunk));
    }
}
