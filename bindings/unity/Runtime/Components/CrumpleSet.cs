using UnityEngine;

namespace Crumple
{
    /// <summary>
    /// An example set as an asset: made by the importer of .crumple files, or of .glb files with morph targets. It holds the
    /// bytes of a .crumple file and what they say.
    /// </summary>
    public sealed class CrumpleSet : ScriptableObject
    {
        [SerializeField, HideInInspector] private byte[] bytes = new byte[0];
        [SerializeField] private int vertexCount;
        [SerializeField] private int exampleCount;
        [SerializeField] private float depthLimit;

        /// <summary>The bytes of a .crumple file.</summary>
        internal byte[] Bytes
        {
            get { return bytes; }
        }

        /// <summary>Vertices of its base mesh.</summary>
        public int VertexCount
        {
            get { return vertexCount; }
        }

        /// <summary>Examples.</summary>
        public int ExampleCount
        {
            get { return exampleCount; }
        }

        /// <summary>No vertex moves further than this, m.</summary>
        public float DepthLimit
        {
            get { return depthLimit; }
        }

        /// <summary>Takes the bytes of a .crumple file, which are checked.</summary>
        /// <exception cref="CrumpleException">They are no .crumple file, or of another version.</exception>
        public void SetBytes(byte[] baked)
        {
            using (CrumpleContext context = new CrumpleContext(1))
            using (ExampleSet set = context.LoadBaked(baked))
            {
                CrumpleExampleSetInfo info = set.GetInfo();
                bytes = baked;
                vertexCount = (int)info.VertexCount;
                exampleCount = (int)info.ExampleCount;
                depthLimit = info.DepthLimit;
            }
        }

        /// <summary>A set from the bytes of a .crumple file, made at run time.</summary>
        public static CrumpleSet FromBaked(byte[] baked)
        {
            CrumpleSet made = CreateInstance<CrumpleSet>();
            made.SetBytes(baked);
            return made;
        }

        /// <summary>The set's base mesh as a Mesh: positions, normals, tangents where it has them, and triangles.</summary>
        public Mesh CreateMesh()
        {
            using (CrumpleContext context = new CrumpleContext(1))
            using (ExampleSet set = context.LoadBaked(bytes))
            {
                Mesh mesh = MeshLayout.MeshOf(set);
                mesh.name = name;
                return mesh;
            }
        }
    }
}
