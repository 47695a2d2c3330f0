using System;
using Unity.Collections;
using UnityEngine;
using UnityEngine.Rendering;

namespace Crumple
{
    /// <summary>Something that a mesh or a component lacks. The message says what it is and what would be right.</summary>
    internal sealed class CrumpleSetupException : CrumpleException
    {
        internal CrumpleSetupException(string message)
            : base(CrumpleResult.ErrorUnsupported, message)
        {
        }
    }

    /// <summary>Where a Mesh has its positions, normals and tangents.</summary>
    internal struct MeshLayout
    {
        internal UnityPlugin.Attribute Position, Normal, Tangent;
        internal int Stream, Stride, VertexCount;

        /// <summary>Reads the layout. All three must lie in one vertex stream, since that is one buffer.</summary>
        internal static MeshLayout Of(Mesh mesh)
        {
            MeshLayout layout = default(MeshLayout);
            layout.VertexCount = mesh.vertexCount;
            if (!mesh.HasVertexAttribute(VertexAttribute.Position))
                throw new CrumpleSetupException("mesh '" + mesh.name + "' has no positions");
            layout.Stream = mesh.GetVertexAttributeStream(VertexAttribute.Position);
            layout.Stride = mesh.GetVertexBufferStride(layout.Stream);
            layout.Position = Read(mesh, VertexAttribute.Position, layout.Stream, "positions");
            layout.Normal = Read(mesh, VertexAttribute.Normal, layout.Stream, "normals");
            layout.Tangent = Read(mesh, VertexAttribute.Tangent, layout.Stream, "tangents");
            return layout;
        }

        private static UnityPlugin.Attribute Read(Mesh mesh, VertexAttribute which, int stream, string what)
        {
            UnityPlugin.Attribute found = default(UnityPlugin.Attribute);
            if (!mesh.HasVertexAttribute(which)) return found;
            if (mesh.GetVertexAttributeStream(which) != stream)
                throw new CrumpleSetupException("mesh '" + mesh.name + "' has its " + what + " in vertex stream " +
                    mesh.GetVertexAttributeStream(which) + " and its positions in stream " + stream +
                    "; Crumple writes them in one: Mesh.SetVertexBufferParams with the same stream for both");
            found.Format = (int)mesh.GetVertexAttributeFormat(which);
            found.Dimension = mesh.GetVertexAttributeDimension(which);
            found.Offset = mesh.GetVertexAttributeOffset(which);
            return found;
        }

        /// <summary>The CPU writes 32-bit floats only.</summary>
        internal void CheckForCpu(Mesh mesh)
        {
            Check(mesh, Position, 3, "positions");
            Check(mesh, Normal, 3, "normals");
            Check(mesh, Tangent, 4, "tangents");
        }

        private static void Check(Mesh mesh, UnityPlugin.Attribute attribute, int dimension, string what)
        {
            if (attribute.Dimension == 0) return;
            if (attribute.Format == (int)VertexAttributeFormat.Float32 && attribute.Dimension == dimension) return;
            throw new CrumpleSetupException("mesh '" + mesh.name + "' has " + what + " in " + (VertexAttributeFormat)attribute.Format + " x " +
                attribute.Dimension + "; on the CPU Crumple writes Float32 x " + dimension +
                ": switch Vertex Compression off for them in Player Settings, or write on the GPU");
        }

        /// <summary>A set's base mesh as a Mesh with one vertex stream.</summary>
        internal static Mesh MeshOf(ExampleSet set)
        {
            CrumpleExampleSetInfo info = set.GetInfo();
            bool tangents = info.HasTangents;
            int stride = tangents ? 40 : 24, count = (int)info.VertexCount;
            float[] vertices = new float[count * stride / 4];
            uint[] indices = new uint[info.TriangleCount * 3];
            set.CopyMesh(StridedArray.Of(vertices, 0, stride), StridedArray.Of(vertices, 12, stride),
                tangents ? StridedArray.Of(vertices, 24, stride) : default(StridedArray),
                indices.Length > 0 ? StridedArray.Of(indices) : default(StridedArray));
            Mesh mesh = new Mesh();
            VertexAttributeDescriptor[] attributes = new VertexAttributeDescriptor[tangents ? 3 : 2];
            attributes[0] = new VertexAttributeDescriptor(VertexAttribute.Position, VertexAttributeFormat.Float32, 3);
            attributes[1] = new VertexAttributeDescriptor(VertexAttribute.Normal, VertexAttributeFormat.Float32, 3);
            if (tangents) attributes[2] = new VertexAttributeDescriptor(VertexAttribute.Tangent, VertexAttributeFormat.Float32, 4);
            mesh.SetVertexBufferParams(count, attributes);
            mesh.SetVertexBufferData(vertices, 0, 0, vertices.Length);
            mesh.SetIndexBufferParams(indices.Length, IndexFormat.UInt32);
            mesh.SetIndexBufferData(indices, 0, 0, indices.Length);
            mesh.subMeshCount = 1;
            mesh.SetSubMesh(0, new SubMeshDescriptor(0, indices.Length));
            mesh.bounds = ToBounds(info.Bounds);
            return mesh;
        }

