using System;
using System.IO;
using System.Linq;
using System.Runtime.InteropServices;
using Crumple;

/// <summary>Example sets from every place they can come from.</summary>
static class LoadingTests
{
    public static string Fixtures;

    public static void Gltf()
    {
        using (CrumpleContext context = Sheet.Context())
        {
            string path = Path.Combine(Fixtures, "two_materials.glb");
            using (ExampleSet file = context.LoadGltf(path), memory = context.LoadGltf(File.ReadAllBytes(path)))
            {
                ExampleSetInfo info = file.GetInfo();
                Check.Same(info.Fingerprint, memory.GetInfo().Fingerprint, "fingerprints");
                Check.Same(2, info.PrimitiveCount, "primitives");
                Check.That(info.Name.Length > 0 && info.ExampleCount > 0, info.Name);
                Check.Same(IntPtr.Zero, info.Values.Name, "no pointer is left");
                PrimitiveInfo second = file.GetPrimitive(1);
                Check.That(second.Material.Length > 0, "material");
                Check.Same((uint)info.VertexCount, second.Values.FirstVertex + second.Values.VertexCount, "the last part ends the mesh");
                Check.That(file.GetExample(0).Name.Length > 0, "names");
                Check.Same(1f, info.NodeTransform[15], "node");
                Check.Fails(CrumpleResult.ErrorFormat, "no mesh", () => context.LoadGltf(path, "no such mesh"));
                CrumpleExampleSetOptions options = CrumpleExampleSetOptions.Default;
                options.DepthLimit = 0.001f;
                using (ExampleSet limited = context.LoadGltf(path, options: options))
                    Check.Same(0.001f, limited.GetInfo().Values.DepthLimit, "limit");
            }
            using (ExampleSet body = context.LoadGltf(path, joinNodes: true))
            {
                Check.Same(1, body.FindPart("Plate"), "the only part");
                Check.Fails(CrumpleResult.ErrorInvalidArgument, "Plate", () => body.FindPart("Bumper"));
            }
            Check.Fails(CrumpleResult.ErrorIo, "nowhere.glb", () => context.LoadGltf("nowhere.glb"));
            Check.Fails(CrumpleResult.ErrorFormat, "", () => context.LoadGltf(new byte[64]));
            Check.Throws<ArgumentNullException>(() => context.LoadGltf((string)null));
        }
    }

    public static void Obj()
    {
        using (CrumpleContext context = Sheet.Context())
        {
            string dent = Path.Combine(Fixtures, "plate_dent.obj");
            using (ExampleSet set = context.LoadObj(Path.Combine(Fixtures, "plate.obj"), new[] { dent, dent }))
            {
                Check.Same(2, set.GetInfo().ExampleCount, "examples");
                Check.Same("plate_dent", set.GetExample(1).Name, "name");
            }
        }
    }

    /// <summary>Saved, and loaded from bytes, from memory that is kept, and from a file.</summary>
    public static void Baked()
    {
        byte[] bytes;
        ulong fingerprint;
        using (CrumpleContext context = Sheet.Context())
        {
            ExampleSet set = context.CreateExampleSet(Sheet.Def());
            bytes = set.Save();
            fingerprint = set.GetInfo().Fingerprint;
        }
        using (CrumpleContext context = Sheet.Context())
        {
            Check.Same(fingerprint, context.LoadBaked(bytes).GetInfo().Fingerprint, "bytes");
            string file = Path.Combine(Path.GetTempPath(), "crumple " + Guid.NewGuid().ToString("N") + " ü.crumple");
            File.WriteAllBytes(file, bytes);
            try
            {
                Check.Same(fingerprint, context.LoadBakedFile(file).GetInfo().Fingerprint, "file with a name in UTF-8");
            }
            finally
            {
                File.Delete(file);
            }
            IntPtr memory = Marshal.AllocHGlobal(bytes.Length + 16);
            IntPtr aligned = new IntPtr((memory.ToInt64() + 15) / 16 * 16);
            Marshal.Copy(bytes, 0, aligned, bytes.Length);
            ExampleSet kept = context.LoadBaked(aligned, bytes.Length, CrumpleBytes.Keep);
            Check.Same(fingerprint, kept.GetInfo().Fingerprint, "memory");
            context.Dispose();
            Marshal.FreeHGlobal(memory);
        }
        bytes[bytes.Length / 2] ^= 1;
        using (CrumpleContext context = Sheet.Context())
        {
            Check.Fails(CrumpleResult.ErrorFormat, "", () => context.LoadBaked(bytes));
            Check.Fails(CrumpleResult.ErrorFormat, "", () => context.LoadBaked(default(ReadOnlySpan<byte>)));
        }
    }

    /// <summary>Everything that a def says reaches C, and the mesh comes back.</summary>
    public static void Arrays()
    {
        using (CrumpleContext context = Sheet.Context())
        {
            ExampleSetDef def = Sheet.Def();
            def.SetTriangles(Sheet.Triangles().Select(index => (ushort)index).ToArray());
            def.VertexMasses = Enumerable.Repeat(2f, Sheet.Vertices).ToArray();
            def.Examples[0] = new ExampleDef
            {
                Name = "sparse é",
                DeltaCount = 2,
                DeltaIndices = StridedArray.Of(new uint[] { 3, 312 }),
                PositionDeltas = StridedArray.Of(new[] { new CrumpleVec3(0, 0, -0.01f), new CrumpleVec3(0, 0, -0.02f) }),
                ContactVertex = 3,
                ContactNormal = new CrumpleVec3(0, 0, 2),
            };
            def.Examples[1].ContactPoint = new CrumpleVec3(0.25f, 0.2f, 0);
            ExampleSet set = context.CreateExampleSet(def);
            ExampleInfo sparse = set.GetExample(0);
            Check.Same("sparse é", sparse.Name, "name");
            Check.Same(3u, sparse.Values.ContactVertex, "contact");
            Check.Same(2u, sparse.Values.MovedVertices, "moved");
            Check.Same(1f, sparse.Values.ContactNormal.Z, "normal");
            Check.Same((uint)set.NearestVertex(new CrumpleVec3(0.25f, 0.2f, 0), out _), set.GetExample(1).Values.ContactVertex, "point");
            CrumpleHitResult told = context.CreateInstance(set).SubmitImpulse(Sheet.Point(312, -1), new CrumpleVec3(0, 0, -4), 0.01f);
            Check.Near(-0.02f, told.Target.Z, 1e-7f, "4 N s, 0.01 s, 2 kg");

            CrumpleVec3[] positions = new CrumpleVec3[Sheet.Vertices];
            float[] normals = new float[Sheet.Vertices * 4];
            uint[] indices = new uint[Sheet.Triangles().Length];
            set.CopyMesh(StridedArray.Of(positions), StridedArray.Of(normals, 4, 16), indices: StridedArray.Of(indices));
            Check.That(positions.SequenceEqual(Sheet.Points()), "positions");
            Check.That(indices.Select(index => (int)index).SequenceEqual(Sheet.Triangles()), "indices");
            Check.That(normals[3] > 0.9f && normals[0] == 0, "normals, and nothing between them");
            Check.Fails(CrumpleResult.ErrorMesh, "tangents",
                () => set.CopyMesh(default(StridedArray), tangents: StridedArray.Of(normals, 0, 16)));
        }
    }
}
