// Meshes, native arrays and command buffers of Unity's API.
using System;
using System.Collections.Generic;
using System.Runtime.InteropServices;
using Unity.Collections;

namespace Unity.Collections
{
    public enum Allocator { Invalid, None, Temp, TempJob, Persistent }

    /// <summary>Memory outside the collected heap.</summary>
    public struct NativeArray<T> : IDisposable where T : struct
    {
        internal IntPtr Memory;
        internal bool Owned;
        internal static int Living;

        public int Length { get; private set; }
        public bool IsCreated { get { return Memory != IntPtr.Zero; } }

        public NativeArray(int length, Allocator allocator)
        {
            if (allocator <= Allocator.None) throw new ArgumentException("an allocator is needed");
            Length = length;
            Memory = Marshal.AllocHGlobal(Math.Max(1, length * Marshal.SizeOf(typeof(T))));
            Owned = true;
            Living++;
        }

        internal NativeArray(IntPtr memory, int length)
        {
            Length = length;
            Memory = memory;
            Owned = false;
        }

        public unsafe void CopyFrom(NativeArray<T> other)
        {
            if (other.Length != Length) throw new ArgumentException("lengths differ: " + other.Length + " and " + Length);
            long bytes = (long)Length * Marshal.SizeOf(typeof(T));
            Buffer.MemoryCopy((void*)other.Memory, (void*)Memory, bytes, bytes);
        }

        public void Dispose()
        {
            if (Memory == IntPtr.Zero) throw new ObjectDisposedException("the NativeArray was disposed of already");
            if (Owned) Marshal.FreeHGlobal(Memory);
            Memory = IntPtr.Zero;
            Living--;
        }
    }
}

namespace Unity.Collections.LowLevel.Unsafe
{
    public static class NativeArrayUnsafeUtility
    {
        public static unsafe void* GetUnsafePtr<T>(NativeArray<T> array) where T : struct { return (void*)array.Memory; }
    }
}

namespace UnityEngine.Rendering
{
    public enum VertexAttribute { Position, Normal, Tangent, Color, TexCoord0 }

    public enum VertexAttributeFormat { Float32, Float16, UNorm8, SNorm8, UNorm16, SNorm16, UInt8, SInt8, UInt16, SInt16, UInt32, SInt32 }

    public struct VertexAttributeDescriptor
    {
        public VertexAttribute attribute { get; set; }
        public VertexAttributeFormat format { get; set; }
        public int dimension { get; set; }
        public int stream { get; set; }

        public VertexAttributeDescriptor(VertexAttribute attribute, VertexAttributeFormat format = VertexAttributeFormat.Float32,
            int dimension = 3, int stream = 0)
        {
            this.attribute = attribute;
            this.format = format;
            this.dimension = dimension;
            this.stream = stream;
        }
    }

    public enum IndexFormat { UInt16, UInt32 }

    [Flags]
    public enum MeshUpdateFlags { Default = 0, DontValidateIndices = 1, DontResetBoneBounds = 2, DontNotifyMeshUsers = 4, DontRecalculateBounds = 8 }

    public struct SubMeshDescriptor
    {
        public int indexStart { get; set; }
        public int indexCount { get; set; }

        public SubMeshDescriptor(int indexStart, int indexCount)
        {
            this.indexStart = indexStart;
            this.indexCount = indexCount;
        }
    }

    public class CommandBuffer : IDisposable
    {
        internal IntPtr Callback;
        internal int EventId;

        public string name { get; set; }
        public void IssuePluginEvent(IntPtr callback, int eventID) { Callback = callback; EventId = eventID; }
        public void Dispose() { }
    }
}

namespace UnityEngine
{
    using Rendering;

    public sealed class GraphicsBuffer : IDisposable
    {
        [Flags]
        public enum Target { Vertex = 1, Index = 2, CopySource = 4, CopyDestination = 8, Structured = 16, Raw = 32 }

        internal IntPtr Native;

        public IntPtr GetNativeBufferPtr() { return Native; }
        public void Dispose() { Native = IntPtr.Zero; }
    }

    public static class Graphics
    {
        internal static Action<CommandBuffer> Execute;

        public static void ExecuteCommandBuffer(CommandBuffer buffer) { if (Execute != null) Execute(buffer); }
    }

