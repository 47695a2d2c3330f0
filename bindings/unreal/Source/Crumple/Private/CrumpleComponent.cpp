#include "CrumpleComponent.h"

#include "CrumpleBody.h"
#include "CrumpleContacts.h"
#include "CrumpleLog.h"
#include "CrumpleModule.h"
#include "CrumpleSceneProxy.h"
#include "CrumpleSet.h"

#include "Components/StaticMeshComponent.h"
#include "Engine/StaticMesh.h"
#include "GameFramework/Actor.h"
#include "RenderingThread.h"

UCrumpleComponent::UCrumpleComponent()
{
	PrimaryComponentTick.bCanEverTick = true;
	PrimaryComponentTick.TickGroup = TG_PostPhysics;
	SetCollisionEnabled(ECollisionEnabled::NoCollision);
	Contacts = MakeShared<FCrumpleContacts>();
}

void UCrumpleComponent::BeginPlay()
{
	Super::BeginPlay();
	if (!Begin())
	{
		UE_LOG(LogCrumple, Error, TEXT("%s: %s"), *GetPathName(), *LastError);
	}
}

bool UCrumpleComponent::Begin()
{
	AActor* Owner = GetOwner();
	Target = Cast<UStaticMeshComponent>(GetAttachParent());
	if (!Target && Owner)
	{
		Target = Owner->FindComponentByClass<UStaticMeshComponent>();
	}
	TargetMesh = Target ? Target->GetStaticMesh() : nullptr;
	TargetSet = Set;
	LastError = !Target ? TEXT("the actor has no static mesh component to dent")
		: !TargetMesh ? TEXT("the static mesh component has no static mesh")
		: !TargetSet ? TEXT("choose a Set") : TEXT("");
	if (!LastError.IsEmpty())
	{
		return false;
	}
	const TSharedPtr<FCrumpleContext> Context = FCrumpleModule::GetContext(LastError);
	const TSharedPtr<FCrumpleShape> Shape = Context ? Context->FindShape(*TargetSet, *TargetMesh, LastError) : nullptr;
	Body = Shape ? FCrumpleBody::Create(Shape.ToSharedRef(), LastError) : nullptr;
	if (!Body)
	{
		return false;
	}
	if (!AttachToComponent(Target, FAttachmentTransformRules::SnapToTargetIncludingScale))
	{
		LastError = TEXT("the component must not be above the static mesh component; put it below");
		Body.Reset();
		return false;
	}
	for (int32 Material = 0; Material < Target->GetNumMaterials(); ++Material)
	{
		SetMaterial(Material, Target->GetMaterial(Material));
	}
	Target->SetVisibility(false, false);
	if (bDentOnHit)
	{
		Target->SetNotifyRigidBodyCollision(true);
		Target->OnComponentHit.AddDynamic(this, &UCrumpleComponent::OnHit);
	}
	UpdateBounds();
	MarkRenderStateDirty();
	return true;
}

void UCrumpleComponent::EndPlay(const EEndPlayReason::Type Reason)
{
	if (Body)
	{
		if (IsValid(Target))
		{
			Target->OnComponentHit.RemoveDynamic(this, &UCrumpleComponent::OnHit);
			Target->SetVisibility(true, false);
		}
		Body->Release();
		Body.Reset();
		MarkRenderStateDirty();
	}
	Contacts->Reset();
	Super::EndPlay(Reason);
}

void UCrumpleComponent::TickComponent(float DeltaTime, ELevelTick TickType, FActorComponentTickFunction* ThisTickFunction)
{
	Super::TickComponent(DeltaTime, TickType, ThisTickFunction);
	Now += DeltaTime;
	if (!Body)
	{
		return;
	}
	for (const uint64 Contact : Contacts->Expire(Now))
	{
		Body->EndContact(Contact);
	}
	if (Body->TakePending())
	{
		MarkRenderDynamicDataDirty();
	}
}

void UCrumpleComponent::OnHit(UPrimitiveComponent*, AActor*, UPrimitiveComponent* OtherComp, FVector NormalImpulse,
	const FHitResult& HitResult)
{
	// Swept movement reports hits without an impulse.
	if (!Body || NormalImpulse.Size() <= LeastImpulse())
	{
		return;
	}
	const FVector Place = GetComponentTransform().InverseTransformPosition(HitResult.ImpactPoint);
	const uint64 Contact = Contacts->Find(OtherComp ? OtherComp->GetUniqueID() : 0, Place, Now);
	// Unreal tells after its step, so the velocity before the touch is unknown.
	const float StrikerMass = OtherComp && OtherComp->IsSimulatingPhysics() ? OtherComp->GetMass() : 0;
	Hit(HitResult.ImpactPoint, NormalImpulse, HitResult.ImpactNormal, StrikerMass, Contact, true);
}

