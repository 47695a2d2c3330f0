using System;
using StandIn;

namespace Crumple.Tests
{
    /// <summary>Crumple.Tests.exe cpu, or gpu and the plugin's file.</summary>
    public static class Program
    {
        public static int Main(string[] arguments)
        {
            if (arguments[0] == "cpu") return Runner.Run(typeof(Program).Assembly, type => type != typeof(GpuTests));
            Gpu.Open(arguments[1]);
            int result = Runner.Run(typeof(Program).Assembly, type => type == typeof(GpuTests));
            Gpu.Close();
            return result;
        }
    }
}
