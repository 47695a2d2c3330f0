#include "CrumpleMeshData.h"

#include "Engine/StaticMesh.h"
#include "StaticMeshResources.h"

static FVector3f UnitOr(const FVector4f& Packed, const FVector3f& Otherwise)
{
	const FVector3f Unit = FVector3f(Packed.X, Packed.Y, Packed.Z).GetSafeNormal();
	return Unit.IsNearlyZero() ? Otherwise : Unit;
}

bool FCrumpleMeshData::Read(const UStaticMesh& Mesh, FString& OutError)
{
	const FStaticMeshRenderData* RenderData = Mesh.GetRenderData();
	if (!RenderData || RenderData->LODResources.Num() == 0)
	{
		OutError = FString::Printf(TEXT("%s has no render data"), *Mesh.GetName());
		return false;
	}
	if (!WITH_EDITOR && !Mesh.bAllowCPUAccess)
	{
		OutError = FString::Printf(TEXT("%s: tick Allow CPU Access in the static mesh's LOD settings; packaged games keep vertices only then"),
			*Mesh.GetName());
		return false;
	}
	// Levels below this one are streamed out.
	const int32 Level = FMath::Min<int32>(RenderData->CurrentFirstLODIdx, RenderData->LODResources.Num() - 1);
	const FStaticMeshLODResources& LOD = RenderData->LODResources[Level];
	const FPositionVertexBuffer& PositionBuffer = LOD.VertexBuffers.PositionVertexBuffer;
	const FStaticMeshVertexBuffer& VertexBuffer = LOD.VertexBuffers.StaticMeshVertexBuffer;
	const FColorVertexBuffer& ColorBuffer = LOD.VertexBuffers.ColorVertexBuffer;
	const FIndexArrayView IndexView = LOD.IndexBuffer.GetArrayView();
	const uint32 Vertices = PositionBuffer.GetNumVertices();
	if (Vertices == 0 || IndexView.Num() == 0)
	{
		OutError = FString::Printf(TEXT("%s has no vertices that the CPU can read; tick Allow CPU Access in its LOD settings"), *Mesh.GetName());
		return false;
	}

	TexCoordChannels = VertexBuffer.GetNumTexCoords();
	Positions.SetNumUninitialized(Vertices);
	Normals.SetNumUninitialized(Vertices);
	Tangents.SetNumUninitialized(Vertices);
	TexCoords.SetNumUninitialized(Vertices * TexCoordChannels);
	Colors.SetNumUninitialized(Vertices);
	const bool bColors = ColorBuffer.GetNumVertices() == Vertices;
	for (uint32 Vertex = 0; Vertex < Vertices; ++Vertex)
	{
		Positions[Vertex] = PositionBuffer.VertexPosition(Vertex);
		const FVector4f Normal = VertexBuffer.VertexTangentZ(Vertex), Tangent = VertexBuffer.VertexTangentX(Vertex);
		// Both are packed to 8 or 16 bits, and zero on degenerate triangles; Crumple takes unit vectors.
		Normals[Vertex] = UnitOr(Normal, FVector3f(0, 0, 1));
		const FVector3f Unit = UnitOr(Tangent, FVector3f(1, 0, 0));
		Tangents[Vertex] = FVector4f(Unit.X, Unit.Y, Unit.Z, Normal.W < 0 ? -1.0f : 1.0f);
		for (int32 Channel = 0; Channel < TexCoordChannels; ++Channel)
		{
			TexCoords[Channel * Vertices + Vertex] = VertexBuffer.GetVertexUV(Vertex, Channel);
		}
		Colors[Vertex] = bColors ? ColorBuffer.VertexColor(Vertex) : FColor::White;
	}
	Indices.SetNumUninitialized(IndexView.Num());
	for (int32 Index = 0; Index < IndexView.Num(); ++Index)
	{
		Indices[Index] = IndexView[Index];
	}
	for (const FStaticMeshSection& Section : LOD.Sections)
	{
		Sections.Add(FSection{Section.MaterialIndex, Section.FirstIndex, Section.NumTriangles});
	}
	return true;
}
