#include "CrumpleBody.h"

#include "CrumpleLog.h"
#include "CrumpleVulkan.h"

#include "Misc/ScopeLock.h"
#include "Misc/ScopeRWLock.h"

static const TCHAR* const Gone = TEXT("the body is gone");

FCrumpleBody::FCrumpleBody(TSharedRef<FCrumpleShape> InShape) : Shape(InShape), Layout{static_cast<uint32>(InShape->Mesh.Num())} {}

TSharedPtr<FCrumpleBody> FCrumpleBody::Create(TSharedRef<FCrumpleShape> Shape, FString& OutError)
{
	TSharedPtr<FCrumpleBody> Body = MakeShareable(new FCrumpleBody(Shape));
	CrumpleInstanceDef Def = crumple_instance_def_default();
	Def.set = Shape->Set;
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

bool FCrumpleBody::Submit(const FCrumpleHit& Hit, CrumpleHitResult& OutTold, FString& OutError)
{
	CrumpleHitDef Def = crumple_hit_def_default();
	Def.point = Shape->Space.PointToSet(Hit.Point);
	Def.impulse = Shape->Space.ImpulseToSet(Hit.Impulse);
	Def.normal = Shape->Space.DirectionToSet(Hit.Normal);
	Def.striker.mass = Hit.StrikerMass;
	Def.duration = Hit.Duration;
	Def.mass = Hit.VertexMass;
	Def.contact_id = Hit.Contact;

	FReadScopeLock Reading(Life);
	if (Instance.index == 0)
	{
		OutError = Gone;
		return false;
	}
	CrumpleContext* Context = Shape->Context->Get();
	CrumpleResult Result = CRUMPLE_OK;
	if (Hit.bInwards)
	{
		Result = crumple_instance_preview_hit(Context, Instance, &Def, &OutTold);
		if (Result == CRUMPLE_OK)
		{
			const CrumpleVec3& Out = Shape->Normals[OutTold.contact_vertex];
			if (Def.impulse.x * Out.x + Def.impulse.y * Out.y + Def.impulse.z * Out.z > 0)
			{
				Def.impulse = {-Def.impulse.x, -Def.impulse.y, -Def.impulse.z};
			}
			if (Def.normal.x * Out.x + Def.normal.y * Out.y + Def.normal.z * Out.z < 0)
			{
				Def.normal = {-Def.normal.x, -Def.normal.y, -Def.normal.z};
			}
		}
	}
	if (Result == CRUMPLE_OK)
	{
		Result = crumple_instance_submit_hit(Context, Instance, &Def, &OutTold);
	}
	if (Result != CRUMPLE_OK)
	{
		OutError = CrumpleWhy(Result);
		return false;
	}
	bPending = true;
	return true;
}

bool FCrumpleBody::EndContact(uint64 Contact)
{
	FReadScopeLock Reading(Life);
	return Instance.index != 0 && crumple_instance_end_contact(Shape->Context->Get(), Instance, Contact) == CRUMPLE_OK;
}

template <typename CallType>
bool FCrumpleBody::Locked(CallType&& Call, FString& OutError)
{
	FReadScopeLock Reading(Life);
	if (Instance.index == 0)
	{
		OutError = Gone;
		return false;
	}
	FScopeLock Lock(&Shape->Context->Mutex);
	const CrumpleResult Result = Call(Shape->Context->Get());
	if (Result != CRUMPLE_OK)
	{
		OutError = CrumpleWhy(Result);
		return false;
	}
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
