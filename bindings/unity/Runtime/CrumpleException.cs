using System;
using Crumple.Native;

namespace Crumple
{
    /// <summary>
    /// A call into Crumple failed. Nothing has changed then, and everything stays usable.
    /// </summary>
    public class CrumpleException : Exception
    {
        /// <summary>What kind of failure it is.</summary>
        public CrumpleResult Result { get; }

        /// <summary>The C function that failed, as crumple.h names it.</summary>
        public string Call { get; }

        /// <summary>What was wrong and what would be right, in the library's words.</summary>
        public string NativeMessage { get; }

        /// <summary>A failure of <paramref name="call"/>.</summary>
        public CrumpleException(CrumpleResult result, string call, string nativeMessage)
            : this(result, call, nativeMessage, nativeMessage + " (" + result + ")")
        {
        }

        internal CrumpleException(CrumpleResult result, string call, string nativeMessage, string message)
            : base(message)
        {
            Result = result;
            Call = call;
            NativeMessage = nativeMessage;
        }

        /// <summary>The calling thread's last failure.</summary>
        internal static CrumpleException Last(CrumpleResult result, string call)
        {
            return new CrumpleException(result, call, Utf8.Text(NativeMethods.crumple_last_error()));
        }
    }

    /// <summary>What is wrong with the native library.</summary>
    public enum CrumpleLibraryProblem
    {
        /// <summary>The system's loader finds no such file, or lacks a library that it needs.</summary>
        Missing,
        /// <summary>There is a file, made for another processor or system.</summary>
        WrongArchitecture,
        /// <summary>It is a library of another version than these C# files.</summary>
        WrongVersion,
        /// <summary>It lacks a function that these C# files call.</summary>
        MissingFunction,
    }

    /// <summary>
    /// The native library cannot be used. Thrown before the first call into it, and at each further attempt; runtimes remember
    /// what they did not find, so start the process anew when the right file is there.
    /// </summary>
    public sealed class CrumpleLibraryException : CrumpleException
    {
        /// <summary>What is wrong.</summary>
        public CrumpleLibraryProblem Problem { get; }

        /// <summary>The file that was found, or the name that was looked for.</summary>
        public string FileName { get; }

        /// <summary>Version of the library that was found, such as "0.2.0"; null where none told its version.</summary>
        public string FoundVersion { get; }

        /// <summary>Version that these C# files were made for.</summary>
        public string WantedVersion { get; }

        internal CrumpleLibraryException(CrumpleLibraryProblem problem, string fileName, string foundVersion, string wantedVersion,
            string message)
            : base(CrumpleResult.ErrorUnsupported, "crumple_version", message, message)
        {
            Problem = problem;
            FileName = fileName;
            FoundVersion = foundVersion;
            WantedVersion = wantedVersion;
        }
    }
}
