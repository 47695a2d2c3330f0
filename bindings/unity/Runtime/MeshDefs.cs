using System.Collections.Generic;

namespace Crumple
{
    /// <summary>A mesh, as arrays: they are read during the call that takes this, and free again after it.</summary>
    public class MeshDef
    {
        /// <summary>Number of vertices, at least 1. Their order is yours and is kept.</summary>
        public int VertexCount { get; set; }

        /// <summary>3 floats a vertex, m. Any handedness, any axis up. Required.</summary>
        public StridedArray Positions { get; set; }

        /// <summary>Unit normals, 3 floats a vertex. Absent: computed from the triangles, smooth across seams.</summary>
        public StridedArray Normals { get; set; }

        /// <summary>Tangents, 4 floats a vertex: xyz of unit length, w +1 or -1. Absent: none.</summary>
        public StridedArray Tangents { get; set; }

        /// <summary>Triangles, three 32-bit indices each, counter-clockwise seen from outside.</summary>
        public StridedArray Indices { get; set; }

        /// <summary>Number of indices, a multiple of 3.</summary>
        public int IndexCount { get; set; }

        /// <summary>One vector a vertex: positions and their number.</summary>
        public void SetPositions(CrumpleVec3[] positions)
        {
            Positions = StridedArray.Of(positions);
            VertexCount = positions.Length;
        }

        /// <summary>Triangles and the number of their indices.</summary>
        public void SetTriangles(uint[] indices)
        {
            Indices = StridedArray.Of(indices);
            IndexCount = indices.Length;
        }

        /// <summary>The same, none negative.</summary>
        public void SetTriangles(int[] indices)
        {
            Indices = StridedArray.Of(indices);
            IndexCount = indices.Length;
        }

        internal CrumpleMeshDef ToNative(Pins pins)
        {
            CrumpleMeshDef def = CrumpleMeshDef.Default;
            def.VertexCount = (uint)VertexCount;
            def.Positions = pins.Input(Positions);
            def.Normals = pins.Input(Normals);
            def.Tangents = pins.Input(Tangents);
            def.Indices = pins.Input(Indices);
            def.IndexCount = (uint)IndexCount;
            return def;
        }
    }

    /// <summary>A base mesh and its examples.</summary>
    public sealed class ExampleSetDef : MeshDef
    {
        /// <summary>The same mesh after collisions; at least one.</summary>
        public List<ExampleDef> Examples { get; } = new List<ExampleDef>();

        /// <summary>How the set is made ready.</summary>
        public CrumpleExampleSetOptions Options = CrumpleExampleSetDef.Default.Options;
    }

    /// <summary>One example: the base mesh after a collision.</summary>
    public sealed class ExampleDef
    {
        /// <summary>Any text; need not be unique.</summary>
        public string Name { get; set; }

        /// <summary>Where every vertex of the base mesh goes, 3 floats each, m, in the base's order.</summary>
        public StridedArray TargetPositions { get; set; }

        /// <summary>Unit normals there, 3 floats each. Absent: computed.</summary>
        public StridedArray TargetNormals { get; set; }

        /// <summary>What is known of the collision: its contact, impulse, duration and striker, as in crumple_build.h.</summary>
        public CrumpleExampleDef Collision = CrumpleExampleDef.Default;

        internal CrumpleExampleDef ToNative(Pins pins)
        {
            CrumpleExampleDef def = Collision;
            def.Name = pins.Text(Name);
            def.TargetPositions = pins.Input(TargetPositions);
            def.TargetNormals = pins.Input(TargetNormals);
            return def;
        }
    }
}
