// Generated from include/crumple.h by `cargo xtask header`; do not edit it.

using System;
using System.Runtime.InteropServices;

namespace Crumple.Native
{
    /// <summary>
    /// The functions of crumple.h as they are. Call <see cref="CrumpleRuntime.EnsureLoaded"/> before the first one: it tells
    /// what is wrong with a library that is missing or does not fit.
    /// </summary>
    public static unsafe class NativeMethods
    {
        /// <summary>
        /// Name of the native library, without what systems put before and after it.
        /// </summary>
#if (UNITY_IOS || UNITY_TVOS || UNITY_VISIONOS) && !UNITY_EDITOR
        public const string Library = "__Internal";
#else
        public const string Library = "crumple";
#endif

        /// <summary>
        /// Major version of this header. Programs built against another major version do not fit.
        /// </summary>
        public const uint VersionMajor = 0;

        /// <summary>
        /// Minor version of this header. Before 1.0, programs built against another minor version do not fit.
        /// </summary>
        public const uint VersionMinor = 1;

        /// <summary>
        /// Patch version of this header.
        /// </summary>
        public const uint VersionPatch = 0;

        /// <summary>
        /// The three as one number, as <see cref="Native.NativeMethods.crumple_version"/> gives it.
        /// </summary>
        public const uint Version = (((VersionMajor * 1000000) + (VersionMinor * 1000)) + VersionPatch);

        /// <summary>
        /// The version of the library that runs: major * 1000000 + minor * 1000 + patch. Compare it with
        /// <see cref="Native.NativeMethods.Version"/>, that of the header you compiled against. Never fails; any thread.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern uint crumple_version();

        /// <summary>
        /// The version of the library that runs as text, such as "0.1.0". Lives for ever. Never fails; any thread.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern IntPtr crumple_version_string();

        /// <summary>
        /// What this build of the library can do: the CRUMPLE_FEATURE_ bits, or-ed. Bits unknown to you may be set. Never fails;
        /// any thread.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ulong crumple_features();

        /// <summary>
        /// What was wrong in the calling thread's last failed call, and what would be right, as UTF-8:
        /// "<see cref="Native.NativeMethods.crumple_instance_create"/>: ...". Empty before the first failure; a call that
        /// succeeds leaves it. Valid until the thread's next failed call. At most 1023 bytes. Never null, never fails; any
        /// thread, each has its own text.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern IntPtr crumple_last_error();

        /// <summary>
        /// The name of a result, such as "<see cref="CrumpleResult.ErrorFormat"/>"; "unknown result" for a number that is none.
        /// Lives for ever. Never fails; any thread.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern IntPtr crumple_result_name(CrumpleResult result);

        /// <summary>
        /// An allocator def without functions: set both. Never fails; any thread.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleAllocatorDef crumple_allocator_def_default();

        /// <summary>
        /// Makes the library take all further memory from the host's functions, for the whole process; null goes back to the
        /// system's. May be called at any time: each piece of memory returns to the functions it came from, so those must stay
        /// callable until the last piece is back. Destroying all contexts returns all, except for a few kB a thread that contexts
        /// with threads of Crumple's own leave to the next ones for the life of the process. At most 15 different allocators in
        /// the life of a process.
        /// </summary>
        /// <remarks>
        /// <para>Any thread. Errors: <see cref="CrumpleResult.ErrorUnsupported"/> (a build without
        /// <see cref="CrumpleFeatures.HostAllocator"/>; see <see cref="Native.NativeMethods.crumple_features"/>),
        /// <see cref="CrumpleResult.ErrorStructSize"/>, <see cref="CrumpleResult.ErrorMisaligned"/>,
        /// <see cref="CrumpleResult.ErrorNullPointer"/> (a function is missing), <see cref="CrumpleResult.ErrorInvalidArgument"/>
        /// (a sixteenth allocator).</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_allocator_set(CrumpleAllocatorDef* allocator);

        /// <summary>
        /// The defaults: threads of Crumple's own, one for each core; no log. Never fails; any thread.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleContextDef crumple_context_def_default();

        /// <summary>
        /// Creates a context. def is copied; what its callbacks need must live until the context is destroyed.
        /// </summary>
        /// <remarks>
        /// <para>Any thread; contexts know nothing of each other. Errors: <see cref="CrumpleResult.ErrorNullPointer"/>,
        /// <see cref="CrumpleResult.ErrorMisaligned"/>, <see cref="CrumpleResult.ErrorStructSize"/>,
        /// <see cref="CrumpleResult.ErrorInvalidArgument"/> (more than 1024 threads; 65535 contexts are alive),
        /// <see cref="CrumpleResult.ErrorOutOfMemory"/> (the system starts no more threads).</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_context_create(CrumpleContextDef* def, IntPtr* outContext);

        /// <summary>
        /// Destroys a context and everything made in it. Your own memory is never freed, and is not touched afterwards. Every id
        /// of the context, and the context itself, is an error from then on.
        /// </summary>
        /// <remarks>
        /// <para>No other call with this context may be running. Where a Vulkan device is attached, it must still be there.
        /// Errors: <see cref="CrumpleResult.ErrorNullPointer"/>, <see cref="CrumpleResult.ErrorInvalidId"/> (destroyed already),
        /// <see cref="CrumpleResult.ErrorFramesInFlight"/> (see
        /// <see cref="Native.NativeMethods.crumple_vulkan_complete_frames"/>), <see cref="CrumpleResult.ErrorConcurrentUse"/>.
        /// Nothing was destroyed then.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_context_destroy(IntPtr context);

        /// <summary>
        /// An example without anything: set its positions. Never fails; any thread.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleExampleDef crumple_example_def_default();

        /// <summary>
        /// A set without anything: set its mesh and its examples. Never fails; any thread.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleExampleSetDef crumple_example_set_def_default();

        /// <summary>
        /// Makes an example set from arrays, which are copied: free them afterwards. Takes a moment (it indexes the mesh and
        /// samples every example), so load before the scene starts, on a context of its own thread if need be.
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised. Errors: <see cref="CrumpleResult.ErrorNullPointer"/>,
        /// <see cref="CrumpleResult.ErrorMisaligned"/>, <see cref="CrumpleResult.ErrorStructSize"/> (of def or of an example),
        /// <see cref="CrumpleResult.ErrorInvalidId"/>, <see cref="CrumpleResult.ErrorInvalidArgument"/> (an enumerator or a
        /// count, a stride smaller than an element, an option out of range), <see cref="CrumpleResult.ErrorBufferTooSmall"/> (an
        /// array has fewer bytes than its count needs), <see cref="CrumpleResult.ErrorNotFinite"/>,
        /// <see cref="CrumpleResult.ErrorIndexOutOfRange"/>, <see cref="CrumpleResult.ErrorMesh"/> (no vertices),
        /// <see cref="CrumpleResult.ErrorExampleMismatch"/> (no example, or one that does not fit the mesh),
        /// <see cref="CrumpleResult.ErrorOutOfMemory"/>, <see cref="CrumpleResult.ErrorConcurrentUse"/>.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_create(
            IntPtr context,
            CrumpleExampleSetDef* def,
            CrumpleExampleSet* outSet);

        /// <summary>
        /// A level of detail without anything: set its mesh. Never fails; any thread.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleLodDef crumple_lod_def_default();