    public sealed class Mesh : Object
    {
        private VertexAttributeDescriptor[] layout = new VertexAttributeDescriptor[0];
        private byte[][] streams = new byte[0][];
        private uint[] indices = new uint[0];
        private readonly List<GCHandle> pins = new List<GCHandle>();
        internal bool Readable = true;
        internal readonly List<KeyValuePair<int, int>> Uploads = new List<KeyValuePair<int, int>>(4096);

        /// <summary>What the GPU side gives for a vertex stream; null: no native buffer.</summary>
        internal static Func<Mesh, int, IntPtr> NativeBuffers;
        internal static Action<Mesh> Gone;

        internal override void Released() { if (Gone != null) Gone(this); }

        public Mesh() { name = ""; }

        public int vertexCount { get; private set; }
        public int subMeshCount { get; set; }
        public Bounds bounds { get; set; }
        public bool isReadable { get { return Readable; } }
        public GraphicsBuffer.Target vertexBufferTarget { get; set; }

        public void MarkDynamic() { }
        public void UploadMeshData(bool markNoLongerReadable) { if (markNoLongerReadable) Readable = false; }

        public void SetVertexBufferParams(int count, params VertexAttributeDescriptor[] attributes)
        {
            vertexCount = count;
            layout = attributes;
            int last = -1;
            foreach (VertexAttributeDescriptor attribute in attributes) last = Math.Max(last, attribute.stream);
            streams = new byte[last + 1][];
            for (int i = 0; i <= last; i++) streams[i] = new byte[count * GetVertexBufferStride(i)];
        }

        private static int Size(VertexAttributeFormat format)
        {
            switch (format)
            {
                case VertexAttributeFormat.Float32:
                case VertexAttributeFormat.UInt32:
                case VertexAttributeFormat.SInt32: return 4;
                case VertexAttributeFormat.UNorm8:
                case VertexAttributeFormat.SNorm8:
                case VertexAttributeFormat.UInt8:
                case VertexAttributeFormat.SInt8: return 1;
                default: return 2;
            }
        }

        private int Index(VertexAttribute which)
        {
            for (int i = 0; i < layout.Length; i++)
                if (layout[i].attribute == which) return i;
            return -1;
        }

        public bool HasVertexAttribute(VertexAttribute which) { return Index(which) >= 0; }
        public int GetVertexAttributeStream(VertexAttribute which) { return Index(which) < 0 ? -1 : layout[Index(which)].stream; }
        public VertexAttributeFormat GetVertexAttributeFormat(VertexAttribute which) { return layout[Index(which)].format; }
        public int GetVertexAttributeDimension(VertexAttribute which) { return Index(which) < 0 ? 0 : layout[Index(which)].dimension; }

        public int GetVertexAttributeOffset(VertexAttribute which)
        {
            int found = Index(which), offset = 0;
            if (found < 0) return -1;
            for (int i = 0; i < found; i++)
                if (layout[i].stream == layout[found].stream) offset += Size(layout[i].format) * layout[i].dimension;
            return offset;
        }

        public int GetVertexBufferStride(int stream)
        {
            int stride = 0;
            foreach (VertexAttributeDescriptor attribute in layout)
                if (attribute.stream == stream) stride += Size(attribute.format) * attribute.dimension;
            return stride;
        }

        public void SetVertexBufferData<T>(T[] data, int dataStart, int meshBufferStart, int count, int stream = 0,
            MeshUpdateFlags flags = MeshUpdateFlags.Default) where T : struct
        {
            GCHandle pin = GCHandle.Alloc(data, GCHandleType.Pinned);
            Write(pin.AddrOfPinnedObject(), Marshal.SizeOf(typeof(T)), dataStart, meshBufferStart, count, stream);
            pin.Free();
        }

        public void SetVertexBufferData<T>(NativeArray<T> data, int dataStart, int meshBufferStart, int count, int stream = 0,
            MeshUpdateFlags flags = MeshUpdateFlags.Default) where T : struct
        {
            if (dataStart + count > data.Length) throw new ArgumentOutOfRangeException("count");
            Write(data.Memory, 1, dataStart, meshBufferStart, count, stream);
            Uploads.Add(new KeyValuePair<int, int>(meshBufferStart, count));
        }

