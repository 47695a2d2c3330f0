using System;
using System.Runtime.InteropServices;
using System.Text;

namespace Crumple
{
    /// <summary>The C interface of the native plugin, as native~/crumple_unity.h describes it. Only there under Vulkan matters
    /// it.</summary>
    internal static unsafe class UnityPlugin
    {
        private const string Library = "crumple_unity";

        internal enum State
        {
            Ready = 0,
            NotLoaded = 1,
            NoLibrary = 2,
            OtherRenderer = 3,
            NoDevice = 4,
        }

        internal enum BufferState
        {
            New = 0,
            Recorded = 1,
            Failed = 2,
            Lost = 3,
        }

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
            internal uint StructSize, Lod;
            internal CrumpleInstance Instance;
            internal IntPtr NativeBuffer;
            internal uint VertexCount, Stride;
            internal Attribute Position, Normal, Tangent;
            internal uint Reserved;
        }

        /// <summary>CrumpleUnityBufferInfo.</summary>
        [StructLayout(LayoutKind.Sequential)]
        internal struct BufferInfo
        {
            internal uint StructSize;
            internal BufferState State;
            internal CrumpleResult Result;
            internal int Wanted;
            internal ulong Recordings;
            internal CrumpleAabb Bounds;
        }

        [DllImport(Library)] internal static extern uint crumple_unity_version();
        [DllImport(Library)] private static extern IntPtr crumple_unity_last_error();
        [DllImport(Library)] private static extern State crumple_unity_state(byte* text, uint capacity);
        [DllImport(Library)] internal static extern uint crumple_unity_device();
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
        [DllImport(Library)] internal static extern CrumpleResult crumple_unity_buffer_info(ulong buffer, ref BufferInfo info);
        [DllImport(Library)] private static extern CrumpleResult crumple_unity_buffer_error(ulong buffer, byte* text, uint capacity);

        private const int TextSize = 1024;

        /// <summary>Whether buffers can be written on the device; why not otherwise. A missing plugin is an answer, no
        /// exception.</summary>
        internal static bool IsReady(out string why)
        {
            try
            {
                uint version = crumple_unity_version();
                if (version / 1000 != Native.NativeMethods.Version / 1000)
                {
                    why = "the native plugin crumple_unity is of version " + version + ", the C# files of " + Native.NativeMethods.Version +
                        ": take both from one package";
                    return false;
                }
                byte* text = stackalloc byte[TextSize];
                text[0] = 0;
                State state = crumple_unity_state(text, TextSize);
                why = Text(text);
                return state == State.Ready;
            }
            catch (DllNotFoundException error)
            {
                why = "there is no native plugin crumple_unity beside the library crumple (" + error.Message + ")";
            }
            catch (EntryPointNotFoundException error)
            {
                why = "the native plugin crumple_unity is another version's (" + error.Message + "): take the package as a whole";
            }
            catch (BadImageFormatException error)
            {
                why = "the native plugin crumple_unity is made for another processor or system (" + error.Message + ")";
            }
            return false;
        }

        internal static string LastError()
        {
            return Text((byte*)crumple_unity_last_error());
        }

        internal static string BufferError(ulong buffer)
        {
            byte* text = stackalloc byte[TextSize];
            return crumple_unity_buffer_error(buffer, text, TextSize) == CrumpleResult.Ok ? Text(text) : LastError();
        }

        /// <summary>The oldest message about events that could do nothing; null: there is none.</summary>
        internal static string TakeMessage()
        {
            byte* text = stackalloc byte[TextSize];
            return crumple_unity_take_message(text, TextSize) == 0 ? null : Text(text);
        }

        private static string Text(byte* text)
        {
            int length = 0;
            while (text[length] != 0) length++;
            return Encoding.UTF8.GetString(text, length);
        }
    }
}
