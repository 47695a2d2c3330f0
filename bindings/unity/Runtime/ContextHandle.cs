using System;
using System.Collections.Generic;
using System.Runtime.InteropServices;
using Crumple.Native;

namespace Crumple
{
    /// <summary>
    /// A native context, and all managed memory that it can reach: pinned arrays and the log. That memory is let go when the
    /// context is gone and no thread is inside it any more, never earlier.
    /// </summary>
    internal sealed class ContextHandle : SafeHandle
    {
        private readonly object sync = new object();
        private readonly HashSet<Pins> pins = new HashSet<Pins>();
        private GCHandle log;
        private bool destroyed;

        internal unsafe ContextHandle(ref CrumpleContextDef def, LogSink sink)
            : base(IntPtr.Zero, true)
        {
            if (sink != null)
            {
                log = GCHandle.Alloc(sink);
                sink.Fill(ref def, GCHandle.ToIntPtr(log));
            }
            IntPtr context = IntPtr.Zero;
            CrumpleResult result;
            fixed (CrumpleContextDef* pointer = &def) result = NativeMethods.crumple_context_create(pointer, &context);
            if (result != CrumpleResult.Ok)
            {
                if (log.IsAllocated) log.Free();
                SetHandleAsInvalid();
                CrumpleException.Check(result);
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
        internal bool ShutDown()
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
                return Destroy() == CrumpleResult.Ok;
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
            if (Destroy() != CrumpleResult.Ok) return false; // it may still reach what is pinned: leave everything
            lock (sync)
            {
                foreach (Pins each in pins) each.Dispose();
                pins.Clear();
            }
            if (log.IsAllocated) log.Free();
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
    }

    /// <summary>A call into a context: keeps it until the call is over.</summary>
    internal readonly struct Call : IDisposable
    {
        internal readonly IntPtr Context;
        private readonly ContextHandle handle;

        internal Call(ContextHandle handle)
        {
            bool held = false;
            // Asked first, since the text of the handle's own exception names no object.
            if (handle.IsClosed) throw new ObjectDisposedException("CrumpleContext");
            handle.DangerousAddRef(ref held);
            this.handle = handle;
            Context = handle.DangerousGetHandle();
        }

        public void Dispose()
        {
            handle.DangerousRelease();
        }
    }
}
