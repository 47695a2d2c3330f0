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

/** A hit in the static mesh's space. */
struct FCrumpleHit
{
	/** cm. */
	FVector Point = FVector::ZeroVector;
	/** kg cm/s. */
	FVector Impulse = FVector::ZeroVector;
	/** Contact normal, of any length; Submit turns it out of the body. Zero: unknown. */
	FVector Normal = FVector::ZeroVector;
	/** kg; 0: unknown. */
	float StrikerMass = 0;
	/** How long it acts, s: a constant of the material. */
	float Duration = 0.01f;
	/** Mass of the vertex that is hit, kg; 0: the set's. */
	float VertexMass = 0;
	/** 0: a hit of its own. */
	uint64 Contact = 0;
	/** Whether an impulse that points out of the surface is turned around: Unreal does not say on which of two bodies a normal impulse
	    acts. */
	bool bInwards = false;
};

class FCrumpleBody : public TSharedFromThis<FCrumpleBody>
{
public:
	static TSharedPtr<FCrumpleBody> Create(TSharedRef<FCrumpleShape> Shape, FString& OutError);
	~FCrumpleBody();

	/** Any thread, also while others are in the context. */
	bool Submit(const FCrumpleHit& Hit, CrumpleHitResult& OutTold, FString& OutError);
	bool EndContact(uint64 Contact);
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

	/** Held by whoever names the instance without submitting hits: with Mutex. */
	CrumpleInstance Get() const { return Instance; }

private:
	explicit FCrumpleBody(TSharedRef<FCrumpleShape> InShape);

	/** Calls into the context with the lock held, unless the body is gone. */
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
