#include "CrumpleContacts.h"

#include "CrumpleBody.h"
#include "CrumpleComponent.h"
#include "CrumpleLog.h"

#include "Components/StaticMeshComponent.h"

/** A pair that is awake and was not told of for longer than this no longer touches, s. */
static constexpr double Gap = 0.1;
/** What touches a component so soon after it began to play stood there before, s. */
static constexpr double Beginning = 0.1;

static CrumpleVec3 ToMetres(const FVector& Vector)
{
	const FVector Metres = Vector * (1 / FCrumpleSpace::CmPerMetre);
	return {static_cast<float>(Metres.X), static_cast<float>(Metres.Y), static_cast<float>(Metres.Z)};
}

static FVector VelocityAt(UPrimitiveComponent* Component, const FVector& Point)
{
	return !Component ? FVector::ZeroVector
		: Component->IsSimulatingPhysics() ? Component->GetPhysicsLinearVelocityAtPoint(Point) : Component->GetComponentVelocity();
}

static float MassOf(const UPrimitiveComponent* Component)
{
	return Component && Component->IsSimulatingPhysics() ? Component->GetMass() : INFINITY;
}

void FCrumpleContacts::Use(CrumpleContext* InContext)
{
	Context = InContext;
	CrumpleContactOptionsDef Options = crumple_contact_options_def_default();
	// Both components of a pair tell of it, each the whole impulse.
	Options.impulses = CRUMPLE_IMPULSES_WHOLE_AT_EVERY_POINT;
	crumple_context_set_contact_options(Context, &Options);
}

void FCrumpleContacts::Add(UCrumpleComponent* Component)
{
	Component->Began = Now;
	Components.Add(Component);
}

bool FCrumpleContacts::FTouch::IsAsleep() const
{
	for (const TWeakObjectPtr<UPrimitiveComponent>& Body : Bodies)
	{
		if (!Body.IsValid() || Body->IsAnyRigidBodyAwake())
		{
			return false;
		}
	}
	return true;
}

const FCrumpleContacts::FTouch& FCrumpleContacts::Touch(
	uint64 Pair, const FVector& Velocity, bool bStood, UPrimitiveComponent* const (&Bodies)[2])
{
	FTouch* Known = Touches.FindByPredicate([=](const FTouch& Each) { return Each.Pair == Pair; });
	if (!Known)
	{
		// The weight of a stack is the impulse of a blow. Only the velocity tells them apart, and here it is that after the step.
		const FVector Before = bStood ? Velocity : FVector::ZeroVector;
		return Touches[Touches.Add(FTouch{Pair, Before, Velocity, bStood, Now, {Bodies[0], Bodies[1]}})];
	}
	if (Known->Last < Now)
	{
		*Known = FTouch{Pair, Known->After, Velocity, true, Now, {Bodies[0], Bodies[1]}};
	}
	return *Known;
}

bool FCrumpleContacts::Report(UCrumpleComponent& Component, UPrimitiveComponent* Other, double Impulse, const FHitResult& Hit, FString& OutError)
{
	UCrumpleComponent** const Found =
		Components.FindByPredicate([=](const UCrumpleComponent* Each) { return Other && Each->bDentOnHit && Each->Target == Other; });
	UCrumpleComponent* const Bodies[2] = {&Component, Found ? *Found : nullptr};
	CrumpleContactPointDef Point = crumple_contact_point_def_default();
	for (int32 Side = 0; Side < 2 && Bodies[Side]; ++Side)
	{
		if (!Bodies[Side]->Body->Place(Bodies[Side]->GetRenderMatrix(), OutError))
		{
			return false;
		}
		Point.bodies[Side] = Bodies[Side]->Body->Get();
	}
	// Unreal's normal is that of one of the two. Ours points out of the surface.
	FVector Out;
	if (!Component.Body->FindNormal(Component.GetComponentTransform().InverseTransformPosition(Hit.ImpactPoint), Out, OutError))
	{
		return false;
	}
	Out = Component.GetRenderMatrix().TransformVector(Out);
	const double Turned = FVector::DotProduct(Hit.ImpactNormal, Out);
	const FVector Normal = Turned == 0 ? Out.GetSafeNormal() : Hit.ImpactNormal * (Turned < 0 ? -1.0 : 1.0);

	const uint32 Own = Component.Target->GetUniqueID(), Others = Other ? Other->GetUniqueID() : 0;
	const double Sign = Own < Others ? 1 : -1;
	const FVector Velocity = VelocityAt(Other, Hit.ImpactPoint) - VelocityAt(Component.Target, Hit.ImpactPoint);
	Point.pair = static_cast<uint64>(FMath::Min(Own, Others)) << 32 | FMath::Max(Own, Others);
	const bool bStood = Now - Component.Began < Beginning;
	UPrimitiveComponent* const Touching[2] = {Component.Target, Other};
	const FTouch& Known = Touch(Point.pair, Velocity * Sign, bStood, Touching);
	Point.has_velocity = Known.bKnown;
	Point.velocity = ToMetres(Known.Before * Sign);
	Point.point = ToMetres(Hit.ImpactPoint);
	Point.normal = {static_cast<float>(Normal.X), static_cast<float>(Normal.Y), static_cast<float>(Normal.Z)};
	Point.impulse = static_cast<float>(Impulse / FCrumpleSpace::CmPerMetre);
	Point.masses[0] = MassOf(Component.Target);
	Point.masses[1] = MassOf(Other);
	Point.gain = Component.Gain;
	if (crumple_context_report_contacts(Context, &Point, 1) != CRUMPLE_OK)
	{
		OutError = UTF8_TO_TCHAR(crumple_last_error());
		return false;
	}
	return true;
}

void FCrumpleContacts::Step(float Seconds)
{
	if (Frame == GFrameCounter || !(Seconds > 0))
	{
		return;
	}
	Frame = GFrameCounter;
	CrumpleContactReport Report{};
	crumple_context_step_contacts(Context, Seconds, &Report);
	if (Report.refused > 0 && !bWarned)
	{
		bWarned = true;
		UE_LOG(LogCrumple, Warning, TEXT("A hit was not taken: %s"), UTF8_TO_TCHAR(crumple_result_name(Report.refusal)));
	}
	Now += Seconds;
	Touches.RemoveAll([=, this](const FTouch& Each) { return Now - Each.Last > Gap && !Each.IsAsleep(); });
	Hits.SetNumUninitialized(static_cast<int32>(Report.hits));
	uint32_t Count = 0;
	if (Report.hits == 0 || crumple_context_get_contact_hits(Context, Hits.GetData(), static_cast<uint32_t>(Report.hits), &Count) != CRUMPLE_OK)
	{
		return;
	}
	for (uint32_t Index = 0; Index < Count; ++Index)
	{
		const CrumpleContactHit& Hit = Hits[static_cast<int32>(Index)];
		// Those who are told may end any component.
		UCrumpleComponent** const Struck = Components.FindByPredicate(
			[&](const UCrumpleComponent* Each)
			{
				const CrumpleInstance Own = Each->Body->Get();
				return Own.index == Hit.instance.index && Own.generation == Hit.instance.generation;
			});
		if (Struck)
		{
			(*Struck)->Body->SetPending();
			(*Struck)->Tell(FVector(Hit.point.x, Hit.point.y, Hit.point.z) * FCrumpleSpace::CmPerMetre, CrumpleDepth(Hit.result));
		}
	}
}
