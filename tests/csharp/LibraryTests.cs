using System;
using Crumple;
using Crumple.Native;

/// <summary>
/// What is said of a library that cannot be used, before the first call into it. One process a case, since a library is loaded
/// once. The argument is the case.
/// </summary>
static class LibraryTests
{
    static int Main(string[] arguments)
    {
        switch (arguments[0])
        {
            case "version": return Check.Run(Version);
            case "patch": return Check.Run(Patch);
            case "foreign": return Check.Run(Foreign);
            case "garbage": return Check.Run(NotLoaded);
            case "missing": return Check.Run(NotLoaded);
            default: return 2;
        }
    }

    /// <summary>Whatever comes first, and each time.</summary>
    static void Refused(string part)
    {
        string wanted = NativeMethods.VersionMajor + "." + NativeMethods.VersionMinor + "." + NativeMethods.VersionPatch;
        CrumpleLibraryException error = Check.Throws<CrumpleLibraryException>(() => new CrumpleContext(), part);
        Check.Throws<CrumpleLibraryException>(() => new ExampleSetDef(), error.Message);
        Check.That(error.Message.Contains(wanted), error.Message);
        Console.WriteLine(error.Message);
    }

    static void Version()
    {
        Refused("is Crumple " + NativeMethods.VersionMajor + "." + (NativeMethods.VersionMinor + 1) + ".3, but");
    }

    /// <summary>A later patch of the same minor version fits.</summary>
    static void Patch()
    {
        CrumpleRuntime.EnsureLoaded();
    }

    static void Foreign()
    {
        Refused("has no function crumple_version");
    }

    static void NotLoaded()
    {
        Refused("was not loaded: it is missing, or is for another system");
    }
}
