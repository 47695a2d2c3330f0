// Generated from the headers in include by `cargo xtask header`; do not edit it. They document what is declared here. C# lays out
// structs as C does; tests compare them with a C compiler's.
#pragma warning disable 1591

using System;
using System.Runtime.InteropServices;

namespace Crumple.Native
{
    /// <summary>
    /// The functions of the C headers. Call <see cref="CrumpleRuntime.EnsureLoaded"/> first: it says what is wrong with a library that is
    /// missing or does not fit.
    /// </summary>
    public static unsafe class NativeMethods
    {
        // The file name without the prefix and suffix that systems add.
        public const string Library = "crumple";
        public const uint VersionMajor = 0;
        public const uint VersionMinor = 2;
        public const uint VersionPatch = 0;
        public const uint Version = (((VersionMajor * 1000000) + (VersionMinor * 1000)) + VersionPatch);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern uint crumple_version();
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern IntPtr crumple_version_string();
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ulong crumple_features();
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern IntPtr crumple_last_error();
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern IntPtr crumple_result_name(CrumpleResult result);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleContextDef crumple_context_def_default();
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_context_create(CrumpleContextDef* def, IntPtr* outContext);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_context_destroy(IntPtr context);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_load_baked_memory(IntPtr context, IntPtr data, UIntPtr size,
            CrumpleBytes bytes, CrumpleExampleSet* outSet);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_load_baked(IntPtr context, IntPtr path,
            CrumpleExampleSet* outSet);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleBool crumple_example_set_is_valid(IntPtr context, CrumpleExampleSet set);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_destroy(IntPtr context, CrumpleExampleSet set);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_get_info(IntPtr context, CrumpleExampleSet set,
            CrumpleExampleSetInfo* outInfo);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleMeshCopyDef crumple_mesh_copy_def_default();
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_copy_mesh(IntPtr context, CrumpleExampleSet set,
            CrumpleMeshCopyDef* def);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleInstanceDef crumple_instance_def_default();
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_create(IntPtr context, CrumpleInstanceDef* def,
            CrumpleInstance* outInstance);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_destroy(IntPtr context, CrumpleInstance instance);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleBool crumple_instance_is_valid(IntPtr context, CrumpleInstance instance);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_set_user_data(IntPtr context, CrumpleInstance instance,
            ulong userData);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_get_user_data(IntPtr context, CrumpleInstance instance,
            ulong* outData);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_get_info(IntPtr context, CrumpleInstance instance,
            CrumpleInstanceInfo* outInfo);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_set_transform(IntPtr context, CrumpleInstance instance,
            float* localToWorld);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_set_depth_limit(IntPtr context, CrumpleInstance instance,
            float depthLimit);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleHitDef crumple_hit_def_default();
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_submit_hit(IntPtr context, CrumpleInstance instance,
            CrumpleHitDef* def, CrumpleHitResult* outResult);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_context_submit_hits(IntPtr context, CrumpleInstance* instances,
            CrumpleHitDef* defs, uint count, CrumpleHitResult* outResults);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_preview_hit(IntPtr context, CrumpleInstance instance,
            CrumpleHitDef* def, CrumpleHitResult* outResult);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleContactOptionsDef crumple_contact_options_def_default();
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_context_set_contact_options(IntPtr context,
            CrumpleContactOptionsDef* options);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleContactPointDef crumple_contact_point_def_default();
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_context_report_contacts(IntPtr context, CrumpleContactPointDef* points,
            uint count);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_context_step_contacts(IntPtr context, float seconds,
            CrumpleContactReport* outReport);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_context_clear_contacts(IntPtr context);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_get_marks(IntPtr context, CrumpleInstance instance,
            CrumpleMark* marks, uint capacity, uint* outCount);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_set_marks(IntPtr context, CrumpleInstance instance,
            CrumpleMark* marks, uint count);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_save_damage(IntPtr context, CrumpleInstance instance, IntPtr data,
            UIntPtr capacity, UIntPtr* outSize);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_load_damage(IntPtr context, CrumpleInstance instance, IntPtr data,
            UIntPtr size);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_context_save_damage(IntPtr context, CrumpleInstance* instances, uint count,
            IntPtr data, UIntPtr capacity, UIntPtr* outSize);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_context_load_damage(IntPtr context, CrumpleInstance* instances, uint count,
            IntPtr data, UIntPtr size);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_repair_damage(IntPtr context, CrumpleInstance instance,
            float keep);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_repair_around(IntPtr context, CrumpleInstance instance,
            CrumpleVec3 point, float radius, float keep);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_reset_damage(IntPtr context, CrumpleInstance instance);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_copy_damage(IntPtr context, CrumpleInstance instance,
            CrumpleInstance source);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleHostBufferDef crumple_host_buffer_def_default();
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_buffer_register_host(IntPtr context, CrumpleInstance instance,
            CrumpleHostBufferDef* def, CrumpleBuffer* outBuffer);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_buffer_unregister(IntPtr context, CrumpleBuffer buffer);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleBool crumple_buffer_is_valid(IntPtr context, CrumpleBuffer buffer);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_buffer_get_info(IntPtr context, CrumpleBuffer buffer,
            CrumpleBufferInfo* outInfo);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_buffer_invalidate(IntPtr context, CrumpleBuffer buffer);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_buffer_set_memory(IntPtr context, CrumpleBuffer buffer,
            CrumpleHostBufferDef* def);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_context_deform(IntPtr context, CrumpleBuffer* buffers, uint count,
            CrumpleDeformReport* outReport);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_context_get_changed_buffers(IntPtr context, CrumpleBufferInfo* buffers,
            uint capacity, uint* outCount);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_buffer_get_changes(IntPtr context, CrumpleBuffer buffer,
            CrumpleRange* ranges, uint capacity, uint* outCount, CrumpleAabb* outBounds);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleExampleDef crumple_example_def_default();
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleExampleSetDef crumple_example_set_def_default();
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_create(IntPtr context, CrumpleExampleSetDef* def,
            CrumpleExampleSet* outSet);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleMeshDef crumple_mesh_def_default();
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_add_lod(IntPtr context, CrumpleExampleSet set,
            CrumpleMeshDef* mesh, uint* outLod);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_save_baked(IntPtr context, CrumpleExampleSet set, IntPtr data,
            UIntPtr capacity, UIntPtr* outSize);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_mesh_keep_out(CrumpleMeshDef* mesh, CrumpleCapsule* capsules,
            uint capsuleCount, CrumpleMeshDef* meshes, uint meshCount, float* outLimits);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_get_example(IntPtr context, CrumpleExampleSet set,
            uint example, CrumpleExampleInfo* outInfo);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_map_damage(IntPtr context, CrumpleExampleSet set,
            CrumpleExampleSet oldSet, IntPtr data, UIntPtr size, float maxDistance, IntPtr mapped, UIntPtr capacity,
            UIntPtr* outSize, CrumpleDamageMapping* outMapping);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleGltfDef crumple_gltf_def_default();
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_load_gltf(IntPtr context, CrumpleGltfDef* def,
            CrumpleExampleSet* outSet);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_load_gltf_memory(IntPtr context, IntPtr data, UIntPtr size,
            CrumpleGltfDef* def, CrumpleExampleSet* outSet);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleObjDef crumple_obj_def_default();
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_load_obj(IntPtr context, CrumpleObjDef* def,
            CrumpleExampleSet* outSet);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_get_primitive(IntPtr context, CrumpleExampleSet set,
            uint primitive, CrumplePrimitive* outPrimitive);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_find_part(IntPtr context, CrumpleExampleSet set, IntPtr name,
            uint* outLod);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_get_part(IntPtr context, CrumpleExampleSet set, uint part,
            CrumplePart* outPart);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_release_part(IntPtr context, CrumpleInstance instance, uint part,
            CrumpleInstance* outPart);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_mount_part(IntPtr context, CrumpleInstance instance,
            CrumpleInstance part, CrumpleBool mounted);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_set_part_rigid(IntPtr context, CrumpleInstance instance,
            uint part, CrumpleBool rigid);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_measure_part(IntPtr context, CrumpleInstance instance, uint lod,
            float* outDeepest, float* outMean, float* outEquivalentDepth);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_attach_point(IntPtr context, CrumpleExampleSet set,
            CrumpleVec3 point, CrumpleAttachment* outAttachment);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_get_attached_pose(IntPtr context, CrumpleInstance instance,
            CrumpleAttachment* attachment, CrumplePose* outPose);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_example_set_find_nearest_vertex(IntPtr context, CrumpleExampleSet set,
            CrumpleVec3 point, uint* outVertex, float* outDistance);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_buffer_get_changed_triangles(IntPtr context, CrumpleBuffer buffer,
            CrumpleRange* ranges, uint capacity, uint* outCount, CrumpleAabb* outBounds);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_end_contact(IntPtr context, CrumpleInstance instance,
            ulong contactId);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_get_contact(IntPtr context, CrumpleInstance instance,
            ulong contactId, CrumpleHitResult* outResult);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_context_get_contact_hits(IntPtr context, CrumpleContactHit* hits,
            uint capacity, uint* outCount);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_context_get_contact_totals(IntPtr context,
            CrumpleContactReport* outReport);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_context_set_time(IntPtr context, double time);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_instance_set_view(IntPtr context, CrumpleInstance instance, float pixels,
            float distance, float fovY, float viewportHeight, uint* outLod);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CrumpleResult crumple_context_set_vertex_budget(IntPtr context, ulong vertices);
    }
}
