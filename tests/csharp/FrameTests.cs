using System;
using System.IO;
using Crumple;

/// <summary>Ten thousand frames: nothing is allocated, and nothing grows.</summary>
static class FrameTests
{
    const int Frames = 10000, Warm = 500;

    public static void NothingIsAllocated()
    {
        using (CrumpleContext context = new CrumpleContext(1))
        {
            ExampleSet set = context.CreateExampleSet(Sheet.Def());
            CrumpleInstanceDef def = CrumpleInstanceDef.Default;
            def.MarkCapacity = 16; // soon full: marks merge from then on
            Instance body = context.CreateInstance(set, in def);
            float[] vertices = new float[Sheet.Vertices * 6];
            HostBuffer buffer = body.RegisterHostBuffer(StridedArray.Of(vertices, 0, 24), StridedArray.Of(vertices, 12, 24));
            CrumpleBuffer[] buffers = { buffer.Id };
            CrumpleRange[] ranges = new CrumpleRange[64];
            float[] transform = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };
            CrumpleAttachment lamp = set.AttachPoint(new CrumpleVec3(0, 0, 0.1f));
            long allocated = 0, resident = 0;
            ulong native = 0, written = 0;
            int collections = 0;
            for (int frame = 0; frame < Frames; frame++)
            {
                if (frame == Warm)
                {
                    GC.Collect();
                    native = body.GetInfo().MemoryBytes;
                    resident = Resident();
                    collections = GC.CollectionCount(0);
                    allocated = GC.GetAllocatedBytesForCurrentThread();
                }
                float x = frame * 37 % 101 / 101f - 0.5f, y = frame * 61 % 103 / 103f - 0.5f;
                body.SubmitImpulse(new CrumpleVec3(x, y, 0.07f), new CrumpleVec3(0, 0, -2), 0.01f, 1);
                body.SetTransform(transform);
                written += context.Deform().VerticesWritten;
                context.Deform(buffers);
                buffer.GetChanges(ranges, out CrumpleAabb bounds);
                if (!(bounds.Min.Z < bounds.Max.Z)) throw new Exception("bounds");
                body.GetAttachedPose(in lamp);
                if (frame % 100 == 99) body.RepairDamage(0.5f);
            }
            allocated = GC.GetAllocatedBytesForCurrentThread() - allocated;
            Check.Same(0L, allocated, "bytes allocated in " + (Frames - Warm) + " frames");
            Check.Same(collections, GC.CollectionCount(0), "collections");
            // Dents take as much as they have nodes.
            Check.That(body.GetInfo().MemoryBytes < native + native / 2, "memory of the instance");
            Check.That(written > 1000000, written + " vertices were written");
            // A leak of 100 bytes a frame would be more than this.
            if (resident != 0) Check.That(Resident() - resident < 900000, "resident memory grew from " + resident + " to " + Resident());
            // The counter counts.
            long before = GC.GetAllocatedBytesForCurrentThread();
            GC.KeepAlive(new byte[100]);
            Check.That(GC.GetAllocatedBytesForCurrentThread() - before >= 100, "the counter counts");
        }
    }

    /// <summary>Scenes come and go; memory does not.</summary>
    public static void ScenesComeAndGo()
    {
        byte[] baked;
        using (CrumpleContext context = new CrumpleContext(1)) baked = context.CreateExampleSet(Sheet.Def()).Save();
        long resident = 0;
        for (int scene = 0; scene < 300; scene++)
        {
            if (scene == 100)
            {
                GC.Collect();
                resident = Resident();
            }
            using (CrumpleContext context = new CrumpleContext(1, (level, message) => { }))
            {
                ExampleSet set = context.LoadBaked(baked);
                Instance body = context.CreateInstance(set);
                body.RegisterHostBuffer(StridedArray.Of(new CrumpleVec3[Sheet.Vertices]));
                body.Submit(Sheet.Hit(0, 0, 0.02f));
                context.Deform();
                if (scene % 2 == 0) body.Dispose();
            }
        }
        GC.Collect();
        // One set is 90 kB and more: 200 of them would be 18 MB.
        if (resident != 0) Check.That(Resident() - resident < 6000000, "resident memory grew from " + resident + " to " + Resident());
        Check.That(baked.Length > 20000, "a set has " + baked.Length + " bytes");
    }

    /// <summary>Bytes of this process in memory; 0 where the system does not tell.</summary>
    static long Resident()
    {
        const string file = "/proc/self/statm";
        return File.Exists(file) ? long.Parse(File.ReadAllText(file).Split(' ')[1]) * 4096 : 0;
    }
}
