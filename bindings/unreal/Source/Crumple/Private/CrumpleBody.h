// A body in the scene as Crumple knows it: an instance, and its vertices as they lie in memory. No UObject: proxies on the render
// thread hold it too.
#pragma once

#include "CrumpleContext.h"

#include "CoreMinimal.h"

#include <atomic>

/** How a body's vertices lie in one buffer: positions, 3 floats each, then from a multiple of 256 bytes on tangent and normal, 4 floats
    each. The normal's fourth is the sign of the bitangent, where Unreal looks for it; Crumple writes three floats there and leaves it. */
struct FCrumpleLayout
{
	uint32 Vertices = 0;

	static constexpr uint32 PositionStride = 12, BasisStride = 32, NormalOffset = 16;

	uint32 BasisBegin() const { return (Vertices * PositionStride + 255) / 256 * 256; }
	uint32 Size() const { return BasisBegin() + Vertices * BasisStride; }
};

/** How deep a hit dented, m; 0 if it left no mark. */
inline double CrumpleDepth(const CrumpleHitResult& Told)
{
	return Told.status != CRUMPLE_HIT_STATUS_MARKED ? 0 : FVector(Told.achieved.x, Told.achieved.y, Told.achieved.z).Size();
}

class FCrumpleBody : public TSharedFromThis<FCrumpleBody>
{
public:
	/** Compliance: m per N s. */
	static TSharedPtr<FCrumpleBody> Create(TSharedRef<FCrumpleShape> Shape, float Compliance, FString& OutError);
	~FCrumpleBody();

	/** A hit in the static mesh's space: cm, and kg cm/s. Any thread, also while others are in the context. */
	bool Submit(const FVector& Point, const FVector& Impulse, CrumpleHitResult& OutTold, FString& OutError);
	/** Where the body is: from the set's space, m, to the world, cm. For contact points. Any thread. */
	bool Place(const FMatrix& ToWorld, FString& OutError);
	/** Out of the surface of the set's base mesh, in the set's space, nearest to a point in the static mesh's space. Any thread. */
	bool FindNormal(const FVector& Point, FVector& OutNormal, FString& OutError);
	/** A hit arrived by another way. */
	void SetPending() { bPending = true; }
	/** Whether something happened since the last call that a deform would show. Any thread. */
	bool TakePending() { return bPending.exchange(false); }

	bool Repair(float Keep, FString& OutError);
	bool Reset(FString& OutError);
	bool Save(TArray<uint8>& OutDamage, FString& OutError);
	bool Load(const TArray<uint8>& Damage, FString& OutError);

	/** Brings the vertices up to date, and copies them where one changed, or always. False where there is no copy; errors are logged. */
	bool Deform(TArray<uint8>& OutBytes, bool bAlways = false);
	/** The undented vertices, with everything that Crumple does not write. */
	TArray<uint8> MakeBytes() const;

	/** Ends the instance. Calls after it fail and say so. Done by the component, while proxies may live on. */
	void Release();

	const TSharedRef<FCrumpleShape> Shape;
	const FCrumpleLayout Layout;

	/** Held by whoever names the instance without bringing hits: with Mutex. */
	CrumpleInstance Get() const { return Instance; }

private:
	explicit FCrumpleBody(TSharedRef<FCrumpleShape> InShape);

	/** Calls into the context, unless the body is gone. Others may be in the context. */
	template <typename CallType>
	bool Shared(CallType&& Call, FString& OutError);
	/** The same with the lock held. */
	template <typename CallType>
	bool Locked(CallType&& Call, FString& OutError);
	/** The same, and what it did will be shown. */
	template <typename CallType>
	bool Change(CallType&& Call, FString& OutError)
	{
		const bool bDone = Locked(Call, OutError);
		bPending = bPending || bDone;
		return bDone;
	}

	FRWLock Life;  // hits read, the end writes
	CrumpleInstance Instance{};
	TArray<uint8> Bytes;
	CrumpleBuffer Buffer{};  // of Bytes; none until the first Deform
	std::atomic<bool> bPending{false};
};
