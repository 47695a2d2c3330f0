// What cannot be driven from inside Unity's own test runner: collisions, reloads, imports, and what a frame uploads and
// allocates.
using System;
using System.Collections.Generic;
using System.IO;
using Crumple.Editor;
using NUnit.Framework;
using StandIn;
using UnityEditor.AssetImporters;
using UnityEngine;
using UnityEngine.Rendering;

namespace Crumple.Tests
{
    public sealed class CollisionTests
    {
        private CrumpleSet set;
        private CrumpleMesh mesh;
        private Collider own, ball;

        [SetUp]
        public void SetUp()
        {
            set = Sheet.CreateSet();
            Create();
            ball = Ball();
        }

        private void Create()
        {
            mesh = Sheet.Create(set);
            own = mesh.gameObject.AddComponent<BoxCollider>();
        }

        private static Collider Ball()
        {
            GameObject made = new GameObject("Ball");
            made.AddComponent<Rigidbody>().mass = 0.4f;
            return made.AddComponent<SphereCollider>();
        }

        [TearDown]
        public void TearDown()
        {
            Engine.Clear();
            CrumpleWorld.Shutdown();
        }

        // A step in which the ball, which comes at so many m/s, gives an impulse.
        private void Step(string what, float impulse, float speed, params Vector3[] points)
        {
            Vector3 normal = new Vector3(0, 0, -1);
            Engine.Step(mesh.gameObject, what, Engine.Touch(own, ball, normal * -impulse, normal * speed, normal, points));
        }

        [Test]
        public void AContactInPartsMakesTheDentOfTheWhole()
        {
            Step("OnCollisionEnter", -0.5f, 5, new Vector3(0.19f, 0, 0), new Vector3(0.21f, 0, 0));
            Step("OnCollisionStay", -0.5f, 5, new Vector3(0.2f, 0, 0));
            Step("OnCollisionStay", 1, -5, new Vector3(0.2f, 0, 0)); // told of the other body
            Engine.Frame();
            Assert.AreEqual(0.04, Sheet.Depth(mesh), 1e-4); // 2 N s in all
            Assert.AreEqual(1u, mesh.Instance.GetInfo().MarkCount);
            for (int i = 0; i < 4; i++) Engine.Step();
            Step("OnCollisionEnter", -0.5f, 5, new Vector3(0.2f, 0, 0));
            Engine.Frame();
            Assert.AreEqual(2UL, CrumpleWorld.Context.ContactTotals().Begun); // another blow at the same place
            Step("OnCollisionEnter", -0.5f, 5, new Vector3(-0.2f, 0, 0));
            Engine.Frame();
            Assert.AreEqual(3UL, CrumpleWorld.Context.ContactTotals().Begun);
        }

        [Test]
        public void TheDentIsThereInTheFrameOfItsStep()
        {
            int told = 0;
            mesh.Dented += (dented, hit) => told++;
            Step("OnCollisionEnter", -1, 5, Vector3.zero);
            Assert.AreEqual(0, told); // the step has not ended
            Engine.Frame();
            Assert.AreEqual(1, told);
            Assert.AreEqual(0.02, Sheet.Depth(mesh), 1e-4);
            Engine.Frame();
            Engine.Step();
            Assert.AreEqual(1, told);
            Assert.AreEqual(1UL, CrumpleWorld.Context.ContactTotals().Points);
        }

        [Test]
        public void OfTwoBodiesThatDentBothTellAndEachIsStruckOnce()
        {
            CrumpleMesh below = Sheet.Create(set);
            below.transform.localScale = new Vector3(1, 1, -1); // its front is down
            Collider other = below.gameObject.AddComponent<BoxCollider>();
            int told = 0;
            mesh.Dented += (dented, hit) => told++;
            below.Dented += (dented, hit) => told += 10;
            Vector3 up = new Vector3(0, 0, 1);
            Engine.Step(mesh.gameObject, "OnCollisionEnter", Engine.Touch(own, other, up, up * 5, up * -1, Vector3.zero));
            Engine.Tell(below.gameObject, "OnCollisionEnter", Engine.Touch(other, own, up, up * 5, up, Vector3.zero));
            Engine.Frame();
            Assert.AreEqual(11, told);
            Assert.AreEqual(0.02, Sheet.Depth(mesh), 1e-4);
            Assert.AreEqual(0.02, Sheet.Depth(below), 1e-4);
        }

