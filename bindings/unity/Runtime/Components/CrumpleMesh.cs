using System;
using UnityEngine;

namespace Crumple
{
    /// <summary>Who writes the vertices of a <see cref="CrumpleMesh"/>.</summary>
    public enum CrumpleWriter
    {
        /// <summary>The GPU where it can, otherwise the CPU.</summary>
        Automatic,
        /// <summary>The CPU.</summary>
        Cpu,
        /// <summary>The GPU; where it cannot the CPU does, with a warning that says why.</summary>
        Gpu,
    }

    /// <summary>
    /// A body that collisions dent. Put it beside a MeshFilter and a collider; its rigidbody may be on a parent. Hits come from
    /// OnCollisionEnter and OnCollisionStay, or from <see cref="Hit"/>.
    /// </summary>
    [DisallowMultipleComponent]
    [AddComponentMenu("Physics/Crumple Mesh")]
    public sealed partial class CrumpleMesh : MonoBehaviour
    {
        [Tooltip("The mesh's examples: an imported .crumple file, or a .glb file with the importer CrumpleImporter.")]
        [SerializeField] private CrumpleSet set;
        [Tooltip("Shows the dents. Empty: the one of this object. Without a mesh it gets the set's own.")]
        [SerializeField] private MeshFilter target;
        [Tooltip("Who writes the vertices.")]
        [SerializeField] private CrumpleWriter writer = CrumpleWriter.Automatic;

        [Header("Material")]
        [Tooltip("How far a blow of 1 N s moves its contact, m. Unused if an example knows its blow.")]
        [Min(0)]
        [SerializeField] private float compliance = 0.02f;
        [Tooltip("Contacts with less impulse than this leave no dent, N s.")]
        [Min(0)]
        [SerializeField] private float yieldImpulse;
        [Tooltip("No vertex moves further than this, m. 0: the set's limit.")]
        [Min(0)]
        [SerializeField] private float depthLimit;

        [Header("Collisions")]
        [Tooltip("Take hits from this object's collisions.")]
        [SerializeField] private bool fromCollisions = true;

        [SerializeField, HideInInspector] private byte[] savedDamage = new byte[0];

        private Instance instance;
        private CrumpleWorld.Loaded loaded;
        private Mesh original; // what the filter showed before
        private Mesh mesh; // this component's own
        private MeshFilter filter;
        private CpuTarget cpu;
        private GpuTarget gpu;
        private bool changed;
        private bool warned;

        /// <summary>A hit arrived: what became of it. The component may be destroyed in here.</summary>
        public event Action<CrumpleMesh, CrumpleHitResult> Dented;

        /// <summary>Who writes the vertices at the moment; Automatic: nobody, see <see cref="Problem"/>.</summary>
        public CrumpleWriter WrittenBy
        {
            get { return gpu != null ? CrumpleWriter.Gpu : cpu != null ? CrumpleWriter.Cpu : CrumpleWriter.Automatic; }
        }

        /// <summary>Why it shows no dents; null where it does.</summary>
        public string Problem { get; private set; }

        /// <summary>Why the CPU writes, where the GPU was wanted; null otherwise.</summary>
        public string GpuProblem { get; private set; }

        /// <summary>
        /// The body, to be used inside <see cref="CrumpleWorld.Enter"/>; null while there is a problem, or before the first enable.
        /// </summary>
        public Instance Instance
        {
            get { return instance; }
        }

        /// <summary>The examples. Another set begins without damage.</summary>
        public CrumpleSet Set
        {
            get { return set; }
            set
            {
                if (ReferenceEquals(set, value)) return;
                bool open = isActiveAndEnabled;
                Release();
                savedDamage = new byte[0];
                set = value;
                if (open) Open();
            }
        }

        /// <summary>Who writes the vertices. Counts from the next time that the component is enabled.</summary>
        public CrumpleWriter Writer
        {
            get { return writer; }
            set { writer = value; }
        }

        private void OnEnable()
        {
            if (instance == null) Open();
        }

        private void OnDestroy()
        {
            Release();
        }

        private void Open()
        {
            Problem = null;
            try
            {
                if (set == null)
                    throw new CrumpleSetupException("there is no example set: import a .crumple file, or a .glb file with CrumpleImporter, " +
                        "and set it");
                filter = target != null ? target : GetComponent<MeshFilter>();
                if (filter == null) throw new CrumpleSetupException("there is no MeshFilter to show the dents");
                original = CrumpleWorld.OriginalOf(filter.sharedMesh);
                loaded = CrumpleWorld.Load(set, original == null ? null : original);
                CrumpleInstanceDef def = CrumpleInstanceDef.Default;
                def.DepthLimit = depthLimit;
                def.Compliance = compliance;
                def.YieldImpulse = yieldImpulse;
                CrumpleContext context = CrumpleWorld.Context;
                using (CrumpleWorld.Enter())
                {
                    instance = context.CreateInstance(loaded.Set, in def);
                    if (savedDamage.Length > 0) instance.LoadDamage(savedDamage);
                }
                mesh = original == null ? set.CreateMesh() : Instantiate(original);
                mesh.name = (original == null ? set.name : original.name) + " (dented)";
                filter.sharedMesh = mesh;
                CrumpleWorld.Meshes.Add(this);
                OpenTarget();
                changed = true;
            }
            catch (CrumpleException error)
            {
                Fail(error);
            }
        }

