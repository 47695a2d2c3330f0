//! The device as it is used here, and everything that is made on it.

use super::arena::Arena;
use super::belt::Belt;
use super::encode::Scratch;
use super::kernels::Kernels;
use super::read::Reader;
use super::target::Windows;
use crate::Error;
use std::fmt;
use std::pin::pin;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::task::{Context, Poll, Waker};

/// How a device is used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DeviceDef {
    /// Invocations a workgroup: a power of two from 32 to 256, no more than the device can. 128 where nothing says otherwise.
    pub workgroup_size: u32,
}

impl Default for DeviceDef {
    fn default() -> Self {
        DeviceDef { workgroup_size: 128 }
    }
}

/// What everything is made with.
pub(super) struct Gpu {
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    pub limits: wgpu::Limits,
    /// What the device said to nobody in particular; of devices that were made here.
    pub said: Option<Arc<Mutex<Said>>>,
    /// Buffers and bind groups made so far.
    pub made: AtomicU64,
}

/// What a device says by itself.
#[derive(Debug, Default)]
pub(super) struct Said {
    /// The first error that no scope held.
    pub error: Option<String>,
    /// Why the device is lost, where it is.
    pub lost: Option<String>,
}

impl Gpu {
    /// Calls `f`; what it makes wgpu say is an error, and never the host's handler's affair. `bytes` are what it allocates.
    pub(super) fn checked<T>(&self, call: &str, bytes: u64, f: impl FnOnce() -> T) -> Result<T, Error> {
        use wgpu::ErrorFilter::{Internal, OutOfMemory, Validation};
        let scopes = [OutOfMemory, Validation, Internal].map(|filter| self.device.push_error_scope(filter));
        let t = f();
        let mut first = None;
        for scope in scopes.into_iter().rev() {
            first = now(scope.pop()).or(first);
        }
        if first.is_some() {
            // Where a device is lost everything else fails too.
            self.lost()?;
        }
        match first {
            None => Ok(t),
            Some(wgpu::Error::OutOfMemory { .. }) => Err(Error::OutOfMemory { what: call.into(), bytes }),
            Some(other) => Err(Error::Wgpu { call: call.into(), what: one_line(&other.to_string()) }),
        }
    }

    /// A buffer of so many bytes, at least 4.
    pub(super) fn buffer(&self, what: &str, bytes: u64, usage: wgpu::BufferUsages) -> Result<wgpu::Buffer, Error> {
        let size = bytes.max(4).next_multiple_of(4);
        if size > self.limits.max_buffer_size {
            let most = self.limits.max_buffer_size;
            return Err(Error::Unsupported {
                what: format!("{what} of {bytes} bytes; max_buffer_size is {most} on this device"),
            });
        }
        self.made.fetch_add(1, Ordering::Relaxed);
        let mapped_at_creation = usage.contains(wgpu::BufferUsages::MAP_WRITE);
        let label = format!("crumple: {what}");
        let descriptor = wgpu::BufferDescriptor { label: Some(&label), size, usage, mapped_at_creation };
        self.checked(what, bytes, || self.device.create_buffer(&descriptor))
    }

    /// Bytes of the largest storage buffer that can be bound: a multiple of 4.
    pub(super) fn most_bound(&self) -> u64 {
        self.limits.max_storage_buffer_binding_size & !3
    }

    /// What the device has said since it was last asked, as an error.
    fn heard(&self) -> Result<(), Error> {
        self.lost()?;
        let Some(said) = &self.said else { return Ok(()) };
        let error = said.lock().unwrap_or_else(|e| e.into_inner()).error.take();
        error.map_or(Ok(()), |what| Err(Error::Wgpu { call: "an earlier call".into(), what }))
    }

    fn lost(&self) -> Result<(), Error> {
        let Some(said) = &self.said else { return Ok(()) };
        match &said.lock().unwrap_or_else(|e| e.into_inner()).lost {
            Some(reason) => Err(Error::DeviceLost { call: format!("wgpu ({reason})") }),
            None => Ok(()),
        }
    }
}

/// A `wgpu` device that deforms.
pub struct Device {
    pub(super) gpu: Gpu,
    /// Tells targets of other devices.
    pub(super) id: u64,
    pub(super) kernels: Kernels,
    pub(super) workgroup: u32,
    pub(super) windows: Windows,
    pub(super) arena: Arena,
    pub(super) belt: Belt,
    pub(super) reader: Reader,
    pub(super) scratch: Scratch,
}

