// Generated from the headers in include by `cargo xtask header`; do not edit it. They document what is declared here. C# lays out
// structs as C does; tests compare them with a C compiler's.
#pragma warning disable 1591

using System;
using System.Runtime.InteropServices;
using Crumple.Native;

namespace Crumple
{
    [Flags]
    public enum CrumpleFeatures : ulong
    {
        Gltf = 1,
        Obj = 2,
        HostAllocator = 4,
        Vulkan = 8,
    }

    public enum CrumpleResult
    {
        Ok = 0,
        ErrorInvalidArgument = 1,
        ErrorNotFinite = 2,
        ErrorIndexOutOfRange = 3,
        ErrorMesh = 4,
        ErrorExampleMismatch = 5,
        ErrorBufferTooSmall = 6,
        ErrorMisaligned = 7,
        ErrorContactTooFar = 8,
        ErrorUnsupported = 9,
        ErrorFormat = 10,
        ErrorIo = 11,
        ErrorDamageMismatch = 12,
        ErrorOutOfMemory = 13,
        ErrorWrongRule = 14,
        ErrorVulkan = 15,
        ErrorDeviceLost = 16,
        ErrorUnknownContact = 17,
        ErrorNullPointer = 64,
        ErrorStructSize = 65,
        ErrorInvalidId = 66,
        ErrorConcurrentUse = 67,
        ErrorInternal = 68,
        ErrorFramesInFlight = 69,
    }

    public enum CrumpleLogLevel
    {
        Info = 0,
        Warning = 1,
    }

    public enum CrumpleBytes
    {
        Copy = 0,
        Keep = 1,
    }

    public enum CrumpleRule
    {
        Marks = 0,
        MostDisplaced = 1,
        Blend = 2,
    }

    public enum CrumpleSelection
    {
        Classic = 0,
        ClassicUnclamped = 1,
    }

    public enum CrumpleHitKind
    {
        Blow = 0,
        Displacement = 1,
    }

    public enum CrumpleSpace
    {
        Local = 0,
        World = 1,
    }

    public enum CrumpleStrikerShape
    {
        Unknown = 0,
        Ball = 1,
        Pole = 2,
        Corner = 3,
        Wall = 4,
    }

    public enum CrumpleHitStatus
    {
        Marked = 0,
        BelowYield = 1,
        NothingReaches = 2,
        Accumulated = 3,
        Rigid = 4,
    }

    public enum CrumpleImpulses
    {
        PerPoint = 0,
        WholeAtEveryPoint = 1,
        ZeroIsUnknown = 2,
    }

    public enum CrumpleDirectionFormat
    {
        Float = 0,
        Octahedral = 1,
    }

