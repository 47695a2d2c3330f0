// The component on the GPU: C#, the plugin, and a Vulkan device; only Unity itself is played.
using System;
using NUnit.Framework;
using StandIn;
using UnityEngine;

namespace Crumple.Tests
{
    public sealed class GpuTests
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

        private static Mesh Shown(CrumpleMesh mesh) { return mesh.GetComponent<MeshFilter>().sharedMesh; }

        private static void ExpectSame(CrumpleMesh gpu, CrumpleMesh cpu)
        {
            Assert.AreEqual(CrumpleWriter.Gpu, gpu.WrittenBy);
            Assert.AreEqual(CrumpleWriter.Cpu, cpu.WrittenBy);
            byte[] device = Gpu.Read(Shown(gpu)), memory = Shown(cpu).Stream(0);
            for (int i = 0; i < memory.Length; i++)
                if (device[i] != memory[i]) Assert.Fail("byte " + i + " is " + device[i] + " on the device and " + memory[i] + " on the CPU");
        }

        [Test]
        public void TheDeviceWritesWhatTheCpuWrites()
        {
            CrumpleMesh gpu = Sheet.Create(set, CrumpleWriter.Gpu), cpu = Sheet.Create(set);
            for (int i = 0; i < 10; i++)
            {
                foreach (CrumpleMesh mesh in new[] { gpu, cpu }) mesh.Hit(new Vector3(0.08f * i - 0.4f, 0.1f, 0), new Vector3(0, 0, -1));
                Engine.Frame();
            }
            ExpectSame(gpu, cpu);
            Engine.Frame();
            Assert.IsTrue(Sheet.Depth(cpu) > 0.01f && Shown(gpu).bounds.min.z <= -Sheet.Depth(cpu));
            gpu.ResetDamage();
            cpu.ResetDamage();
            Engine.Frame();
            ExpectSame(gpu, cpu);
        }

        [Test]
        public void NothingIsIssuedWhereNothingHappens()
        {
            CrumpleMesh gpu = Sheet.Create(set, CrumpleWriter.Automatic);
            for (int i = 0; i < 10 && (i == 0 || Gpu.Pending > 0); i++)
            {
                Gpu.Read(Shown(gpu)); // all frames are done
                Engine.Frame();
            }
            Assert.AreEqual(CrumpleWriter.Gpu, gpu.WrittenBy);
            Assert.AreEqual(0u, Gpu.Pending);
        }

        [Test]
        public void ADeviceIsLostAndDamageIsNot()
        {
            CrumpleMesh gpu = Sheet.Create(set, CrumpleWriter.Gpu), cpu = Sheet.Create(set);
            foreach (CrumpleMesh mesh in new[] { gpu, cpu }) mesh.Hit(Vector3.zero, new Vector3(0, 0, -2));
            Engine.Frame();
            Gpu.EndDevice();
            Engine.Frame();
            Engine.Frame();
            foreach (CrumpleMesh mesh in new[] { gpu, cpu }) mesh.Hit(new Vector3(0.2f, 0.1f, 0), new Vector3(0, 0, -2));
            Engine.Frame();
            Gpu.BeginDevice();
            Engine.Frame();
            Engine.Frame();
            ExpectSame(gpu, cpu);
        }

        [Test]
        public void WhatTheDeviceRefusesTheCpuWritesAndSaysWhy()
        {
            Gpu.WithoutRaw = true;
            CrumpleMesh mesh = Sheet.Create(set, CrumpleWriter.Gpu);
            mesh.Hit(Vector3.zero, new Vector3(0, 0, -2));
            Engine.Frame(); // the event finds it out
            Engine.Frame(); // the component hears of it
            Gpu.WithoutRaw = false;
            Assert.AreEqual(CrumpleWriter.Cpu, mesh.WrittenBy);
            Assert.IsTrue(mesh.GpuProblem.Contains("VK_BUFFER_USAGE_STORAGE_BUFFER_BIT"));
            Assert.AreEqual(0.04, Sheet.Depth(mesh), 1e-4);
            Assert.IsTrue(Array.Exists(Engine.Console(), line => line.StartsWith("warning: ") && line.Contains("the CPU writes the vertices")));
        }

        [Test]
        public void DestroyedAndReloadedWithFramesInFlight()
        {
            for (int i = 0; i < 2; i++)
            {
                CrumpleMesh gone = Sheet.Create(set, CrumpleWriter.Gpu), stays = Sheet.Create(set, CrumpleWriter.Gpu);
                gone.Dented += (mesh, hit) => UnityEngine.Object.DestroyImmediate(mesh.gameObject);
                stays.Hit(Vector3.zero, new Vector3(0, 0, -2));
                Engine.Frame();
                gone.Hit(Vector3.zero, new Vector3(0, 0, -2));
                Engine.Frame();
                Engine.ReloadScripts();
                CrumpleWorld.Shutdown();
                stays.enabled = false;
                stays.enabled = true;
                Engine.Frame();
                CrumpleMesh cpu = Sheet.Create(set);
                cpu.Hit(Vector3.zero, new Vector3(0, 0, -2));
                Engine.Frame();
                ExpectSame(stays, cpu);
                Engine.Clear();
            }
        }

        [Test]
        public void FramesAllocateNothing()
        {
            CrumpleMesh mesh = Sheet.Create(set, CrumpleWriter.Gpu);
            Action frames = () =>
            {
                for (int i = 0; i < 100; i++)
                {
                    mesh.Hit(new Vector3(0.001f * i, 0.1f, 0), new Vector3(0, 0, -0.5f));
                    Engine.Frame();
                }
            };
            frames();
            long before = GC.GetAllocatedBytesForCurrentThread();
            frames();
            long bytes = GC.GetAllocatedBytesForCurrentThread() - before;
            if (bytes > 0) Assert.Fail(bytes + " bytes in 100 frames");
        }
    }
}
