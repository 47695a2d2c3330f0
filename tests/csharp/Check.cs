using System;
using System.Diagnostics;

/// <summary>Facts that could fail, and a runner that names the one which did.</summary>
static class Check
{
    public static int Count;

    public static void That(bool fact, string text)
    {
        Count++;
        if (!fact) throw new Exception("not so: " + text);
    }

    public static void Same<T>(T expected, T found, string what)
    {
        Count++;
        if (!Equals(expected, found)) throw new Exception(what + ": expected " + expected + ", found " + found);
    }

    public static void Near(float expected, float found, float off, string what)
    {
        Count++;
        if (!(Math.Abs(expected - found) <= off)) throw new Exception(what + ": expected " + expected + ", found " + found);
    }

    public static T Throws<T>(Action action, string part = "") where T : Exception
    {
        Count++;
        try
        {
            action();
        }
        catch (T error)
        {
            if (!error.Message.Contains(part)) throw new Exception("expected ..." + part + "..., found: " + error.Message);
            return error;
        }
        throw new Exception("expected " + typeof(T).Name + " with ..." + part + "..., but nothing was thrown");
    }

    /// <summary>The action throws a CrumpleException with this result and a text that has this in it.</summary>
    public static void Fails(Crumple.CrumpleResult result, string part, Action action)
    {
        Crumple.CrumpleException error = Throws<Crumple.CrumpleException>(action, part);
        Same(result, error.Result, error.Message);
        That(error.Message.StartsWith("crumple_", StringComparison.Ordinal), error.Message + " names the function");
    }

    /// <summary>Runs the tests in order; the exit status of the program.</summary>
    public static int Run(params Action[] tests)
    {
        int failed = 0;
        foreach (Action test in tests)
        {
            string name = test.Method.DeclaringType.Name + "." + test.Method.Name;
            Stopwatch watch = Stopwatch.StartNew();
            int before = Count;
            try
            {
                test();
            }
            catch (Exception error)
            {
                Console.WriteLine("FAILED  " + name + ": " + error);
                failed++;
                continue;
            }
            Console.WriteLine("ok  {0}: {1} checks, {2} ms", name, Count - before, watch.ElapsedMilliseconds);
        }
        Console.WriteLine("{0} checks, {1} of {2} tests failed", Count, failed, tests.Length);
        return failed == 0 ? 0 : 1;
    }
}
