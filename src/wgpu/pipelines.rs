//! The pipelines of the kernels: the SPIR-V of the build if the device takes it, else WGSL, which wgpu translates.

use super::wgpu_device::WgpuDevice;
use crate::base::error::Error;
use crate::gpu::{Call, Module, Variant};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::num::NonZero;
use std::sync::atomic::Ordering;

macro_rules! built {
    ($include:ident $name:literal) => {
        $include!(concat!(env!("OUT_DIR"), "/", $name))
    };
}

/// In the order of `Case`.
const MODULES: [Module; 2] = built!(include "wgpu_modules.rs");
const SOURCES: [&str; 2] = [built!(include_str "nodes_uniform.wgsl"), built!(include_str "classic_uniform.wgsl")];
const NAMES: [&str; 2] = ["crumple: nodes", "crumple: classic"];
const WORKGROUP: &str = "@workgroup_size(128)";

/// Layouts, and the pipelines that were needed so far.
pub(super) struct WgpuPipelines {
    /// Of arena, frame and call.
    pub work: wgpu::BindGroupLayout,
    /// Of one buffer: the host's or a state.
    pub one: wgpu::BindGroupLayout,
    /// In the order of `Case`.
    layouts: [wgpu::PipelineLayout; 2],
    /// Invocations a workgroup.
    workgroup: u32,
    pub pipelines: BTreeMap<Variant, wgpu::ComputePipeline>,
}

impl WgpuPipelines {
    pub(super) fn new(gpu: &WgpuDevice, workgroup: u32) -> Result<Self, Error> {
        gpu.checked("making pipeline layouts", 0, || Self::make(&gpu.device, workgroup))
    }

    fn make(device: &wgpu::Device, workgroup: u32) -> Self {
        let binding = |binding, ty, has_dynamic_offset, size| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset, min_binding_size: NonZero::new(size) },
            count: None,
        };
        let storage = |read_only| wgpu::BufferBindingType::Storage { read_only };
        let layout = |label, entries: &[wgpu::BindGroupLayoutEntry]| {
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries })
        };
        let call = binding(2, wgpu::BufferBindingType::Uniform, true, size_of::<Call>() as u64);
        // The frame's data is read four words at a time.
        let read = |n, least| binding(n, storage(true), false, least);
        let work = layout("crumple: work", &[read(0, 4), read(1, 16), call]);
        let one = layout("crumple: buffer", &[binding(0, storage(false), false, 4)]);
        let groups = [Some(&work), Some(&one), Some(&one)];
        let layouts = [2, 3].map(|count| {
            device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("crumple"),
                bind_group_layouts: &groups[..count],
                immediate_size: 0,
            })
        });
        WgpuPipelines { work, one, layouts, workgroup, pipelines: BTreeMap::new() }
    }

    /// Adds the pipeline of a variant, if it is not there yet.
    pub(super) fn add(&mut self, gpu: &WgpuDevice, variant: Variant) -> Result<(), Error> {
        let Entry::Vacant(pipeline) = self.pipelines.entry(variant) else { return Ok(()) };
        let (device, rule) = (&gpu.device, variant.case as usize);
        let label = Some(NAMES[rule]);
        let exact = device.features().contains(wgpu::Features::PASSTHROUGH_SHADERS)
            && device.adapter_info().backend == wgpu::Backend::Vulkan;
        let workgroup = variant.invocations(self.workgroup);
        let made = gpu.checked("making a compute pipeline", 0, || {
            let module = if exact {
                let words = MODULES[rule].compiled(variant, workgroup);
                let spirv = Some(words.into());
                let entry_point =
                    wgpu::PassthroughShaderEntryPoint { name: "main".into(), workgroup_size: (workgroup, 1, 1) };
                let entry_points = vec![entry_point].into();
                let descriptor =
                    wgpu::ShaderModuleDescriptorPassthrough { label, entry_points, spirv, ..Default::default() };
                // SAFETY: the SPIR-V is valid. Its bindings are those of the layout, numbered from 0 on without gaps, as wgpu
                // numbers them too. Its loops, divisors and indices are those of the WGSL below.
                unsafe { device.create_shader_module_passthrough(descriptor) }
            } else {
                let workgroup = format!("@workgroup_size({workgroup})");
                let source = wgpu::ShaderSource::Wgsl(SOURCES[rule].replacen(WORKGROUP, &workgroup, 1).into());
                let descriptor = wgpu::ShaderModuleDescriptor { label, source };
                // SAFETY: every loop of a kernel ends, no divisor is 0, and every index lies within what is bound: the same code
                // makes them for every device, for layouts that were checked.
                unsafe { device.create_shader_module_trusted(descriptor, wgpu::ShaderRuntimeChecks::unchecked()) }
            };
            // The SPIR-V has its values already.
            let overrides = MODULES[rule].off.iter().map(|(name, _)| *name).filter(|name| !exact && variant.on(name));
            let constants: Vec<(&str, f64)> = overrides.map(|name| (name, 1.0)).collect();
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label,
                layout: Some(&self.layouts[rule]),
                module: &module,
                entry_point: Some("main"),
                compilation_options: wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() },
                cache: None,
            })
        })?;
        pipeline.insert(made);
        Ok(())
    }
}

impl WgpuDevice {
    pub(super) fn bind_group(
        &self,
        layout: &wgpu::BindGroupLayout,
        buffers: &[wgpu::BufferBinding<'_>],
    ) -> Result<wgpu::BindGroup, Error> {
        let resource = buffers.iter().cloned().map(wgpu::BindingResource::Buffer);
        let entry = |(n, resource)| wgpu::BindGroupEntry { binding: n as u32, resource };
        let entries: Vec<_> = resource.enumerate().map(entry).collect();
        self.made.fetch_add(1, Ordering::Relaxed);
        let descriptor = wgpu::BindGroupDescriptor { label: Some("crumple"), layout, entries: &entries };
        self.checked("binding a buffer", 0, || self.device.create_bind_group(&descriptor))
    }
}
