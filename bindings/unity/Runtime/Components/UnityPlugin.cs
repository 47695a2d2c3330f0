using System;
using System.Runtime.InteropServices;

namespace Crumple
{
    /// <summary>The C interface of the native plugin, as native~/crumple_unity.h describes it. Only there under Vulkan matters
    /// it.</summary>
    internal static unsafe class UnityPlugin
    {
        private const string Library = "crumple_unity";

        /// <summary>CrumpleUnityAttribute.</summary>
        [StructLayout(LayoutKind.Sequential)]
        internal struct Attribute
        {
            internal int Format, Dimension, Offset;
        }

        /// <summary>CrumpleUnityBufferDef.</summary>
        [StructLayout(LayoutKind.Sequential)]
        internal struct BufferDef
        {
            internal CrumpleInstance Instance;
            internal IntPtr NativeBuffer;
            internal uint Lod, VertexCount, Stride;
            internal Attribute Position, Normal, Tangent;
        }

        /// <summary>CrumpleUnityBufferInfo.</summary>
        [StructLayout(LayoutKind.Sequential)]
        internal struct BufferInfo
        {
            internal ulong Recordings;
            internal CrumpleAabb Bounds;
        }

        [DllImport(Library)] private static extern uint crumple_unity_version();
        [DllImport(Library)] private static extern IntPtr crumple_unity_last_error();
        [DllImport(Library)] internal static extern uint crumple_unity_device(byte* why, uint capacity);
        [DllImport(Library)] internal static extern IntPtr crumple_unity_event(out int id);
        [DllImport(Library)] internal static extern uint crumple_unity_pending();
        [DllImport(Library)] private static extern uint crumple_unity_take_message(byte* text, uint capacity);
        [DllImport(Library)] internal static extern CrumpleResult crumple_unity_add_context(IntPtr context);
        [DllImport(Library)] internal static extern CrumpleResult crumple_unity_destroy_context(IntPtr context);
        [DllImport(Library)] internal static extern CrumpleResult crumple_unity_lock(IntPtr context);
        [DllImport(Library)] internal static extern CrumpleResult crumple_unity_unlock(IntPtr context);
        [DllImport(Library)] internal static extern CrumpleResult crumple_unity_register_buffer(IntPtr context, ref BufferDef def, out ulong buffer);
        [DllImport(Library)] internal static extern CrumpleResult crumple_unity_unregister_buffer(ulong buffer);
        [DllImport(Library)] internal static extern CrumpleResult crumple_unity_want(ulong buffer);
        [DllImport(Library)] internal static extern CrumpleResult crumple_unity_buffer_info(ulong buffer, out BufferInfo info);

        private const int TextSize = 1024;

        /// <summary>The number of the device that buffers can be written on; 0 and why not otherwise. A missing plugin is an answer, no
        /// exception.</summary>
        internal static uint Device(out string why)
        {
            try
            {
                uint version = crumple_unity_version();
                if (version / 1000 != Native.NativeMethods.Version / 1000)
                {
                    why = "the native plugin crumple_unity is of version " + version + ", the C# files of " + Native.NativeMethods.Version +
                        ": take both from one package";
                    return 0;
                }
                byte* text = stackalloc byte[TextSize];
                text[0] = 0;
                uint device = crumple_unity_device(text, TextSize);
                why = Utf8.Text((IntPtr)text);
                return device;
            }
            catch (Exception error) when (error is DllNotFoundException || error is EntryPointNotFoundException || error is BadImageFormatException)
            {
                why = "there is no native plugin crumple_unity of this package beside the library crumple (" + error.Message + ")";
            }
            return 0;
        }

        internal static string LastError()
        {
            return Utf8.Text(crumple_unity_last_error());
        }

        /// <summary>The message of the last event that could do nothing; null: there is none.</summary>
        internal static string TakeMessage()
        {
            byte* text = stackalloc byte[TextSize];
            return crumple_unity_take_message(text, TextSize) == 0 ? null : Utf8.Text((IntPtr)text);
        }
    }
}
