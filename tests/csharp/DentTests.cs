using System;
using System.IO;
using System.Linq;
using Crumple;

/// <summary>What is dented, and by how much.</summary>
static class DentTests
{
    /// <summary>Marks, bytes and arrays go there and back; the dent is as deep as was asked for.</summary>
    public static void DamageRoundTrips()
    {
        using (CrumpleContext context = Sheet.Context())
        {
            ExampleSet set = context.CreateExampleSet(Sheet.Def());
            Instance body = context.CreateInstance(set), other = context.CreateInstance(set);
            CrumpleVec3[] vertices = new CrumpleVec3[Sheet.Vertices], seen = new CrumpleVec3[Sheet.Vertices];
            HostBuffer buffer = body.RegisterHostBuffer(StridedArray.Of(vertices));
            other.RegisterHostBuffer(StridedArray.Of(seen));
            CrumpleHitResult told = body.Submit(Sheet.Hit(0, 0, 0.04f));
            Check.Same(CrumpleHitStatus.Marked, told.Status, "status");
            Check.Near(-0.04f, told.Achieved.Z, 1e-5f, "achieved");
            Check.Same(0, (int)told.Mark.Told, "a displacement");
            Check.That(told.ExpectedError > 0 && told.ExpectedError <= 1, "expected error");
            CrumpleDeformReport report = context.Deform(new[] { buffer.Id });
            Check.Same((ulong)Sheet.Vertices, report.VerticesWritten, "the first deform writes all");
            Check.Near(0.04f, Sheet.Deepest(vertices), 5e-4f, "depth");
            Check.Near(vertices[told.ContactVertex].Z, Sheet.Point((int)told.ContactVertex, -1).Z - 0.04f, 1e-4f, "contact");
            Check.Same(0f, seen[5].X, "the other is not written yet");
            Check.Same(0UL, context.Deform(new CrumpleBuffer[0]).VerticesWritten, "no buffers are none, not all");
            Check.Same(0f, seen[5].X, "none");

            other.SetMarks(body.GetMarks());
            Check.Same(1, other.MarkCount, "marks");
            context.Deform();
            Check.That(vertices.SequenceEqual(seen), "the same marks give the same vertices");
            byte[] saved = body.SaveDamage();
            Check.Same(saved.Length, body.SavedSize, "saved size");
            other.ResetDamage();
            Check.Same(0, other.MarkCount, "reset");
            other.LoadDamage(saved);
            Check.That(other.SaveDamage().SequenceEqual(saved), "bytes come back");
            body.Submit(Sheet.Hit(0.25f, 0.2f, 0.02f));
            other.CopyDamageFrom(body);
            Check.That(other.SaveDamage().SequenceEqual(body.SaveDamage()), "copied");
            body.RepairDamage(0.5f);
            context.Deform();
            Check.That(Sheet.Deepest(vertices) < 0.75f * Sheet.Deepest(seen), "half repaired");
            body.RepairDamage(0);
            context.Deform();
            Check.That(Sheet.Points().SequenceEqual(vertices), "as new");
            body.SetMarks(default(ReadOnlySpan<CrumpleMark>));
        }
    }

