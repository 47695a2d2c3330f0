using System;
using Crumple;

/// <summary>Ten thousand frames allocate nothing. tests/c/memory.c has what the library allocates.</summary>
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
            long allocated = 0;
            ulong written = 0;
            int collections = 0;
            for (int frame = 0; frame < Frames; frame++)
            {
                if (frame == Warm)
                {
                    GC.Collect();
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
            Check.That(written > 1000000, written + " vertices were written");
            // The counter counts.
            long before = GC.GetAllocatedBytesForCurrentThread();
            GC.KeepAlive(new byte[100]);
            Check.That(GC.GetAllocatedBytesForCurrentThread() - before >= 100, "the counter counts");
        }
    }
}
