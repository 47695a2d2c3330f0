using System;
using System.IO;
using System.Linq;
using Crumple;

/// <summary>Example sets from every place they can come from: names in UTF-8, options, arrays.</summary>
static class LoadingTests
{
    public static string Fixtures;

    public static void Files()
    {
        string file = Path.Combine(Path.GetTempPath(), "crumple " + Guid.NewGuid().ToString("N") + " ü.glb");
        File.Copy(Path.Combine(Fixtures, "two_materials.glb"), file);
        try
        {
            using (CrumpleContext context = new CrumpleContext(2))
            {
                CrumpleExampleSetOptions options = CrumpleGltfDef.Default.Options;
                options.DepthLimit = 0.001f;
                ExampleSet set = context.LoadGltf(file, options: options);
                CrumpleExampleSetInfo info = set.GetInfo();
                Check.Same(0.001f, info.DepthLimit, "limit");
                Check.Same(2u, info.PrimitiveCount, "primitives");
                byte[] bytes = set.Save();
                Check.Same(info.Fingerprint, context.LoadBaked(bytes).GetInfo().Fingerprint, "bytes");
                Check.Fails(CrumpleResult.ErrorFormat, "nö such mesh", () => context.LoadGltf(file, "nö such mesh"));
                Check.Fails(CrumpleResult.ErrorIo, "nowhere.glb", () => context.LoadGltf("nowhere.glb"));
                Check.Fails(CrumpleResult.ErrorFormat, "", () => context.LoadBaked(bytes.Take(100).ToArray()));
            }
        }
        finally
        {
            File.Delete(file);
        }
    }

    /// <summary>What a def says reaches C, and the mesh comes back.</summary>
    public static void Arrays()
    {
        using (CrumpleContext context = new CrumpleContext(2))
        {
            ExampleSetDef def = Sheet.Def();
            def.Options.VertexMass = 2;
            ExampleSet set = context.CreateExampleSet(def);
            Check.Same(3u, set.GetInfo().ExampleCount, "examples");
            CrumpleHitResult told = context.CreateInstance(set).SubmitImpulse(Sheet.Point(312, -1), new CrumpleVec3(0, 0, -4), 0.01f);
            Check.Near(-0.02f, told.Target.Z, 1e-7f, "4 N s, 0.01 s, 2 kg");
            def.Examples[1].Collision.ContactKind = CrumpleContactKind.Vertex;
            def.Examples[1].Collision.ContactVertex = 312;
            Check.Fails(CrumpleResult.ErrorExampleMismatch, "vertex 312", () => context.CreateExampleSet(def));

            CrumpleVec3[] positions = new CrumpleVec3[Sheet.Vertices];
            float[] normals = new float[Sheet.Vertices * 4];
            uint[] indices = new uint[Sheet.Triangles().Length];
            set.CopyMesh(StridedArray.Of(positions), StridedArray.Of(normals, 4, 16), indices: StridedArray.Of(indices));
            Check.That(positions.SequenceEqual(Sheet.Points()), "positions");
            Check.That(indices.Select(index => (int)index).SequenceEqual(Sheet.Triangles()), "indices");
            Check.That(normals[3] > 0.9f && normals[0] == 0, "normals, and nothing between them");
        }
    }
}