        private void Fail(CrumpleException error)
        {
            Release();
            Problem = error.Message;
            Debug.LogError("CrumpleMesh '" + name + "': " + Problem, this);
        }

        private void OpenTarget()
        {
            GpuProblem = null;
            string why = null;
            uint device = writer == CrumpleWriter.Cpu ? 0 : CrumpleWorld.Device(out why);
            if (device != 0)
            {
                gpu = new GpuTarget(mesh, instance, loaded.Lod, device);
                if (gpu.Failure == null) return;
                why = gpu.Failure;
                gpu.Dispose();
                gpu = null;
            }
            UseCpu(why);
        }

        private void UseCpu(string why)
        {
            if (why != null)
            {
                GpuProblem = why;
                CrumpleWorld.SayOnce(writer == CrumpleWriter.Gpu, "the CPU writes the vertices, since " + why, this);
            }
            cpu = new CpuTarget(mesh, instance, loaded.Lod);
        }

        /// <summary>What <paramref name="shown"/> was made of, where it is this component's own mesh: a copy of a dented object
        /// begins there.</summary>
        internal bool Owns(Mesh shown, out Mesh madeOf)
        {
            madeOf = original;
            return mesh != null && ReferenceEquals(mesh, shown);
        }

        /// <summary>Ends everything native, keeps the damage for the next time, and shows the mesh as it was.</summary>
        internal void Release()
        {
            CrumpleWorld.Meshes.Remove(this);
            if (gpu != null) gpu.Dispose();
            if (cpu != null) cpu.Dispose();
            gpu = null;
            cpu = null;
            if (instance != null)
            {
                using (CrumpleWorld.Enter())
                {
                    savedDamage = instance.GetInfo().MarkCount > 0 ? instance.SaveDamage() : new byte[0];
                    instance.Dispose();
                }
                instance = null;
            }
            loaded = null;
            if (mesh == null) return;
            if (filter != null && ReferenceEquals(filter.sharedMesh, mesh)) filter.sharedMesh = original;
            if (Application.isPlaying) Destroy(mesh);
            else DestroyImmediate(mesh);
            mesh = null;
        }

        private void LateUpdate()
        {
            CrumpleWorld.EndStep();
            if (instance == null) return;
            try
            {
                if (gpu != null) FollowDevice();
                if (!changed || gpu != null && gpu.Lost) return;
                changed = false;
                if (gpu != null) gpu.Want();
                else cpu.Update();
            }
            catch (CrumpleException error)
            {
                Fail(error);
            }
        }

        // Bounds and failures come from the render thread a frame or more later; a device may be another one by now.
        private unsafe void FollowDevice()
        {
            uint device = UnityPlugin.crumple_unity_device(null, 0);
            if (device != 0 && gpu.Device != device)
            {
                gpu.Dispose();
                gpu = null;
                OpenTarget();
                changed = true;
                return;
            }
            gpu.Look();
            if (gpu.Failure == null) return;
            string why = gpu.Failure;
            gpu.Dispose();
            gpu = null;
            UseCpu(why);
            changed = true;
        }

        /// <summary>Every dent keeps this share of its depth, 0 (as new) to 1.</summary>
        public void Repair(float keep)
        {
            using (CrumpleWorld.Enter()) Opened().RepairDamage(keep);
            changed = true;
        }

        /// <summary>Makes it as new.</summary>
        public void ResetDamage()
        {
            using (CrumpleWorld.Enter()) Opened().ResetDamage();
            changed = true;
        }

        /// <summary>The damage as bytes: for saved games, and to send over a network.</summary>
        public byte[] SaveDamage()
        {
            using (CrumpleWorld.Enter()) return Opened().SaveDamage();
        }

        /// <summary>Takes the damage that <see cref="SaveDamage"/> gave, here or on another machine.</summary>
        public void LoadDamage(byte[] damage)
        {
            using (CrumpleWorld.Enter()) Opened().LoadDamage(damage);
            changed = true;
        }

        private Instance Opened()
        {
            if (instance == null)
                throw new InvalidOperationException("CrumpleMesh '" + name + "' is not open: " + (Problem ?? "it was never enabled"));
            return instance;
        }
    }
}
