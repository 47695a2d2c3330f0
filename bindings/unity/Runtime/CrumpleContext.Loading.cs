using System;
using System.Collections.Generic;
using System.Runtime.InteropServices;
using Crumple.Native;

namespace Crumple
{
    public sealed partial class CrumpleContext
    {
        /// <summary>
        /// Makes an example set from arrays, which are copied. Takes a moment: load before the scene starts, on a context of its
        /// own thread if need be.
        /// </summary>
        public unsafe ExampleSet CreateExampleSet(ExampleSetDef def)
        {
            if (def == null) throw new ArgumentNullException("def");
            using (Pins pins = new Pins())
            {
                CrumpleMeshDef mesh = CrumpleMeshDef.Default;
                mesh.VertexCount = MeshDef.Count(def.VertexCount, "VertexCount");
                mesh.Positions = pins.Input(def.Positions);
                mesh.Normals = pins.Input(def.Normals);
                mesh.Tangents = pins.Input(def.Tangents);
                mesh.Indices = pins.Input(def.Indices);
                mesh.IndexCount = MeshDef.Count(def.IndexCount, "IndexCount");
                mesh.IndexType = def.IndexType;
                CrumpleExampleSetDef native = CrumpleExampleSetDef.Default;
                native.Mesh = (IntPtr)(&mesh);
                native.Options = def.Options;
                if (def.VertexMasses != null) native.Options.VertexMasses = pins.Input(StridedArray.Of(def.VertexMasses));
                CrumpleExampleDef[] examples = new CrumpleExampleDef[def.Examples.Count];
                for (int i = 0; i < examples.Length; i++) examples[i] = def.Examples[i].ToNative(pins);
                native.Examples = pins.Pin(examples);
                native.ExampleCount = (uint)examples.Length;
                CrumpleExampleSet id;
                using (Call call = EnterAlone(this))
                    call.Check(NativeMethods.crumple_example_set_create(call.Context, &native, &id),
                        "crumple_example_set_create");
                return new ExampleSet(this, id);
            }
        }

        /// <summary>
        /// Makes an example set from a mesh of a glTF 2.0 or GLB file and its morph targets.
        /// </summary>
        /// <param name="path">The file.</param>
        /// <param name="meshName">Name of the mesh; null: <paramref name="meshIndex"/> decides.</param>
        /// <param name="meshIndex">Index of the mesh; -1: the first that has morph targets.</param>
        /// <param name="options">How the set is made ready; null: the defaults.</param>
        /// <param name="joinNodes">Join the meshes of all nodes to one body of parts; see <see cref="ExampleSet.FindPart"/>.</param>
        public unsafe ExampleSet LoadGltf(string path, string meshName = null, int meshIndex = -1,
            CrumpleExampleSetOptions? options = null, bool joinNodes = false)
        {
            if (path == null) throw new ArgumentNullException("path");
            using (Pins pins = new Pins())
            {
                CrumpleGltfDef def = Gltf(pins, path, meshName, meshIndex, options, joinNodes);
                CrumpleExampleSet id;
                using (Call call = EnterAlone(this))
                    call.Check(NativeMethods.crumple_example_set_load_gltf(call.Context, &def, &id),
                        "crumple_example_set_load_gltf");
                return new ExampleSet(this, id);
            }
        }

        /// <summary>
        /// The same from the bytes of a file, read during the call only.
        /// </summary>
        /// <param name="bytes">The file's bytes.</param>
        /// <param name="folder">The folder that files named in it are relative to; null: such files are an error.</param>
        /// <param name="meshName">Name of the mesh; null: <paramref name="meshIndex"/> decides.</param>
        /// <param name="meshIndex">Index of the mesh; -1: the first that has morph targets.</param>
        /// <param name="options">How the set is made ready; null: the defaults.</param>
        /// <param name="joinNodes">Join the meshes of all nodes to one body of parts; see <see cref="ExampleSet.FindPart"/>.</param>
        public unsafe ExampleSet LoadGltf(ReadOnlySpan<byte> bytes, string folder = null, string meshName = null, int meshIndex = -1,
            CrumpleExampleSetOptions? options = null, bool joinNodes = false)
        {
            using (Pins pins = new Pins())
            {
                CrumpleGltfDef def = Gltf(pins, folder, meshName, meshIndex, options, joinNodes);
                CrumpleExampleSet id;
                using (Call call = EnterAlone(this))
                fixed (byte* data = &MemoryMarshal.GetReference(bytes))
                    call.Check(NativeMethods.crumple_example_set_load_gltf_memory(call.Context, (IntPtr)data,
                        (UIntPtr)(uint)bytes.Length, &def, &id), "crumple_example_set_load_gltf_memory");
                return new ExampleSet(this, id);
            }
        }

