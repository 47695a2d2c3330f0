//! The classic kernel on the device: what ours is held against, 52 bytes a vertex (`literature.wgsl`).

use std::time::Duration;

use anyhow::Result;
use ash::vk;
use glam::Vec3;

use super::buffer::Buffer;
use super::engine::Gpu;

/// Read and written for each vertex that an example moves: entry, base position, state twice.
pub const BYTES: f64 = 16.0 + 12.0 + 12.0 + 12.0;

/// What the kernel is told: entries, invocations in a row of workgroups, weight.
type Call = [u32; 3];

/// A pipeline for one workgroup size.
pub struct Kernel<'g> {
    gpu: &'g Gpu,
    set_layout: vk::DescriptorSetLayout,
    layout: vk::PipelineLayout,
    pipeline: vk::Pipeline,
    group: u32,
}

impl<'g> Kernel<'g> {
    pub fn new(gpu: &'g Gpu, group: u32) -> Result<Self> {
        let device = &gpu.device;
        let binding = |n| {
            vk::DescriptorSetLayoutBinding::default()
                .binding(n)
                .descriptor_type(vk::DescriptorType::STORAGE_BUFFER)
                .descriptor_count(1)
                .stage_flags(vk::ShaderStageFlags::COMPUTE)
        };
        let bindings = [binding(0), binding(1), binding(2)];
        let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
        let words = words(group);
        let size = size_of::<Call>() as u32;
        let push = [vk::PushConstantRange::default().stage_flags(vk::ShaderStageFlags::COMPUTE).size(size)];
        // SAFETY: valid arguments; what is made is destroyed in `drop`.
        unsafe {
            let set_layout = device.create_descriptor_set_layout(&info, None)?;
            let sets = [set_layout];
            let info = vk::PipelineLayoutCreateInfo::default().set_layouts(&sets).push_constant_ranges(&push);
            let layout = device.create_pipeline_layout(&info, None)?;
            let module = device.create_shader_module(&vk::ShaderModuleCreateInfo::default().code(&words), None)?;
            let stage = vk::PipelineShaderStageCreateInfo::default()
                .stage(vk::ShaderStageFlags::COMPUTE)
                .module(module)
                .name(c"main");
            let info = [vk::ComputePipelineCreateInfo::default().stage(stage).layout(layout)];
            let made = device.create_compute_pipelines(vk::PipelineCache::null(), &info, None);
            device.destroy_shader_module(module, None);
            let pipeline = made.map_err(|(_, e)| e)?[0];
            Ok(Kernel { gpu, set_layout, layout, pipeline, group })
        }
    }

    /// Invocations in a row of workgroups, and the workgroups of a dispatch, for so many entries.
    fn groups(&self, entries: usize) -> (u32, [u32; 2]) {
        let groups = (entries as u32).div_ceil(self.group);
        let across = groups.min(self.gpu.limits.max_compute_work_group_count[0]);
        (across.saturating_mul(self.group), [across, groups.div_ceil(across)])
    }

    /// Records one pass over `entries` entries.
    pub fn record(&self, commands: vk::CommandBuffer, set: vk::DescriptorSet, entries: usize, weight: f32) {
        let (row, [across, down]) = self.groups(entries);
        let call: Call = [entries as u32, row, weight.to_bits()];
        let (device, point) = (&self.gpu.device, vk::PipelineBindPoint::COMPUTE);
        // SAFETY: the command buffer is recording; handles are alive until whoever submits has waited.
        unsafe {
            device.cmd_bind_pipeline(commands, point, self.pipeline);
            device.cmd_bind_descriptor_sets(commands, point, self.layout, 0, &[set], &[]);
            let stages = vk::ShaderStageFlags::COMPUTE;
            device.cmd_push_constants(commands, self.layout, stages, 0, bytemuck::bytes_of(&call));
            device.cmd_dispatch(commands, across, down, 1);
        }
    }
}

impl Drop for Kernel<'_> {
    fn drop(&mut self) {
        let device = &self.gpu.device;
        // SAFETY: every submission was waited for.
        unsafe {
            device.destroy_pipeline(self.pipeline, None);
            device.destroy_pipeline_layout(self.layout, None);
            device.destroy_descriptor_set_layout(self.set_layout, None);
        }
    }
}

/// The kernel at work: a pass for each displacement field, one after the other, from the body at rest.
pub struct Literature<'g> {
    gpu: &'g Gpu,
    kernel: Kernel<'g>,
    base: Buffer<'g>,
    current: Buffer<'g>,
    /// Of each field its entries, how many, and their set.
    fields: Vec<(Buffer<'g>, usize, vk::DescriptorSet)>,
    pool: vk::DescriptorPool,
    weight: f32,
}

