#include "CrumpleBody.h"

#include "CrumpleLog.h"
#include "CrumpleVulkan.h"

#include "Misc/ScopeLock.h"
#include "Misc/ScopeRWLock.h"

static const TCHAR* const Gone = TEXT("the body is gone");

FCrumpleBody::FCrumpleBody(TSharedRef<FCrumpleShape> InShape) : Shape(InShape), Layout{static_cast<uint32>(InShape->Mesh.Num())} {}

TSharedPtr<FCrumpleBody> FCrumpleBody::Create(TSharedRef<FCrumpleShape> Shape, float Compliance, FString& OutError)
{
	TSharedPtr<FCrumpleBody> Body = MakeShareable(new FCrumpleBody(Shape));
	CrumpleInstanceDef Def = crumple_instance_def_default();
	Def.set = Shape->Set;
	Def.compliance = Compliance;
	FScopeLock Lock(&Shape->Context->Mutex);
	const CrumpleResult Result = crumple_instance_create(Shape->Context->Get(), &Def, &Body->Instance);
	if (Result != CRUMPLE_OK)
	{
		OutError = CrumpleWhy(Result);
		return nullptr;
	}
	return Body;
}

FCrumpleBody::~FCrumpleBody()
{
	Release();
}

void FCrumpleBody::Release()
{
	FWriteScopeLock Writing(Life);
	if (Instance.index == 0)
	{
		return;
	}
	FScopeLock Lock(&Shape->Context->Mutex);
	// Its buffers end with it, the ranges of proxies too.
	Shape->Context->GetVulkan().Forget(Instance);
	crumple_instance_destroy(Shape->Context->Get(), Instance);
	Instance = {};
	Buffer = {};
}

template <typename CallType>
bool FCrumpleBody::Shared(CallType&& Call, FString& OutError)
{
	FReadScopeLock Reading(Life);
	if (Instance.index == 0)
	{
		OutError = Gone;
		return false;
	}
	const CrumpleResult Result = Call(Shape->Context->Get());
	if (Result != CRUMPLE_OK)
	{
		OutError = CrumpleWhy(Result);
		return false;
	}
	return true;
}

template <typename CallType>
bool FCrumpleBody::Locked(CallType&& Call, FString& OutError)
{
	return Shared(
		[&](CrumpleContext* Context)
		{
			FScopeLock Lock(&Shape->Context->Mutex);
			return Call(Context);
		},
		OutError);
}

bool FCrumpleBody::Submit(const FVector& Point, const FVector& Impulse, CrumpleHitResult& OutTold, FString& OutError)
{
	CrumpleHitDef Def = crumple_hit_def_default();
	Def.point = Shape->Space.PointToSet(Point);
	Def.impulse = Shape->Space.ImpulseToSet(Impulse);
	const bool bDone = Shared(
		[&](CrumpleContext* Context) { return crumple_instance_submit_hit(Context, Instance, &Def, &OutTold); }, OutError);
	bPending = bPending || bDone;
	return bDone;
}

bool FCrumpleBody::Place(const FMatrix& ToWorld, FString& OutError)
{
	// A row of Unreal's is a column here.
	float Columns[16];
	for (int32 Row = 0; Row < 4; ++Row)
	{
		for (int32 Axis = 0; Axis < 4; ++Axis)
		{
			Columns[4 * Row + Axis] = static_cast<float>(ToWorld.M[Row][Axis] / (Axis < 3 ? FCrumpleSpace::CmPerMetre : 1));
		}
	}
	return Shared([&](CrumpleContext* Context) { return crumple_instance_set_transform(Context, Instance, Columns); }, OutError);
}

bool FCrumpleBody::FindNormal(const FVector& Point, FVector& OutNormal, FString& OutError)
{
	CrumpleHitDef Def = crumple_hit_def_default();
	Def.point = Shape->Space.PointToSet(Point);
	CrumpleHitResult Told{};
	if (!Shared([&](CrumpleContext* Context) { return crumple_instance_preview_hit(Context, Instance, &Def, &Told); }, OutError))
	{
		return false;
	}
	const CrumpleVec3& Normal = Shape->Normals[Told.contact_vertex];
	OutNormal = FVector(Normal.x, Normal.y, Normal.z);
	return true;
}

bool FCrumpleBody::Repair(float Keep, FString& OutError)
{
	return Change([&](CrumpleContext* Context) { return crumple_instance_repair_damage(Context, Instance, Keep); }, OutError);
}

