// Stand-ins for what the plugin uses of RHI, RenderCore, Engine's rendering and VulkanRHI; see StandinCore.h. Names and signatures
// after Epic's API reference: RHI and RenderCore 5.3 to 5.5, IVulkanDynamicRHI 5.4.
//
// They behave: render commands run on a thread of their own, what those enqueue on another (the RHI thread), a frame is one command
// buffer, and three of them are in flight.
#pragma once

#include "StandinCore.h"

// RHI resources.
enum EBufferUsageFlags : uint32
{
	BUF_Static = 1,
	BUF_UnorderedAccess = 2,
	BUF_VertexBuffer = 4,
	BUF_ShaderResource = 8,
	BUF_IndexBuffer = 16
};
inline EBufferUsageFlags operator|(EBufferUsageFlags A, EBufferUsageFlags B) { return EBufferUsageFlags(uint32(A) | uint32(B)); }
enum class ERHIAccess : uint32
{
	VertexOrIndexBuffer = 1,
	SRVMask = 2
};
inline ERHIAccess operator|(ERHIAccess A, ERHIAccess B) { return ERHIAccess(uint32(A) | uint32(B)); }
enum EResourceLockMode
{
	RLM_ReadOnly,
	RLM_WriteOnly
};
enum EPixelFormat : uint8
{
	PF_Unknown,
	PF_R32_FLOAT,
	PF_A32B32G32R32F
};
enum class ERHIInterfaceType
{
	Null,
	Vulkan
};
namespace ERHIFeatureLevel
{
	enum Type
	{
		SM5
	};
}
struct FRHIResourceCreateInfo
{
	explicit FRHIResourceCreateInfo(const TCHAR*) {}
};

template <typename T>
class TRefCountPtr
{
public:
	TRefCountPtr() = default;
	TRefCountPtr(T* Pointer) : Held(Pointer ? Pointer->StandinShared() : nullptr) {}
	operator T*() const { return Held.get(); }
	T* operator->() const { return Held.get(); }
	void SafeRelease() { Held.reset(); }

private:
	std::shared_ptr<T> Held;
};

struct FRHIBuffer : std::enable_shared_from_this<FRHIBuffer>
{
	virtual ~FRHIBuffer() = default;
	std::shared_ptr<FRHIBuffer> StandinShared() { return shared_from_this(); }
	uint32 Size = 0;
	std::vector<uint8> Locked;
};
using FBufferRHIRef = TRefCountPtr<FRHIBuffer>;

struct FRHIGPUFence : std::enable_shared_from_this<FRHIGPUFence>
{
	std::shared_ptr<FRHIGPUFence> StandinShared() { return shared_from_this(); }
	bool Poll() const;
	void Clear() { Submission = 0; }
	std::atomic<uint64> Submission{0};  // 0: not inserted
};
using FGPUFenceRHIRef = TRefCountPtr<FRHIGPUFence>;

struct FRHIViewDesc
{
	enum class EBufferType : uint8
	{
		Unknown,
		Typed
	};
	struct FBufferSRV
	{
		struct FInitializer
		{
			FInitializer& SetType(EBufferType In) { return Type = In, *this; }
			FInitializer& SetFormat(EPixelFormat In) { return Format = In, *this; }
			FInitializer& SetOffsetInBytes(uint32 In) { return Offset = In, *this; }
			FInitializer& SetNumElements(uint32 In) { return Elements = In, *this; }
			EBufferType Type = EBufferType::Unknown;
			EPixelFormat Format = PF_Unknown;
			uint32 Offset = 0, Elements = 0;
		};
	};
	static FBufferSRV::FInitializer CreateBufferSRV() { return {}; }
};
struct FRHIShaderResourceView : std::enable_shared_from_this<FRHIShaderResourceView>
{
	std::shared_ptr<FRHIShaderResourceView> StandinShared() { return shared_from_this(); }
	FBufferRHIRef Buffer;
	FRHIViewDesc::FBufferSRV::FInitializer View;
};
using FShaderResourceViewRHIRef = TRefCountPtr<FRHIShaderResourceView>;

