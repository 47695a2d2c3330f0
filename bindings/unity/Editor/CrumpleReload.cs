using UnityEditor;

namespace Crumple.Editor
{
    /// <summary>
    /// The editor drops all managed code when scripts are compiled, and keeps native libraries. Everything native of Crumple's
    /// ends before that; components open again afterwards, with their damage.
    /// </summary>
    [InitializeOnLoad]
    internal static class CrumpleReload
    {
        static CrumpleReload()
        {
            AssemblyReloadEvents.beforeAssemblyReload += End;
        }

        private static void End()
        {
            CrumpleWorld.Shutdown();
            CrumpleRuntime.Shutdown(); // contexts of your own code
        }
    }
}
