//! The Vulkan functions that are called, loaded through the host's own loader and each checked before it is used.

use crate::Error;
use ash::vk;
use std::ffi::CStr;

macro_rules! functions {
    ($(#[$doc:meta])* $table:ident: $($field:ident = $name:literal as $pfn:ident,)*) => {
        $(#[$doc])*
        pub(super) struct $table {
            $(pub(super) $field: vk::$pfn,)*
        }

        impl $table {
            /// # Safety
            /// What `get` answers is the function of that name, or none.
            pub(super) unsafe fn load(
                get: impl Fn(&std::ffi::CStr) -> vk::PFN_vkVoidFunction,
            ) -> Result<Self, $crate::Error> {
                Ok(Self {
                    $($field: {
                        let function = get($name).ok_or_else(|| $crate::vulkan::functions::missing($name))?;
                        // SAFETY: by its name it is of this type.
                        unsafe { std::mem::transmute::<unsafe extern "system" fn(), vk::$pfn>(function) }
                    },)*
                })
            }
        }
    };
}

pub(super) use functions;

functions! {
    /// Of an instance.
    InstanceFunctions:
    get_device_proc_addr = c"vkGetDeviceProcAddr" as PFN_vkGetDeviceProcAddr,
    properties = c"vkGetPhysicalDeviceProperties" as PFN_vkGetPhysicalDeviceProperties,
    memory_properties = c"vkGetPhysicalDeviceMemoryProperties" as PFN_vkGetPhysicalDeviceMemoryProperties,
    queue_families = c"vkGetPhysicalDeviceQueueFamilyProperties" as PFN_vkGetPhysicalDeviceQueueFamilyProperties,
}

functions! {
    /// Of a device.
    Functions:
    create_buffer = c"vkCreateBuffer" as PFN_vkCreateBuffer,
    destroy_buffer = c"vkDestroyBuffer" as PFN_vkDestroyBuffer,
    buffer_requirements = c"vkGetBufferMemoryRequirements" as PFN_vkGetBufferMemoryRequirements,
    allocate_memory = c"vkAllocateMemory" as PFN_vkAllocateMemory,
    free_memory = c"vkFreeMemory" as PFN_vkFreeMemory,
    bind_buffer_memory = c"vkBindBufferMemory" as PFN_vkBindBufferMemory,
    map_memory = c"vkMapMemory" as PFN_vkMapMemory,
    flush_memory = c"vkFlushMappedMemoryRanges" as PFN_vkFlushMappedMemoryRanges,
    create_set_layout = c"vkCreateDescriptorSetLayout" as PFN_vkCreateDescriptorSetLayout,
    destroy_set_layout = c"vkDestroyDescriptorSetLayout" as PFN_vkDestroyDescriptorSetLayout,
    create_pipeline_layout = c"vkCreatePipelineLayout" as PFN_vkCreatePipelineLayout,
    destroy_pipeline_layout = c"vkDestroyPipelineLayout" as PFN_vkDestroyPipelineLayout,
    create_shader_module = c"vkCreateShaderModule" as PFN_vkCreateShaderModule,
    destroy_shader_module = c"vkDestroyShaderModule" as PFN_vkDestroyShaderModule,
    create_pipelines = c"vkCreateComputePipelines" as PFN_vkCreateComputePipelines,
    destroy_pipeline = c"vkDestroyPipeline" as PFN_vkDestroyPipeline,
    create_cache = c"vkCreatePipelineCache" as PFN_vkCreatePipelineCache,
    destroy_cache = c"vkDestroyPipelineCache" as PFN_vkDestroyPipelineCache,
    cache_data = c"vkGetPipelineCacheData" as PFN_vkGetPipelineCacheData,
    create_pool = c"vkCreateDescriptorPool" as PFN_vkCreateDescriptorPool,
    destroy_pool = c"vkDestroyDescriptorPool" as PFN_vkDestroyDescriptorPool,
    allocate_sets = c"vkAllocateDescriptorSets" as PFN_vkAllocateDescriptorSets,
    update_sets = c"vkUpdateDescriptorSets" as PFN_vkUpdateDescriptorSets,
    cmd_copy = c"vkCmdCopyBuffer" as PFN_vkCmdCopyBuffer,
    cmd_barrier = c"vkCmdPipelineBarrier" as PFN_vkCmdPipelineBarrier,
    cmd_bind_pipeline = c"vkCmdBindPipeline" as PFN_vkCmdBindPipeline,
    cmd_bind_sets = c"vkCmdBindDescriptorSets" as PFN_vkCmdBindDescriptorSets,
    cmd_push_constants = c"vkCmdPushConstants" as PFN_vkCmdPushConstants,
    cmd_dispatch = c"vkCmdDispatch" as PFN_vkCmdDispatch,
}

pub(super) fn missing(name: &CStr) -> Error {
    let name = name.to_string_lossy();
    Error::Unsupported {
        what: format!("a Vulkan device without {name}: a device of Vulkan 1.1 has it, asked through its own instance"),
    }
}

/// What a Vulkan call answered, as an error where it is one.
pub(super) fn checked(call: &str, result: vk::Result) -> Result<(), Error> {
    match result {
        vk::Result::SUCCESS => Ok(()),
        vk::Result::ERROR_DEVICE_LOST => Err(Error::DeviceLost { call: call.into() }),
        other => Err(Error::Vulkan { call: call.into(), result: format!("{other:?}") }),
    }
}
