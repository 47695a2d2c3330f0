using UnrealBuildTool;

public class Crumple : ModuleRules
{
	public Crumple(ReadOnlyTargetRules Target) : base(Target)
	{
		PCHUsage = PCHUsageMode.UseExplicitOrSharedPCHs;
		PublicDependencyModuleNames.AddRange(new[] { "Core", "CoreUObject", "Engine", "CrumpleLibrary" });
		PrivateDependencyModuleNames.AddRange(new[] { "Projects", "RenderCore", "RHI" });

		// Mac has no Vulkan RHI: the CPU path there.
		bool Vulkan = Target.Platform == UnrealTargetPlatform.Win64 || Target.Platform == UnrealTargetPlatform.Linux;
		if (Vulkan)
		{
			PrivateDependencyModuleNames.Add("VulkanRHI");
			AddEngineThirdPartyPrivateStaticDependencies(Target, "Vulkan");
		}
		PrivateDefinitions.Add("CRUMPLE_WITH_VULKAN=" + (Vulkan ? "1" : "0"));
	}
}
