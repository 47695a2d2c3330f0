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
        /// Major version of this header. Libraries of another major version are incompatible.
        /// </summary>
        public const uint VersionMajor = 0;

        /// <summary>
        /// Minor version of this header. Before 1.0, libraries of another minor version are incompatible.
        /// </summary>
        public const uint VersionMinor = 1;

        /// <summary>
        /// 
        /// </summary>
        public const uint VersionPatch = 0;

        /// <summary>
        /// The version of this header as one number, in the format of <see cref="Native.NativeMethods.crumple_version"/>.
        /// </summary>
        public const uint Version = (((VersionMajor * 1000000) + (VersionMinor * 1000)) + VersionPatch);

        /// <summary>
        /// Returns the version of the running library: major * 1000000 + minor * 1000 + patch. Compare it with
        /// <see cref="Native.NativeMethods.Version"/>.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern uint crumple_version();

        /// <summary>
        /// Returns the version of the running library as text, such as "0.1.0". The text stays valid for ever.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern IntPtr crumple_version_string();

        /// <summary>
        /// Returns the CRUMPLE_FEATURE_ bits of this build, combined with or. Ignore bits that you do not know.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ulong crumple_features();

        /// <summary>
        /// Returns the message of the calling thread's last failed call, as UTF-8:
        /// "<see cref="Native.NativeMethods.crumple_instance_create"/>: ...". It names the wrong value and the right one. It is
        /// empty before the first failure; calls that succeed leave it unchanged. It stays valid until the thread's next failed
        /// call. At most 1023 bytes, never null.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern IntPtr crumple_last_error();

        /// <summary>
        /// Returns the name of a result, such as "<see cref="CrumpleResult.ErrorFormat"/>", or "unknown result". The text stays
        /// valid for ever.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern IntPtr crumple_result_name(CrumpleResult result);

        /// <summary>
        /// An allocator def without functions. Set both.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleAllocatorDef crumple_allocator_def_default();

        /// <summary>
        /// Makes the library allocate from the host's functions, for the whole process. Null restores the system's allocator. You
        /// may call this at any time. Each block is freed by the functions that allocated it, so they must stay callable.
        /// Destroying all contexts frees all blocks, except for a few kB per thread that contexts with their own threads keep
        /// until process exit. A process can use at most 15 different allocators. Builds without
        /// <see cref="CrumpleFeatures.HostAllocator"/> return <see cref="CrumpleResult.ErrorUnsupported"/>.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_allocator_set(CrumpleAllocatorDef* allocator);

        /// <summary>
        /// The default options: one thread per core, no log.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleContextDef crumple_context_def_default();

        /// <summary>
        /// Creates a context. What its callbacks use must live until the context is destroyed. Any thread may call this. Errors:
        /// <see cref="CrumpleResult.ErrorInvalidArgument"/> (more than 1024 threads, or 65535 contexts alive),
        /// <see cref="CrumpleResult.ErrorOutOfMemory"/> (the system starts no more threads).
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_context_create(CrumpleContextDef* def, IntPtr* outContext);

        /// <summary>
        /// Destroys a context and everything in it. Your own memory is neither freed nor touched. The context and its ids become
        /// invalid. No other call may be running with this context. An attached Vulkan device must still exist.
        /// <see cref="CrumpleResult.ErrorFramesInFlight"/>: see
        /// <see cref="Native.NativeMethods.crumple_vulkan_complete_frames"/>; nothing was destroyed.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_context_destroy(IntPtr context);

        /// <summary>
        /// An example without positions. Set them.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleExampleDef crumple_example_def_default();

        /// <summary>
        /// A set without mesh and examples. Set them.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleExampleSetDef crumple_example_set_def_default();

        /// <summary>
        /// Builds an example set from arrays. The call indexes the mesh and samples every example, which takes time: build sets
        /// while loading, or load baked ones. Errors: <see cref="CrumpleResult.ErrorMesh"/> (no vertices),
        /// <see cref="CrumpleResult.ErrorExampleMismatch"/> (no examples, or one that does not fit the mesh).
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_create(
            IntPtr context,
            CrumpleExampleSetDef* def,
            CrumpleExampleSet* outSet);

        /// <summary>
        /// A level of detail without mesh. Set it.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleLodDef crumple_lod_def_default();

        /// <summary>
        /// Adds a mesh that shows the same damage, such as a level of detail or a collision proxy. Call this before the set's
        /// first instance is created. out_lod is its number, 1 for the first, for the lod fields of buffer defs. Each vertex is
        /// bound to the nearest point of the base surface and moves with it. A vertex on a base vertex moves exactly as that
        /// vertex. Contacts, marks, saved damage and the fingerprint are still those of the base mesh. Errors:
        /// <see cref="CrumpleResult.ErrorInvalidArgument"/> (the set has instances), <see cref="CrumpleResult.ErrorMesh"/>.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_add_lod(
            IntPtr context,
            CrumpleExampleSet set,
            CrumpleLodDef* def,
            uint* outLod);

        /// <summary>
        /// Ends a set's id and the strings of its infos. Instances keep the set's memory alive and continue to work.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_destroy(IntPtr context, CrumpleExampleSet set);

        /// <summary>
        /// The first mesh with morph targets, with default options. Set the path.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleGltfDef crumple_gltf_def_default();

        /// <summary>
        /// Default options. Set the paths.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleObjDef crumple_obj_def_default();

        /// <summary>
        /// Builds an example set from a glTF 2.0 or GLB file: a mesh with its morph targets. Primitives are joined in their
        /// order; see <see cref="Native.NativeMethods.crumple_example_set_get_primitive"/>. mesh.extras gives names
        /// (targetNames), contacts (impacts) and placements. Coordinates stay in the mesh's own space: node transforms are not
        /// applied. Errors: <see cref="CrumpleResult.ErrorIo"/>, <see cref="CrumpleResult.ErrorFormat"/> (malformed, or no such
        /// mesh), <see cref="CrumpleResult.ErrorUnsupported"/> (Draco or meshopt compression, or a build without
        /// <see cref="CrumpleFeatures.Gltf"/>), <see cref="CrumpleResult.ErrorExampleMismatch"/> (no morph targets), and those of
        /// <see cref="Native.NativeMethods.crumple_example_set_create"/>.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_load_gltf(
            IntPtr context,
            CrumpleGltfDef* def,
            CrumpleExampleSet* outSet);

        /// <summary>
        /// As <see cref="Native.NativeMethods.crumple_example_set_load_gltf"/>, from the size bytes of a file at data, which are
        /// read during the call. Any alignment.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_load_gltf_memory(
            IntPtr context,
            IntPtr data,
            UIntPtr size,
            CrumpleGltfDef* def,
            CrumpleExampleSet* outSet);

        /// <summary>
        /// Builds an example set from a base OBJ file and one OBJ file per example, named after its file. Vertices are the file's
        /// v lines in their order. Polygons are triangulated. Errors: <see cref="CrumpleResult.ErrorIo"/>,
        /// <see cref="CrumpleResult.ErrorFormat"/>, <see cref="CrumpleResult.ErrorUnsupported"/> (a build without
        /// <see cref="CrumpleFeatures.Obj"/>), and those of <see cref="Native.NativeMethods.crumple_example_set_create"/>.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_load_obj(
            IntPtr context,
            CrumpleObjDef* def,
            CrumpleExampleSet* outSet);

        /// <summary>
        /// Loads an example set from the size bytes of a .crumple file at data, written by "crumple bake" or
        /// <see cref="Native.NativeMethods.crumple_example_set_save_baked"/>. Loading builds nothing and is fast. All bytes are
        /// validated. The set has one primitive, no name and no node transform. Errors: <see cref="CrumpleResult.ErrorFormat"/>
        /// (damaged, cut short, or no baked set), <see cref="CrumpleResult.ErrorUnsupported"/> (another format version, or a
        /// big-endian processor).
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_load_baked_memory(
            IntPtr context,
            IntPtr data,
            UIntPtr size,
            CrumpleBytes bytes,
            CrumpleExampleSet* outSet);

        /// <summary>
        /// As <see cref="Native.NativeMethods.crumple_example_set_load_baked_memory"/>, from a file that is read into memory.
        /// path is UTF-8. Also returns <see cref="CrumpleResult.ErrorIo"/>.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_load_baked(
            IntPtr context,
            IntPtr path,
            CrumpleExampleSet* outSet);

        /// <summary>
        /// Writes an example set as the bytes of a .crumple file, equal on all machines. data has capacity bytes of any
        /// alignment; see "Arrays" at the top. <see cref="CrumpleResult.ErrorUnsupported"/>: a big-endian processor.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_save_baked(
            IntPtr context,
            CrumpleExampleSet set,
            IntPtr data,
            UIntPtr capacity,
            UIntPtr* outSize);

        /// <summary>
        /// A copy def without streams. Set those that you need.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleMeshCopyDef crumple_mesh_copy_def_default();

        /// <summary>
        /// Returns facts about a set.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_get_info(
            IntPtr context,
            CrumpleExampleSet set,
            CrumpleExampleSetInfo* outInfo);

        /// <summary>
        /// Returns facts about the example with an index below example_count.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_get_example(
            IntPtr context,
            CrumpleExampleSet set,
            uint example,
            CrumpleExampleInfo* outInfo);

        /// <summary>
        /// Returns the vertices and triangles of the part with an index below primitive_count.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_get_primitive(
            IntPtr context,
            CrumpleExampleSet set,
            uint primitive,
            CrumplePrimitive* outPrimitive);

        /// <summary>
        /// Copies the base mesh or a level of detail into your memory, for your vertex and index buffers. Normals that the set
        /// was not given are the computed ones. <see cref="CrumpleResult.ErrorMesh"/>: the mesh lacks the normals or tangents
        /// asked for.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_copy_mesh(
            IntPtr context,
            CrumpleExampleSet set,
            CrumpleMeshCopyDef* def);

        /// <summary>
        /// Finds the vertex of the base mesh nearest to a point in the mesh's space, m. The lowest index wins a tie. Either
        /// output may be null. The distance is in m.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_find_nearest_vertex(
            IntPtr context,
            CrumpleExampleSet set,
            CrumpleVec3 point,
            uint* outVertex,
            float* outDistance);

        /// <summary>
        /// An instance with default options. Set its set.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleInstanceDef crumple_instance_def_default();

        /// <summary>
        /// Creates an undamaged instance: a few hundred bytes, plus 8 bytes per 128 vertices.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_create(
            IntPtr context,
            CrumpleInstanceDef* def,
            CrumpleInstance* outInstance);

        /// <summary>
        /// Destroys an instance and ends the ids of its buffers. Your memory keeps its contents.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_destroy(IntPtr context, CrumpleInstance instance);

        /// <summary>
        /// Returns the state of an instance.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_get_info(
            IntPtr context,
            CrumpleInstance instance,
            CrumpleInstanceInfo* outInfo);

        /// <summary>
        /// Sets the transform of an instance: local_to_world points to 16 floats, column-major (element 4 * column + row, as in
        /// glTF and Vulkan), translation in elements 12 to 14, m, last row 0 0 0 1. It may scale and shear but not flatten. Hits
        /// in <see cref="CrumpleSpace.World"/> that are submitted afterwards use it: points as points, impulses and displacements
        /// as vectors, by its inverse. Deformed vertices are always in the mesh's space.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_set_transform(
            IntPtr context,
            CrumpleInstance instance,
            float* localToWorld);

        /// <summary>
        /// Limits how far a vertex moves, m, from the next <see cref="Native.NativeMethods.crumple_context_deform"/> on. 0: the
        /// set's limit. Marks are kept, and show again when the limit is raised.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_set_depth_limit(
            IntPtr context,
            CrumpleInstance instance,
            float depthLimit);

        /// <summary>
        /// Allows vertices a position error of up to tolerance, m, in the mesh's space, which makes deforming cheaper: smaller
        /// displacements are skipped. 0: none are skipped. Seams stay closed. The value is rounded down to a power of two in
        /// metres, so it may be set every frame from <see cref="Native.NativeMethods.crumple_pixel_tolerance"/>. When the rounded
        /// value changes, the next deform writes every dented block. Classic rules ignore it.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_set_tolerance(
            IntPtr context,
            CrumpleInstance instance,
            float tolerance);

        /// <summary>
        /// Returns the length, m, that covers a number of pixels at a distance, m, for a camera with this vertical field of view,
        /// radians, and viewport height, pixels. Use it as the tolerance of an instance whose nearest vertex is at that distance.
        /// Returns 0 for meaningless arguments: negative or NaN, a field of view of pi or more, a height of 0.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern float crumple_pixel_tolerance(float pixels, float distance, float fovY, float viewportHeight);

        /// <summary>
        /// A zero impulse in the mesh's space. Set point, impulse and duration.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleImpulseDef crumple_impulse_def_default();

        /// <summary>
        /// A zero displacement in the mesh's space. Set point and displacement.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleDisplacementDef crumple_displacement_def_default();

        /// <summary>
        /// Submits a hit. Examples are selected during the call. The mark counts from the next read of the damage (see "Reads" at
        /// the top). A hit that is too weak, or that no example answers, is not an error; see out_result-&gt;status. out_result
        /// may be null. With a contact_id, it describes the hit alone. May be called from any thread at any time, except while
        /// the instance or context is being destroyed. Errors: <see cref="CrumpleResult.ErrorInvalidArgument"/> (duration not
        /// above 0, negative or unknown mass), <see cref="CrumpleResult.ErrorContactTooFar"/>,
        /// <see cref="CrumpleResult.ErrorWrongRule"/> (a contact_id with a classic rule).
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_submit_impulse(
            IntPtr context,
            CrumpleInstance instance,
            CrumpleImpulseDef* def,
            CrumpleHitResult* outResult);

        /// <summary>
        /// As <see cref="Native.NativeMethods.crumple_instance_submit_impulse"/>, for a displacement.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_submit_displacement(
            IntPtr context,
            CrumpleInstance instance,
            CrumpleDisplacementDef* def,
            CrumpleHitResult* outResult);

        /// <summary>
        /// Computes the result of <see cref="Native.NativeMethods.crumple_instance_submit_impulse"/> without leaving a mark.
        /// out_result is required. May be called from any thread at any time.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_preview_impulse(
            IntPtr context,
            CrumpleInstance instance,
            CrumpleImpulseDef* def,
            CrumpleHitResult* outResult);

        /// <summary>
        /// As <see cref="Native.NativeMethods.crumple_instance_preview_impulse"/>, for a displacement.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_preview_displacement(
            IntPtr context,
            CrumpleInstance instance,
            CrumpleDisplacementDef* def,
            CrumpleHitResult* outResult);

        /// <summary>
        /// Ends a contact. Its dent stays; later hits with the same id begin a new contact. Use contacts where the physics engine
        /// reports one contact as many small impulses. Give each of these hits the same contact_id, any number but 0, and end the
        /// contact when the bodies separate. They make the dent of the whole impulse, at any frame rate: their displacements add,
        /// and the place is the mean of their points weighted by displacement. Yield thresholds and depth limit apply to the sum.
        /// One mark is replaced as hits arrive. Ends and hits of one contact take effect at the next read, hits first. Reuse an
        /// id only after that read. Ending an unknown id is not an error. Contacts also end when the instance's damage is set,
        /// loaded, copied, repaired or reset. At most 256 are open; the one hit longest ago ends first. May be called from any
        /// thread at any time. Errors: <see cref="CrumpleResult.ErrorWrongRule"/> (a classic rule).
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_end_contact(
            IntPtr context,
            CrumpleInstance instance,
            ulong contactId);

        /// <summary>
        /// Copies an instance's marks, sorted, so that the same hits give the same marks in any order. marks has room for
        /// capacity marks; see "Arrays" at the top. <see cref="CrumpleResult.ErrorWrongRule"/>: classic rules have no marks.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_get_marks(
            IntPtr context,
            CrumpleInstance instance,
            CrumpleMark* marks,
            uint capacity,
            uint* outCount);

        /// <summary>
        /// Replaces an instance's marks by count marks of the same set. Discards pending hits and ends contacts. Errors:
        /// <see cref="CrumpleResult.ErrorInvalidArgument"/> (a mark that the set cannot have),
        /// <see cref="CrumpleResult.ErrorWrongRule"/>.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_set_marks(
            IntPtr context,
            CrumpleInstance instance,
            CrumpleMark* marks,
            uint count);

        /// <summary>
        /// Saves an instance's damage as bytes that are equal on all machines. They hold a version and the set's fingerprint.
        /// data has capacity bytes of any alignment; see "Arrays" at the top.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_save_damage(
            IntPtr context,
            CrumpleInstance instance,
            IntPtr data,
            UIntPtr capacity,
            UIntPtr* outSize);

        /// <summary>
        /// Replaces an instance's damage by size saved bytes of any alignment. Discards pending hits and ends contacts. Errors:
        /// <see cref="CrumpleResult.ErrorDamageMismatch"/> (another set, version or rule, or cut short),
        /// <see cref="CrumpleResult.ErrorInvalidArgument"/> (a mark that the set cannot have).
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_load_damage(
            IntPtr context,
            CrumpleInstance instance,
            IntPtr data,
            UIntPtr size);

        /// <summary>
        /// Repairs an instance: every dent keeps this share of its depth, 0 (as new) to 1 (unchanged). Ends contacts.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_repair_damage(
            IntPtr context,
            CrumpleInstance instance,
            float keep);

        /// <summary>
        /// Makes an instance as new. Discards pending hits and ends contacts.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_reset_damage(IntPtr context, CrumpleInstance instance);

        /// <summary>
        /// Replaces an instance's damage by that of source, an instance with an equal set and the same kind of rule. Discards the
        /// instance's pending hits and ends its contacts. Copying from itself does nothing.
        /// <see cref="CrumpleResult.ErrorDamageMismatch"/>: another set or rule.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_copy_damage(
            IntPtr context,
            CrumpleInstance instance,
            CrumpleInstance source);

        /// <summary>
        /// A buffer without memory. Set its streams.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleHostBufferDef crumple_host_buffer_def_default();

        /// <summary>
        /// Registers your memory for an instance's deformed vertices. The first deform writes every vertex. An instance may have
        /// several buffers, such as the members of a ring; each is brought up to date by itself. Only
        /// <see cref="Native.NativeMethods.crumple_context_deform"/> touches the memory. It must exist until the buffer is
        /// unregistered or set to other memory, or until its instance or context is destroyed. Memory of different buffers must
        /// not overlap; debug builds of the library check this. Errors: <see cref="CrumpleResult.ErrorMesh"/> (normals or
        /// tangents that the mesh lacks), <see cref="CrumpleResult.ErrorWrongRule"/> (lod above 0 with a classic rule).
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_buffer_register_host(
            IntPtr context,
            CrumpleInstance instance,
            CrumpleHostBufferDef* def,
            CrumpleBuffer* outBuffer);

        /// <summary>
        /// Ends a buffer. The memory is yours alone again; a VkBuffer is once the frames that wrote it are complete.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_buffer_unregister(IntPtr context, CrumpleBuffer buffer);

        /// <summary>
        /// Declares a buffer's contents lost or overwritten. The next deform or recording writes every vertex.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_buffer_invalidate(IntPtr context, CrumpleBuffer buffer);

        /// <summary>
        /// Gives a host buffer other memory, perhaps for another level of detail, and invalidates it. After an error the buffer
        /// keeps its memory. Errors as for <see cref="Native.NativeMethods.crumple_buffer_register_host"/>.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_buffer_set_memory(
            IntPtr context,
            CrumpleBuffer buffer,
            CrumpleHostBufferDef* def);

        /// <summary>
        /// Brings host buffers up to date: count ids at buffers, each once, or all host buffers of the context with null and 0.
        /// Writes only what changed since the last write of each buffer, in parallel over all of them. Without changes it is
        /// cheap. An unseen instance needs no deform: its next deform includes all its hits, at 8 to 20 microseconds each. The
        /// buffers' memory must not be read or written during the call. out_report may be null.
        /// <see cref="CrumpleResult.ErrorInvalidArgument"/>: a buffer twice, a Vulkan buffer, or overlapping memory in debug
        /// builds. No vertex is written then.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_context_deform(
            IntPtr context,
            CrumpleBuffer* buffers,
            uint count,
            CrumpleDeformReport* outReport);

        /// <summary>
        /// Returns the vertices that the last deform or recording that included the buffer wrote (null as buffers includes all),
        /// as increasing, separate ranges, and the bounds of all its vertices, m. Use them for uploads, refits and culling.
        /// Bounds of a Vulkan buffer may be too large. ranges has room for capacity ranges; see "Arrays" at the top. out_bounds
        /// may be null.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_buffer_get_changes(
            IntPtr context,
            CrumpleBuffer buffer,
            CrumpleRange* ranges,
            uint capacity,
            uint* outCount,
            CrumpleAabb* outBounds);

        /// <summary>
        /// A device def without handles. Set them and the queue family.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleVulkanAttachDef crumple_vulkan_attach_def_default();

        /// <summary>
        /// A range def without buffer, read as vertices. Set buffer, buffer_size, usage, size and streams.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleVulkanBufferDef crumple_vulkan_buffer_def_default();

        /// <summary>
        /// Attaches your Vulkan device, one per context. Takes some tenths of a millisecond. The handles must be valid, belong
        /// together, and live until <see cref="Native.NativeMethods.crumple_vulkan_detach"/> or
        /// <see cref="Native.NativeMethods.crumple_context_destroy"/>. Errors: <see cref="CrumpleResult.ErrorInvalidArgument"/>
        /// (a device is attached, the queue family does not exist or lacks compute, workgroup_size),
        /// <see cref="CrumpleResult.ErrorUnsupported"/> (below Vulkan 1.1, a loader that lacks a function, or a build without
        /// <see cref="CrumpleFeatures.Vulkan"/>).
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_vulkan_attach(IntPtr context, CrumpleVulkanAttachDef* def);

        /// <summary>
        /// Detaches the Vulkan device. Ends all Vulkan buffers and destroys Crumple's objects on the device. Damage stays. After
        /// <see cref="CrumpleResult.ErrorDeviceLost"/>: call <see cref="Native.NativeMethods.crumple_vulkan_complete_frames"/>
        /// with UINT64_MAX, then this, then vkDestroyDevice. Attach the new device and register the buffers again.
        /// <see cref="CrumpleResult.ErrorFramesInFlight"/>: nothing was changed.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_vulkan_detach(IntPtr context);

        /// <summary>
        /// Returns pipeline cache data for the next run's <see cref="Native.NativeMethods.crumple_vulkan_attach"/>. data has
        /// capacity bytes of any alignment; see "Arrays" at the top. The size may grow until every kind of buffer was registered.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_vulkan_get_pipeline_cache(
            IntPtr context,
            IntPtr data,
            UIntPtr capacity,
            UIntPtr* outSize);

        /// <summary>
        /// Registers a range of a VkBuffer for an instance's deformed vertices. The first recording writes every vertex. An
        /// instance may have several ranges, such as the members of a ring. A mesh's first range copies its vertices and examples
        /// to a staging buffer, and the next recording copies them to the device; all instances and ranges share them. The
        /// VkBuffer must exist until its last range has ended and the frames that wrote it are complete. Errors:
        /// <see cref="CrumpleResult.ErrorInvalidArgument"/> (no device, stages of 0, an unsupported format, overlapping
        /// attributes, a scale not above 0, a VkBuffer that is registered with another description),
        /// <see cref="CrumpleResult.ErrorWrongRule"/> (lod above 0 with a classic rule),
        /// <see cref="CrumpleResult.ErrorUnsupported"/> (normals or tangents that the mesh lacks; more bytes than the device can
        /// bind).
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_buffer_register_vulkan(
            IntPtr context,
            CrumpleInstance instance,
            CrumpleVulkanBufferDef* def,
            CrumpleBuffer* outBuffer);

        /// <summary>
        /// Records commands that bring Vulkan buffers up to date: count ids at buffers, each once, or all Vulkan buffers of the
        /// context with null and 0. For the blocks that changed it records a copy of a few bytes per block, a barrier, one
        /// dispatch per VkBuffer and a barrier. It submits nothing and waits for nothing. Does not allocate in steady state.
        /// Damage may change at once after the call.
        /// </summary>
        /// <remarks>
        /// <para>command_buffer is a VkCommandBuffer in the recording state, outside a render pass, of the attached queue family,
        /// whose pool no other thread uses. Submit it once, in the order of recording. frame is your frame number, from 1 on,
        /// never falling; several recordings may share one. out_report may be null.</para>
        /// <para>The commands change the compute pipeline, compute descriptor sets 0 to 2, and the first 24 bytes of compute push
        /// constants, nothing else. Errors: <see cref="CrumpleResult.ErrorInvalidArgument"/> (no device of yours, a buffer twice,
        /// a host buffer, a frame that is complete or lower than the last), <see cref="CrumpleResult.ErrorUnsupported"/> (more
        /// work than the device can bind). Nothing is recorded then.</para>
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
        /// Declares frame and all earlier ones complete on the device, as a fence or timeline semaphore says. Their resources are
        /// reused or freed. Call it once a frame; it is cheap. Numbers above the last recorded frame count as that frame.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_vulkan_complete_frames(IntPtr context, ulong frame);

        /// <summary>
        /// Declares that the recordings of frame and later ones will not be submitted. Their buffers are written whole by the
        /// next recording.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_vulkan_discard_frames(IntPtr context, ulong frame);

        /// <summary>
        /// Any physical device. Set the loader and the UUID.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleVulkanOpenDef crumple_vulkan_open_def_default();

        /// <summary>
        /// An import without memory. Set handle, sizes, memory type and usage.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleVulkanImportDef crumple_vulkan_import_def_default();

        /// <summary>
        /// Creates a Vulkan device of Crumple's own, for engines that can share memory but cannot hand out a command buffer.
        /// Takes milliseconds to tenths of a second. Use it instead of <see cref="Native.NativeMethods.crumple_vulkan_attach"/>:
        /// import buffers, register them, and write them with <see cref="Native.NativeMethods.crumple_vulkan_submit"/>.
        /// <see cref="Native.NativeMethods.crumple_vulkan_detach"/> and
        /// <see cref="Native.NativeMethods.crumple_context_destroy"/> wait for the device and destroy it. Errors:
        /// <see cref="CrumpleResult.ErrorInvalidArgument"/> (a device is attached, workgroup_size),
        /// <see cref="CrumpleResult.ErrorUnsupported"/> (no such device, no import of memory, or a build without
        /// <see cref="CrumpleFeatures.Vulkan"/>).
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_vulkan_open(IntPtr context, CrumpleVulkanOpenDef* def);

        /// <summary>
        /// Imports a buffer of your device into Crumple's device. out_buffer is the buffer field for
        /// <see cref="CrumpleVulkanBufferDef"/>, whose buffer_size, usage, queue_family, stages and accesses are then ignored.
        /// Before each submit, release the VkBuffer to VK_QUEUE_FAMILY_EXTERNAL on your queue; acquire it afterwards. The memory
        /// must exist until <see cref="Native.NativeMethods.crumple_vulkan_unimport_buffer"/>,
        /// <see cref="Native.NativeMethods.crumple_vulkan_detach"/> or
        /// <see cref="Native.NativeMethods.crumple_context_destroy"/>. Errors: <see cref="CrumpleResult.ErrorInvalidArgument"/>
        /// (no device of <see cref="Native.NativeMethods.crumple_vulkan_open"/>, a bad handle, an unsuitable memory type or
        /// usage), <see cref="CrumpleResult.ErrorUnsupported"/> (a handle type of another system, or a buffer that the device
        /// cannot import).
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_vulkan_import_buffer(
            IntPtr context,
            CrumpleVulkanImportDef* def,
            ulong* outBuffer);

        /// <summary>
        /// Ends an imported buffer after the device is done with it. <see cref="CrumpleResult.ErrorInvalidArgument"/>: ranges of
        /// it are registered.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_vulkan_unimport_buffer(IntPtr context, ulong buffer);

        /// <summary>
        /// Imports a binary semaphore of your device, exported with this handle type. out_semaphore is its number for
        /// <see cref="Native.NativeMethods.crumple_vulkan_submit"/>. It lives until
        /// <see cref="Native.NativeMethods.crumple_vulkan_detach"/> or
        /// <see cref="Native.NativeMethods.crumple_context_destroy"/>. Errors: <see cref="CrumpleResult.ErrorInvalidArgument"/>
        /// (no device of <see cref="Native.NativeMethods.crumple_vulkan_open"/>, a bad handle),
        /// <see cref="CrumpleResult.ErrorUnsupported"/> (a driver without external semaphores; use fences and
        /// <see cref="Native.NativeMethods.crumple_vulkan_wait_frame"/>).
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_vulkan_import_semaphore(
            IntPtr context,
            CrumpleHandleType handleType,
            long handle,
            ulong* outSemaphore);

        /// <summary>
        /// As <see cref="Native.NativeMethods.crumple_vulkan_record"/>, but records for Crumple's own device and submits. The
        /// device waits for wait_count semaphores at waits first and signals signal_count semaphores at signals last, even
        /// without changes. The call itself does not wait. out_frame is the frame number for
        /// <see cref="Native.NativeMethods.crumple_vulkan_wait_frame"/>. out_frame and out_report may be null. Nothing is
        /// submitted after an error.
        /// </summary>
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
        /// Waits until Crumple's own device has completed a frame and all earlier ones, or for timeout nanoseconds (UINT64_MAX:
        /// without limit). out_done is whether it is complete. The context stays in use meanwhile.
        /// <see cref="CrumpleResult.ErrorInvalidArgument"/>: the frame was not submitted.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_vulkan_wait_frame(
            IntPtr context,
            ulong frame,
            ulong timeout,
            CrumpleBool* outDone);

        /// <summary>
        /// Binds a point in the mesh's space, m, to the nearest surface. The point keeps its distance from the surface and turns
        /// with it. <see cref="CrumpleResult.ErrorInvalidArgument"/>: the point is further away than 1e9 m.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_attach_point(
            IntPtr context,
            CrumpleExampleSet set,
            CrumpleVec3 point,
            CrumpleAttachment* outAttachment);

        /// <summary>
        /// Returns the place of an attached point on the dented instance, including pending hits. Uses no buffer. Errors:
        /// <see cref="CrumpleResult.ErrorIndexOutOfRange"/> or <see cref="CrumpleResult.ErrorInvalidArgument"/> (an attachment of
        /// another set, or one that is not of <see cref="Native.NativeMethods.crumple_example_set_attach_point"/>).
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_get_attached_frame(
            IntPtr context,
            CrumpleInstance instance,
            CrumpleAttachment* attachment,
            CrumpleFrame* outFrame);

        /// <summary>
        /// Records the context's calls to a file, path in UTF-8. "crumple replay FILE" makes the same calls without your engine
        /// and checks that every result and vertex is equal: a bug becomes a test. The file starts with the existing sets,
        /// instances, damage and buffers. It grows by some hundred bytes per hit and frame, written at once, so that a crash
        /// loses nothing. The next deform writes every buffer whole. Vulkan buffers are replayed on the CPU and not compared.
        /// Refused calls are noted with their message. Hits wait for each other while recording, so leave it off in releases.
        /// Submits are serialised, but may arrive meanwhile. Errors: <see cref="CrumpleResult.ErrorInvalidArgument"/> (a
        /// recording runs, or an instance has open contacts), <see cref="CrumpleResult.ErrorIo"/>,
        /// <see cref="CrumpleResult.ErrorUnsupported"/> (a big-endian processor).
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_recording_begin(IntPtr context, IntPtr path);

        /// <summary>
        /// Ends the recording and completes the file. <see cref="Native.NativeMethods.crumple_context_destroy"/> does so too.
        /// <see cref="CrumpleResult.ErrorIo"/>: the file could not be completed; its content can be replayed, and the recording
        /// has ended.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_recording_end(IntPtr context);
    }
}
