// Crumple's commands in Unreal's own Vulkan command buffer.
//
// IVulkanDynamicRHI gives no VkBuffer, only where a buffer lies in which memory. So a second VkBuffer, for storage, is bound to that
// range: buffers are linear, and two of them see the same bytes. It is done where Vulkan's specification says that it may be, and
// refused otherwise (the CPU path then does the work, and the log says why once):
//   - Memory type. Unreal's buffer is one for vertices among others, and memoryTypeBits of a usage are a subset of those of a part
//     of that usage: where every type that a vertex buffer may lie in is good for a storage buffer, Unreal's choice is.
//   - Alignment. Where Unreal's offset is none for a storage buffer, ours begins below it, and the range begins later.
//   - Size. What is bound ends within Unreal's allocation.
//   - Dedicated memory belongs to one buffer alone. Drivers that ask for that are refused.
//   - Order. Crumple's barriers name our VkBuffer, draws read Unreal's: memory barriers of our own go around them.
#pragma once

#include "CoreMinimal.h"
#include "RHI.h"
#include "RHICommandList.h"
#include "RHIResources.h"

#include "crumple_vulkan.h"

class FCrumpleBody;
class FCrumpleContext;

/** A range of a buffer that Crumple writes. 0 is none. */
using FCrumpleRangeId = uint64;

struct FCrumpleVulkanDevice;

class FCrumpleVulkan
{
public:
	explicit FCrumpleVulkan(FCrumpleContext& InContext);
	~FCrumpleVulkan();

	/** Shows a body in a buffer, which has the body's layout and Spare bytes more. 0, and why, where that cannot be. Render thread. */
	FCrumpleRangeId Register(FCrumpleBody& Body, FRHIBuffer* Buffer, FString& OutWhy);
	void Unregister(FCrumpleRangeId Range);
	/** Brings a range up to date in this frame, with all others that ask before it is recorded. Render thread, outside of a
	    render pass. */
	void Update(FRHICommandListImmediate& RHICmdList, FCrumpleRangeId Range);

	/** The instance is about to go, and with it its ranges. The context's Mutex is held. */
	void Forget(CrumpleInstance Instance);

	/** Waits for the GPU and lets go of Unreal's device, for good. Game thread, before the RHI goes. */
	void Detach();

	static constexpr uint32 Spare = 256;

private:
	struct FRange
	{
		FCrumpleRangeId Id;
		CrumpleInstance Instance;
		CrumpleBuffer Buffer;
		uint64 Alias;
		FBufferRHIRef Memory;
		bool bRecorded;  // at least once
	};

	/** What the GPU may still use. */
	struct FRetired
	{
		uint64 Frame;
		uint64 Alias;
		FBufferRHIRef Memory;
	};

	struct FInFlight
	{
		uint64 Frame;
		FGPUFenceRHIRef Fence;
	};

	bool Attach(FString& OutWhy);
	/** What was asked for, or what is due. RHI thread. */
	void Record(uint64 Frame, TArray<FCrumpleRangeId> Asked);
	void Poll();
	void Complete(uint64 Frame);

	FCrumpleContext& Context;
	TUniquePtr<FCrumpleVulkanDevice> Device;
	FString WhyNot;  // once it is known that there will be none
	bool bTold = false;
	TArray<FRange> Ranges;
	TArray<FCrumpleRangeId> Due;  // goes with the next recording
	TArray<FInFlight> InFlight;  // the oldest first
	TArray<FGPUFenceRHIRef> Fences;
	TArray<FRetired> Retired;
	FCrumpleRangeId NewestRange = 0;
	uint64 NewestFrame = 0;
};
