#include "CrumpleSet.h"

#include "CrumpleLog.h"

#include "Misc/FileHelper.h"
#include "Misc/Paths.h"

void UCrumpleSet::Import()
{
	if (ReadFile(File.FilePath))
	{
		MarkPackageDirty();
	}
}

UCrumpleSet* UCrumpleSet::LoadCrumpleSet(const FString& Path)
{
	UCrumpleSet* Set = NewObject<UCrumpleSet>();
	return Set->ReadFile(Path) ? Set : nullptr;
}

void UCrumpleSet::SetBytes(TArray<uint8> NewBytes)
{
	Bytes = MoveTemp(NewBytes);
	++Revision;
}

bool UCrumpleSet::ReadFile(const FString& Path)
{
	const FString Full = FPaths::IsRelative(Path) ? FPaths::Combine(FPaths::ProjectContentDir(), Path) : Path;
	TArray<uint8> Read;
	if (!FFileHelper::LoadFileToArray(Read, *Full))
	{
		UE_LOG(LogCrumple, Error, TEXT("%s cannot be read; paths that are not absolute begin in the project's Content folder"), *Full);
		return false;
	}
	SetBytes(MoveTemp(Read));
	UE_LOG(LogCrumple, Log, TEXT("%s: %d bytes"), *Full, Bytes.Num());
	return true;
}
