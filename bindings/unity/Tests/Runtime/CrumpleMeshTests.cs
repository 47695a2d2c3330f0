using System.Collections;
using System.Text.RegularExpressions;
using NUnit.Framework;
using UnityEngine;
using UnityEngine.Rendering;
using UnityEngine.TestTools;

namespace Crumple.Tests
{
    /// <summary>What a component does from hit to vertex, on the CPU. For Unity's test runner.</summary>
    public sealed class CrumpleMeshTests
    {
        private CrumpleSet set;

        [SetUp]
        public void SetUp()
        {
            set = Sheet.CreateSet();
        }

        [TearDown]
        public void TearDown()
        {
            CrumpleWorld.Shutdown();
        }

        [UnityTest]
        public IEnumerator AHitDentsByImpulseTimesDurationOverMass()
        {
            CrumpleMesh mesh = Sheet.Create(set);
            yield return null;
            Assert.AreEqual(CrumpleWriter.Cpu, mesh.WrittenBy);
            Assert.AreEqual(0f, Sheet.Depth(mesh));
            CrumpleHitResult? told = mesh.Hit(new Vector3(0.25f, 0, 0), new Vector3(0, 0, -2));
            Assert.AreEqual(CrumpleHitStatus.Marked, told.Value.Status);
            yield return null;
            Assert.AreEqual(0.04f, Sheet.Depth(mesh), 1e-4f); // 2 N s * 10 ms / 0.5 kg
            Bounds bounds = mesh.GetComponent<MeshFilter>().sharedMesh.bounds;
            Assert.AreEqual(-0.04f, bounds.min.z, 1e-3f);
            Object.DestroyImmediate(mesh.gameObject);
        }

        [UnityTest]
        public IEnumerator DamageIsSavedRepairedAndReset()
        {
            CrumpleMesh mesh = Sheet.Create(set), other = Sheet.Create(set);
            mesh.Hit(Vector3.zero, new Vector3(0, 0, -2));
            byte[] saved = mesh.SaveDamage();
            other.LoadDamage(saved);
            yield return null;
            float depth = Sheet.Depth(mesh);
            Assert.AreEqual(0.04f, depth, 1e-4f);
            Assert.AreEqual(depth, Sheet.Depth(other));
            mesh.Repair(0.5f);
            yield return null;
            Assert.AreEqual(0.5f * depth, Sheet.Depth(mesh), 1e-3f);
            mesh.ResetDamage();
            yield return null;
            Assert.AreEqual(0f, Sheet.Depth(mesh));
            Object.DestroyImmediate(mesh.gameObject);
            Object.DestroyImmediate(other.gameObject);
        }

        [UnityTest]
        public IEnumerator DamageOutlivesAShutdownAndTheMeshIsGivenBack()
        {
            Mesh own = set.CreateMesh();
            CrumpleMesh mesh = Sheet.Create(set, CrumpleWriter.Cpu, own);
            MeshFilter filter = mesh.GetComponent<MeshFilter>();
            mesh.Hit(Vector3.zero, new Vector3(0, 0, -2));
            yield return null;
            Assert.IsTrue(filter.sharedMesh != own);
            CrumpleWorld.Shutdown();
            Assert.IsTrue(filter.sharedMesh == own);
            Assert.AreEqual(0, CrumpleWorld.MeshCount);
            Assert.AreEqual(0f, Sheet.Depth(mesh));
            yield return null; // nothing to do
            mesh.enabled = false;
            mesh.enabled = true;
            yield return null;
            Assert.AreEqual(0.04f, Sheet.Depth(mesh), 1e-4f);
            Object.DestroyImmediate(mesh.gameObject);
            Assert.AreEqual(0, CrumpleWorld.MeshCount);
        }

        [UnityTest]
        public IEnumerator AMeshWithOtherVerticesIsBoundToTheSet()
        {
            Mesh quad = new Mesh();
            quad.name = "quad";
            quad.SetVertexBufferParams(5, new VertexAttributeDescriptor(VertexAttribute.Position), new VertexAttributeDescriptor(VertexAttribute.Normal),
                new VertexAttributeDescriptor(VertexAttribute.TexCoord0, VertexAttributeFormat.Float32, 2));
            float[] vertices =
            {
                -0.5f, -0.5f, 0, 0, 0, 1, 0, 0,
                0.5f, -0.5f, 0, 0, 0, 1, 1, 0,
                0.5f, 0.5f, 0, 0, 0, 1, 1, 1,
                -0.5f, 0.5f, 0, 0, 0, 1, 0, 1,
                0, 0, 0, 0, 0, 1, 0.5f, 0.5f,
            };
            quad.SetVertexBufferData(vertices, 0, 0, vertices.Length);
            quad.SetIndexBufferParams(12, IndexFormat.UInt32);
            quad.SetIndexBufferData(new uint[] { 0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4 }, 0, 0, 12);
            quad.subMeshCount = 1;
            quad.SetSubMesh(0, new SubMeshDescriptor(0, 12));
            CrumpleMesh mesh = Sheet.Create(set, CrumpleWriter.Cpu, quad);
            mesh.Hit(Vector3.zero, new Vector3(0, 0, -2));
            yield return null;
            Assert.IsNull(mesh.Problem);
            Assert.AreEqual(0.04f, Sheet.Depth(mesh), 1e-4f);
            Object.DestroyImmediate(mesh.gameObject);
        }

        [Test]
        public void WhatIsWrongIsNamed()
        {
            LogAssert.Expect(LogType.Error, new Regex("there is no example set"));
            CrumpleMesh mesh = Sheet.Create(null);
            Assert.IsTrue(mesh.Problem.Contains("there is no example set"));
            Assert.IsNull(mesh.Hit(Vector3.zero, Vector3.one));
            Assert.Throws<System.InvalidOperationException>(() => mesh.ResetDamage());
            Object.DestroyImmediate(mesh.gameObject);

            Mesh sealed_ = set.CreateMesh();
            sealed_.name = "sealed";
            sealed_.UploadMeshData(true);
            LogAssert.Expect(LogType.Error, new Regex("mesh 'sealed' is not readable: tick Read/Write"));
            Object.DestroyImmediate(Sheet.Create(set, CrumpleWriter.Cpu, sealed_).gameObject);

            Mesh elsewhere = set.CreateMesh();
            elsewhere.name = "elsewhere";
            float[] far = new float[6 * Sheet.Side * Sheet.Side];
            for (int i = 0; i < far.Length; i++) far[i] = 30;
            elsewhere.SetVertexBufferData(far, 0, 0, far.Length);
            LogAssert.Expect(LogType.Error, new Regex("mesh 'elsewhere' does not lie where example set 'sheet' does"));
            Object.DestroyImmediate(Sheet.Create(set, CrumpleWriter.Cpu, elsewhere).gameObject);

            CrumpleException error = Assert.Throws<CrumpleException>(() => CrumpleSet.FromBaked(new byte[100]));
            Assert.AreEqual(CrumpleResult.ErrorFormat, error.Result);
        }

        [Test]
        public void AHitFarOffIsSaidOnce()
        {
            CrumpleMesh mesh = Sheet.Create(set);
            LogAssert.Expect(LogType.Warning, new Regex("a hit was not taken"));
            Assert.IsNull(mesh.Hit(new Vector3(100, 0, 0), Vector3.up));
            Assert.IsNull(mesh.Hit(new Vector3(100, 0, 0), Vector3.up));
            Object.DestroyImmediate(mesh.gameObject);
        }
    }
}
