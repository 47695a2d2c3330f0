using System;
using System.Collections.Generic;
using System.Linq;
using System.Threading;
using Crumple;

/// <summary>Hits from many threads, and two threads where one is allowed.</summary>
static class ThreadTests
{
    const int Threads = 8, Hits = 200, Bodies = 3;

    static CrumpleHitDef Hit(int i)
    {
        return Sheet.Hit(i * 37 % 101 / 101f - 0.5f, i * 61 % 103 / 103f - 0.5f, 0.005f + 0.0001f * (i % 300));
    }

    /// <summary>Damage of every body after all hits, in an order that the threads and the shuffle decide.</summary>
    static byte[][] Scene(int threads, bool deform, int seed)
    {
        using (CrumpleContext context = new CrumpleContext(2))
        {
            ExampleSet set = context.CreateExampleSet(Sheet.Def());
            CrumpleInstanceDef def = CrumpleInstanceDef.Default;
            def.MarkCapacity = 4096; // never reached: no merging, so neither order nor moment matters
            Instance[] bodies = Enumerable.Range(0, Bodies).Select(_ => context.CreateInstance(set, in def)).ToArray();
            foreach (Instance body in bodies) body.RegisterHostBuffer(StridedArray.Of(new CrumpleVec3[Sheet.Vertices]));
            Random random = new Random(seed);
            int[] order = Enumerable.Range(0, Threads * Hits).OrderBy(_ => random.Next()).ToArray();
            List<Exception> errors = new List<Exception>();
            bool running = true;
            List<Thread> all = new List<Thread>();
            for (int t = 0; t < threads; t++)
            {
                int first = t;
                all.Add(Start(errors, () =>
                {
                    for (int i = first; i < order.Length; i += threads)
                    {
                        bodies[order[i] % Bodies].Submit(Hit(order[i]));
                        if (i % 50 != 0) continue;
                        // Each thread has an error text of its own.
                        string part = i % 100 == 0 ? "point" : "displacement";
                        CrumpleHitDef bad = Hit(i);
                        if (i % 100 == 0) bad.Point.X = float.NaN;
                        else bad.Displacement.X = float.NaN;
                        Check.Throws<CrumpleException>(() => bodies[0].Submit(in bad), part);
                    }
                }));
            }
            Thread deformer = deform ? Start(errors, () =>
            {
                while (Volatile.Read(ref running)) context.Deform();
            }) : null;
            foreach (Thread thread in all) thread.Join();
            Volatile.Write(ref running, false);
            if (deform) deformer.Join();
            if (errors.Count > 0) throw errors[0];
            context.Deform();
            return bodies.Select(body => body.SaveDamage()).ToArray();
        }
    }

    static Thread Start(List<Exception> errors, Action action)
    {
        Thread thread = new Thread(() =>
        {
            try
            {
                action();
            }
            catch (Exception error)
            {
                lock (errors) errors.Add(error);
            }
        });
        thread.Start();
        return thread;
    }

    public static void SameMarksInAnyOrder()
    {
        byte[][] expected = Scene(1, false, 1);
        Check.That(expected.Sum(bytes => bytes.Length) > Threads * Hits * 30, "there are marks");
        for (int round = 0; round < 3; round++)
        {
            byte[][] found = Scene(Threads, round > 0, 2 + round);
            for (int b = 0; b < Bodies; b++) Check.That(expected[b].SequenceEqual(found[b]), "body " + b + " is the same bit for bit");
        }
    }

    /// <summary>While a call is held up, everybody else is told so, but hits are taken.</summary>
    public static void TwoInside()
    {
        using (ManualResetEventSlim inside = new ManualResetEventSlim(), leave = new ManualResetEventSlim())
        {
            bool hold = false;
            CrumpleContext context = new CrumpleContext(2, (level, message) =>
            {
                if (!hold) return;
                hold = false;
                inside.Set();
                leave.Wait();
            });
            Instance body = context.CreateInstance(context.CreateExampleSet(Sheet.Def()));
            HostBuffer buffer = body.RegisterHostBuffer(StridedArray.Of(new CrumpleVec3[Sheet.Vertices]));
            hold = true;
            List<Exception> errors = new List<Exception>();
            Thread loader = Start(errors, () => context.CreateExampleSet(Sheet.Def()));
            inside.Wait();
            Check.Fails(CrumpleResult.ErrorConcurrentUse, "another thread", () => context.Deform());
            Check.Fails(CrumpleResult.ErrorConcurrentUse, "another thread", () => body.GetInfo());
            Check.Fails(CrumpleResult.ErrorConcurrentUse, "another thread", () => context.Dispose());
            Check.Fails(CrumpleResult.ErrorConcurrentUse, "another thread", () => body.Dispose());
            Check.Fails(CrumpleResult.ErrorConcurrentUse, "another thread", () => buffer.Dispose());
            body.Submit(Hit(1)); // which is allowed
            leave.Set();
            loader.Join();
            Check.Same(0, errors.Count, "errors of the other thread");
            Check.Same(1u, body.GetInfo().MarkCount, "marks");
            context.Dispose();
            Check.Same(null, context.LastLogException, "exceptions in the handler");
        }
    }

    /// <summary>Messages arrive on the caller's thread. What a handler throws stays in it, and can be asked for; the call goes on.</summary>
    public static void Log()
    {
        List<string> said = new List<string>();
        int thread = Thread.CurrentThread.ManagedThreadId;
        CrumpleContext context = null;
        using (context = new CrumpleContext(2, (level, message) =>
        {
            Check.Same(thread, Thread.CurrentThread.ManagedThreadId, "thread");
            said.Add(level + ": " + message);
            // It is not allowed in: that is an exception too, and not a deadlock.
            Check.Fails(CrumpleResult.ErrorConcurrentUse, "callback", () => context.Deform());
            throw new InvalidOperationException("thrown by a log handler");
        }))
        {
            ExampleSetDef def = Sheet.Def();
            def.Examples.Add(new ExampleDef { Name = "nothing ü", TargetPositions = StridedArray.Of(Sheet.Points()) });
            GC.Collect(); // moves what it can; the callback is still found
            context.CreateExampleSet(def);
            Check.That(said.Any(line => line == "Warning: example 'nothing ü' moves no vertex"), string.Join("; ", said));
            Check.Same("thrown by a log handler", context.LastLogException.Message, "kept");
        }
    }
}
