// Which hits belong together. Unreal reports a contact as one event a step, without a number of its own; Crumple makes one dent of
// hits with the same number, the same at any frame rate.
#pragma once

#include "CoreMinimal.h"

class FCrumpleContacts
{
public:
	/** The number of the contact with a component at a point, cm, of the static mesh's space; Now in seconds. */
	uint64 Find(uint32 Other, const FVector& Point, double Now)
	{
		for (FOpen& Open : All)
		{
			if (Open.Other == Other && FVector::DistSquared(Open.Point, Point) < Reach * Reach)
			{
				Open.Last = Now;
				return Open.Id;
			}
		}
		All.Add(FOpen{++Newest, Other, Point, Now});
		return Newest;
	}

	/** Forgets contacts that were not hit for a while, and tells their numbers. */
	TArray<uint64> Expire(double Now)
	{
		TArray<uint64> Ended;
		for (int32 Index = All.Num() - 1; Index >= 0; --Index)
		{
			if (Now - All[Index].Last > Gap)
			{
				Ended.Add(All[Index].Id);
				All.RemoveAt(Index);
			}
		}
		return Ended;
	}

	void Reset() { All.Empty(); }

	/** Longer than a frame, shorter than a bounce, s. */
	static constexpr double Gap = 0.1;
	/** Hits further apart are contacts of their own, cm: a car that scrapes along a wall. */
	static constexpr double Reach = 10;

private:
	struct FOpen
	{
		uint64 Id;
		uint32 Other;
		FVector Point;
		double Last;
	};

	TArray<FOpen> All;
	uint64 Newest = 0;
};
