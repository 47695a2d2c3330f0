#include "CrumpleSceneProxy.h"

#include "CrumpleComponent.h"
#include "CrumpleVersion.h"

#include "Engine/Engine.h"
#include "MaterialDomain.h"
#include "Materials/Material.h"
#include "Materials/MaterialRenderProxy.h"
#include "MeshBatch.h"
#include "RenderingThread.h"
#include "SceneInterface.h"
#include "SceneManagement.h"

static void Fill(FRHICommandListBase& RHICmdList, FRHIBuffer* Buffer, const void* Data, uint32 Size)
{
	void* Locked = RHICmdList.LockBuffer(Buffer, 0, Size, RLM_WriteOnly);
	FMemory::Memcpy(Locked, Data, Size);
	RHICmdList.UnlockBuffer(Buffer);
}

void FCrumpleVertexBuffer::InitRHI(FRHICommandListBase& RHICmdList)
{
	// Written by shaders: so that it lies in the GPU's own memory, where the GPU path writes it.
	const EBufferUsageFlags Usage = BUF_Static | BUF_VertexBuffer | BUF_ShaderResource | BUF_UnorderedAccess;
	FRHIResourceCreateInfo Info(TEXT("Crumple vertices"));
	VertexBufferRHI = RHICmdList.CreateBuffer(Layout.Size() + FCrumpleVulkan::Spare, Usage, 0,
		ERHIAccess::VertexOrIndexBuffer | ERHIAccess::SRVMask, Info);
	Fill(RHICmdList, VertexBufferRHI, Initial.GetData(), Initial.Num());
	Positions = RHICmdList.CreateShaderResourceView(VertexBufferRHI, FRHIViewDesc::CreateBufferSRV()
		.SetType(FRHIViewDesc::EBufferType::Typed).SetFormat(PF_R32_FLOAT).SetOffsetInBytes(0).SetNumElements(3 * Layout.Vertices));
	Basis = RHICmdList.CreateShaderResourceView(VertexBufferRHI, FRHIViewDesc::CreateBufferSRV()
		.SetType(FRHIViewDesc::EBufferType::Typed).SetFormat(PF_A32B32G32R32F).SetOffsetInBytes(Layout.BasisBegin())
		.SetNumElements(2 * Layout.Vertices));
}

void FCrumpleVertexBuffer::ReleaseRHI()
{
	Positions.SafeRelease();
	Basis.SafeRelease();
	FVertexBuffer::ReleaseRHI();
}

void FCrumpleIndexBuffer::InitRHI(FRHICommandListBase& RHICmdList)
{
	FRHIResourceCreateInfo Info(TEXT("Crumple indices"));
	const uint32 Size = static_cast<uint32>(Indices.Num() * sizeof(uint32));
	IndexBufferRHI = RHICmdList.CreateIndexBuffer(sizeof(uint32), Size, BUF_Static, Info);
	Fill(RHICmdList, IndexBufferRHI, Indices.GetData(), Size);
}

FCrumpleSceneProxy::FCrumpleSceneProxy(const UCrumpleComponent& Component, TSharedRef<FCrumpleBody> InBody, bool bUseGPU)
	: FPrimitiveSceneProxy(&Component)
	, Body(InBody)
	, MaterialRelevance(Component.GetMaterialRelevance(GetScene().GetFeatureLevel()))
	, VertexFactory(GetScene().GetFeatureLevel(), "FCrumpleSceneProxy")
{
	const FCrumpleMeshData& Mesh = Body->Shape->Mesh;
	for (const FCrumpleMeshData::FSection& Section : Mesh.Sections)
	{
		const UMaterialInterface* Material = Component.GetMaterial(Section.Material);
		Materials.Add((Material ? Material : UMaterial::GetDefaultMaterial(MD_Surface))->GetRenderProxy());
	}
	Vertices.Layout = Body->Layout;
	Indices.Indices = Mesh.Indices;
	if (Body->Shape->Space.Handedness() < 0)
	{
		// The buffer is a mirror image of the static mesh, which the render matrix mirrors back. Unreal turns the winding of what is
		// drawn under such a matrix, so it must be turned here.
		for (int32 Index = 0; Index + 2 < Indices.Indices.Num(); Index += 3)
		{
			Swap(Indices.Indices[Index + 1], Indices.Indices[Index + 2]);
		}
	}
	const int32 Channels = FMath::Max(1, Mesh.TexCoordChannels);
	TexCoords.SetUseFullPrecisionUVs(true);
	TexCoords.Init(Mesh.Num(), Channels);
	for (int32 Vertex = 0; Vertex < Mesh.Num(); ++Vertex)
	{
		TexCoords.SetVertexTangents(Vertex, FVector3f(1, 0, 0), FVector3f(0, 1, 0), FVector3f(0, 0, 1));
		for (int32 Channel = 0; Channel < Channels; ++Channel)
		{
			TexCoords.SetVertexUV(Vertex, Channel,
				Channel < Mesh.TexCoordChannels ? Mesh.TexCoords[Channel * Mesh.Num() + Vertex] : FVector2f(0, 0));
		}
	}
	Colors.InitFromColorArray(Mesh.Colors);
	// The engine deletes proxies on the render thread, after this.
	ENQUEUE_RENDER_COMMAND(CrumpleInit)([this, bUseGPU](FRHICommandListImmediate& RHICmdList) { Init(RHICmdList, bUseGPU); });
}