class FRHICommandListBase
{
public:
	FBufferRHIRef CreateBuffer(uint32 Size, EBufferUsageFlags Usage, uint32 Stride, ERHIAccess State, FRHIResourceCreateInfo& Info);
	FBufferRHIRef CreateIndexBuffer(uint32 Stride, uint32 Size, EBufferUsageFlags Usage, FRHIResourceCreateInfo& Info);
	FShaderResourceViewRHIRef CreateShaderResourceView(FRHIBuffer* Buffer, FRHIViewDesc::FBufferSRV::FInitializer const& ViewDesc);
	void* LockBuffer(FRHIBuffer* Buffer, uint32 Offset, uint32 Size, EResourceLockMode Mode);
	void UnlockBuffer(FRHIBuffer* Buffer);
};
class FRHICommandListImmediate : public FRHICommandListBase
{
public:
	template <typename LambdaType>
	void EnqueueLambda(LambdaType&& Lambda)
	{
		Enqueue([this, Lambda = std::forward<LambdaType>(Lambda)]() mutable { Lambda(*this); });
	}
	void WriteGPUFence(FRHIGPUFence* Fence);
	void BlockUntilGPUIdle();
	void Enqueue(std::function<void()> Work);
};
FGPUFenceRHIRef RHICreateGPUFence(const FName& Name);

struct FDynamicRHI
{
	virtual ~FDynamicRHI() = default;
	virtual ERHIInterfaceType GetInterfaceType() const = 0;
	// What stands behind the command lists. RHI thread, but for Make.
	virtual std::shared_ptr<FRHIBuffer> Make(uint32 Size) = 0;
	virtual void Write(FRHIBuffer& Buffer, const std::vector<uint8>& Bytes) = 0;
	/** What a draw of this frame would read of the buffer, when the frame was submitted and is done. */
	virtual std::vector<uint8> Read(FRHIBuffer& Buffer) = 0;
	virtual void Submit() {}
	virtual void WaitIdle() {}
	virtual uint64 Current() { return 1; }
	virtual bool IsDone(uint64) { return true; }
};
extern FDynamicRHI* GDynamicRHI;

// Threads.
bool IsInGameThread();
void StandinRenderCommand(std::function<void(FRHICommandListImmediate&)> Command);
void FlushRenderingCommands();
struct StandinEnqueue
{
	template <typename LambdaType>
	void operator()(LambdaType&& Lambda) const
	{
		StandinRenderCommand(std::forward<LambdaType>(Lambda));
	}
};
#define ENQUEUE_RENDER_COMMAND(Name) StandinEnqueue()
/** Starts and ends the two threads. */
struct StandinThreads
{
	StandinThreads();
	~StandinThreads();
};