        private static CrumpleGltfDef Gltf(Pins pins, string path, string meshName, int meshIndex, CrumpleExampleSetOptions? options,
            bool joinNodes)
        {
            CrumpleGltfDef def = CrumpleGltfDef.Default;
            def.Path = pins.Text(path);
            def.MeshName = pins.Text(meshName);
            if (meshIndex != -1) def.MeshIndex = MeshDef.Count(meshIndex, "meshIndex");
            if (options.HasValue) def.Options = options.Value;
            def.JoinNodes = joinNodes;
            return def;
        }

        /// <summary>
        /// Makes an example set from a base OBJ file and one OBJ file an example, which has the base's vertices in the base's
        /// order.
        /// </summary>
        public unsafe ExampleSet LoadObj(string basePath, IReadOnlyList<string> examplePaths, CrumpleExampleSetOptions? options = null)
        {
            if (basePath == null) throw new ArgumentNullException("basePath");
            if (examplePaths == null) throw new ArgumentNullException("examplePaths");
            using (Pins pins = new Pins())
            {
                IntPtr[] paths = new IntPtr[examplePaths.Count];
                for (int i = 0; i < paths.Length; i++) paths[i] = pins.Text(examplePaths[i]);
                CrumpleObjDef def = CrumpleObjDef.Default;
                def.BasePath = pins.Text(basePath);
                def.ExamplePaths = pins.Pin(paths);
                def.ExampleCount = (uint)paths.Length;
                if (options.HasValue) def.Options = options.Value;
                CrumpleExampleSet id;
                using (Call call = EnterAlone(this))
                    call.Check(NativeMethods.crumple_example_set_load_obj(call.Context, &def, &id),
                        "crumple_example_set_load_obj");
                return new ExampleSet(this, id);
            }
        }

        /// <summary>
        /// Makes an example set from the bytes of a .crumple file, which are copied: at once, since nothing is built or unpacked.
        /// </summary>
        public unsafe ExampleSet LoadBaked(ReadOnlySpan<byte> bytes)
        {
            fixed (byte* data = &MemoryMarshal.GetReference(bytes))
                return LoadBaked((IntPtr)data, bytes.Length, CrumpleBytes.Copy);
        }

        /// <summary>
        /// The same from memory of your own, such as a memory map. With <see cref="CrumpleBytes.Keep"/> it is used where it lies,
        /// and must stay there, unchanged, until the set and all its instances are disposed of, or the context.
        /// </summary>
        public unsafe ExampleSet LoadBaked(IntPtr data, long size, CrumpleBytes bytes)
        {
            if (size < 0) throw new ArgumentOutOfRangeException("size", size, "a size is not negative");
            CrumpleExampleSet id;
            using (Call call = EnterAlone(this))
                call.Check(NativeMethods.crumple_example_set_load_baked_memory(call.Context, data, (UIntPtr)(ulong)size, bytes, &id),
                    "crumple_example_set_load_baked_memory");
            return new ExampleSet(this, id);
        }

        /// <summary>The same from a file, which is read into memory.</summary>
        public unsafe ExampleSet LoadBakedFile(string path)
        {
            if (path == null) throw new ArgumentNullException("path");
            using (Pins pins = new Pins())
            {
                CrumpleExampleSet id;
                using (Call call = EnterAlone(this))
                    call.Check(NativeMethods.crumple_example_set_load_baked(call.Context, pins.Text(path), &id),
                        "crumple_example_set_load_baked");
                return new ExampleSet(this, id);
            }
        }
    }
}
