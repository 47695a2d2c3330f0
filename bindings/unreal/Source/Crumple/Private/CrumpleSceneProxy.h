// Draws a body: the static mesh's triangles, materials, texture coordinates and colours, with positions and tangents in a buffer of
// the body's own, which the CPU or Crumple's kernels write. The buffer holds the set's space; the component's render matrix turns it.
#pragma once

#include "CrumpleBody.h"
#include "CrumpleVulkan.h"

#include "CoreMinimal.h"
#include "LocalVertexFactory.h"
#include "Materials/MaterialRelevance.h"
#include "PrimitiveSceneProxy.h"
#include "PrimitiveViewRelevance.h"
#include "RenderResource.h"
#include "Rendering/ColorVertexBuffer.h"
#include "Rendering/StaticMeshVertexBuffer.h"

class FMaterialRenderProxy;
class UCrumpleComponent;

/** Positions and tangents, see FCrumpleLayout. */
class FCrumpleVertexBuffer : public FVertexBuffer
{
public:
	virtual void InitRHI(FRHICommandListBase& RHICmdList) override;
	virtual void ReleaseRHI() override;

	FCrumpleLayout Layout;
	TArray<uint8> Initial;
	FShaderResourceViewRHIRef Positions, Basis;
};

class FCrumpleIndexBuffer : public FIndexBuffer
{
public:
	virtual void InitRHI(FRHICommandListBase& RHICmdList) override;

	TArray<uint32> Indices;
};

class FCrumpleSceneProxy final : public FPrimitiveSceneProxy
{
public:
	FCrumpleSceneProxy(const UCrumpleComponent& Component, TSharedRef<FCrumpleBody> InBody, bool bUseGPU);
	virtual ~FCrumpleSceneProxy();

	virtual SIZE_T GetTypeHash() const override;
	virtual uint32 GetMemoryFootprint() const override { return sizeof(*this) + GetAllocatedSize(); }
	virtual FPrimitiveViewRelevance GetViewRelevance(const FSceneView* View) const override;
	virtual void GetDynamicMeshElements(const TArray<const FSceneView*>& Views, const FSceneViewFamily& ViewFamily, uint32 VisibilityMap,
		FMeshElementCollector& Collector) const override;

	/** Render thread. Shows what happened to the body. */
	void Update(FRHICommandListImmediate& RHICmdList);

	/** Whether Crumple's kernels write the buffer, once the render thread has made it. */
	bool IsOnGPU() const { return bOnGPU; }

	const FCrumpleVertexBuffer& GetVertices() const { return Vertices; }
	const FCrumpleIndexBuffer& GetIndices() const { return Indices; }

private:
	/** Deforms on the CPU and fills the buffer where a vertex changed, or always. Only the render thread does, so that no older vertices come after newer ones. */
	void Show(FRHICommandListImmediate& RHICmdList, bool bAlways);

	void Init(FRHICommandListImmediate& RHICmdList, bool bUseGPU);

	const TSharedRef<FCrumpleBody> Body;
	TArray<const FMaterialRenderProxy*> Materials;  // a section each
	FMaterialRelevance MaterialRelevance;
	FCrumpleVertexBuffer Vertices;
	FCrumpleIndexBuffer Indices;
	FStaticMeshVertexBuffer TexCoords;
	FColorVertexBuffer Colors;
	FLocalVertexFactory VertexFactory;
	FCrumpleRangeId Range = 0;
	std::atomic<bool> bOnGPU{false};
};
