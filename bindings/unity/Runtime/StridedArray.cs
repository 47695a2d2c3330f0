using System;
using System.Collections.Generic;
using System.Runtime.CompilerServices;
using System.Runtime.InteropServices;

namespace Crumple
{
    /// <summary>
    /// Where an array of vertices or indices lies: in a managed array, or at an address of yours. Element i begins at
    /// offset + i * stride, in bytes; several may share one array, such as interleaved positions and normals. The default
    /// value is an absent array.
    /// </summary>
    public readonly struct StridedArray
    {
        internal readonly Array Array;
        internal readonly IntPtr Address;
        internal readonly long Size, Offset, Stride;

        private StridedArray(Array array, IntPtr address, long size, long offset, long stride)
        {
            if (offset < 0 || offset > size)
                throw new ArgumentOutOfRangeException("offset", offset, "the array has " + size + " bytes");
            Array = array;
            Address = address;
            Size = size;
            Offset = offset;
            Stride = stride;
        }

        /// <summary>Whether nothing was given.</summary>
        internal bool IsAbsent
        {
            get { return Array == null && Address == IntPtr.Zero; }
        }

        /// <summary>One element of the array a vertex or index: vectors, indices.</summary>
        public static StridedArray Of<T>(T[] array) where T : struct
        {
            return Of(array, 0, ElementSize<T>());
        }

        /// <summary>
        /// Values inside an array, say of floats or of your vertex struct: the first lies offset bytes from its begin, each next
        /// one stride bytes further.
        /// </summary>
        /// <exception cref="ArgumentException">The elements hold references, or are bool or char.</exception>
        public static StridedArray Of<T>(T[] array, int offset, int stride) where T : struct
        {
            return new StridedArray(array, IntPtr.Zero, (long)array.Length * ElementSize<T>(), offset, stride);
        }

        /// <summary>
        /// Memory of your own with so many bytes, such as a NativeArray's or a mapped buffer's, which must stay where it is as
        /// long as it is used: during a call that reads it, or until the buffer made of it is disposed.
        /// </summary>
        public static StridedArray At(IntPtr address, long size, long offset, long stride)
        {
            if (address == IntPtr.Zero) throw new ArgumentNullException("address");
            return new StridedArray(null, address, size, offset, stride);
        }

        private static int ElementSize<T>() where T : struct
        {
            if (RuntimeHelpers.IsReferenceOrContainsReferences<T>() || typeof(T) == typeof(bool) || typeof(T) == typeof(char))
                throw new ArgumentException("elements must be plain numbers or structs of them, not " + typeof(T));
            return Marshal.SizeOf(typeof(T));
        }
    }

    /// <summary>Holds managed memory where it is, and gives its addresses to C.</summary>
    internal sealed class Pins : IDisposable
    {
        private readonly List<GCHandle> handles = new List<GCHandle>();

        internal CrumpleInput Input(StridedArray array)
        {
            CrumpleInput input = default(CrumpleInput);
            if (array.IsAbsent) return input;
            input.Data = new IntPtr(Begin(array).ToInt64() + array.Offset);
            input.Size = (UIntPtr)(ulong)(array.Size - array.Offset);
            input.Stride = (UIntPtr)(ulong)array.Stride;
            return input;
        }

        internal CrumpleStream Stream(StridedArray array)
        {
            CrumpleStream stream = default(CrumpleStream);
            if (array.IsAbsent) return stream;
            stream.Data = Begin(array);
            stream.Size = (UIntPtr)(ulong)array.Size;
            stream.Offset = (UIntPtr)(ulong)array.Offset;
            stream.Stride = (UIntPtr)(ulong)array.Stride;
            return stream;
        }

        /// <summary>UTF-8 with a zero at its end; null for null.</summary>
        internal IntPtr Text(string text)
        {
            return text == null ? IntPtr.Zero : Pin(Utf8.Bytes(text));
        }

        internal IntPtr Pin(Array array)
        {
            GCHandle handle = GCHandle.Alloc(array, GCHandleType.Pinned);
            handles.Add(handle);
            // Of an array without elements there is no address to give.
            return array.Length == 0 ? IntPtr.Zero : handle.AddrOfPinnedObject();
        }

        private IntPtr Begin(StridedArray array)
        {
            return array.Array == null ? array.Address : Pin(array.Array);
        }

        /// <summary>Lets go. Never throws; may be called again.</summary>
        public void Dispose()
        {
            foreach (GCHandle handle in handles) handle.Free();
            handles.Clear();
        }
    }
}
