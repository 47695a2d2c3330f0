// Generated from include/crumple.h by `cargo xtask header`; do not edit it.

using System;
using System.Runtime.InteropServices;

namespace Crumple
{
    /// <summary>
    /// What this build of the library can do. Bits unknown to you may be set.
    /// </summary>
    [Flags]
    public enum CrumpleFeatures : ulong
    {
        /// <summary>
        /// Bit of <see cref="Native.NativeMethods.crumple_features"/>: the library loads glTF 2.0 and GLB files.
        /// </summary>
        Gltf = 1,
        /// <summary>
        /// Bit of <see cref="Native.NativeMethods.crumple_features"/>: the library loads OBJ files.
        /// </summary>
        Obj = 2,
        /// <summary>
        /// Bit of <see cref="Native.NativeMethods.crumple_features"/>: <see cref="Native.NativeMethods.crumple_allocator_set"/>
        /// works.
        /// </summary>
        HostAllocator = 4,
        /// <summary>
        /// Bit of <see cref="Native.NativeMethods.crumple_features"/>: <see cref="Native.NativeMethods.crumple_vulkan_attach"/>
        /// works.
        /// </summary>
        Vulkan = 8,
    }

    /// <summary>
    /// The result of a call. See "Results" at the top.
    /// </summary>
    public enum CrumpleResult
    {
        /// <summary>
        /// 
        /// </summary>
        Ok = 0,
        /// <summary>
        /// A value is outside its range, or the call is not allowed now.
        /// </summary>
        ErrorInvalidArgument = 1,
        /// <summary>
        /// A number is NaN or infinite.
        /// </summary>
        ErrorNotFinite = 2,
        /// <summary>
        /// An index is not below its count.
        /// </summary>
        ErrorIndexOutOfRange = 3,
        /// <summary>
        /// The base mesh cannot be used.
        /// </summary>
        ErrorMesh = 4,
        /// <summary>
        /// An example does not fit the base mesh, or there is no example.
        /// </summary>
        ErrorExampleMismatch = 5,
        /// <summary>
        /// An array has fewer bytes or elements than the call needs.
        /// </summary>
        ErrorBufferTooSmall = 6,
        /// <summary>
        /// A pointer, offset or stride is not a multiple of its alignment.
        /// </summary>
        ErrorMisaligned = 7,
        /// <summary>
        /// The point of a hit is further from the body than max_contact_distance. Often the point is in the wrong space.
        /// </summary>
        ErrorContactTooFar = 8,
        /// <summary>
        /// The input is valid, but this library or this build does not support it.
        /// </summary>
        ErrorUnsupported = 9,
        /// <summary>
        /// A file or saved bytes are malformed.
        /// </summary>
        ErrorFormat = 10,
        /// <summary>
        /// The operating system refused to read or write a file.
        /// </summary>
        ErrorIo = 11,
        /// <summary>
        /// Damage belongs to another example set, rule or version.
        /// </summary>
        ErrorDamageMismatch = 12,
        /// <summary>
        /// Memory ran out. See "Memory" at the top.
        /// </summary>
        ErrorOutOfMemory = 13,
        /// <summary>
        /// The call does not work with the instance's rule.
        /// </summary>
        ErrorWrongRule = 14,
        /// <summary>
        /// A Vulkan function failed.
        /// </summary>
        ErrorVulkan = 15,
        /// <summary>
        /// The Vulkan device is lost. Damage is not lost.
        /// </summary>
        ErrorDeviceLost = 16,
        /// <summary>
        /// A required pointer is null.
        /// </summary>
        ErrorNullPointer = 64,
        /// <summary>
        /// The struct_size of a def is wrong. Start from the def's crumple_..._def_default function.
        /// </summary>
        ErrorStructSize = 65,
        /// <summary>
        /// An id or a context is null, was destroyed, or belongs to another context.
        /// </summary>
        ErrorInvalidId = 66,
        /// <summary>
        /// Two threads used one context at once, or a callback called back into its context.
        /// </summary>
        ErrorConcurrentUse = 67,
        /// <summary>
        /// A defect of the library. Please report it with the text of <see cref="Native.NativeMethods.crumple_last_error"/>.
        /// </summary>
        ErrorInternal = 68,
        /// <summary>
        /// Recorded frames were not reported to <see cref="Native.NativeMethods.crumple_vulkan_complete_frames"/>.
        /// </summary>
        ErrorFramesInFlight = 69,
    }

    /// <summary>
    /// The severity of a log message.
    /// </summary>
    public enum CrumpleLogLevel
    {
        /// <summary>
        /// 
        /// </summary>
        Info = 0,
        /// <summary>
        /// Something that works but is probably a mistake.
        /// </summary>
        Warning = 1,
    }

    /// <summary>
    /// How the place where an example was hit is given.
    /// </summary>
    public enum CrumpleContactKind
    {
        /// <summary>
        /// Not given: Crumple uses the example's deepest vertex. The default.
        /// </summary>
        None = 0,
        /// <summary>
        /// As a vertex of the base mesh.
        /// </summary>
        Vertex = 1,
        /// <summary>
        /// As a point in the mesh's space. Its nearest vertex becomes the contact.
        /// </summary>
        Point = 2,
    }

    /// <summary>
    /// Whether an example may be carried away from where it was made.
    /// </summary>
    public enum CrumplePlacement
    {
        /// <summary>
        /// Anchored for a hit within a tenth of its support radius of its own contact and with 0.9 to 1 times its own depth;
        /// carried otherwise. The default.
        /// </summary>
        Automatic = 0,
        /// <summary>
        /// Always used where the artist made it: creases, frames, bumpers.
        /// </summary>
        Anchored = 1,
        /// <summary>
        /// Always moved to where the body was hit: sheet metal.
        /// </summary>
        Carried = 2,
    }

    /// <summary>
    /// The type of triangle indices. <see cref="CrumpleIndexType.U32"/> is the default.
    /// </summary>
    public enum CrumpleIndexType
    {
        /// <summary>
        /// 
        /// </summary>
        U32 = 0,
        /// <summary>
        /// 
        /// </summary>
        U16 = 1,
    }

    /// <summary>
    /// How the dents of several marks combine at a vertex. The direction is always that of their sum.
    /// </summary>
    public enum CrumpleCombine
    {
        /// <summary>
        /// Lengths add, up to the depth limit.
        /// </summary>
        Sum = 1,
        /// <summary>
        /// Energies add: the length is the root of the sum of squares. The default.
        /// </summary>
        Energies = 0,
        /// <summary>
        /// Only the deepest dent counts.
        /// </summary>
        Deepest = 2,
    }

    /// <summary>
    /// How an example is treated that moves vertices with the same base position apart.
    /// </summary>
    public enum CrumpleSeams
    {
        /// <summary>
        /// The vertices stay together: each gets the mean of their displacements. The default.
        /// </summary>
        Weld = 0,
        /// <summary>
        /// The vertices move apart as in the example: a tear that the artist made.
        /// </summary>
        Keep = 1,
    }

    /// <summary>
    /// Whether the bytes of a baked set are copied.
    /// </summary>
    public enum CrumpleBytes
    {
        /// <summary>
        /// The bytes are copied. Free them after the call.
        /// </summary>
        Copy = 0,
        /// <summary>
        /// The bytes are used in place. They must stay readable and unchanged until the set and its instances, or the context,
        /// are destroyed. Bytes that do not start at a multiple of 16 are copied.
        /// </summary>
        Keep = 1,
    }

