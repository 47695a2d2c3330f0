//! A device of Crumple's own, on any adapter.

use super::device::Device;
use super::wgpu_device::{DeviceDef, now, one_line};
use crate::base::error::Error;

/// The definition of a device of Crumple's own.
#[derive(Debug, Clone, Copy)]
pub struct HeadlessDef<'a> {
    /// Part of the adapter's name, in any case. `None` takes the first adapter of the fastest kind (discrete, integrated, virtual,
    /// software).
    pub adapter: Option<&'a str>,
    /// The graphics interfaces to ask: Vulkan, Metal and D3D12 if the platform has them, and others that the host builds wgpu with.
    pub backends: wgpu::Backends,
    /// How the device is used.
    pub device: DeviceDef,
}

impl Default for HeadlessDef<'_> {
    fn default() -> Self {
        HeadlessDef { adapter: None, backends: wgpu::Backends::all(), device: DeviceDef::default() }
    }
}

/// Lists the adapters. It asks every driver, which takes tens of milliseconds.
pub fn adapters(backends: wgpu::Backends) -> Vec<wgpu::AdapterInfo> {
    all(backends).iter().map(wgpu::Adapter::get_info).collect()
}

fn all(backends: wgpu::Backends) -> Vec<wgpu::Adapter> {
    if !wgpu::Instance::enabled_backend_features().intersects(backends) {
        return Vec::new();
    }
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = backends;
    descriptor.flags = wgpu::InstanceFlags::empty();
    now(wgpu::Instance::new(descriptor).enumerate_adapters(backends))
}

impl Device {
    /// Makes a device with all limits of its adapter, for tools without an engine. Make its buffers with [`Device::device`].
    ///
    /// Errors that the device reports outside of calls here (it is lost, or the caller made a mistake on it) are returned by the
    /// next call here. They never end the process.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if there is no such adapter (the text lists the adapters), or it has no compute shaders;
    /// [`Error::Wgpu`] if it makes no device; the errors of [`Device::new`].
    pub fn headless(def: &HeadlessDef<'_>) -> Result<Self, Error> {
        let mut adapters = all(def.backends);
        use wgpu::DeviceType::{Cpu, DiscreteGpu, IntegratedGpu, Other, VirtualGpu};
        let kinds = [DiscreteGpu, IntegratedGpu, VirtualGpu, Other, Cpu];
        adapters.sort_by_key(|a| kinds.iter().position(|kind| *kind == a.get_info().device_type));
        let wanted = def.adapter.map(str::to_lowercase);
        let fits = |a: &&wgpu::Adapter| wanted.as_ref().is_none_or(|w| a.get_info().name.to_lowercase().contains(w));
        let Some(adapter) = adapters.iter().find(fits) else {
            let names: Vec<String> = adapters.iter().map(|a| name(&a.get_info())).collect();
            let there = if names.is_empty() { "none".into() } else { names.join(", ") };
            let named = def.adapter.map_or_else(String::new, |w| format!(" named {w:?}"));
            let what = format!("deforming on the GPU: no adapter{named} for {:?}; there are: {there}", def.backends);
            return Err(Error::Unsupported { what });
        };
        let flags = adapter.get_downlevel_capabilities().flags;
        if !flags.contains(wgpu::DownlevelFlags::COMPUTE_SHADERS) {
            let what = format!("deforming on {}: it has no compute shaders", name(&adapter.get_info()));
            return Err(Error::Unsupported { what });
        }
        let made = now(adapter.request_device(&descriptor(adapter.features(), adapter.limits())));
        let (device, queue) =
            made.map_err(|e| Error::Wgpu { call: "requesting a device".into(), what: one_line(&e.to_string()) })?;
        Self::with(device, queue, &def.device, true)
    }
}

/// The features that are useful here: kernels as SPIR-V instead of translated WGSL.
pub(super) fn exact(features: wgpu::Features) -> wgpu::Features {
    features & wgpu::Features::PASSTHROUGH_SHADERS
}

/// What to request of wgpu.
pub(super) fn descriptor(features: wgpu::Features, limits: wgpu::Limits) -> wgpu::DeviceDescriptor<'static> {
    let (label, required_features, required_limits) = (Some("crumple"), exact(features), limits);
    wgpu::DeviceDescriptor { label, required_features, required_limits, ..Default::default() }
}

fn name(info: &wgpu::AdapterInfo) -> String {
    format!("{} ({:?})", info.name, info.backend)
}
