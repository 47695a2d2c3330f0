using System;
using System.Collections.Generic;
using Crumple.Native;

namespace Crumple
{
    /// <summary>
    /// The native library as a whole: whether it fits, its version, and the end of everything made by this application domain.
    /// </summary>
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
            LibraryCheck.Run();
            loaded = true;
        }

        /// <summary>The version of the native library, such as "0.2.0".</summary>
        public static string Version
        {
            get
            {
                EnsureLoaded();
                return Utf8.Text(NativeMethods.crumple_version_string());
            }
        }

        /// <summary>What this build of the native library can do.</summary>
        public static CrumpleFeatures Features
        {
            get
            {
                EnsureLoaded();
                return (CrumpleFeatures)NativeMethods.crumple_features();
            }
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
            return Shutdown(false);
        }

        private static int Shutdown(bool exiting)
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
                if (handle != null && !handle.ShutDown(exiting)) left++;
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
                    AppDomain.CurrentDomain.ProcessExit += (sender, arguments) => Shutdown(true);
                else
                    AppDomain.CurrentDomain.DomainUnload += (sender, arguments) => Shutdown(false);
            }
        }
    }
}
