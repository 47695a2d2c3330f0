#include "CrumpleContext.h"

#include "CrumpleLog.h"
#include "CrumpleSet.h"
#include "CrumpleVulkan.h"

#include "Engine/StaticMesh.h"
#include "Misc/ScopeLock.h"

FString CrumpleWhy(CrumpleResult Result)
{
	return FString::Printf(TEXT("%s (%s)"), UTF8_TO_TCHAR(crumple_last_error()), UTF8_TO_TCHAR(crumple_result_name(Result)));
}

FString CrumpleVersionProblem(uint32 Library)
{
	const uint32 Header = CRUMPLE_VERSION;
	// Before 1.0 minor versions differ too.
	if (Library / 1000 == Header / 1000)
	{
		return FString();
	}
	return FString::Printf(
		TEXT("the Crumple library is of version %u.%u.%u, and the plugin was compiled for %u.%u.%u; take both from one archive"),
		Library / 1000000, Library / 1000 % 1000, Library % 1000, Header / 1000000, Header / 1000 % 1000, Header % 1000);
}

static void LogCrumpleMessage(CrumpleLogLevel Level, const char* Message, void*)
{
	if (Level == CRUMPLE_LOG_LEVEL_WARNING)
	{
		UE_LOG(LogCrumple, Warning, TEXT("%s"), UTF8_TO_TCHAR(Message));
	}
	else
	{
		UE_LOG(LogCrumple, Log, TEXT("%s"), UTF8_TO_TCHAR(Message));
	}
}

FCrumpleContext::FCrumpleContext() = default;

TSharedPtr<FCrumpleContext> FCrumpleContext::Create(FString& OutError)
{
	OutError = CrumpleVersionProblem(crumple_version());
	if (!OutError.IsEmpty())
	{
		return nullptr;
	}
	CrumpleContextDef Def = crumple_context_def_default();
	Def.log = LogCrumpleMessage;
	CrumpleContext* Made = nullptr;
	const CrumpleResult Result = crumple_context_create(&Def, &Made);
	if (Result != CRUMPLE_OK)
	{
		OutError = CrumpleWhy(Result);
		return nullptr;
	}
	TSharedPtr<FCrumpleContext> Context = MakeShareable(new FCrumpleContext);
	Context->Context = Made;
	Context->Contacts.Use(Made);
	Context->Vulkan = MakeUnique<FCrumpleVulkan>(*Context);
	return Context;
}

FCrumpleContext::~FCrumpleContext()
{
	Vulkan->Detach();
	const CrumpleResult Result = crumple_context_destroy(Context);
	if (Result != CRUMPLE_OK)
	{
		UE_LOG(LogCrumple, Error, TEXT("%s"), *CrumpleWhy(Result));
	}
}

TSharedPtr<FCrumpleShape> FCrumpleContext::FindShape(const UCrumpleSet& Asset, const UStaticMesh& Mesh, FString& OutError)
{
	Shapes.RemoveAll([](const FKnown& Known) { return !Known.Shape.IsValid(); });
	for (const FKnown& Known : Shapes)
	{
		// Whoever holds the shape holds both assets, so these addresses are nobody else's.
		if (Known.Asset == &Asset && Known.Revision == Asset.GetRevision() && Known.Axes == Asset.Axes && Known.Mesh == &Mesh)
		{
			// The render thread may have released it since it was found valid.
			if (const TSharedPtr<FCrumpleShape> Shape = Known.Shape.Pin())
			{
				return Shape;
			}
		}
	}
	FCrumpleMeshData Data;
	if (!Data.Read(Mesh, OutError))
	{
		return nullptr;
	}
	TSharedPtr<FCrumpleShape> Shape = MakeShared<FCrumpleShape>(AsShared(), MoveTemp(Data));
	if (!Shape->Load(Asset, Mesh.GetName(), OutError))
	{
		return nullptr;
	}
	Shapes.Add(FKnown{&Asset, Asset.GetRevision(), Asset.Axes, &Mesh, Shape});
	return Shape;
}