        internal static Bounds ToBounds(CrumpleAabb box)
        {
            Bounds bounds = new Bounds();
            bounds.SetMinMax(new Vector3(box.Min.X, box.Min.Y, box.Min.Z), new Vector3(box.Max.X, box.Max.Y, box.Max.Z));
            return bounds;
        }
    }

    /// <summary>Which mesh of an example set a Mesh is: the base mesh itself, or another one of the same body, which is bound to
    /// it.</summary>
    internal sealed class MeshMatch
    {
        private readonly string name;
        private readonly Vector3[] positions, normals;
        private readonly Vector4[] tangents;
        private readonly int[] triangles;

        internal MeshMatch(Mesh mesh)
        {
            name = mesh.name;
            if (!mesh.isReadable)
                throw new CrumpleSetupException("mesh '" + name + "' is not readable: tick Read/Write in its import settings");
            positions = mesh.vertices;
            normals = mesh.normals;
            tangents = mesh.tangents;
            triangles = mesh.triangles;
            if (positions.Length == 0) throw new CrumpleSetupException("mesh '" + name + "' has no vertices");
        }

        /// <summary>0: vertex by vertex the base mesh. Otherwise it becomes a level of detail of the set.</summary>
        internal int Find(ExampleSet set, string setName)
        {
            CrumpleExampleSetInfo info = set.GetInfo();
            Vector3[] theirs = new Vector3[info.VertexCount];
            set.CopyMesh(StridedArray.Of(theirs));
            float size = MeshLayout.ToBounds(info.Bounds).size.magnitude;
            if (IsBase(theirs, 1e-4f * size)) return 0;
            CheckPlace(set, theirs, 0.02f * size, setName);
            MeshDef lod = new MeshDef();
            lod.Positions = StridedArray.Of(positions);
            lod.VertexCount = positions.Length;
            if (normals.Length == positions.Length) lod.Normals = StridedArray.Of(normals);
            if (tangents.Length == positions.Length) lod.Tangents = StridedArray.Of(tangents);
            lod.SetTriangles(triangles);
            return set.AddLod(lod);
        }

        private bool IsBase(Vector3[] theirs, float tolerance)
        {
            if (positions.Length != theirs.Length) return false;
            for (int i = 0; i < theirs.Length; i++)
                if (!((theirs[i] - positions[i]).magnitude <= tolerance)) return false;
            return true;
        }

        // A mesh in another place, scale or handedness would be bound too, to the wrong vertices. Some hundred of its vertices
        // tell: they lie near the base mesh's surface.
        private unsafe void CheckPlace(ExampleSet set, Vector3[] theirs, float tolerance, string setName)
        {
            int step = Math.Max(1, positions.Length / 256);
            for (int i = 0; i < positions.Length; i += step)
            {
                CrumpleAttachment nearest = set.AttachPoint(ToCrumple(positions[i]));
                Vector3 surface = Vector3.zero;
                for (int corner = 0; corner < 3; corner++) surface += nearest.Weights[corner] * theirs[nearest.Vertices[corner]];
                float distance = (positions[i] - surface).magnitude;
                if (distance <= tolerance) continue;
                throw new CrumpleSetupException("mesh '" + name + "' does not lie where example set '" + setName + "' does: its vertex " + i +
                    " at " + positions[i] + " is " + distance + " m off. Both must be in one space, " +
                    "in metres; most glTF importers of Unity mirror x, the set does not. Leave the mesh filter empty to show the set's own mesh");
            }
        }

        internal static CrumpleVec3 ToCrumple(Vector3 v)
        {
            return new CrumpleVec3(v.x, v.y, v.z);
        }
    }
}
