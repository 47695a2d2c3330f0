// The plugin's one Crumple context, and what components share in it.
//
// Threads: two may not be inside of a context at once, but for hits. Whoever calls anything else holds Mutex: the game thread (and
// the workers that send dynamic data), the render thread and the RHI thread all do.
#pragma once

#include "CrumpleContacts.h"
#include "CrumpleMeshData.h"
#include "CrumpleSpace.h"

#include "CoreMinimal.h"
#include "HAL/CriticalSection.h"
#include "Templates/SharedPointer.h"

class FCrumpleContext;
class FCrumpleVulkan;
class UCrumpleSet;
class UStaticMesh;

/** What the calling thread's last failed call had to say. */
FString CrumpleWhy(CrumpleResult Result);

/** Why a library of this version cannot be used with the header that the plugin was compiled against; empty where it can. */
FString CrumpleVersionProblem(uint32 Library);

/** A set that knows a static mesh as a level of detail of its own. Shared by all components that have both. */
class FCrumpleShape
{
public:
	FCrumpleShape(TSharedRef<FCrumpleContext> InContext, FCrumpleMeshData InMesh) : Context(InContext), Mesh(MoveTemp(InMesh)) {}
	~FCrumpleShape();

	/** Loads, finds the axes, checks that the mesh lies on the set's surface, and adds it as a level. */
	bool Load(const UCrumpleSet& Asset, const FString& MeshName, FString& OutError);

	const TSharedRef<FCrumpleContext> Context;
	const FCrumpleMeshData Mesh;
	FCrumpleSpace Space;
	CrumpleExampleSet Set{};
	uint32 Lod = 0;
	/** Around everything that a body of this shape can become, m, in the set's space. */
	CrumpleAabb Bounds{};
	/** Of the base mesh. */
	TArray<CrumpleVec3> Normals;

private:
	bool FindSpace(ECrumpleAxes Axes, const CrumpleExampleSetInfo& Info, const FString& MeshName, FString& OutError);
	/** The vertex furthest off the set's surface, of at most Samples, and how far that is, m. */
	float FurthestOff(const FCrumpleSpace& In, const TArray<CrumpleVec3>& Base, int32& OutVertex) const;
	bool AddLevel(FString& OutError);
};

class FCrumpleContext : public TSharedFromThis<FCrumpleContext>
{
public:
	/** Null, and why, where there can be none. */
	static TSharedPtr<FCrumpleContext> Create(FString& OutError);
	~FCrumpleContext();

	/** The shape that others use already, or a new one. Game thread. Null, and why, where the two do not fit. */
	TSharedPtr<FCrumpleShape> FindShape(const UCrumpleSet& Asset, const UStaticMesh& Mesh, FString& OutError);

	CrumpleContext* Get() const { return Context; }
	FCrumpleVulkan& GetVulkan() { return *Vulkan; }

	FCriticalSection Mutex;
	FCrumpleContacts Contacts;

private:
	struct FKnown
	{
		const UCrumpleSet* Asset;
		uint32 Revision;
		ECrumpleAxes Axes;
		const UStaticMesh* Mesh;
		TWeakPtr<FCrumpleShape> Shape;
	};

	FCrumpleContext();

	CrumpleContext* Context = nullptr;
	TUniquePtr<FCrumpleVulkan> Vulkan;
	TArray<FKnown> Shapes;
};