impl fmt::Debug for Device {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Device").field("device", &self.gpu.device).finish_non_exhaustive()
    }
}

impl Device {
    /// Takes the host's device and its queue, and makes pipelines (some milliseconds). Neither features nor limits above those
    /// of WebGPU are needed; more [`wgpu::Limits::max_storage_buffer_binding_size`] lets larger buffers be written at once.
    ///
    /// Errors of calls made here come back from them, and never reach the host's handler of uncaptured errors; but an encoder
    /// that is of another device than the targets fails when the host finishes or submits it, as wgpu has it.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a workgroup size that is none; [`Error::Unsupported`] naming a limit that is too low;
    /// [`Error::Wgpu`].
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue, def: &DeviceDef) -> Result<Self, Error> {
        Self::with(device.clone(), queue.clone(), def, None)
    }

    pub(super) fn with(
        device: wgpu::Device,
        queue: wgpu::Queue,
        def: &DeviceDef,
        said: Option<Arc<Mutex<Said>>>,
    ) -> Result<Self, Error> {
        static NEXT: AtomicU64 = AtomicU64::new(1);
        let limits = device.limits();
        check(def, &limits)?;
        let gpu = Gpu { device, queue, limits, said, made: AtomicU64::new(0) };
        Ok(Device {
            kernels: Kernels::new(&gpu, def.workgroup_size)?,
            gpu,
            id: NEXT.fetch_add(1, Ordering::Relaxed),
            workgroup: def.workgroup_size,
            windows: Windows::default(),
            arena: Arena::default(),
            belt: Belt::default(),
            reader: Reader::default(),
            scratch: Scratch::default(),
        })
    }

    /// The device that this works on.
    pub fn device(&self) -> &wgpu::Device {
        &self.gpu.device
    }

    /// Its queue.
    pub fn queue(&self) -> &wgpu::Queue {
        &self.gpu.queue
    }

    /// How many buffers and bind groups were made so far: a number that stands still once as many frames are in flight as
    /// ever, and as much changes a frame as ever.
    pub fn objects_made(&self) -> u64 {
        self.gpu.made.load(Ordering::Relaxed)
    }

    /// Fails where the device has said by itself that something is wrong; only devices made here are listened to.
    pub(super) fn heard(&self) -> Result<(), Error> {
        self.gpu.heard()
    }
}

fn check(def: &DeviceDef, limits: &wgpu::Limits) -> Result<(), Error> {
    let needs = [
        ("max_bind_groups", limits.max_bind_groups, 3),
        ("max_storage_buffers_per_shader_stage", limits.max_storage_buffers_per_shader_stage, 4),
        ("max_uniform_buffers_per_shader_stage", limits.max_uniform_buffers_per_shader_stage, 1),
        ("max_dynamic_uniform_buffers_per_pipeline_layout", limits.max_dynamic_uniform_buffers_per_pipeline_layout, 1),
        ("max_compute_workgroups_per_dimension", limits.max_compute_workgroups_per_dimension, 1),
        ("max_compute_invocations_per_workgroup", limits.max_compute_invocations_per_workgroup, 32),
    ];
    if let Some((name, has, need)) = needs.into_iter().find(|(_, has, need)| has < need) {
        return Err(Error::Unsupported {
            what: format!("a wgpu device with {name} {has}; it must be requested with at least {need}"),
        });
    }
    let most = limits.max_compute_workgroup_size_x.min(limits.max_compute_invocations_per_workgroup).min(256);
    if !def.workgroup_size.is_power_of_two() || !(32..=most).contains(&def.workgroup_size) {
        return Err(Error::invalid("workgroup_size", def.workgroup_size, &format!("a power of two, 32 to {most}")));
    }
    Ok(())
}

/// What a future of wgpu gives: outside browsers they are ready from the start.
pub(super) fn now<F: Future>(future: F) -> F::Output {
    let mut future = pin!(future);
    let mut context = Context::from_waker(Waker::noop());
    loop {
        match future.as_mut().poll(&mut context) {
            Poll::Ready(output) => return output,
            Poll::Pending => std::thread::yield_now(),
        }
    }
}

/// wgpu's words without their line breaks.
pub(super) fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
