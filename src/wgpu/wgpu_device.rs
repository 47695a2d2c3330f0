//! The wgpu device with its queue and limits, and its errors.

use crate::base::error::Error;
use crate::gpu::{BindingLimits, check_workgroup_size};
use std::pin::pin;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::task::{Context, Poll, Waker};

/// What a device reports outside of calls.
#[derive(Debug, Default)]
struct DeviceEvents {
    /// The first error that no scope caught.
    error: Option<String>,
    /// Why the device is lost.
    lost: Option<String>,
}

/// How a device is used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DeviceDef {
    /// Invocations a workgroup: a power of two from 32 to 128 that the device supports. The default is 128.
    pub workgroup_size: u32,
}

impl Default for DeviceDef {
    fn default() -> Self {
        DeviceDef { workgroup_size: 128 }
    }
}

/// The wgpu device, its queue and its limits.
pub(super) struct WgpuDevice {
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    pub limits: wgpu::Limits,
    /// What the device reports outside of calls. Only devices that were made here are listened to.
    events: Option<Arc<Mutex<DeviceEvents>>>,
    /// Buffers and bind groups made so far.
    pub made: AtomicU64,
}

impl WgpuDevice {
    /// Takes the device if its limits suffice. `own` says whether it was made here.
    pub(super) fn new(device: wgpu::Device, queue: wgpu::Queue, def: &DeviceDef, own: bool) -> Result<Self, Error> {
        let limits = device.limits();
        check(def, &limits)?;
        let events = own.then(|| listen(&device));
        Ok(WgpuDevice { device, queue, limits, events, made: AtomicU64::new(0) })
    }

    /// Calls `f`, and returns what wgpu finds wrong with it as an error. The host's handler does not hear of it. `bytes` is what
    /// the call allocates.
    pub(super) fn checked<T>(&self, call: &str, bytes: u64, f: impl FnOnce() -> T) -> Result<T, Error> {
        use wgpu::ErrorFilter::{Internal, OutOfMemory, Validation};
        let scopes = [OutOfMemory, Validation, Internal].map(|filter| self.device.push_error_scope(filter));
        let t = f();
        let mut first = None;
        for scope in scopes.into_iter().rev() {
            first = now(scope.pop()).or(first);
        }
        if first.is_some() {
            // On a lost device everything else fails too.
            self.lost()?;
        }
        match first {
            None => Ok(t),
            Some(wgpu::Error::OutOfMemory { .. }) => Err(Error::OutOfMemory { what: call.into(), bytes }),
            Some(other) => Err(Error::Wgpu { call: call.into(), what: one_line(&other.to_string()) }),
        }
    }

    /// Makes a buffer of `bytes` bytes, at least 4.
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

    pub(super) fn binding_limits(&self) -> BindingLimits {
        BindingLimits {
            bytes: self.limits.max_storage_buffer_binding_size & !3,
            name: "max_storage_buffer_binding_size",
            alignment: u64::from(self.limits.min_storage_buffer_offset_alignment.max(4)),
        }
    }

    /// Returns what the device has reported since the last call, as an error.
    pub(super) fn reported_error(&self) -> Result<(), Error> {
        self.lost()?;
        let Some(events) = &self.events else { return Ok(()) };
        let error = events.lock().unwrap_or_else(|e| e.into_inner()).error.take();
        error.map_or(Ok(()), |what| Err(Error::Wgpu { call: "an earlier call".into(), what }))
    }

    fn lost(&self) -> Result<(), Error> {
        let Some(events) = &self.events else { return Ok(()) };
        match &events.lock().unwrap_or_else(|e| e.into_inner()).lost {
            Some(reason) => Err(Error::DeviceLost { call: format!("wgpu ({reason})") }),
            None => Ok(()),
        }
    }
}

/// Notes what the device reports outside of calls.
fn listen(device: &wgpu::Device) -> Arc<Mutex<DeviceEvents>> {
    let events = Arc::new(Mutex::new(DeviceEvents::default()));
    let (errors, losses) = (events.clone(), events.clone());
    device.on_uncaptured_error(Arc::new(move |e: wgpu::Error| {
        let mut events = errors.lock().unwrap_or_else(|e| e.into_inner());
        events.error.get_or_insert_with(|| one_line(&e.to_string()));
    }));
    device.set_device_lost_callback(move |reason, message| {
        let mut events = losses.lock().unwrap_or_else(|e| e.into_inner());
        events.lost.get_or_insert_with(|| one_line(&format!("{reason:?}: {message}")));
    });
    events
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
    let most = limits.max_compute_workgroup_size_x.min(limits.max_compute_invocations_per_workgroup);
    check_workgroup_size(def.workgroup_size, most)
}

/// The output of a future of wgpu. Outside of browsers it is ready from the start.
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

/// A text of wgpu without its line breaks.
pub(super) fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