    /// <summary>
    /// How hits damage an instance.
    /// </summary>
    public enum CrumpleRule
    {
        /// <summary>
        /// Each hit leaves a mark. Memory is bounded and the order of hits does not matter. The default.
        /// </summary>
        Marks = 0,
        /// <summary>
        /// The classic rule "most displaced" of the literature, for comparison. The order of hits matters. It has no marks and
        /// needs memory for each vertex.
        /// </summary>
        MostDisplaced = 1,
        /// <summary>
        /// The classic rule "blend", with blend_constant. Otherwise as <see cref="CrumpleRule.MostDisplaced"/>.
        /// </summary>
        Blend = 2,
    }

    /// <summary>
    /// How the examples for a hit are selected.
    /// </summary>
    public enum CrumpleSelection
    {
        /// <summary>
        /// <see cref="CrumpleSelection.Nearest"/> with marks, <see cref="CrumpleSelection.Classic"/> with a classic rule. The
        /// default.
        /// </summary>
        OfRule = 0,
        /// <summary>
        /// The examples that are most informative about the hit's place, depth and lean (the angle between the hit and the
        /// surface normal). Marks only.
        /// </summary>
        Nearest = 1,
        /// <summary>
        /// The one example that moves the contact vertex in the direction most like the target, with a weight of at most 1.
        /// </summary>
        Classic = 2,
        /// <summary>
        /// As <see cref="CrumpleSelection.Classic"/>, without the limit of the weight: diverges above 2. Classic rules only.
        /// </summary>
        ClassicUnclamped = 3,
    }

    /// <summary>
    /// The space that a hit is given in.
    /// </summary>
    public enum CrumpleSpace
    {
        /// <summary>
        /// The mesh's own space. The default.
        /// </summary>
        Local = 0,
        /// <summary>
        /// World space. The instance's transform maps it to the mesh's space.
        /// </summary>
        World = 1,
    }

    /// <summary>
    /// What became of a hit.
    /// </summary>
    public enum CrumpleHitStatus
    {
        /// <summary>
        /// It leaves a mark, or with a classic rule a deformation.
        /// </summary>
        Marked = 0,
        /// <summary>
        /// It is weaker than a yield threshold, or than a millionth of the depth limit.
        /// </summary>
        BelowYield = 1,
        /// <summary>
        /// No example moves the contact vertex towards the target.
        /// </summary>
        NothingReaches = 2,
    }

    /// <summary>
    /// The type of a handle to shared memory or to a semaphore.
    /// </summary>
    public enum CrumpleHandleType
    {
        /// <summary>
        /// A file descriptor, VK_EXTERNAL_MEMORY_HANDLE_TYPE_OPAQUE_FD_BIT. Crumple duplicates it; yours stays yours to close.
        /// Linux and Android.
        /// </summary>
        OpaqueFd = 0,
        /// <summary>
        /// A HANDLE, VK_EXTERNAL_MEMORY_HANDLE_TYPE_OPAQUE_WIN32_BIT. Windows. Untested.
        /// </summary>
        OpaqueWin32 = 1,
    }

