// An engine's Vulkan: one VkBuffer that all buffers are parts of, at offsets that suit vertices and nobody else, three frames in
// flight, a command buffer each.
#include "IVulkanDynamicRHI.h"

#include "vulkan_host.h"

#include <atomic>

namespace
{
	constexpr VkDeviceSize PoolSize = 64 << 20;
	constexpr uint32_t Poison = 0xCDCDCDCD;
	constexpr VkBufferUsageFlags PoolUsage = VK_BUFFER_USAGE_VERTEX_BUFFER_BIT | VK_BUFFER_USAGE_INDEX_BUFFER_BIT |
		VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT | VK_BUFFER_USAGE_STORAGE_TEXEL_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT |
		VK_BUFFER_USAGE_TRANSFER_DST_BIT;
	constexpr VkPipelineStageFlags Drawing = VK_PIPELINE_STAGE_VERTEX_INPUT_BIT | VK_PIPELINE_STAGE_VERTEX_SHADER_BIT;

	struct FBuffer : FRHIBuffer
	{
		VkDeviceSize Offset = 0;
	};

	struct FFrame
	{
		VkCommandBuffer Commands = VK_NULL_HANDLE;
		VkFence Done = VK_NULL_HANDLE;
		uint64 Submission = 0;
		bool bSubmitted = false;
		std::vector<HostBuffer> Staging;
	};

	struct FVulkanRHI final : IVulkanDynamicRHI
	{
		Host Device{};
		HostBuffer Pool{};
		VkDeviceSize Used = 16;
		FFrame Frames[3];
		FFrame* Open = Frames;
		uint64 Newest = 0, Finished = 0;
		std::vector<std::pair<VkDeviceSize, VkDeviceSize>> Parts;
		mutable std::mutex Mutex;  // of submissions: fences are polled from the render thread

		FVulkanRHI()
		{
			host_open(&Device);
			Pool = host_buffer(&Device, PoolSize, PoolUsage, false);
			const VkCommandBuffer Commands = host_begin(&Device);
			vkCmdFillBuffer(Commands, Pool.buffer, 0, VK_WHOLE_SIZE, Poison);
			host_barrier(Commands);
			host_run(&Device, Commands);
			for (FFrame& Frame : Frames)
			{
				const VkFenceCreateInfo Info = {VK_STRUCTURE_TYPE_FENCE_CREATE_INFO, nullptr, 0};
				VK(vkCreateFence(Device.device, &Info, nullptr, &Frame.Done));
			}
			Begin();
		}

		~FVulkanRHI() override
		{
			Submit();
			WaitIdle();
			for (FFrame& Frame : Frames)
			{
				Recycle(Frame);
				if (Frame.Commands)
				{
					vkFreeCommandBuffers(Device.device, Device.pool, 1, &Frame.Commands);
				}
				vkDestroyFence(Device.device, Frame.Done, nullptr);
			}
			host_destroy_buffer(&Device, &Pool);
			host_close(&Device);
		}

		VkInstance RHIGetVkInstance() const override { return Device.instance; }
		VkDevice RHIGetVkDevice() const override { return Device.device; }
		VkPhysicalDevice RHIGetVkPhysicalDevice() const override { return Device.physical_device; }
		void* RHIGetVkDeviceProcAddr(const char* Name) const override
		{
			return reinterpret_cast<void*>(vkGetDeviceProcAddr(Device.device, Name));
		}
		void* RHIGetVkInstanceProcAddr(const char* Name) const override
		{
			return reinterpret_cast<void*>(vkGetInstanceProcAddr(Device.instance, Name));
		}
		uint32 RHIGetGraphicsQueueFamilyIndex() const override { return Device.queue_family; }
#if STANDIN_ENGINE_MINOR >= 8
		VkCommandBuffer RHIGetVkCommandBuffer() override { return Open->Commands; }
#else
		VkCommandBuffer RHIGetActiveVkCommandBuffer() override { return Open->Commands; }
#endif
		FVulkanRHIAllocationInfo RHIGetAllocationInfo(FRHIBuffer* Buffer) const override
		{
			if (!StandinVulkan::bTells)
			{
				return {};
			}
			return {Pool.memory, static_cast<FBuffer*>(Buffer)->Offset, Buffer->Size};
		}
		void RHIFinishExternalComputeWork(VkCommandBuffer Commands) override
		{
			check(Commands == Open->Commands);
			++StandinVulkan::Finished;
		}

		std::shared_ptr<FRHIBuffer> Make(uint32 Size) override
		{
			auto Made = std::make_shared<FBuffer>();
			Made->Offset = Used;
			const std::lock_guard Lock(Mutex);
			Parts.push_back({Used, Size});
			// With a gap behind it, and 16 bytes off what anything else is aligned to.
			Used = (Used + Size + 1023) / 256 * 256 + 16;
			check(Used < PoolSize);
			return Made;
		}

		void Begin()
		{
			FFrame& Frame = *Open;
			Recycle(Frame);
			Frame.Commands = host_begin(&Device);
			Frame.Submission = ++Newest;
		}

