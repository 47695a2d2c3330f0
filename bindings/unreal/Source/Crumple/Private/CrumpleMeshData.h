// What a static mesh draws, read once: the level of detail that Crumple dents.
#pragma once

#include "CoreMinimal.h"

class UStaticMesh;

/** One level of detail, in Unreal's space (cm), in the order in which Unreal draws it. */
struct FCrumpleMeshData
{
	struct FSection
	{
		int32 Material;
		uint32 FirstIndex;
		uint32 Triangles;
	};

	TArray<FVector3f> Positions;
	TArray<FVector3f> Normals;
	TArray<FVector4f> Tangents;  // w: +1 or -1, the sign of the bitangent cross(normal, tangent) * w
	TArray<FVector2f> TexCoords; // channel by channel
	TArray<FColor> Colors;
	TArray<uint32> Indices;
	TArray<FSection> Sections;
	int32 TexCoordChannels = 0;

	int32 Num() const { return Positions.Num(); }

	/** False, and why, where the mesh cannot be read. Game thread. */
	bool Read(const UStaticMesh& Mesh, FString& OutError);
};
