using System;
using System.Collections.Generic;
using UnityEngine;
using UnityEngine.Rendering;

namespace Crumple
{
    /// <summary>
    /// The one context that all <see cref="CrumpleMesh"/> of a project share, the example sets in it, and the event that has them
    /// deformed on the GPU. Main thread only.
    /// <para>
    /// Where the GPU deforms, Unity's render thread records from the context. So every call of yours into it, or into what was made
    /// in it, but those that submit hits or end contacts, stands between <see cref="Enter"/> and the end of that stay: the main
    /// thread waits for at most one recording, and the render thread never. Call nothing of Unity's meanwhile.
    /// </para>
    /// </summary>
    public static partial class CrumpleWorld
    {
        /// <summary>A set that is loaded, and which of its meshes a Mesh shows.</summary>
        internal sealed class Loaded
        {
            internal ExampleSet Set;
            internal int Lod;
        }

        /// <summary>A stay inside the context.</summary>
        public struct Stay : IDisposable
        {
            private readonly IntPtr held;

            internal Stay(IntPtr context)
            {
                held = context;
                if (held == IntPtr.Zero) return;
                CrumpleResult result = UnityPlugin.crumple_unity_lock(held);
                if (result != CrumpleResult.Ok) throw new CrumpleException(result, UnityPlugin.LastError());
            }

            /// <summary>Leaves.</summary>
            public void Dispose()
            {
                if (held != IntPtr.Zero) UnityPlugin.crumple_unity_unlock(held);
            }
        }

        /// <summary>The meshes that are dented at the moment.</summary>
        internal static readonly List<CrumpleMesh> Meshes = new List<CrumpleMesh>();

        private static readonly Dictionary<(CrumpleSet, Mesh), Loaded> Sets = new Dictionary<(CrumpleSet, Mesh), Loaded>();
        private static readonly HashSet<string> Said = new HashSet<string>();
        private static CrumpleContext context;
        private static IntPtr shared; // the context, once the native plugin knows it
        private static CommandBuffer commands;
        private static bool hooked;

        /// <summary>The context, made at its first use. Between frames it may be used as any other; see the type's
        /// remarks.</summary>
        public static CrumpleContext Context
        {
            get
            {
                if (context == null)
                {
                    // No log and no callbacks: they would be gone after a reload of scripts, and the native side lives on.
                    context = new CrumpleContext();
                    CrumpleContactOptionsDef contacts = CrumpleContactOptionsDef.Default;
                    contacts.Impulses = CrumpleImpulses.WholeAtEveryPoint;
                    context.SetContactOptions(contacts);
                    Hook();
                }
                return context;
            }
        }

        /// <summary>Enters the context: <c>using (CrumpleWorld.Enter()) …</c> Stays do not nest.</summary>
        /// <exception cref="CrumpleException">This thread is inside already.</exception>
        public static Stay Enter()
        {
            return new Stay(shared);
        }

        /// <summary>The device's number where the native plugin can write on one; 0 and why otherwise.</summary>
        internal static uint Device(out string why)
        {
            uint device = UnityPlugin.Device(out why);
            if (device != 0 && shared == IntPtr.Zero)
            {
                IntPtr pointer = Context.Pointer;
                CrumpleResult result = UnityPlugin.crumple_unity_add_context(pointer);
                if (result != CrumpleResult.Ok)
                {
                    why = UnityPlugin.LastError();
                    return 0;
                }
                shared = pointer;
            }
            return device;
        }

        /// <summary>The set of an asset as <paramref name="shown"/> shows it; null: as its own mesh. Loaded once for all that
        /// share both.</summary>
        internal static Loaded Load(CrumpleSet asset, Mesh shown)
        {
            Loaded loaded;
            if (Sets.TryGetValue((asset, shown), out loaded)) return loaded;
            CrumpleContext made = Context;
            loaded = new Loaded();
            MeshMatch match = ReferenceEquals(shown, null) ? null : new MeshMatch(shown);
            string name = asset.name;
            using (Enter())
            {
                loaded.Set = made.LoadBaked(asset.Bytes);
                try
                {
                    if (match != null) loaded.Lod = match.Find(loaded.Set, name);
                }
                catch
                {
                    loaded.Set.Dispose();
                    throw;
                }
            }
            Sets.Add((asset, shown), loaded);
            return loaded;
        }

        internal static Mesh OriginalOf(Mesh shown)
        {
            Mesh original;
            foreach (CrumpleMesh mesh in Meshes)
                if (mesh.Owns(shown, out original)) return original;
            return shown;
        }

        /// <summary>Writes a text to the console, the first time.</summary>
        internal static void SayOnce(bool warning, string text, UnityEngine.Object about)
        {
            if (!Said.Add(text)) return;
            if (warning) Debug.LogWarning("Crumple: " + text, about);
            else Debug.Log("Crumple: " + text, about);
        }

        /// <summary>
        /// Ends everything native: before the editor reloads scripts, when play mode begins anew, and when the application quits.
        /// Meshes keep their damage and open again when they are enabled. May be called at any time between frames, and twice.
        /// </summary>
        public static void Shutdown()
        {
            while (Meshes.Count > 0) Meshes[Meshes.Count - 1].Release();
            Sets.Clear();
            CrumpleContext old = context;
            context = null;
            if (old == null) return;
            if (shared != IntPtr.Zero)
            {
                // From here on it is the plugin's: it ends when the device is done with the frames that it recorded.
                UnityPlugin.crumple_unity_destroy_context(shared);
                shared = IntPtr.Zero;
            }
            try
            {
                old.Dispose();
            }
            catch (CrumpleException error)
            {
                if (error.Result != CrumpleResult.ErrorFramesInFlight) Debug.LogException(error);
            }
        }

        private static void Hook()
        {
            if (hooked) return;
            hooked = true;
            Application.onBeforeRender += BeforeRender;
            Application.quitting += Shutdown;
        }

        // With domain reload switched off, statics live on from one play mode to the next.
        [RuntimeInitializeOnLoadMethod(RuntimeInitializeLoadType.SubsystemRegistration)]
        private static void BeginPlay()
        {
            Shutdown();
        }

        // After every LateUpdate, before the first camera. Where no buffer is wanted and no frame to be heard of, nothing is
        // issued: the event interrupts the render pass that runs.
        private static void BeforeRender()
        {
            if (shared == IntPtr.Zero || UnityPlugin.crumple_unity_pending() == 0) return;
            if (commands == null)
            {
                int id;
                IntPtr callback = UnityPlugin.crumple_unity_event(out id);
                if (callback == IntPtr.Zero) return;
                commands = new CommandBuffer();
                commands.name = "Crumple";
                commands.IssuePluginEvent(callback, id);
            }
            Graphics.ExecuteCommandBuffer(commands);
            string message = UnityPlugin.TakeMessage();
            if (message != null) SayOnce(true, message, null);
        }
    }
}
