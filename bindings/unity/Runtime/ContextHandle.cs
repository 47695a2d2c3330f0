using System;
using System.Collections.Generic;
using System.Runtime.InteropServices;
using Crumple.Native;

namespace Crumple
{
    /// <summary>
    /// A native context, and all managed memory that it can reach: pinned arrays and callbacks. That memory is let go when the
    /// context is gone and no thread is inside it any more, never earlier.
    /// </summary>
    internal sealed class ContextHandle : SafeHandle
    {
        private readonly object sync = new object();
        private readonly HashSet<Pins> pins = new HashSet<Pins>();
        private readonly List<CrumpleInstance> instances = new List<CrumpleInstance>();
        private readonly List<Pins> instancePins = new List<Pins>();
        private readonly List<CrumpleExampleSet> sets = new List<CrumpleExampleSet>();
        private GCHandle callbacks;
        private volatile bool left;
        private bool destroyed;

        /// <summary>
        /// A Vulkan device of the host's is attached. It may be gone when nobody asks for the end of the context.
        /// </summary>
        internal volatile bool HasHostDevice;

        internal unsafe ContextHandle(ref CrumpleContextDef def, CallbackSink sink)
            : base(IntPtr.Zero, true)
        {
            if (sink != null)
            {
                callbacks = GCHandle.Alloc(sink);
                sink.Fill(ref def, GCHandle.ToIntPtr(callbacks));
            }
            IntPtr context = IntPtr.Zero;
            CrumpleResult result;
            fixed (CrumpleContextDef* pointer = &def) result = NativeMethods.crumple_context_create(pointer, &context);
            if (result != CrumpleResult.Ok)
            {
                CrumpleException error = CrumpleException.Last(result, "crumple_context_create");
                if (callbacks.IsAllocated) callbacks.Free();
                SetHandleAsInvalid();
                throw error;
            }
            SetHandle(context);
            CrumpleRuntime.Register(this);
        }

        public override bool IsInvalid
        {
            get { return handle == IntPtr.Zero; }
        }

        /// <summary>Destroys the native context, or tells why that cannot be; nothing changes then.</summary>
        internal CrumpleResult Destroy()
        {
            if (destroyed) return CrumpleResult.Ok;
            CrumpleResult result = NativeMethods.crumple_context_destroy(handle);
            destroyed = result == CrumpleResult.Ok || result == CrumpleResult.ErrorInvalidId;
            return destroyed ? CrumpleResult.Ok : result;
        }

        /// <summary>The end of the domain or process. Whether the native context is gone.</summary>
        internal bool ShutDown(bool exiting)
        {
            bool held = false;
            try
            {
                DangerousAddRef(ref held);
            }
            catch (ObjectDisposedException)
            {
                return true; // ended already
            }
            try
            {
                // When a process exits its device may be gone, and its memory goes anyway.
                if (!(exiting && HasHostDevice)) Destroy();
                return destroyed;
            }
            finally
            {
                DangerousRelease();
                Dispose();
            }
        }

        /// <summary>
        /// Runs when no call is inside any more; on the finalizer's thread where nobody disposed of the context.
        /// </summary>
        protected override bool ReleaseHandle()
        {
            if (!destroyed && !HasHostDevice) Destroy();
            if (!destroyed) return false; // it may still reach what is pinned: leave everything
            lock (sync)
            {
                foreach (Pins each in pins) each.Dispose();
                pins.Clear();
            }
            if (callbacks.IsAllocated) callbacks.Free();
            return true;
        }

        /// <summary>Keeps memory pinned until <see cref="Unpin"/>, or the end of the context.</summary>
        internal void Keep(Pins kept)
        {
            lock (sync) pins.Add(kept);
        }

        internal void Unpin(Pins kept)
        {
            lock (sync)
            {
                pins.Remove(kept);
                kept.Dispose();
            }
        }

        /// <summary>
        /// An instance that nobody holds any more. Finalizers run at any time, when the context may be in use, so what they leave
        /// is destroyed by a later call.
        /// </summary>
        internal void Leave(CrumpleInstance instance, List<Pins> memory)
        {
            lock (sync)
            {
                instances.Add(instance);
                instancePins.AddRange(memory);
                left = true;
            }
        }

        internal void Leave(CrumpleExampleSet set)
        {
            lock (sync)
            {
                sets.Add(set);
                left = true;
            }
        }

        /// <summary>Destroys what was left behind. The caller is the only one inside the context.</summary>
        internal void Sweep()
        {
            if (!left) return;
            lock (sync)
            {
                if (Swept())
                {
                    instances.Clear();
                    sets.Clear();
                    foreach (Pins memory in instancePins)
                    {
                        pins.Remove(memory);
                        memory.Dispose();
                    }
                    instancePins.Clear();
                    left = false;
                }
            }
        }

        private bool Swept()
        {
            // Ids that are gone already are no harm. Where another thread is inside, all is tried again later.
            foreach (CrumpleInstance instance in instances)
                if (NativeMethods.crumple_instance_destroy(handle, instance) == CrumpleResult.ErrorConcurrentUse) return false;
            foreach (CrumpleExampleSet set in sets)
                if (NativeMethods.crumple_example_set_destroy(handle, set) == CrumpleResult.ErrorConcurrentUse) return false;
            return true;
        }
    }

    /// <summary>A call into a context: keeps the context, and the object that the call is about, until it is over.</summary>
    internal readonly struct Call : IDisposable
    {
        internal readonly IntPtr Context;
        private readonly ContextHandle handle;
        private readonly object owner;

        internal Call(ContextHandle handle, object owner)
        {
            bool held = false;
            // Asked first, since the text of the handle's own exception names no object.
            if (handle.IsClosed) throw new ObjectDisposedException("CrumpleContext");
            handle.DangerousAddRef(ref held);
            this.handle = handle;
            this.owner = owner;
            Context = handle.DangerousGetHandle();
        }

        internal void Check(CrumpleResult result, string call)
        {
            if (result != CrumpleResult.Ok) throw CrumpleException.Last(result, call);
        }

        public void Dispose()
        {
            handle.DangerousRelease();
            GC.KeepAlive(owner);
        }
    }
}
