using System;
using System.Linq;
using System.Runtime.InteropServices;
using System.Threading;
using Crumple;
using Crumple.Native;

/// <summary>Frames on a real Vulkan device, which a host in C owns. In a process of its own, since devices go with it.</summary>
static unsafe class VulkanTests
{
    const int Stride = 24, Size = Sheet.Vertices * Stride;
    const uint Rgb32 = 106, StorageBuffer = 0x20, HostStage = 0x4000, HostRead = 0x2000; // of vulkan_core.h

    static IntPtr shared;

    static CrumpleVulkanAttachDef Device()
    {
        CrumpleVulkanAttachDef def = CrumpleVulkanAttachDef.Default;
        def.GetInstanceProcAddr = shared_loader();
        def.Instance = shared_instance(shared);
        def.PhysicalDevice = shared_physical_device(shared);
        def.Device = shared_device(shared);
        def.QueueFamily = shared_family(shared);
        return def;
    }

    static CrumpleVulkanBufferDef Range()
    {
        CrumpleVulkanBufferDef def = CrumpleVulkanBufferDef.Default;
        def.Buffer = shared_buffer(shared);
        def.BufferSize = def.Size = Size;
        def.Usage = StorageBuffer;
        def.BeforeStages = def.AfterStages = HostStage;
        def.BeforeAccess = def.AfterAccess = HostRead;
        def.Positions = new CrumpleVulkanStream { Format = Rgb32, Stride = Stride };
        def.Normals = new CrumpleVulkanStream { Format = Rgb32, Stride = Stride, Offset = 12 };
        return def;
    }

    static CrumpleContext Attached()
    {
        CrumpleContext context = Sheet.Context(1);
        CrumpleVulkanAttachDef def = Device();
        context.AttachVulkan(in def);
        return context;
    }

    static Instance Body(CrumpleContext context, out VulkanBuffer buffer)
    {
        CrumpleInstanceDef instance = CrumpleInstanceDef.Default;
        instance.MarkCapacity = 8;
        Instance body = context.CreateInstance(context.CreateExampleSet(Sheet.Def()), in instance);
        CrumpleVulkanBufferDef def = Range();
        buffer = body.RegisterVulkanBuffer(in def);
        return body;
    }

    /// <summary>The vertices that the device wrote are those that the CPU gives, and recording allocates nothing.</summary>
    static void Frames()
    {
        const ulong frames = 100, warm = 20;
        using (CrumpleContext context = Attached())
        {
            Instance body = Body(context, out VulkanBuffer buffer);
            float[] wanted = new float[Size / 4];
            HostBuffer host = body.RegisterHostBuffer(StridedArray.Of(wanted, 0, Stride), StridedArray.Of(wanted, 12, Stride));
            CrumpleBuffer[] named = { buffer.Id };
            CrumpleRange[] ranges = new CrumpleRange[64];
            long allocated = 0;
            ulong written = 0;
            for (ulong frame = 1; frame <= frames; frame++)
            {
                if (frame == warm) allocated = GC.GetAllocatedBytesForCurrentThread();
                float x = frame * 37 % 101 / 101f - 0.5f, y = frame * 61 % 103 / 103f - 0.5f;
                body.SubmitImpulse(new CrumpleVec3(x, y, 0.07f), new CrumpleVec3(0, 0, -2), 0.01f, 1);
                IntPtr commands = shared_begin(shared);
                CrumpleRecordReport report =
                    frame % 2 == 0 ? context.RecordDeform(commands, frame) : context.RecordDeform(commands, frame, named);
                written += report.VerticesWritten;
                shared_run(shared, commands);
                context.CompleteFrames(frame);
                buffer.GetChanges(ranges, out CrumpleAabb bounds);
                if (!(bounds.Min.Z < bounds.Max.Z)) throw new Check.Failure("bounds");
            }
            Check.Same(0L, GC.GetAllocatedBytesForCurrentThread() - allocated, "bytes allocated in " + (frames - warm) + " frames");
            Check.That(written > 10000, written + " vertices were written");
            context.Deform();
            float* found = (float*)shared_data(shared);
            float off = 0;
            for (int i = 0; i < wanted.Length; i++) off = Math.Max(off, Math.Abs(wanted[i] - found[i]));
            Check.That(off < 1e-5f && wanted.Any(value => value != 0), "the device and the CPU differ by " + off);
            Check.Fails(CrumpleResult.ErrorInvalidArgument, "", () => context.Deform(named)); // a Vulkan buffer
            Check.Same(0UL, context.RecordDeform(new IntPtr(16), frames + 1, default(ReadOnlySpan<CrumpleBuffer>)).VerticesWritten, "none");
            Check.That(context.GetVulkanPipelineCache().Length > 0, "pipeline cache");
            host.Dispose();
        }
    }