    /// <summary>
    /// Returns size bytes aligned to align (a power of two, at least 16), or null. Must be thread-safe. Must not call Crumple,
    /// throw or jump out.
    /// </summary>
    [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
    public delegate IntPtr CrumpleAlloc(UIntPtr size, UIntPtr align, IntPtr user);

    /// <summary>
    /// Frees memory of <see cref="CrumpleAlloc"/>; size and align are those of its allocation. Must be thread-safe. Must not call
    /// Crumple, throw or jump out.
    /// </summary>
    [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
    public delegate void CrumpleFree(IntPtr pointer, UIntPtr size, UIntPtr align, IntPtr user);

    /// <summary>
    /// The host's allocator. Both functions are required.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleAllocatorDef
    {
        /// <summary>
        /// 
        /// </summary>
        public uint StructSize;
        /// <summary>
        /// 
        /// </summary>
        public IntPtr Alloc;
        /// <summary>
        /// 
        /// </summary>
        public IntPtr Free;
        /// <summary>
        /// Passed to both. May be null.
        /// </summary>
        public IntPtr User;

        /// <summary>
        /// The defaults, from <c>crumple_allocator_def_default()</c>: begin with these.
        /// </summary>
        /// <exception cref="CrumpleLibraryException">The native library is missing or does not fit.</exception>
        public static CrumpleAllocatorDef Default
        {
            get
            {
                CrumpleRuntime.EnsureLoaded();
                return Native.NativeMethods.crumple_allocator_def_default();
            }
        }
    }

    /// <summary>
    /// Receives one message, UTF-8, without a line break at its end. The text is valid during the callback. Runs on the thread
    /// that called Crumple. Must not call the same context, throw or jump out.
    /// </summary>
    [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
    public delegate void CrumpleLog(CrumpleLogLevel level, IntPtr message, IntPtr user);

    /// <summary>
    /// A task of a parallel-for. Call it with an index below count and with the task_data of <see cref="CrumpleParallelFor"/>.
    /// </summary>
    [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
    public delegate void CrumpleTask(uint index, IntPtr taskData);

    /// <summary>
    /// Your parallel-for: calls task(index, task_data) once for each index below count, on any threads and in any order, and
    /// returns when all calls have returned. Tasks do not block or throw and may run at once. Crumple itself runs an index that
    /// you leave out, and ignores a second call of an index. Crumple calls this function on the thread that called Crumple. It
    /// must not throw or jump out. Of the same context it may call only the functions that may be called at any time.
    /// </summary>
    [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
    public delegate void CrumpleParallelFor(uint count, IntPtr task, IntPtr taskData, IntPtr user);

    /// <summary>
    /// The host's job system. Zero everywhere: Crumple uses its own threads.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleTaskSystem
    {
        /// <summary>
        /// 
        /// </summary>
        public IntPtr ParallelFor;
        /// <summary>
        /// 
        /// </summary>
        public IntPtr User;
        /// <summary>
        /// Number of threads that can work at once; 0 counts as 1. It affects how work is split, never the result.
        /// </summary>
        public uint Workers;
    }

    /// <summary>
    /// Options of a context.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleContextDef
    {
        /// <summary>
        /// 
        /// </summary>
        public uint StructSize;
        /// <summary>
        /// Number of threads that deform, up to 1024. 0: one per core. 1: the calling thread only. Ignored where tasks is set.
        /// Default 0.
        /// </summary>
        public uint Threads;
        /// <summary>
        /// Receives messages. Default null: none.
        /// </summary>
        public IntPtr Log;
        /// <summary>
        /// 
        /// </summary>
        public IntPtr LogUser;
        /// <summary>
        /// 
        /// </summary>
        public CrumpleTaskSystem Tasks;

        /// <summary>
        /// The defaults, from <c>crumple_context_def_default()</c>: begin with these.
        /// </summary>
        /// <exception cref="CrumpleLibraryException">The native library is missing or does not fit.</exception>
        public static CrumpleContextDef Default
        {
            get
            {
                CrumpleRuntime.EnsureLoaded();
                return Native.NativeMethods.crumple_context_def_default();
            }
        }
    }

    /// <summary>
    /// An array that Crumple reads during the call. Element i is at data + i * stride. Count and type are stated where the array
    /// is used. Zero everywhere: absent.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleInput
    {
        /// <summary>
        /// First element, aligned to its type (4 bytes; 2 for 16-bit indices). Null: absent.
        /// </summary>
        public IntPtr Data;
        /// <summary>
        /// Readable bytes at data: at least (count - 1) * stride + the size of one element.
        /// </summary>
        public UIntPtr Size;
        /// <summary>
        /// Bytes from one element to the next: at least the size of one element, a multiple of its alignment. 0 is an error.
        /// </summary>
        public UIntPtr Stride;
    }

    /// <summary>
    /// A point or a vector.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleVec3
    {
        /// <summary>
        /// 
        /// </summary>
        public float X;
        /// <summary>
        /// 
        /// </summary>
        public float Y;
        /// <summary>
        /// 
        /// </summary>
        public float Z;
    }

    /// <summary>
    /// An example: the base mesh after a collision. Give target_positions, or delta_indices with position_deltas.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleExampleDef
    {
        /// <summary>
        /// 
        /// </summary>
        public uint StructSize;
        /// <summary>
        /// Number of vertices in delta_indices, position_deltas and normal_deltas.
        /// </summary>
        public uint DeltaCount;
        /// <summary>
        /// UTF-8 text, copied. Need not be unique. Null: empty.
        /// </summary>
        public IntPtr Name;
        /// <summary>
        /// Full form: the new position of every vertex, vertex_count times 3 floats, m, in the base mesh's order.
        /// </summary>
        public CrumpleInput TargetPositions;
        /// <summary>
        /// Full form: the new unit normals, vertex_count times 3 floats. Absent: computed. Needs normals of the base mesh.
        /// </summary>
        public CrumpleInput TargetNormals;
        /// <summary>
        /// Sparse form: indices of the moved vertices, strictly increasing, delta_count times uint32_t.
        /// </summary>
        public CrumpleInput DeltaIndices;
        /// <summary>
        /// Sparse form: their displacements, delta_count times 3 floats, m.
        /// </summary>
        public CrumpleInput PositionDeltas;
        /// <summary>
        /// Sparse form: the changes of their unit normals, delta_count times 3 floats. Absent: computed.
        /// </summary>
        public CrumpleInput NormalDeltas;
        /// <summary>
        /// 
        /// </summary>
        public CrumpleContactKind ContactKind;
        /// <summary>
        /// The vertex that was hit, for <see cref="CrumpleContactKind.Vertex"/>.
        /// </summary>
        public uint ContactVertex;
        /// <summary>
        /// The point that was hit, m, in the mesh's space, for <see cref="CrumpleContactKind.Point"/>.
        /// </summary>
        public CrumpleVec3 ContactPoint;
        /// <summary>
        /// The surface's outward direction at the contact, of any length above 0. Used where has_contact_normal is true.
        /// </summary>
        public CrumpleVec3 ContactNormal;
        /// <summary>
        /// Whether contact_normal is given. Default false: the mesh's normal is used.
        /// </summary>
        public CrumpleBool HasContactNormal;
        /// <summary>
        /// 
        /// </summary>
        public CrumplePlacement Placement;

        /// <summary>
        /// The defaults, from <c>crumple_example_def_default()</c>: begin with these.
        /// </summary>
        /// <exception cref="CrumpleLibraryException">The native library is missing or does not fit.</exception>
        public static CrumpleExampleDef Default
        {
            get
            {
                CrumpleRuntime.EnsureLoaded();
                return Native.NativeMethods.crumple_example_def_default();
            }
        }
    }

    /// <summary>
    /// A mesh as arrays, which are copied. Part of the defs that contain it, which set its defaults.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleMeshDef
    {
        /// <summary>
        /// Number of vertices, at least 1. Their order is kept.
        /// </summary>
        public uint VertexCount;
        /// <summary>
        /// Number of indices, a multiple of 3.
        /// </summary>
        public uint IndexCount;
        /// <summary>
        /// Positions: vertex_count times 3 floats, m. Any handedness, any axis up. Required.
        /// </summary>
        public CrumpleInput Positions;
        /// <summary>
        /// Unit normals: vertex_count times 3 floats. Absent: computed from the triangles, smooth across seams.
        /// </summary>
        public CrumpleInput Normals;
        /// <summary>
        /// Tangents as in glTF: vertex_count times 4 floats, xyz of unit length, w +1 or -1. Absent: none.
        /// </summary>
        public CrumpleInput Tangents;
        /// <summary>
        /// Triangles: index_count indices, counter-clockwise seen from outside. Absent: a point cloud, whose normals must be
        /// given.
        /// </summary>
        public CrumpleInput Indices;
        /// <summary>
        /// 
        /// </summary>
        public CrumpleIndexType IndexType;
    }

    /// <summary>
    /// How an example set is built. Part of the defs that build one, which set its defaults.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleExampleSetOptions
    {
        /// <summary>
        /// No vertex moves further than this, m. Default 0: the depth of the deepest example.
        /// </summary>
        public float DepthLimit;
        /// <summary>
        /// Displacements of an example up to this length are dropped, m. Default 0: only zeros.
        /// </summary>
        public float DropBelow;
        /// <summary>
        /// Mass of every vertex, kg, for impulses without a mass: a calibration constant in impulse * duration / mass, not the
        /// body's mass. Default 0: unknown.
        /// </summary>
        public float VertexMass;
        /// <summary>
        /// Nodes along each side of the grid that stores a carried example: 4 to 128. Default 32; sharp creases need more. With a
        /// bake_tolerance, this is the maximum.
        /// </summary>
        public uint StampResolution;
        /// <summary>
        /// Largest position error from quantisation at weight 1, m. Displacements are then stored as integers of 1 or 2 bytes,
        /// carried examples on the coarsest grid within the error. Default 0: exact floats. Changes the fingerprint; depth_limit
        /// and vertex_mass do not.
        /// </summary>
        public float BakeTolerance;
        /// <summary>
        /// Largest error of a normal at weight 1, degrees, above 0 and up to 45. Used with a bake_tolerance. Default 1.
        /// </summary>
        public float BakeNormalTolerance;
        /// <summary>
        /// Mass of each vertex, kg: vertex_count floats, instead of vertex_mass. Default absent.
        /// </summary>
        public CrumpleInput VertexMasses;
        /// <summary>
        /// 
        /// </summary>
        public CrumpleCombine Combine;
        /// <summary>
        /// 
        /// </summary>
        public CrumpleSeams Seams;
        /// <summary>
        /// Carried examples are never scaled above their own depth, as anchored ones never are. Default false.
        /// </summary>
        public CrumpleBool Strict;
        /// <summary>
        /// Also use mirrored copies of the examples where the body is symmetric in a coordinate plane through the centre of its
        /// bounds. Default true.
        /// </summary>
        public CrumpleBool Mirror;
        /// <summary>
        /// Fade carried dents to zero at boundary edges that no example moves. Default true.
        /// </summary>
        public CrumpleBool HeldRims;
    }

    /// <summary>
    /// A base mesh with its examples, at least 1, and how the set is built.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleExampleSetDef
    {
        /// <summary>
        /// 
        /// </summary>
        public uint StructSize;
        /// <summary>
        /// 
        /// </summary>
        public uint ExampleCount;
        /// <summary>
        /// 
        /// </summary>
        public CrumpleMeshDef Mesh;
        /// <summary>
        /// example_count defs, each from <see cref="Native.NativeMethods.crumple_example_def_default"/>.
        /// </summary>
        public IntPtr Examples;
        /// <summary>
        /// 
        /// </summary>
        public CrumpleExampleSetOptions Options;

        /// <summary>
        /// The defaults, from <c>crumple_example_set_def_default()</c>: begin with these.
        /// </summary>
        /// <exception cref="CrumpleLibraryException">The native library is missing or does not fit.</exception>
        public static CrumpleExampleSetDef Default
        {
            get
            {
                CrumpleRuntime.EnsureLoaded();
                return Native.NativeMethods.crumple_example_set_def_default();
            }
        }
    }

    /// <summary>
    /// A base mesh with its examples: immutable, shared by any number of instances. An id; zero is null.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleExampleSet
    {
        /// <summary>
        /// 
        /// </summary>
        public uint Index;
        /// <summary>
        /// 
        /// </summary>
        public ushort Generation;
        /// <summary>
        /// 
        /// </summary>
        public ushort Context;
    }

    /// <summary>
    /// Another mesh of a set's body, such as a level of detail, in the base mesh's space.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleLodDef
    {
        /// <summary>
        /// 
        /// </summary>
        public uint StructSize;
        /// <summary>
        /// 
        /// </summary>
        public CrumpleMeshDef Mesh;

        /// <summary>
        /// The defaults, from <c>crumple_lod_def_default()</c>: begin with these.
        /// </summary>
        /// <exception cref="CrumpleLibraryException">The native library is missing or does not fit.</exception>
        public static CrumpleLodDef Default
        {
            get
            {
                CrumpleRuntime.EnsureLoaded();
                return Native.NativeMethods.crumple_lod_def_default();
            }
        }
    }

    /// <summary>
    /// Which mesh of a glTF file to load, and how the set is built.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleGltfDef
    {
        /// <summary>
        /// 
        /// </summary>
        public uint StructSize;
        /// <summary>
        /// Index of the mesh in the file, used where mesh_name is null. Default UINT32_MAX: the first mesh with morph targets.
        /// </summary>
        public uint MeshIndex;
        /// <summary>
        /// Name of the mesh, UTF-8. Default null: mesh_index decides.
        /// </summary>
        public IntPtr MeshName;
        /// <summary>
        /// Path of the .glb or .gltf file, UTF-8. For <see cref="Native.NativeMethods.crumple_example_set_load_gltf_memory"/>:
        /// the folder of files that the glTF refers to; null makes such files an error.
        /// </summary>
        public IntPtr Path;
        /// <summary>
        /// 
        /// </summary>
        public CrumpleExampleSetOptions Options;

        /// <summary>
        /// The defaults, from <c>crumple_gltf_def_default()</c>: begin with these.
        /// </summary>
        /// <exception cref="CrumpleLibraryException">The native library is missing or does not fit.</exception>
        public static CrumpleGltfDef Default
        {
            get
            {
                CrumpleRuntime.EnsureLoaded();
                return Native.NativeMethods.crumple_gltf_def_default();
            }
        }
    }

    /// <summary>
    /// A base OBJ file with its example files, and how the set is built.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleObjDef
    {
        /// <summary>
        /// 
        /// </summary>
        public uint StructSize;
        /// <summary>
        /// Number of example_paths, at least 1.
        /// </summary>
        public uint ExampleCount;
        /// <summary>
        /// Path of the base mesh, UTF-8. Required.
        /// </summary>
        public IntPtr BasePath;
        /// <summary>
        /// Paths of the examples, UTF-8. Each has the vertices of the base mesh in the same order.
        /// </summary>
        public IntPtr ExamplePaths;
        /// <summary>
        /// 
        /// </summary>
        public CrumpleExampleSetOptions Options;

        /// <summary>
        /// The defaults, from <c>crumple_obj_def_default()</c>: begin with these.
        /// </summary>
        /// <exception cref="CrumpleLibraryException">The native library is missing or does not fit.</exception>
        public static CrumpleObjDef Default
        {
            get
            {
                CrumpleRuntime.EnsureLoaded();
                return Native.NativeMethods.crumple_obj_def_default();
            }
        }
    }

    /// <summary>
    /// An array that Crumple writes. Element i is at data + offset + i * stride. Positions and normals are 3 floats, tangents 4
    /// floats, indices one uint32_t. Bytes between elements are not touched, so streams may be interleaved. Zero everywhere:
    /// absent.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleStream
    {
        /// <summary>
        /// Start of the memory, aligned to 4 bytes. Null: absent.
        /// </summary>
        public IntPtr Data;
        /// <summary>
        /// Writable bytes at data: at least offset + (count - 1) * stride + the size of one element.
        /// </summary>
        public UIntPtr Size;
        /// <summary>
        /// Bytes from data to the first element, a multiple of 4.
        /// </summary>
        public UIntPtr Offset;
        /// <summary>
        /// Bytes from one element to the next: at least the size of one element, a multiple of 4. 0 is an error.
        /// </summary>
        public UIntPtr Stride;
    }

    /// <summary>
    /// Where a set's mesh is copied to: positions (m), unit normals, tangents, and 3 * triangle_count indices. Absent streams are
    /// skipped.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleMeshCopyDef
    {
        /// <summary>
        /// 
        /// </summary>
        public uint StructSize;
        /// <summary>
        /// Which mesh: 0 for the base mesh, or a number of <see cref="Native.NativeMethods.crumple_example_set_add_lod"/>.
        /// Default 0.
        /// </summary>
        public uint Lod;
        /// <summary>
        /// 
        /// </summary>
        public CrumpleStream Positions;
        /// <summary>
        /// 
        /// </summary>
        public CrumpleStream Normals;
        /// <summary>
        /// 
        /// </summary>
        public CrumpleStream Tangents;
        /// <summary>
        /// 
        /// </summary>
        public CrumpleStream Indices;

        /// <summary>
        /// The defaults, from <c>crumple_mesh_copy_def_default()</c>: begin with these.
        /// </summary>
        /// <exception cref="CrumpleLibraryException">The native library is missing or does not fit.</exception>
        public static CrumpleMeshCopyDef Default
        {
            get
            {
                CrumpleRuntime.EnsureLoaded();
                return Native.NativeMethods.crumple_mesh_copy_def_default();
            }
        }
    }

    /// <summary>
    /// An axis-aligned box, m.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleAabb
    {
        /// <summary>
        /// 
        /// </summary>
        public CrumpleVec3 Min;
        /// <summary>
        /// 
        /// </summary>
        public CrumpleVec3 Max;
    }

    /// <summary>
    /// Facts about an example set; counts and bounds are those of the base mesh. Its strings are valid until the set is
    /// destroyed.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public unsafe partial struct CrumpleExampleSetInfo
    {
        /// <summary>
        /// Name of the mesh in its file, UTF-8; empty for a set built from arrays. Never null.
        /// </summary>
        public IntPtr Name;
        /// <summary>
        /// Equal for equal sets, on any machine. Saved damage fits sets of one fingerprint.
        /// </summary>
        public ulong Fingerprint;
        /// <summary>
        /// 
        /// </summary>
        public ulong MemoryBytes;
        /// <summary>
        /// 
        /// </summary>
        public uint VertexCount;
        /// <summary>
        /// 
        /// </summary>
        public uint TriangleCount;
        /// <summary>
        /// 
        /// </summary>
        public uint ExampleCount;
        /// <summary>
        /// Parts of the mesh with their own material, at least 1.
        /// </summary>
        public uint PrimitiveCount;
        /// <summary>
        /// Number of positions that several vertices share.
        /// </summary>
        public uint SeamCount;
        /// <summary>
        /// No vertex moves further than this, m.
        /// </summary>
        public float DepthLimit;
        /// <summary>
        /// 
        /// </summary>
        public CrumpleAabb Bounds;
        /// <summary>
        /// World matrix of the first node that shows the mesh, column-major; the identity if there is none.
        /// </summary>
        public fixed float NodeTransform[16];
        /// <summary>
        /// 
        /// </summary>
        public CrumpleBool HasTangents;
        /// <summary>
        /// Number of meshes: 1 + added levels of detail.
        /// </summary>
        public uint LodCount;
        /// <summary>
        /// 
        /// </summary>
        public fixed ulong Reserved[4];
    }

    /// <summary>
    /// Facts about an example. Its name, UTF-8, is valid until the set is destroyed, and never null.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public unsafe partial struct CrumpleExampleInfo
    {
        /// <summary>
        /// 
        /// </summary>
        public IntPtr Name;
        /// <summary>
        /// The vertex that was hit, or the deepest vertex.
        /// </summary>
        public uint ContactVertex;
        /// <summary>
        /// Number of vertices that it moves. 0: it has no effect.
        /// </summary>
        public uint MovedVertices;
        /// <summary>
        /// Where it was hit, m.
        /// </summary>
        public CrumpleVec3 ContactPoint;
        /// <summary>
        /// Outward unit normal at the contact; zero if unknown.
        /// </summary>
        public CrumpleVec3 ContactNormal;
        /// <summary>
        /// Displacement of the contact vertex, m.
        /// </summary>
        public float Depth;
        /// <summary>
        /// Displacement of the deepest vertex, m.
        /// </summary>
        public float MaxDepth;
        /// <summary>
        /// Distance from the contact to the furthest vertex that moves noticeably, m.
        /// </summary>
        public float SupportRadius;
        /// <summary>
        /// 
        /// </summary>
        public CrumplePlacement Placement;
        /// <summary>
        /// 
        /// </summary>
        public fixed ulong Reserved[2];
    }

    /// <summary>
    /// A part of the mesh with its own material, whose name (UTF-8) is null if it has none and is valid until the set is
    /// destroyed.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public unsafe partial struct CrumplePrimitive
    {
        /// <summary>
        /// 
        /// </summary>
        public IntPtr Material;
        /// <summary>
        /// 
        /// </summary>
        public uint FirstVertex;
        /// <summary>
        /// 
        /// </summary>
        public uint VertexCount;
        /// <summary>
        /// First triangle. Its first index is 3 * first_triangle.
        /// </summary>
        public uint FirstTriangle;
        /// <summary>
        /// 
        /// </summary>
        public uint TriangleCount;
        /// <summary>
        /// 
        /// </summary>
        public fixed uint Reserved[2];
    }

    /// <summary>
    /// Options of an instance.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public unsafe partial struct CrumpleInstanceDef
    {
        /// <summary>
        /// 
        /// </summary>
        public uint StructSize;
        /// <summary>
        /// Most examples that one hit may mix: 1 to 4. Default 3.
        /// </summary>
        public uint ExamplesPerHit;
        /// <summary>
        /// The example set, which the instance keeps alive. Required.
        /// </summary>
        public CrumpleExampleSet Set;
        /// <summary>
        /// 
        /// </summary>
        public CrumpleRule Rule;
        /// <summary>
        /// 
        /// </summary>
        public CrumpleSelection Selection;
        /// <summary>
        /// Most marks kept, 1 to 65535, 32 bytes each. Above it, the weakest mark is merged into the nearest mark. Default 64.
        /// </summary>
        public uint MarkCapacity;
        /// <summary>
        /// No vertex moves further than this, m. Default 0: the set's limit.
        /// </summary>
        public float DepthLimit;
        /// <summary>
        /// Shorter impulses leave no mark, N s, in the hit's space. Default 0.
        /// </summary>
        public float YieldImpulse;
        /// <summary>
        /// Hits with a shorter target leave no mark, m, in the mesh's space. Default 0.
        /// </summary>
        public float YieldDisplacement;
        /// <summary>
        /// Hits further than this from the nearest vertex are refused, m, in the mesh's space. Default 0: the body's diagonal.
        /// </summary>
        public float MaxContactDistance;
        /// <summary>
        /// Constant of <see cref="CrumpleRule.Blend"/>, 0 to 1. Default 0.
        /// </summary>
        public float BlendConstant;
        /// <summary>
        /// Largest position error, m; see <see cref="Native.NativeMethods.crumple_instance_set_tolerance"/>. Default 0: none.
        /// </summary>
        public float Tolerance;
        /// <summary>
        /// Transform; see <see cref="Native.NativeMethods.crumple_instance_set_transform"/>. Default the identity.
        /// </summary>
        public fixed float LocalToWorld[16];

        /// <summary>
        /// The defaults, from <c>crumple_instance_def_default()</c>: begin with these.
        /// </summary>
        /// <exception cref="CrumpleLibraryException">The native library is missing or does not fit.</exception>
        public static CrumpleInstanceDef Default
        {
            get
            {
                CrumpleRuntime.EnsureLoaded();
                return Native.NativeMethods.crumple_instance_def_default();
            }
        }
    }

    /// <summary>
    /// A body in the scene: an example set, a transform and the damage. An id; zero is null.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleInstance
    {
        /// <summary>
        /// 
        /// </summary>
        public uint Index;
        /// <summary>
        /// 
        /// </summary>
        public ushort Generation;
        /// <summary>
        /// 
        /// </summary>
        public ushort Context;
    }

    /// <summary>
    /// The state of an instance, including pending hits.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public unsafe partial struct CrumpleInstanceInfo
    {
        /// <summary>
        /// The id that it was created with, which may be stale.
        /// </summary>
        public CrumpleExampleSet Set;
        /// <summary>
        /// Memory of the instance, bytes, without the set and without your buffers.
        /// </summary>
        public ulong MemoryBytes;
        /// <summary>
        /// Number of marks; 0 with a classic rule.
        /// </summary>
        public uint MarkCount;
        /// <summary>
        /// 
        /// </summary>
        public uint BufferCount;
        /// <summary>
        /// 
        /// </summary>
        public float DepthLimit;
        /// <summary>
        /// Number of open contacts; see <see cref="Native.NativeMethods.crumple_instance_end_contact"/>.
        /// </summary>
        public uint ContactCount;
        /// <summary>
        /// 
        /// </summary>
        public fixed uint Reserved[4];
    }

    /// <summary>
    /// A hit given as an impulse, with point and impulse in the given space (default <see cref="CrumpleSpace.Local"/>). The
    /// target displacement of the contact is impulse * duration / mass. For dents that do not depend on the frame rate, make
    /// duration a constant of the material and report a contact once with its whole impulse, or in parts with a contact_id.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleImpulseDef
    {
        /// <summary>
        /// 
        /// </summary>
        public uint StructSize;
        /// <summary>
        /// 
        /// </summary>
        public CrumpleSpace Space;
        /// <summary>
        /// Where it hit, m. The nearest vertex becomes the contact.
        /// </summary>
        public CrumpleVec3 Point;
        /// <summary>
        /// The impulse on the body, N s. A zero impulse leaves no mark.
        /// </summary>
        public CrumpleVec3 Impulse;
        /// <summary>
        /// How long the impulse acted, s: a constant of the material such as 0.01, not the time step. Required; 0 is rejected.
        /// </summary>
        public float Duration;
        /// <summary>
        /// Mass of the contact vertex, kg. Default 0: the mass that the set has for the vertex.
        /// </summary>
        public float Mass;
        /// <summary>
        /// The contact that the hit is part of; see <see cref="Native.NativeMethods.crumple_instance_end_contact"/>. Default 0:
        /// none.
        /// </summary>
        public ulong ContactId;

        /// <summary>
        /// The defaults, from <c>crumple_impulse_def_default()</c>: begin with these.
        /// </summary>
        /// <exception cref="CrumpleLibraryException">The native library is missing or does not fit.</exception>
        public static CrumpleImpulseDef Default
        {
            get
            {
                CrumpleRuntime.EnsureLoaded();
                return Native.NativeMethods.crumple_impulse_def_default();
            }
        }
    }

    /// <summary>
    /// A hit given as the desired contact displacement, for engines with their own impulse-to-depth mapping. It does not depend
    /// on the frame rate. Fields without a comment are as in <see cref="CrumpleImpulseDef"/>.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleDisplacementDef
    {
        /// <summary>
        /// 
        /// </summary>
        public uint StructSize;
        /// <summary>
        /// 
        /// </summary>
        public CrumpleSpace Space;
        /// <summary>
        /// 
        /// </summary>
        public CrumpleVec3 Point;
        /// <summary>
        /// Target displacement of the contact, m.
        /// </summary>
        public CrumpleVec3 Displacement;
        /// <summary>
        /// 
        /// </summary>
        public ulong ContactId;

        /// <summary>
        /// The defaults, from <c>crumple_displacement_def_default()</c>: begin with these.
        /// </summary>
        /// <exception cref="CrumpleLibraryException">The native library is missing or does not fit.</exception>
        public static CrumpleDisplacementDef Default
        {
            get
            {
                CrumpleRuntime.EnsureLoaded();
                return Native.NativeMethods.crumple_displacement_def_default();
            }
        }
    }

    /// <summary>
    /// An example that a hit uses.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleChosen
    {
        /// <summary>
        /// 
        /// </summary>
        public uint Example;
        /// <summary>
        /// Share of the dent; shares of a hit sum to 1. Negative where it corrects overshoot of the others.
        /// </summary>
        public float Share;
        /// <summary>
        /// Factor of its displacements.
        /// </summary>
        public float Scale;
        /// <summary>
        /// Whether it stays where it was made. Otherwise it is carried (moved) to the contact.
        /// </summary>
        public CrumpleBool Anchored;
        /// <summary>
        /// Planes it is mirrored in: 1 for x, 2 for y, 4 for z, added.
        /// </summary>
        public byte Mirror;
        /// <summary>
        /// 
        /// </summary>
        public ushort Reserved;
    }

    /// <summary>
    /// An example, how it is placed, and its share of a dent.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumplePair
    {
        /// <summary>
        /// Index of the example; 0xFFFF in an unused pair.
        /// </summary>
        public ushort Example;
        /// <summary>
        /// Low 12 bits: share of the dent, two's complement, 1024 for the whole dent. Bits 12, 13 and 14: the example is mirrored
        /// in x, y and z. Bit 15: it stays where it was made.
        /// </summary>
        public ushort Share;
    }

    /// <summary>
    /// One dent: where, how deep, and made of which examples. Plain data of 32 bytes, equal on all machines: send or save it as
    /// it is (little-endian).
    /// </summary>
    /// <remarks>
    /// <para>```text u_m(v) = strength * sum over pairs of scale(depth, share) * e_i(v)          strength = sqrt(energy)
    /// ```</para>
    /// </remarks>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleMark
    {
        /// <summary>
        /// The vertex that was hit.
        /// </summary>
        public uint Contact;
        /// <summary>
        /// Depth asked for at the contact, m; above 0.
        /// </summary>
        public float Depth;
        /// <summary>
        /// Strength squared, in units of 2^-32: 4294967296 for one hit; each hit that repeats the mark adds as much. Sets that
        /// combine by sum or by the deepest store the strength itself.
        /// </summary>
        public ulong Energy;
        /// <summary>
        /// Up to four examples, the used ones first.
        /// </summary>
        public CrumplePair Pairs0;
        /// <summary>
        /// Up to four examples, the used ones first.
        /// </summary>
        public CrumplePair Pairs1;
        /// <summary>
        /// Up to four examples, the used ones first.
        /// </summary>
        public CrumplePair Pairs2;
        /// <summary>
        /// Up to four examples, the used ones first.
        /// </summary>
        public CrumplePair Pairs3;
    }

    /// <summary>
    /// The effect of a hit.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public unsafe partial struct CrumpleHitResult
    {
        /// <summary>
        /// 
        /// </summary>
        public CrumpleHitStatus Status;
        /// <summary>
        /// The vertex nearest to the point.
        /// </summary>
        public uint ContactVertex;
        /// <summary>
        /// Its distance from the point, m.
        /// </summary>
        public float ContactDistance;
        /// <summary>
        /// Target displacement of the contact before clamping, m, in the mesh's space.
        /// </summary>
        public CrumpleVec3 Target;
        /// <summary>
        /// Displacement of the contact by this hit alone, m, in the mesh's space. target - achieved was not achieved.
        /// </summary>
        public CrumpleVec3 Achieved;
        /// <summary>
        /// 
        /// </summary>
        public uint ChosenCount;
        /// <summary>
        /// Whether the target was longer than the depth limit and was cut to it.
        /// </summary>
        public CrumpleBool Clamped;
        /// <summary>
        /// The examples, the largest share first.
        /// </summary>
        public CrumpleChosen Chosen0;
        /// <summary>
        /// The examples, the largest share first.
        /// </summary>
        public CrumpleChosen Chosen1;
        /// <summary>
        /// The examples, the largest share first.
        /// </summary>
        public CrumpleChosen Chosen2;
        /// <summary>
        /// The examples, the largest share first.
        /// </summary>
        public CrumpleChosen Chosen3;
        /// <summary>
        /// The mark; zero everywhere where the hit leaves none.
        /// </summary>
        public CrumpleMark Mark;
        /// <summary>
        /// 
        /// </summary>
        public fixed ulong Reserved[4];
    }

    /// <summary>
    /// Memory for the deformed vertices of one instance, in the mesh's order and space.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleHostBufferDef
    {
        /// <summary>
        /// 
        /// </summary>
        public uint StructSize;
        /// <summary>
        /// Which mesh: 0 for the base mesh, or a number of <see cref="Native.NativeMethods.crumple_example_set_add_lod"/>.
        /// Default 0.
        /// </summary>
        public uint Lod;
        /// <summary>
        /// Positions, m. Required.
        /// </summary>
        public CrumpleStream Positions;
        /// <summary>
        /// Unit normals. Absent: not written.
        /// </summary>
        public CrumpleStream Normals;
        /// <summary>
        /// Tangents: xyz of unit length and orthogonal to the normal, w as in the mesh. Absent: not written.
        /// </summary>
        public CrumpleStream Tangents;

        /// <summary>
        /// The defaults, from <c>crumple_host_buffer_def_default()</c>: begin with these.
        /// </summary>
        /// <exception cref="CrumpleLibraryException">The native library is missing or does not fit.</exception>
        public static CrumpleHostBufferDef Default
        {
            get
            {
                CrumpleRuntime.EnsureLoaded();
                return Native.NativeMethods.crumple_host_buffer_def_default();
            }
        }
    }

    /// <summary>
    /// Your memory that an instance's deformed vertices are written to. An id; zero is null.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleBuffer
    {
        /// <summary>
        /// 
        /// </summary>
        public uint Index;
        /// <summary>
        /// 
        /// </summary>
        public ushort Generation;
        /// <summary>
        /// 
        /// </summary>
        public ushort Context;
    }

    /// <summary>
    /// The work of a deform. Blocks are runs of consecutive vertices.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public unsafe partial struct CrumpleDeformReport
    {
        /// <summary>
        /// 
        /// </summary>
        public ulong VerticesWritten;
        /// <summary>
        /// 
        /// </summary>
        public ulong BlocksWritten;
        /// <summary>
        /// Blocks that were up to date.
        /// </summary>
        public ulong BlocksSkipped;
        /// <summary>
        /// Examples of marks that tolerances skipped; see <see cref="Native.NativeMethods.crumple_instance_set_tolerance"/>.
        /// </summary>
        public ulong PartsSkipped;
        /// <summary>
        /// 
        /// </summary>
        public fixed ulong Reserved[4];
    }

    /// <summary>
    /// A range of vertices.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleRange
    {
        /// <summary>
        /// 
        /// </summary>
        public uint First;
        /// <summary>
        /// 
        /// </summary>
        public uint Count;
    }

    /// <summary>
    /// Any Vulkan function, as PFN_vkVoidFunction: (<see cref="CrumpleVulkanFunction"/>)vkGetInstanceProcAddr.
    /// </summary>
    [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
    public delegate void CrumpleVulkanFunction();

    /// <summary>
    /// Your Vulkan device, Vulkan 1.1 or later: a VkInstance, a VkPhysicalDevice and a VkDevice, all required. No extension or
    /// feature needs to be enabled.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleVulkanAttachDef
    {
        /// <summary>
        /// 
        /// </summary>
        public uint StructSize;
        /// <summary>
        /// Family of the queue that executes the command buffers; it must support compute. Required. Default UINT32_MAX.
        /// </summary>
        public uint QueueFamily;
        /// <summary>
        /// vkGetInstanceProcAddr of the instance's loader. Crumple gets every function from it and never opens a Vulkan library.
        /// Required.
        /// </summary>
        public IntPtr GetInstanceProcAddr;
        /// <summary>
        /// 
        /// </summary>
        public IntPtr Instance;
        /// <summary>
        /// 
        /// </summary>
        public IntPtr PhysicalDevice;
        /// <summary>
        /// 
        /// </summary>
        public IntPtr Device;
        /// <summary>
        /// Data of <see cref="Native.NativeMethods.crumple_vulkan_get_pipeline_cache"/> from an earlier run, read during the
        /// call. Data of another driver is ignored. Default null.
        /// </summary>
        public IntPtr PipelineCache;
        /// <summary>
        /// Bytes at pipeline_cache.
        /// </summary>
        public UIntPtr PipelineCacheSize;
        /// <summary>
        /// Invocations per workgroup: 32, 64, 128 or 256, within the device's limit. Default 128.
        /// </summary>
        public uint WorkgroupSize;

        /// <summary>
        /// The defaults, from <c>crumple_vulkan_attach_def_default()</c>: begin with these.
        /// </summary>
        /// <exception cref="CrumpleLibraryException">The native library is missing or does not fit.</exception>
        public static CrumpleVulkanAttachDef Default
        {
            get
            {
                CrumpleRuntime.EnsureLoaded();
                return Native.NativeMethods.crumple_vulkan_attach_def_default();
            }
        }
    }

    /// <summary>
    /// Where the values of one attribute are. Zero everywhere: absent.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleVulkanStream
    {
        /// <summary>
        /// Bytes from the start of the range to the first value, a multiple of 4.
        /// </summary>
        public ulong Offset;
        /// <summary>
        /// Bytes from one value to the next: at least the size of a value, a multiple of 4.
        /// </summary>
        public ulong Stride;
        /// <summary>
        /// A VkFormat. Positions: R32G32B32_SFLOAT, R16G16B16A16_SFLOAT (w is 1), R16G16B16A16_SNORM (see scale). Normals:
        /// R32G32B32_SFLOAT, R16G16B16A16_SNORM, R8G8B8A8_SNORM (w is 0). Tangents: R32G32B32A32_SFLOAT, R16G16B16A16_SNORM,
        /// R8G8B8A8_SNORM.
        /// </summary>
        public uint Format;
        /// <summary>
        /// 
        /// </summary>
        public uint Reserved;
    }

    /// <summary>
    /// A range of a VkBuffer for the deformed vertices of one instance, in the mesh's order and space. Fields without a comment
    /// are as in <see cref="CrumpleHostBufferDef"/>.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleVulkanBufferDef
    {
        /// <summary>
        /// 
        /// </summary>
        public uint StructSize;
        /// <summary>
        /// 
        /// </summary>
        public uint Lod;
        /// <summary>
        /// The VkBuffer, bound to memory: (uint64_t)handle. Required. Any number of ranges may lie in one VkBuffer; buffer,
        /// buffer_size, usage, queue_family and the four stage and access fields must then be equal.
        /// </summary>
        public ulong Buffer;
        /// <summary>
        /// Bytes of the whole VkBuffer. Required.
        /// </summary>
        public ulong BufferSize;
        /// <summary>
        /// VkBufferUsageFlags of the VkBuffer, with VK_BUFFER_USAGE_STORAGE_BUFFER_BIT. Required.
        /// </summary>
        public uint Usage;
        /// <summary>
        /// Default VK_QUEUE_FAMILY_IGNORED: the device's own family owns the VkBuffer, or it is VK_SHARING_MODE_CONCURRENT.
        /// Otherwise the other family that owns it. Each recording that includes one of its ranges then begins with an acquire
        /// and ends with a release of the whole VkBuffer, even without changes. You record the matching release and acquire on
        /// the other queue.
        /// </summary>
        public uint QueueFamily;
        /// <summary>
        /// VkPipelineStageFlags of your last use of the VkBuffer before a recording, not 0. Barriers cover the whole VkBuffer, so
        /// include indices, copies and read-backs in it. Default VK_PIPELINE_STAGE_VERTEX_INPUT_BIT.
        /// </summary>
        public uint BeforeStages;
        /// <summary>
        /// VkAccessFlags of that use. Default VK_ACCESS_VERTEX_ATTRIBUTE_READ_BIT.
        /// </summary>
        public uint BeforeAccess;
        /// <summary>
        /// VkPipelineStageFlags of your next use of anything in the VkBuffer, not 0. Default VK_PIPELINE_STAGE_VERTEX_INPUT_BIT.
        /// </summary>
        public uint AfterStages;
        /// <summary>
        /// VkAccessFlags of that use. Default VK_ACCESS_VERTEX_ATTRIBUTE_READ_BIT.
        /// </summary>
        public uint AfterAccess;
        /// <summary>
        /// Start of the range, bytes, a multiple of 4.
        /// </summary>
        public ulong Offset;
        /// <summary>
        /// Bytes of the range. Nothing outside is written. Ranges may interleave; values must not overlap. Required.
        /// </summary>
        public ulong Size;
        /// <summary>
        /// 
        /// </summary>
        public CrumpleVulkanStream Positions;
        /// <summary>
        /// 
        /// </summary>
        public CrumpleVulkanStream Normals;
        /// <summary>
        /// 
        /// </summary>
        public CrumpleVulkanStream Tangents;
        /// <summary>
        /// For positions in R16G16B16A16_SNORM: a stored s in -1 to 1 is s * scale + bias, m. Positions outside are clamped, so
        /// cover the mesh's bounds grown by the depth limit. Above 0. Default 1, 1, 1.
        /// </summary>
        public CrumpleVec3 Scale;
        /// <summary>
        /// 
        /// </summary>
        public CrumpleVec3 Bias;

        /// <summary>
        /// The defaults, from <c>crumple_vulkan_buffer_def_default()</c>: begin with these.
        /// </summary>
        /// <exception cref="CrumpleLibraryException">The native library is missing or does not fit.</exception>
        public static CrumpleVulkanBufferDef Default
        {
            get
            {
                CrumpleRuntime.EnsureLoaded();
                return Native.NativeMethods.crumple_vulkan_buffer_def_default();
            }
        }
    }

    /// <summary>
    /// The recorded work. Fields without a comment are as in <see cref="CrumpleDeformReport"/>.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public unsafe partial struct CrumpleRecordReport
    {
        /// <summary>
        /// 
        /// </summary>
        public ulong VerticesWritten;
        /// <summary>
        /// Blocks of consecutive vertices that will be written. 0: nothing was recorded, except queue-family transfers.
        /// </summary>
        public ulong BlocksWritten;
        /// <summary>
        /// 
        /// </summary>
        public ulong BlocksSkipped;
        /// <summary>
        /// 
        /// </summary>
        public ulong PartsSkipped;
        /// <summary>
        /// Bytes that the commands copy to the device, including meshes used for the first time.
        /// </summary>
        public ulong BytesCopied;
        /// <summary>
        /// Dispatches: one per VkBuffer, and one per buffer of an instance with a classic rule.
        /// </summary>
        public uint Dispatches;
        /// <summary>
        /// 
        /// </summary>
        public uint Reserved0;
        /// <summary>
        /// 
        /// </summary>
        public fixed ulong Reserved[4];
    }

    /// <summary>
    /// A Vulkan device that Crumple creates, beside yours on the same physical device. Fields without a comment are as in
    /// <see cref="CrumpleVulkanAttachDef"/>.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public unsafe partial struct CrumpleVulkanOpenDef
    {
        /// <summary>
        /// 
        /// </summary>
        public uint StructSize;
        /// <summary>
        /// 
        /// </summary>
        public uint WorkgroupSize;
        /// <summary>
        /// vkGetInstanceProcAddr of a loader that stays loaded. Required.
        /// </summary>
        public IntPtr GetInstanceProcAddr;
        /// <summary>
        /// deviceUUID of your physical device (VkPhysicalDeviceIDProperties); devices of one UUID can share memory. Default zero:
        /// the first device that supports compute.
        /// </summary>
        public fixed byte DeviceUuid[16];
        /// <summary>
        /// 
        /// </summary>
        public IntPtr PipelineCache;
        /// <summary>
        /// Bytes at pipeline_cache.
        /// </summary>
        public UIntPtr PipelineCacheSize;

        /// <summary>
        /// The defaults, from <c>crumple_vulkan_open_def_default()</c>: begin with these.
        /// </summary>
        /// <exception cref="CrumpleLibraryException">The native library is missing or does not fit.</exception>
        public static CrumpleVulkanOpenDef Default
        {
            get
            {
                CrumpleRuntime.EnsureLoaded();
                return Native.NativeMethods.crumple_vulkan_open_def_default();
            }
        }
    }

    /// <summary>
    /// A VkBuffer of your device in memory that it exported, at offset (default 0) in the memory and with a size, bytes. usage is
    /// as in <see cref="CrumpleVulkanBufferDef"/>. Create it with VkExternalMemoryBufferCreateInfo and its memory with
    /// VkExportMemoryAllocateInfo, of one handle type (default <see cref="CrumpleHandleType.OpaqueFd"/>).
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleVulkanImportDef
    {
        /// <summary>
        /// 
        /// </summary>
        public uint StructSize;
        /// <summary>
        /// 
        /// </summary>
        public CrumpleHandleType HandleType;
        /// <summary>
        /// Handle of the memory. Required. Default -1.
        /// </summary>
        public long Handle;
        /// <summary>
        /// allocationSize of the memory, bytes. Required.
        /// </summary>
        public ulong MemorySize;
        /// <summary>
        /// memoryTypeIndex of the memory. Required.
        /// </summary>
        public uint MemoryType;
        /// <summary>
        /// 
        /// </summary>
        public uint Usage;
        /// <summary>
        /// 
        /// </summary>
        public ulong Offset;
        /// <summary>
        /// 
        /// </summary>
        public ulong Size;
        /// <summary>
        /// Whether the memory is dedicated to this buffer (VkMemoryDedicatedAllocateInfo). Default false.
        /// </summary>
        public CrumpleBool Dedicated;

        /// <summary>
        /// The defaults, from <c>crumple_vulkan_import_def_default()</c>: begin with these.
        /// </summary>
        /// <exception cref="CrumpleLibraryException">The native library is missing or does not fit.</exception>
        public static CrumpleVulkanImportDef Default
        {
            get
            {
                CrumpleRuntime.EnsureLoaded();
                return Native.NativeMethods.crumple_vulkan_import_def_default();
            }
        }
    }

    /// <summary>
    /// A point bound to the nearest surface. Plain data: copy or save it. It fits every instance of its set.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public unsafe partial struct CrumpleAttachment
    {
        /// <summary>
        /// Vertices of the triangle; all equal for a mesh without triangles.
        /// </summary>
        public fixed uint Vertices[3];
        /// <summary>
        /// Barycentric weights of the surface point; they sum to 1.
        /// </summary>
        public fixed float Weights[3];
        /// <summary>
        /// The attached point at rest, m, in the mesh's space.
        /// </summary>
        public CrumpleVec3 Point;
        /// <summary>
        /// 
        /// </summary>
        public fixed uint Reserved[3];
    }

    /// <summary>
    /// A rotation as a unit quaternion.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleQuat
    {
        /// <summary>
        /// 
        /// </summary>
        public float X;
        /// <summary>
        /// 
        /// </summary>
        public float Y;
        /// <summary>
        /// 
        /// </summary>
        public float Z;
        /// <summary>
        /// 
        /// </summary>
        public float W;
    }

    /// <summary>
    /// The place of an attached point, and its rotation since rest.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public unsafe partial struct CrumpleFrame
    {
        /// <summary>
        /// Position, m, in the mesh's space.
        /// </summary>
        public CrumpleVec3 Position;
        /// <summary>
        /// 
        /// </summary>
        public CrumpleQuat Rotation;
        /// <summary>
        /// 
        /// </summary>
        public fixed uint Reserved[5];
    }
}