        [Test]
        public void AStrikersMomentumIsItsImpulse()
        {
            CrumpleHitResult known = mesh.Hit(new Vector3(0.2f, 0, 0), new Vector3(0, 0, -1)).Value;
            CrumpleHitResult striker = mesh.Hit(new Vector3(0.2f, 0, 0), Vector3.zero, new Vector3(0, 0, 1), 4,
                new Vector3(0, 0, -0.25f), 0.1f).Value;
            Assert.AreEqual(known.Target.Z, striker.Target.Z);
            Assert.AreEqual(CrumpleHitStatus.Marked, striker.Status);
        }

        [Test]
        public void WhatRestsDoesNotDent()
        {
            Step("OnCollisionEnter", -0.5f, 5, Vector3.zero);
            for (int i = 0; i < 500; i++) Step("OnCollisionStay", -0.5f, 0.2f, Vector3.zero); // gravity of a step of 20 ms
            Engine.Frame();
            Assert.AreEqual(0.01, Sheet.Depth(mesh), 1e-4);
            mesh.ResetDamage();
            for (int i = 0; i < 500; i++) Step("OnCollisionStay", -0.5f, 0.2f, Vector3.zero);
            Engine.Frame();
            Assert.AreEqual(0.0, Sheet.Depth(mesh), 0.0);
            Assert.AreEqual(1UL, CrumpleWorld.Context.ContactTotals().Hits);
        }

        [Test]
        public void ScaleAndPositionOfTheObjectCount()
        {
            mesh.transform.position = new Vector3(10, 0, 0);
            mesh.transform.localScale = new Vector3(2, 2, 2);
            Step("OnCollisionEnter", -2, 5, new Vector3(10.4f, 0, 0));
            Engine.Frame();
            Assert.AreEqual(0.02, Sheet.Depth(mesh), 1e-4); // 40 mm in the world
            mesh.enabled = false;
            Step("OnCollisionEnter", -2, 5, new Vector3(9, 0, 0)); // is told, and not taken
            mesh.enabled = true;
            using (CrumpleWorld.Enter()) Assert.AreEqual(1u, mesh.Instance.GetInfo().MarkCount);
        }

        [Test]
        public void TheComponentMayBeDestroyedInACallback()
        {
            mesh.Dented += (dented, hit) => UnityEngine.Object.DestroyImmediate(dented.gameObject);
            Step("OnCollisionEnter", -2, 5, Vector3.zero);
            Step("OnCollisionStay", -2, 5, Vector3.zero);
            Engine.Frame();
            Assert.IsTrue(mesh == null);
            Assert.AreEqual(0, CrumpleWorld.MeshCount);
            Create();
            mesh.Dented += (dented, hit) => UnityEngine.Object.Destroy(dented);
            Step("OnCollisionEnter", -2, 5, Vector3.zero);
            Engine.Frame();
            Assert.AreEqual(0, CrumpleWorld.MeshCount);
            Create();
            int told = 0;
            mesh.Dented += (dented, hit) => told++;
            mesh.Dented += (dented, hit) => CrumpleWorld.Shutdown();
            Step("OnCollisionEnter", -2, 5, Vector3.zero, new Vector3(0.4f, 0, 0));
            Step("OnCollisionStay", -2, 5, Vector3.zero);
            Engine.Frame();
            Assert.AreEqual(1, told); // of two hits
        }

        [Test]
        public void WhatIsRefusedIsSaidOnce()
        {
            Engine.Console();
            for (int i = 0; i < 3; i++)
            {
                Step("OnCollisionEnter", -2, 5, new Vector3(100, 0, 0));
                Engine.Frame();
            }
            string[] lines = Engine.Console();
            if (lines.Length != 1 || !lines[0].Contains("a hit was not taken: ErrorContactTooFar")) Assert.Fail(string.Join(" | ", lines));
        }