    /// <summary>With a frame in flight nothing ends; after that everything does, and the context takes a device again.</summary>
    static void InFlight()
    {
        CrumpleContext context = Attached();
        Instance body = Body(context, out VulkanBuffer buffer);
        IntPtr commands = shared_begin(shared);
        context.RecordDeform(commands, 1);
        Check.Fails(CrumpleResult.ErrorFramesInFlight, "frame", () => context.DetachVulkan());
        Check.Fails(CrumpleResult.ErrorFramesInFlight, "frame", () => context.Dispose());
        Check.That(!context.IsDisposed, "it goes on");
        body.Submit(Sheet.Hit(0, 0, 0.03f));
        shared_run(shared, commands);
        context.CompleteFrames(1);
        context.DetachVulkan();
        Check.Throws<ObjectDisposedException>(() => buffer.Invalidate(), "VulkanBuffer");
        buffer.Dispose();
        CrumpleVulkanAttachDef device = Device();
        context.AttachVulkan(in device);
        CrumpleVulkanBufferDef def = Range();
        VulkanBuffer second = body.RegisterVulkanBuffer(in def);
        commands = shared_begin(shared);
        Check.Same((ulong)Sheet.Vertices, context.RecordDeform(commands, 1).VerticesWritten, "all vertices");
        context.DiscardFrames(1);
        shared_run(shared, commands);
        context.CompleteFrames(1);
        second.Dispose();
        Check.Same(0u, body.GetInfo().BufferCount, "buffers");
        context.Dispose();
    }

    /// <summary>At the end of a domain what is in flight is left alone, and counted; everything else ends.</summary>
    static void LeftBehind()
    {
        CrumpleContext busy = Attached(), idle = Attached();
        Body(busy, out _);
        Body(idle, out _);
        IntPtr commands = shared_begin(shared);
        busy.RecordDeform(commands, 1);
        IntPtr pointer = busy.Pointer, other = idle.Pointer;
        Check.Same(1, CrumpleRuntime.Shutdown(), "left behind");
        Check.Throws<ObjectDisposedException>(() => busy.CompleteFrames(1));
        shared_run(shared, commands);
        // Only who kept its address can end it now.
        Check.Same(CrumpleResult.ErrorInvalidId, NativeMethods.crumple_context_destroy(other), "idle");
        Check.Same(CrumpleResult.Ok, NativeMethods.crumple_vulkan_complete_frames(pointer, 1), "busy");
        Check.Same(CrumpleResult.Ok, NativeMethods.crumple_context_destroy(pointer), "busy");
    }

    /// <summary>A device of Crumple's own: opened, and closed. Nothing is shared with it here.</summary>
    static void OwnDevice()
    {
        using (CrumpleContext context = Sheet.Context(1))
        {
            CrumpleVulkanOpenDef own = CrumpleVulkanOpenDef.Default;
            own.GetInstanceProcAddr = shared_loader();
            try
            {
                context.OpenVulkan(in own);
            }
            catch (CrumpleException error) when (error.Result == CrumpleResult.ErrorUnsupported)
            {
                Console.WriteLine("this driver shares no memory: " + error.Message);
                return;
            }
            ulong frame = context.SubmitDeform(default(ReadOnlySpan<ulong>), default(ReadOnlySpan<ulong>), out CrumpleRecordReport report);
            Check.Same(0UL, report.VerticesWritten, "no buffers");
            Check.That(context.WaitFrame(frame, ulong.MaxValue), "done");
            Check.Throws<ArgumentException>(() => context.SubmitDeform(default(ReadOnlySpan<CrumpleBuffer>), default(ReadOnlySpan<ulong>),
                default(ReadOnlySpan<ulong>), out report), "buffer");
            CrumpleVulkanImportDef import = CrumpleVulkanImportDef.Default;
            Check.Throws<CrumpleException>(() => context.ImportVulkanBuffer(in import), "crumple_vulkan_import_buffer");
        }
    }

    static CrumpleContext held;

    /// <summary>
    /// Contexts whose device goes before them, one forgotten and one held when the process ends: nobody touches the device again,
    /// or this would crash. Without validation, which has an opinion of such hosts.
    /// </summary>
    static void DeviceGoesFirst()
    {
        held = Attached();
        Body(held, out _);
        Thread thread = new Thread(() => Body(Attached(), out _));
        thread.Start();
        thread.Join();
        shared_close(shared);
        for (int i = 0; i < 5; i++)
        {
            GC.Collect();
            GC.WaitForPendingFinalizers();
        }
        Check.That(!held.IsDisposed, "held");
    }

    static int Main(string[] arguments)
    {
        shared = shared_open(Size);
        if (arguments.Length == 1 && arguments[0] == "device-goes-first") return Check.Run(DeviceGoesFirst);
        int status = Check.Run(Frames, InFlight, LeftBehind, OwnDevice);
        if (status == 0) shared_close(shared);
        return status;
    }

    const string Host = "crumplehost";

    [DllImport(Host)] static extern IntPtr shared_open(ulong size);
    [DllImport(Host)] static extern void shared_close(IntPtr shared);
    [DllImport(Host)] static extern IntPtr shared_loader();
    [DllImport(Host)] static extern IntPtr shared_instance(IntPtr shared);
    [DllImport(Host)] static extern IntPtr shared_physical_device(IntPtr shared);
    [DllImport(Host)] static extern IntPtr shared_device(IntPtr shared);
    [DllImport(Host)] static extern uint shared_family(IntPtr shared);
    [DllImport(Host)] static extern ulong shared_buffer(IntPtr shared);
    [DllImport(Host)] static extern IntPtr shared_data(IntPtr shared);
    [DllImport(Host)] static extern IntPtr shared_begin(IntPtr shared);
    [DllImport(Host)] static extern void shared_run(IntPtr shared, IntPtr commands);
}
