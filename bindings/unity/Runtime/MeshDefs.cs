using System;
using System.Collections.Generic;

namespace Crumple
{
    /// <summary>A mesh, as arrays: they are read during the call that takes this, and free again after it.</summary>
    public abstract class MeshDef
    {
        /// <summary>Number of vertices, at least 1. Their order is yours and is kept.</summary>
        public int VertexCount { get; set; }

        /// <summary>3 floats a vertex, m. Any handedness, any axis up. Required.</summary>
        public StridedArray Positions { get; set; }

        /// <summary>Unit normals, 3 floats a vertex. Absent: computed from the triangles, smooth across seams.</summary>
        public StridedArray Normals { get; set; }

        /// <summary>Tangents, 4 floats a vertex: xyz of unit length, w +1 or -1. Absent: none.</summary>
        public StridedArray Tangents { get; set; }

        /// <summary>Triangles, three indices each, counter-clockwise seen from outside, of <see cref="IndexType"/>.</summary>
        public StridedArray Indices { get; set; }

        /// <summary>Number of indices, a multiple of 3.</summary>
        public int IndexCount { get; set; }

        /// <summary>Type of the indices. Default 32 bits.</summary>
        public CrumpleIndexType IndexType { get; set; }

        /// <summary>One vector a vertex: positions and their number.</summary>
        public void SetPositions(CrumpleVec3[] positions)
        {
            Positions = StridedArray.Of(positions);
            VertexCount = positions.Length;
        }

        /// <summary>Triangles of 32-bit indices.</summary>
        public void SetTriangles(uint[] indices)
        {
            Indices = StridedArray.Of(indices);
            IndexCount = indices.Length;
            IndexType = CrumpleIndexType.U32;
        }

        /// <summary>Triangles of 32-bit indices, none negative.</summary>
        public void SetTriangles(int[] indices)
        {
            Indices = StridedArray.Of(indices);
            IndexCount = indices.Length;
            IndexType = CrumpleIndexType.U32;
        }

        /// <summary>Triangles of 16-bit indices.</summary>
        public void SetTriangles(ushort[] indices)
        {
            Indices = StridedArray.Of(indices);
            IndexCount = indices.Length;
            IndexType = CrumpleIndexType.U16;
        }

        /// <summary>A count for C, which has no negative ones.</summary>
        internal static uint Count(int count, string name)
        {
            if (count < 0) throw new ArgumentOutOfRangeException(name, count, "a count is not negative");
            return (uint)count;
        }
    }

    /// <summary>A base mesh and its examples.</summary>
    public sealed class ExampleSetDef : MeshDef
    {
        /// <summary>The same mesh after collisions; at least one.</summary>
        public List<ExampleDef> Examples { get; } = new List<ExampleDef>();

        /// <summary>How the set is made ready.</summary>
        public CrumpleExampleSetOptions Options = CrumpleExampleSetOptions.Default;

        /// <summary>Mass of each vertex, kg, instead of Options.VertexMass. Default null: absent.</summary>
        public float[] VertexMasses { get; set; }
    }

    /// <summary>Another mesh of a set's body, such as a level of detail or a collision proxy.</summary>
    public sealed class LodDef : MeshDef
    {
    }

    /// <summary>
    /// One example: the base mesh after a collision. Give <see cref="TargetPositions"/>, or <see cref="DeltaIndices"/> with
    /// <see cref="PositionDeltas"/>.
    /// </summary>
    public sealed class ExampleDef
    {
        /// <summary>Any text; need not be unique.</summary>
        public string Name { get; set; }

        /// <summary>Full form: where every vertex of the base mesh goes, 3 floats each, m, in the base's order.</summary>
        public StridedArray TargetPositions { get; set; }

        /// <summary>Full form: unit normals there, 3 floats each. Absent: computed.</summary>
        public StridedArray TargetNormals { get; set; }

        /// <summary>Sparse form: number of moved vertices.</summary>
        public int DeltaCount { get; set; }

        /// <summary>Sparse form: indices of the moved vertices, strictly increasing, 32 bits each.</summary>
        public StridedArray DeltaIndices { get; set; }

        /// <summary>Sparse form: how far they move, 3 floats each, m.</summary>
        public StridedArray PositionDeltas { get; set; }

        /// <summary>Sparse form: how their unit normals change, 3 floats each. Absent: computed.</summary>
        public StridedArray NormalDeltas { get; set; }

        /// <summary>The vertex that was hit. Default null: its deepest one, or the one nearest to ContactPoint.</summary>
        public int? ContactVertex { get; set; }

        /// <summary>The point that was hit, m, in the mesh's space. Default null.</summary>
        public CrumpleVec3? ContactPoint { get; set; }

        /// <summary>The surface's outward direction there, of any length but 0. Default null: taken from the mesh.</summary>
        public CrumpleVec3? ContactNormal { get; set; }

        /// <summary>The impulse on the body that made it, N s. Default zero: unknown.</summary>
        public CrumpleVec3 Impulse { get; set; }

        /// <summary>How long the impulse acted, s. Default 0: unknown.</summary>
        public float Duration { get; set; }

        /// <summary>What struck the body. Zeros are unknown.</summary>
        public CrumpleStriker Striker { get; set; }

        internal CrumpleExampleDef ToNative(Pins pins)
        {
            CrumpleExampleDef def = CrumpleExampleDef.Default;
            def.Name = pins.Text(Name);
            def.TargetPositions = pins.Input(TargetPositions);
            def.TargetNormals = pins.Input(TargetNormals);
            def.DeltaCount = MeshDef.Count(DeltaCount, "DeltaCount");
            def.DeltaIndices = pins.Input(DeltaIndices);
            def.PositionDeltas = pins.Input(PositionDeltas);
            def.NormalDeltas = pins.Input(NormalDeltas);
            if (ContactVertex.HasValue)
            {
                def.ContactKind = CrumpleContactKind.Vertex;
                def.ContactVertex = MeshDef.Count(ContactVertex.Value, "ContactVertex");
            }
            else if (ContactPoint.HasValue)
            {
                def.ContactKind = CrumpleContactKind.Point;
                def.ContactPoint = ContactPoint.Value;
            }
            if (ContactNormal.HasValue)
            {
                def.ContactNormal = ContactNormal.Value;
                def.HasContactNormal = true;
            }
            def.Impulse = Impulse;
            def.Duration = Duration;
            def.Striker = Striker;
            return def;
        }
    }
}