impl<'g> Literature<'g> {
    /// Of these displacement fields: pairs of vertex and displacement (m), vertices increasing.
    pub fn new(gpu: &'g Gpu, base: &[Vec3], fields: &[Vec<(u32, Vec3)>], weight: f32, group: u32) -> Result<Self> {
        let kernel = Kernel::new(gpu, group)?;
        let positions: &[u32] = bytemuck::cast_slice(base);
        let (device, count) = (&gpu.device, fields.len() as u32);
        let sizes =
            [vk::DescriptorPoolSize::default().ty(vk::DescriptorType::STORAGE_BUFFER).descriptor_count(3 * count)];
        let info = vk::DescriptorPoolCreateInfo::default().max_sets(count).pool_sizes(&sizes);
        let (rest, current) = (Buffer::filled(gpu, positions)?, Buffer::filled(gpu, positions)?);
        // SAFETY: valid arguments; destroyed in `drop`.
        let pool = unsafe { device.create_descriptor_pool(&info, None) }?;
        let mut it = Literature { gpu, kernel, base: rest, current, fields: Vec::new(), pool, weight };
        for field in fields {
            let entry = |(v, d): &(u32, Vec3)| {
                let [x, y, z] = (base[*v as usize] + *d).to_array().map(f32::to_bits);
                [*v, x, y, z]
            };
            let entries: Vec<u32> = field.iter().flat_map(entry).collect();
            let entries = Buffer::filled(gpu, &entries)?;
            let layouts = [it.kernel.set_layout];
            let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(pool).set_layouts(&layouts);
            // SAFETY: the pool has room for as many sets as there are fields.
            let set = unsafe { device.allocate_descriptor_sets(&info) }?[0];
            for (binding, buffer) in (0..).zip([&entries, &it.base, &it.current]) {
                let info = [vk::DescriptorBufferInfo::default().buffer(buffer.handle).range(vk::WHOLE_SIZE)];
                let write = vk::WriteDescriptorSet::default()
                    .dst_set(set)
                    .dst_binding(binding)
                    .descriptor_type(vk::DescriptorType::STORAGE_BUFFER)
                    .buffer_info(&info);
                // SAFETY: nothing uses the set yet.
                unsafe { device.update_descriptor_sets(&[write], &[]) };
            }
            it.fields.push((entries, field.len(), set));
        }
        Ok(it)
    }

    /// Back to the body at rest, so that every entry is written, and then, timed, a pass for each field.
    pub fn run(&mut self) -> Duration {
        let run = || {
            let (rest, current) = (&self.base, &self.current);
            self.gpu.timed(|commands| self.gpu.copy(commands, rest, current, rest.size))?;
            self.gpu.timed(|commands| {
                for (i, (_, entries, set)) in self.fields.iter().enumerate() {
                    if i > 0 {
                        self.gpu.barrier(commands);
                    }
                    self.kernel.record(commands, *set, *entries, self.weight);
                }
            })
        };
        run().unwrap_or_else(|e| panic!("{e:#}"))
    }

    /// Records the pass of the first field.
    pub fn record_pass(&self, commands: vk::CommandBuffer) {
        let (_, entries, set) = &self.fields[0];
        self.kernel.record(commands, *set, *entries, self.weight);
    }

    /// Positions after the last run.
    pub fn vertices(&self) -> Result<Vec<f32>> {
        self.current.read()
    }
}

impl Drop for Literature<'_> {
    fn drop(&mut self) {
        // SAFETY: every submission was waited for.
        unsafe { self.gpu.device.destroy_descriptor_pool(self.pool, None) };
    }
}

/// The same on the CPU, from the body at rest.
pub fn on_the_cpu(base: &[Vec3], fields: &[Vec<(u32, Vec3)>], weight: f32) -> Vec<f32> {
    let mut current = base.to_vec();
    for field in fields {
        for (v, d) in field {
            let v = *v as usize;
            let (rest, now) = (base[v], current[v]);
            let result = now + ((rest + *d) - now) * weight;
            if (result - rest).length_squared() >= (now - rest).length_squared() {
                current[v] = result;
            }
        }
    }
    current.into_iter().flat_map(|p| p.to_array()).collect()
}

/// The words of a module, with so many invocations a workgroup.
fn with_workgroup(module: &[u8], invocations: u32) -> Vec<u32> {
    const HEADER: usize = 5;
    const EXECUTION_MODE: u32 = 16;
    let mut words: Vec<u32> = module.chunks_exact(4).map(|w| u32::from_le_bytes([w[0], w[1], w[2], w[3]])).collect();
    let mut at = HEADER;
    while words[at] & 0xFFFF != EXECUTION_MODE {
        at += (words[at] >> 16) as usize;
    }
    // LocalSize: entry point, mode, x, y, z.
    words[at + 3] = invocations;
    words
}

/// The kernel in SPIR-V, with so many invocations a workgroup.
pub fn words(group: u32) -> Vec<u32> {
    with_workgroup(include_bytes!(concat!(env!("OUT_DIR"), "/literature.spv")), group)
}
