//! The pipelines of the kernels, and their descriptor sets.

use super::functions::failed;
use super::vulkan_device::VulkanDevice;
use crate::base::error::Error;
use crate::gpu::{Call, Variant, compiled};
use ash::vk;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::sync::Arc;

/// The kernels, for tools that compile them without a device of Crumple: name and SPIR-V.
#[doc(hidden)]
pub fn kernels() -> impl Iterator<Item = (String, Vec<u32>)> {
    Variant::all().map(|v| {
        let name = format!("{:?} {:?}{}", v.case, v.kernel, if v.packed { " packed" } else { "" });
        (name.to_lowercase(), compiled(v, 128))
    })
}

/// Layouts, and the pipelines that were needed so far.
pub(super) struct VulkanPipelines {
    gpu: Arc<VulkanDevice>,
    /// Of arena and frame, and of one buffer: the host's or a state.
    set_layouts: [vk::DescriptorSetLayout; 2],
    pub layout: vk::PipelineLayout,
    cache: vk::PipelineCache,
    /// Invocations a workgroup.
    workgroup: u32,
    pub pipelines: BTreeMap<Variant, vk::Pipeline>,
}

/// A descriptor set in a pool of its own. It is dropped once no frame uses it.
pub(super) struct DescriptorSet {
    gpu: Arc<VulkanDevice>,
    pool: vk::DescriptorPool,
    pub handle: vk::DescriptorSet,
}

impl VulkanPipelines {
    /// Makes the layouts. Pipelines are added later, with `workgroup` invocations a workgroup, from the cache data if it has them.
    pub(super) fn new(gpu: &Arc<VulkanDevice>, workgroup: u32, cache: &[u8]) -> Result<Self, Error> {
        let mut made = VulkanPipelines {
            gpu: gpu.clone(),
            set_layouts: Default::default(),
            layout: vk::PipelineLayout::null(),
            cache: vk::PipelineCache::null(),
            workgroup,
            pipelines: BTreeMap::new(),
        };
        let device = &gpu.device;
        let binding = |n| {
            vk::DescriptorSetLayoutBinding::default()
                .binding(n)
                .descriptor_type(vk::DescriptorType::STORAGE_BUFFER)
                .descriptor_count(1)
                .stage_flags(vk::ShaderStageFlags::COMPUTE)
        };
        for (layout, bindings) in made.set_layouts.iter_mut().zip([&[binding(0), binding(1)][..], &[binding(0)]]) {
            let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(bindings);
            // SAFETY: a valid device and valid arguments that live through the call. So everywhere in this file.
            let set_layout = unsafe { device.create_descriptor_set_layout(&info, None) };
            *layout = set_layout.map_err(failed("vkCreateDescriptorSetLayout"))?;
        }
        let push = [vk::PushConstantRange::default()
            .stage_flags(vk::ShaderStageFlags::COMPUTE)
            .size(size_of::<Call>() as u32)];
        let sets = [made.set_layouts[0], made.set_layouts[1], made.set_layouts[1]];
        let layout = vk::PipelineLayoutCreateInfo::default().set_layouts(&sets).push_constant_ranges(&push);
        // Drivers ignore cache data of other drivers.
        let cache = vk::PipelineCacheCreateInfo::default().initial_data(cache);
        // SAFETY: as above.
        unsafe {
            made.layout = device.create_pipeline_layout(&layout, None).map_err(failed("vkCreatePipelineLayout"))?;
            made.cache = device.create_pipeline_cache(&cache, None).map_err(failed("vkCreatePipelineCache"))?;
        }
        Ok(made)
    }

