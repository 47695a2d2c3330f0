using System;
using Crumple;

/// <summary>Each kind of failure as the exception that it should be; nothing has changed after it.</summary>
static class ErrorTests
{
    public static void OfCalls()
    {
        using (CrumpleContext context = Sheet.Context())
        {
            ExampleSet set = context.CreateExampleSet(Sheet.Def());
            Instance body = context.CreateInstance(set);
            CrumpleVec3 middle = Sheet.Point(312, -1), down = new CrumpleVec3(0, 0, -1);
            Check.Fails(CrumpleResult.ErrorInvalidArgument, "threads", () => new CrumpleContext(new ContextOptions { Threads = 2000 }));
            Check.Fails(CrumpleResult.ErrorInvalidArgument, "duration", () => body.SubmitImpulse(middle, down, 0));
            Check.Fails(CrumpleResult.ErrorInvalidArgument, "mass", () => body.SubmitImpulse(middle, down, 0.01f));
            Check.Fails(CrumpleResult.ErrorNotFinite, "point", () => body.SubmitDisplacement(new CrumpleVec3(float.NaN, 0, 0), down));
            Check.Fails(CrumpleResult.ErrorContactTooFar, "", () => body.SubmitDisplacement(new CrumpleVec3(0, 0, 50), down));
            Check.Fails(CrumpleResult.ErrorIndexOutOfRange, "3", () => set.GetExample(3));
            Check.Fails(CrumpleResult.ErrorMisaligned, "stride",
                () => body.RegisterHostBuffer(StridedArray.Of(new byte[Sheet.Vertices * 13], 0, 13)));
            Check.Fails(CrumpleResult.ErrorBufferTooSmall, "positions", () => body.RegisterHostBuffer(StridedArray.Of(new CrumpleVec3[5])));
            Check.Fails(CrumpleResult.ErrorMesh, "tangents", () => body.RegisterHostBuffer(
                StridedArray.Of(new CrumpleVec3[Sheet.Vertices]), tangents: StridedArray.Of(new float[Sheet.Vertices * 4], 0, 16)));
            Check.Fails(CrumpleResult.ErrorNullPointer, "positions", () => body.RegisterHostBuffer(default(StridedArray)));
            Check.Fails(CrumpleResult.ErrorDamageMismatch, "", () => body.LoadDamage(new byte[3]));
            Check.Fails(CrumpleResult.ErrorDamageMismatch, "", () => body.LoadDamage(default(ReadOnlySpan<byte>)));
            Check.Fails(CrumpleResult.ErrorInvalidArgument, "", () => body.EndContact(0));
            Check.Fails(CrumpleResult.ErrorInvalidArgument, "", () => body.RepairDamage(2));
            Check.Fails(CrumpleResult.ErrorInvalidArgument, "contact", () => body.SetMarks(new[] { new CrumpleMark { Contact = 99999 } }));
            body.SubmitDisplacement(middle, down);
            Check.Fails(CrumpleResult.ErrorBufferTooSmall, "room for 0", () => body.CopyMarks(default(Span<CrumpleMark>)));
            Check.Fails(CrumpleResult.ErrorBufferTooSmall, "", () => body.SaveDamage(default(Span<byte>)));
            Check.Fails(CrumpleResult.ErrorBufferTooSmall, "", () => body.SaveDamage(new byte[4]));
            CrumpleInstanceDef blend = CrumpleInstanceDef.Default;
            blend.Rule = CrumpleRule.Blend;
            Instance classic = context.CreateInstance(set, in blend);
            Check.Fails(CrumpleResult.ErrorWrongRule, "Marks", () => classic.GetMarks());
            CrumpleInstanceDef none = CrumpleInstanceDef.Default;
            none.StructSize = 8;
            Check.Fails(CrumpleResult.ErrorStructSize, "struct_size", () => context.CreateInstance(set, in none));
            Check.Same(1, body.MarkCount, "marks after all that");
            // Of another context.
            using (CrumpleContext other = Sheet.Context())
                Check.Fails(CrumpleResult.ErrorInvalidId, "another context", () => other.CreateInstance(set));
        }
    }