        [Test]
        public void CollidersThatVanishAreForgotten()
        {
            for (int i = 0; i < 1000; i++)
            {
                ball = Ball();
                Step("OnCollisionEnter", -0.1f, 5, new Vector3(0.1f, 0.1f, 0));
            }
            Engine.Frame();
            Assert.IsTrue(mesh.Instance.GetInfo().ContactCount <= 256);
            Assert.IsTrue(CrumpleWorld.Context.ContactTotals().Open < 10);
            ball = null;
            Step("OnCollisionEnter", -0.1f, 5, Vector3.zero); // the collider is gone within the step
            Engine.Frame();
            Assert.AreEqual(1001UL, CrumpleWorld.Context.ContactTotals().Hits);
        }

        [Test]
        public void StepsAllocateNothing()
        {
            Vector3 normal = new Vector3(0, 0, -1);
            Collision collision = Engine.Touch(own, ball, normal * 0.5f, normal * 5, normal, Vector3.zero, new Vector3(0.3f, 0, 0));
            Action steps = () =>
            {
                for (int i = 0; i < 300; i++)
                {
                    CrumpleWorld.BeginStep();
                    CrumpleWorld.Report(collision, mesh, null);
                    CrumpleWorld.EndStep();
                }
            };
            steps();
            long before = GC.GetAllocatedBytesForCurrentThread();
            steps();
            long bytes = GC.GetAllocatedBytesForCurrentThread() - before;
            if (bytes > 0) Assert.Fail(bytes + " bytes in 300 steps");
        }
    }

    public sealed class LifeTests
    {
        private CrumpleSet set;

        [SetUp]
        public void SetUp() { set = Sheet.CreateSet(); }

        [TearDown]
        public void TearDown()
        {
            Engine.Clear();
            CrumpleWorld.Shutdown();
        }

        [Test]
        public void ScriptsAreReloadedAndDamageStays()
        {
            Type hook = typeof(CrumpleImporter).Assembly.GetType("Crumple.Editor.CrumpleReload");
            System.Runtime.CompilerServices.RuntimeHelpers.RunClassConstructor(hook.TypeHandle);
            CrumpleMesh mesh = Sheet.Create(set);
            CrumpleContext own = new CrumpleContext();
            mesh.Hit(Vector3.zero, new Vector3(0, 0, -2));
            Engine.Frame();
            CrumpleContext before = CrumpleWorld.Context;
            Engine.ReloadScripts();
            Assert.IsTrue(before.IsDisposed && own.IsDisposed && CrumpleWorld.Context != before);
            Engine.Frame();
            Assert.AreEqual(0.04, Sheet.Depth(mesh), 1e-4);
            Application.Quit();
            Assert.AreEqual(0, CrumpleWorld.MeshCount);
        }

        [Test]
        public void ScenesComeAndGo()
        {
            for (int i = 0; i < 20; i++)
            {
                CrumpleMesh a = Sheet.Create(set), b = Sheet.Create(set);
                a.Hit(Vector3.zero, new Vector3(0, 0, -2));
                Engine.Frame();
                Assert.AreEqual(0.0, Sheet.Depth(b), 0.0);
                Engine.Clear();
                Assert.AreEqual(0, CrumpleWorld.MeshCount);
            }
        }

        [Test]
        public void ACopyOfADentedObjectBeginsAtRest()
        {
            Mesh shown = set.CreateMesh();
            CrumpleMesh first = Sheet.Create(set, CrumpleWriter.Cpu, shown);
            first.Hit(Vector3.zero, new Vector3(0, 0, -2));
            Engine.Frame();
            CrumpleMesh second = Sheet.Create(set, CrumpleWriter.Cpu, first.GetComponent<MeshFilter>().sharedMesh);
            Engine.Frame();
            Assert.IsNull(second.Problem);
            Assert.AreEqual(0.0, Sheet.Depth(second), 0.0);
            second.Set = set; // the same: nothing happens
            second.Set = Sheet.CreateSet();
            Assert.IsNull(second.Problem);
        }

