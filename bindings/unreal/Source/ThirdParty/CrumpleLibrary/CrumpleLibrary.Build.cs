// The library from the archive: headers in Public, libraries in Lib/<platform>. `cargo xtask package` fills both.
using System.IO;
using UnrealBuildTool;

public class CrumpleLibrary : ModuleRules
{
	public CrumpleLibrary(ReadOnlyTargetRules Target) : base(Target)
	{
		Type = ModuleType.External;
		PublicSystemIncludePaths.Add(Path.Combine(ModuleDirectory, "Public"));

		string Libraries = Path.Combine(ModuleDirectory, "Lib", Target.Platform.ToString());
		if (Target.Platform == UnrealTargetPlatform.Win64)
		{
			PublicAdditionalLibraries.Add(Present(Path.Combine(Libraries, "crumple.dll.lib")));
			// Loaded by the Crumple module as it starts, which names the file when it is not there.
			PublicDelayLoadDLLs.Add("crumple.dll");
			PublicDefinitions.Add("CRUMPLE_DELAY_LOADED=1");
			RuntimeDependencies.Add("$(PluginDir)/Binaries/ThirdParty/CrumpleLibrary/Win64/crumple.dll",
				Present(Path.Combine(Libraries, "crumple.dll")));
		}
		else if (Target.Platform == UnrealTargetPlatform.Linux)
		{
			// Linked by one name, and looked for beside the binary by its SONAME: the same file twice.
			const string Name = "libcrumple.so.0.2";
			PublicAdditionalLibraries.Add(Present(Path.Combine(Libraries, "libcrumple.so")));
			RuntimeDependencies.Add("$(BinaryOutputDir)/" + Name, Present(Path.Combine(Libraries, Name)));
			PublicDefinitions.Add("CRUMPLE_DELAY_LOADED=0");
		}
		else if (Target.Platform == UnrealTargetPlatform.Mac)
		{
			// Static: nothing to stage, and nothing whose path could be wrong.
			PublicAdditionalLibraries.Add(Present(Path.Combine(Libraries, "libcrumple.a")));
			PublicDefinitions.Add("CRUMPLE_DELAY_LOADED=0");
		}
		else
		{
			throw new BuildException("Crumple has no library for " + Target.Platform + "; there are some for Win64, Linux and Mac");
		}
	}

	private static string Present(string File)
	{
		if (!System.IO.File.Exists(File))
		{
			throw new BuildException("Crumple: there is no " + File + "; put the library of the archive there, see README.md of the plugin");
		}
		return File;
	}
}