		void Recycle(FFrame& Frame)
		{
			if (Frame.bSubmitted)
			{
				VK(vkWaitForFences(Device.device, 1, &Frame.Done, VK_TRUE, UINT64_MAX));
				const std::lock_guard Lock(Mutex);
				VK(vkResetFences(Device.device, 1, &Frame.Done));
				Finished = std::max(Finished, Frame.Submission);
				Frame.bSubmitted = false;
				vkFreeCommandBuffers(Device.device, Device.pool, 1, &Frame.Commands);
				Frame.Commands = VK_NULL_HANDLE;
			}
			for (HostBuffer& Each : Frame.Staging)
			{
				host_destroy_buffer(&Device, &Each);
			}
			Frame.Staging.clear();
		}

		void Submit() override
		{
			VK(vkEndCommandBuffer(Open->Commands));
			VkSubmitInfo Info{};
			Info.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO;
			Info.commandBufferCount = 1;
			Info.pCommandBuffers = &Open->Commands;
			{
				const std::lock_guard Lock(Mutex);
				VK(vkQueueSubmit(Device.queue, 1, &Info, Open->Done));
				Open->bSubmitted = true;
			}
			Open = Open + 1 == std::end(Frames) ? Frames : Open + 1;
			Begin();
		}

		void WaitIdle() override { VK(vkDeviceWaitIdle(Device.device)); }
		uint64 Current() override { return Open->Submission; }
		bool IsDone(uint64 Submission) override
		{
			const std::lock_guard Lock(Mutex);
			if (Submission <= Finished)
			{
				return true;
			}
			for (const FFrame& Frame : Frames)
			{
				if (Frame.bSubmitted && Frame.Submission == Submission)
				{
					return vkGetFenceStatus(Device.device, Frame.Done) == VK_SUCCESS;
				}
			}
			return false;
		}

		static void Barrier(VkCommandBuffer Commands, VkPipelineStageFlags Before, VkAccessFlags Made, VkPipelineStageFlags After,
			VkAccessFlags Seen)
		{
			const VkMemoryBarrier Memory = {VK_STRUCTURE_TYPE_MEMORY_BARRIER, nullptr, Made, Seen};
			vkCmdPipelineBarrier(Commands, Before, After, 0, 1, &Memory, 0, nullptr, 0, nullptr);
		}

		void Write(FRHIBuffer& Buffer, const std::vector<uint8>& Bytes) override
		{
			HostBuffer Staging = host_buffer(&Device, Bytes.size(), VK_BUFFER_USAGE_TRANSFER_SRC_BIT, true);
			std::memcpy(Staging.data, Bytes.data(), Bytes.size());
			const VkBufferCopy All = {0, static_cast<FBuffer&>(Buffer).Offset, Bytes.size()};
			Barrier(Open->Commands, Drawing | VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT,
				VK_ACCESS_TRANSFER_WRITE_BIT);
			vkCmdCopyBuffer(Open->Commands, Staging.buffer, Pool.buffer, 1, &All);
			Barrier(Open->Commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT, Drawing,
				VK_ACCESS_VERTEX_ATTRIBUTE_READ_BIT | VK_ACCESS_SHADER_READ_BIT);
			Open->Staging.push_back(Staging);
		}

		/** Ordered behind what a draw would be ordered behind, and no more. */
		std::vector<uint8> Read(FRHIBuffer& Buffer) override
		{
			HostBuffer Seen = host_buffer(&Device, Buffer.Size, VK_BUFFER_USAGE_TRANSFER_DST_BIT, true);
			const VkBufferCopy All = {static_cast<FBuffer&>(Buffer).Offset, 0, Buffer.Size};
			Barrier(Open->Commands, Drawing, 0, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_READ_BIT);
			vkCmdCopyBuffer(Open->Commands, Pool.buffer, Seen.buffer, 1, &All);
			Barrier(Open->Commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT,
				VK_PIPELINE_STAGE_HOST_BIT | Drawing, VK_ACCESS_HOST_READ_BIT);
			Submit();
			WaitIdle();
			const uint8* Data = static_cast<const uint8*>(Seen.data);
			std::vector<uint8> Bytes(Data, Data + Buffer.Size);
			host_destroy_buffer(&Device, &Seen);
			return Bytes;
		}
	};

	FVulkanRHI* Vulkan = nullptr;
	FDynamicRHI* Before = nullptr;
}

bool StandinVulkan::bTells = true;
std::atomic<uint64> StandinVulkan::Finished{0};

StandinVulkan::StandinVulkan()
{
	Before = GDynamicRHI;
	GDynamicRHI = Vulkan = new FVulkanRHI;
}

StandinVulkan::~StandinVulkan()
{
	GDynamicRHI = Before;
	delete Vulkan;
}

bool StandinVulkan::IsSoftware()
{
	return Vulkan->Device.software;
}

bool StandinVulkan::SpareIsUntouched()
{
	FBuffer Whole;
	Whole.Size = static_cast<uint32>(Vulkan->Used);
	const std::vector<uint8> Bytes = Vulkan->Read(Whole);
	std::vector<bool> Taken(Bytes.size());
	for (const auto& [Offset, Size] : Vulkan->Parts)
	{
		std::fill_n(Taken.begin() + static_cast<std::ptrdiff_t>(Offset), Size, true);
	}
	for (SIZE_T At = 0; At < Bytes.size(); ++At)
	{
		if (!Taken[At] && Bytes[At] != 0xCD)
		{
			return false;
		}
	}
	return true;
}
