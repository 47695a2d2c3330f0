// Unreal's importer welds, splits and reorders vertices, so the static mesh's are not the set's. Crumple does not ask that: the
// static mesh as Unreal draws it becomes a level of detail of the set, each vertex of which is bound to the place of the base surface
// that it lies on. What is asked is that it lies there, which is checked.
#include "CrumpleContext.h"
#include "CrumpleLog.h"

#include "crumple_import.h"
#include "crumple_parts.h"

#include "Misc/ScopeLock.h"

namespace
{
	/** Vertices that are looked at: enough to tell two meshes apart. */
	constexpr int32 Samples = 512;
	/** A level of detail that Unreal simplified, or the fallback of a Nanite mesh, is off by less than this share of the diagonal. */
	constexpr float Tolerance = 0.01f;

	float Length(const CrumpleVec3& A, const CrumpleVec3& B)
	{
		return FMath::Sqrt(FMath::Square(A.x - B.x) + FMath::Square(A.y - B.y) + FMath::Square(A.z - B.z));
	}

	template <typename T>
	CrumpleInput Input(const TArray<T>& Array)
	{
		return CrumpleInput{Array.GetData(), Array.Num() * sizeof(T), sizeof(T)};
	}

	const TCHAR* Name(ECrumpleAxes Axes)
	{
		return Axes == ECrumpleAxes::YUp ? TEXT("YUp") : Axes == ECrumpleAxes::ZUp ? TEXT("ZUp") : TEXT("Same");
	}
}

FCrumpleShape::~FCrumpleShape()
{
	if (Set.index != 0)
	{
		FScopeLock Lock(&Context->Mutex);
		crumple_example_set_destroy(Context->Get(), Set);
	}
}

bool FCrumpleShape::Load(const UCrumpleSet& Asset, const FString& MeshName, FString& OutError)
{
	FScopeLock Lock(&Context->Mutex);
	const TArray<uint8>& Bytes = Asset.GetBytes();
	if (Bytes.Num() == 0)
	{
		OutError = FString::Printf(TEXT("%s is empty: choose its File and press Import"), *Asset.GetName());
		return false;
	}
	const bool bGlb = Bytes.Num() >= 4 && FMemory::Memcmp(Bytes.GetData(), "glTF", 4) == 0;
	CrumpleGltfDef Def = crumple_gltf_def_default();
	CrumpleResult Result = bGlb
		? crumple_example_set_load_gltf_memory(Context->Get(), Bytes.GetData(), Bytes.Num(), &Def, &Set)
		: crumple_example_set_load_baked_memory(Context->Get(), Bytes.GetData(), Bytes.Num(), CRUMPLE_BYTES_COPY, &Set);
	CrumpleExampleSetInfo Info{};
	if (Result == CRUMPLE_OK)
	{
		Result = crumple_example_set_get_info(Context->Get(), Set, &Info);
	}
	if (Result != CRUMPLE_OK)
	{
		OutError = FString::Printf(TEXT("%s: %s"), *Asset.GetName(), *CrumpleWhy(Result));
		return false;
	}
	const float Limit = Info.depth_limit;
	Bounds.min = {Info.bounds.min.x - Limit, Info.bounds.min.y - Limit, Info.bounds.min.z - Limit};
	Bounds.max = {Info.bounds.max.x + Limit, Info.bounds.max.y + Limit, Info.bounds.max.z + Limit};
	return FindSpace(Asset.Axes, Info, MeshName, OutError) && AddLevel(OutError);
}

