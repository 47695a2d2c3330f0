// After Epic's API reference of VulkanRHI: IVulkanDynamicRHI and FVulkanRHIAllocationInfo of 5.4, RHIGetVkCommandBuffer of 5.8.
#pragma once

#include "StandinRender.h"

#include <vulkan/vulkan.h>

struct FVulkanRHIAllocationInfo
{
	VkDeviceMemory Handle = VK_NULL_HANDLE;
	uint64 Offset = 0;
	uint64 Size = 0;
};

struct IVulkanDynamicRHI : public FDynamicRHI
{
	virtual ERHIInterfaceType GetInterfaceType() const override final { return ERHIInterfaceType::Vulkan; }
	virtual VkInstance RHIGetVkInstance() const = 0;
	virtual VkDevice RHIGetVkDevice() const = 0;
	virtual VkPhysicalDevice RHIGetVkPhysicalDevice() const = 0;
	virtual void* RHIGetVkDeviceProcAddr(const char* InName) const = 0;
	virtual void* RHIGetVkInstanceProcAddr(const char* InName) const = 0;
	virtual uint32 RHIGetGraphicsQueueFamilyIndex() const = 0;
#if STANDIN_ENGINE_MINOR >= 8
	virtual VkCommandBuffer RHIGetVkCommandBuffer() = 0;
#else
	virtual VkCommandBuffer RHIGetActiveVkCommandBuffer() = 0;
#endif
	virtual FVulkanRHIAllocationInfo RHIGetAllocationInfo(FRHIBuffer* InBuffer) const = 0;
	virtual void RHIFinishExternalComputeWork(VkCommandBuffer InCommandBuffer) = 0;
};

inline IVulkanDynamicRHI* GetIVulkanDynamicRHI()
{
	check(GDynamicRHI->GetInterfaceType() == ERHIInterfaceType::Vulkan);
	return static_cast<IVulkanDynamicRHI*>(GDynamicRHI);
}

/** An engine's Vulkan, on a device of vulkan_host.h. */
struct StandinVulkan
{
	StandinVulkan();
	~StandinVulkan();
	/** Whether RHIGetAllocationInfo() tells anything. */
	static bool bTells;
	/** Calls of RHIFinishExternalComputeWork(). */
	static std::atomic<uint64> Finished;
	/** Whether nobody wrote outside of the buffers that were made, when the device is idle. */
	static bool SpareIsUntouched();
	/** Whether the device is this machine's processor. */
	static bool IsSoftware();
};
