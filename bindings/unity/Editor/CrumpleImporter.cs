using System.IO;
using UnityEditor.AssetImporters;
using UnityEngine;

namespace Crumple.Editor
{
    /// <summary>
    /// Makes a <see cref="CrumpleSet"/> of a .crumple file; and of a .glb file with morph targets, where you choose this importer
    /// for it in the Inspector. The set's own mesh comes with it.
    /// </summary>
    [ScriptedImporter(1, new[] { "crumple" }, new[] { "glb" })]
    public sealed class CrumpleImporter : ScriptedImporter
    {
        [Tooltip(".glb: name of the mesh. Empty: the first with morph targets.")]
        [SerializeField] private string meshName = "";
        [Tooltip(".glb: mass of every vertex, kg. Components that say 0 take it.")]
        [Min(0)]
        [SerializeField] private float vertexMass = 0.5f;
        [Tooltip(".glb: how far an example may put a vertex off, m, so that the set is smaller. 0: exact.")]
        [Min(0)]
        [SerializeField] private float tolerance = 0.0001f;

        /// <inheritdoc/>
        public override void OnImportAsset(AssetImportContext import)
        {
            try
            {
                string path = import.assetPath;
                CrumpleSet set = ScriptableObject.CreateInstance<CrumpleSet>();
                set.name = Path.GetFileNameWithoutExtension(path);
                set.SetBytes(path.EndsWith(".glb", System.StringComparison.OrdinalIgnoreCase) ? Bake(path) : File.ReadAllBytes(path));
                Mesh mesh = set.CreateMesh();
                import.AddObjectToAsset("set", set);
                import.AddObjectToAsset("mesh", mesh);
                import.SetMainObject(set);
            }
            catch (CrumpleException error)
            {
                import.LogImportError("Crumple cannot import " + import.assetPath + ": " + error.Message);
            }
            catch (IOException error)
            {
                import.LogImportError("Crumple cannot read " + import.assetPath + ": " + error.Message);
            }
        }

        private byte[] Bake(string path)
        {
            CrumpleExampleSetOptions options = CrumpleGltfDef.Default.Options;
            options.VertexMass = vertexMass;
            options.BakeTolerance = tolerance;
            using (CrumpleContext context = new CrumpleContext())
            using (ExampleSet set = context.LoadGltf(path, meshName.Length == 0 ? null : meshName, options))
                return set.Save();
        }
    }
}
