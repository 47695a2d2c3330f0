// Stand-ins for what the plugin uses of Engine: objects, components, a static mesh, and a world of frames; see StandinCore.h.
#pragma once

#include "StandinCore.h"
#include "StandinRender.h"

class UObject
{
public:
	virtual ~UObject() = default;
	FString GetName() const { return StandinName; }
	FString GetPathName() const { return StandinName; }
	uint32 GetUniqueID() const { return StandinId; }
	bool MarkPackageDirty() const { return true; }
	FString StandinName;
	uint32 StandinId = 0;
	bool bStandinGarbage = false;
	/** Lives until the program ends, as long as garbage is not collected there. */
	static std::vector<std::unique_ptr<UObject>> StandinAll;
};
template <typename T>
T* NewObject(UObject* = nullptr)
{
	T* Made = new T;
	UObject::StandinAll.emplace_back(Made);
	Made->StandinId = static_cast<uint32>(UObject::StandinAll.size());
	return Made;
}
inline bool IsValid(const UObject* Object) { return Object && !Object->bStandinGarbage; }
template <typename To, typename From>
To* Cast(From* Object)
{
	return dynamic_cast<To*>(Object);
}
template <typename T>
class TObjectPtr
{
public:
	TObjectPtr() = default;
	TObjectPtr(T* In) : Pointer(In) {}
	operator T*() const { return Pointer; }
	T* operator->() const { return Pointer; }
	T& operator*() const { return *Pointer; }

private:
	T* Pointer = nullptr;
};

template <typename T>
class TWeakObjectPtr
{
public:
	TWeakObjectPtr(T* In = nullptr) : Pointer(In) {}
	bool IsValid() const { return ::IsValid(Pointer); }
	T* operator->() const { return Pointer; }

private:
	T* Pointer;
};

// Delegates that Blueprint sees.
template <typename... ArgTypes>
class StandinDelegate
{
public:
	template <typename T>
	void AddDynamic(T* Object, void (T::*Function)(ArgTypes...))
	{
		All.push_back({Object, [=](ArgTypes... Args) { (Object->*Function)(Args...); }});
	}
	template <typename T>
	void RemoveDynamic(T* Object, void (T::*)(ArgTypes...))
	{
		std::erase_if(All, [=](const auto& Each) { return Each.first == Object; });
	}
	/** A test's. */
	void StandinAdd(std::function<void(ArgTypes...)> Function) { All.push_back({nullptr, std::move(Function)}); }
	SIZE_T StandinNum() const { return All.size(); }
	void Broadcast(ArgTypes... Args) const
	{
		const auto Now = All;
		for (const auto& Each : Now) Each.second(Args...);
	}

private:
	std::vector<std::pair<const void*, std::function<void(ArgTypes...)>>> All;
};
#define DECLARE_DYNAMIC_MULTICAST_DELEGATE_ThreeParams(Name, Type1, Name1, Type2, Name2, Type3, Name3) \
	class Name : public StandinDelegate<Type1, Type2, Type3> \
	{ \
	}

struct FFilePath
{
	FString FilePath;
};
class UDataAsset : public UObject
{
};

class UMaterialInterface : public UObject
{
public:
	FMaterialRenderProxy* GetRenderProxy() const { return &Standin; }
	mutable FMaterialRenderProxy Standin;
};
enum EMaterialDomain
{
	MD_Surface
};
class UMaterial : public UMaterialInterface
{
public:
	static UMaterial* GetDefaultMaterial(EMaterialDomain Domain);
};

