using System;
using System.IO;
using System.Reflection;
using Crumple;
using Crumple.Native;

/// <summary>
/// What is said of a library that cannot be used, before the first call into it. One process a case, since a library is loaded
/// once. Arguments: the case, and the file that is in the way of the right one; or for "missing" the right one.
/// </summary>
static class LibraryTests
{
    static readonly string Wanted =
        NativeMethods.VersionMajor + "." + NativeMethods.VersionMinor + "." + NativeMethods.VersionPatch;
    static string file;

    static int Main(string[] arguments)
    {
        file = arguments[1];
        switch (arguments[0])
        {
            case "version": return Check.Run(Version);
            case "patch": return Check.Run(Patch, Images);
            case "foreign": return Check.Run(Foreign);
            case "architecture": return Check.Run(Architecture);
            case "garbage": return Check.Run(Garbage);
            case "missing": return Check.Run(Missing);
            case "beside": return Check.Run(Beside);
            default: return 2;
        }
    }

    static CrumpleLibraryException Refused(CrumpleLibraryProblem problem)
    {
        // Whatever comes first.
        CrumpleLibraryException error = Check.Throws<CrumpleLibraryException>(() => new CrumpleContext());
        Check.Same(problem, error.Problem, error.Message);
        Check.Same(Wanted, error.WantedVersion, "wanted");
        Check.Throws<CrumpleLibraryException>(() => new ExampleSetDef(), error.Message);
        Check.Throws<CrumpleLibraryException>(() => CrumpleRuntime.Features.ToString(), error.Message);
        Check.That(error.Message.Contains(Wanted), error.Message);
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
        string found = NativeMethods.VersionMajor + "." + (NativeMethods.VersionMinor + 1) + ".3";
        Check.Same(found, error.FoundVersion, "found");
        Named(error, found, "same package");
    }

    /// <summary>Another patch of the same minor version fits, but for the functions that this one lacks.</summary>
    static void Patch()
    {
        CrumpleLibraryException error = Refused(CrumpleLibraryProblem.MissingFunction);
        string found = NativeMethods.VersionMajor + "." + NativeMethods.VersionMinor + ".99";
        Check.Same(found, error.FoundVersion, "found");
        Named(error, found, "crumple_version_string");
        Func<uint, uint, bool> fits = (library, wanted) => (bool)Inside("LibraryCheck", "Fits", library, wanted);
        Check.That(fits(1000, 1000) && fits(1007, 1002) && !fits(1000, 1002), "patches of a minor version before 1.0");
        Check.That(!fits(2000, 1000) && !fits(1000, 2000) && !fits(1001000, 1000), "other versions before 1.0");
        Check.That(fits(1002000, 1001000) && !fits(1001000, 1002000) && !fits(2002000, 1001000), "from 1.0 on a newer one does");
        Check.That(fits(1001001, 1001000) && !fits(1001000, 1001001), "patches from 1.0 on");
    }

    /// <summary>Files of other systems, from the fields of their headers that tell the processor.</summary>
    static void Images()
    {
        byte[] elf = new byte[64], mach = new byte[64], pe = new byte[256];
        new byte[] { 0x7F, (byte)'E', (byte)'L', (byte)'F', 2, 1 }.CopyTo(elf, 0);
        elf[18] = 243;
        Check.Same("RISC-V ELF", Image(elf), "ELF");
        new byte[] { 0xCF, 0xFA, 0xED, 0xFE, 0x0C, 0, 0, 1 }.CopyTo(mach, 0);
        Check.Same("ARM64 Mach-O", Image(mach), "Mach-O");
        new byte[] { 0xCA, 0xFE, 0xBA, 0xBE, 0, 0, 0, 2, 1, 0, 0, 7 }.CopyTo(mach, 0);
        Check.Same("x86-64 Mach-O", Image(mach), "universal");
        pe[0] = (byte)'M';
        pe[1] = (byte)'Z';
        pe[60] = 0x80;
        new byte[] { (byte)'P', (byte)'E', 0, 0, 0x64, 0x86 }.CopyTo(pe, 0x80);
        Check.Same("x86-64 PE", Image(pe), "PE");
        pe[61] = 0xFF;
        Check.Same("no native library", Image(pe), "a header outside the file");
        for (int length = 0; length < 20; length++)
        {
            byte[] cut = new byte[length];
            Array.Copy(elf, cut, length);
            Check.Same("no native library", Image(cut), "cut short");
        }
    }

    static string Image(byte[] bytes)
    {
        return (string)Inside("NativeImage", "OfBytes", bytes);
    }

    static object Inside(string type, string method, params object[] arguments)
    {
        Type found = typeof(CrumpleRuntime).Assembly.GetType("Crumple." + type, true);
        return found.GetMethod(method, BindingFlags.Static | BindingFlags.NonPublic).Invoke(null, arguments);
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

    static void Missing()
    {
        CrumpleLibraryException error = Refused(CrumpleLibraryProblem.Missing);
        Check.Same("libcrumple.so", error.FileName, "name");
        Check.That(error.Message.Contains("LD_LIBRARY_PATH"), error.Message);
        Console.WriteLine(error.Message);
        // Mono remembers what it did not find.
        string beside = Path.Combine(AppDomain.CurrentDomain.BaseDirectory, "libcrumple.so");
        File.Copy(file, beside);
        try
        {
            file = beside;
            Named(Refused(CrumpleLibraryProblem.Missing), "is there", "start the process anew");
        }
        finally
        {
            File.Delete(beside);
        }
    }

    /// <summary>Beside the program, nobody needs to tell where it is.</summary>
    static void Beside()
    {
        using (CrumpleContext context = new CrumpleContext()) context.Deform();
        Check.Same(Wanted, CrumpleRuntime.Version, "version");
        Check.That((CrumpleRuntime.Features & CrumpleFeatures.Gltf) != 0, "features");
    }
}
