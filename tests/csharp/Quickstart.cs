// A sheet of metal, one example of a dent in its middle, and a hit somewhere else.
using System;
using Crumple;

static class Quickstart
{
    const int Side = 41, Vertices = Side * Side;

    static int Main()
    {
        // 1. The base mesh, 1 m by 1 m, and the same mesh after a collision: 5 cm deep in the middle.
        CrumpleVec3[] flat = new CrumpleVec3[Vertices], dented = new CrumpleVec3[Vertices];
        uint[] indices = new uint[(Side - 1) * (Side - 1) * 6];
        for (int v = 0, i = 0; v < Vertices; v++)
        {
            float x = v % Side / (Side - 1f) - 0.5f, y = v / Side / (Side - 1f) - 0.5f;
            float r = (float)Math.Sqrt(x * x + y * y) / 0.2f, depth = r < 1 ? 0.05f * (1 - r * r) * (1 - r * r) : 0;
            flat[v] = new CrumpleVec3(x, y, 0);
            dented[v] = new CrumpleVec3(x, y, -depth);
            if (v % Side == Side - 1 || v / Side == Side - 1) continue;
            foreach (int corner in new[] { v, v + 1, v + Side, v + Side, v + 1, v + Side + 1 }) indices[i++] = (uint)corner;
        }

        // 2. A context, an example set, and a body in the scene.
        using (CrumpleContext context = new CrumpleContext())
        {
            ExampleSetDef def = new ExampleSetDef();
            def.SetPositions(flat);
            def.SetTriangles(indices);
            def.Examples.Add(new ExampleDef { TargetPositions = StridedArray.Of(dented) });
            def.Options.VertexMass = 0.5f; // kg
            ExampleSet set = context.CreateExampleSet(def);
            Instance body = context.CreateInstance(set);

            // 3. Your vertex buffer: position and normal interleaved, 24 bytes a vertex.
            float[] vertices = new float[Vertices * 6];
            body.RegisterHostBuffer(StridedArray.Of(vertices, 0, 24), StridedArray.Of(vertices, 12, 24));

            // 4. A contact from your physics engine: 2 N s downwards in 10 ms, 25 cm from the middle. Any thread.
            CrumpleHitResult told = body.SubmitImpulse(new CrumpleVec3(0.25f, 0, 0), new CrumpleVec3(0, 0, -2), 0.01f);

            // 5. Once a frame.
            context.Deform();
            float z = vertices[6 * told.ContactVertex + 2];
            Console.WriteLine("vertex {0} is dented by {1:0.0} mm", told.ContactVertex, -1000 * z);
            return Math.Abs(z + 0.04f) < 1e-4f ? 0 : 1;
        }
    }
}
