#include "CrumpleVulkan.h"

#include "CrumpleBody.h"
#include "CrumpleLog.h"
#include "CrumpleVersion.h"

#include "DynamicRHI.h"
#include "Misc/ScopeLock.h"
#include "RenderingThread.h"

// RHIGetVkInstanceProcAddr() is documented from 5.4 on, and the loader is to be had by it alone.
#if CRUMPLE_WITH_VULKAN && CRUMPLE_ENGINE_AT_LEAST(4)

#include "IVulkanDynamicRHI.h"

#define CRUMPLE_VULKAN_FUNCTIONS(Each) \
	Each(vkCreateBuffer) \
	Each(vkDestroyBuffer) \
	Each(vkGetBufferMemoryRequirements2) \
	Each(vkBindBufferMemory) \
	Each(vkCmdPipelineBarrier)

struct FCrumpleVulkanDevice
{
	IVulkanDynamicRHI* RHI = nullptr;
	VkDevice Handle = VK_NULL_HANDLE;
#define CRUMPLE_MEMBER(Name) PFN_##Name Name = nullptr;
	CRUMPLE_VULKAN_FUNCTIONS(CRUMPLE_MEMBER)
#undef CRUMPLE_MEMBER

	VkBuffer Make(VkDeviceSize Size, VkBufferUsageFlags Usage, VkMemoryRequirements& OutNeeds, bool& bOutDedicated) const
	{
		VkBufferCreateInfo Info{};
		Info.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
		Info.size = Size;
		Info.usage = Usage;
		VkBuffer Buffer = VK_NULL_HANDLE;
		if (vkCreateBuffer(Handle, &Info, nullptr, &Buffer) != VK_SUCCESS)
		{
			return VK_NULL_HANDLE;
		}
		VkMemoryDedicatedRequirements Dedicated{};
		Dedicated.sType = VK_STRUCTURE_TYPE_MEMORY_DEDICATED_REQUIREMENTS;
		VkMemoryRequirements2 Needs{};
		Needs.sType = VK_STRUCTURE_TYPE_MEMORY_REQUIREMENTS_2;
		Needs.pNext = &Dedicated;
		VkBufferMemoryRequirementsInfo2 Of{};
		Of.sType = VK_STRUCTURE_TYPE_BUFFER_MEMORY_REQUIREMENTS_INFO_2;
		Of.buffer = Buffer;
		vkGetBufferMemoryRequirements2(Handle, &Of, &Needs);
		OutNeeds = Needs.memoryRequirements;
		bOutDedicated = Dedicated.prefersDedicatedAllocation || Dedicated.requiresDedicatedAllocation;
		return Buffer;
	}

	VkMemoryRequirements Ask(VkDeviceSize Size, VkBufferUsageFlags Usage, bool& bOutDedicated) const
	{
		VkMemoryRequirements Needs{};
		const VkBuffer Buffer = Make(Size, Usage, Needs, bOutDedicated);
		vkDestroyBuffer(Handle, Buffer, nullptr);
		return Needs;
	}

	/** A VkBuffer of Crumple's on the first Size bytes of Unreal's; OutBegin is where they begin in it. Null, and why. */
	VkBuffer Alias(FRHIBuffer* Buffer, VkDeviceSize Size, VkDeviceSize& OutBegin, FString& OutWhy) const
	{
		constexpr VkBufferUsageFlags Ours = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, Theirs = VK_BUFFER_USAGE_VERTEX_BUFFER_BIT;
		const FVulkanRHIAllocationInfo At = RHI->RHIGetAllocationInfo(Buffer);
		if (At.Handle == VK_NULL_HANDLE)
		{
			OutWhy = TEXT("the RHI does not tell where the vertex buffer lies");
			return VK_NULL_HANDLE;
		}
		bool bDedicated = false, bOursDedicated = false;
		const VkMemoryRequirements Vertex = Ask(Size, Theirs, bDedicated), Storage = Ask(Size, Ours, bOursDedicated);
		if (bDedicated)
		{
			OutWhy = TEXT("the driver wants vertex buffers in memory of their own");
			return VK_NULL_HANDLE;
		}
		if (Storage.alignment == 0 || (Vertex.memoryTypeBits & ~Storage.memoryTypeBits) != 0)
		{
			OutWhy = FString::Printf(TEXT("vertex buffers may lie in memory of types %#x, storage buffers in %#x alone"),
				Vertex.memoryTypeBits, Storage.memoryTypeBits);
			return VK_NULL_HANDLE;
		}
		OutBegin = At.Offset % Storage.alignment;
		VkMemoryRequirements Needs{};
		const VkBuffer Made = Make(OutBegin + Size, Ours, Needs, bOursDedicated);
		if (Made != VK_NULL_HANDLE && Needs.size <= OutBegin + At.Size
			&& vkBindBufferMemory(Handle, Made, At.Handle, At.Offset - OutBegin) == VK_SUCCESS)
		{
			return Made;
		}
		OutWhy = FString::Printf(TEXT("a storage buffer of %llu bytes does not go where the vertex buffer lies, which has %llu"),
			static_cast<unsigned long long>(Needs.size), static_cast<unsigned long long>(At.Size));
		vkDestroyBuffer(Handle, Made, nullptr);
		return VK_NULL_HANDLE;
	}

