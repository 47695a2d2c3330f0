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
            DentTests.DamageRoundTrips,
            DentTests.ChangesAndBounds,
            DentTests.ContactsAndSpaces,
            DentTests.ManyAtOnce,
            DentTests.ContactPoints,
            DentTests.TimeAndPoses,
            DentTests.Parts,
            DentTests.TheRest,
            LoadingTests.Gltf,
            LoadingTests.Obj,
            LoadingTests.Baked,
            LoadingTests.Arrays,
            ErrorTests.OfCalls,
            ErrorTests.OfSets,
            ErrorTests.OfVulkan,
            ThreadTests.SameMarksInAnyOrder,
            ThreadTests.TwoInside,
            CallbackTests.Log,
            CallbackTests.ExceptionsStayManaged,
            CallbackTests.Tasks,
            FrameTests.NothingIsAllocated,
            FrameTests.ScenesComeAndGo,
            LifetimeTests.AnyOrder,
            LifetimeTests.OneByOne,
            LifetimeTests.ArraysAreLetGo,
            LifetimeTests.ForgottenThingsGo,
            LifetimeTests.Shutdown,
            DomainTests.UnloadedWithoutDisposing);
    }
}