    /// Adds the pipeline of a variant, if it is not there yet.
    pub(super) fn add(&mut self, variant: Variant) -> Result<(), Error> {
        let (device, layout) = (&self.gpu.device, self.layout);
        let Entry::Vacant(entry) = self.pipelines.entry(variant) else { return Ok(()) };
        let words = compiled(variant, self.workgroup);
        let info = vk::ShaderModuleCreateInfo::default().code(&words);
        // SAFETY: as above. The SPIR-V is valid.
        let module = unsafe { device.create_shader_module(&info, None) }.map_err(failed("vkCreateShaderModule"))?;
        let stage = vk::PipelineShaderStageCreateInfo::default()
            .stage(vk::ShaderStageFlags::COMPUTE)
            .module(module)
            .name(c"main");
        let info = vk::ComputePipelineCreateInfo::default().stage(stage).layout(layout);
        // SAFETY: as above. A pipeline does not need its module once it is made.
        let made = unsafe {
            let made = device.create_compute_pipelines(self.cache, &[info], None);
            device.destroy_shader_module(module, None);
            made
        };
        let made = made.map_err(|(_, result)| failed("vkCreateComputePipelines")(result))?;
        entry.insert(made[0]);
        Ok(())
    }

    /// Returns pipeline cache data for the next run.
    pub(super) fn cache_data(&self) -> Result<Vec<u8>, Error> {
        // SAFETY: as above.
        unsafe { self.gpu.device.get_pipeline_cache_data(self.cache) }.map_err(failed("vkGetPipelineCacheData"))
    }

    /// Makes a set of arena and frame (two buffers), or of the host's buffer or a state (one). Each buffer comes with offset and
    /// size in bytes.
    pub(super) fn set(&self, buffers: &[(vk::Buffer, u64, u64)]) -> Result<DescriptorSet, Error> {
        let device = &self.gpu.device;
        let sizes = [vk::DescriptorPoolSize::default()
            .ty(vk::DescriptorType::STORAGE_BUFFER)
            .descriptor_count(buffers.len() as u32)];
        let info = vk::DescriptorPoolCreateInfo::default().max_sets(1).pool_sizes(&sizes);
        self.gpu.count();
        // SAFETY: as above.
        let pool = unsafe { device.create_descriptor_pool(&info, None) }.map_err(failed("vkCreateDescriptorPool"))?;
        let mut set = DescriptorSet { gpu: self.gpu.clone(), pool, handle: vk::DescriptorSet::null() };
        let layouts = [self.set_layouts[usize::from(buffers.len() == 1)]];
        let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(pool).set_layouts(&layouts);
        // SAFETY: as above. The pool has room for this set.
        let sets = unsafe { device.allocate_descriptor_sets(&info) }.map_err(failed("vkAllocateDescriptorSets"))?;
        set.handle = sets[0];
        for (binding, (buffer, offset, range)) in (0..).zip(buffers) {
            let info = [vk::DescriptorBufferInfo::default().buffer(*buffer).offset(*offset).range(*range)];
            let write = vk::WriteDescriptorSet::default()
                .dst_set(set.handle)
                .dst_binding(binding)
                .descriptor_type(vk::DescriptorType::STORAGE_BUFFER)
                .buffer_info(&info);
            // SAFETY: as above. No command buffer uses the set yet.
            unsafe { device.update_descriptor_sets(&[write], &[]) };
        }
        Ok(set)
    }
}

impl Drop for DescriptorSet {
    fn drop(&mut self) {
        // SAFETY: no frame uses it any more.
        self.gpu.destroy(|device| unsafe { device.destroy_descriptor_pool(self.pool, None) });
    }
}

impl Drop for VulkanPipelines {
    fn drop(&mut self) {
        self.gpu.destroy(|device| {
            // SAFETY: no frame uses them any more; null handles are ignored.
            unsafe {
                self.pipelines.values().for_each(|p| device.destroy_pipeline(*p, None));
                device.destroy_pipeline_cache(self.cache, None);
                device.destroy_pipeline_layout(self.layout, None);
                self.set_layouts.iter().for_each(|l| device.destroy_descriptor_set_layout(*l, None));
            }
        });
    }
}
