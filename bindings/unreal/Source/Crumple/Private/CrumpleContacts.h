// From the collisions that Unreal tells of to Crumple's contact points, and from its hits to components. Game thread.
#pragma once

#include "CoreMinimal.h"
#include "UObject/WeakObjectPtr.h"

#include "crumple_contacts.h"

class UCrumpleComponent;
class UPrimitiveComponent;
struct FHitResult;

class FCrumpleContacts
{
public:
	/** Of a context that lives as long. */
	void Use(CrumpleContext* InContext);

	/** Components that play. */
	void Add(UCrumpleComponent* Component);
	void Remove(UCrumpleComponent* Component)
	{
		Components.RemoveAll([=](const UCrumpleComponent* Each) { return Each == Component; });
	}

	/** A contact of a component with another one. Impulse: kg cm/s, of the whole pair in the step. False, and why, where it cannot be. */
	bool Report(UCrumpleComponent& Component, UPrimitiveComponent* Other, double Impulse, const FHitResult& Hit, FString& OutError);

	/** Makes hits of what was reported in this frame, once. Every component calls it; any may be gone afterwards. */
	void Step(float Seconds);

private:
	/** How a pair moves. Unreal tells after its step, so the velocity before a step is the one after the step before it. */
	struct FTouch
	{
		uint64 Pair;
		/** Of the one with the higher id relative to the other, cm/s. */
		FVector Before, After;
		bool bKnown;
		double Last;
		/** Unreal tells nothing of bodies that sleep. They touch all the same. */
		TWeakObjectPtr<UPrimitiveComponent> Bodies[2];

		bool IsAsleep() const;
	};
	/** bStood: whether a pair that is new stood there when play began. */
	const FTouch& Touch(uint64 Pair, const FVector& Velocity, bool bStood, UPrimitiveComponent* const (&Bodies)[2]);

	CrumpleContext* Context = nullptr;
	TArray<UCrumpleComponent*> Components;
	TArray<FTouch> Touches;
	TArray<CrumpleContactHit> Hits;
	double Now = 0;  // s of steps
	uint64 Frame = 0;
	bool bWarned = false;
};