// A static mesh.
struct FIndexArrayView
{
	const TArray<uint32>* All;
	int32 Num() const { return All->Num(); }
	uint32 operator[](int32 Index) const { return (*All)[Index]; }
};
struct FRawStaticIndexBuffer
{
	FIndexArrayView GetArrayView() const { return {&Standin}; }
	TArray<uint32> Standin;
};
struct FStaticMeshSection
{
	int32 MaterialIndex = 0;
	uint32 FirstIndex = 0, NumTriangles = 0;
};
struct FStaticMeshVertexBuffers
{
	FStaticMeshVertexBuffer StaticMeshVertexBuffer;
	FPositionVertexBuffer PositionVertexBuffer;
	FColorVertexBuffer ColorVertexBuffer;
};
struct FStaticMeshLODResources
{
	FStaticMeshVertexBuffers VertexBuffers;
	FRawStaticIndexBuffer IndexBuffer;
	std::vector<FStaticMeshSection> Sections;
};
struct FStaticMeshRenderData
{
	struct
	{
		int32 Num() const { return int32(Standin.size()); }
		const FStaticMeshLODResources& operator[](int32 Index) const { return *Standin.at(SIZE_T(Index)); }
		std::vector<std::unique_ptr<FStaticMeshLODResources>> Standin;
	} LODResources;
	uint8 CurrentFirstLODIdx = 0;
};
class UStaticMesh : public UObject
{
public:
	const FStaticMeshRenderData* GetRenderData() const { return Standin.get(); }
	bool bAllowCPUAccess = true;
	std::unique_ptr<FStaticMeshRenderData> Standin;
};

