using System;
using System.Collections.Generic;
using System.IO;
using System.Reflection;
using System.Runtime.InteropServices;
using Crumple.Native;

namespace Crumple
{
    /// <summary>Loads the library for the first time, and says in one exception what is wrong where that fails.</summary>
    internal static class LibraryCheck
    {
        internal static void Run()
        {
            uint found;
            try
            {
                found = NativeMethods.crumple_version();
            }
            catch (EntryPointNotFoundException)
            {
                string file = LoadedFile() ?? NativeMethods.Library;
                throw Problem(CrumpleLibraryProblem.MissingFunction, file, null,
                    file + " has no function crumple_version: it is no Crumple library. Put the file of Crumple " + Wanted
                    + " in its place.");
            }
            catch (BadImageFormatException error)
            {
                throw NotLoaded(error.Message);
            }
            catch (DllNotFoundException error)
            {
                throw NotLoaded(error.Message);
            }
            if (!Fits(found, NativeMethods.Version))
            {
                string file = LoadedFile() ?? NativeMethods.Library;
                throw Problem(CrumpleLibraryProblem.WrongVersion, file, Text(found),
                    file + " is Crumple " + Text(found) + ", but these C# files are of Crumple " + Wanted
                    + ". Take both from the same package; an editor or game that has loaded the old file must be restarted.");
            }
#if !ENABLE_IL2CPP
            LookUpFunctions(Text(found));
#endif
        }

#if !ENABLE_IL2CPP
        /// <summary>
        /// Looks up every function, so that a library which lacks one is named now and not in the middle of a game.
        /// </summary>
        private static void LookUpFunctions(string found)
        {
            foreach (MethodInfo method in typeof(NativeMethods).GetMethods(BindingFlags.Static | BindingFlags.Public))
            {
                if ((method.Attributes & MethodAttributes.PinvokeImpl) == 0) continue;
                try
                {
                    Marshal.Prelink(method);
                }
                catch (EntryPointNotFoundException)
                {
                    string file = LoadedFile() ?? NativeMethods.Library;
                    throw Problem(CrumpleLibraryProblem.MissingFunction, file, found,
                        file + " has no function " + method.Name + ", though it says that it is Crumple " + found
                        + ", and these C# files are of Crumple " + Wanted + ". Take both from the same package.");
                }
            }
        }
#endif

        /// <summary>
        /// Whether C# files of one version can call a library of another: of a later one of the same kind. Before 1.0 the minor
        /// version counts as the major one does later.
        /// </summary>
        internal static bool Fits(uint library, uint wanted)
        {
            uint unit = wanted < 1000000 ? 1000u : 1000000u;
            return library / unit == wanted / unit && library >= wanted;
        }

        private static string Wanted
        {
            get { return Text(NativeMethods.Version); }
        }

        private static string Text(uint version)
        {
            return version / 1000000 + "." + version / 1000 % 1000 + "." + version % 1000;
        }

        private static CrumpleLibraryException Problem(CrumpleLibraryProblem problem, string file, string found, string message)
        {
            return new CrumpleLibraryException(problem, file, found, Wanted, message);
        }

        /// <summary>Loaders say "not found" for files of another processor as well: look whether there is one.</summary>
        private static CrumpleLibraryException NotLoaded(string reason)
        {
            // Mono has nothing to tell but the name and three unknowns.
            reason = reason.Contains("<unknown") ? "" : " (" + reason + ")";
            string here = NativeImage.OfThisProcess();
            foreach (string file in Candidates())
            {
                string image = NativeImage.OfFile(file);
                if (image == null) continue;
                if (image == NativeImage.None)
                    return Problem(CrumpleLibraryProblem.WrongArchitecture, file, null,
                        file + " is no native library. Put the file of Crumple " + Wanted + " for " + here + " in its place.");
                if (image != here)
                    return Problem(CrumpleLibraryProblem.WrongArchitecture, file, null,
                        file + " is for " + image + ", but this process is " + here + ". Put the file of Crumple " + Wanted + " for "
                        + here + " in its place.");
                return Problem(CrumpleLibraryProblem.Missing, file, null,
                    file + " is there, but was not loaded" + reason + ": a library that it needs is missing, the "
                    + "loader does not look in that folder (" + SearchVariable + "), or it came there after this process had looked: then "
                    + "start the process anew. Wanted is Crumple " + Wanted + " for " + here + ".");
            }
            string name = FileNames()[0];
            return Problem(CrumpleLibraryProblem.Missing, name, null,
                name + " of Crumple " + Wanted + " for " + here + " was not found" + reason + ". Put it beside the program, or into a "
                + "folder that the system's loader searches (" + SearchVariable + "); in Unity into Plugins of the package.");
        }

        private static string SearchVariable
        {
            get { return Platform.Windows ? "PATH" : Platform.Mac ? "DYLD_LIBRARY_PATH" : "LD_LIBRARY_PATH"; }
        }

        private static string[] FileNames()
        {
            if (Platform.Windows) return new[] { "crumple.dll" };
            if (Platform.Mac) return new[] { "libcrumple.dylib", "crumple.bundle" };
            return new[] { "libcrumple.so" };
        }

        /// <summary>Files with the library's name where loaders look, in about their order.</summary>
        private static IEnumerable<string> Candidates()
        {
            List<string> folders = new List<string>();
            string assembly = typeof(LibraryCheck).Assembly.Location;
            if (!string.IsNullOrEmpty(assembly)) folders.Add(Path.GetDirectoryName(assembly));
            folders.Add(AppDomain.CurrentDomain.BaseDirectory);
            // A built game of Unity has its assemblies in Managed, and beside that Plugins.
            foreach (string plugins in new[] { "Plugins", "Plugins/x86_64", "Plugins/ARM64" })
                folders.Add(Path.Combine(Path.Combine(folders[0], ".."), plugins));
            string searched = Environment.GetEnvironmentVariable(SearchVariable);
            if (searched != null) folders.AddRange(searched.Split(Path.PathSeparator));
            folders.Add(Directory.GetCurrentDirectory());
            foreach (string folder in folders)
            {
                if (string.IsNullOrEmpty(folder)) continue;
                foreach (string name in FileNames())
                {
                    string file = Path.Combine(folder, name);
                    if (File.Exists(file)) yield return file;
                }
            }
        }

        /// <summary>The file that the library was loaded from, where the system tells.</summary>
        private static string LoadedFile()
        {
            try
            {
                if (Platform.Linux)
                {
                    foreach (string line in File.ReadAllLines("/proc/self/maps"))
                    {
                        int path = line.IndexOf('/');
                        if (path >= 0 && Path.GetFileName(line.Substring(path)).StartsWith("libcrumple.so", StringComparison.Ordinal))
                            return line.Substring(path);
                    }
                }
            }
            catch (IOException)
            {
                // The name alone must do then.
            }
            foreach (string file in Candidates()) return file;
            return null;
        }
    }
}