        [Test]
        public void OnlyWhatChangedIsUploaded()
        {
            CrumpleMesh mesh = Sheet.Create(set);
            Mesh shown = mesh.GetComponent<MeshFilter>().sharedMesh;
            Engine.Frame();
            int all = Sheet.Side * Sheet.Side * 24;
            Assert.AreEqual(all, Bytes(shown));
            Engine.Frame();
            Assert.AreEqual(0, Bytes(shown));
            mesh.Hit(new Vector3(0.4f, 0.4f, 0), new Vector3(0, 0, -0.5f));
            Engine.Frame();
            int some = Bytes(shown);
            Assert.IsTrue(some > 0 && some < all);
        }

        private static int Bytes(Mesh mesh)
        {
            int sum = 0;
            foreach (KeyValuePair<int, int> upload in mesh.Uploads) sum += upload.Value;
            mesh.Uploads.Clear();
            return sum;
        }

        [Test]
        public void FramesAllocateNothing()
        {
            CrumpleMesh mesh = Sheet.Create(set);
            CrumpleHitDef none = CrumpleHitDef.Default;
            Action frames = () =>
            {
                for (int i = 0; i < 300; i++)
                {
                    mesh.Hit(new Vector3(0.001f * i, 0.1f, 0), new Vector3(0, 0, -0.5f));
                    Engine.Frame();
                    mesh.GetComponent<MeshFilter>().sharedMesh.Uploads.Clear();
                }
            };
            frames();
            long before = GC.GetAllocatedBytesForCurrentThread();
            frames();
            long bytes = GC.GetAllocatedBytesForCurrentThread() - before;
            if (bytes > 0) Assert.Fail(bytes + " bytes in 300 frames");
        }

        [Test]
        public void LayoutsThatTheCpuDoesNotWriteAreNamed()
        {
            Expect("mesh 'half' has positions in Float16 x 4; on the CPU Crumple writes Float32 x 3", "half",
                new VertexAttributeDescriptor(VertexAttribute.Position, VertexAttributeFormat.Float16, 4));
            Expect("mesh 'packed' has normals in SNorm8 x 4; on the CPU Crumple writes Float32 x 3", "packed",
                new VertexAttributeDescriptor(VertexAttribute.Position), new VertexAttributeDescriptor(VertexAttribute.Normal, VertexAttributeFormat.SNorm8, 4));
            Expect("mesh 'split' has its normals in vertex stream 1 and its positions in stream 0", "split",
                new VertexAttributeDescriptor(VertexAttribute.Position), new VertexAttributeDescriptor(VertexAttribute.Normal, VertexAttributeFormat.Float32, 3, 1));
            Expect("mesh 'bare' has no positions", "bare", new VertexAttributeDescriptor(VertexAttribute.Normal));
        }

        private static void Expect(string part, string name, params VertexAttributeDescriptor[] attributes)
        {
            Mesh mesh = new Mesh { name = name };
            mesh.SetVertexBufferParams(3, attributes);
            CrumpleSetupException error = Assert.Throws<CrumpleSetupException>(() => MeshLayout.Of(mesh).CheckForCpu(mesh));
            if (!error.Message.Contains(part)) Assert.Fail(error.Message);
        }

        [Test]
        public void WhereTheGpuCannotTheCpuDoesAndSaysWhyOnce()
        {
            CrumpleMesh mesh = Sheet.Create(set, CrumpleWriter.Gpu), other = Sheet.Create(set, CrumpleWriter.Gpu);
            Assert.AreEqual(CrumpleWriter.Cpu, mesh.WrittenBy);
            string[] lines = Array.FindAll(Engine.Console(), line => line.StartsWith("warning: "));
            Assert.AreEqual(1, lines.Length);
            Assert.IsTrue(lines[0].Contains(other.GpuProblem));
            if (!lines[0].Contains("Unity has not loaded crumple_unity as a plugin")) Assert.Fail(lines[0]);
            mesh.Hit(Vector3.zero, new Vector3(0, 0, -2));
            Engine.Frame();
            Assert.AreEqual(0.04, Sheet.Depth(mesh), 1e-4);
        }
    }

