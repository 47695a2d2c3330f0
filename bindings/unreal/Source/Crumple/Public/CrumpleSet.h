// An example set as an asset: the bytes of a .crumple or .glb file.
#pragma once

#include "CoreMinimal.h"
#include "Engine/DataAsset.h"
#include "Engine/EngineTypes.h"

#include "CrumpleSet.generated.h"

/** Which way the file's axes lie in the static mesh. Both are the same body; the importer turned one of them. */
UENUM(BlueprintType)
enum class ECrumpleAxes : uint8
{
	/** The one of those below in which the static mesh lies on the set's surface. The first of them where several do. */
	Automatic,
	/** Unreal X, Y, Z are the file's x, z, y: y is up there, as in glTF. */
	YUp,
	/** Unreal X, Y, Z are the file's x, -y, z: z is up there and the space right-handed, as in Blender or most FBX. */
	ZUp,
	/** Unreal X, Y, Z are the file's x, y, z. */
	Same,
};

/** A base mesh and its examples. Any number of components share one. */
UCLASS(BlueprintType)
class CRUMPLE_API UCrumpleSet : public UDataAsset
{
	GENERATED_BODY()

public:
	/** Where Import reads from: a .crumple or .glb file, made from the very mesh that the static mesh was imported from. */
	UPROPERTY(EditAnywhere, Category = "Crumple", meta = (FilePathFilter = "Crumple or GLB (*.crumple;*.glb)|*.crumple;*.glb"))
	FFilePath File;

	/** The file's space. Lengths in it are metres. */
	UPROPERTY(EditAnywhere, BlueprintReadWrite, Category = "Crumple")
	ECrumpleAxes Axes = ECrumpleAxes::Automatic;

	/** Reads File into this asset, which is then all that a packaged game needs. */
	UFUNCTION(CallInEditor, Category = "Crumple")
	void Import();

	/** Reads a file at run time: an absolute path, or one inside of the project's Content. Null where it cannot be read; the log says
	    why. Files that are no assets must be named in Additional Non-Asset Directories to Package. */
	UFUNCTION(BlueprintCallable, Category = "Crumple")
	static UCrumpleSet* LoadCrumpleSet(const FString& Path);

	/** Replaces the bytes. What they are is checked when the first component uses them. */
	void SetBytes(TArray<uint8> NewBytes);

	const TArray<uint8>& GetBytes() const { return Bytes; }
	/** Another number for other bytes. */
	uint32 GetRevision() const { return Revision; }

private:
	bool ReadFile(const FString& Path);

	UPROPERTY()
	TArray<uint8> Bytes;

	uint32 Revision = 0;
};