    public static void OfSets()
    {
        using (CrumpleContext context = Sheet.Context())
        {
            Action<Action<ExampleSetDef>, CrumpleResult, string> broken = (breaks, result, part) =>
            {
                ExampleSetDef def = Sheet.Def();
                breaks(def);
                Check.Fails(result, part, () => context.CreateExampleSet(def));
            };
            broken(def => def.Examples.Clear(), CrumpleResult.ErrorExampleMismatch, "example");
            broken(def => def.VertexCount++, CrumpleResult.ErrorBufferTooSmall, "positions");
            broken(def => def.VertexCount = 0, CrumpleResult.ErrorMesh, "vert");
            broken(def => def.IndexCount--, CrumpleResult.ErrorInvalidArgument, "index_count");
            broken(def => def.SetTriangles(new[] { 0, 1, 99999 }), CrumpleResult.ErrorIndexOutOfRange, "99999");
            broken(def => def.SetTriangles(new[] { 0, 1, -1 }), CrumpleResult.ErrorIndexOutOfRange, "4294967295");
            broken(def => def.Options.BasisTolerance = -1, CrumpleResult.ErrorInvalidArgument, "basis_tolerance");
            broken(def => def.Positions = default(StridedArray), CrumpleResult.ErrorNullPointer, "positions");
            Check.Throws<ArgumentOutOfRangeException>(() => context.CreateExampleSet(new ExampleSetDef { VertexCount = -1 }), "VertexCount");
            Check.Throws<ArgumentNullException>(() => context.CreateExampleSet(null));
            Check.Throws<ArgumentNullException>(() => StridedArray.Of<float>(null));
            Check.Throws<ArgumentNullException>(() => StridedArray.At(IntPtr.Zero, 4, 0, 4));
            Check.Throws<ArgumentOutOfRangeException>(() => StridedArray.Of(new float[3], 16, 12), "offset");
            Check.Throws<ArgumentException>(() => StridedArray.Of(new bool[3]), "plain numbers");
            Check.Throws<ArgumentException>(() => StridedArray.Of(new Holder[1]), "plain numbers");
        }
    }

    struct Holder
    {
#pragma warning disable 649
        public string Text;
#pragma warning restore 649
    }

    /// <summary>Where no device is, and none can be.</summary>
    public static void OfVulkan()
    {
        using (CrumpleContext context = Sheet.Context())
        {
            Instance body = context.CreateInstance(context.CreateExampleSet(Sheet.Def()));
            CrumpleVulkanAttachDef def = CrumpleVulkanAttachDef.Default;
            Check.Fails(CrumpleResult.ErrorNullPointer, "def.instance", () => context.AttachVulkan(in def));
            CrumpleVulkanOpenDef own = CrumpleVulkanOpenDef.Default;
            Check.Fails(CrumpleResult.ErrorNullPointer, "get_instance_proc_addr", () => context.OpenVulkan(in own));
            CrumpleVulkanBufferDef range = CrumpleVulkanBufferDef.Default;
            Check.Fails(CrumpleResult.ErrorInvalidArgument, "device", () => body.RegisterVulkanBuffer(in range));
            Check.Fails(CrumpleResult.ErrorInvalidArgument, "device", () => context.RecordDeform(new IntPtr(16), 1));
            Check.Fails(CrumpleResult.ErrorInvalidArgument, "device", () => context.CompleteFrames(1));
            Check.Fails(CrumpleResult.ErrorInvalidArgument, "device", () => context.DiscardFrames(1));
            Check.Fails(CrumpleResult.ErrorInvalidArgument, "device", () => context.DetachVulkan());
            Check.Fails(CrumpleResult.ErrorInvalidArgument, "device", () => context.GetVulkanPipelineCache());
            CrumpleVulkanImportDef import = CrumpleVulkanImportDef.Default;
            Check.Fails(CrumpleResult.ErrorInvalidArgument, "crumple_vulkan_open", () => context.ImportVulkanBuffer(in import));
            Check.Fails(CrumpleResult.ErrorInvalidArgument, "crumple_vulkan_open", () => context.ReleaseVulkanBuffer(1));
            Check.Fails(CrumpleResult.ErrorInvalidArgument, "crumple_vulkan_open",
                () => context.ImportVulkanSemaphore(CrumpleHandleType.OpaqueFd, 3));
            Check.Fails(CrumpleResult.ErrorInvalidArgument, "crumple_vulkan_open",
                () => context.SubmitDeform(default(ReadOnlySpan<ulong>), default(ReadOnlySpan<ulong>), out _));
            Check.Fails(CrumpleResult.ErrorInvalidArgument, "crumple_vulkan_open", () => context.WaitFrame(1, 0));
        }
    }
}
