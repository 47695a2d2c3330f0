// Dents the static mesh of its actor where that is hit.
#pragma once

#include "CoreMinimal.h"
#include "Components/MeshComponent.h"

#include "CrumpleComponent.generated.h"

class FCrumpleBody;
class FCrumpleContacts;
class UCrumpleComponent;
class UCrumpleSet;
class UStaticMesh;
class UStaticMeshComponent;

/** A dent was made: where, in world space, and how deep, cm. The component may be destroyed in here. */
DECLARE_DYNAMIC_MULTICAST_DELEGATE_ThreeParams(FCrumpleDentedSignature, UCrumpleComponent*, Component, FVector, Point, float, Depth);

/**
 * Put it on an actor with a static mesh component, below it or anywhere on the actor, and choose a Set. From BeginPlay on it draws the
 * static mesh in its component's place, dented; that component stays what collides, and is only hidden. Where something does not fit
 * nothing is hidden, LastError says why, and so does the log (LogCrumple).
 */
UCLASS(ClassGroup = (Physics), meta = (BlueprintSpawnableComponent))
class CRUMPLE_API UCrumpleComponent : public UMeshComponent
{
	GENERATED_BODY()

public:
	UCrumpleComponent();

	/** The base mesh and the examples. */
	UPROPERTY(EditAnywhere, BlueprintReadWrite, Category = "Crumple")
	TObjectPtr<UCrumpleSet> Set;

	/** How far an impulse of 1 N s moves its place, m, if no example knows its blow. Read when the component begins to play. */
	UPROPERTY(EditAnywhere, BlueprintReadWrite, Category = "Crumple", meta = (ClampMin = "0"))
	float Compliance = 0.02f;

	/** Factor of the energy of collisions. */
	UPROPERTY(EditAnywhere, BlueprintReadWrite, Category = "Crumple", meta = (ClampMin = "0"))
	float Gain = 1;

	/** Whether hits of the static mesh component dent it by themselves. */
	UPROPERTY(EditAnywhere, BlueprintReadWrite, Category = "Crumple")
	bool bDentOnHit = true;

	/** Whether dents are made on the GPU where the RHI is Vulkan's. They are the same. Read when the component begins to play. */
	UPROPERTY(EditAnywhere, BlueprintReadWrite, Category = "Crumple")
	bool bUseGPU = true;

	UPROPERTY(BlueprintAssignable, Category = "Crumple")
	FCrumpleDentedSignature OnDented;

	/** What was wrong in the last call that returned false, or in BeginPlay; empty if nothing ever was. */
	UPROPERTY(BlueprintReadOnly, Transient, Category = "Crumple")
	FString LastError;

	/** Whether the component draws and dents. */
	UFUNCTION(BlueprintPure, Category = "Crumple")
	bool IsWorking() const { return Body.IsValid(); }

	/** Hits the body: a point in world space, cm, and the impulse that it receives, kg cm/s. Game thread. */
	UFUNCTION(BlueprintCallable, Category = "Crumple")
	bool SubmitImpulse(FVector Point, FVector Impulse);

	/** Lets every dent keep this share of its depth: 0 as new, 1 nothing repaired. */
	UFUNCTION(BlueprintCallable, Category = "Crumple")
	bool Repair(float Keep);

	UFUNCTION(BlueprintCallable, Category = "Crumple")
	bool ResetDamage();

	/** The damage as bytes, for saved games and for the network: 32 a dent, and a few. */
	UFUNCTION(BlueprintCallable, Category = "Crumple")
	bool SaveDamage(TArray<uint8>& Damage);

	/** Shows damage that SaveDamage gave, here or on another machine, of the same set. */
	UFUNCTION(BlueprintCallable, Category = "Crumple")
	bool LoadDamage(const TArray<uint8>& Damage);

	/** A function that hits the body from any thread, also after the component is gone (false then): a point, cm, and an impulse,
	    kg cm/s, both in the component's space. OnDented is not told. Game thread. */
	TFunction<bool(const FVector& Point, const FVector& Impulse)> MakeSubmitter() const;

	/** The plugin's own. */
	TSharedPtr<FCrumpleBody> GetBody() const { return Body; }

	virtual void BeginPlay() override;
	virtual void EndPlay(const EEndPlayReason::Type Reason) override;
	virtual void TickComponent(float DeltaTime, ELevelTick TickType, FActorComponentTickFunction* ThisTickFunction) override;
	virtual FPrimitiveSceneProxy* CreateSceneProxy() override;
	virtual FMatrix GetRenderMatrix() const override;
	virtual FBoxSphereBounds CalcBounds(const FTransform& LocalToWorld) const override;
	virtual FBoxSphereBounds CalcLocalBounds() const override;
	virtual int32 GetNumMaterials() const override;

protected:
	virtual void SendRenderDynamicData_Concurrent() override;

private:
	UFUNCTION()
	void OnHit(UPrimitiveComponent* HitComponent, AActor* OtherActor, UPrimitiveComponent* OtherComp, FVector NormalImpulse,
		const FHitResult& Hit);

	bool Begin();
	/** Tells OnDented of a dent at a place in the world, cm; Depth in m, 0 for none. The component may be gone afterwards. */
	void Tell(const FVector& Point, double Depth);
	/** Runs a call of the body; remembers why it fails. */
	template <typename CallType>
	bool With(CallType&& Call);

	/** What is dented. */
	UPROPERTY(Transient)
	TObjectPtr<UStaticMeshComponent> Target;

	/** What the body was made of: it must not go before. */
	UPROPERTY(Transient)
	TObjectPtr<UStaticMesh> TargetMesh;
	UPROPERTY(Transient)
	TObjectPtr<UCrumpleSet> TargetSet;

	TSharedPtr<FCrumpleBody> Body;
	/** Time of the contacts when play began, s. */
	double Began = 0;

	friend FCrumpleContacts;
};