    /// <summary>Hits, changed buffers and bytes of many; a set in two contexts.</summary>
    public static void ManyAtOnce()
    {
        using (CrumpleContext context = Sheet.Context(), other = Sheet.Context())
        {
            ExampleSet set = context.CreateExampleSet(Sheet.Def());
            Instance[] bodies = { context.CreateInstance(set), context.CreateInstance(set) };
            CrumpleInstance[] ids = { bodies[0].Id, bodies[1].Id };
            CrumpleVec3[] vertices = new CrumpleVec3[Sheet.Vertices], seen = new CrumpleVec3[Sheet.Vertices];
            bodies[0].RegisterHostBuffer(StridedArray.Of(vertices));
            HostBuffer second = bodies[1].RegisterHostBuffer(StridedArray.Of(seen));
            context.Deform();
            CrumpleBufferInfo[] changed = new CrumpleBufferInfo[2];
            Check.Same(2, context.GetChangedBuffers(changed), "all are written first");
            Check.Fails(CrumpleResult.ErrorBufferTooSmall, "room for 0", () => context.GetChangedBuffers(default(Span<CrumpleBufferInfo>)));
            bodies[1].Submit(Sheet.Hit(0, 0, 0.02f));
            context.Deform();
            Check.Same(1, context.GetChangedBuffers(changed), "one is hit");
            Check.Same(second.Id.Index, changed[0].Buffer.Index, "the second");
            Check.Same(bodies[1].Id.Index, changed[0].Instance.Index, "of the second body");

            CrumpleHitResult[] results = new CrumpleHitResult[2];
            CrumpleHitDef[] hits = { Sheet.Hit(0.2f, 0, 0.03f), Sheet.Hit(0.2f, 0.1f, 0.03f) };
            context.SubmitHits(ids, hits, results);
            Check.Same(CrumpleHitStatus.Marked, results[1].Status, "status");
            Check.Throws<ArgumentException>(() => context.SubmitHits(ids, hits.Take(1).ToArray(), results));
            CrumpleHitDef blow = CrumpleHitDef.Default;
            Check.Fails(CrumpleResult.ErrorInvalidArgument, "hit 0: ", () => context.SubmitHits(ids.Take(1).ToArray(), new[] { blow }, default(Span<CrumpleHitResult>)));
            byte[] all = context.SaveDamage();
            Check.That(all.SequenceEqual(context.SaveDamage(ids)), "all are both");
            bodies[1].LoadDamage(bodies[0].SaveDamage());
            Check.Same(bodies[0].Revision, bodies[1].Revision, "the same marks");
            context.LoadDamage(all, ids);
            Check.That(all.SequenceEqual(context.SaveDamage()), "bytes come back");
            Check.Fails(CrumpleResult.ErrorDamageMismatch, "2 instances; 1", () => context.LoadDamage(all, ids.Take(1).ToArray()));

            ExampleSet there = set.ShareWith(other);
            Check.Same(set.GetInfo().Fingerprint, there.GetInfo().Fingerprint, "shared");
            set.Dispose();
            other.CreateInstance(there).Submit(hits[0]);
        }
    }

    /// <summary>The points of a manifold are one blow, which the context tells.</summary>
    public static void ContactPoints()
    {
        using (CrumpleContext context = Sheet.Context())
        {
            CrumpleInstanceDef def = CrumpleInstanceDef.Default;
            def.Compliance = 0.001f;
            Instance body = context.CreateInstance(context.CreateExampleSet(Sheet.Def()), in def);
            CrumpleContactPointDef[] points = new CrumpleContactPointDef[2];
            for (int i = 0; i < 2; i++)
            {
                points[i] = CrumpleContactPointDef.Default;
                points[i].Pair = 9;
                points[i].Bodies0 = body.Id;
                points[i].Point = new CrumpleVec3(0.01f * i, 0, 0.07f);
                points[i].Normal = new CrumpleVec3(0, 0, 1);
                points[i].HasVelocity = true;
                points[i].Velocity = new CrumpleVec3(0, 0, -5);
                points[i].Impulse = 15;
            }
            context.ReportContacts(points);
            CrumpleContactReport report = context.StepContacts(1f / 60);
            Check.Same(1UL, report.Hits, "one blow");
            CrumpleContactHit[] hits = new CrumpleContactHit[2];
            Check.Fails(CrumpleResult.ErrorBufferTooSmall, "room for 0", () => context.GetContactHits(default(Span<CrumpleContactHit>)));
            Check.Same(1, context.GetContactHits(hits), "one hit");
            Check.Same(9UL, hits[0].Pair, "pair");
            Check.Same(body.Id.Index, hits[0].Instance.Index, "instance");
            Check.Near(-30, hits[0].Impulse.Z, 1e-4f, "impulse");
            Check.Near(0.005f, hits[0].Point.X, 1e-6f, "the centre");
            Check.Near(-0.03f, hits[0].Result.Achieved.Z, 1e-4f, "depth");
            context.ClearContacts();
            context.StepContacts(1f / 60);
            Check.Same(0, context.GetContactHits(hits), "no hit in the next step");
            Check.Same(2UL, context.ContactTotals().Points, "points");
            CrumpleContactOptionsDef options = CrumpleContactOptionsDef.Default;
            options.MaxPoints = 1;
            context.SetContactOptions(options);
            Check.Fails(CrumpleResult.ErrorInvalidArgument, "max_points", () => context.ReportContacts(points));
        }
    }

