using System;
using System.Collections.Generic;
using System.Runtime.InteropServices;
using Crumple.Native;

namespace Crumple
{
    /// <summary>The native library as a whole: whether it fits, and the end of everything made by this application domain.</summary>
    public static class CrumpleRuntime
    {
        private static readonly object Lock = new object();
        private static readonly List<WeakReference> Contexts = new List<WeakReference>();
        private static volatile bool loaded;
        private static bool hooked;

        /// <summary>
        /// Loads the native library and compares its version with that of these C# files. Everything in this namespace does it by
        /// itself; call it early to learn early. Any thread; after the first success it costs nothing.
        /// </summary>
        /// <exception cref="CrumpleLibraryException">The library is missing, or does not fit.</exception>
        public static void EnsureLoaded()
        {
            if (loaded) return;
            string wanted = "Crumple " + Text(NativeMethods.Version);
            uint found;
            try
            {
                found = NativeMethods.crumple_version();
            }
            catch (EntryPointNotFoundException error)
            {
                throw new CrumpleLibraryException("the native library " + NativeMethods.Library + " has no function crumple_version, so it " +
                    "is not " + wanted + ". Put that file in its place", error);
            }
            catch (Exception error) when (error is DllNotFoundException || error is BadImageFormatException)
            {
                throw new CrumpleLibraryException("the native library " + NativeMethods.Library + " was not loaded: it is missing, or is for " +
                    "another system or processor. Put " + wanted + " for " + RuntimeInformation.ProcessArchitecture +
                    " beside the program or where the system's loader searches, in Unity into Plugins of the package", error);
            }
            // A later library of the same minor version fits, from 1.0 on one of the same major version.
            uint kind = NativeMethods.VersionMajor == 0 ? 1000u : 1000000u;
            if (found / kind != NativeMethods.Version / kind || found < NativeMethods.Version)
                throw new CrumpleLibraryException("the native library " + NativeMethods.Library + " is Crumple " + Text(found) +
                    ", but these C# files are of " + wanted + ". Take both from one package, and restart the program");
            loaded = true;
        }

        internal static T Loaded<T>(Func<T> call)
        {
            EnsureLoaded();
            return call();
        }

        private static string Text(uint version)
        {
            return version / 1000000 + "." + version / 1000 % 1000 + "." + version % 1000;
        }

        /// <summary>
        /// Destroys every context that this application domain has made, and unpins their memory; what belongs to them throws
        /// <see cref="ObjectDisposedException"/> from then on, and new contexts may be made. For hosts that unload managed code
        /// while the native library stays, such as Unity's editor before it reloads scripts. Happens by itself when the domain
        /// unloads or the process exits. No call may be running in any of the contexts, and attached Vulkan devices must still be
        /// there. A context with Vulkan frames in flight cannot be destroyed: it is left behind, unused, until the process ends.
        /// </summary>
        /// <returns>How many contexts were left behind.</returns>
        public static int Shutdown()
        {
            WeakReference[] contexts;
            lock (Lock)
            {
                contexts = Contexts.ToArray();
                Contexts.Clear();
            }
            int left = 0;
            foreach (WeakReference context in contexts)
            {
                ContextHandle handle = context.Target as ContextHandle;
                if (handle != null && !handle.ShutDown()) left++;
            }
            return left;
        }

        internal static void Register(ContextHandle handle)
        {
            lock (Lock)
            {
                Contexts.RemoveAll(context => !context.IsAlive);
                // Also handles that only wait for their finalizer: it may come too late.
                Contexts.Add(new WeakReference(handle, true));
                if (hooked) return;
                hooked = true;
                if (AppDomain.CurrentDomain.IsDefaultAppDomain())
                    AppDomain.CurrentDomain.ProcessExit += (sender, arguments) => Shutdown();
                else
                    AppDomain.CurrentDomain.DomainUnload += (sender, arguments) => Shutdown();
            }
        }
    }
}
