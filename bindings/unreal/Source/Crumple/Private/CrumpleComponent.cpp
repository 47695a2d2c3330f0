#include "CrumpleComponent.h"

#include "CrumpleBody.h"
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
	Body = Shape ? FCrumpleBody::Create(Shape.ToSharedRef(), Compliance, LastError) : nullptr;
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
	Context->Contacts.Add(this);
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
		Body->Shape->Context->Contacts.Remove(this);
		Body->Release();
		Body.Reset();
		MarkRenderStateDirty();
	}
	Super::EndPlay(Reason);
}

void UCrumpleComponent::TickComponent(float DeltaTime, ELevelTick TickType, FActorComponentTickFunction* ThisTickFunction)
{
	Super::TickComponent(DeltaTime, TickType, ThisTickFunction);
	if (!Body)
	{
		return;
	}
	// Held, since those who are told of hits may end this component.
	const TSharedRef<FCrumpleContext> Context = Body->Shape->Context;
	Context->Contacts.Step(DeltaTime);
	if (Body && Body->TakePending())
	{
		MarkRenderDynamicDataDirty();
	}
}

void UCrumpleComponent::OnHit(UPrimitiveComponent*, AActor*, UPrimitiveComponent* OtherComp, FVector NormalImpulse,
	const FHitResult& HitResult)
{
	// Swept movement reports hits without an impulse.
	if (NormalImpulse.Size() > 0)
	{
		With([&](FCrumpleBody& Of)
			{ return Of.Shape->Context->Contacts.Report(*this, OtherComp, NormalImpulse.Size(), HitResult, LastError); });
	}
}

void UCrumpleComponent::Tell(const FVector& Point, double Depth)
{
	if (Depth > 0)
	{
		// The last thing done: the component may be gone afterwards.
		OnDented.Broadcast(this, Point, static_cast<float>(Depth * FCrumpleSpace::CmPerMetre));
	}
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

bool UCrumpleComponent::SubmitImpulse(FVector Point, FVector Impulse)
{
	const FTransform& Transform = GetComponentTransform();
	const FVector Place = Transform.InverseTransformPosition(Point), Push = Transform.InverseTransformVectorNoScale(Impulse);
	CrumpleHitResult Told{};
	if (!With([&](FCrumpleBody& Of) { return Of.Submit(Place, Push, Told, LastError); }))
	{
		return false;
	}
	Tell(Point, CrumpleDepth(Told));
	return true;
}

TFunction<bool(const FVector& Point, const FVector& Impulse)> UCrumpleComponent::MakeSubmitter() const
{
	return [Of = Body](const FVector& Point, const FVector& Impulse)
	{
		CrumpleHitResult Told{};
		FString Error;
		return Of && Of->Submit(Point, Impulse, Told, Error);
	};
}

bool UCrumpleComponent::Repair(float Keep)
{
	return With([&](FCrumpleBody& Of) { return Of.Repair(Keep, LastError); });
}

bool UCrumpleComponent::ResetDamage()
{
	return With([&](FCrumpleBody& Of) { return Of.Reset(LastError); });
}

bool UCrumpleComponent::SaveDamage(TArray<uint8>& Damage)
{
	return With([&](FCrumpleBody& Of) { return Of.Save(Damage, LastError); });
}

bool UCrumpleComponent::LoadDamage(const TArray<uint8>& Damage)
{
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
