using System;
using Unity.Collections;
using Unity.Collections.LowLevel.Unsafe;
using UnityEngine;
using UnityEngine.Rendering;

namespace Crumple
{
    /// <summary>Writes an instance's vertices into its Mesh by the CPU: only what changed is uploaded. Frames allocate
    /// nothing.</summary>
    internal sealed class CpuTarget : IDisposable
    {
        private const MeshUpdateFlags Quiet =
            MeshUpdateFlags.DontRecalculateBounds | MeshUpdateFlags.DontValidateIndices | MeshUpdateFlags.DontNotifyMeshUsers;

        private readonly Mesh mesh;
        private readonly MeshLayout layout;
        private readonly CrumpleContext context;
        private readonly HostBuffer buffer;
        private readonly CrumpleBuffer[] ids;
        private NativeArray<byte> vertices;
        private CrumpleRange[] ranges = new CrumpleRange[64];

        internal unsafe CpuTarget(Mesh mesh, Instance instance, int lod)
        {
            this.mesh = mesh;
            context = instance.Context;
            layout = MeshLayout.Of(mesh);
            layout.CheckForCpu(mesh);
            mesh.MarkDynamic();
            long size = (long)layout.VertexCount * layout.Stride;
            vertices = new NativeArray<byte>((int)size, Allocator.Persistent);
            try
            {
                // What lies between positions, normals and tangents is uploaded with them.
                using (Mesh.MeshDataArray data = Mesh.AcquireReadOnlyMeshData(mesh))
                    vertices.CopyFrom(data[0].GetVertexData<byte>(layout.Stream));
                IntPtr memory = (IntPtr)NativeArrayUnsafeUtility.GetUnsafePtr(vertices);
                using (CrumpleWorld.Enter())
                    buffer = instance.RegisterHostBuffer(Stream(memory, size, layout.Position), Stream(memory, size, layout.Normal),
                        Stream(memory, size, layout.Tangent), lod);
            }
            catch
            {
                vertices.Dispose();
                throw;
            }
            ids = new[] { buffer.Id };
        }

        private StridedArray Stream(IntPtr memory, long size, UnityPlugin.Attribute attribute)
        {
            return attribute.Dimension == 0 ? default(StridedArray) : StridedArray.At(memory, size, attribute.Offset, layout.Stride);
        }

        /// <summary>Brings the Mesh up to date.</summary>
        internal void Update()
        {
            int count;
            CrumpleAabb bounds;
            using (CrumpleWorld.Enter())
            {
                context.Deform(ids);
                count = buffer.GetChanges(default(Span<CrumpleRange>), out bounds);
                if (count > ranges.Length) ranges = new CrumpleRange[Math.Max(count, 2 * ranges.Length)];
                if (count > 0) buffer.GetChanges(ranges, out bounds);
            }
            for (int i = 0; i < count; i++)
            {
                int first = (int)ranges[i].First * layout.Stride;
                mesh.SetVertexBufferData(vertices, first, first, (int)ranges[i].Count * layout.Stride, layout.Stream, Quiet);
            }
            if (count > 0) mesh.bounds = MeshLayout.ToBounds(bounds);
        }

        public void Dispose()
        {
            if (!vertices.IsCreated) return;
            using (CrumpleWorld.Enter()) buffer.Dispose();
            vertices.Dispose();
        }
    }

    /// <summary>Has the native plugin write an instance's vertices into the Mesh's own Vulkan buffer.</summary>
    internal sealed class GpuTarget : IDisposable
    {
        private readonly Mesh mesh;
        private GraphicsBuffer graphics;
        private ulong buffer;
        private ulong seen; // recordings

        /// <summary>The device that it was made for.</summary>
        internal readonly uint Device;

        /// <summary>Null, or why the plugin cannot write this mesh.</summary>
        internal string Failure { get; private set; }

        internal GpuTarget(Mesh mesh, Instance instance, int lod, uint device)
        {
            this.mesh = mesh;
            Device = device;
            MeshLayout layout = MeshLayout.Of(mesh);
            mesh.vertexBufferTarget |= GraphicsBuffer.Target.Raw;
            graphics = mesh.GetVertexBuffer(layout.Stream);
            UnityPlugin.BufferDef def = default(UnityPlugin.BufferDef);
            def.Lod = (uint)lod;
            def.Instance = instance.Id;
            def.NativeBuffer = graphics.GetNativeBufferPtr(); // waits for the render thread
            def.VertexCount = (uint)layout.VertexCount;
            def.Stride = (uint)layout.Stride;
            def.Position = layout.Position;
            def.Normal = layout.Normal;
            def.Tangent = layout.Tangent;
            if (UnityPlugin.crumple_unity_register_buffer(instance.Context.Pointer, ref def, out buffer) == CrumpleResult.Ok) return;
            Failure = UnityPlugin.LastError();
            graphics.Dispose();
            graphics = null;
        }

        /// <summary>Its device is gone; another one may come.</summary>
        internal bool Lost { get; private set; }

        /// <summary>The next event brings the Mesh up to date. Where that cannot be, <see cref="Look"/> learns why.</summary>
        internal void Want()
        {
            UnityPlugin.crumple_unity_want(buffer);
        }

        /// <summary>Learns what became of it: new bounds, or a failure.</summary>
        internal void Look()
        {
            UnityPlugin.BufferInfo info;
            CrumpleResult result = UnityPlugin.crumple_unity_buffer_info(buffer, out info);
            Lost = result == CrumpleResult.ErrorDeviceLost;
            if (result != CrumpleResult.Ok && !Lost) Failure = UnityPlugin.LastError();
            if (result != CrumpleResult.Ok || info.Recordings == seen) return;
            seen = info.Recordings;
            mesh.bounds = MeshLayout.ToBounds(info.Bounds);
        }

        /// <summary>Unregisters first, so that no event meets a buffer that is gone.</summary>
        public void Dispose()
        {
            if (graphics == null) return;
            UnityPlugin.crumple_unity_unregister_buffer(buffer);
            graphics.Dispose();
            graphics = null;
        }
    }
}
