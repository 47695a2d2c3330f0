#include "CrumpleModule.h"

#include "CrumpleLog.h"
#include "CrumpleVulkan.h"

#include "HAL/PlatformProcess.h"
#include "Interfaces/IPluginManager.h"
#include "Misc/CoreDelegates.h"
#include "Misc/Paths.h"

DEFINE_LOG_CATEGORY(LogCrumple);
IMPLEMENT_MODULE(FCrumpleModule, Crumple)

void FCrumpleModule::StartupModule()
{
#if CRUMPLE_DELAY_LOADED
	// Nothing of the library may be called before this: Windows would look for it, and end the process where there is none.
	const TSharedPtr<IPlugin> Plugin = IPluginManager::Get().FindPlugin(TEXT("Crumple"));
	const FString Path = FPaths::Combine(Plugin ? Plugin->GetBaseDir() : FString(), TEXT("Binaries/ThirdParty/CrumpleLibrary/Win64/crumple.dll"));
	Library = FPlatformProcess::GetDllHandle(*Path);
	if (!Library)
	{
		WhyNot = FString::Printf(TEXT("the Crumple library cannot be loaded from %s; put the one of the archive there"), *Path);
		UE_LOG(LogCrumple, Error, TEXT("%s"), *WhyNot);
		return;
	}
#endif
	WhyNot = CrumpleVersionProblem(crumple_version());
	if (!WhyNot.IsEmpty())
	{
		UE_LOG(LogCrumple, Error, TEXT("%s"), *WhyNot);
		return;
	}
	UE_LOG(LogCrumple, Log, TEXT("Crumple %s"), UTF8_TO_TCHAR(crumple_version_string()));
	// Still with an RHI, which modules may outlive.
	PreExit = FCoreDelegates::OnEnginePreExit.AddRaw(this, &FCrumpleModule::Stop);
}

void FCrumpleModule::Stop()
{
	if (Context)
	{
		Context->GetVulkan().Detach();
	}
}

void FCrumpleModule::ShutdownModule()
{
	FCoreDelegates::OnEnginePreExit.Remove(PreExit);
	Stop();
	// The library stays loaded: threads of it may still be on their way out.
	Context.Reset();
}

TSharedPtr<FCrumpleContext> FCrumpleModule::GetContext(FString& OutError)
{
	FCrumpleModule& Module = FModuleManager::LoadModuleChecked<FCrumpleModule>("Crumple");
	if (!Module.WhyNot.IsEmpty())
	{
		OutError = Module.WhyNot;
		return nullptr;
	}
	if (!Module.Context)
	{
		Module.Context = FCrumpleContext::Create(OutError);
	}
	return Module.Context;
}
