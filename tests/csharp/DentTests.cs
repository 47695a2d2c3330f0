using System;
using System.Linq;
using Crumple;
using Crumple.Native;

/// <summary>From hits to vertices, as far as C# could get it wrong: arrays, spans, bools, ids, results.</summary>
static class DentTests
{
    public static void HitToVertices()
    {
        using (CrumpleContext context = new CrumpleContext(2))
        {
            ExampleSet set = context.CreateExampleSet(Sheet.Def());
            Instance body = context.CreateInstance(set), other = context.CreateInstance(set);
            CrumpleVec3[] vertices = new CrumpleVec3[Sheet.Vertices], seen = new CrumpleVec3[Sheet.Vertices];
            HostBuffer buffer = body.RegisterHostBuffer(StridedArray.Of(vertices));
            other.RegisterHostBuffer(StridedArray.Of(seen));
            CrumpleHitResult told = body.Submit(Sheet.Hit(0, 0, 0.04f));
            Check.Same(CrumpleHitStatus.Marked, told.Status, "status");
            Check.Near(-0.04f, told.Achieved.Z, 1e-5f, "achieved");
            CrumpleDeformReport report = context.Deform(new[] { buffer.Id });
            Check.Same((ulong)Sheet.Vertices, report.VerticesWritten, "the first deform writes all");
            Check.Near(0.04f, Sheet.Deepest(vertices), 5e-4f, "depth");
            Check.Same(0f, seen[5].X, "the other is not written yet");

            CrumpleRange[] ranges = new CrumpleRange[16];
            Check.Same(1, buffer.GetChanges(ranges, out CrumpleAabb bounds), "ranges");
            Check.Same((uint)Sheet.Vertices, ranges[0].Count, "all");
            Check.Same(1, buffer.GetChanges(default(Span<CrumpleRange>), out bounds), "counted only");
            Check.Same(vertices.Min(v => v.Z), bounds.Min.Z, "lowest");
            byte[] saved = body.SaveDamage();
            other.LoadDamage(saved);
            Check.That(other.SaveDamage().SequenceEqual(saved), "bytes come back");
            context.Deform();
            Check.That(vertices.SequenceEqual(seen), "the same marks give the same vertices");
            body.RepairDamage(0.5f);
            context.Deform();
            Check.That(Sheet.Deepest(vertices) < 0.75f * Sheet.Deepest(seen), "half repaired");
            body.ResetDamage();
            context.Deform();
            Check.That(Sheet.Points().SequenceEqual(vertices), "as new");
        }
    }

    /// <summary>Hits in world space, attached points and levels of detail; a function that has no method.</summary>
    public static void SpacesAndMeshes()
    {
        using (CrumpleContext context = new CrumpleContext(2))
        {
            ExampleSet set = context.CreateExampleSet(Sheet.Def());
            MeshDef lod = new MeshDef();
            lod.SetPositions(new[] { Sheet.Point(312, -1), new CrumpleVec3(-0.5f, -0.5f, 0) });
            Check.Same(1, set.AddLod(lod), "the first level");
            Instance body = context.CreateInstance(set);
            CrumpleVec3[] vertices = new CrumpleVec3[Sheet.Vertices], proxy = new CrumpleVec3[2];
            body.RegisterHostBuffer(StridedArray.Of(vertices));
            body.RegisterHostBuffer(StridedArray.Of(proxy), lod: 1);
            CrumpleAttachment lamp = set.AttachPoint(new CrumpleVec3(0.05f, 0.02f, 0.2f));
            CrumplePose rest = body.GetAttachedPose(in lamp);
            Check.Near(0.2f, rest.Position.Z, 1e-6f, "at rest");
            body.SetTransform(new float[] { 0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1 }); // a quarter turn about z, and away
            CrumpleHitDef hit = Sheet.Hit(5, 6, 0.05f);
            hit.Point.Z += 7;
            hit.Space = CrumpleSpace.World;
            Check.Same(312u, body.Submit(in hit).ContactVertex, "turned back");
            context.Deform();
            Check.Same(vertices[312], proxy[0], "a level's vertex on a base vertex");
            Check.That(body.GetAttachedPose(in lamp).Position.Z < rest.Position.Z - 0.03f, "the lamp follows");
            CrumpleException.Check(NativeMethods.crumple_instance_repair_around(context.Pointer, body.Id, new CrumpleVec3(0, 0, 0), 0.3f, 0));
            context.Deform();
            Check.That(Sheet.Deepest(vertices) < 0.03f, "repaired around the middle");
        }
    }

