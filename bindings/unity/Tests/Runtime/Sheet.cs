using System;
using UnityEngine;

namespace Crumple.Tests
{
    /// <summary>A sheet of 1 m by 1 m in the plane z = 0, and one example: a dent of 5 cm in its middle.</summary>
    internal static class Sheet
    {
        internal const int Side = 41;

        internal static CrumpleSet CreateSet()
        {
            CrumpleVec3[] rest = new CrumpleVec3[Side * Side], dented = new CrumpleVec3[Side * Side], normals = new CrumpleVec3[Side * Side];
            int[] triangles = new int[(Side - 1) * (Side - 1) * 6];
            for (int v = 0, i = 0; v < rest.Length; v++)
            {
                float x = (float)(v % Side) / (Side - 1) - 0.5f, y = (float)(v / Side) / (Side - 1) - 0.5f;
                float r = (x * x + y * y) / 0.04f, depth = r < 1 ? 0.05f * (1 - r) * (1 - r) : 0;
                rest[v] = new CrumpleVec3(x, y, 0);
                normals[v] = new CrumpleVec3(0, 0, 1);
                dented[v] = new CrumpleVec3(x, y, -depth);
                if (v % Side == Side - 1 || v / Side == Side - 1) continue;
                foreach (int corner in new[] { v, v + 1, v + Side, v + Side, v + 1, v + Side + 1 }) triangles[i++] = corner;
            }
            ExampleSetDef def = new ExampleSetDef();
            def.SetPositions(rest);
            def.Normals = StridedArray.Of(normals);
            def.SetTriangles(triangles);
            def.Options.VertexMass = 0.5f; // kg
            def.Examples.Add(new ExampleDef { Name = "dent", TargetPositions = StridedArray.Of(dented) });
            using (CrumpleContext context = new CrumpleContext())
            using (ExampleSet set = context.CreateExampleSet(def))
            {
                CrumpleSet asset = CrumpleSet.FromBaked(set.Save());
                asset.name = "sheet";
                return asset;
            }
        }

        /// <summary>An object that shows the set's own mesh, and is closed until its set is there.</summary>
        internal static CrumpleMesh Create(CrumpleSet set, CrumpleWriter writer = CrumpleWriter.Cpu, Mesh shown = null)
        {
            GameObject body = new GameObject("Hood");
            body.SetActive(false);
            body.AddComponent<MeshFilter>().sharedMesh = shown;
            CrumpleMesh mesh = body.AddComponent<CrumpleMesh>();
            mesh.Set = set;
            mesh.Writer = writer;
            body.SetActive(true);
            return mesh;
        }

        /// <summary>How deep the deepest vertex lies, m.</summary>
        internal static float Depth(CrumpleMesh mesh)
        {
            float deepest = 0;
            foreach (Vector3 vertex in mesh.GetComponent<MeshFilter>().sharedMesh.vertices) deepest = Math.Max(deepest, -vertex.z);
            return deepest;
        }
    }
}