bool FCrumpleBody::Reset(FString& OutError)
{
	return Change([&](CrumpleContext* Context) { return crumple_instance_reset_damage(Context, Instance); }, OutError);
}

bool FCrumpleBody::Save(TArray<uint8>& OutDamage, FString& OutError)
{
	return Locked(
		[&](CrumpleContext* Context)
		{
			size_t Size = 0;
			CrumpleResult Result = crumple_instance_save_damage(Context, Instance, nullptr, 0, &Size);
			// Hits from other threads may come in between: they grow it.
			for (int32 Attempt = 0; Result == CRUMPLE_OK; ++Attempt)
			{
				OutDamage.SetNumUninitialized(static_cast<int32>(Size));
				const size_t Room = Size;
				Result = crumple_instance_save_damage(Context, Instance, OutDamage.GetData(), Room, &Size);
				if (Result != CRUMPLE_ERROR_BUFFER_TOO_SMALL || Attempt == 8)
				{
					break;
				}
				Result = crumple_instance_save_damage(Context, Instance, nullptr, 0, &Size);
			}
			if (Result == CRUMPLE_OK)
			{
				OutDamage.SetNum(static_cast<int32>(Size));
			}
			return Result;
		},
		OutError);
}

bool FCrumpleBody::Load(const TArray<uint8>& Damage, FString& OutError)
{
	return Change([&](CrumpleContext* Context) { return crumple_instance_load_damage(Context, Instance, Damage.GetData(), Damage.Num()); }, OutError);
}

TArray<uint8> FCrumpleBody::MakeBytes() const
{
	const FCrumpleMeshData& Mesh = Shape->Mesh;
	TArray<uint8> Made;
	Made.SetNumZeroed(Layout.Size());
	for (uint32 Vertex = 0; Vertex < Layout.Vertices; ++Vertex)
	{
		const FVector4f& Tangent = Mesh.Tangents[Vertex];
		const float Sign = Tangent.W * Shape->Space.Handedness();
		const CrumpleVec3 Position = Shape->Space.PointToSet(FVector(Mesh.Positions[Vertex]));
		const CrumpleVec3 T = Shape->Space.DirectionToSet(FVector(Tangent.X, Tangent.Y, Tangent.Z));
		const CrumpleVec3 N = Shape->Space.DirectionToSet(FVector(Mesh.Normals[Vertex]));
		const float Basis[8] = {T.x, T.y, T.z, Sign, N.x, N.y, N.z, Sign};
		FMemory::Memcpy(&Made[Vertex * FCrumpleLayout::PositionStride], &Position, sizeof Position);
		FMemory::Memcpy(&Made[Layout.BasisBegin() + Vertex * FCrumpleLayout::BasisStride], Basis, sizeof Basis);
	}
	return Made;
}

bool FCrumpleBody::Deform(TArray<uint8>& OutBytes, bool bAlways)
{
	FString Error;
	CrumpleDeformReport Report{};
	OutBytes.Empty();
	const bool bDone = Locked(
		[&](CrumpleContext* Context)
		{
			CrumpleResult Result = CRUMPLE_OK;
			if (Buffer.index == 0)
			{
				Bytes = MakeBytes();
				uint8* Data = Bytes.GetData();
				const size_t Size = Bytes.Num(), Basis = Layout.BasisBegin();
				CrumpleHostBufferDef Def = crumple_host_buffer_def_default();
				Def.lod = Shape->Lod;
				Def.positions = {Data, Size, 0, FCrumpleLayout::PositionStride};
				Def.tangents = {Data, Size, Basis, FCrumpleLayout::BasisStride};
				Def.normals = {Data, Size, Basis + FCrumpleLayout::NormalOffset, FCrumpleLayout::BasisStride};
				Result = crumple_buffer_register_host(Context, Instance, &Def, &Buffer);
			}
			if (Result == CRUMPLE_OK)
			{
				Result = crumple_context_deform(Context, &Buffer, 1, &Report);
			}
			if (Result == CRUMPLE_OK && (bAlways || Report.blocks_written > 0))
			{
				OutBytes = Bytes;
			}
			return Result;
		},
		Error);
	// A proxy may outlive its body for a moment.
	if (!bDone && Error != Gone)
	{
		UE_LOG(LogCrumple, Error, TEXT("%s"), *Error);
	}
	return OutBytes.Num() > 0;
}
