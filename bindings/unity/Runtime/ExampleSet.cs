using System;
using Crumple.Native;

namespace Crumple
{
    /// <summary>
    /// A base mesh and its examples: immutable, shared by any number of instances, which keep what they need of it after its end.
    /// One that is not disposed of ends with its context.
    /// </summary>
    public sealed class ExampleSet : IDisposable
    {
        private readonly CrumpleExampleSet id;
        private bool disposed;

        /// <summary>The context that it was made in.</summary>
        public CrumpleContext Context { get; }

        internal ExampleSet(CrumpleContext context, CrumpleExampleSet id)
        {
            Context = context;
            this.id = id;
        }

        /// <summary>Its id, for <see cref="NativeMethods"/>.</summary>
        public CrumpleExampleSet Id
        {
            get
            {
                if (disposed) throw new ObjectDisposedException("ExampleSet");
                return id;
            }
        }

        /// <summary>Ends it, now. A second time, or after its context, nothing happens.</summary>
        public void Dispose()
        {
            if (disposed) return;
            if (!Context.IsDisposed)
            {
                using (Call call = Context.Enter())
                    CrumpleException.Check(NativeMethods.crumple_example_set_destroy(call.Context, id));
            }
            disposed = true;
        }

        /// <summary>What it holds. The pointer Name ends with the set.</summary>
        public unsafe CrumpleExampleSetInfo GetInfo()
        {
            CrumpleExampleSetInfo info;
            using (Call call = Context.Enter())
                CrumpleException.Check(NativeMethods.crumple_example_set_get_info(call.Context, Id, &info));
            return info;
        }

        /// <summary>
        /// Adds another mesh of the same body that shows the same damage, before the first instance is made. The arrays are
        /// copied.
        /// </summary>
        /// <returns>Its number, 1 for the first, for <see cref="Instance.RegisterHostBuffer"/>.</returns>
        public unsafe int AddLod(MeshDef def)
        {
            uint lod;
            using (Call call = Context.Enter())
            using (Pins pins = new Pins())
            {
                CrumpleMeshDef native = def.ToNative(pins);
                CrumpleException.Check(NativeMethods.crumple_example_set_add_lod(call.Context, Id, &native, &lod));
            }
            return (int)lod;
        }

        /// <summary>
        /// Copies the base mesh, or a level of detail: the vertex and index buffers to draw with, before the first dent.
        /// Positions and normals are 3 floats a vertex, tangents 4, indices 32 bits each; absent ones are left out.
        /// </summary>
        public unsafe void CopyMesh(StridedArray positions, StridedArray normals = default(StridedArray),
            StridedArray tangents = default(StridedArray), StridedArray indices = default(StridedArray), int lod = 0)
        {
            using (Call call = Context.Enter())
            using (Pins pins = new Pins())
            {
                CrumpleMeshCopyDef def = CrumpleMeshCopyDef.Default;
                def.Lod = (uint)lod;
                def.Positions = pins.Stream(positions);
                def.Normals = pins.Stream(normals);
                def.Tangents = pins.Stream(tangents);
                def.Indices = pins.Stream(indices);
                CrumpleException.Check(NativeMethods.crumple_example_set_copy_mesh(call.Context, Id, &def));
            }
        }

        /// <summary>
        /// Binds a point, m, in the mesh's space, to the surface nearest to it. It fits every instance of the set: see
        /// <see cref="Instance.GetAttachedPose"/>.
        /// </summary>
        public unsafe CrumpleAttachment AttachPoint(CrumpleVec3 point)
        {
            CrumpleAttachment attachment;
            using (Call call = Context.Enter())
                CrumpleException.Check(NativeMethods.crumple_example_set_attach_point(call.Context, Id, point, &attachment));
            return attachment;
        }

        /// <summary>The bytes of a .crumple file, for <see cref="CrumpleContext.LoadBaked"/>.</summary>
        public unsafe byte[] Save()
        {
            using (Call call = Context.Enter())
            {
                UIntPtr size;
                CrumpleException.Check(NativeMethods.crumple_example_set_save_baked(call.Context, Id, IntPtr.Zero, UIntPtr.Zero, &size));
                byte[] bytes = new byte[(int)size];
                fixed (byte* data = bytes)
                    CrumpleException.Check(NativeMethods.crumple_example_set_save_baked(call.Context, Id, (IntPtr)data, size, &size));
                return bytes;
            }
        }
    }
}
