using System;
using Crumple;

/// <summary>The scene of tests/c/support.h: a crowned sheet of 1 m by 1 m, z up, with dents in three places.</summary>
static class Sheet
{
    public const int Side = 25, Vertices = Side * Side, Examples = 3;
    static readonly float[][] Centres = { new[] { 0, 0, 0.05f }, new[] { 0.25f, 0.2f, 0.03f }, new[] { -0.2f, 0.25f, 0.08f } };

    public static CrumpleVec3 Point(int v, int example)
    {
        float x = v % Side / (Side - 1f) - 0.5f, y = v / Side / (Side - 1f) - 0.5f;
        float z = 0.2f * (0.25f - x * x) + 0.1f * (0.25f - y * y);
        if (example >= 0)
        {
            float dx = x - Centres[example][0], dy = y - Centres[example][1], r = (dx * dx + dy * dy) / 0.04f;
            if (r < 1) z -= Centres[example][2] * (1 - r) * (1 - r);
        }
        return new CrumpleVec3(x, y, z);
    }

    public static CrumpleVec3[] Points(int example = -1)
    {
        CrumpleVec3[] points = new CrumpleVec3[Vertices];
        for (int v = 0; v < Vertices; v++) points[v] = Point(v, example);
        return points;
    }

    public static int[] Triangles()
    {
        int[] indices = new int[(Side - 1) * (Side - 1) * 6];
        for (int v = 0, i = 0; v < Vertices; v++)
        {
            if (v % Side == Side - 1 || v / Side == Side - 1) continue;
            foreach (int corner in new[] { v, v + 1, v + Side, v + Side, v + 1, v + Side + 1 }) indices[i++] = corner;
        }
        return indices;
    }

    public static ExampleSetDef Def()
    {
        ExampleSetDef def = new ExampleSetDef();
        def.SetPositions(Points());
        def.SetTriangles(Triangles());
        for (int e = 0; e < Examples; e++)
            def.Examples.Add(new ExampleDef { Name = "dent " + e, TargetPositions = StridedArray.Of(Points(e)) });
        return def;
    }

    /// <summary>A hit from above that asks for so many metres.</summary>
    public static CrumpleHitDef Hit(float x, float y, float depth)
    {
        CrumpleHitDef def = CrumpleHitDef.Default;
        def.Kind = CrumpleHitKind.Displacement;
        def.Point = new CrumpleVec3(x, y, 0.07f);
        def.Displacement = new CrumpleVec3(0, 0, -depth);
        return def;
    }

    /// <summary>How far the deepest vertex lies below where it was, m.</summary>
    public static float Deepest(CrumpleVec3[] vertices)
    {
        float deepest = 0;
        for (int v = 0; v < Vertices; v++) deepest = Math.Max(deepest, Point(v, -1).Z - vertices[v].Z);
        return deepest;
    }
}