    /// <summary>The points of a manifold are one blow, which the context tells.</summary>
    public static void ContactPoints()
    {
        using (CrumpleContext context = new CrumpleContext(2))
        {
            CrumpleInstanceDef def = CrumpleInstanceDef.Default;
            def.Compliance = 0.001f;
            Instance body = context.CreateInstance(context.CreateExampleSet(Sheet.Def()), in def);
            CrumpleContactPointDef point = CrumpleContactPointDef.Default;
            point.Pair = 9;
            point.Bodies0 = body.Id;
            point.Point = new CrumpleVec3(0, 0, 0.07f);
            point.Normal = new CrumpleVec3(0, 0, 1);
            point.HasVelocity = true;
            point.Velocity = new CrumpleVec3(0, 0, -5);
            point.Impulse = 15;
            CrumpleContactPointDef[] points = { point, point };
            context.ReportContacts(points);
            Check.Same(1UL, context.StepContacts(1f / 60).Hits, "one blow");
            CrumpleContactHit[] hits = new CrumpleContactHit[2];
            Check.Same(1, context.GetContactHits(hits), "one hit");
            Check.Same(body.Id.Index, hits[0].Instance.Index, "on the body");
            Check.Same(2UL, context.ContactTotals().Points, "points");
            CrumpleContactOptionsDef options = CrumpleContactOptionsDef.Default;
            options.MaxPoints = 1;
            context.SetContactOptions(options);
            Check.Fails(CrumpleResult.ErrorInvalidArgument, "max_points", () => context.ReportContacts(points));
        }
    }

    /// <summary>A failure is an exception with the library's message, and nothing has changed.</summary>
    public static void Errors()
    {
        using (CrumpleContext context = new CrumpleContext(2), other = new CrumpleContext(2))
        {
            ExampleSet set = context.CreateExampleSet(Sheet.Def());
            Instance body = context.CreateInstance(set);
            Check.Fails(CrumpleResult.ErrorInvalidArgument, "threads", () => new CrumpleContext(-1));
            Check.Fails(CrumpleResult.ErrorContactTooFar, "m", () => body.SubmitImpulse(new CrumpleVec3(0, 0, 50), new CrumpleVec3(0, 0, -1), 0.01f, 1));
            Check.Fails(CrumpleResult.ErrorBufferTooSmall, "positions", () => body.RegisterHostBuffer(StridedArray.Of(new CrumpleVec3[5])));
            Check.Fails(CrumpleResult.ErrorNullPointer, "positions", () => body.RegisterHostBuffer(default(StridedArray)));
            Check.Fails(CrumpleResult.ErrorInvalidId, "another context", () => other.CreateInstance(set));
            Check.Same(0u, body.GetInfo().MarkCount + body.GetInfo().BufferCount, "marks and buffers after all that");
            Check.Throws<ArgumentException>(() => body.SetTransform(new float[12]), "16");
            Check.Throws<ArgumentNullException>(() => StridedArray.At(IntPtr.Zero, 4, 0, 4));
            Check.Throws<ArgumentOutOfRangeException>(() => StridedArray.Of(new float[3], 16, 12), "offset");
            Check.Throws<ArgumentException>(() => StridedArray.Of(new bool[3]), "plain numbers");
            Check.Throws<ArgumentException>(() => StridedArray.Of(new Holder[1]), "plain numbers");
        }
    }

    struct Holder
    {
#pragma warning disable 649
        public string Text;
#pragma warning restore 649
    }
}