void FCrumpleSceneProxy::Init(FRHICommandListImmediate& RHICmdList, bool bUseGPU)
{
	Vertices.Initial = Body->MakeBytes();
	Vertices.InitResource(RHICmdList);
	Indices.InitResource(RHICmdList);
	TexCoords.InitResource(RHICmdList);
	Colors.InitResource(RHICmdList);

	// Read as 32-bit floats, by the input assembler or by shaders through the views: both convert what they read.
	FLocalVertexFactory::FDataType Data;
	TexCoords.BindTexCoordVertexBuffer(&VertexFactory, Data);
	TexCoords.BindLightMapVertexBuffer(&VertexFactory, Data, 0);
	Colors.BindColorVertexBuffer(&VertexFactory, Data);
	const uint32 Begin = Body->Layout.BasisBegin(), Stride = FCrumpleLayout::BasisStride;
	Data.PositionComponent = FVertexStreamComponent(&Vertices, 0, FCrumpleLayout::PositionStride, VET_Float3);
	Data.PositionComponentSRV = Vertices.Positions;
	Data.TangentBasisComponents[0] =
		FVertexStreamComponent(&Vertices, Begin, 0, Stride, VET_Float4, EVertexStreamUsage::ManualFetch);
	Data.TangentBasisComponents[1] =
		FVertexStreamComponent(&Vertices, Begin, FCrumpleLayout::NormalOffset, Stride, VET_Float4, EVertexStreamUsage::ManualFetch);
	Data.TangentsSRV = Vertices.Basis;
#if CRUMPLE_ENGINE_AT_LEAST(4)
	VertexFactory.SetData(RHICmdList, Data);
#else
	VertexFactory.SetData(Data);
#endif
	VertexFactory.InitResource(RHICmdList);

	if (bUseGPU)
	{
		FString Why;
		FCrumpleVulkan& Vulkan = Body->Shape->Context->GetVulkan();
		Range = Vulkan.Register(*Body, Vertices.VertexBufferRHI, Why);
		bOnGPU = Range != 0;
		// Damage from before this proxy was made.
		Vulkan.Update(RHICmdList, Range);
	}
	if (Range == 0)
	{
		Show(RHICmdList, true);
	}
}

FCrumpleSceneProxy::~FCrumpleSceneProxy()
{
	Body->Shape->Context->GetVulkan().Unregister(Range);
	VertexFactory.ReleaseResource();
	Colors.ReleaseResource();
	TexCoords.ReleaseResource();
	Indices.ReleaseResource();
	Vertices.ReleaseResource();
}

SIZE_T FCrumpleSceneProxy::GetTypeHash() const
{
	static size_t Unique;
	return reinterpret_cast<SIZE_T>(&Unique);
}

void FCrumpleSceneProxy::Update(FRHICommandListImmediate& RHICmdList)
{
	if (Range != 0)
	{
		Body->Shape->Context->GetVulkan().Update(RHICmdList, Range);
	}
	else
	{
		Show(RHICmdList, false);
	}
}

void FCrumpleSceneProxy::Show(FRHICommandListImmediate& RHICmdList, bool bAlways)
{
	TArray<uint8> Bytes;
	if (Body->Deform(Bytes, bAlways))
	{
		// All of it: what a lock of a part leaves of the rest is not the same for every RHI.
		Fill(RHICmdList, Vertices.VertexBufferRHI, Bytes.GetData(), Bytes.Num());
	}
}

FPrimitiveViewRelevance FCrumpleSceneProxy::GetViewRelevance(const FSceneView* View) const
{
	FPrimitiveViewRelevance Relevance;
	Relevance.bDrawRelevance = IsShown(View);
	Relevance.bShadowRelevance = IsShadowCast(View);
	Relevance.bDynamicRelevance = true;
	Relevance.bRenderInMainPass = ShouldRenderInMainPass();
	Relevance.bUsesLightingChannels = GetLightingChannelMask() != GetDefaultLightingChannelMask();
	Relevance.bRenderCustomDepth = ShouldRenderCustomDepth();
	MaterialRelevance.SetPrimitiveViewRelevance(Relevance);
	Relevance.bVelocityRelevance = DrawsVelocity() && Relevance.bOpaque && Relevance.bRenderInMainPass;
	return Relevance;
}

void FCrumpleSceneProxy::GetDynamicMeshElements(const TArray<const FSceneView*>& Views, const FSceneViewFamily&, uint32 VisibilityMap,
	FMeshElementCollector& Collector) const
{
	for (int32 View = 0; View < Views.Num(); ++View)
	{
		if ((VisibilityMap & (1u << View)) == 0)
		{
			continue;
		}
		for (int32 Section = 0; Section < Materials.Num(); ++Section)
		{
			const FCrumpleMeshData::FSection& Of = Body->Shape->Mesh.Sections[Section];
			FMeshBatch& Mesh = Collector.AllocateMesh();
			Mesh.VertexFactory = &VertexFactory;
			Mesh.MaterialRenderProxy = Materials[Section];
			Mesh.ReverseCulling = IsLocalToWorldDeterminantNegative();
			Mesh.Type = PT_TriangleList;
			Mesh.DepthPriorityGroup = SDPG_World;
			FMeshBatchElement& Element = Mesh.Elements[0];
			Element.IndexBuffer = &Indices;
			Element.FirstIndex = Of.FirstIndex;
			Element.NumPrimitives = Of.Triangles;
			Element.MinVertexIndex = 0;
			Element.MaxVertexIndex = Body->Layout.Vertices - 1;
			Collector.AddMesh(View, Mesh);
		}
	}
}