    /// <summary>Growth, repair around a point, results of contacts, hits in a pose.</summary>
    public static void TimeAndPoses()
    {
        using (CrumpleContext context = Sheet.Context())
        {
            CrumpleInstanceDef def = CrumpleInstanceDef.Default;
            def.GrowTime = 0.1f;
            def.Compliance = 0.01f;
            Instance body = context.CreateInstance(context.CreateExampleSet(Sheet.Def()), in def);
            CrumpleVec3[] vertices = new CrumpleVec3[Sheet.Vertices];
            body.RegisterHostBuffer(StridedArray.Of(vertices));
            context.SetTime(1);
            CrumpleHitDef hit = Sheet.Hit(0, 0, 0.04f);
            hit.ContactId = 3;
            body.Submit(in hit);
            body.EndContact(3);
            Check.Fails(CrumpleResult.ErrorUnknownContact, "contact_id is 3", () => body.EndContact(3));
            Check.Fails(CrumpleResult.ErrorUnknownContact, "contact_id is 4", () => body.GetContact(4));
            Check.Near(-0.04f, body.GetContact(3).Target.Z, 1e-6f, "of a contact that ended");
            context.SetTime(1.05);
            context.Deform();
            Check.Near(0.02f, Sheet.Deepest(vertices), 1e-3f, "half grown");
            context.SetTime(2);
            CrumpleVec3 at = Sheet.Point((int)body.GetContact(3).ContactVertex, -1);
            body.RepairAround(at, 0.1f, 0.25f);
            context.SetTime(3);
            context.Deform();
            Check.Near(0.01f, Sheet.Deepest(vertices), 1e-3f, "repaired");
            Check.Near(-0.02f, body.SubmitImpulse(at, new CrumpleVec3(0, 0, -2), 0).Target.Z, 1e-6f, "compliance");
        }
    }

    /// <summary>Half of the sheet comes off, is dented alone, and goes on again.</summary>
    public static void Parts()
    {
        using (CrumpleContext context = Sheet.Context())
        {
            ExampleSet set = context.CreateExampleSet(Sheet.Def());
            const int Rows = Sheet.Side / 2;
            LodDef half = new LodDef();
            half.SetPositions(Sheet.Points().Take(Rows * Sheet.Side).ToArray());
            half.SetTriangles(Sheet.Triangles().Take((Rows - 1) * (Sheet.Side - 1) * 6).ToArray());
            int part = set.AddLod(half);
            Instance body = context.CreateInstance(set);
            body.Submit(Sheet.Hit(0, -0.1f, 0.03f));
            Instance bumper = body.ReleasePart(part);
            Check.Same(body.Revision, bumper.Revision, "it keeps its dents");
            CrumpleHitResult told = body.Submit(Sheet.Hit(0, -0.4f, 0.03f));
            Check.That(told.ContactVertex >= Rows * Sheet.Side, "on what is left");
            told = bumper.Submit(Sheet.Hit(0, 0.4f, 0.03f));
            Check.That(told.ContactVertex < Rows * Sheet.Side, "on the part");
            float deepest = bumper.MeasurePart(part, out float mean, out float energy);
            Check.That(mean > 0 && mean < deepest && deepest < 0.05f && energy > 0.02f, "measured");
            body.MountPart(bumper);
            ulong before = bumper.Revision;
            body.Submit(Sheet.Hit(0, -0.3f, 0.03f));
            Check.That(bumper.Revision != before, "dented with the body");
            body.MountPart(bumper, false);
            Check.Fails(CrumpleResult.ErrorInvalidArgument, "on this body", () => body.MountPart(bumper, false));
            body.SetPartRigid(part, true);
            body.MountPart(bumper);
            Check.Same(CrumpleHitStatus.Rigid, body.Submit(Sheet.Hit(0, -0.3f, 0.03f)).Status, "glass");
        }
    }

