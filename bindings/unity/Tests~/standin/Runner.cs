// NUnit and Unity's test tools, as far as the tests use them, and a program that runs all tests.
using System;
using System.Collections;
using System.Collections.Generic;
using System.Reflection;
using System.Text.RegularExpressions;

namespace NUnit.Framework
{
    [AttributeUsage(AttributeTargets.Method)] public sealed class TestAttribute : Attribute { }
    [AttributeUsage(AttributeTargets.Method)] public sealed class SetUpAttribute : Attribute { }
    [AttributeUsage(AttributeTargets.Method)] public sealed class TearDownAttribute : Attribute { }

    public sealed class AssertionException : Exception
    {
        public AssertionException(string message) : base(message) { }
    }

    public delegate void TestDelegate();

    public static class Assert
    {
        public static void Fail(string message) { throw new AssertionException(message); }
        public static void IsTrue(bool condition) { if (!condition) Fail("expected true"); }
        public static void IsNull(object value) { if (value != null) Fail("expected null, got " + value); }
        public static void AreEqual(object expected, object actual) { if (!Equals(expected, actual)) Fail("expected " + expected + ", got " + actual); }

        public static void AreEqual(double expected, double actual, double delta)
        {
            if (!(Math.Abs(expected - actual) <= delta)) Fail("expected " + expected + " within " + delta + ", got " + actual);
        }

        public static T Throws<T>(TestDelegate code) where T : Exception
        {
            try
            {
                code();
            }
            catch (T error)
            {
                return error;
            }
            Fail("expected " + typeof(T));
            return null;
        }
    }
}

namespace UnityEngine
{
    public enum LogType { Error, Assert, Warning, Log, Exception }
}

namespace UnityEngine.TestTools
{
    [AttributeUsage(AttributeTargets.Method)] public sealed class UnityTestAttribute : Attribute { }

    public static class LogAssert
    {
        internal static readonly List<KeyValuePair<string, Regex>> Expected = new List<KeyValuePair<string, Regex>>();

        public static void Expect(LogType type, Regex message)
        {
            Expected.Add(new KeyValuePair<string, Regex>(type.ToString().ToLowerInvariant() + ": ", message));
        }
    }
}

namespace StandIn
{
    using NUnit.Framework;
    using UnityEngine.TestTools;

    public static class Runner
    {
        public static int Run(Assembly tests, Predicate<Type> which)
        {
            int count = 0, failures = 0;
            foreach (Type type in Array.FindAll(tests.GetTypes(), which))
            {
                foreach (MethodInfo method in type.GetMethods())
                {
                    bool plain = Has<TestAttribute>(method), frames = Has<UnityTestAttribute>(method);
                    if (!plain && !frames) continue;
                    count++;
                    string error = Run(type, method);
                    if (error == null) continue;
                    failures++;
                    Console.WriteLine("FAILED " + type.Name + "." + method.Name + ": " + error);
                }
            }
            Console.WriteLine(count + " tests, " + failures + " failures");
            return failures == 0 && count > 0 ? 0 : 1;
        }

        private static bool Has<T>(MethodInfo method) { return method.GetCustomAttributes(typeof(T), false).Length > 0; }

        private static string Run(Type type, MethodInfo method)
        {
            LogAssert.Expected.Clear();
            Engine.Console();
            try
            {
                object tests = Activator.CreateInstance(type);
                foreach (MethodInfo each in type.GetMethods()) if (Has<SetUpAttribute>(each)) each.Invoke(tests, null);
                try
                {
                    IEnumerator steps = method.Invoke(tests, null) as IEnumerator;
                    while (steps != null && steps.MoveNext()) Engine.Frame();
                }
                finally
                {
                    foreach (MethodInfo each in type.GetMethods()) if (Has<TearDownAttribute>(each)) each.Invoke(tests, null);
                }
            }
            catch (Exception error)
            {
                TargetInvocationException wrapped = error as TargetInvocationException;
                return (wrapped == null ? error : wrapped.InnerException).ToString();
            }
            Engine.Sweep();
            if (Unity.Collections.NativeArray<byte>.Living != 0) return Unity.Collections.NativeArray<byte>.Living + " native arrays are left";
            if (Gpu.Living != 0) return Gpu.Living + " vertex buffers are left on the device";
            return Lines();
        }

        // As Unity's runner does: what was expected must come, and no other error or exception may.
        private static string Lines()
        {
            List<string> lines = new List<string>(Engine.Console());
            foreach (KeyValuePair<string, Regex> expected in LogAssert.Expected)
            {
                int found = lines.FindIndex(line => line.StartsWith(expected.Key) && expected.Value.IsMatch(line));
                if (found < 0) return "the console lacks " + expected.Key + expected.Value + "; it has " + string.Join(" | ", lines);
                lines.RemoveAt(found);
            }
            string wrong = lines.Find(line => line.StartsWith("error: ") || line.StartsWith("exception: "));
            return wrong == null ? null : "unexpected on the console: " + wrong;
        }
    }
}
