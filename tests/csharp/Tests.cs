using System;

/// <summary>Everything that needs the library alone. Arguments: folder of fixtures, table of layouts.</summary>
static class Tests
{
    static int Main(string[] arguments)
    {
        LoadingTests.Fixtures = arguments[0];
        LayoutTests.Table = arguments[1];
        return Check.Run(
            LayoutTests.SizesAndOffsets,
            LayoutTests.Defaults,
            LayoutTests.EveryFunctionIsExported,
            LoadingTests.Files,
            LoadingTests.Arrays,
            DentTests.HitToVertices,
            DentTests.SpacesAndMeshes,
            DentTests.ContactPoints,
            DentTests.Errors,
            ThreadTests.Hits,
            ThreadTests.TwoInside,
            ThreadTests.Log,
            FrameTests.NothingIsAllocated,
            FrameTests.ScenesComeAndGo,
            LifetimeTests.AnyOrder,
            LifetimeTests.OneByOne,
            LifetimeTests.ArraysAreLetGo,
            LifetimeTests.AForgottenContextGoes,
            LifetimeTests.Shutdown,
            DomainTests.UnloadedWithoutDisposing);
    }
}