// Render resources.
class FRenderResource
{
public:
	virtual ~FRenderResource() { check(!bInitialized); }
	virtual void InitRHI(FRHICommandListBase&) {}
	virtual void ReleaseRHI() {}
	void InitResource(FRHICommandListBase& RHICmdList)
	{
		InitRHI(RHICmdList);
		bInitialized = true;
	}
	void ReleaseResource()
	{
		if (bInitialized)
		{
			ReleaseRHI();
		}
		bInitialized = false;
	}

private:
	bool bInitialized = false;
};
class FVertexBuffer : public FRenderResource
{
public:
	virtual void ReleaseRHI() override { VertexBufferRHI.SafeRelease(); }
	FBufferRHIRef VertexBufferRHI;
};
class FIndexBuffer : public FRenderResource
{
public:
	virtual void ReleaseRHI() override { IndexBufferRHI.SafeRelease(); }
	FBufferRHIRef IndexBufferRHI;
};
enum EVertexElementType
{
	VET_None,
	VET_Float3,
	VET_Float4
};
enum class EVertexStreamUsage : uint8
{
	Default = 0,
	ManualFetch = 4
};
struct FVertexStreamComponent
{
	FVertexStreamComponent() = default;
	FVertexStreamComponent(const FVertexBuffer* InVertexBuffer, uint32 InOffset, uint32 InStride, EVertexElementType InType,
		EVertexStreamUsage Usage = EVertexStreamUsage::Default)
		: FVertexStreamComponent(InVertexBuffer, 0, InOffset, InStride, InType, Usage)
	{
	}
	FVertexStreamComponent(const FVertexBuffer* InVertexBuffer, uint32 InStreamOffset, uint32 InOffset, uint32 InStride,
		EVertexElementType InType, EVertexStreamUsage Usage = EVertexStreamUsage::Default)
		: VertexBuffer(InVertexBuffer), StreamOffset(InStreamOffset), Offset(uint8(InOffset)), Stride(uint8(InStride)), Type(InType), VertexStreamUsage(Usage)
	{
	}
	const FVertexBuffer* VertexBuffer = nullptr;
	uint32 StreamOffset = 0;
	uint8 Offset = 0, Stride = 0;
	EVertexElementType Type = VET_None;
	EVertexStreamUsage VertexStreamUsage = EVertexStreamUsage::Default;
};
struct FStaticMeshDataType
{
	FVertexStreamComponent PositionComponent, TangentBasisComponents[2];
	FRHIShaderResourceView *PositionComponentSRV = nullptr, *TangentsSRV = nullptr;
	const class FStaticMeshVertexBuffer* StandinTexCoords = nullptr;
	const class FColorVertexBuffer* StandinColors = nullptr;
};
class FVertexFactory : public FRenderResource
{
};
class FLocalVertexFactory : public FVertexFactory
{
public:
	struct FDataType : public FStaticMeshDataType
	{
	};
	FLocalVertexFactory(ERHIFeatureLevel::Type, const char*) {}
#if STANDIN_ENGINE_MINOR >= 4
	void SetData(FRHICommandListBase&, const FDataType& In) { StandinData = In; }
#else
	void SetData(const FDataType& In) { StandinData = In; }
#endif
	FDataType StandinData;
};

// A static mesh's buffers.
class FPositionVertexBuffer
{
public:
	uint32 GetNumVertices() const { return uint32(Standin.Num()); }
	const FVector3f& VertexPosition(uint32 Vertex) const { return Standin[int32(Vertex)]; }
	TArray<FVector3f> Standin;
};
class FStaticMeshVertexBuffer : public FRenderResource
{
public:
	void SetUseFullPrecisionUVs(bool) {}
	void Init(uint32 Vertices, uint32 InTexCoords, bool = true)
	{
		TexCoords = InTexCoords;
		Standin.SetNum(int32(Vertices));
		StandinUVs.SetNum(int32(Vertices * InTexCoords));
	}
	uint32 GetNumTexCoords() const { return TexCoords; }
	FVector4f VertexTangentX(uint32 Vertex) const { return Standin[int32(Vertex)].X; }
	FVector4f VertexTangentZ(uint32 Vertex) const { return Standin[int32(Vertex)].Z; }
	FVector2f GetVertexUV(uint32 Vertex, uint32 Channel) const { return StandinUVs[int32(Vertex * TexCoords + Channel)]; }
	void SetVertexUV(uint32 Vertex, uint32 Channel, const FVector2f& UV) { StandinUVs[int32(Vertex * TexCoords + Channel)] = UV; }
	void SetVertexTangents(uint32 Vertex, const FVector3f& X, const FVector3f& Y, const FVector3f& Z)
	{
		const float Sign = FVector3f::DotProduct(FVector3f::CrossProduct(Z, X), Y) < 0 ? -1.0f : 1.0f;
		Standin[int32(Vertex)] = {FVector4f(X.X, X.Y, X.Z, 0), FVector4f(Z.X, Z.Y, Z.Z, Sign)};
	}
	void BindTexCoordVertexBuffer(const FVertexFactory*, FStaticMeshDataType& Data) const { Data.StandinTexCoords = this; }
	void BindLightMapVertexBuffer(const FVertexFactory*, FStaticMeshDataType&, int) const {}
	struct FBasis
	{
		FVector4f X, Z;
	};
	TArray<FBasis> Standin;
	TArray<FVector2f> StandinUVs;

private:
	uint32 TexCoords = 0;
};
class FColorVertexBuffer : public FVertexBuffer
{
public:
	uint32 GetNumVertices() const { return uint32(Standin.Num()); }
	const FColor& VertexColor(uint32 Vertex) const { return Standin[int32(Vertex)]; }
	void InitFromColorArray(const TArray<FColor>& Colors) { Standin = Colors; }
	void BindColorVertexBuffer(const FVertexFactory*, FStaticMeshDataType& Data) const { Data.StandinColors = this; }
	TArray<FColor> Standin;
};

