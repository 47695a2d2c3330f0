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
        /// Bit of <see cref="Native.NativeMethods.crumple_features"/>: glTF 2.0 and GLB files can be loaded.
        /// </summary>
        Gltf = 1,
        /// <summary>
        /// Bit of <see cref="Native.NativeMethods.crumple_features"/>: OBJ files can be loaded.
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
    /// What every fallible call returns. After anything but <see cref="CrumpleResult.Ok"/> no output was written,
    /// <see cref="Native.NativeMethods.crumple_last_error"/> tells what was wrong and what would be right, and everything stays
    /// usable.
    /// </summary>
    public enum CrumpleResult
    {
        /// <summary>
        /// The call did what it says.
        /// </summary>
        Ok = 0,
        /// <summary>
        /// A value lies outside its range.
        /// </summary>
        ErrorInvalidArgument = 1,
        /// <summary>
        /// A number is NaN or infinite.
        /// </summary>
        ErrorNotFinite = 2,
        /// <summary>
        /// An index points past the end of what it indexes.
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
        /// Memory is smaller than what must be read from it or written to it.
        /// </summary>
        ErrorBufferTooSmall = 6,
        /// <summary>
        /// A pointer, an offset or a stride is not a multiple of the alignment it needs.
        /// </summary>
        ErrorMisaligned = 7,
        /// <summary>
        /// A contact lies further from the body than the instance accepts: often a point in the wrong space.
        /// </summary>
        ErrorContactTooFar = 8,
        /// <summary>
        /// Valid input that this library, or this build of it, does not read.
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
        /// Damage belongs to another example set or to another version.
        /// </summary>
        ErrorDamageMismatch = 12,
        /// <summary>
        /// Memory ran out. Only memory whose size your counts decide is reported so; see "Memory" at the top of the header.
        /// </summary>
        ErrorOutOfMemory = 13,
        /// <summary>
        /// The call does not fit the instance's rule.
        /// </summary>
        ErrorWrongRule = 14,
        /// <summary>
        /// A call into the graphics driver failed.
        /// </summary>
        ErrorVulkan = 15,
        /// <summary>
        /// The graphics device is lost. Damage is not.
        /// </summary>
        ErrorDeviceLost = 16,
        /// <summary>
        /// A pointer is null that must not be.
        /// </summary>
        ErrorNullPointer = 64,
        /// <summary>
        /// The struct_size of a def is that of no version: take defs from their crumple_..._def_default function.
        /// </summary>
        ErrorStructSize = 65,
        /// <summary>
        /// An id or a context is null, was destroyed, or belongs to another context; the text says which.
        /// </summary>
        ErrorInvalidId = 66,
        /// <summary>
        /// Two threads were inside the same context at once, or a callback called back into it.
        /// </summary>
        ErrorConcurrentUse = 67,
        /// <summary>
        /// A defect of the library; the text is its message. Please report it.
        /// </summary>
        ErrorInternal = 68,
        /// <summary>
        /// Frames were recorded that <see cref="Native.NativeMethods.crumple_vulkan_complete_frames"/> was not told of.
        /// </summary>
        ErrorFramesInFlight = 69,
    }

    /// <summary>
    /// How much a log message matters.
    /// </summary>
    public enum CrumpleLogLevel
    {
        /// <summary>
        /// What was done.
        /// </summary>
        Info = 0,
        /// <summary>
        /// Something that works but is probably not what was meant.
        /// </summary>
        Warning = 1,
    }

    /// <summary>
    /// How the place where an example was hit is told.
    /// </summary>
    public enum CrumpleContactKind
    {
        /// <summary>
        /// Not told: its deepest vertex. The default.
        /// </summary>
        None = 0,
        /// <summary>
        /// A vertex of the base mesh.
        /// </summary>
        Vertex = 1,
        /// <summary>
        /// A point in the mesh's space; its nearest vertex becomes the contact.
        /// </summary>
        Point = 2,
    }

    /// <summary>
    /// Whether an example may be carried away from where it was made.
    /// </summary>
    public enum CrumplePlacement
    {
        /// <summary>
        /// Anchored for hits close to its own contact that ask for about its own depth, carried for others. The default.
        /// </summary>
        Automatic = 0,
        /// <summary>
        /// Always where and as the artist made it: creases, frames, bumpers.
        /// </summary>
        Anchored = 1,
        /// <summary>
        /// Always carried to where the body was hit: sheet metal.
        /// </summary>
        Carried = 2,
    }

    /// <summary>
    /// The type of triangle indices.
    /// </summary>
    public enum CrumpleIndexType
    {
        /// <summary>
        /// uint32_t, 4 bytes. The default.
        /// </summary>
        U32 = 0,
        /// <summary>
        /// uint16_t, 2 bytes.
        /// </summary>
        U16 = 1,
    }

    /// <summary>
    /// How the dents of several hits combine at a vertex. The direction is always that of their sum.
    /// </summary>
    public enum CrumpleCombine
    {
        /// <summary>
        /// Energies add: depth grows as the root of the number of equal hits, as metal does. The default.
        /// </summary>
        Energies = 0,
        /// <summary>
        /// Lengths add, up to the depth limit.
        /// </summary>
        Sum = 1,
        /// <summary>
        /// The deepest dent decides: stamping to a fixed position.
        /// </summary>
        Deepest = 2,
    }

    /// <summary>
    /// What becomes of an example that moves apart vertices which share a position in the base mesh.
    /// </summary>
    public enum CrumpleSeams
    {
        /// <summary>
        /// They stay together: each gets the mean of their displacements. The default.
        /// </summary>
        Weld = 0,
        /// <summary>
        /// They move apart, as the example says: a tear that the artist made.
        /// </summary>
        Keep = 1,
    }

    /// <summary>
    /// What becomes of the bytes that a set is loaded from.
    /// </summary>
    public enum CrumpleBytes
    {
        /// <summary>
        /// They are copied: free them after the call.
        /// </summary>
        Copy = 0,
        /// <summary>
        /// They are kept and used where they lie: a memory map, or an asset that stays loaded. They must stay readable and must
        /// not change until the set was destroyed and all its instances with it, or the context. Where they do not begin at a
        /// multiple of 16 bytes they are copied all the same; do not rely on that.
        /// </summary>
        Keep = 1,
    }

    /// <summary>
    /// What hits do to an instance.
    /// </summary>
    public enum CrumpleRule
    {
        /// <summary>
        /// Hits leave marks: bounded, local, the same in any order, without memory per vertex. The default.
        /// </summary>
        Marks = 0,
        /// <summary>
        /// The literature's rule "most displaced", for comparison: depends on the order of hits, needs memory per vertex, has no
        /// marks.
        /// </summary>
        MostDisplaced = 1,
        /// <summary>
        /// The literature's rule "blend", with blend_constant.
        /// </summary>
        Blend = 2,
    }

    /// <summary>
    /// How the examples for a hit are chosen.
    /// </summary>
    public enum CrumpleSelection
    {
        /// <summary>
        /// <see cref="CrumpleSelection.Nearest"/> with marks, <see cref="CrumpleSelection.Classic"/> with the literature's rules.
        /// The default.
        /// </summary>
        OfRule = 0,
        /// <summary>
        /// The examples that say most of a hit's place, depth and lean, carried or anchored as each says. Marks only.
        /// </summary>
        Nearest = 1,
        /// <summary>
        /// The literature's: the one example that moves the contact in the direction most like the target, weight at most 1.
        /// </summary>
        Classic = 2,
        /// <summary>
        /// The same without a limit of the weight: diverges above 2. The literature's rules only, for comparison.
        /// </summary>
        ClassicUnclamped = 3,
    }

    /// <summary>
    /// The space a hit is given in.
    /// </summary>
    public enum CrumpleSpace
    {
        /// <summary>
        /// The mesh's own. The default.
        /// </summary>
        Local = 0,
        /// <summary>
        /// The world's: through the instance's transform.
        /// </summary>
        World = 1,
    }

    /// <summary>
    /// What became of a hit.
    /// </summary>
    public enum CrumpleHitStatus
    {
        /// <summary>
        /// It leaves a mark (with the literature's rules: a deformation).
        /// </summary>
        Marked = 0,
        /// <summary>
        /// It is weaker than the instance's yield threshold, or next to nothing.
        /// </summary>
        BelowYield = 1,
        /// <summary>
        /// No example moves the contact in the direction asked for.
        /// </summary>
        NothingReaches = 2,
    }

    /// <summary>
    /// How a device hands memory or a semaphore to another one.
    /// </summary>
    public enum CrumpleHandleType
    {
        /// <summary>
        /// A file descriptor, VK_EXTERNAL_MEMORY_HANDLE_TYPE_OPAQUE_FD_BIT. It is duplicated: yours stays yours, to be closed
        /// when you like. Linux, Android and their kind.
        /// </summary>
        OpaqueFd = 0,
        /// <summary>
        /// A HANDLE, VK_EXTERNAL_MEMORY_HANDLE_TYPE_OPAQUE_WIN32_BIT. Windows. Untested.
        /// </summary>
        OpaqueWin32 = 1,
    }

    /// <summary>
    /// Gives size bytes aligned to align (a power of two, at least 16), or null. Called from any thread, several at once. Must
    /// not call Crumple, throw, or jump out.
    /// </summary>
    [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
    public delegate IntPtr CrumpleAlloc(UIntPtr size, UIntPtr align, IntPtr user);

    /// <summary>
    /// Takes back what <see cref="CrumpleAlloc"/> gave, with the same size and align. Called from any thread, several at once.
    /// Must not call Crumple, throw, or jump out.
    /// </summary>
    [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
    public delegate void CrumpleFree(IntPtr pointer, UIntPtr size, UIntPtr align, IntPtr user);

    /// <summary>
    /// The host's allocator.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleAllocatorDef
    {
        /// <summary>
        /// Bytes of this struct, from <see cref="Native.NativeMethods.crumple_allocator_def_default"/>.
        /// </summary>
        public uint StructSize;
        /// <summary>
        /// Gives memory. Required.
        /// </summary>
        public IntPtr Alloc;
        /// <summary>
        /// Takes memory back. Required.
        /// </summary>
        public IntPtr Free;
        /// <summary>
        /// Handed to both, untouched. May be null.
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
    /// Receives one message, UTF-8, without a line break at its end; the text is gone when the callback returns. Called from the
    /// thread that called Crumple. Must not call Crumple with the same context, throw, or jump out.
    /// </summary>
    [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
    public delegate void CrumpleLog(CrumpleLogLevel level, IntPtr message, IntPtr user);

    /// <summary>
    /// One task of a parallel-for, given to you to be run: index is 0 to count - 1, task_data what came with it.
    /// </summary>
    [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
    public delegate void CrumpleTask(uint index, IntPtr taskData);

    /// <summary>
    /// Your parallel-for: call task(index, task_data) once for every index below count, on any threads and in any order, and
    /// return when all have returned. Tasks never block, never throw, and may run at once. What you forget is run after you
    /// return, and an index that you run twice does nothing the second time. Called from the thread that called Crumple. Must not
    /// throw or jump out. It may call <see cref="Native.NativeMethods.crumple_instance_submit_impulse"/>,
    /// <see cref="Native.NativeMethods.crumple_instance_submit_displacement"/> and
    /// <see cref="Native.NativeMethods.crumple_instance_end_contact"/>, nothing else of the same context.
    /// </summary>
    [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
    public delegate void CrumpleParallelFor(uint count, IntPtr task, IntPtr taskData, IntPtr user);

    /// <summary>
    /// The host's job system. Zero everywhere: there is none, Crumple uses threads of its own.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleTaskSystem
    {
        /// <summary>
        /// Runs tasks. Null: Crumple uses threads of its own.
        /// </summary>
        public IntPtr ParallelFor;
        /// <summary>
        /// Handed to parallel_for, untouched. May be null.
        /// </summary>
        public IntPtr User;
        /// <summary>
        /// How many threads may work at once; 0 counts as 1. Only decides how finely work is cut: never the result.
        /// </summary>
        public uint Workers;
    }

    /// <summary>
    /// How a context works.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleContextDef
    {
        /// <summary>
        /// Bytes of this struct, from <see cref="Native.NativeMethods.crumple_context_def_default"/>.
        /// </summary>
        public uint StructSize;
        /// <summary>
        /// Threads that deform: 0 one for each core, 1 only the calling thread, up to 1024. Without meaning where tasks is set.
        /// Default 0.
        /// </summary>
        public uint Threads;
        /// <summary>
        /// Receives messages. Null: none. Default null.
        /// </summary>
        public IntPtr Log;
        /// <summary>
        /// Handed to log, untouched.
        /// </summary>
        public IntPtr LogUser;
        /// <summary>
        /// Your job system, instead of threads of Crumple's own. Default zero: none.
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
    /// An array that Crumple reads during the call and never keeps. Element i lies at data + i * stride; how many there are and
    /// of what type is said where the array is used. Zero everywhere: the array is absent.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleInput
    {
        /// <summary>
        /// First element; aligned to its type (4 bytes, or 2 for 16-bit indices). Null: absent.
        /// </summary>
        public IntPtr Data;
        /// <summary>
        /// Readable bytes from data on; at least (count - 1) * stride + the bytes of one element.
        /// </summary>
        public UIntPtr Size;
        /// <summary>
        /// Bytes from one element to the next: at least those of one element, a multiple of its alignment. 0 is an error, never
        /// "tightly packed".
        /// </summary>
        public UIntPtr Stride;
    }

    /// <summary>
    /// A point or a vector. Its unit is named where it is used.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleVec3
    {
        /// <summary>
        /// Along the mesh's (or the world's) first axis.
        /// </summary>
        public float X;
        /// <summary>
        /// Along the second axis.
        /// </summary>
        public float Y;
        /// <summary>
        /// Along the third axis.
        /// </summary>
        public float Z;
    }

    /// <summary>
    /// One example: the base mesh after a collision. Give target_positions, or delta_indices with position_deltas.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleExampleDef
    {
        /// <summary>
        /// Bytes of this struct, from <see cref="Native.NativeMethods.crumple_example_def_default"/>.
        /// </summary>
        public uint StructSize;
        /// <summary>
        /// Number of moved vertices in delta_indices, position_deltas and normal_deltas. Without meaning for target_positions.
        /// </summary>
        public uint DeltaCount;
        /// <summary>
        /// Any UTF-8 text that ends with a zero, copied; need not be unique. Null: empty.
        /// </summary>
        public IntPtr Name;
        /// <summary>
        /// Full form: where every vertex of the base mesh goes: vertex_count times 3 floats, m, in the base's order.
        /// </summary>
        public CrumpleInput TargetPositions;
        /// <summary>
        /// Full form: unit normals there: vertex_count times 3 floats. Absent: computed. Needs the base mesh's normals.
        /// </summary>
        public CrumpleInput TargetNormals;
        /// <summary>
        /// Sparse form: indices of the moved vertices, strictly increasing: delta_count times uint32_t.
        /// </summary>
        public CrumpleInput DeltaIndices;
        /// <summary>
        /// Sparse form: how far they move: delta_count times 3 floats, m.
        /// </summary>
        public CrumpleInput PositionDeltas;
        /// <summary>
        /// Sparse form: how their unit normals change: delta_count times 3 floats. Absent: computed.
        /// </summary>
        public CrumpleInput NormalDeltas;
        /// <summary>
        /// How the place where the example was hit is told. Default <see cref="CrumpleContactKind.None"/>.
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
        /// The surface's outward direction there, of any length but 0, where has_contact_normal is true.
        /// </summary>
        public CrumpleVec3 ContactNormal;
        /// <summary>
        /// Whether contact_normal is given; otherwise it is taken from the mesh. Default false.
        /// </summary>
        public CrumpleBool HasContactNormal;
        /// <summary>
        /// Whether it may be carried. Default <see cref="CrumplePlacement.Automatic"/>.
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
    /// How an example set is made ready. Part of the defs that make one, which carry its defaults.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleExampleSetOptions
    {
        /// <summary>
        /// No vertex ever moves further than this, m. 0: the deepest displacement of any example. Default 0.
        /// </summary>
        public float DepthLimit;
        /// <summary>
        /// Displacements of an example up to this length are dropped, m. 0: only exact zeros. Default 0.
        /// </summary>
        public float DropBelow;
        /// <summary>
        /// Mass of every vertex, kg, for impulses that bring none of their own. 0: not known. Default 0.
        /// </summary>
        public float VertexMass;
        /// <summary>
        /// Nodes along each side of the grid that a carried example is kept in: 4 to 128. Default 32; sharp creases want more.
        /// With a tolerance, at most.
        /// </summary>
        public uint StampResolution;
        /// <summary>
        /// How far an example of weight 1 may put a vertex off, m: displacements are kept as integers of 1 or 2 bytes that hold
        /// this, and carried examples on the coarsest grid that does. 0, the default: exact floats.
        /// </summary>
        public float Tolerance;
        /// <summary>
        /// With a tolerance: how far an example of weight 1 may turn a normal off, degrees; above 0 to 45. Default 1.
        /// </summary>
        public float NormalTolerance;
        /// <summary>
        /// Mass of each vertex, kg: vertex_count floats, instead of vertex_mass. Default absent.
        /// </summary>
        public CrumpleInput VertexMasses;
        /// <summary>
        /// How the dents of several hits combine. Default <see cref="CrumpleCombine.Energies"/>.
        /// </summary>
        public CrumpleCombine Combine;
        /// <summary>
        /// What becomes of examples that tear seams. Default <see cref="CrumpleSeams.Weld"/>.
        /// </summary>
        public CrumpleSeams Seams;
        /// <summary>
        /// Whether carried examples may never be scaled above their own depth, as anchored ones never are. Default false.
        /// </summary>
        public CrumpleBool Strict;
        /// <summary>
        /// Whether examples also serve mirrored, where the body is the same on both sides of a coordinate plane through the
        /// centre of its bounds. Default true.
        /// </summary>
        public CrumpleBool Mirror;
        /// <summary>
        /// Whether carried dents fall to zero towards edges of the sheet that the examples show to be held. Default true.
        /// </summary>
        public CrumpleBool HeldRims;
    }

    /// <summary>
    /// A base mesh and its examples, as arrays.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleExampleSetDef
    {
        /// <summary>
        /// Bytes of this struct, from <see cref="Native.NativeMethods.crumple_example_set_def_default"/>.
        /// </summary>
        public uint StructSize;
        /// <summary>
        /// Vertices of the base mesh, at least 1. Their order is yours and is kept.
        /// </summary>
        public uint VertexCount;
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
        /// Triangles: index_count indices, three a triangle, counter-clockwise seen from outside. Absent: a cloud of points,
        /// which then needs normals.
        /// </summary>
        public CrumpleInput Indices;
        /// <summary>
        /// Number of indices, a multiple of 3.
        /// </summary>
        public uint IndexCount;
        /// <summary>
        /// Type of indices. Default <see cref="CrumpleIndexType.U32"/>.
        /// </summary>
        public CrumpleIndexType IndexType;
        /// <summary>
        /// The examples: example_count of them, each from <see cref="Native.NativeMethods.crumple_example_def_default"/>.
        /// </summary>
        public IntPtr Examples;
        /// <summary>
        /// Number of examples, at least 1.
        /// </summary>
        public uint ExampleCount;
        /// <summary>
        /// How the set is made ready.
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
    /// A base mesh and its examples: immutable, shared by any number of instances. An id; zero is null. Compare ids field by
    /// field; copy them freely; a stale or foreign id is an error, never a crash.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleExampleSet
    {
        /// <summary>
        /// Place in the context, plus one; 0 is null.
        /// </summary>
        public uint Index;
        /// <summary>
        /// Tells successive users of the place apart.
        /// </summary>
        public ushort Generation;
        /// <summary>
        /// Tells contexts apart.
        /// </summary>
        public ushort Context;
    }

    /// <summary>
    /// Another mesh of a set's body, as arrays.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleLodDef
    {
        /// <summary>
        /// Bytes of this struct, from <see cref="Native.NativeMethods.crumple_lod_def_default"/>.
        /// </summary>
        public uint StructSize;
        /// <summary>
        /// Its vertices, at least 1. Their order is yours and is kept.
        /// </summary>
        public uint VertexCount;
        /// <summary>
        /// Positions: vertex_count times 3 floats, m, in the base mesh's space. Required.
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
        /// Triangles: index_count indices, three a triangle, counter-clockwise seen from outside. Absent: none.
        /// </summary>
        public CrumpleInput Indices;
        /// <summary>
        /// Number of indices, a multiple of 3.
        /// </summary>
        public uint IndexCount;
        /// <summary>
        /// Type of indices. Default <see cref="CrumpleIndexType.U32"/>.
        /// </summary>
        public CrumpleIndexType IndexType;

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
    /// Which mesh of a glTF file, and how it is made ready.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleGltfDef
    {
        /// <summary>
        /// Bytes of this struct, from <see cref="Native.NativeMethods.crumple_gltf_def_default"/>.
        /// </summary>
        public uint StructSize;
        /// <summary>
        /// Index of the mesh in the file, where mesh_name is null; UINT32_MAX: the first mesh that has morph targets. Default
        /// UINT32_MAX.
        /// </summary>
        public uint MeshIndex;
        /// <summary>
        /// Name of the mesh, UTF-8. Null: mesh_index decides. Default null.
        /// </summary>
        public IntPtr MeshName;
        /// <summary>
        /// Path of the .glb or .gltf file, UTF-8, for <see cref="Native.NativeMethods.crumple_example_set_load_gltf"/>. For
        /// <see cref="Native.NativeMethods.crumple_example_set_load_gltf_memory"/> the folder that files named in it are relative
        /// to; null: such files are an error.
        /// </summary>
        public IntPtr Path;
        /// <summary>
        /// How the set is made ready. vertex_masses must be absent, or hold as many as the mesh has vertices.
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
    /// A base OBJ and its examples, and how they are made ready.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleObjDef
    {
        /// <summary>
        /// Bytes of this struct, from <see cref="Native.NativeMethods.crumple_obj_def_default"/>.
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
        /// Paths of the examples, UTF-8: the base mesh after a collision, with the same vertices in the same order.
        /// </summary>
        public IntPtr ExamplePaths;
        /// <summary>
        /// How the set is made ready.
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
    /// An array that Crumple writes. Element i lies at data + offset + i * stride. Positions and normals are 3 floats (12 bytes),
    /// tangents 4 (16 bytes), indices one uint32_t; Crumple touches those bytes and none between them, so that several streams
    /// may be interleaved in one vertex buffer. Zero everywhere: the array is absent.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleStream
    {
        /// <summary>
        /// Begin of the memory, aligned to 4 bytes. Null: absent.
        /// </summary>
        public IntPtr Data;
        /// <summary>
        /// Writable bytes from data on; at least offset + (count - 1) * stride + the bytes of one element.
        /// </summary>
        public UIntPtr Size;
        /// <summary>
        /// Bytes from data to the first element, a multiple of 4.
        /// </summary>
        public UIntPtr Offset;
        /// <summary>
        /// Bytes from one element to the next: at least those of one element, a multiple of 4. 0 is an error, never "tightly
        /// packed".
        /// </summary>
        public UIntPtr Stride;
    }

    /// <summary>
    /// Where a set's mesh is copied to. Absent streams are left out.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleMeshCopyDef
    {
        /// <summary>
        /// Bytes of this struct, from <see cref="Native.NativeMethods.crumple_mesh_copy_def_default"/>.
        /// </summary>
        public uint StructSize;
        /// <summary>
        /// Which mesh: 0 the base mesh, else a number from <see cref="Native.NativeMethods.crumple_example_set_add_lod"/>.
        /// Default 0.
        /// </summary>
        public uint Lod;
        /// <summary>
        /// Positions: 3 floats a vertex, m.
        /// </summary>
        public CrumpleStream Positions;
        /// <summary>
        /// Unit normals: 3 floats a vertex.
        /// </summary>
        public CrumpleStream Normals;
        /// <summary>
        /// Tangents: 4 floats a vertex, xyz of unit length, w +1 or -1.
        /// </summary>
        public CrumpleStream Tangents;
        /// <summary>
        /// Triangles: 3 times triangle_count uint32_t.
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
    /// A box along the mesh's axes, m.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleAabb
    {
        /// <summary>
        /// Least coordinates, m.
        /// </summary>
        public CrumpleVec3 Min;
        /// <summary>
        /// Greatest coordinates, m.
        /// </summary>
        public CrumpleVec3 Max;
    }

    /// <summary>
    /// What an example set holds. Strings live until the set is destroyed.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public unsafe partial struct CrumpleExampleSetInfo
    {
        /// <summary>
        /// Name of the mesh in its file, UTF-8; empty for a set made from arrays. Never null.
        /// </summary>
        public IntPtr Name;
        /// <summary>
        /// Tells whether two sets are the same, on any machine; saved damage fits sets of one fingerprint.
        /// </summary>
        public ulong Fingerprint;
        /// <summary>
        /// Bytes of memory that the set takes.
        /// </summary>
        public ulong MemoryBytes;
        /// <summary>
        /// Vertices of the base mesh.
        /// </summary>
        public uint VertexCount;
        /// <summary>
        /// Triangles of the base mesh.
        /// </summary>
        public uint TriangleCount;
        /// <summary>
        /// Examples.
        /// </summary>
        public uint ExampleCount;
        /// <summary>
        /// Parts of the mesh with a material of their own; at least 1.
        /// </summary>
        public uint PrimitiveCount;
        /// <summary>
        /// Positions that several vertices share.
        /// </summary>
        public uint SeamCount;
        /// <summary>
        /// No vertex moves further than this, m.
        /// </summary>
        public float DepthLimit;
        /// <summary>
        /// Box around the base mesh, m.
        /// </summary>
        public CrumpleAabb Bounds;
        /// <summary>
        /// World matrix of the first node that shows the mesh, column-major; the identity where there is none.
        /// </summary>
        public fixed float NodeTransform[16];
        /// <summary>
        /// Whether the mesh has tangents.
        /// </summary>
        public CrumpleBool HasTangents;
        /// <summary>
        /// Meshes that show the damage: 1, the base mesh, and those of
        /// <see cref="Native.NativeMethods.crumple_example_set_add_lod"/>.
        /// </summary>
        public uint LodCount;
        /// <summary>
        /// Zero; room for later.
        /// </summary>
        public fixed ulong Reserved[4];
    }

    /// <summary>
    /// What an example is. Strings live until the set is destroyed.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public unsafe partial struct CrumpleExampleInfo
    {
        /// <summary>
        /// Its name, UTF-8. Never null.
        /// </summary>
        public IntPtr Name;
        /// <summary>
        /// The vertex that was hit, or its deepest.
        /// </summary>
        public uint ContactVertex;
        /// <summary>
        /// Vertices that it moves. 0: the example does nothing.
        /// </summary>
        public uint MovedVertices;
        /// <summary>
        /// Where it was hit, m.
        /// </summary>
        public CrumpleVec3 ContactPoint;
        /// <summary>
        /// The surface's outward unit normal there; zero where it is not known.
        /// </summary>
        public CrumpleVec3 ContactNormal;
        /// <summary>
        /// How far the contact vertex moves, m.
        /// </summary>
        public float Depth;
        /// <summary>
        /// How far its deepest vertex moves, m.
        /// </summary>
        public float MaxDepth;
        /// <summary>
        /// Distance from the contact to the furthest vertex that moves noticeably, m.
        /// </summary>
        public float SupportRadius;
        /// <summary>
        /// Whether it may be carried.
        /// </summary>
        public CrumplePlacement Placement;
        /// <summary>
        /// Zero; room for later.
        /// </summary>
        public fixed ulong Reserved[2];
    }

    /// <summary>
    /// A part of the mesh with a material of its own.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumplePrimitive
    {
        /// <summary>
        /// Name of its material, UTF-8; null where it has none. Lives until the set is destroyed.
        /// </summary>
        public IntPtr Material;
        /// <summary>
        /// First vertex.
        /// </summary>
        public uint FirstVertex;
        /// <summary>
        /// Number of vertices.
        /// </summary>
        public uint VertexCount;
        /// <summary>
        /// First triangle; its first index is 3 times that.
        /// </summary>
        public uint FirstTriangle;
        /// <summary>
        /// Number of triangles.
        /// </summary>
        public uint TriangleCount;
    }

    /// <summary>
    /// A body in the scene.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public unsafe partial struct CrumpleInstanceDef
    {
        /// <summary>
        /// Bytes of this struct, from <see cref="Native.NativeMethods.crumple_instance_def_default"/>.
        /// </summary>
        public uint StructSize;
        /// <summary>
        /// How many examples one hit may mix: 1 to 4. Default 3.
        /// </summary>
        public uint ExamplesPerHit;
        /// <summary>
        /// The mesh and the examples. Required. The instance keeps what it needs of it alive.
        /// </summary>
        public CrumpleExampleSet Set;
        /// <summary>
        /// What hits do. Default <see cref="CrumpleRule.Marks"/>.
        /// </summary>
        public CrumpleRule Rule;
        /// <summary>
        /// How examples are chosen. Default <see cref="CrumpleSelection.OfRule"/>.
        /// </summary>
        public CrumpleSelection Selection;
        /// <summary>
        /// Marks kept, 1 to 65535, 32 bytes each. Above it the weakest mark gives its energy to its nearest neighbour. Default
        /// 64.
        /// </summary>
        public uint MarkCapacity;
        /// <summary>
        /// No vertex moves further than this, m. 0: the set's limit. Default 0.
        /// </summary>
        public float DepthLimit;
        /// <summary>
        /// Impulses shorter than this leave no mark, N s. Default 0.
        /// </summary>
        public float YieldImpulse;
        /// <summary>
        /// Hits that would displace their contact by less than this leave no mark, m. Default 0.
        /// </summary>
        public float YieldDisplacement;
        /// <summary>
        /// Contacts further than this from the nearest vertex are refused, m. 0: the body's diagonal. Default 0.
        /// </summary>
        public float MaxContactDistance;
        /// <summary>
        /// Constant of <see cref="CrumpleRule.Blend"/>, 0 to 1. Default 0.
        /// </summary>
        public float BlendConstant;
        /// <summary>
        /// No vertex is wrong by more than this, m; see <see cref="Native.NativeMethods.crumple_instance_set_tolerance"/>.
        /// Default 0: nothing is left out.
        /// </summary>
        public float Tolerance;
        /// <summary>
        /// From mesh to world space, column-major (element 4 * column + row); see
        /// <see cref="Native.NativeMethods.crumple_instance_set_transform"/>. Default the identity.
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
    /// One body in the scene: an example set, a transform, and the damage so far. An id; zero is null.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleInstance
    {
        /// <summary>
        /// Place in the context, plus one; 0 is null.
        /// </summary>
        public uint Index;
        /// <summary>
        /// Tells successive users of the place apart.
        /// </summary>
        public ushort Generation;
        /// <summary>
        /// Tells contexts apart.
        /// </summary>
        public ushort Context;
    }

    /// <summary>
    /// What an instance is at the moment.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public unsafe partial struct CrumpleInstanceInfo
    {
        /// <summary>
        /// The id it was made with, which may be stale by now.
        /// </summary>
        public CrumpleExampleSet Set;
        /// <summary>
        /// Bytes of memory it takes, without the set and without your buffers.
        /// </summary>
        public ulong MemoryBytes;
        /// <summary>
        /// Marks, hits that wait among them. 0 with the literature's rules.
        /// </summary>
        public uint MarkCount;
        /// <summary>
        /// Registered buffers.
        /// </summary>
        public uint BufferCount;
        /// <summary>
        /// No vertex moves further than this, m.
        /// </summary>
        public float DepthLimit;
        /// <summary>
        /// Open contacts, see <see cref="Native.NativeMethods.crumple_instance_end_contact"/>.
        /// </summary>
        public uint ContactCount;
        /// <summary>
        /// Zero; room for later.
        /// </summary>
        public fixed uint Reserved[4];
    }

    /// <summary>
    /// A hit by an impulse. The contact is displaced by impulse * duration / mass. Let duration be a constant of the material,
    /// never the time step, and report a contact once, with its whole impulse, or in parts with a contact_id: then dents do not
    /// depend on the frame rate.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleImpulseDef
    {
        /// <summary>
        /// Bytes of this struct, from <see cref="Native.NativeMethods.crumple_impulse_def_default"/>.
        /// </summary>
        public uint StructSize;
        /// <summary>
        /// The space of point and impulse. Default <see cref="CrumpleSpace.Local"/>.
        /// </summary>
        public CrumpleSpace Space;
        /// <summary>
        /// Where it hit, m; its nearest vertex is the contact.
        /// </summary>
        public CrumpleVec3 Point;
        /// <summary>
        /// The impulse that the body received, N s.
        /// </summary>
        public CrumpleVec3 Impulse;
        /// <summary>
        /// How long it acted, s; above 0: a constant of the material, say 0.01, not the time step. Default 0: set it.
        /// </summary>
        public float Duration;
        /// <summary>
        /// Mass of the contact vertex, kg. 0: that of the set. Default 0.
        /// </summary>
        public float Mass;
        /// <summary>
        /// Which contact it is part of, any number of your own; hits of one contact make one dent, see
        /// <see cref="Native.NativeMethods.crumple_instance_end_contact"/>. 0: none, a hit of its own. Default 0.
        /// </summary>
        public ulong ContactId;
        /// <summary>
        /// Only tell what the hit would do, and leave nothing. Default false.
        /// </summary>
        public CrumpleBool Preview;

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
    /// A hit that should displace its contact so far: for engines with a mapping of their own. Free of the frame rate.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleDisplacementDef
    {
        /// <summary>
        /// Bytes of this struct, from <see cref="Native.NativeMethods.crumple_displacement_def_default"/>.
        /// </summary>
        public uint StructSize;
        /// <summary>
        /// The space of point and displacement. Default <see cref="CrumpleSpace.Local"/>.
        /// </summary>
        public CrumpleSpace Space;
        /// <summary>
        /// Where it hit, m; its nearest vertex is the contact.
        /// </summary>
        public CrumpleVec3 Point;
        /// <summary>
        /// How far the contact should move, m.
        /// </summary>
        public CrumpleVec3 Displacement;
        /// <summary>
        /// Which contact it is part of, as in <see cref="CrumpleImpulseDef"/>. Default 0.
        /// </summary>
        public ulong ContactId;
        /// <summary>
        /// Only tell what the hit would do, and leave nothing. Default false.
        /// </summary>
        public CrumpleBool Preview;

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
    /// An example that a hit is made of.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleChosen
    {
        /// <summary>
        /// Its index in the set.
        /// </summary>
        public uint Example;
        /// <summary>
        /// Its share of the dent; the shares of a hit sum to 1. Negative where it corrects others that overshoot.
        /// </summary>
        public float Share;
        /// <summary>
        /// What its displacements are multiplied with.
        /// </summary>
        public float Scale;
        /// <summary>
        /// Whether it stays where it was made; otherwise it is carried to the contact.
        /// </summary>
        public CrumpleBool Anchored;
        /// <summary>
        /// The planes that it is mirrored in: 1 for x, 2 for y, 4 for z, added up.
        /// </summary>
        public byte Mirror;
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
        /// Low 12 bits: share of the dent, two's complement, 1024 being the whole. Bits 12, 13 and 14: the example is mirrored in
        /// x, y, z. Bit 15: it stays where it was made.
        /// </summary>
        public ushort Share;
    }

    /// <summary>
    /// One dent: where, how deep, and made of which examples. Plain data of 32 bytes, the same on every machine: send it over the
    /// network as it is (little-endian) to show the same dent there.
    /// </summary>
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
        /// Strength squared, in units of 2^-32: 4294967296 for one hit; each hit that repeats the mark adds as much.
        /// </summary>
        public ulong Energy;
        /// <summary>
        /// One to four examples, the used ones first.
        /// </summary>
        public CrumplePair Pairs0;
        /// <summary>
        /// One to four examples, the used ones first.
        /// </summary>
        public CrumplePair Pairs1;
        /// <summary>
        /// One to four examples, the used ones first.
        /// </summary>
        public CrumplePair Pairs2;
        /// <summary>
        /// One to four examples, the used ones first.
        /// </summary>
        public CrumplePair Pairs3;
    }

    /// <summary>
    /// What a hit was turned into, and what of it could not be met.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleHitResult
    {
        /// <summary>
        /// What became of it.
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
        /// Displacement asked for at the contact, m, in the mesh's space.
        /// </summary>
        public CrumpleVec3 Target;
        /// <summary>
        /// Displacement that this hit alone brings there, m, in the mesh's space.
        /// </summary>
        public CrumpleVec3 Achieved;
        /// <summary>
        /// Number of chosen examples.
        /// </summary>
        public uint ChosenCount;
        /// <summary>
        /// Whether the target was longer than the depth limit and was cut to it.
        /// </summary>
        public CrumpleBool Clamped;
        /// <summary>
        /// The examples, the weightiest first.
        /// </summary>
        public CrumpleChosen Chosen0;
        /// <summary>
        /// The examples, the weightiest first.
        /// </summary>
        public CrumpleChosen Chosen1;
        /// <summary>
        /// The examples, the weightiest first.
        /// </summary>
        public CrumpleChosen Chosen2;
        /// <summary>
        /// The examples, the weightiest first.
        /// </summary>
        public CrumpleChosen Chosen3;
        /// <summary>
        /// The mark it leaves; zero everywhere where it leaves none.
        /// </summary>
        public CrumpleMark Mark;
    }

    /// <summary>
    /// Memory for the deformed vertices of one instance, in the mesh's order and space.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleHostBufferDef
    {
        /// <summary>
        /// Bytes of this struct, from <see cref="Native.NativeMethods.crumple_host_buffer_def_default"/>.
        /// </summary>
        public uint StructSize;
        /// <summary>
        /// The mesh whose vertices are written: 0 the base mesh, else a number from
        /// <see cref="Native.NativeMethods.crumple_example_set_add_lod"/>. Counts of vertices are that mesh's. Default 0.
        /// </summary>
        public uint Lod;
        /// <summary>
        /// Positions: 3 floats a vertex, m. Required.
        /// </summary>
        public CrumpleStream Positions;
        /// <summary>
        /// Unit normals: 3 floats a vertex. Absent: none are written.
        /// </summary>
        public CrumpleStream Normals;
        /// <summary>
        /// Tangents: 4 floats a vertex, xyz of unit length and orthogonal to the normal, w as in the base mesh. Absent: none are
        /// written.
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
    /// Memory of yours that an instance's deformed vertices are written to. An id; zero is null.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleBuffer
    {
        /// <summary>
        /// Place in the context, plus one; 0 is null.
        /// </summary>
        public uint Index;
        /// <summary>
        /// Tells successive users of the place apart.
        /// </summary>
        public ushort Generation;
        /// <summary>
        /// Tells contexts apart.
        /// </summary>
        public ushort Context;
    }

    /// <summary>
    /// What a deform did.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public unsafe partial struct CrumpleDeformReport
    {
        /// <summary>
        /// Vertices written, over all buffers.
        /// </summary>
        public ulong VerticesWritten;
        /// <summary>
        /// Blocks of consecutive vertices written.
        /// </summary>
        public ulong BlocksWritten;
        /// <summary>
        /// Blocks that were up to date already.
        /// </summary>
        public ulong BlocksSkipped;
        /// <summary>
        /// Examples of marks that tolerances left out of blocks written, see
        /// <see cref="Native.NativeMethods.crumple_instance_set_tolerance"/>.
        /// </summary>
        public ulong PartsSkipped;
        /// <summary>
        /// Zero; room for later.
        /// </summary>
        public fixed ulong Reserved[4];
    }

    /// <summary>
    /// Consecutive vertices.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleRange
    {
        /// <summary>
        /// First vertex.
        /// </summary>
        public uint First;
        /// <summary>
        /// Number of vertices.
        /// </summary>
        public uint Count;
    }

    /// <summary>
    /// Any Vulkan function, as PFN_vkVoidFunction: (<see cref="CrumpleVulkanFunction"/>)vkGetInstanceProcAddr.
    /// </summary>
    [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
    public delegate void CrumpleVulkanFunction();

    /// <summary>
    /// Your Vulkan device, of Vulkan 1.1 or later. No extension and no feature needs to be enabled.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleVulkanAttachDef
    {
        /// <summary>
        /// Bytes of this struct, from <see cref="Native.NativeMethods.crumple_vulkan_attach_def_default"/>.
        /// </summary>
        public uint StructSize;
        /// <summary>
        /// Family of the queue that command buffers are submitted to; one that can compute. Required. Default UINT32_MAX.
        /// </summary>
        public uint QueueFamily;
        /// <summary>
        /// vkGetInstanceProcAddr of the loader that the instance was made with. Every function is taken from it; Crumple never
        /// opens a Vulkan library of its own accord. Required.
        /// </summary>
        public IntPtr GetInstanceProcAddr;
        /// <summary>
        /// The VkInstance. Required.
        /// </summary>
        public IntPtr Instance;
        /// <summary>
        /// The VkPhysicalDevice. Required.
        /// </summary>
        public IntPtr PhysicalDevice;
        /// <summary>
        /// The VkDevice. Required.
        /// </summary>
        public IntPtr Device;
        /// <summary>
        /// What <see cref="Native.NativeMethods.crumple_vulkan_get_pipeline_cache"/> gave at an earlier run; read during the
        /// call. Data of another driver is not used. Default null: none.
        /// </summary>
        public IntPtr PipelineCache;
        /// <summary>
        /// Bytes at pipeline_cache.
        /// </summary>
        public UIntPtr PipelineCacheSize;
        /// <summary>
        /// Invocations a workgroup: 32, 64, 128 or 256, no more than the device can. Default 128.
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
    /// Where the values of one attribute lie. Zero everywhere: the attribute is absent.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleVulkanStream
    {
        /// <summary>
        /// Bytes from the range's begin to the first vertex's value; a multiple of 4.
        /// </summary>
        public ulong Offset;
        /// <summary>
        /// Bytes from one vertex's value to the next; a multiple of 4, at least those of one value.
        /// </summary>
        public ulong Stride;
        /// <summary>
        /// A VkFormat. Positions: R32G32B32_SFLOAT, R16G16B16A16_SFLOAT (the fourth is 1), R16G16B16A16_SNORM (see scale).
        /// Normals: R32G32B32_SFLOAT, R16G16B16A16_SNORM, R8G8B8A8_SNORM (the fourth is 0). Tangents: R32G32B32A32_SFLOAT,
        /// R16G16B16A16_SNORM, R8G8B8A8_SNORM.
        /// </summary>
        public uint Format;
        /// <summary>
        /// Zero.
        /// </summary>
        public uint Reserved;
    }

    /// <summary>
    /// A range of a VkBuffer for the deformed vertices of one instance, in the mesh's order and space.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleVulkanBufferDef
    {
        /// <summary>
        /// Bytes of this struct, from <see cref="Native.NativeMethods.crumple_vulkan_buffer_def_default"/>.
        /// </summary>
        public uint StructSize;
        /// <summary>
        /// The mesh whose vertices are written: 0 the base mesh, else a number from
        /// <see cref="Native.NativeMethods.crumple_example_set_add_lod"/>. Default 0.
        /// </summary>
        public uint Lod;
        /// <summary>
        /// The VkBuffer, bound to memory: (uint64_t)handle. Required. Any number of ranges may lie in it; this field and the
        /// seven below it are then the same for each.
        /// </summary>
        public ulong Buffer;
        /// <summary>
        /// Bytes of the whole VkBuffer. Required.
        /// </summary>
        public ulong BufferSize;
        /// <summary>
        /// The VkBufferUsageFlags that it was made with; VK_BUFFER_USAGE_STORAGE_BUFFER_BIT must be among them. Required.
        /// </summary>
        public uint Usage;
        /// <summary>
        /// The queue family that owns it before and after what Crumple records; not the device's own: each recording that names
        /// one of its ranges then begins with an acquire and ends with a release of the whole VkBuffer, even where no vertex
        /// changed, and the release and acquire of that other queue are yours. Default VK_QUEUE_FAMILY_IGNORED: that of the
        /// device owns it, or it is shared (VK_SHARING_MODE_CONCURRENT).
        /// </summary>
        public uint QueueFamily;
        /// <summary>
        /// The VkPipelineStageFlags in which you used the VkBuffer last before a recording, anything in it, since barriers are of
        /// the whole: indices, copies into it, read-backs; not 0. Default VK_PIPELINE_STAGE_VERTEX_INPUT_BIT.
        /// </summary>
        public uint BeforeStages;
        /// <summary>
        /// The VkAccessFlags of that use. Default VK_ACCESS_VERTEX_ATTRIBUTE_READ_BIT.
        /// </summary>
        public uint BeforeAccess;
        /// <summary>
        /// The VkPipelineStageFlags in which you use it next, anything in it; not 0. Default VK_PIPELINE_STAGE_VERTEX_INPUT_BIT.
        /// </summary>
        public uint AfterStages;
        /// <summary>
        /// The VkAccessFlags of that use. Default VK_ACCESS_VERTEX_ATTRIBUTE_READ_BIT.
        /// </summary>
        public uint AfterAccess;
        /// <summary>
        /// Bytes before the range; a multiple of 4.
        /// </summary>
        public ulong Offset;
        /// <summary>
        /// Bytes of the range: nothing outside it is written. Ranges may interleave; values must not overlap. Required.
        /// </summary>
        public ulong Size;
        /// <summary>
        /// Positions, m. Required.
        /// </summary>
        public CrumpleVulkanStream Positions;
        /// <summary>
        /// Unit normals. Absent: none are written.
        /// </summary>
        public CrumpleVulkanStream Normals;
        /// <summary>
        /// Tangents: xyz of unit length and orthogonal to the normal, w as in the base mesh. Absent: none are written.
        /// </summary>
        public CrumpleVulkanStream Tangents;
        /// <summary>
        /// Of positions in R16G16B16A16_SNORM: a stored number s, -1 to 1, stands for s * scale + bias, m. What lies outside is
        /// held at the border, so take the mesh's bounds grown by the depth limit. Above 0. Default 1, 1, 1.
        /// </summary>
        public CrumpleVec3 Scale;
        /// <summary>
        /// See scale, m. Default 0, 0, 0.
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
    /// What was recorded.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public unsafe partial struct CrumpleRecordReport
    {
        /// <summary>
        /// Vertices that will be written, over all buffers.
        /// </summary>
        public ulong VerticesWritten;
        /// <summary>
        /// Blocks of consecutive vertices that will be written. 0: nothing was recorded, but what queue families ask for.
        /// </summary>
        public ulong BlocksWritten;
        /// <summary>
        /// Blocks that were up to date already.
        /// </summary>
        public ulong BlocksSkipped;
        /// <summary>
        /// Examples of marks that tolerances left out, see <see cref="Native.NativeMethods.crumple_instance_set_tolerance"/>.
        /// </summary>
        public ulong PartsSkipped;
        /// <summary>
        /// Bytes that the commands copy to the device, those of meshes seen for the first time among them.
        /// </summary>
        public ulong BytesCopied;
        /// <summary>
        /// Dispatches: one for each VkBuffer, and one for each buffer of an instance with one of the literature's rules.
        /// </summary>
        public uint Dispatches;
        /// <summary>
        /// Zero.
        /// </summary>
        public uint Reserved0;
        /// <summary>
        /// Zero; room for later.
        /// </summary>
        public fixed ulong Reserved[4];
    }

    /// <summary>
    /// A Vulkan device that Crumple makes for itself, beside yours on the same physical device.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public unsafe partial struct CrumpleVulkanOpenDef
    {
        /// <summary>
        /// Bytes of this struct, from <see cref="Native.NativeMethods.crumple_vulkan_open_def_default"/>.
        /// </summary>
        public uint StructSize;
        /// <summary>
        /// As in <see cref="CrumpleVulkanAttachDef"/>. Default 128.
        /// </summary>
        public uint WorkgroupSize;
        /// <summary>
        /// vkGetInstanceProcAddr of a loader. Required; it stays loaded.
        /// </summary>
        public IntPtr GetInstanceProcAddr;
        /// <summary>
        /// deviceUUID of your physical device (VkPhysicalDeviceIDProperties): memory can be shared within it alone. Zero
        /// everywhere: the first that can compute. Default zero.
        /// </summary>
        public fixed byte DeviceUuid[16];
        /// <summary>
        /// As in <see cref="CrumpleVulkanAttachDef"/>. Default null.
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
    /// A VkBuffer of your device, in memory that it exported. You made it with VkExternalMemoryBufferCreateInfo, and its memory
    /// with VkExportMemoryAllocateInfo, both of the same type of handle.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleVulkanImportDef
    {
        /// <summary>
        /// Bytes of this struct, from <see cref="Native.NativeMethods.crumple_vulkan_import_def_default"/>.
        /// </summary>
        public uint StructSize;
        /// <summary>
        /// What handle is. Default <see cref="CrumpleHandleType.OpaqueFd"/>.
        /// </summary>
        public CrumpleHandleType HandleType;
        /// <summary>
        /// The handle of the memory. Required. Default -1.
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
        /// VkBufferUsageFlags that the buffer was made with; VK_BUFFER_USAGE_STORAGE_BUFFER_BIT must be among them. Required.
        /// </summary>
        public uint Usage;
        /// <summary>
        /// Where in the memory the buffer was bound, bytes. Default 0.
        /// </summary>
        public ulong Offset;
        /// <summary>
        /// The buffer's size, bytes. Required.
        /// </summary>
        public ulong Size;
        /// <summary>
        /// Whether the memory was allocated for this buffer alone (VkMemoryDedicatedAllocateInfo). Default false.
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
    /// A point bound to the surface nearest to it. Plain data: keep it, copy it, save it; it fits every instance of its set.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public unsafe partial struct CrumpleAttachment
    {
        /// <summary>
        /// The triangle's vertices; all the same for a mesh without triangles.
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
    }

    /// <summary>
    /// A rotation: a unit quaternion, x y z w, w the real part.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleQuat
    {
        /// <summary>
        /// i part.
        /// </summary>
        public float X;
        /// <summary>
        /// j part.
        /// </summary>
        public float Y;
        /// <summary>
        /// k part.
        /// </summary>
        public float Z;
        /// <summary>
        /// Real part.
        /// </summary>
        public float W;
    }

    /// <summary>
    /// Where an attached point is.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CrumpleFrame
    {
        /// <summary>
        /// Position, m, in the mesh's space.
        /// </summary>
        public CrumpleVec3 Position;
        /// <summary>
        /// Rotation since rest.
        /// </summary>
        public CrumpleQuat Rotation;
    }
}