        /// <summary>
        /// Adds another mesh of the same body that shows the same damage, such as a level of detail or a collision proxy. The
        /// arrays are copied. Its number, 1 for the first, is what <see cref="CrumpleHostBufferDef"/>.lod takes. Each of its
        /// vertices is bound to the nearest point of the base surface and moves as that does; one that stands on a base vertex
        /// moves exactly as that one. Contacts, marks, saved damage and the set's fingerprint stay those of the base mesh. All
        /// instances of the set know all of its levels, so add them before the first instance is made.
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised. Errors: <see cref="CrumpleResult.ErrorNullPointer"/>,
        /// <see cref="CrumpleResult.ErrorMisaligned"/>, <see cref="CrumpleResult.ErrorStructSize"/>,
        /// <see cref="CrumpleResult.ErrorInvalidId"/>, <see cref="CrumpleResult.ErrorInvalidArgument"/> (the set has instances;
        /// an enumerator, a count, or a stride smaller than an element), <see cref="CrumpleResult.ErrorBufferTooSmall"/> (an
        /// array has fewer bytes than its count needs), <see cref="CrumpleResult.ErrorNotFinite"/>,
        /// <see cref="CrumpleResult.ErrorIndexOutOfRange"/>, <see cref="CrumpleResult.ErrorMesh"/> (no vertices),
        /// <see cref="CrumpleResult.ErrorOutOfMemory"/>, <see cref="CrumpleResult.ErrorConcurrentUse"/>. The set is as it was
        /// then.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_add_lod(
            IntPtr context,
            CrumpleExampleSet set,
            CrumpleLodDef* def,
            uint* outLod);

        /// <summary>
        /// Ends a set's id. Its memory lives on as long as instances use it, and they keep working. Strings that the set's infos
        /// pointed to are gone.
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised. Errors: <see cref="CrumpleResult.ErrorNullPointer"/>,
        /// <see cref="CrumpleResult.ErrorInvalidId"/>, <see cref="CrumpleResult.ErrorConcurrentUse"/>.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_destroy(IntPtr context, CrumpleExampleSet set);

        /// <summary>
        /// The first mesh with morph targets, with default options; set the path. Never fails; any thread.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleGltfDef crumple_gltf_def_default();

        /// <summary>
        /// Default options; set the paths. Never fails; any thread.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleObjDef crumple_obj_def_default();

        /// <summary>
        /// Makes an example set from a glTF 2.0 or GLB file: a mesh with its morph targets, dense or sparse, all primitives
        /// joined (see <see cref="Native.NativeMethods.crumple_example_set_get_primitive"/>). Where the file has them, names come
        /// from mesh.extras.targetNames, contacts from mesh.extras.impacts and placements from mesh.extras.placements. Numbers
        /// are those of the mesh's own space: scales and rotations of nodes are not applied.
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised. Errors: <see cref="CrumpleResult.ErrorIo"/>, <see cref="CrumpleResult.ErrorFormat"/>
        /// (malformed, or no such mesh: the text lists those there are), <see cref="CrumpleResult.ErrorUnsupported"/> (compressed
        /// with Draco or meshopt, or a build without <see cref="CrumpleFeatures.Gltf"/>),
        /// <see cref="CrumpleResult.ErrorExampleMismatch"/> (no morph targets), and those of
        /// <see cref="Native.NativeMethods.crumple_example_set_create"/>.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_load_gltf(
            IntPtr context,
            CrumpleGltfDef* def,
            CrumpleExampleSet* outSet);

        /// <summary>
        /// The same from the bytes of a file: size bytes at data, read during the call only, of any alignment.
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised. Errors: as for <see cref="Native.NativeMethods.crumple_example_set_load_gltf"/>.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_load_gltf_memory(
            IntPtr context,
            IntPtr data,
            UIntPtr size,
            CrumpleGltfDef* def,
            CrumpleExampleSet* outSet);

        /// <summary>
        /// Makes an example set from a base OBJ file and one OBJ file an example, which has the base's vertices in the base's
        /// order and is named after its file. Polygons are cut into triangles.
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised. Errors: <see cref="CrumpleResult.ErrorIo"/>, <see cref="CrumpleResult.ErrorFormat"/>,
        /// <see cref="CrumpleResult.ErrorUnsupported"/> (a build without <see cref="CrumpleFeatures.Obj"/>), and those of
        /// <see cref="Native.NativeMethods.crumple_example_set_create"/>.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_load_obj(
            IntPtr context,
            CrumpleObjDef* def,
            CrumpleExampleSet* outSet);

        /// <summary>
        /// Makes an example set from the size bytes of a .crumple file at data, which "crumple bake" or
        /// <see cref="Native.NativeMethods.crumple_example_set_save_baked"/> wrote: at once, since nothing is built or unpacked.
        /// bytes tells whether they are copied or kept, see <see cref="CrumpleBytes"/>. Everything in them is checked: no file
        /// can make Crumple read or write what it should not. The set has one primitive, no name and no node transform.
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised. Errors: <see cref="CrumpleResult.ErrorNullPointer"/>,
        /// <see cref="CrumpleResult.ErrorMisaligned"/> (out_set), <see cref="CrumpleResult.ErrorInvalidId"/>,
        /// <see cref="CrumpleResult.ErrorInvalidArgument"/> (bytes is no enumerator), <see cref="CrumpleResult.ErrorFormat"/>
        /// (damaged, cut short, or no baked set), <see cref="CrumpleResult.ErrorUnsupported"/> (of another version of the format,
        /// or a big-endian processor), <see cref="CrumpleResult.ErrorOutOfMemory"/>,
        /// <see cref="CrumpleResult.ErrorConcurrentUse"/>. Nothing is kept then.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_load_baked_memory(
            IntPtr context,
            IntPtr data,
            UIntPtr size,
            CrumpleBytes bytes,
            CrumpleExampleSet* outSet);

        /// <summary>
        /// The same from a file, which is read into memory: path is UTF-8.
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised. Errors: <see cref="CrumpleResult.ErrorIo"/>,
        /// <see cref="CrumpleResult.ErrorNullPointer"/>, <see cref="CrumpleResult.ErrorInvalidArgument"/> (path is not UTF-8),
        /// and those of <see cref="Native.NativeMethods.crumple_example_set_load_baked_memory"/>.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_load_baked(
            IntPtr context,
            IntPtr path,
            CrumpleExampleSet* outSet);

        /// <summary>
        /// Saves an example set as the bytes of a .crumple file; the same bytes for the same set on every machine. data has room
        /// for capacity bytes, of any alignment; with null and 0 only their number is told.
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised. Errors: <see cref="CrumpleResult.ErrorNullPointer"/>,
        /// <see cref="CrumpleResult.ErrorMisaligned"/> (out_size), <see cref="CrumpleResult.ErrorInvalidId"/>,
        /// <see cref="CrumpleResult.ErrorBufferTooSmall"/>, <see cref="CrumpleResult.ErrorUnsupported"/> (a big-endian
        /// processor), <see cref="CrumpleResult.ErrorOutOfMemory"/>, <see cref="CrumpleResult.ErrorConcurrentUse"/>.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_save_baked(
            IntPtr context,
            CrumpleExampleSet set,
            IntPtr data,
            UIntPtr capacity,
            UIntPtr* outSize);

        /// <summary>
        /// Copies nothing; set the streams that you want. Never fails; any thread.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleMeshCopyDef crumple_mesh_copy_def_default();

        /// <summary>
        /// Tells what a set holds.
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised. Errors: <see cref="CrumpleResult.ErrorNullPointer"/>,
        /// <see cref="CrumpleResult.ErrorMisaligned"/>, <see cref="CrumpleResult.ErrorInvalidId"/>,
        /// <see cref="CrumpleResult.ErrorConcurrentUse"/>.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_get_info(
            IntPtr context,
            CrumpleExampleSet set,
            CrumpleExampleSetInfo* outInfo);

        /// <summary>
        /// Tells what an example is; example is below example_count.
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised. Errors: <see cref="CrumpleResult.ErrorNullPointer"/>,
        /// <see cref="CrumpleResult.ErrorMisaligned"/>, <see cref="CrumpleResult.ErrorInvalidId"/>,
        /// <see cref="CrumpleResult.ErrorIndexOutOfRange"/>, <see cref="CrumpleResult.ErrorConcurrentUse"/>.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_get_example(
            IntPtr context,
            CrumpleExampleSet set,
            uint example,
            CrumpleExampleInfo* outInfo);

        /// <summary>
        /// Tells which vertices and triangles a part of the mesh has; primitive is below primitive_count.
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised. Errors: <see cref="CrumpleResult.ErrorNullPointer"/>,
        /// <see cref="CrumpleResult.ErrorMisaligned"/>, <see cref="CrumpleResult.ErrorInvalidId"/>,
        /// <see cref="CrumpleResult.ErrorIndexOutOfRange"/>, <see cref="CrumpleResult.ErrorConcurrentUse"/>.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_get_primitive(
            IntPtr context,
            CrumpleExampleSet set,
            uint primitive,
            CrumplePrimitive* outPrimitive);

        /// <summary>
        /// Copies the base mesh, or a level of detail, into your memory: the vertex and index buffers to draw with, before the
        /// first dent. Normals are computed ones where the set was made without.
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised. Errors: <see cref="CrumpleResult.ErrorNullPointer"/>,
        /// <see cref="CrumpleResult.ErrorMisaligned"/>, <see cref="CrumpleResult.ErrorStructSize"/>,
        /// <see cref="CrumpleResult.ErrorInvalidId"/>, <see cref="CrumpleResult.ErrorInvalidArgument"/> (a stride smaller than an
        /// element, streams that overlap), <see cref="CrumpleResult.ErrorIndexOutOfRange"/> (def.lod),
        /// <see cref="CrumpleResult.ErrorBufferTooSmall"/>, <see cref="CrumpleResult.ErrorMesh"/> (normals or tangents of a mesh
        /// that has none), <see cref="CrumpleResult.ErrorConcurrentUse"/>.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_copy_mesh(
            IntPtr context,
            CrumpleExampleSet set,
            CrumpleMeshCopyDef* def);

        /// <summary>
        /// Tells the vertex of the base mesh nearest to a point, m, in the mesh's space; of equally near ones the lowest. Either
        /// output may be null; the distance is in m.
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised. Errors: <see cref="CrumpleResult.ErrorNullPointer"/>,
        /// <see cref="CrumpleResult.ErrorMisaligned"/>, <see cref="CrumpleResult.ErrorInvalidId"/>,
        /// <see cref="CrumpleResult.ErrorNotFinite"/>, <see cref="CrumpleResult.ErrorConcurrentUse"/>.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_find_nearest_vertex(
            IntPtr context,
            CrumpleExampleSet set,
            CrumpleVec3 point,
            uint* outVertex,
            float* outDistance);

        /// <summary>
        /// An instance with default rules; set its set. Never fails; any thread.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleInstanceDef crumple_instance_def_default();

        /// <summary>
        /// Creates an undamaged instance: a few hundred bytes, and 8 for each 128 vertices.
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised. Errors: <see cref="CrumpleResult.ErrorNullPointer"/>,
        /// <see cref="CrumpleResult.ErrorMisaligned"/>, <see cref="CrumpleResult.ErrorStructSize"/>,
        /// <see cref="CrumpleResult.ErrorInvalidId"/> (def.set), <see cref="CrumpleResult.ErrorInvalidArgument"/>,
        /// <see cref="CrumpleResult.ErrorNotFinite"/>, <see cref="CrumpleResult.ErrorOutOfMemory"/>,
        /// <see cref="CrumpleResult.ErrorConcurrentUse"/>.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_create(
            IntPtr context,
            CrumpleInstanceDef* def,
            CrumpleInstance* outInstance);

        /// <summary>
        /// Ends an instance and unregisters its buffers, whose ids end too. Your memory stays as it is.
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised. Errors: <see cref="CrumpleResult.ErrorNullPointer"/>,
        /// <see cref="CrumpleResult.ErrorInvalidId"/>, <see cref="CrumpleResult.ErrorConcurrentUse"/>.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_destroy(IntPtr context, CrumpleInstance instance);

        /// <summary>
        /// Tells what an instance is at the moment.
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised. Errors: <see cref="CrumpleResult.ErrorNullPointer"/>,
        /// <see cref="CrumpleResult.ErrorMisaligned"/>, <see cref="CrumpleResult.ErrorInvalidId"/>,
        /// <see cref="CrumpleResult.ErrorConcurrentUse"/>.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_get_info(
            IntPtr context,
            CrumpleInstance instance,
            CrumpleInstanceInfo* outInfo);

        /// <summary>
        /// Tells where an instance is: local_to_world points to 16 floats, column-major (element 4 * column + row, as in glTF,
        /// OpenGL and Vulkan), translation in elements 12 to 14, m, last row 0 0 0 1. May scale and shear, but not flatten. Only
        /// hits in <see cref="CrumpleSpace.World"/> go through it, those submitted from then on; deformed vertices are always in
        /// the mesh's own space.
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised. Errors: <see cref="CrumpleResult.ErrorNullPointer"/>,
        /// <see cref="CrumpleResult.ErrorMisaligned"/>, <see cref="CrumpleResult.ErrorInvalidId"/>,
        /// <see cref="CrumpleResult.ErrorNotFinite"/>, <see cref="CrumpleResult.ErrorInvalidArgument"/> (it flattens, or the last
        /// row is another), <see cref="CrumpleResult.ErrorConcurrentUse"/>.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_set_transform(
            IntPtr context,
            CrumpleInstance instance,
            float* localToWorld);

        /// <summary>
        /// No vertex of the instance moves further than depth_limit, m, from the next
        /// <see cref="Native.NativeMethods.crumple_context_deform"/> on; 0: the set's limit. Damage that is there stays, and
        /// shows again when the limit is raised.
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised. Errors: <see cref="CrumpleResult.ErrorNullPointer"/>,
        /// <see cref="CrumpleResult.ErrorInvalidId"/>, <see cref="CrumpleResult.ErrorNotFinite"/>,
        /// <see cref="CrumpleResult.ErrorInvalidArgument"/>, <see cref="CrumpleResult.ErrorConcurrentUse"/>.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_set_depth_limit(
            IntPtr context,
            CrumpleInstance instance,
            float depthLimit);

        /// <summary>
        /// Lets vertices of the instance be wrong by up to tolerance, m, in the mesh's space, so that deforming it costs less:
        /// displacements too short to matter are left out. 0: nothing is left out. Seams stay closed. It is rounded down to a
        /// power of two times 1 m, so it may be set in each frame from
        /// <see cref="Native.NativeMethods.crumple_pixel_tolerance"/>; where that changes, the next
        /// <see cref="Native.NativeMethods.crumple_context_deform"/> writes everything that is dented anew. Instances with one of
        /// the literature's rules ignore it.
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised. Errors: <see cref="CrumpleResult.ErrorNullPointer"/>,
        /// <see cref="CrumpleResult.ErrorInvalidId"/>, <see cref="CrumpleResult.ErrorNotFinite"/>,
        /// <see cref="CrumpleResult.ErrorInvalidArgument"/> (below 0), <see cref="CrumpleResult.ErrorConcurrentUse"/>.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_set_tolerance(
            IntPtr context,
            CrumpleInstance instance,
            float tolerance);

        /// <summary>
        /// The length, m, that covers so many pixels at a distance, m, before a camera with this vertical field of view, radians,
        /// and viewport height, pixels: the tolerance for an instance whose nearest vertex is that far off. 0, which leaves out
        /// nothing, for values that make no sense: negative, not a number, a field of view of half a turn or more, a height of 0.
        /// Never fails; any thread.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern float crumple_pixel_tolerance(float pixels, float distance, float fovY, float viewportHeight);

        /// <summary>
        /// An impulse of nothing, in the mesh's space; set its point, impulse and duration. Never fails; any thread.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleImpulseDef crumple_impulse_def_default();

        /// <summary>
        /// A displacement of nothing, in the mesh's space; set its point and displacement. Never fails; any thread.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleDisplacementDef crumple_displacement_def_default();

        /// <summary>
        /// Reports an impulse. Its examples are chosen at once; the mark it makes counts from the next call that reads damage
        /// (<see cref="Native.NativeMethods.crumple_context_deform"/>,
        /// <see cref="Native.NativeMethods.crumple_instance_get_marks"/> and so on), whatever the order and the threads hits came
        /// from. A hit that is too weak, or that no example answers, is no error: see status. out_result may be null. With a
        /// contact_id it tells what the hit would do alone; see <see cref="Native.NativeMethods.crumple_instance_end_contact"/>
        /// for what it does with the contact's other hits.
        /// </summary>
        /// <remarks>
        /// <para>May be called from any thread at any time, also while other threads submit or deform; not while the instance or
        /// the context is being destroyed. Errors: <see cref="CrumpleResult.ErrorNullPointer"/>,
        /// <see cref="CrumpleResult.ErrorMisaligned"/>, <see cref="CrumpleResult.ErrorStructSize"/>,
        /// <see cref="CrumpleResult.ErrorInvalidId"/>, <see cref="CrumpleResult.ErrorNotFinite"/>,
        /// <see cref="CrumpleResult.ErrorInvalidArgument"/> (a duration not above 0, a negative mass, or none known),
        /// <see cref="CrumpleResult.ErrorContactTooFar"/> (the point is further from the body than the instance accepts),
        /// <see cref="CrumpleResult.ErrorWrongRule"/> (a contact_id with one of the literature's rules, which cannot replace what
        /// they have deformed), <see cref="CrumpleResult.ErrorOutOfMemory"/>. Nothing is left behind then.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_submit_impulse(
            IntPtr context,
            CrumpleInstance instance,
            CrumpleImpulseDef* def,
            CrumpleHitResult* outResult);

        /// <summary>
        /// Reports a hit that should displace its contact so far. As
        /// <see cref="Native.NativeMethods.crumple_instance_submit_impulse"/> in every other respect, its threads and errors too.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_submit_displacement(
            IntPtr context,
            CrumpleInstance instance,
            CrumpleDisplacementDef* def,
            CrumpleHitResult* outResult);

        /// <summary>
        /// Ends a contact of an instance: its dent stays as it is, and later hits with the same id begin another one.
        /// </summary>
        /// <remarks>
        /// <para>A physics engine that reports one contact as many small impulses, one a step, gives all of them the same
        /// contact_id (of its own choice, one for each contact point and touch, not 0) and ends the contact when the bodies part.
        /// They make the one dent that the whole impulse in one report would have made, at any frame rate: while the contact is
        /// open, displacements (impulse * duration / mass) add, the point is the mean of their points, weighted by the lengths of
        /// their displacements, yield thresholds and depth limit hold for the sum, and the contact's one mark is replaced as more
        /// hits come.</para>
        /// <para>Counts from the next call that reads damage on, after all hits that have arrived by then: use an id again only
        /// after that. An id that is not open is no error. Contacts also end when the instance's damage is set, loaded, copied
        /// into, repaired or reset, and when more than 256 are open: the one hit longest ago ends then (of equals the lowest
        /// id).</para>
        /// <para>May be called from any thread at any time, as
        /// <see cref="Native.NativeMethods.crumple_instance_submit_impulse"/>. Errors:
        /// <see cref="CrumpleResult.ErrorNullPointer"/>, <see cref="CrumpleResult.ErrorInvalidId"/>,
        /// <see cref="CrumpleResult.ErrorInvalidArgument"/> (contact_id is 0), <see cref="CrumpleResult.ErrorWrongRule"/> (one of
        /// the literature's rules), <see cref="CrumpleResult.ErrorOutOfMemory"/>.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_end_contact(
            IntPtr context,
            CrumpleInstance instance,
            ulong contactId);

        /// <summary>
        /// Copies an instance's marks, sorted: the same hits give the same marks whatever their order. marks has room for
        /// capacity of them; with null and 0 only their number is told.
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised. Errors: <see cref="CrumpleResult.ErrorNullPointer"/>,
        /// <see cref="CrumpleResult.ErrorMisaligned"/>, <see cref="CrumpleResult.ErrorInvalidId"/>,
        /// <see cref="CrumpleResult.ErrorBufferTooSmall"/> (capacity is smaller than the number of marks),
        /// <see cref="CrumpleResult.ErrorWrongRule"/> (the literature's rules have no marks),
        /// <see cref="CrumpleResult.ErrorConcurrentUse"/>.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_get_marks(
            IntPtr context,
            CrumpleInstance instance,
            CrumpleMark* marks,
            uint capacity,
            uint* outCount);

        /// <summary>
        /// Replaces an instance's marks by count others, of the same set, forgets hits that wait and ends contacts. Null and 0:
        /// none.
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised. Errors: <see cref="CrumpleResult.ErrorNullPointer"/>,
        /// <see cref="CrumpleResult.ErrorMisaligned"/>, <see cref="CrumpleResult.ErrorInvalidId"/>,
        /// <see cref="CrumpleResult.ErrorInvalidArgument"/> (a mark that the set cannot have),
        /// <see cref="CrumpleResult.ErrorWrongRule"/>, <see cref="CrumpleResult.ErrorOutOfMemory"/>,
        /// <see cref="CrumpleResult.ErrorConcurrentUse"/>. Nothing changes then.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_set_marks(
            IntPtr context,
            CrumpleInstance instance,
            CrumpleMark* marks,
            uint count);

        /// <summary>
        /// Saves an instance's damage as bytes, with a version and the set's fingerprint; the same bytes for the same damage on
        /// every machine. data has room for capacity bytes, of any alignment; with null and 0 only their number is told.
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised. Errors: <see cref="CrumpleResult.ErrorNullPointer"/>,
        /// <see cref="CrumpleResult.ErrorMisaligned"/>, <see cref="CrumpleResult.ErrorInvalidId"/>,
        /// <see cref="CrumpleResult.ErrorBufferTooSmall"/>, <see cref="CrumpleResult.ErrorConcurrentUse"/>.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_save_damage(
            IntPtr context,
            CrumpleInstance instance,
            IntPtr data,
            UIntPtr capacity,
            UIntPtr* outSize);

        /// <summary>
        /// Replaces an instance's damage by size saved bytes, of any alignment, forgets hits that wait and ends contacts.
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised. Errors: <see cref="CrumpleResult.ErrorNullPointer"/>,
        /// <see cref="CrumpleResult.ErrorInvalidId"/>, <see cref="CrumpleResult.ErrorDamageMismatch"/> (of another set, version
        /// or rule, or cut short), <see cref="CrumpleResult.ErrorInvalidArgument"/> (a mark that the set cannot have),
        /// <see cref="CrumpleResult.ErrorConcurrentUse"/>. Nothing changes then.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_load_damage(
            IntPtr context,
            CrumpleInstance instance,
            IntPtr data,
            UIntPtr size);

        /// <summary>
        /// Repairs an instance: every dent keeps this share of its depth, 0 (as new) to 1 (nothing repaired). Ends contacts.
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised. Errors: <see cref="CrumpleResult.ErrorNullPointer"/>,
        /// <see cref="CrumpleResult.ErrorInvalidId"/>, <see cref="CrumpleResult.ErrorNotFinite"/>,
        /// <see cref="CrumpleResult.ErrorInvalidArgument"/>, <see cref="CrumpleResult.ErrorConcurrentUse"/>.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_repair_damage(
            IntPtr context,
            CrumpleInstance instance,
            float keep);

        /// <summary>
        /// Makes an instance as new, forgets hits that wait and ends contacts.
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised. Errors: <see cref="CrumpleResult.ErrorNullPointer"/>,
        /// <see cref="CrumpleResult.ErrorInvalidId"/>, <see cref="CrumpleResult.ErrorConcurrentUse"/>.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_reset_damage(IntPtr context, CrumpleInstance instance);

        /// <summary>
        /// Replaces the damage of instance by that of source, another instance with an equal set and the same kind of rule,
        /// forgets hits that wait for instance and ends its contacts. From itself: nothing happens.
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised. Errors: <see cref="CrumpleResult.ErrorNullPointer"/>,
        /// <see cref="CrumpleResult.ErrorInvalidId"/>, <see cref="CrumpleResult.ErrorDamageMismatch"/>,
        /// <see cref="CrumpleResult.ErrorConcurrentUse"/>. Nothing changes then.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_copy_damage(
            IntPtr context,
            CrumpleInstance instance,
            CrumpleInstance source);

        /// <summary>
        /// A buffer without memory; set its streams. Never fails; any thread.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleHostBufferDef crumple_host_buffer_def_default();

        /// <summary>
        /// Registers memory of yours that <see cref="Native.NativeMethods.crumple_context_deform"/> writes an instance's vertices
        /// to. An instance may have several, such as the members of a ring, each of which gets what it lacks. Nothing is written
        /// yet; the first deform writes every vertex. The memory is touched by
        /// <see cref="Native.NativeMethods.crumple_context_deform"/> only, and must stay until the buffer is unregistered, given
        /// other memory, or its instance or context is destroyed. Memory of different buffers must not overlap (debug builds of
        /// the library check it).
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised. Errors: <see cref="CrumpleResult.ErrorNullPointer"/>,
        /// <see cref="CrumpleResult.ErrorMisaligned"/>, <see cref="CrumpleResult.ErrorStructSize"/>,
        /// <see cref="CrumpleResult.ErrorInvalidId"/>, <see cref="CrumpleResult.ErrorInvalidArgument"/> (a stride smaller than an
        /// element, streams that overlap), <see cref="CrumpleResult.ErrorIndexOutOfRange"/> (def.lod),
        /// <see cref="CrumpleResult.ErrorWrongRule"/> (def.lod above 0 for an instance with one of the literature's rules),
        /// <see cref="CrumpleResult.ErrorBufferTooSmall"/>, <see cref="CrumpleResult.ErrorMesh"/> (normals or tangents of a mesh
        /// that has none), <see cref="CrumpleResult.ErrorOutOfMemory"/>, <see cref="CrumpleResult.ErrorConcurrentUse"/>.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_buffer_register_host(
            IntPtr context,
            CrumpleInstance instance,
            CrumpleHostBufferDef* def,
            CrumpleBuffer* outBuffer);

        /// <summary>
        /// Forgets a buffer. The memory stays as it is, yours alone again; a VkBuffer once the frames that wrote it are done.
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised. Errors: <see cref="CrumpleResult.ErrorNullPointer"/>,
        /// <see cref="CrumpleResult.ErrorInvalidId"/>, <see cref="CrumpleResult.ErrorConcurrentUse"/>.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_buffer_unregister(IntPtr context, CrumpleBuffer buffer);

        /// <summary>
        /// Says that somebody else wrote to a buffer's memory, or that its contents were lost: the next deform, or recording,
        /// writes every vertex.
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised. Errors: <see cref="CrumpleResult.ErrorNullPointer"/>,
        /// <see cref="CrumpleResult.ErrorInvalidId"/>, <see cref="CrumpleResult.ErrorConcurrentUse"/>.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_buffer_invalidate(IntPtr context, CrumpleBuffer buffer);

        /// <summary>
        /// Gives a buffer other memory, such as a newly mapped one, perhaps for another level of detail, and invalidates it.
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised. Errors: as for <see cref="Native.NativeMethods.crumple_buffer_register_host"/>, and
        /// <see cref="CrumpleResult.ErrorInvalidArgument"/> for a Vulkan buffer; the buffer keeps its memory then.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_buffer_set_memory(
            IntPtr context,
            CrumpleBuffer buffer,
            CrumpleHostBufferDef* def);

        /// <summary>
        /// Brings host buffers up to date: count ids at buffers, each once; with null and 0 all of the context. Writes only where
        /// damage changed since a buffer was last written, in parallel over all of them, and is cheap where nothing did. Do not
        /// read or write the buffers' memory meanwhile. An instance that nobody sees needs no deform: it catches up in one,
        /// however many hits it took. out_report may be null.
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised. Errors: <see cref="CrumpleResult.ErrorNullPointer"/>,
        /// <see cref="CrumpleResult.ErrorMisaligned"/>, <see cref="CrumpleResult.ErrorInvalidId"/>,
        /// <see cref="CrumpleResult.ErrorInvalidArgument"/> (a buffer twice, or one that
        /// <see cref="Native.NativeMethods.crumple_vulkan_record"/> writes; in debug builds of the library: memory of two buffers
        /// overlaps), <see cref="CrumpleResult.ErrorOutOfMemory"/>, <see cref="CrumpleResult.ErrorConcurrentUse"/>. No vertex is
        /// written then.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_context_deform(
            IntPtr context,
            CrumpleBuffer* buffers,
            uint count,
            CrumpleDeformReport* outReport);

        /// <summary>
        /// Tells which vertices the last deform or recording that named a buffer wrote (increasing ranges, apart from each
        /// other), and a box, m, around all of its vertices as they are now: what to upload, what to refit, what to cull with.
        /// The box of a Vulkan buffer is never too small but may be too large, since the CPU does not see its vertices. ranges
        /// has room for capacity of them; with null and 0 only their number is told. out_bounds may be null.
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised. Errors: <see cref="CrumpleResult.ErrorNullPointer"/>,
        /// <see cref="CrumpleResult.ErrorMisaligned"/>, <see cref="CrumpleResult.ErrorInvalidId"/>,
        /// <see cref="CrumpleResult.ErrorBufferTooSmall"/> (capacity is smaller than the number of ranges),
        /// <see cref="CrumpleResult.ErrorConcurrentUse"/>.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_buffer_get_changes(
            IntPtr context,
            CrumpleBuffer buffer,
            CrumpleRange* ranges,
            uint capacity,
            uint* outCount,
            CrumpleAabb* outBounds);

        /// <summary>
        /// A device without handles; set them and the queue family. Never fails; any thread.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleVulkanAttachDef crumple_vulkan_attach_def_default();

        /// <summary>
        /// A range of no buffer, read as vertices before and after; set the buffer, its size and usage, the range and its
        /// streams. Never fails; any thread.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleVulkanBufferDef crumple_vulkan_buffer_def_default();

        /// <summary>
        /// Takes your Vulkan device: loads functions, some tenths of a millisecond. A context has one at a time. The handles must
        /// be valid, belong together, and stay so until <see cref="Native.NativeMethods.crumple_vulkan_detach"/> or
        /// <see cref="Native.NativeMethods.crumple_context_destroy"/>.
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised. Errors: <see cref="CrumpleResult.ErrorNullPointer"/>,
        /// <see cref="CrumpleResult.ErrorMisaligned"/>, <see cref="CrumpleResult.ErrorStructSize"/>,
        /// <see cref="CrumpleResult.ErrorInvalidArgument"/> (one is attached already, a queue family that is not there or cannot
        /// compute, workgroup_size), <see cref="CrumpleResult.ErrorUnsupported"/> (a device below Vulkan 1.1; a loader that lacks
        /// a function, which is named; a build without <see cref="CrumpleFeatures.Vulkan"/>),
        /// <see cref="CrumpleResult.ErrorVulkan"/>, <see cref="CrumpleResult.ErrorDeviceLost"/>,
        /// <see cref="CrumpleResult.ErrorConcurrentUse"/>.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_vulkan_attach(IntPtr context, CrumpleVulkanAttachDef* def);

        /// <summary>
        /// Lets go of the Vulkan device, unregisters all Vulkan buffers, whose ids end, and destroys what Crumple made there.
        /// Damage stays. After a loss of the device (<see cref="CrumpleResult.ErrorDeviceLost"/>):
        /// <see cref="Native.NativeMethods.crumple_vulkan_complete_frames"/> with UINT64_MAX, since a lost device runs nothing
        /// any more, this call, vkDestroyDevice, then attach the new one and register again.
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised. Errors: <see cref="CrumpleResult.ErrorNullPointer"/>,
        /// <see cref="CrumpleResult.ErrorInvalidId"/>, <see cref="CrumpleResult.ErrorInvalidArgument"/> (none is attached),
        /// <see cref="CrumpleResult.ErrorFramesInFlight"/>, <see cref="CrumpleResult.ErrorConcurrentUse"/>. Nothing changes
        /// then.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_vulkan_detach(IntPtr context);

        /// <summary>
        /// Gives what the driver would like to have again at the next start: hand it to
        /// <see cref="Native.NativeMethods.crumple_vulkan_attach"/>. data has room for capacity bytes, of any alignment; with
        /// null and 0 only their number is told, which may grow until all kinds of buffers were registered.
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised. Errors: <see cref="CrumpleResult.ErrorNullPointer"/>,
        /// <see cref="CrumpleResult.ErrorMisaligned"/> (out_size), <see cref="CrumpleResult.ErrorInvalidArgument"/> (no device is
        /// attached), <see cref="CrumpleResult.ErrorBufferTooSmall"/>, <see cref="CrumpleResult.ErrorVulkan"/>,
        /// <see cref="CrumpleResult.ErrorDeviceLost"/>, <see cref="CrumpleResult.ErrorConcurrentUse"/>.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_vulkan_get_pipeline_cache(
            IntPtr context,
            IntPtr data,
            UIntPtr capacity,
            UIntPtr* outSize);

        /// <summary>
        /// Registers a range of a VkBuffer of yours that <see cref="Native.NativeMethods.crumple_vulkan_record"/> writes an
        /// instance's vertices to. An instance may have several, such as the members of a ring. Nothing is written yet; the first
        /// recording writes every vertex. The first range of a mesh has its vertices and examples copied: into a staging buffer
        /// now, from there to the device by the next recording; other instances and ranges share them. The VkBuffer must live
        /// until its last range is unregistered (or its instance, the device or the context gone) and the frames that wrote it
        /// are done.
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised. Errors: <see cref="CrumpleResult.ErrorNullPointer"/>,
        /// <see cref="CrumpleResult.ErrorMisaligned"/> (offsets and strides that are not multiples of 4),
        /// <see cref="CrumpleResult.ErrorStructSize"/>, <see cref="CrumpleResult.ErrorInvalidId"/>,
        /// <see cref="CrumpleResult.ErrorInvalidArgument"/> (no device is attached, no buffer, a usage without STORAGE_BUFFER,
        /// stages of 0, a format that is not one of those named, a stride smaller than a value, attributes that overlap, a scale
        /// that is not above 0, another description of a VkBuffer that is registered already),
        /// <see cref="CrumpleResult.ErrorNotFinite"/>, <see cref="CrumpleResult.ErrorBufferTooSmall"/>,
        /// <see cref="CrumpleResult.ErrorIndexOutOfRange"/> (def.lod), <see cref="CrumpleResult.ErrorWrongRule"/> (def.lod above
        /// 0 for an instance with one of the literature's rules), <see cref="CrumpleResult.ErrorUnsupported"/> (normals or
        /// tangents of a mesh that has none; more bytes than the device can bind), <see cref="CrumpleResult.ErrorOutOfMemory"/>,
        /// <see cref="CrumpleResult.ErrorVulkan"/>, <see cref="CrumpleResult.ErrorDeviceLost"/>,
        /// <see cref="CrumpleResult.ErrorConcurrentUse"/>.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_buffer_register_vulkan(
            IntPtr context,
            CrumpleInstance instance,
            CrumpleVulkanBufferDef* def,
            CrumpleBuffer* outBuffer);

        /// <summary>
        /// Records what brings Vulkan buffers up to date: count ids at buffers, each once; with null and 0 all of the context.
        /// Hits are folded; then, for the blocks that changed since each buffer was last written, there is a copy of a few bytes
        /// a block, a barrier, one dispatch a VkBuffer, a barrier. Nothing is submitted, nothing waited for, and nothing
        /// allocated once as much has changed in a frame, and as many frames were in flight, as ever will. What is read on the
        /// CPU is read by this call; damage may change at once after it.
        /// </summary>
        /// <remarks>
        /// <para>command_buffer is a VkCommandBuffer, primary or secondary, in the recording state, outside a render pass, of a
        /// pool of the queue family that was attached and that no other thread uses meanwhile. It is submitted once, in the order
        /// of recording; not simultaneously, not again. frame is your number of the frame, from 1 on; it never falls, and several
        /// recordings may have the same one. out_report may be null.</para>
        /// <para>Left changed in the command buffer: the compute pipeline, the compute descriptor sets 0 to 2, and the first 24
        /// bytes of the push constants of stage compute. Nothing else.</para>
        /// <para>Externally synchronised. Errors: <see cref="CrumpleResult.ErrorNullPointer"/>,
        /// <see cref="CrumpleResult.ErrorMisaligned"/>, <see cref="CrumpleResult.ErrorInvalidId"/>,
        /// <see cref="CrumpleResult.ErrorInvalidArgument"/> (no device of yours is attached, a buffer twice or a host buffer, a
        /// frame that is done or below the last), <see cref="CrumpleResult.ErrorUnsupported"/> (more work than the device can
        /// bind), <see cref="CrumpleResult.ErrorOutOfMemory"/>, <see cref="CrumpleResult.ErrorVulkan"/>,
        /// <see cref="CrumpleResult.ErrorDeviceLost"/>, <see cref="CrumpleResult.ErrorConcurrentUse"/>. Nothing was recorded
        /// then.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_vulkan_record(
            IntPtr context,
            IntPtr commandBuffer,
            ulong frame,
            CrumpleBuffer* buffers,
            uint count,
            CrumpleRecordReport* outReport);

        /// <summary>
        /// Says that the device is done with frame and all before it: what was submitted for them has completed, as a fence or
        /// timeline semaphore says. What they used is used again, or freed. A number above the last recorded frame's counts as
        /// that. Cheap; once a frame.
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised. Errors: <see cref="CrumpleResult.ErrorNullPointer"/>,
        /// <see cref="CrumpleResult.ErrorInvalidId"/>, <see cref="CrumpleResult.ErrorInvalidArgument"/> (no device of yours is
        /// attached), <see cref="CrumpleResult.ErrorConcurrentUse"/>.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_vulkan_complete_frames(IntPtr context, ulong frame);

        /// <summary>
        /// Says that what was recorded for frame and those after it will not be submitted: the buffers that it wrote are written
        /// whole by their next recording.
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised. Errors: <see cref="CrumpleResult.ErrorNullPointer"/>,
        /// <see cref="CrumpleResult.ErrorInvalidId"/>, <see cref="CrumpleResult.ErrorInvalidArgument"/> (no device of yours is
        /// attached), <see cref="CrumpleResult.ErrorConcurrentUse"/>.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_vulkan_discard_frames(IntPtr context, ulong frame);

        /// <summary>
        /// Any device, by no loader; set that, and the UUID. Never fails; any thread.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleVulkanOpenDef crumple_vulkan_open_def_default();

        /// <summary>
        /// No memory; set its handle, sizes, type and usage. Never fails; any thread.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleVulkanImportDef crumple_vulkan_import_def_default();

        /// <summary>
        /// Makes a Vulkan device of Crumple's own, for engines that cannot hand out a command buffer but can share memory,
        /// perhaps with another process: some milliseconds to tenths of a second. It takes the place of
        /// <see cref="Native.NativeMethods.crumple_vulkan_attach"/>: buffers are imported by
        /// <see cref="Native.NativeMethods.crumple_vulkan_import_buffer"/>, registered by
        /// <see cref="Native.NativeMethods.crumple_buffer_register_vulkan"/> and written by
        /// <see cref="Native.NativeMethods.crumple_vulkan_submit"/>. <see cref="Native.NativeMethods.crumple_vulkan_detach"/> and
        /// <see cref="Native.NativeMethods.crumple_context_destroy"/> wait for it, and destroy it.
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised. Errors: <see cref="CrumpleResult.ErrorNullPointer"/>,
        /// <see cref="CrumpleResult.ErrorMisaligned"/>, <see cref="CrumpleResult.ErrorStructSize"/>,
        /// <see cref="CrumpleResult.ErrorInvalidArgument"/> (a device is attached already, workgroup_size),
        /// <see cref="CrumpleResult.ErrorUnsupported"/> (no such device, which names those there are; one that cannot import
        /// memory; a build without <see cref="CrumpleFeatures.Vulkan"/>), <see cref="CrumpleResult.ErrorVulkan"/>,
        /// <see cref="CrumpleResult.ErrorDeviceLost"/>, <see cref="CrumpleResult.ErrorConcurrentUse"/>.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_vulkan_open(IntPtr context, CrumpleVulkanOpenDef* def);

        /// <summary>
        /// Makes a buffer of your device known to Crumple's own, and gives what stands for it as buffer of
        /// <see cref="CrumpleVulkanBufferDef"/>; that def's buffer_size, usage, queue family, stages and accesses are not looked
        /// at then. On your queue, before each submission you release the VkBuffer to VK_QUEUE_FAMILY_EXTERNAL, and afterwards
        /// you acquire it from there. The memory must live until
        /// <see cref="Native.NativeMethods.crumple_vulkan_unimport_buffer"/>,
        /// <see cref="Native.NativeMethods.crumple_vulkan_detach"/> or
        /// <see cref="Native.NativeMethods.crumple_context_destroy"/>.
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised. Errors: <see cref="CrumpleResult.ErrorNullPointer"/>,
        /// <see cref="CrumpleResult.ErrorMisaligned"/>, <see cref="CrumpleResult.ErrorStructSize"/>,
        /// <see cref="CrumpleResult.ErrorInvalidArgument"/> (no device of <see cref="Native.NativeMethods.crumple_vulkan_open"/>,
        /// a handle that is none or not of memory, a memory type that the buffer cannot lie in, a usage without STORAGE_BUFFER),
        /// <see cref="CrumpleResult.ErrorBufferTooSmall"/> (the memory), <see cref="CrumpleResult.ErrorUnsupported"/> (a handle
        /// of another system, or a buffer that the device cannot import), <see cref="CrumpleResult.ErrorOutOfMemory"/>,
        /// <see cref="CrumpleResult.ErrorVulkan"/>, <see cref="CrumpleResult.ErrorDeviceLost"/>,
        /// <see cref="CrumpleResult.ErrorConcurrentUse"/>.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_vulkan_import_buffer(
            IntPtr context,
            CrumpleVulkanImportDef* def,
            ulong* outBuffer);

        /// <summary>
        /// Forgets an imported buffer that no range is registered of, and waits until the device is done with it.
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised. Errors: <see cref="CrumpleResult.ErrorNullPointer"/>,
        /// <see cref="CrumpleResult.ErrorInvalidArgument"/> (no device of <see cref="Native.NativeMethods.crumple_vulkan_open"/>,
        /// no such buffer, ranges of it are registered), <see cref="CrumpleResult.ErrorVulkan"/>,
        /// <see cref="CrumpleResult.ErrorDeviceLost"/>, <see cref="CrumpleResult.ErrorConcurrentUse"/>.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_vulkan_unimport_buffer(IntPtr context, ulong buffer);

        /// <summary>
        /// Makes a binary semaphore of your device, exported with the same type of handle, known to Crumple's own, and gives its
        /// number for <see cref="Native.NativeMethods.crumple_vulkan_submit"/>. It lives until
        /// <see cref="Native.NativeMethods.crumple_vulkan_detach"/> or
        /// <see cref="Native.NativeMethods.crumple_context_destroy"/>.
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised. Errors: <see cref="CrumpleResult.ErrorNullPointer"/>,
        /// <see cref="CrumpleResult.ErrorMisaligned"/>, <see cref="CrumpleResult.ErrorInvalidArgument"/> (no device of
        /// <see cref="Native.NativeMethods.crumple_vulkan_open"/>, handle_type, a handle that is none or not of a semaphore),
        /// <see cref="CrumpleResult.ErrorUnsupported"/> (a driver without external semaphores: order by fences and
        /// <see cref="Native.NativeMethods.crumple_vulkan_wait_frame"/> then), <see cref="CrumpleResult.ErrorVulkan"/>,
        /// <see cref="CrumpleResult.ErrorDeviceLost"/>, <see cref="CrumpleResult.ErrorConcurrentUse"/>.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_vulkan_import_semaphore(
            IntPtr context,
            CrumpleHandleType handleType,
            long handle,
            ulong* outSemaphore);

        /// <summary>
        /// What <see cref="Native.NativeMethods.crumple_vulkan_record"/> is for a device of Crumple's own: records what brings
        /// Vulkan buffers up to date, and submits that. count ids at buffers, each once; with null and 0 all of the context. The
        /// device waits for wait_count semaphores at waits before and signals signal_count at signals after, also where nothing
        /// changed; nothing is waited for by this call. out_frame gets the number of the frame, for
        /// <see cref="Native.NativeMethods.crumple_vulkan_wait_frame"/>. out_frame and out_report may be null.
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised. Errors: those of <see cref="Native.NativeMethods.crumple_vulkan_record"/>, and
        /// <see cref="CrumpleResult.ErrorInvalidArgument"/> where there is no device of
        /// <see cref="Native.NativeMethods.crumple_vulkan_open"/>, or no such semaphore. Nothing was submitted then.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_vulkan_submit(
            IntPtr context,
            CrumpleBuffer* buffers,
            uint count,
            ulong* waits,
            uint waitCount,
            ulong* signals,
            uint signalCount,
            ulong* outFrame,
            CrumpleRecordReport* outReport);

        /// <summary>
        /// Waits until Crumple's own device is done with a frame of <see cref="Native.NativeMethods.crumple_vulkan_submit"/> and
        /// all before it, or for timeout nanoseconds (UINT64_MAX: as long as it takes). out_done tells whether it is done. The
        /// context is in use meanwhile.
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised. Errors: <see cref="CrumpleResult.ErrorNullPointer"/>,
        /// <see cref="CrumpleResult.ErrorInvalidArgument"/> (no device of <see cref="Native.NativeMethods.crumple_vulkan_open"/>,
        /// a frame that was not submitted), <see cref="CrumpleResult.ErrorVulkan"/>, <see cref="CrumpleResult.ErrorDeviceLost"/>,
        /// <see cref="CrumpleResult.ErrorConcurrentUse"/>.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_vulkan_wait_frame(
            IntPtr context,
            ulong frame,
            ulong timeout,
            CrumpleBool* outDone);

        /// <summary>
        /// Binds a point, m, in the mesh's space, to the surface nearest to it: it will keep its distance from the surface and
        /// turn with it.
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised. Errors: <see cref="CrumpleResult.ErrorNullPointer"/>,
        /// <see cref="CrumpleResult.ErrorMisaligned"/>, <see cref="CrumpleResult.ErrorInvalidId"/>,
        /// <see cref="CrumpleResult.ErrorNotFinite"/>, <see cref="CrumpleResult.ErrorInvalidArgument"/> (further off than 1e9 m),
        /// <see cref="CrumpleResult.ErrorConcurrentUse"/>.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_attach_point(
            IntPtr context,
            CrumpleExampleSet set,
            CrumpleVec3 point,
            CrumpleAttachment* outAttachment);

        /// <summary>
        /// Tells where an attached point is on a dented instance, hits that wait among them. Touches no buffer and reads none.
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised. Errors: <see cref="CrumpleResult.ErrorNullPointer"/>,
        /// <see cref="CrumpleResult.ErrorMisaligned"/>, <see cref="CrumpleResult.ErrorInvalidId"/>,
        /// <see cref="CrumpleResult.ErrorIndexOutOfRange"/> and <see cref="CrumpleResult.ErrorNotFinite"/> (an attachment of
        /// another set, or none), <see cref="CrumpleResult.ErrorConcurrentUse"/>.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_get_attached_frame(
            IntPtr context,
            CrumpleInstance instance,
            CrumpleAttachment* attachment,
            CrumpleFrame* outFrame);

        /// <summary>
        /// Begins to write what is called with this context to a file, so that it can be played again: "crumple replay FILE"
        /// makes the same calls in the same order without your engine, tells whether every result and every vertex is the same,
        /// and is how a bug that you see becomes a test that we can run. The file, path (UTF-8), is made new; it first gets what
        /// there is: the example sets, whole, the instances with their damage, the buffers. It grows by some hundred bytes a hit
        /// and a frame, written at once, so that a crash loses nothing. Every buffer is written whole by the next deform, as
        /// after <see cref="Native.NativeMethods.crumple_buffer_invalidate"/>.
        /// </summary>
        /// <remarks>
        /// <para>What Vulkan calls write is not compared, but made on the CPU; calls that are refused, other than hits, are noted
        /// with their message. Hits wait for each other and for calls that take them meanwhile, so leave it off in what you ship,
        /// or keep it for when a player asks.</para>
        /// <para>Externally synchronised; hits may arrive meanwhile. Errors: <see cref="CrumpleResult.ErrorNullPointer"/>,
        /// <see cref="CrumpleResult.ErrorInvalidId"/>, <see cref="CrumpleResult.ErrorInvalidArgument"/> (path is not UTF-8; a
        /// recording runs already; an instance has open contacts: end them first), <see cref="CrumpleResult.ErrorIo"/>,
        /// <see cref="CrumpleResult.ErrorUnsupported"/> (a big-endian processor), <see cref="CrumpleResult.ErrorOutOfMemory"/>,
        /// <see cref="CrumpleResult.ErrorConcurrentUse"/>. Nothing is recorded then.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_recording_begin(IntPtr context, IntPtr path);

        /// <summary>
        /// Ends a recording: the file is whole. <see cref="Native.NativeMethods.crumple_context_destroy"/> does so too.
        /// </summary>
        /// <remarks>
        /// <para>Externally synchronised; hits may arrive meanwhile. Errors: <see cref="CrumpleResult.ErrorNullPointer"/>,
        /// <see cref="CrumpleResult.ErrorInvalidId"/>, <see cref="CrumpleResult.ErrorInvalidArgument"/> (no recording runs),
        /// <see cref="CrumpleResult.ErrorIo"/> (the file could not be written to its end: what is there can be replayed; the
        /// recording has ended), <see cref="CrumpleResult.ErrorConcurrentUse"/>.</para>
        /// </remarks>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_recording_end(IntPtr context);
    }
}
