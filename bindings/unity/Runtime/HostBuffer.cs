using System;
using System.Runtime.InteropServices;
using Crumple.Native;

namespace Crumple
{
    /// <summary>
    /// Arrays of yours, or memory, that <see cref="CrumpleContext.Deform"/> writes an instance's vertices to. The instance holds it,
    /// so it may be forgotten.
    /// </summary>
    public sealed class HostBuffer : IDisposable
    {
        private readonly Instance instance;
        private readonly CrumpleBuffer id;
        internal readonly Pins Memory;

        /// <summary>Whether it was disposed of, or its instance was.</summary>
        internal bool Ended;

        internal HostBuffer(Instance instance, CrumpleBuffer id, Pins memory)
        {
            this.instance = instance;
            this.id = id;
            Memory = memory;
        }

        /// <summary>Its id, for lists of buffers and for <see cref="NativeMethods"/>.</summary>
        public CrumpleBuffer Id
        {
            get
            {
                if (Ended) throw new ObjectDisposedException("HostBuffer");
                return id;
            }
        }

        /// <summary>
        /// Forgets the buffer; managed arrays are unpinned. The memory stays as it is, yours alone again. A second time, or after its
        /// instance or context, nothing happens.
        /// </summary>
        public void Dispose()
        {
            if (Ended) return;
            if (!instance.Context.IsDisposed)
            {
                using (Call call = instance.Context.Enter())
                    CrumpleException.Check(NativeMethods.crumple_buffer_unregister(call.Context, id));
            }
            instance.End(this);
        }

        /// <summary>
        /// Which vertices the last deform wrote, as increasing ranges, and the box, m, around all vertices as they are now: what to
        /// upload, and what to cull with. An empty destination only counts the ranges. Allocates nothing.
        /// </summary>
        /// <returns>Number of ranges.</returns>
        /// <exception cref="CrumpleException">Among others: there are more than the destination has room for.</exception>
        public unsafe int GetChanges(Span<CrumpleRange> destination, out CrumpleAabb bounds)
        {
            uint count;
            CrumpleAabb box;
            using (Call call = instance.Context.Enter())
            fixed (CrumpleRange* ranges = &MemoryMarshal.GetReference(destination))
                CrumpleException.Check(NativeMethods.crumple_buffer_get_changes(call.Context, Id, destination.IsEmpty ? null : ranges,
                    (uint)destination.Length, &count, &box));
            bounds = box;
            return (int)count;
        }
    }
}
