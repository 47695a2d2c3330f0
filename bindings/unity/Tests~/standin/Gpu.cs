// The renderer beneath the stand-ins: native~/tests/mono_host.cpp, over a real Vulkan device.
using System;
using System.Collections.Generic;
using System.Runtime.InteropServices;
using UnityEngine;

namespace StandIn
{
    public static class Gpu
    {
        private const string Library = "unity_mono_host";

        [DllImport(Library)] private static extern void unity_host_open(string plugin);
        [DllImport(Library)] private static extern void unity_host_close();
        [DllImport(Library)] private static extern IntPtr unity_host_make_buffer(byte[] bytes, uint size, int raw);
        [DllImport(Library)] private static extern void unity_host_destroy_buffer(IntPtr native);
        [DllImport(Library)] private static extern void unity_host_frame(IntPtr callback, int eventId);
        [DllImport(Library)] private static extern void unity_host_read(IntPtr native, byte[] into);
        [DllImport(Library)] private static extern void unity_host_end_device();
        [DllImport(Library)] private static extern void unity_host_begin_device();
        [DllImport(Library)] private static extern uint unity_host_pending();

        private static readonly Dictionary<Mesh, IntPtr> Buffers = new Dictionary<Mesh, IntPtr>();

        /// <summary>Vertex buffers on the device.</summary>
        internal static int Living { get { return Buffers.Count; } }

        /// <summary>Meshes get buffers that shaders may not write, as if Unity did not heed vertexBufferTarget.</summary>
        public static bool WithoutRaw;

        /// <summary>Opens the device, and the plugin as Unity would.</summary>
        public static void Open(string plugin)
        {
            unity_host_open(plugin);
            Mesh.NativeBuffers = (mesh, stream) =>
            {
                IntPtr native;
                if (Buffers.TryGetValue(mesh, out native)) return native;
                bool raw = (mesh.vertexBufferTarget & GraphicsBuffer.Target.Raw) != 0 && !WithoutRaw;
                byte[] bytes = mesh.Stream(stream);
                native = unity_host_make_buffer(bytes, (uint)bytes.Length, raw ? 1 : 0);
                Buffers.Add(mesh, native);
                return native;
            };
            Mesh.Gone = mesh =>
            {
                IntPtr native;
                if (!Buffers.TryGetValue(mesh, out native)) return;
                unity_host_destroy_buffer(native);
                Buffers.Remove(mesh);
            };
            Graphics.Execute = commands => unity_host_frame(commands.Callback, commands.EventId);
        }

        public static void Close() { unity_host_close(); }

        /// <summary>A frame without an event.</summary>
        public static void Frame() { unity_host_frame(IntPtr.Zero, 0); }

        public static uint Pending { get { return unity_host_pending(); } }

        /// <summary>The bytes of a mesh's vertex buffer on the device.</summary>
        public static byte[] Read(Mesh mesh)
        {
            byte[] bytes = new byte[mesh.Stream(0).Length];
            unity_host_read(Buffers[mesh], bytes);
            return bytes;
        }

        public static void EndDevice()
        {
            unity_host_end_device();
            Buffers.Clear();
        }

        public static void BeginDevice() { unity_host_begin_device(); }
    }
}
