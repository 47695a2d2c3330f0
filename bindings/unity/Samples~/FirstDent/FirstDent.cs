using Crumple;
using UnityEngine;

/// <summary>
/// A sheet of metal, and a ball that falls on it. Put this on an empty object in an empty scene with a camera in front, and press
/// Play. With an imported set in the Inspector that is dented instead.
/// </summary>
public sealed class FirstDent : MonoBehaviour
{
    private const int Side = 41;

    [Tooltip("Empty: a sheet of 1 m by 1 m.")]
    [SerializeField] private CrumpleSet set;

    /// <summary>What is dented.</summary>
    public CrumpleMesh Dented { get; private set; }

    private void Start()
    {
        if (set == null) set = CreateSheet();
        GameObject body = new GameObject("Sheet");
        body.SetActive(false);
        body.AddComponent<MeshFilter>(); // without a mesh: the component gives it the set's own
        GameObject ball = GameObject.CreatePrimitive(PrimitiveType.Sphere);
        body.AddComponent<MeshRenderer>().sharedMaterial = ball.GetComponent<MeshRenderer>().sharedMaterial; // of any pipeline
        BoxCollider box = body.AddComponent<BoxCollider>();
        box.size = new Vector3(1, 1, 0.02f);
        box.center = new Vector3(0, 0, -0.01f);
        Dented = body.AddComponent<CrumpleMesh>();
        Dented.Set = set;
        body.SetActive(true);

        // Gravity points down, the sheet's front along z: turn gravity rather than the sheet.
        Physics.gravity = new Vector3(0, 0, -9.81f);
        ball.transform.localScale = new Vector3(0.2f, 0.2f, 0.2f);
        ball.transform.position = new Vector3(0.2f, 0.1f, 1);
        ball.AddComponent<Rigidbody>().mass = 0.4f; // 1.8 N s after a fall of 1 m: a dent of 4 cm
    }

    /// <summary>The sheet, and as its one example the same sheet with a dent of 5 cm in the middle.</summary>
    private static CrumpleSet CreateSheet()
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
        using (ExampleSet made = context.CreateExampleSet(def)) return CrumpleSet.FromBaked(made.Save());
    }
}
