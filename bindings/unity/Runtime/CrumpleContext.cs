using System;
using Crumple.Native;

namespace Crumple
{
    /// <summary>
    /// Everything that Crumple knows: example sets, instances and buffers are made in a context and end with it.
    /// <para>
    /// Threads: only one thread may be inside a context at once, whichever object of it is called; a second one gets a
    /// <see cref="CrumpleException"/> with <see cref="CrumpleResult.ErrorConcurrentUse"/>. Excepted are
    /// <see cref="Instance.Submit(in CrumpleHitDef)"/>,
    /// <see cref="Instance.SubmitDisplacement(CrumpleVec3, CrumpleVec3)"/> and <see cref="Instance.EndContact"/>: any thread, at
    /// any time.
    /// </para>
    /// <para>
    /// Every method throws <see cref="CrumpleException"/> where the C function does not return CRUMPLE_OK, and
    /// <see cref="ObjectDisposedException"/> after <see cref="Dispose"/>. Units are metres, seconds, kilograms.
    /// </para>
    /// </summary>
    public sealed partial class CrumpleContext : IDisposable
    {
        internal readonly ContextHandle Handle;
        private readonly CallbackSink sink;

        /// <summary>A context with threads of its own, one for each core, and no log.</summary>
        /// <exception cref="CrumpleLibraryException">The native library is missing or does not fit.</exception>
        public CrumpleContext()
            : this(new ContextOptions())
        {
        }

        /// <summary>A context.</summary>
        /// <exception cref="CrumpleLibraryException">The native library is missing or does not fit.</exception>
        public CrumpleContext(ContextOptions options)
        {
            if (options == null) throw new ArgumentNullException("options");
            CrumpleContextDef def = CrumpleContextDef.Default;
            def.Threads = MeshDef.Count(options.Threads, "Threads");
            MeshDef.Count(options.TaskWorkers, "TaskWorkers");
            if (options.Log != null || options.Tasks != null) sink = new CallbackSink(options);
            Handle = new ContextHandle(ref def, sink);
        }

        /// <summary>What a handler of the options threw last; null where none did. The call that it came from went on.</summary>
        public Exception LastCallbackException
        {
            get { return sink == null ? null : sink.Failure; }
        }

        /// <summary>Whether the context has ended.</summary>
        public bool IsDisposed
        {
            get { return Handle.IsClosed; }
        }

        /// <summary>
        /// The CrumpleContext*, for <see cref="NativeMethods"/> and for plugins of your own. It stays valid until this is
        /// disposed of.
        /// </summary>
        public IntPtr Pointer
        {
            get
            {
                if (Handle.IsClosed) throw new ObjectDisposedException("CrumpleContext");
                return Handle.DangerousGetHandle();
            }
        }

        /// <summary>
        /// Destroys the context and everything made in it, in whatever order the others are disposed of, and unpins arrays. A
        /// second time nothing happens.
        /// </summary>
        /// <exception cref="CrumpleException">
        /// Vulkan frames are in flight (<see cref="CompleteFrames"/>), or another thread is inside. Nothing was destroyed then.
        /// </exception>
        public void Dispose()
        {
            if (Handle.IsClosed) return;
            using (Call call = Enter(this)) call.Check(Handle.Destroy(), "crumple_context_destroy");
            Handle.Dispose();
        }

        /// <summary>
        /// Brings all host buffers up to date, once a frame. Writes only where damage changed. Do not read or write their memory
        /// meanwhile. Allocates nothing.
        /// </summary>
        public unsafe CrumpleDeformReport Deform()
        {
            CrumpleDeformReport report;
            using (Call call = EnterAlone(this))
                call.Check(NativeMethods.crumple_context_deform(call.Context, null, 0, &report), "crumple_context_deform");
            return report;
        }

        /// <summary>
        /// Brings some host buffers up to date, each named once; none for an empty list. Allocates nothing.
        /// </summary>
        public unsafe CrumpleDeformReport Deform(ReadOnlySpan<CrumpleBuffer> buffers)
        {
            CrumpleDeformReport report = default(CrumpleDeformReport);
            // For C no ids are all buffers.
            if (buffers.IsEmpty) return report;
            using (Call call = EnterAlone(this))
            fixed (CrumpleBuffer* ids = &System.Runtime.InteropServices.MemoryMarshal.GetReference(buffers))
                call.Check(NativeMethods.crumple_context_deform(call.Context, ids, (uint)buffers.Length, &report), "crumple_context_deform");
            return report;
        }

        /// <summary>A body in the scene, undamaged, with default rules.</summary>
        public Instance CreateInstance(ExampleSet set)
        {
            CrumpleInstanceDef def = CrumpleInstanceDef.Default;
            return CreateInstance(set, in def);
        }

        /// <summary>A body in the scene, undamaged. The def's Set is not looked at.</summary>
        public unsafe Instance CreateInstance(ExampleSet set, in CrumpleInstanceDef def)
        {
            if (set == null) throw new ArgumentNullException("set");
            CrumpleInstanceDef copy = def;
            copy.Set = set.Id;
            CrumpleInstance id;
            using (Call call = EnterAlone(set))
                call.Check(NativeMethods.crumple_instance_create(call.Context, &copy, &id), "crumple_instance_create");
            return new Instance(this, set, id);
        }

        /// <summary>For calls that any thread may make at any time.</summary>
        internal Call Enter(object owner)
        {
            return new Call(Handle, owner);
        }

        /// <summary>For calls that need the context for themselves.</summary>
        internal Call EnterAlone(object owner)
        {
            Call call = new Call(Handle, owner);
            Handle.Sweep();
            return call;
        }
    }
}
