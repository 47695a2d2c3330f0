//! The pipelines of the kernels, and their descriptor sets.

use super::functions::checked;
use super::vulkan_device::VulkanDevice;
use crate::base::error::Error;
use crate::gpu::{Call, Variant, compiled};
use ash::vk::{self, Handle};
use std::ptr::{null, null_mut};

/// The kernels, for tools that compile them without a device of Crumple: name and SPIR-V.
#[doc(hidden)]
pub fn kernels() -> impl Iterator<Item = (String, Vec<u32>)> {
    Variant::all().map(|v| {
        let name = format!("{:?} {:?}{}", v.case, v.kernel, if v.packed { " packed" } else { "" });
        (name.to_lowercase(), compiled(v, 128))
    })
}

/// Layouts and pipelines.
#[derive(Debug, Default)]
pub(super) struct VulkanPipelines {
    /// Of arena and frame, and of one buffer: the host's or a state.
    set_layouts: [vk::DescriptorSetLayout; 2],
    pub layout: vk::PipelineLayout,
    cache: vk::PipelineCache,
    /// Invocations a workgroup.
    workgroup: u32,
    /// In the order of [`Variant::number`]; null until needed.
    pipelines: Vec<vk::Pipeline>,
}

impl VulkanPipelines {
    /// A pipeline that was added.
    pub(super) fn get(&self, variant: Variant) -> vk::Pipeline {
        self.pipelines[variant.number()]
    }
}

/// A descriptor set in a pool of its own.
#[derive(Debug)]
pub(super) struct DescriptorSet {
    pool: vk::DescriptorPool,
    pub handle: vk::DescriptorSet,
}

impl VulkanDevice {
    /// Makes the layouts. Pipelines are added later, with `workgroup` invocations a workgroup, from the cache data if it has them.
    pub(super) fn pipelines(&self, workgroup: u32, cache: &[u8]) -> Result<VulkanPipelines, Error> {
        let pipelines = vec![vk::Pipeline::null(); Variant::COUNT];
        let mut pipelines = VulkanPipelines { workgroup, pipelines, ..VulkanPipelines::default() };
        let made = self.make_layouts(&mut pipelines, cache);
        if made.is_err() {
            // SAFETY: nothing uses them yet.
            unsafe { self.destroy_pipelines(&pipelines) };
        }
        made.map(|()| pipelines)
    }

    fn make_layouts(&self, k: &mut VulkanPipelines, cache: &[u8]) -> Result<(), Error> {
        let (f, device) = (&self.functions, self.device);
        let binding = |n| {
            vk::DescriptorSetLayoutBinding::default()
                .binding(n)
                .descriptor_type(vk::DescriptorType::STORAGE_BUFFER)
                .descriptor_count(1)
                .stage_flags(vk::ShaderStageFlags::COMPUTE)
        };
        for (layout, bindings) in k.set_layouts.iter_mut().zip([&[binding(0), binding(1)][..], &[binding(0)]]) {
            let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(bindings);
            // SAFETY: a valid device and valid arguments that live through the call, here and below.
            let result = unsafe { (f.create_descriptor_set_layout)(device, &info, null(), layout) };
            checked("vkCreateDescriptorSetLayout", result)?;
        }
        let push = [vk::PushConstantRange::default()
            .stage_flags(vk::ShaderStageFlags::COMPUTE)
            .size(size_of::<Call>() as u32)];
        let sets = [k.set_layouts[0], k.set_layouts[1], k.set_layouts[1]];
        let info = vk::PipelineLayoutCreateInfo::default().set_layouts(&sets).push_constant_ranges(&push);
        // SAFETY: as above.
        let result = unsafe { (f.create_pipeline_layout)(device, &info, null(), &mut k.layout) };
        checked("vkCreatePipelineLayout", result)?;
        // Drivers ignore cache data of other drivers.
        let info = vk::PipelineCacheCreateInfo::default().initial_data(cache);
        // SAFETY: as above.
        checked("vkCreatePipelineCache", unsafe { (f.create_pipeline_cache)(device, &info, null(), &mut k.cache) })
    }