    public sealed class SampleTests
    {
        [TearDown]
        public void TearDown()
        {
            Engine.Clear();
            CrumpleWorld.Shutdown();
        }

        [Test]
        public void TheFirstDentIsAsDeepAsItSays()
        {
            FirstDent sample = new GameObject("Sample").AddComponent<FirstDent>();
            Engine.Frame();
            float speed = (float)Math.Sqrt(2 * 9.81);
            Collider ball = new GameObject("Ball").AddComponent<SphereCollider>();
            Vector3 down = new Vector3(0, 0, -1);
            Engine.Step(sample.Dented.gameObject, "OnCollisionEnter", Engine.Touch(sample.Dented.GetComponent<BoxCollider>(), ball,
                down * (0.4f * speed), down * speed, down, new Vector3(0.2f, 0.1f, 0)));
            Engine.Frame();
            Assert.AreEqual(0.02 * 0.4 * speed, Sheet.Depth(sample.Dented), 1e-3);
        }
    }

    public sealed class ImportTests
    {
        private static AssetImportContext Import(string path)
        {
            AssetImportContext context = new AssetImportContext { assetPath = path };
            new CrumpleImporter().OnImportAsset(context);
            return context;
        }

        private static void Refused(string path, string part)
        {
            AssetImportContext context = Import(path);
            Assert.IsTrue(context.Main == null);
            if (context.Errors.Count != 1 || !context.Errors[0].Contains(part) || !context.Errors[0].Contains(path))
                Assert.Fail(string.Join(" | ", context.Errors.ToArray()));
        }

        [Test]
        public void GlbAndCrumpleFilesBecomeSets()
        {
            AssetImportContext glb = Import(Path.Combine(Environment.GetEnvironmentVariable("CRUMPLE_ASSETS"), "hood.glb"));
            Assert.AreEqual(0, glb.Errors.Count);
            CrumpleSet set = (CrumpleSet)glb.Main;
            Assert.IsTrue(set.ExampleCount > 0 && set.DepthLimit > 0 && set.name == "hood");
            Assert.AreEqual(set.VertexCount, ((Mesh)glb.Objects["mesh"]).vertexCount);
            string baked = Path.Combine(Path.GetTempPath(), "crumple_unity_" + System.Diagnostics.Process.GetCurrentProcess().Id + ".crumple");
            File.WriteAllBytes(baked, set.Bytes);
            AssetImportContext again = Import(baked);
            File.Delete(baked);
            Assert.AreEqual(set.ExampleCount, ((CrumpleSet)again.Main).ExampleCount);
        }

        [Test]
        public void WhatCannotBeImportedIsNamed()
        {
            string plain = Path.Combine(Path.GetTempPath(), "crumple_unity_" + System.Diagnostics.Process.GetCurrentProcess().Id + ".glb");
            Refused("absent.glb", "cannot read");
            File.WriteAllBytes(plain, PlainGlb());
            Refused(plain, "morph target");
            File.WriteAllBytes(plain, new byte[] { 1, 2, 3 });
            Refused(plain, "ErrorFormat");
            File.Delete(plain);
        }

        // A triangle without morph targets.
        private static byte[] PlainGlb()
        {
            string json = "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":36}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}]," +
                "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\",\"min\":[0,0,0],\"max\":[1,1,0]}]," +
                "\"meshes\":[{\"name\":\"plain\",\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}]}";
            while (json.Length % 4 != 0) json += " ";
            MemoryStream made = new MemoryStream();
            BinaryWriter writer = new BinaryWriter(made);
            writer.Write(0x46546C67);
            writer.Write(2);
            writer.Write(12 + 8 + json.Length + 8 + 36);
            writer.Write(json.Length);
            writer.Write(0x4E4F534A);
            writer.Write(System.Text.Encoding.ASCII.GetBytes(json));
            writer.Write(36);
            writer.Write(0x004E4942);
            foreach (float value in new float[] { 0, 0, 0, 1, 0, 0, 0, 1, 0 }) writer.Write(value);
            return made.ToArray();
        }
    }
}
