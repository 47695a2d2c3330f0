using System;
using System.Runtime.InteropServices;
using Crumple.Native;

namespace Crumple
{
    /// <summary>What an example set holds.</summary>
    public sealed class ExampleSetInfo
    {
        /// <summary>Name of the mesh in its file; empty for a set made from arrays.</summary>
        public string Name { get; }

        /// <summary>All numbers. Its Name is null here: see <see cref="Name"/>.</summary>
        public CrumpleExampleSetInfo Values { get; }

        internal ExampleSetInfo(CrumpleExampleSetInfo values)
        {
            Name = Utf8.Text(values.Name);
            values.Name = IntPtr.Zero;
            Values = values;
        }

        /// <summary>Tells whether two sets are the same, on any machine; saved damage fits sets of one fingerprint.</summary>
        public ulong Fingerprint
        {
            get { return Values.Fingerprint; }
        }

        /// <summary>Vertices of the base mesh.</summary>
        public int VertexCount
        {
            get { return (int)Values.VertexCount; }
        }

        /// <summary>Triangles of the base mesh.</summary>
        public int TriangleCount
        {
            get { return (int)Values.TriangleCount; }
        }

        /// <summary>Number of examples.</summary>
        public int ExampleCount
        {
            get { return (int)Values.ExampleCount; }
        }

        /// <summary>Parts of the mesh with a material of their own; at least 1.</summary>
        public int PrimitiveCount
        {
            get { return (int)Values.PrimitiveCount; }
        }

        /// <summary>Box around the base mesh, m.</summary>
        public CrumpleAabb Bounds
        {
            get { return Values.Bounds; }
        }

        /// <summary>World matrix of the first node that shows the mesh: 16 floats, column-major; a copy.</summary>
        public unsafe float[] NodeTransform
        {
            get
            {
                float[] matrix = new float[16];
                CrumpleExampleSetInfo copy = Values;
                for (int i = 0; i < 16; i++) matrix[i] = copy.NodeTransform[i];
                return matrix;
            }
        }
    }

    /// <summary>What an example is.</summary>
    public sealed class ExampleInfo
    {
        /// <summary>Its name.</summary>
        public string Name { get; }

        /// <summary>All numbers. Its Name is null here: see <see cref="Name"/>.</summary>
        public CrumpleExampleInfo Values { get; }

        internal ExampleInfo(CrumpleExampleInfo values)
        {
            Name = Utf8.Text(values.Name);
            values.Name = IntPtr.Zero;
            Values = values;
        }
    }

    /// <summary>A part of the mesh with a material of its own.</summary>
    public sealed class PrimitiveInfo
    {
        /// <summary>Name of its material; null where it has none.</summary>
        public string Material { get; }

        /// <summary>All numbers. Its Material is null here: see <see cref="Material"/>.</summary>
        public CrumplePrimitive Values { get; }

        internal PrimitiveInfo(CrumplePrimitive values)
        {
            Material = Utf8.Text(values.Material);
            values.Material = IntPtr.Zero;
            Values = values;
        }
    }

    /// <summary>
    /// A base mesh and its examples: immutable, shared by any number of instances, which keep what they need of it after its end.
    /// One that is forgotten is destroyed by a later call into its context.
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

