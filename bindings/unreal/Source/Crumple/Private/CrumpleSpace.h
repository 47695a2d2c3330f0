// Unreal's space and the set's: the one place where axes and units change.
//
// Unreal: centimetres, left-handed, Z up; impulses in kg cm/s. A set: metres, N s, the axes of its file. Vertices are never
// converted: what Crumple writes is drawn as it is, under SetToUnreal().
#pragma once

#include "CrumpleSet.h"

#include "CoreMinimal.h"

#include "crumple.h"

class FCrumpleSpace
{
public:
	explicit FCrumpleSpace(ECrumpleAxes Axes = ECrumpleAxes::YUp)
	{
		if (Axes == ECrumpleAxes::YUp)
		{
			Axis[1] = 2;
			Axis[2] = 1;
		}
		if (Axes == ECrumpleAxes::ZUp)
		{
			Sign[1] = -1;
		}
	}

	/** cm of the static mesh's space to m of the set's. */
	CrumpleVec3 PointToSet(const FVector& Point) const { return ToSet(Point, CmPerMetre); }

	/** m of the set's space to cm of the static mesh's. */
	FVector PointToUnreal(const CrumpleVec3& Point) const { return ToUnreal(Point, CmPerMetre); }

	/** Directions keep their length. */
	CrumpleVec3 DirectionToSet(const FVector& Direction) const { return ToSet(Direction, 1); }
	FVector DirectionToUnreal(const CrumpleVec3& Direction) const { return ToUnreal(Direction, 1); }

	/** kg cm/s to N s. */
	CrumpleVec3 ImpulseToSet(const FVector& Impulse) const { return ToSet(Impulse, CmPerMetre); }

	/** From the set's space to the static mesh's, for row vectors, as everywhere in Unreal. */
	FMatrix SetToUnreal() const
	{
		FMatrix Matrix(ForceInit);
		for (int32 Unreal = 0; Unreal < 3; ++Unreal)
		{
			Matrix.M[Axis[Unreal]][Unreal] = CmPerMetre * Sign[Unreal];
		}
		Matrix.M[3][3] = 1;
		return Matrix;
	}

	/** -1 where the two spaces have different handedness: triangles and the sign of the bitangent turn over then. */
	float Handedness() const
	{
		const bool bSwaps = Axis[1] == 2;
		return (bSwaps ? -1 : 1) * Sign[0] * Sign[1] * Sign[2];
	}

	static constexpr double CmPerMetre = 100;

private:
	CrumpleVec3 ToSet(const FVector& Vector, double Divisor) const
	{
		const double In[3] = {Vector.X, Vector.Y, Vector.Z};
		float Out[3];
		for (int32 Unreal = 0; Unreal < 3; ++Unreal)
		{
			Out[Axis[Unreal]] = static_cast<float>(In[Unreal] / Divisor * Sign[Unreal]);
		}
		return {Out[0], Out[1], Out[2]};
	}

	FVector ToUnreal(const CrumpleVec3& Vector, double Factor) const
	{
		const double In[3] = {Vector.x, Vector.y, Vector.z};
		return FVector(In[Axis[0]] * Factor * Sign[0], In[Axis[1]] * Factor * Sign[1], In[Axis[2]] * Factor * Sign[2]);
	}

	int32 Axis[3] = {0, 1, 2};  // of the set, for each of Unreal's
	float Sign[3] = {1, 1, 1};
};