    /// <summary>What changed, in ranges that cover what differs, and a box around everything.</summary>
    public static void ChangesAndBounds()
    {
        using (CrumpleContext context = Sheet.Context())
        {
            ExampleSet set = context.CreateExampleSet(Sheet.Def());
            Instance body = context.CreateInstance(set);
            CrumpleVec3[] vertices = new CrumpleVec3[Sheet.Vertices];
            HostBuffer buffer = body.RegisterHostBuffer(StridedArray.Of(vertices));
            context.Deform();
            CrumpleVec3[] before = (CrumpleVec3[])vertices.Clone();
            body.Submit(Sheet.Hit(0.25f, 0.2f, 0.03f));
            context.Deform();
            CrumpleRange[] ranges = new CrumpleRange[16];
            int count = buffer.GetChanges(ranges, out CrumpleAabb bounds);
            Check.Same(count, buffer.CountChanges(out CrumpleAabb again), "number of changes");
            Check.Same(bounds, again, "bounds");
            for (int v = 0; v < Sheet.Vertices; v++)
            {
                bool told = ranges.Take(count).Any(range => v >= range.First && v < range.First + range.Count);
                Check.That(told || vertices[v].Equals(before[v]), "what changed is told");
            }
            Check.Same(vertices.Min(v => v.Z), bounds.Min.Z, "lowest");
            Check.Same(vertices.Max(v => v.Z), bounds.Max.Z, "highest");
            Check.Fails(CrumpleResult.ErrorBufferTooSmall, "room for 0", () => buffer.GetChanges(default(Span<CrumpleRange>), out bounds));
            CrumpleRange[] triangles = new CrumpleRange[Sheet.Vertices];
            Check.That(buffer.GetChangedTriangles(triangles, out CrumpleAabb changed) > 0 && triangles[0].Count > 0, "triangles");
            for (uint v = ranges[0].First; v < ranges[0].First + ranges[0].Count; v++)
                Check.That(before[v].Z <= changed.Max.Z && vertices[v].Z >= changed.Min.Z, "the box holds before and now");
            context.Deform();
            Check.Same(0, buffer.GetChanges(default(Span<CrumpleRange>), out bounds), "nothing changed");
            Check.Same(0, buffer.GetChangedTriangles(default(Span<CrumpleRange>), out bounds), "no triangle changed");
            buffer.Invalidate();
            Array.Clear(vertices, 0, vertices.Length);
            Check.Same((ulong)Sheet.Vertices, context.Deform().VerticesWritten, "all again");
            Check.That(Sheet.Deepest(vertices) > 0.02f, "written");
        }
    }