// Materials.
class FMaterialRenderProxy
{
};
struct FPrimitiveViewRelevance
{
	bool bDrawRelevance = false, bShadowRelevance = false, bDynamicRelevance = false, bRenderInMainPass = false,
		 bUsesLightingChannels = false, bRenderCustomDepth = false, bVelocityRelevance = false, bOpaque = false;
};
struct FMaterialRelevance
{
	void SetPrimitiveViewRelevance(FPrimitiveViewRelevance& Out) const { Out.bOpaque = true; }
};

// The scene.
struct FSceneView
{
};
struct FSceneViewFamily
{
};
enum EPrimitiveType
{
	PT_TriangleList
};
enum ESceneDepthPriorityGroup
{
	SDPG_World
};
struct FMeshBatchElement
{
	const FIndexBuffer* IndexBuffer = nullptr;
	uint32 FirstIndex = 0, NumPrimitives = 0, MinVertexIndex = 0, MaxVertexIndex = 0;
};
struct FMeshBatch
{
	FMeshBatchElement Elements[1];
	const FVertexFactory* VertexFactory = nullptr;
	const FMaterialRenderProxy* MaterialRenderProxy = nullptr;
	uint32 ReverseCulling : 1 = 0;
	uint32 Type : 4 = 0;
	uint32 DepthPriorityGroup : 4 = 0;
};
class FMeshElementCollector
{
public:
	FMeshBatch& AllocateMesh() { return *StandinAll.emplace_back(std::make_unique<FMeshBatch>()); }
	void AddMesh(int32, FMeshBatch& Mesh) { StandinAdded.push_back(&Mesh); }
	std::vector<std::unique_ptr<FMeshBatch>> StandinAll;
	std::vector<FMeshBatch*> StandinAdded;
};
class FSceneInterface
{
public:
	ERHIFeatureLevel::Type GetFeatureLevel() const { return ERHIFeatureLevel::SM5; }
};
class UPrimitiveComponent;
class FPrimitiveSceneProxy
{
public:
	explicit FPrimitiveSceneProxy(const UPrimitiveComponent* Component, FName = NAME_None);
	virtual ~FPrimitiveSceneProxy() = default;
	virtual SIZE_T GetTypeHash() const = 0;
	virtual uint32 GetMemoryFootprint() const = 0;
	virtual FPrimitiveViewRelevance GetViewRelevance(const FSceneView* View) const = 0;
	virtual void GetDynamicMeshElements(const TArray<const FSceneView*>& Views, const FSceneViewFamily& ViewFamily, uint32 VisibilityMap,
		FMeshElementCollector& Collector) const = 0;
	FSceneInterface& GetScene() const;
	uint32 GetAllocatedSize() const { return 0; }
	bool IsLocalToWorldDeterminantNegative() const { return StandinLocalToWorld.Determinant() < 0; }
	bool IsShown(const FSceneView*) const { return true; }
	bool IsShadowCast(const FSceneView*) const { return true; }
	bool ShouldRenderInMainPass() const { return true; }
	bool ShouldRenderCustomDepth() const { return false; }
	bool DrawsVelocity() const { return true; }
	uint8 GetLightingChannelMask() const { return 1; }
	static uint8 GetDefaultLightingChannelMask() { return 1; }
	FMatrix StandinLocalToWorld{ForceInit};
	FBoxSphereBounds StandinLocalBounds;
};
