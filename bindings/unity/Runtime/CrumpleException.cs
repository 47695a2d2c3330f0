using System;
using Crumple.Native;

namespace Crumple
{
    /// <summary>
    /// A call into Crumple failed. Nothing has changed then, and everything stays usable. The message names the C function, what was
    /// wrong and what would be right, in the library's words.
    /// </summary>
    public class CrumpleException : Exception
    {
        /// <summary>What kind of failure it is.</summary>
        public CrumpleResult Result { get; }

        /// <summary>A failure with its message.</summary>
        public CrumpleException(CrumpleResult result, string message, Exception inner = null)
            : base(message, inner)
        {
            Result = result;
        }

        /// <summary>
        /// Throws what went wrong if the result of a call of this thread is not Ok, for calls of <see cref="NativeMethods"/>.
        /// </summary>
        public static void Check(CrumpleResult result)
        {
            if (result == CrumpleResult.Ok) return;
            throw new CrumpleException(result, Utf8.Text(NativeMethods.crumple_last_error()) + " (" + result + ")");
        }
    }

    /// <summary>
    /// The native library is missing, or is not of the version of these C# files. Thrown before the first call into it, and at each
    /// further attempt. Runtimes remember what they did not find, so start the process anew when the right file is there.
    /// </summary>
    public sealed class CrumpleLibraryException : CrumpleException
    {
        internal CrumpleLibraryException(string message, Exception inner = null)
            : base(CrumpleResult.ErrorUnsupported, message, inner)
        {
        }
    }
}