    [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
    public delegate void CrumpleLog(CrumpleLogLevel level, IntPtr message, IntPtr user);

    [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
    public delegate void CrumpleTask(uint index, IntPtr taskData);

    [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
    public delegate void CrumpleParallelFor(uint count, IntPtr task, IntPtr taskData, IntPtr user);

    public partial struct CrumpleTaskSystem
    {
        public IntPtr ParallelFor;
        public IntPtr User;
        public uint Workers;
    }

    public partial struct CrumpleContextDef
    {
        public uint StructSize;
        public uint Threads;
        public IntPtr Log;
        public IntPtr LogUser;
        public CrumpleTaskSystem Tasks;

        public static CrumpleContextDef Default => CrumpleRuntime.Loaded(() => NativeMethods.crumple_context_def_default());
    }

    public partial struct CrumpleExampleSet
    {
        public uint Index;
        public ushort Generation;
        public ushort Context;
    }

    public partial struct CrumpleVec3
    {
        public float X;
        public float Y;
        public float Z;
    }

    public partial struct CrumpleAabb
    {
        public CrumpleVec3 Min;
        public CrumpleVec3 Max;
    }

    public unsafe partial struct CrumpleExampleSetInfo
    {
        public IntPtr Name;
        public ulong Fingerprint;
        public ulong MemoryBytes;
        public uint VertexCount;
        public uint TriangleCount;
        public uint ExampleCount;
        public uint PrimitiveCount;
        public uint SeamCount;
        public float DepthLimit;
        public CrumpleAabb Bounds;
        public fixed float NodeTransform[16];
        public CrumpleBool HasTangents;
        public uint LodCount;
        public uint BlowCount;
        public float FieldError;
        public fixed ulong Reserved[2];
    }

    public partial struct CrumpleStream
    {
        public IntPtr Data;
        public UIntPtr Size;
        public UIntPtr Offset;
        public UIntPtr Stride;
    }

    public partial struct CrumpleMeshCopyDef
    {
        public uint StructSize;
        public uint Lod;
        public CrumpleStream Positions;
        public CrumpleStream Normals;
        public CrumpleStream Tangents;
        public CrumpleStream Indices;

        public static CrumpleMeshCopyDef Default => CrumpleRuntime.Loaded(() => NativeMethods.crumple_mesh_copy_def_default());
    }

    public unsafe partial struct CrumpleInstanceDef
    {
        public uint StructSize;
        public uint MarkCapacity;
        public CrumpleExampleSet Set;
        public ulong UserData;
        public CrumpleRule Rule;
        public CrumpleSelection Selection;
        public float DepthLimit;
        public float YieldImpulse;
        public float YieldDisplacement;
        public float MaxContactDistance;
        public float BlendConstant;
        public float Compliance;
        public float GrowTime;
        public fixed float LocalToWorld[16];

        public static CrumpleInstanceDef Default => CrumpleRuntime.Loaded(() => NativeMethods.crumple_instance_def_default());
    }

    public partial struct CrumpleInstance
    {
        public uint Index;
        public ushort Generation;
        public ushort Context;
    }

    public unsafe partial struct CrumpleInstanceInfo
    {
        public CrumpleExampleSet Set;
        public ulong MemoryBytes;
        public uint MarkCount;
        public uint BufferCount;
        public float DepthLimit;
        public uint ContactCount;
        public ulong Revision;
        public fixed uint Reserved[2];
    }

    public unsafe partial struct CrumpleStriker
    {
        public float Mass;
        public float Radius;
        public CrumpleVec3 Velocity;
        public CrumpleStrikerShape Shape;
        public fixed uint Reserved[2];
    }

    public partial struct CrumpleHitDef
    {
        public uint StructSize;
        public CrumpleHitKind Kind;
        public CrumpleSpace Space;
        public CrumpleVec3 Point;
        public CrumpleVec3 Displacement;
        public CrumpleVec3 Impulse;
        public float Duration;
        public float Mass;
        public CrumpleVec3 Normal;
        public CrumpleStriker Striker;
        public ulong ContactId;

        public static CrumpleHitDef Default => CrumpleRuntime.Loaded(() => NativeMethods.crumple_hit_def_default());
    }

    public unsafe partial struct CrumpleMark
    {
        public uint Contact;
        public float Depth;
        public ulong Hits;
        public ushort Told;
        public ushort Striker;
        public fixed ushort Direction[2];
        public ushort Strength;
        public ushort Mass;
        public ushort Radius;
        public ushort Reserved;
    }

    public unsafe partial struct CrumpleHitResult
    {
        public CrumpleHitStatus Status;
        public uint ContactVertex;
        public float ContactDistance;
        public CrumpleVec3 Target;
        public CrumpleVec3 Achieved;
        public float ExpectedError;
        public CrumpleBool Clamped;
        public CrumpleMark Mark;
        public fixed uint Reserved[7];
    }

    public partial struct CrumpleContactOptionsDef
    {
        public uint StructSize;
        public CrumpleImpulses Impulses;
        public float Gain;
        public float MinSpeed;
        public float MinEnergy;
        public float DentRadius;
        public float TouchTime;
        public float SeparationTime;
        public uint MaxPoints;
        public uint MaxTouches;

        public static CrumpleContactOptionsDef Default => CrumpleRuntime.Loaded(() => NativeMethods.crumple_contact_options_def_default());
    }

    public unsafe partial struct CrumpleContactPointDef
    {
        public uint StructSize;
        public CrumpleBool HasVelocity;
        public CrumpleBool HasVelocityAfter;
        public ulong Pair;
        public CrumpleInstance Bodies0;
        public CrumpleInstance Bodies1;
        public CrumpleVec3 Point;
        public CrumpleVec3 Normal;
        public CrumpleVec3 Velocity;
        public CrumpleVec3 VelocityAfter;
        public float Impulse;
        public fixed float Masses[2];
        public float InverseMass;
        public fixed float Radii[2];
        public CrumpleStrikerShape Shapes0;
        public CrumpleStrikerShape Shapes1;
        public float Gain;

        public static CrumpleContactPointDef Default => CrumpleRuntime.Loaded(() => NativeMethods.crumple_contact_point_def_default());
    }

    public unsafe partial struct CrumpleContactReport
    {
        public ulong Points;
        public ulong Hits;
        public ulong Begun;
        public ulong Ended;
        public ulong Open;
        public ulong Slow;
        public ulong Separating;
        public ulong Weak;
        public ulong Crowded;
        public ulong Refused;
        public CrumpleResult Refusal;
        public fixed uint Reserved[3];
    }

    public partial struct CrumpleHostBufferDef
    {
        public uint StructSize;
        public uint Lod;
        public ulong UserData;
        public CrumpleStream Positions;
        public CrumpleStream Normals;
        public CrumpleStream Tangents;
        public CrumpleDirectionFormat NormalFormat;
        public CrumpleDirectionFormat TangentFormat;

        public static CrumpleHostBufferDef Default => CrumpleRuntime.Loaded(() => NativeMethods.crumple_host_buffer_def_default());
    }

    public partial struct CrumpleBuffer
    {
        public uint Index;
        public ushort Generation;
        public ushort Context;
    }

    public unsafe partial struct CrumpleBufferInfo
    {
        public CrumpleBuffer Buffer;
        public CrumpleInstance Instance;
        public ulong UserData;
        public ulong InstanceUserData;
        public uint Lod;
        public fixed uint Reserved[3];
    }

    public unsafe partial struct CrumpleDeformReport
    {
        public ulong VerticesWritten;
        public ulong BlocksWritten;
        public ulong BlocksSkipped;
        public ulong VerticesWaiting;
        public fixed ulong Reserved[3];
    }

    public partial struct CrumpleRange
    {
        public uint First;
        public uint Count;
    }

    public enum CrumpleContactKind
    {
        None = 0,
        Vertex = 1,
        Point = 2,
    }

    public enum CrumpleIndexType
    {
        U32 = 0,
        U16 = 1,
    }

    public partial struct CrumpleInput
    {
        public IntPtr Data;
        public UIntPtr Size;
        public UIntPtr Stride;
    }

    public partial struct CrumpleExampleDef
    {
        public uint StructSize;
        public uint DeltaCount;
        public IntPtr Name;
        public CrumpleInput TargetPositions;
        public CrumpleInput TargetNormals;
        public CrumpleInput DeltaIndices;
        public CrumpleInput PositionDeltas;
        public CrumpleInput NormalDeltas;
        public CrumpleContactKind ContactKind;
        public uint ContactVertex;
        public CrumpleVec3 ContactPoint;
        public CrumpleVec3 ContactNormal;
        public CrumpleVec3 Impulse;
        public float Duration;
        public CrumpleStriker Striker;
        public CrumpleBool HasContactNormal;

        public static CrumpleExampleDef Default => CrumpleRuntime.Loaded(() => NativeMethods.crumple_example_def_default());
    }

    public partial struct CrumpleMeshDef
    {
        public uint StructSize;
        public uint VertexCount;
        public uint IndexCount;
        public CrumpleIndexType IndexType;
        public CrumpleInput Positions;
        public CrumpleInput Normals;
        public CrumpleInput Tangents;
        public CrumpleInput Indices;
        public CrumpleInput DepthLimits;
        public CrumpleInput Stiffness;

        public static CrumpleMeshDef Default => CrumpleRuntime.Loaded(() => NativeMethods.crumple_mesh_def_default());
    }

    public partial struct CrumpleExampleSetOptions
    {
        public float DepthLimit;
        public float DropBelow;
        public float VertexMass;
        public float BasisTolerance;
        public float BakeTolerance;
        public float BakeNormalTolerance;
        public CrumpleInput VertexMasses;
        public CrumpleBool Mirror;
        public CrumpleBool HeldRims;
        public CrumpleBool WholeExamples;
    }

    public partial struct CrumpleExampleSetDef
    {
        public uint StructSize;
        public uint ExampleCount;
        public IntPtr Mesh;
        public IntPtr Examples;
        public CrumpleExampleSetOptions Options;

        public static CrumpleExampleSetDef Default => CrumpleRuntime.Loaded(() => NativeMethods.crumple_example_set_def_default());
    }

    public partial struct CrumpleCapsule
    {
        public CrumpleVec3 A;
        public CrumpleVec3 B;
        public float Radius;
    }

    public partial struct CrumpleExampleInfo
    {
        public IntPtr Name;
        public uint ContactVertex;
        public uint MovedVertices;
        public CrumpleVec3 ContactPoint;
        public CrumpleVec3 ContactNormal;
        public float Depth;
        public float MaxDepth;
        public float SupportRadius;
        public float FieldError;
        public ulong Reserved;
    }

    public unsafe partial struct CrumpleDamageMapping
    {
        public uint Kept;
        public uint Moved;
        public uint TooFar;
        public uint WithoutBlows;
        public float Distance;
        public fixed uint Reserved[3];
    }

    public enum CrumplePartKind
    {
        Dents = 0,
        Rigid = 1,
        Glass = 2,
    }

    public partial struct CrumpleGltfDef
    {
        public uint StructSize;
        public uint MeshIndex;
        public IntPtr MeshName;
        public IntPtr Path;
        public CrumpleBool JoinNodes;
        public float Unit;
        public IntPtr Nodes;
        public IntPtr Targets;
        public IntPtr Rigid;
        public IntPtr Glass;
        public IntPtr Moving;
        public CrumpleExampleSetOptions Options;

        public static CrumpleGltfDef Default => CrumpleRuntime.Loaded(() => NativeMethods.crumple_gltf_def_default());
    }

    public partial struct CrumpleObjDef
    {
        public uint StructSize;
        public uint ExampleCount;
        public IntPtr BasePath;
        public IntPtr ExamplePaths;
        public CrumpleExampleSetOptions Options;

        public static CrumpleObjDef Default => CrumpleRuntime.Loaded(() => NativeMethods.crumple_obj_def_default());
    }

    public unsafe partial struct CrumplePrimitive
    {
        public IntPtr Material;
        public uint FirstVertex;
        public uint VertexCount;
        public uint FirstTriangle;
        public uint TriangleCount;
        public fixed uint Reserved[2];
    }

    public unsafe partial struct CrumplePart
    {
        public IntPtr Name;
        public CrumplePartKind Kind;
        public uint FirstVertex;
        public uint VertexCount;
        public uint FirstTriangle;
        public uint TriangleCount;
        public fixed uint Reserved[3];
    }

    public unsafe partial struct CrumpleAttachment
    {
        public fixed uint Vertices[3];
        public fixed float Weights[3];
        public CrumpleVec3 Point;
        public fixed uint Reserved[3];
    }

    public partial struct CrumpleQuat
    {
        public float X;
        public float Y;
        public float Z;
        public float W;
    }

    public unsafe partial struct CrumplePose
    {
        public CrumpleVec3 Position;
        public CrumpleQuat Rotation;
        public fixed uint Reserved[5];
    }

    public partial struct CrumpleContactHit
    {
        public ulong Pair;
        public ulong ContactId;
        public CrumpleInstance Instance;
        public CrumpleVec3 Point;
        public CrumpleVec3 Impulse;
        public CrumpleHitResult Result;
    }
}