	VkCommandBuffer ActiveCommands() const
	{
#if CRUMPLE_ENGINE_AT_LEAST(8)
		return RHI->RHIGetVkCommandBuffer();
#else
		return RHI->RHIGetActiveVkCommandBuffer();
#endif
	}

	void Barrier(VkCommandBuffer Commands, VkPipelineStageFlags Before, VkAccessFlags Made, VkPipelineStageFlags After, VkAccessFlags Seen) const
	{
		VkMemoryBarrier Memory{};
		Memory.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER;
		Memory.srcAccessMask = Made;
		Memory.dstAccessMask = Seen;
		vkCmdPipelineBarrier(Commands, Before, After, 0, 1, &Memory, 0, nullptr, 0, nullptr);
	}
};

FCrumpleVulkan::FCrumpleVulkan(FCrumpleContext& InContext) : Context(InContext) {}

FCrumpleVulkan::~FCrumpleVulkan() = default;

bool FCrumpleVulkan::Attach(FString& OutWhy)
{
	if (Device || !WhyNot.IsEmpty())
	{
		OutWhy = WhyNot;
		return Device.IsValid();
	}
	const auto No = [&](const FString& Why)
	{
		OutWhy = WhyNot = Why;
		return false;
	};
	if (!GDynamicRHI || GDynamicRHI->GetInterfaceType() != ERHIInterfaceType::Vulkan)
	{
		return No(TEXT("the RHI is not Vulkan's; start with -vulkan for dents on the GPU"));
	}
	TUniquePtr<FCrumpleVulkanDevice> Made = MakeUnique<FCrumpleVulkanDevice>();
	Made->RHI = GetIVulkanDynamicRHI();
	Made->Handle = Made->RHI->RHIGetVkDevice();
#define CRUMPLE_LOAD(Name) \
	Made->Name = reinterpret_cast<PFN_##Name>(Made->RHI->RHIGetVkDeviceProcAddr(#Name)); \
	if (!Made->Name) \
	{ \
		return No(TEXT("the Vulkan device has no " #Name)); \
	}
	CRUMPLE_VULKAN_FUNCTIONS(CRUMPLE_LOAD)
#undef CRUMPLE_LOAD
	CrumpleVulkanAttachDef Def = crumple_vulkan_attach_def_default();
	Def.get_instance_proc_addr = reinterpret_cast<CrumpleVulkanFunction>(Made->RHI->RHIGetVkInstanceProcAddr("vkGetInstanceProcAddr"));
	Def.instance = Made->RHI->RHIGetVkInstance();
	Def.physical_device = Made->RHI->RHIGetVkPhysicalDevice();
	Def.device = Made->Handle;
	Def.queue_family = Made->RHI->RHIGetGraphicsQueueFamilyIndex();
	const CrumpleResult Result = crumple_vulkan_attach(Context.Get(), &Def);
	if (Result != CRUMPLE_OK)
	{
		return No(CrumpleWhy(Result));
	}
	Device = MoveTemp(Made);
	return true;
}

FCrumpleRangeId FCrumpleVulkan::Register(FCrumpleBody& Body, FRHIBuffer* Buffer, FString& OutWhy)
{
	FScopeLock Lock(&Context.Mutex);
	if (Body.Get().index == 0)
	{
		OutWhy = TEXT("the body is gone");
		return 0;
	}
	if (!Attach(OutWhy))
	{
		if (!bTold)
		{
			UE_LOG(LogCrumple, Log, TEXT("Dents are made on the CPU: %s"), *OutWhy);
			bTold = true;
		}
		return 0;
	}
	Poll();
	const FCrumpleLayout& Layout = Body.Layout;
	VkDeviceSize Begin = 0;
	const VkBuffer Alias = Device->Alias(Buffer, Layout.Size(), Begin, OutWhy);
	if (Alias == VK_NULL_HANDLE)
	{
		UE_LOG(LogCrumple, Warning, TEXT("Dents of a body are made on the CPU: %s"), *OutWhy);
		return 0;
	}
	CrumpleVulkanBufferDef Def = crumple_vulkan_buffer_def_default();
	Def.lod = Body.Shape->Lod;
	Def.buffer = (uint64_t)Alias;
	Def.buffer_size = Begin + Layout.Size();
	Def.usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
	// Nothing but Crumple ever uses this VkBuffer: its barriers order Crumple's own passes. Record() orders the rest.
	Def.before_stages = Def.after_stages = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT;
	Def.before_access = VK_ACCESS_SHADER_WRITE_BIT;
	Def.after_access = VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT;
	Def.offset = Begin;
	Def.size = Layout.Size();
	const uint64 Basis = Layout.BasisBegin();
	Def.positions = {0, FCrumpleLayout::PositionStride, VK_FORMAT_R32G32B32_SFLOAT, 0};
	Def.tangents = {Basis, FCrumpleLayout::BasisStride, VK_FORMAT_R32G32B32A32_SFLOAT, 0};
	Def.normals = {Basis + FCrumpleLayout::NormalOffset, FCrumpleLayout::BasisStride, VK_FORMAT_R32G32B32_SFLOAT, 0};
	CrumpleBuffer Made{};
	const CrumpleResult Result = crumple_buffer_register_vulkan(Context.Get(), Body.Get(), &Def, &Made);
	if (Result != CRUMPLE_OK)
	{
		Device->vkDestroyBuffer(Device->Handle, Alias, nullptr);
		OutWhy = CrumpleWhy(Result);
		UE_LOG(LogCrumple, Warning, TEXT("Dents of a body are made on the CPU: %s"), *OutWhy);
		return 0;
	}
	Ranges.Add(FRange{++NewestRange, Body.Get(), Made, (uint64)Alias, Buffer, false});
	return NewestRange;
}

void FCrumpleVulkan::Unregister(FCrumpleRangeId Id)
{
	FScopeLock Lock(&Context.Mutex);
	for (int32 Index = 0; Index < Ranges.Num(); ++Index)
	{
		if (Ranges[Index].Id == Id)
		{
			const FRange Range = Ranges[Index];
			Ranges.RemoveAt(Index);
			if (Range.Buffer.index != 0)
			{
				crumple_buffer_unregister(Context.Get(), Range.Buffer);
			}
			Retired.Add(FRetired{NewestFrame, Range.Alias, Range.Memory});
			return;
		}
	}
}

void FCrumpleVulkan::Forget(CrumpleInstance Instance)
{
	for (FRange& Range : Ranges)
	{
		if (Range.Instance.index == Instance.index && Range.Instance.generation == Instance.generation)
		{
			Range.Buffer = {};
		}
	}
}

void FCrumpleVulkan::Update(FRHICommandListImmediate& RHICmdList, FCrumpleRangeId Id)
{
	uint64 Frame = 0;
	FGPUFenceRHIRef Fence;
	TArray<FCrumpleRangeId> Alone;
	{
		FScopeLock Lock(&Context.Mutex);
		const FRange* Range = Ranges.FindByPredicate([&](const FRange& Each) { return Each.Id == Id; });
		if (!Device || !Range || Range->Buffer.index == 0)
		{
			return;
		}
		Poll();
		if (!Range->bRecorded)
		{
			// What fills the new buffer waits for the RHI thread, perhaps behind a recording that others asked for: not with them.
			Alone.Add(Id);
		}
		else
		{
			const bool bFirst = Due.Num() == 0;
			// It may wait already: the RHI thread can be a frame behind.
			if (!Due.FindByPredicate([&](FCrumpleRangeId Each) { return Each == Id; }))
			{
				Due.Add(Id);
			}
			if (!bFirst)
			{
				return;  // goes with the others
			}
		}
		Frame = ++NewestFrame;
		Fence = Fences.Num() > 0 ? Fences.Pop() : RHICreateGPUFence(TEXT("Crumple"));
		InFlight.Add(FInFlight{Frame, Fence});
	}
	RHICmdList.EnqueueLambda([this, Keep = Context.AsShared(), Frame, Alone](auto&) { Record(Frame, Alone); });
	RHICmdList.WriteGPUFence(Fence);
}

void FCrumpleVulkan::Record(uint64 Frame, TArray<FCrumpleRangeId> Asked)
{
	FScopeLock Lock(&Context.Mutex);
	if (Asked.Num() == 0)
	{
		Asked = MoveTemp(Due);
		Due.Empty();
	}
	TArray<CrumpleBuffer> Buffers;
	for (FRange& Range : Ranges)
	{
		if (Range.Buffer.index != 0 && Asked.FindByPredicate([&](FCrumpleRangeId Each) { return Each == Range.Id; }))
		{
			Range.bRecorded = true;
			Buffers.Add(Range.Buffer);
		}
	}
	if (!Device || Buffers.Num() == 0)
	{
		return;
	}
	constexpr VkPipelineStageFlags Everything = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, Compute = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT;
	constexpr VkAccessFlags Ours = VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT;
	const VkCommandBuffer Commands = Device->ActiveCommands();
	Device->Barrier(Commands, Everything, VK_ACCESS_MEMORY_WRITE_BIT, Compute, Ours);
	const CrumpleResult Result = crumple_vulkan_record(Context.Get(), Commands, Frame, Buffers.GetData(), Buffers.Num(), nullptr);
	if (Result != CRUMPLE_OK)
	{
		UE_LOG(LogCrumple, Error, TEXT("%s"), *CrumpleWhy(Result));
	}
	Device->Barrier(Commands, Compute, VK_ACCESS_SHADER_WRITE_BIT, Everything, VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT);
	Device->RHI->RHIFinishExternalComputeWork(Commands);
}

void FCrumpleVulkan::Poll()
{
	// Fences stand behind the commands of their frame, and pass in that order: counting frames of the CPU would be a guess.
	while (InFlight.Num() > 0 && InFlight[0].Fence->Poll())
	{
		const FInFlight Done = InFlight[0];
		InFlight.RemoveAt(0);
		Done.Fence->Clear();
		Fences.Add(Done.Fence);
		Complete(Done.Frame);
	}
	if (InFlight.Num() == 0)
	{
		Complete(NewestFrame);
	}
}

void FCrumpleVulkan::Complete(uint64 Frame)
{
	crumple_vulkan_complete_frames(Context.Get(), Frame);
	Retired.RemoveAll(
		[&](const FRetired& Each)
		{
			if (Each.Frame <= Frame)
			{
				Device->vkDestroyBuffer(Device->Handle, (VkBuffer)Each.Alias, nullptr);
			}
			return Each.Frame <= Frame;
		});
}

void FCrumpleVulkan::Detach()
{
	{
		FScopeLock Lock(&Context.Mutex);
		WhyNot = TEXT("the engine shuts down");
		if (!Device)
		{
			return;
		}
	}
	check(IsInGameThread());
	ENQUEUE_RENDER_COMMAND(CrumpleDetach)([](FRHICommandListImmediate& RHICmdList) { RHICmdList.BlockUntilGPUIdle(); });
	FlushRenderingCommands();
	FScopeLock Lock(&Context.Mutex);
	for (const FRange& Range : Ranges)
	{
		Retired.Add(FRetired{0, Range.Alias, Range.Memory});
	}
	Ranges.Empty();
	Due.Empty();
	InFlight.Empty();
	Fences.Empty();
	Complete(MAX_uint64);
	const CrumpleResult Result = crumple_vulkan_detach(Context.Get());
	if (Result != CRUMPLE_OK)
	{
		UE_LOG(LogCrumple, Error, TEXT("%s"), *CrumpleWhy(Result));
	}
	Device.Reset();
}

#else

struct FCrumpleVulkanDevice
{
};

FCrumpleVulkan::FCrumpleVulkan(FCrumpleContext& InContext) : Context(InContext) {}

FCrumpleVulkan::~FCrumpleVulkan() = default;

FCrumpleRangeId FCrumpleVulkan::Register(FCrumpleBody&, FRHIBuffer*, FString& OutWhy)
{
	OutWhy = TEXT("this plugin was compiled without Vulkan: not on a Mac, and not below Unreal 5.4");
	FScopeLock Lock(&Context.Mutex);
	if (!bTold)
	{
		UE_LOG(LogCrumple, Log, TEXT("Dents are made on the CPU: %s"), *OutWhy);
		bTold = true;
	}
	return 0;
}

void FCrumpleVulkan::Unregister(FCrumpleRangeId) {}
void FCrumpleVulkan::Forget(CrumpleInstance) {}
void FCrumpleVulkan::Update(FRHICommandListImmediate&, FCrumpleRangeId) {}
void FCrumpleVulkan::Detach() {}

#endif