        private void Write(IntPtr from, int element, int dataStart, int meshBufferStart, int count, int stream)
        {
            Marshal.Copy(IntPtr.Add(from, dataStart * element), streams[stream], meshBufferStart * element, count * element);
        }

        public void SetIndexBufferParams(int count, IndexFormat format) { indices = new uint[count]; }

        public void SetIndexBufferData<T>(T[] data, int dataStart, int meshBufferStart, int count) where T : struct
        {
            Array.Copy((uint[])(object)data, dataStart, indices, meshBufferStart, count);
        }

        public void SetSubMesh(int index, SubMeshDescriptor desc)
        {
            if (index >= subMeshCount) throw new IndexOutOfRangeException("there are " + subMeshCount + " sub-meshes");
        }

        private float[] Floats(VertexAttribute which, int dimension)
        {
            if (!Readable) throw new InvalidOperationException("the mesh is not readable");
            int found = Index(which);
            if (found < 0) return new float[0];
            float[] values = new float[vertexCount * dimension];
            int stride = GetVertexBufferStride(layout[found].stream), offset = GetVertexAttributeOffset(which);
            for (int v = 0; v < vertexCount; v++)
                Buffer.BlockCopy(streams[layout[found].stream], v * stride + offset, values, v * dimension * 4, dimension * 4);
            return values;
        }

        private Vector3[] Vectors(VertexAttribute which)
        {
            float[] values = Floats(which, 3);
            Vector3[] vectors = new Vector3[values.Length / 3];
            for (int v = 0; v < vectors.Length; v++) vectors[v] = new Vector3(values[3 * v], values[3 * v + 1], values[3 * v + 2]);
            return vectors;
        }

        public Vector3[] vertices { get { return Vectors(VertexAttribute.Position); } }
        public Vector3[] normals { get { return Vectors(VertexAttribute.Normal); } }

        public Vector4[] tangents
        {
            get
            {
                float[] values = Floats(VertexAttribute.Tangent, 4);
                Vector4[] vectors = new Vector4[values.Length / 4];
                for (int v = 0; v < vectors.Length; v++)
                    vectors[v] = new Vector4(values[4 * v], values[4 * v + 1], values[4 * v + 2], values[4 * v + 3]);
                return vectors;
            }
        }

        public int[] triangles { get { return Array.ConvertAll(indices, index => (int)index); } }

        internal byte[] Stream(int stream) { return streams[stream]; }

        internal Mesh Copy()
        {
            Mesh copy = new Mesh { name = name + "(Clone)", vertexCount = vertexCount, layout = layout, bounds = bounds };
            copy.subMeshCount = subMeshCount;
            copy.Readable = Readable;
            copy.streams = Array.ConvertAll(streams, stream => (byte[])stream.Clone());
            copy.indices = (uint[])indices.Clone();
            return copy;
        }

        public GraphicsBuffer GetVertexBuffer(int stream)
        {
            return new GraphicsBuffer { Native = NativeBuffers == null ? IntPtr.Zero : NativeBuffers(this, stream) };
        }

        public static MeshDataArray AcquireReadOnlyMeshData(Mesh mesh)
        {
            if (!mesh.Readable) throw new InvalidOperationException("the mesh is not readable");
            return new MeshDataArray(mesh);
        }

        public struct MeshDataArray : IDisposable
        {
            private readonly Mesh mesh;

            internal MeshDataArray(Mesh mesh) { this.mesh = mesh; }
            public MeshData this[int index] { get { return new MeshData(mesh); } }

            public void Dispose()
            {
                foreach (GCHandle pin in mesh.pins) pin.Free();
                mesh.pins.Clear();
            }
        }

        public struct MeshData
        {
            private readonly Mesh mesh;

            internal MeshData(Mesh mesh) { this.mesh = mesh; }

            public NativeArray<T> GetVertexData<T>(int stream) where T : struct
            {
                GCHandle pin = GCHandle.Alloc(mesh.streams[stream], GCHandleType.Pinned);
                mesh.pins.Add(pin);
                return new NativeArray<T>(pin.AddrOfPinnedObject(), mesh.streams[stream].Length / Marshal.SizeOf(typeof(T)));
            }
        }
    }
}