// Components.
class AActor;
class UActorComponent;
enum ELevelTick
{
	LEVELTICK_All
};
enum ETickingGroup
{
	TG_PostPhysics
};
struct FActorComponentTickFunction
{
	bool bCanEverTick = false;
	ETickingGroup TickGroup = TG_PostPhysics;
};
namespace EEndPlayReason
{
	enum Type
	{
		Destroyed,
		Quit
	};
}
class UActorComponent : public UObject
{
public:
	AActor* GetOwner() const { return StandinOwner; }
	virtual void BeginPlay() {}
	virtual void EndPlay(const EEndPlayReason::Type) {}
	virtual void TickComponent(float, ELevelTick, FActorComponentTickFunction*) {}
	void DestroyComponent();
	void MarkRenderStateDirty() { bStandinStateDirty = true; }
	void MarkRenderDynamicDataDirty() { bStandinDataDirty = true; }
	FActorComponentTickFunction PrimaryComponentTick;
	AActor* StandinOwner = nullptr;
	bool bStandinPlaying = false, bStandinStateDirty = false, bStandinDataDirty = false;

protected:
	virtual void SendRenderDynamicData_Concurrent() {}
	friend struct StandinWorld;
};
struct FAttachmentTransformRules
{
	static const FAttachmentTransformRules SnapToTargetIncludingScale;
};
class USceneComponent : public UActorComponent
{
public:
	USceneComponent* GetAttachParent() const { return StandinParent; }
	bool AttachToComponent(USceneComponent* Parent, const FAttachmentTransformRules&)
	{
		for (const USceneComponent* Each = Parent; Each; Each = Each->StandinParent)
		{
			if (Each == this)
			{
				return false;
			}
		}
		StandinParent = Parent;
		return true;
	}
	const FTransform& GetComponentTransform() const { return StandinParent ? StandinParent->GetComponentTransform() : StandinTransform; }
	void SetVisibility(bool bVisible, bool = false) { bStandinVisible = bVisible; }
	virtual FVector GetComponentVelocity() const { return StandinVelocity; }
	virtual FBoxSphereBounds CalcBounds(const FTransform&) const { return {}; }
	virtual FBoxSphereBounds CalcLocalBounds() const { return CalcBounds(FTransform()); }
	FBoxSphereBounds GetLocalBounds() const { return CalcLocalBounds(); }
	void UpdateBounds() { Bounds = CalcBounds(GetComponentTransform()); }
	FBoxSphereBounds Bounds;
	USceneComponent* StandinParent = nullptr;
	FTransform StandinTransform;
	FVector StandinVelocity;
	bool bStandinVisible = true;
};
struct FHitResult
{
	FVector ImpactPoint, ImpactNormal;
};
namespace ECollisionEnabled
{
	enum Type
	{
		NoCollision
	};
}
class UPrimitiveComponent : public USceneComponent
{
public:
	StandinDelegate<UPrimitiveComponent*, AActor*, UPrimitiveComponent*, FVector, const FHitResult&> OnComponentHit;
	void SetCollisionEnabled(ECollisionEnabled::Type) {}
	void SetNotifyRigidBodyCollision(bool bNotify) { bStandinNotifies = bNotify; }
	bool IsSimulatingPhysics() const { return StandinMass > 0; }
	bool IsAnyRigidBodyAwake() const { return IsSimulatingPhysics() && !bStandinAsleep; }
	float GetMass() const { return StandinMass; }
	FVector GetPhysicsLinearVelocityAtPoint(FVector) { return StandinVelocity; }
	virtual FPrimitiveSceneProxy* CreateSceneProxy() { return nullptr; }
	virtual FMatrix GetRenderMatrix() const { return GetComponentTransform().ToMatrixWithScale(); }
	virtual int32 GetNumMaterials() const { return 0; }
	virtual UMaterialInterface* GetMaterial(int32) const { return nullptr; }
	FPrimitiveSceneProxy* SceneProxy = nullptr;
	bool bStandinNotifies = false, bStandinAsleep = false;
	float StandinMass = 0;
};
class UMeshComponent : public UPrimitiveComponent
{
public:
	virtual UMaterialInterface* GetMaterial(int32 Slot) const override { return Slot < int32(Materials.size()) ? Materials[SIZE_T(Slot)] : nullptr; }
	virtual void SetMaterial(int32 Slot, UMaterialInterface* Material)
	{
		Materials.resize(std::max(Materials.size(), SIZE_T(Slot) + 1));
		Materials[SIZE_T(Slot)] = Material;
	}
	virtual FMaterialRelevance GetMaterialRelevance(ERHIFeatureLevel::Type) const { return {}; }

private:
	std::vector<UMaterialInterface*> Materials;
};
class UStaticMeshComponent : public UMeshComponent
{
public:
	UStaticMesh* GetStaticMesh() const { return StandinMesh; }
	virtual int32 GetNumMaterials() const override { return 2; }
	UStaticMesh* StandinMesh = nullptr;
};
class AActor : public UObject
{
public:
	template <typename T>
	T* FindComponentByClass() const
	{
		for (UActorComponent* Each : Standin)
			if (T* Found = dynamic_cast<T*>(Each)) return Found;
		return nullptr;
	}
	bool Destroy();
	std::vector<UActorComponent*> Standin;
};

/** What the plugin's header tool would write into a class. */
#define STANDIN_GENERATED_BODY(Class, Base) \
public: \
	using Super = Base; \
	using ThisClass = Class; \
\
private:

/** A vertex as a draw sees it, in world space: cm. */
struct StandinVertex
{
	FVector Position, Normal, Tangent, Bitangent;
};
struct StandinDrawn
{
	struct FTriangle
	{
		uint32 Corner[3];
		const FMaterialRenderProxy* Material;
	};
	std::vector<StandinVertex> Vertices;
	std::vector<FTriangle> Triangles;  // in the order that Unreal calls the front, whatever was culled
	std::vector<uint8> Bytes;          // of the vertex buffer
	const FStaticMeshVertexBuffer* TexCoords = nullptr;
};

struct StandinWorld
{
	/** Adds a component to an actor and plays it. */
	static void Play(AActor& Actor, UActorComponent& Component);
	/** Ticks, sends what is dirty to the render thread, submits. */
	static void Frame(float Seconds = 1.0f / 60, bool bSubmit = true);
	/** Plays a frame, and draws a component in it. */
	static StandinDrawn Draw(UPrimitiveComponent& Component);
	static std::vector<UActorComponent*> All;
};