bool UCrumpleComponent::Hit(
	const FVector& Point, const FVector& Impulse, const FVector& Normal, float StrikerMass, uint64 Contact, bool bInwards)
{
	const FTransform& Transform = GetComponentTransform();
	FCrumpleHit Made;
	Made.Point = Transform.InverseTransformPosition(Point);
	Made.Impulse = Transform.InverseTransformVectorNoScale(Impulse);
	Made.Normal = Transform.InverseTransformVectorNoScale(Normal);
	Made.StrikerMass = StrikerMass;
	Made.Duration = Duration;
	Made.VertexMass = VertexMass;
	Made.Contact = Contact;
	Made.bInwards = bInwards;
	CrumpleHitResult Told{};
	if (!With([&](FCrumpleBody& Of) { return Of.Submit(Made, Told, LastError); }))
	{
		return false;
	}
	if (Told.status == CRUMPLE_HIT_STATUS_MARKED)
	{
		const double Depth = FMath::Sqrt(FMath::Square(Told.achieved.x) + FMath::Square(Told.achieved.y) + FMath::Square(Told.achieved.z));
		// The last thing done: the component may be gone afterwards.
		OnDented.Broadcast(this, Point, static_cast<float>(Depth * FCrumpleSpace::CmPerMetre));
	}
	return true;
}

template <typename CallType>
bool UCrumpleComponent::With(CallType&& Call)
{
	if (!Body)
	{
		if (LastError.IsEmpty())
		{
			LastError = TEXT("the component does not play");
		}
		return false;
	}
	if (Call(*Body))
	{
		return true;
	}
	UE_LOG(LogCrumple, Warning, TEXT("%s: %s"), *GetPathName(), *LastError);
	return false;
}

float UCrumpleComponent::LeastImpulse() const
{
	// 980 cm/s^2.
	return MinImpulse > 0 ? MinImpulse : Target && Target->IsSimulatingPhysics() ? Target->GetMass() * 980 * 2 / 60 : 0;
}

bool UCrumpleComponent::SubmitImpulse(FVector Point, FVector Impulse)
{
	return Hit(Point, Impulse, FVector::ZeroVector, 0, 0, false);
}

TFunction<bool(const FVector& Point, const FVector& Impulse)> UCrumpleComponent::MakeSubmitter() const
{
	FCrumpleHit Form;
	Form.Duration = Duration;
	Form.VertexMass = VertexMass;
	return [Of = Body, Form](const FVector& Point, const FVector& Impulse)
	{
		FCrumpleHit Made = Form;
		Made.Point = Point;
		Made.Impulse = Impulse;
		CrumpleHitResult Told{};
		FString Error;
		return Of && Of->Submit(Made, Told, Error);
	};
}

bool UCrumpleComponent::Repair(float Keep)
{
	Contacts->Reset();
	return With([&](FCrumpleBody& Of) { return Of.Repair(Keep, LastError); });
}

bool UCrumpleComponent::ResetDamage()
{
	Contacts->Reset();
	return With([&](FCrumpleBody& Of) { return Of.Reset(LastError); });
}

bool UCrumpleComponent::SaveDamage(TArray<uint8>& Damage)
{
	return With([&](FCrumpleBody& Of) { return Of.Save(Damage, LastError); });
}

bool UCrumpleComponent::LoadDamage(const TArray<uint8>& Damage)
{
	Contacts->Reset();
	return With([&](FCrumpleBody& Of) { return Of.Load(Damage, LastError); });
}

FPrimitiveSceneProxy* UCrumpleComponent::CreateSceneProxy()
{
	return Body ? new FCrumpleSceneProxy(*this, Body.ToSharedRef(), bUseGPU) : nullptr;
}

void UCrumpleComponent::SendRenderDynamicData_Concurrent()
{
	Super::SendRenderDynamicData_Concurrent();
	FCrumpleSceneProxy* Proxy = static_cast<FCrumpleSceneProxy*>(SceneProxy);
	if (!Body || !Proxy)
	{
		return;
	}
	ENQUEUE_RENDER_COMMAND(CrumpleUpdate)([Proxy](FRHICommandListImmediate& RHICmdList) { Proxy->Update(RHICmdList); });
}

FMatrix UCrumpleComponent::GetRenderMatrix() const
{
	return Body ? Body->Shape->Space.SetToUnreal() * Super::GetRenderMatrix() : Super::GetRenderMatrix();
}

FBoxSphereBounds UCrumpleComponent::CalcLocalBounds() const
{
	if (!Body)
	{
		return Super::CalcLocalBounds();
	}
	// Of what the render matrix is applied to: m, in the set's space.
	const CrumpleAabb& Around = Body->Shape->Bounds;
	return FBoxSphereBounds(FBox(FVector(Around.min.x, Around.min.y, Around.min.z), FVector(Around.max.x, Around.max.y, Around.max.z)));
}

FBoxSphereBounds UCrumpleComponent::CalcBounds(const FTransform& LocalToWorld) const
{
	if (!Body)
	{
		return Super::CalcBounds(LocalToWorld);
	}
	FBox Box(ForceInit);
	Box += Body->Shape->Space.PointToUnreal(Body->Shape->Bounds.min);
	Box += Body->Shape->Space.PointToUnreal(Body->Shape->Bounds.max);
	return FBoxSphereBounds(Box).TransformBy(LocalToWorld);
}

int32 UCrumpleComponent::GetNumMaterials() const
{
	return Target ? Target->GetNumMaterials() : 0;
}