    /// <summary>Impulses in parts make one dent; hits in world space go through the transform.</summary>
    public static void ContactsAndSpaces()
    {
        using (CrumpleContext context = Sheet.Context())
        {
            ExampleSet set = context.CreateExampleSet(Sheet.Def());
            CrumpleInstanceDef def = CrumpleInstanceDef.Default;
            float[] turned = { 0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1 }; // a quarter turn about z, and away
            def.SetLocalToWorld(turned);
            Instance body = context.CreateInstance(set, in def), whole = context.CreateInstance(set);
            CrumpleHitDef hit = Sheet.Hit(5 - 0.1f, 6 + 0.2f, 0.03f);
            hit.Point.Z += 7;
            hit.Space = CrumpleSpace.World;
            CrumpleHitResult told = body.Submit(in hit);
            Check.Same(set.NearestVertex(new CrumpleVec3(0.2f, 0.1f, 0.07f), out float distance), (int)told.ContactVertex, "turned back");
            Check.Near(distance, told.ContactDistance, 1e-5f, "distance");
            body.SetTransform(new float[] { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 });
            Check.Fails(CrumpleResult.ErrorContactTooFar, "m", () => body.Submit(in hit));
            Check.Throws<ArgumentException>(() => body.SetTransform(new float[12]), "16");
            Check.Fails(CrumpleResult.ErrorInvalidArgument, "", () => body.SetTransform(new float[16]));

            body.ResetDamage();
            for (int i = 0; i < 8; i++)
                body.SubmitImpulse(new CrumpleVec3(0.1f, 0.1f, 0.07f), new CrumpleVec3(0, 0, -0.5f), 0.01f, 1, 77);
            Check.Same(1u, body.GetInfo().ContactCount, "one contact");
            body.EndContact(77);
            whole.SubmitImpulse(new CrumpleVec3(0.1f, 0.1f, 0.07f), new CrumpleVec3(0, 0, -4), 0.01f, 1);
            CrumpleMark one = body.GetMarks().Single(), other = whole.GetMarks().Single();
            Check.Same(other.Contact, one.Contact, "contact");
            Check.Near(other.Depth, one.Depth, 1e-6f, "depth");
            Check.Same(0u, body.GetInfo().ContactCount, "ended");
        }
    }

    /// <summary>Limits and tolerances, attached points, other memory, a second level of detail.</summary>
    public static void TheRest()
    {
        using (CrumpleContext context = Sheet.Context())
        {
            ExampleSet set = context.CreateExampleSet(Sheet.Def());
            LodDef lod = new LodDef();
            lod.SetPositions(new[] { Sheet.Point(312, -1), new CrumpleVec3(-0.5f, -0.5f, 0) });
            Check.Same(1, set.AddLod(lod), "the first level");
            Instance body = context.CreateInstance(set);
            CrumpleAttachment lamp = set.AttachPoint(new CrumpleVec3(0.05f, 0.02f, 0.2f));
            CrumplePose rest = body.GetAttachedPose(in lamp);
            Check.Near(0.2f, rest.Position.Z, 1e-6f, "at rest");
            CrumpleVec3[] vertices = new CrumpleVec3[Sheet.Vertices], proxy = new CrumpleVec3[2];
            HostBuffer buffer = body.RegisterHostBuffer(StridedArray.Of(vertices));
            HostBuffer collider = body.RegisterHostBuffer(StridedArray.Of(proxy), lod: 1);
            body.Submit(Sheet.Hit(0, 0, 0.05f));
            Check.That(body.GetAttachedPose(in lamp).Position.Z < rest.Position.Z - 0.03f, "the lamp follows");
            context.Deform();
            Check.Same(vertices[312], proxy[0], "a level's vertex on a base vertex");
            body.SetDepthLimit(0.01f);
            context.Deform();
            Check.Near(0.01f, Sheet.Deepest(vertices), 3e-4f, "near the limit");
            body.SetDepthLimit(0);
            CrumpleVec3[] fresh = new CrumpleVec3[Sheet.Vertices];
            buffer.SetMemory(StridedArray.Of(fresh));
            Check.Fails(CrumpleResult.ErrorBufferTooSmall, "positions", () => buffer.SetMemory(StridedArray.Of(new float[3], 0, 12)));
            Array.Clear(vertices, 0, vertices.Length);
            context.Deform();
            Check.That(Sheet.Deepest(fresh) > 0.045f, "other memory is written");
            Check.That(vertices.All(v => v.Equals(default(CrumpleVec3))), "what it had is not");
            collider.Dispose();
            Check.Same(1u, body.GetInfo().BufferCount, "buffers");
        }
    }
}
