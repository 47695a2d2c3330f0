using System;
using System.IO;
using Crumple;

/// <summary>
/// What is said of a library that cannot be used, before the first call into it. One process a case, since a library is loaded once.
/// Arguments: the case, and the file that is in the way of the right one; or for "missing" the right one.
/// </summary>
static class LibraryTests
{
    static string file;

    static int Main(string[] arguments)
    {
        file = arguments[1];
        switch (arguments[0])
        {
            case "version": return Check.Run(Version);
            case "patch": return Check.Run(Patch);
            case "foreign": return Check.Run(Foreign);
            case "architecture": return Check.Run(Architecture);
            case "garbage": return Check.Run(Garbage);
            case "missing": return Check.Run(Missing);
            default: return 2;
        }
    }

    static CrumpleLibraryException Refused(CrumpleLibraryProblem problem)
    {
        // Whatever comes first.
        CrumpleLibraryException error = Check.Throws<CrumpleLibraryException>(() => new CrumpleContext());
        Check.Same(problem, error.Problem, error.Message);
        Check.Same("0.1.0", error.WantedVersion, "wanted");
        Check.Throws<CrumpleLibraryException>(() => new ExampleSetDef(), error.Message);
        Check.Throws<CrumpleLibraryException>(() => CrumpleRuntime.PixelTolerance(1, 1, 1, 1), error.Message);
        Check.Throws<CrumpleLibraryException>(() => CrumpleRuntime.Features.ToString(), error.Message);
        Check.That(error.Message.Contains("0.1.0"), error.Message);
        return error;
    }

    static void Named(CrumpleLibraryException error, params string[] parts)
    {
        Check.Same(Path.GetFullPath(file), Path.GetFullPath(error.FileName), "file");
        foreach (string part in parts) Check.That(error.Message.Contains(part), error.Message + " has " + part);
        Console.WriteLine(error.Message);
    }

    static void Version()
    {
        CrumpleLibraryException error = Refused(CrumpleLibraryProblem.WrongVersion);
        Check.Same("0.2.3", error.FoundVersion, "found");
        Named(error, "0.2.3", "same package");
    }

    /// <summary>Another patch of the same minor version fits.</summary>
    static void Patch()
    {
        CrumpleRuntime.EnsureLoaded();
    }

    static void Foreign()
    {
        CrumpleLibraryException error = Refused(CrumpleLibraryProblem.MissingFunction);
        Check.Same(null, error.FoundVersion, "found");
        Named(error, "crumple_version", "no Crumple library");
    }

    static void Architecture()
    {
        Named(Refused(CrumpleLibraryProblem.WrongArchitecture), "for ARM64 ELF", "this process is ");
    }

    static void Garbage()
    {
        Named(Refused(CrumpleLibraryProblem.WrongArchitecture), "no native library");
    }

    /// <summary>And found as soon as it is there.</summary>
    static void Missing()
    {
        CrumpleLibraryException error = Refused(CrumpleLibraryProblem.Missing);
        Check.Same("libcrumple.so", error.FileName, "name");
        Check.That(error.Message.Contains("LD_LIBRARY_PATH"), error.Message);
        Console.WriteLine(error.Message);
        string beside = Path.Combine(AppDomain.CurrentDomain.BaseDirectory, "libcrumple.so");
        File.Copy(file, beside);
        try
        {
            using (CrumpleContext context = new CrumpleContext()) context.Deform();
            Check.Same("0.1.0", CrumpleRuntime.Version, "version");
        }
        finally
        {
            File.Delete(beside);
        }
    }
}
