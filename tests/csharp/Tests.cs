using System;
using System.Linq;
using System.Reflection;

/// <summary>
/// Everything that needs the library alone: all public methods without parameters of classes whose names end with Tests. Arguments:
/// folder of fixtures, table of layouts.
/// </summary>
static class Tests
{
    static int Main(string[] arguments)
    {
        LoadingTests.Fixtures = arguments[0];
        LayoutTests.Table = arguments[1];
        const BindingFlags own = BindingFlags.Static | BindingFlags.Public | BindingFlags.DeclaredOnly;
        var tests = from type in typeof(Tests).Assembly.GetTypes()
                    where type.Name.EndsWith("Tests", StringComparison.Ordinal)
                    from method in type.GetMethods(own)
                    where method.GetParameters().Length == 0
                    select (Action)Delegate.CreateDelegate(typeof(Action), method);
        return Check.Run(tests.ToArray());
    }
}
