using System;
using System.Linq;
using System.Runtime.InteropServices;
using Crumple.Native;

namespace Crumple
{
    /// <summary>
    /// Everything that Crumple knows: example sets, instances and buffers are made in a context and end with it.
    /// <para>
    /// Threads: only one thread may be inside a context at once, whichever object of it is called; a second one gets a
    /// <see cref="CrumpleException"/> with <see cref="CrumpleResult.ErrorConcurrentUse"/>. Excepted are hits, transforms and contact
    /// points: any thread, at any time.
    /// </para>
    /// <para>
    /// Every method throws <see cref="CrumpleException"/> where the C function does not return CRUMPLE_OK, and
    /// <see cref="ObjectDisposedException"/> after <see cref="Dispose"/>. Units are metres, seconds, kilograms.
    /// </para>
    /// </summary>
    public sealed partial class CrumpleContext : IDisposable
    {
        internal readonly ContextHandle Handle;
        private readonly LogSink sink;

        /// <summary>A context.</summary>
        /// <param name="threads">Threads that deform: 0 one for each core, 1 only the calling thread, up to 1024.</param>
        /// <param name="log">Receives messages; null: nobody does.</param>
        /// <exception cref="CrumpleLibraryException">The native library is missing or does not fit.</exception>
        public CrumpleContext(int threads = 0, CrumpleLogHandler log = null)
        {
            CrumpleContextDef def = CrumpleContextDef.Default;
            def.Threads = (uint)threads;
            if (log != null) sink = new LogSink(log);
            Handle = new ContextHandle(ref def, sink);
        }

        /// <summary>What the log handler threw last; null where it did not. The call that it came from went on.</summary>
        public Exception LastLogException
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
        /// Vulkan frames are in flight, or another thread is inside. Nothing was destroyed then.
        /// </exception>
        public void Dispose()
        {
            if (Handle.IsClosed) return;
            using (Enter()) CrumpleException.Check(Handle.Destroy());
            Handle.Dispose();
        }

        /// <summary>
        /// Brings host buffers up to date, once a frame: these, each named once, or all where none is named. Writes only where damage
        /// changed. Do not read or write their memory meanwhile. Allocates nothing.
        /// </summary>
        public unsafe CrumpleDeformReport Deform(ReadOnlySpan<CrumpleBuffer> buffers = default(ReadOnlySpan<CrumpleBuffer>))
        {
            CrumpleDeformReport report;
            using (Call call = Enter())
            fixed (CrumpleBuffer* ids = &MemoryMarshal.GetReference(buffers))
                CrumpleException.Check(NativeMethods.crumple_context_deform(call.Context, ids, (uint)buffers.Length, &report));
            return report;
        }

        /// <summary>
        /// Makes an example set from arrays, which are copied. Takes a moment: load before the scene starts, on a context of its
        /// own thread if need be.
        /// </summary>
        public unsafe ExampleSet CreateExampleSet(ExampleSetDef def)
        {
            using (Call call = Enter())
            using (Pins pins = new Pins())
            {
                CrumpleMeshDef mesh = def.ToNative(pins);
                CrumpleExampleSetDef native = CrumpleExampleSetDef.Default;
                native.Mesh = (IntPtr)(&mesh);
                native.Options = def.Options;
                native.Examples = pins.Pin(def.Examples.Select(example => example.ToNative(pins)).ToArray());
                native.ExampleCount = (uint)def.Examples.Count;
                CrumpleExampleSet id;
                CrumpleException.Check(NativeMethods.crumple_example_set_create(call.Context, &native, &id));
                return new ExampleSet(this, id);
            }
        }

        /// <summary>Makes an example set from a mesh of a glTF 2.0 or GLB file and its morph targets.</summary>
        /// <param name="path">The file.</param>
        /// <param name="meshName">Name of the mesh; null: the first that has morph targets.</param>
        /// <param name="options">How the set is made ready; null: the defaults.</param>
        public unsafe ExampleSet LoadGltf(string path, string meshName = null, CrumpleExampleSetOptions? options = null)
        {
            using (Call call = Enter())
            using (Pins pins = new Pins())
            {
                CrumpleGltfDef def = CrumpleGltfDef.Default;
                def.Path = pins.Text(path);
                def.MeshName = pins.Text(meshName);
                if (options.HasValue) def.Options = options.Value;
                CrumpleExampleSet id;
                CrumpleException.Check(NativeMethods.crumple_example_set_load_gltf(call.Context, &def, &id));
                return new ExampleSet(this, id);
            }
        }

        /// <summary>
        /// Makes an example set from the bytes of a .crumple file, which are copied: at once, since nothing is built or unpacked.
        /// </summary>
        public unsafe ExampleSet LoadBaked(ReadOnlySpan<byte> bytes)
        {
            CrumpleExampleSet id;
            using (Call call = Enter())
            fixed (byte* data = &MemoryMarshal.GetReference(bytes))
                CrumpleException.Check(NativeMethods.crumple_example_set_load_baked_memory(call.Context, (IntPtr)data,
                    (UIntPtr)(uint)bytes.Length, CrumpleBytes.Copy, &id));
            return new ExampleSet(this, id);
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
            CrumpleInstanceDef copy = def;
            copy.Set = set.Id;
            CrumpleInstance id;
            using (Call call = Enter())
                CrumpleException.Check(NativeMethods.crumple_instance_create(call.Context, &copy, &id));
            return new Instance(this, id);
        }

        /// <summary>Begins a call.</summary>
        internal Call Enter()
        {
            return new Call(Handle);
        }
    }
}
