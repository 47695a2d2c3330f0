using System;
using System.Runtime.InteropServices;
using Crumple.Native;

namespace Crumple
{
    /// <summary>
    /// Memory that an instance's deformed vertices are written to. The instance holds it, so it may be forgotten.
    /// </summary>
    public abstract class DeformBuffer : IDisposable
    {
        private readonly CrumpleBuffer id;
        private bool disposed;

        /// <summary>The instance whose vertices it holds.</summary>
        public Instance Instance { get; }

        internal DeformBuffer(Instance instance, CrumpleBuffer id)
        {
            Instance = instance;
            this.id = id;
        }

        /// <summary>Its id, for lists of buffers and for <see cref="NativeMethods"/>.</summary>
        public CrumpleBuffer Id
        {
            get
            {
                if (IsDisposed) throw new ObjectDisposedException(GetType().Name);
                return id;
            }
        }

        /// <summary>Whether it was disposed of, or its instance or context was.</summary>
        public virtual bool IsDisposed
        {
            get { return disposed; }
        }

        /// <summary>
        /// Forgets the buffer; managed arrays are unpinned. The memory stays as it is, yours alone again; a VkBuffer once the
        /// frames that wrote it are done. A second time, or after its instance or context, nothing happens.
        /// </summary>
        public void Dispose()
        {
            if (IsDisposed) return;
            if (!Instance.Context.IsDisposed)
            {
                using (Call call = Instance.Context.EnterAlone(this))
                    call.Check(NativeMethods.crumple_buffer_unregister(call.Context, id), "crumple_buffer_unregister");
            }
            Ended();
            Instance.Forget(this, Memory);
        }

        internal virtual Pins Memory
        {
            get { return null; }
        }

        internal void Ended()
        {
            disposed = true;
        }

        /// <summary>
        /// Somebody else wrote to its memory, or its contents were lost: the next deform or recording writes every vertex.
        /// </summary>
        public void Invalidate()
        {
            using (Call call = Instance.Context.EnterAlone(this))
                call.Check(NativeMethods.crumple_buffer_invalidate(call.Context, Id), "crumple_buffer_invalidate");
        }

        /// <summary>
        /// Number of ranges that <see cref="GetChanges"/> writes, and the box, m, around all vertices as they are now.
        /// </summary>
        public unsafe int CountChanges(out CrumpleAabb bounds)
        {
            uint count;
            CrumpleAabb box;
            using (Call call = Instance.Context.EnterAlone(this))
                call.Check(NativeMethods.crumple_buffer_get_changes(call.Context, Id, null, 0, &count, &box),
                    "crumple_buffer_get_changes");
            bounds = box;
            return (int)count;
        }

        /// <summary>
        /// Which vertices the last deform or recording wrote, as increasing ranges, and the box, m, around all vertices as they
        /// are now: what to upload, and what to cull with. Allocates nothing.
        /// </summary>
        /// <returns>Number of ranges.</returns>
        /// <exception cref="CrumpleException">Among others: there are more than the destination has room for.</exception>
        public unsafe int GetChanges(Span<CrumpleRange> destination, out CrumpleAabb bounds)
        {
            CrumpleRange none;
            uint count;
            CrumpleAabb box;
            using (Call call = Instance.Context.EnterAlone(this))
            fixed (CrumpleRange* ranges = &MemoryMarshal.GetReference(destination))
            {
                // No room is not the same as asking for the number.
                CrumpleRange* room = ranges == null ? &none : ranges;
                call.Check(NativeMethods.crumple_buffer_get_changes(call.Context, Id, room, (uint)destination.Length, &count, &box),
                    "crumple_buffer_get_changes");
            }
            bounds = box;
            return (int)count;
        }

        /// <summary>
        /// The triangles with a vertex that the last deform wrote, as increasing ranges, and the box, m, around these vertices
        /// before and now: what the partial refit of a collider takes. Allocates nothing.
        /// </summary>
        /// <returns>Number of ranges.</returns>
        /// <exception cref="CrumpleException">Among others: there are more than the destination has room for.</exception>
        public unsafe int GetChangedTriangles(Span<CrumpleRange> destination, out CrumpleAabb bounds)
        {
            CrumpleRange none;
            uint count;
            CrumpleAabb box;
            using (Call call = Instance.Context.EnterAlone(this))
            fixed (CrumpleRange* ranges = &MemoryMarshal.GetReference(destination))
            {
                CrumpleRange* room = ranges == null ? &none : ranges;
                call.Check(
                    NativeMethods.crumple_buffer_get_changed_triangles(
                        call.Context, Id, room, (uint)destination.Length, &count, &box),
                    "crumple_buffer_get_changed_triangles");
            }
            bounds = box;
            return (int)count;
        }
    }

    /// <summary>Arrays of yours, or memory, that <see cref="CrumpleContext.Deform()"/> writes.</summary>
    public sealed class HostBuffer : DeformBuffer
    {
        private Pins memory;

        internal HostBuffer(Instance instance, CrumpleBuffer id, Pins memory)
            : base(instance, id)
        {
            this.memory = memory;
        }

        internal override Pins Memory
        {
            get { return memory; }
        }

        /// <summary>
        /// Gives it other memory, perhaps for another level of detail; arrays that it had are unpinned. Every vertex is written
        /// by the next deform. After an exception it has what it had.
        /// </summary>
        public unsafe void SetMemory(StridedArray positions, StridedArray normals = default(StridedArray),
            StridedArray tangents = default(StridedArray), int lod = 0)
        {
            Pins fresh = new Pins();
            bool kept = false;
            try
            {
                CrumpleHostBufferDef def = Def(fresh, positions, normals, tangents, lod);
                using (Call call = Instance.Context.EnterAlone(this))
                    call.Check(NativeMethods.crumple_buffer_set_memory(call.Context, Id, &def),
                        "crumple_buffer_set_memory");
                kept = true;
                Instance.Exchange(memory, fresh);
                memory = fresh;
            }
            finally
            {
                if (!kept) fresh.Dispose();
            }
        }

        internal static CrumpleHostBufferDef Def(Pins pins, StridedArray positions, StridedArray normals, StridedArray tangents, int lod)
        {
            CrumpleHostBufferDef def = CrumpleHostBufferDef.Default;
            def.Lod = MeshDef.Count(lod, "lod");
            def.Positions = pins.Stream(positions);
            def.Normals = pins.Stream(normals);
            def.Tangents = pins.Stream(tangents);
            return def;
        }
    }

    /// <summary>A range of a VkBuffer that Crumple's commands write.</summary>
    public sealed class VulkanBuffer : DeformBuffer
    {
        private readonly int device;

        internal VulkanBuffer(Instance instance, CrumpleBuffer id)
            : base(instance, id)
        {
            device = instance.Context.DeviceNumber;
        }

        /// <summary>Whether it was disposed of, or its instance, context or device was.</summary>
        public override bool IsDisposed
        {
            get { return base.IsDisposed || device != Instance.Context.DeviceNumber; }
        }
    }
}
