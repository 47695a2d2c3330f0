#pragma once

#include "CrumpleContext.h"

#include "CoreMinimal.h"
#include "Modules/ModuleManager.h"

class FCrumpleModule : public IModuleInterface
{
public:
	virtual void StartupModule() override;
	virtual void ShutdownModule() override;

	/** The plugin's context, made when first asked for. Null, and why, where there can be none. Game thread. */
	static TSharedPtr<FCrumpleContext> GetContext(FString& OutError);

private:
	void Stop();

	TSharedPtr<FCrumpleContext> Context;
	FString WhyNot;  // there is no library
	void* Library = nullptr;
	FDelegateHandle PreExit;
};
