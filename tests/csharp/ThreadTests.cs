using System;
using System.Collections.Generic;
using System.Linq;
using System.Threading;
using Crumple;

/// <summary>Hits from many threads, and two threads where one is allowed.</summary>
static class ThreadTests
{
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

    /// <summary>Hits may come from any thread, while another deforms. Each thread has an error text of its own.</summary>
    public static void Hits()
    {
        const int threads = 8, hits = 50;
        using (CrumpleContext context = new CrumpleContext(2))
        {
            CrumpleInstanceDef def = CrumpleInstanceDef.Default;
            def.MarkCapacity = 4096; // never reached: no marks merge
            Instance body = context.CreateInstance(context.CreateExampleSet(Sheet.Def()), in def);
            body.RegisterHostBuffer(StridedArray.Of(new CrumpleVec3[Sheet.Vertices]));
            List<Exception> errors = new List<Exception>();
            bool running = true;
            Thread deformer = Start(errors, () =>
            {
                while (Volatile.Read(ref running)) context.Deform();
            });
            List<Thread> all = Enumerable.Range(0, threads).Select(t => Start(errors, () =>
            {
                CrumpleHitDef bad = Sheet.Hit(0, 0, 0.01f);
                if (t % 2 == 0) bad.Point.X = float.NaN;
                else bad.Displacement.X = float.NaN;
                for (int i = 0; i < hits; i++)
                {
                    body.Submit(Sheet.Hit(i * 37 % 101 / 101f - 0.5f, i * 61 % 103 / 103f - 0.5f, 0.005f + 0.0001f * t));
                    Check.Throws<CrumpleException>(() => body.Submit(in bad), t % 2 == 0 ? "point" : "displacement");
                }
            })).ToList();
            foreach (Thread thread in all) thread.Join();
            Volatile.Write(ref running, false);
            deformer.Join();
            if (errors.Count > 0) throw errors[0];
            context.Deform();
            Check.That(body.GetInfo().MarkCount > hits, "there are marks");
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
            body.Submit(Sheet.Hit(0, 0, 0.01f)); // which is allowed
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