        /// <summary>Leaves it to a later call.</summary>
        ~ExampleSet()
        {
            if (Context != null && !disposed) Context.Handle.Leave(id);
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
                using (Call call = Context.EnterAlone(this))
                    call.Check(NativeMethods.crumple_example_set_destroy(call.Context, id), "crumple_example_set_destroy");
            }
            disposed = true;
            GC.SuppressFinalize(this);
        }

        /// <summary>Gives it to another context too, without a copy. Each context's ends on its own.</summary>
        public unsafe ExampleSet ShareWith(CrumpleContext other)
        {
            if (other == null) throw new ArgumentNullException("other");
            CrumpleExampleSet shared;
            using (Call call = Context.EnterAlone(this))
            using (Call there = other.EnterAlone(other))
                call.Check(NativeMethods.crumple_example_set_share(call.Context, Id, there.Context, &shared), "crumple_example_set_share");
            return new ExampleSet(other, shared);
        }

        /// <summary>What it holds.</summary>
        public unsafe ExampleSetInfo GetInfo()
        {
            CrumpleExampleSetInfo info;
            using (Call call = Context.EnterAlone(this))
            {
                call.Check(NativeMethods.crumple_example_set_get_info(call.Context, Id, &info), "crumple_example_set_get_info");
                return new ExampleSetInfo(info);
            }
        }

        /// <summary>What an example is; example is below ExampleCount.</summary>
        public unsafe ExampleInfo GetExample(int example)
        {
            CrumpleExampleInfo info;
            using (Call call = Context.EnterAlone(this))
            {
                call.Check(NativeMethods.crumple_example_set_get_example(call.Context, Id, MeshDef.Count(example, "example"), &info),
                    "crumple_example_set_get_example");
                return new ExampleInfo(info);
            }
        }

        /// <summary>Which vertices and triangles a part of the mesh has; primitive is below PrimitiveCount.</summary>
        public unsafe PrimitiveInfo GetPrimitive(int primitive)
        {
            CrumplePrimitive info;
            using (Call call = Context.EnterAlone(this))
            {
                call.Check(NativeMethods.crumple_example_set_get_primitive(call.Context, Id, MeshDef.Count(primitive, "primitive"), &info),
                    "crumple_example_set_get_primitive");
                return new PrimitiveInfo(info);
            }
        }

        /// <summary>
        /// Adds another mesh of the same body that shows the same damage, before the first instance is made. The arrays are
        /// copied.
        /// </summary>
        /// <returns>Its number, 1 for the first, for <see cref="Instance.RegisterHostBuffer"/>.</returns>
        public unsafe int AddLod(LodDef def)
        {
            if (def == null) throw new ArgumentNullException("def");
            using (Pins pins = new Pins())
            {
                CrumpleMeshDef native = CrumpleMeshDef.Default;
                native.VertexCount = MeshDef.Count(def.VertexCount, "VertexCount");
                native.Positions = pins.Input(def.Positions);
                native.Normals = pins.Input(def.Normals);
                native.Tangents = pins.Input(def.Tangents);
                native.Indices = pins.Input(def.Indices);
                native.IndexCount = MeshDef.Count(def.IndexCount, "IndexCount");
                native.IndexType = def.IndexType;
                uint lod;
                using (Call call = Context.EnterAlone(this))
                    call.Check(NativeMethods.crumple_example_set_add_lod(call.Context, Id, &native, &lod),
                        "crumple_example_set_add_lod");
                return (int)lod;
            }
        }

        /// <summary>
        /// The number of a part by the name of its node, for sets whose glTF nodes were joined: 1 and up.
        /// </summary>
        /// <exception cref="CrumpleException">Among others: no such part.</exception>
        public unsafe int FindPart(string name)
        {
            if (name == null) throw new ArgumentNullException("name");
            uint lod;
            using (Pins pins = new Pins())
            {
                IntPtr text = pins.Text(name);
                using (Call call = Context.EnterAlone(this))
                    call.Check(NativeMethods.crumple_example_set_find_part(call.Context, Id, text, &lod), "crumple_example_set_find_part");
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
            using (Pins pins = new Pins())
            {
                CrumpleMeshCopyDef def = CrumpleMeshCopyDef.Default;
                def.Lod = MeshDef.Count(lod, "lod");
                def.Positions = pins.Stream(positions);
                def.Normals = pins.Stream(normals);
                def.Tangents = pins.Stream(tangents);
                def.Indices = pins.Stream(indices);
                using (Call call = Context.EnterAlone(this))
                    call.Check(NativeMethods.crumple_example_set_copy_mesh(call.Context, Id, &def), "crumple_example_set_copy_mesh");
            }
        }

        /// <summary>The vertex of the base mesh nearest to a point, m, in the mesh's space, and its distance, m.</summary>
        public unsafe int NearestVertex(CrumpleVec3 point, out float distance)
        {
            uint vertex;
            float found;
            using (Call call = Context.EnterAlone(this))
                call.Check(NativeMethods.crumple_example_set_find_nearest_vertex(call.Context, Id, point, &vertex, &found),
                    "crumple_example_set_find_nearest_vertex");
            distance = found;
            return (int)vertex;
        }

        /// <summary>
        /// Binds a point, m, in the mesh's space, to the surface nearest to it. It fits every instance of the set: see
        /// <see cref="Instance.GetAttachedPose"/>.
        /// </summary>
        public unsafe CrumpleAttachment AttachPoint(CrumpleVec3 point)
        {
            CrumpleAttachment attachment;
            using (Call call = Context.EnterAlone(this))
                call.Check(NativeMethods.crumple_example_set_attach_point(call.Context, Id, point, &attachment), "crumple_example_set_attach_point");
            return attachment;
        }

        /// <summary>The bytes of a .crumple file, for <see cref="CrumpleContext.LoadBaked(ReadOnlySpan{byte})"/>.</summary>
        public unsafe byte[] Save()
        {
            UIntPtr size;
            using (Call call = Context.EnterAlone(this))
            {
                call.Check(NativeMethods.crumple_example_set_save_baked(call.Context, Id, IntPtr.Zero, UIntPtr.Zero, &size),
                    "crumple_example_set_save_baked");
                byte[] bytes = new byte[(int)size];
                fixed (byte* data = bytes)
                    call.Check(NativeMethods.crumple_example_set_save_baked(call.Context, Id, (IntPtr)data, size, &size),
                        "crumple_example_set_save_baked");
                return bytes;
            }
        }
    }
}