bool FCrumpleShape::FindSpace(ECrumpleAxes Axes, const CrumpleExampleSetInfo& Info, const FString& MeshName, FString& OutError)
{
	TArray<CrumpleVec3> Base;
	Base.SetNumUninitialized(Info.vertex_count);
	Normals.SetNumUninitialized(Info.vertex_count);
	CrumpleMeshCopyDef Copy = crumple_mesh_copy_def_default();
	Copy.positions = {Base.GetData(), Base.Num() * sizeof(CrumpleVec3), 0, sizeof(CrumpleVec3)};
	Copy.normals = {Normals.GetData(), Normals.Num() * sizeof(CrumpleVec3), 0, sizeof(CrumpleVec3)};
	const CrumpleResult Result = crumple_example_set_copy_mesh(Context->Get(), Set, &Copy);
	if (Result != CRUMPLE_OK)
	{
		OutError = CrumpleWhy(Result);
		return false;
	}

	const float Enough = Tolerance * Length(Info.bounds.min, Info.bounds.max);
	const ECrumpleAxes All[] = {ECrumpleAxes::YUp, ECrumpleAxes::ZUp, ECrumpleAxes::Same};
	FString Tried;
	const TCHAR* Other = nullptr;
	for (const ECrumpleAxes Each : All)
	{
		int32 Vertex = 0;
		const FCrumpleSpace In(Each);
		const float Off = FurthestOff(In, Base, Vertex);
		const bool bAsked = Axes == ECrumpleAxes::Automatic || Axes == Each;
		if (Off <= Enough && bAsked)
		{
			Space = In;
			UE_LOG(LogCrumple, Log, TEXT("%s: axes %s, %d vertices for %u of the set"), *MeshName, Name(Each), Mesh.Num(), Info.vertex_count);
			return true;
		}
		if (Off <= Enough)
		{
			Other = Name(Each);
		}
		if (bAsked)
		{
			Tried += FString::Printf(TEXT("; with axes %s vertex %d is %.3f m off"), Name(Each), Vertex, Off);
		}
	}
	OutError = FString::Printf(TEXT("%s does not lie on the set's surface, up to %.3f m%s"), *MeshName, Enough, *Tried);
	OutError += Other ? FString::Printf(TEXT("; set Axes to %s"), Other)
		: FString(TEXT("; make the set from the file that the static mesh was imported from, import with Build Scale 1 and without transforms"));
	return false;
}

float FCrumpleShape::FurthestOff(const FCrumpleSpace& In, const TArray<CrumpleVec3>& Base, int32& OutVertex) const
{
	float Furthest = 0;
	const int32 Step = FMath::Max(1, Mesh.Num() / Samples);
	for (int32 Vertex = 0; Vertex < Mesh.Num(); Vertex += Step)
	{
		const CrumpleVec3 Point = In.PointToSet(FVector(Mesh.Positions[Vertex]));
		CrumpleAttachment Place;
		if (crumple_example_set_attach_point(Context->Get(), Set, Point, &Place) != CRUMPLE_OK)
		{
			OutVertex = Vertex;
			return TNumericLimits<float>::Max();
		}
		CrumpleVec3 Surface{};
		for (int32 Corner = 0; Corner < 3; ++Corner)
		{
			const CrumpleVec3& At = Base[Place.vertices[Corner]];
			Surface.x += Place.weights[Corner] * At.x;
			Surface.y += Place.weights[Corner] * At.y;
			Surface.z += Place.weights[Corner] * At.z;
		}
		const float Off = Length(Point, Surface);
		if (Off > Furthest)
		{
			Furthest = Off;
			OutVertex = Vertex;
		}
	}
	return Furthest;
}

bool FCrumpleShape::AddLevel(FString& OutError)
{
	TArray<CrumpleVec3> LevelPositions, LevelNormals;
	TArray<FVector4f> LevelTangents;
	for (int32 Vertex = 0; Vertex < Mesh.Num(); ++Vertex)
	{
		const FVector4f& Tangent = Mesh.Tangents[Vertex];
		const CrumpleVec3 Turned = Space.DirectionToSet(FVector(Tangent.X, Tangent.Y, Tangent.Z));
		LevelPositions.Add(Space.PointToSet(FVector(Mesh.Positions[Vertex])));
		LevelNormals.Add(Space.DirectionToSet(FVector(Mesh.Normals[Vertex])));
		LevelTangents.Add(FVector4f(Turned.x, Turned.y, Turned.z, Tangent.W * Space.Handedness()));
	}
	CrumpleMeshDef Def = crumple_mesh_def_default();
	Def.vertex_count = Mesh.Num();
	Def.positions = Input(LevelPositions);
	Def.normals = Input(LevelNormals);
	Def.tangents = Input(LevelTangents);
	const CrumpleResult Result = crumple_example_set_add_lod(Context->Get(), Set, &Def, &Lod);
	if (Result != CRUMPLE_OK)
	{
		OutError = CrumpleWhy(Result);
	}
	return Result == CRUMPLE_OK;
}