    /// Adds the pipeline of a variant, if it is not there yet.
    pub(super) fn add_pipeline(&self, k: &mut VulkanPipelines, variant: Variant) -> Result<(), Error> {
        let (f, device, number) = (&self.functions, self.device, variant.number());
        if !k.pipelines[number].is_null() {
            return Ok(());
        }
        let words = compiled(variant, k.workgroup);
        let info = vk::ShaderModuleCreateInfo::default().code(&words);
        let mut module = vk::ShaderModule::null();
        // SAFETY: as above. The SPIR-V is valid.
        checked("vkCreateShaderModule", unsafe { (f.create_shader_module)(device, &info, null(), &mut module) })?;
        let stage = vk::PipelineShaderStageCreateInfo::default()
            .stage(vk::ShaderStageFlags::COMPUTE)
            .module(module)
            .name(c"main");
        let info = vk::ComputePipelineCreateInfo::default().stage(stage).layout(k.layout);
        // SAFETY: as above. A pipeline does not need its module once it is made.
        let result = unsafe {
            let result = (f.create_compute_pipelines)(device, k.cache, 1, &info, null(), &mut k.pipelines[number]);
            (f.destroy_shader_module)(device, module, null());
            result
        };
        checked("vkCreateComputePipelines", result)
    }

    /// Returns pipeline cache data for the next run.
    pub(super) fn cache_data(&self, k: &VulkanPipelines) -> Result<Vec<u8>, Error> {
        let get = |size: &mut usize, data: *mut u8| {
            // SAFETY: the cache is valid. `data` has `size` bytes or is null.
            let result = unsafe { (self.functions.get_pipeline_cache_data)(self.device, k.cache, size, data.cast()) };
            checked("vkGetPipelineCacheData", result)
        };
        let mut size = 0;
        get(&mut size, null_mut())?;
        let mut data = vec![0; size];
        get(&mut size, data.as_mut_ptr())?;
        data.truncate(size);
        Ok(data)
    }

    /// Makes a set of arena and frame (two buffers), or of the host's buffer or a state (one). Each buffer comes with offset and
    /// size in bytes.
    pub(super) fn set(&self, k: &VulkanPipelines, buffers: &[(vk::Buffer, u64, u64)]) -> Result<DescriptorSet, Error> {
        let (f, device) = (&self.functions, self.device);
        let sizes = [vk::DescriptorPoolSize::default()
            .ty(vk::DescriptorType::STORAGE_BUFFER)
            .descriptor_count(buffers.len() as u32)];
        let info = vk::DescriptorPoolCreateInfo::default().max_sets(1).pool_sizes(&sizes);
        let mut set = DescriptorSet { pool: vk::DescriptorPool::null(), handle: vk::DescriptorSet::null() };
        self.count();
        // SAFETY: as above.
        checked("vkCreateDescriptorPool", unsafe { (f.create_descriptor_pool)(device, &info, null(), &mut set.pool) })?;
        let layouts = [k.set_layouts[usize::from(buffers.len() == 1)]];
        let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(set.pool).set_layouts(&layouts);
        // SAFETY: as above. The pool has room for this set.
        let result = unsafe { (f.allocate_descriptor_sets)(device, &info, &mut set.handle) };
        if result != vk::Result::SUCCESS {
            // SAFETY: nothing uses it.
            unsafe { self.destroy_set(&set) };
        }
        checked("vkAllocateDescriptorSets", result)?;
        for (binding, (buffer, offset, range)) in (0..).zip(buffers) {
            let info = [vk::DescriptorBufferInfo::default().buffer(*buffer).offset(*offset).range(*range)];
            let write = vk::WriteDescriptorSet::default()
                .dst_set(set.handle)
                .dst_binding(binding)
                .descriptor_type(vk::DescriptorType::STORAGE_BUFFER)
                .buffer_info(&info);
            // SAFETY: as above. No command buffer uses the set yet.
            unsafe { (f.update_descriptor_sets)(device, 1, &write, 0, null()) };
        }
        Ok(set)
    }

    /// # Safety
    /// Nothing uses the set any more.
    pub(super) unsafe fn destroy_set(&self, set: &DescriptorSet) {
        // SAFETY: the caller's promise.
        unsafe { (self.functions.destroy_descriptor_pool)(self.device, set.pool, null()) };
    }

    /// # Safety
    /// Nothing uses them any more.
    pub(super) unsafe fn destroy_pipelines(&self, k: &VulkanPipelines) {
        let (f, device) = (&self.functions, self.device);
        // SAFETY: the caller's promise; null handles are ignored.
        unsafe {
            k.pipelines.iter().for_each(|p| (f.destroy_pipeline)(device, *p, null()));
            (f.destroy_pipeline_cache)(device, k.cache, null());
            (f.destroy_pipeline_layout)(device, k.layout, null());
            k.set_layouts.iter().for_each(|l| (f.destroy_descriptor_set_layout)(device, *l, null()));
        }
    }
}
