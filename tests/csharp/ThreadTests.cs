using System;
using System.Collections.Generic;
using System.Linq;
using System.Threading;
using System.Threading.Tasks;
using Crumple;

/// <summary>Two threads where one is allowed, and messages.</summary>
static class ThreadTests
{
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
            ExampleSet set = context.CreateExampleSet(Sheet.Def());
            Instance body = context.CreateInstance(set);
            HostBuffer buffer = body.RegisterHostBuffer(StridedArray.Of(new CrumpleVec3[Sheet.Vertices]));
            hold = true;
            Task loader = Task.Run(() => context.CreateExampleSet(Sheet.Def()));
            inside.Wait();
            foreach (Action call in new Action[] { () => context.Deform(), () => body.GetInfo(), context.Dispose, set.Dispose, body.Dispose, buffer.Dispose })
                Check.Fails(CrumpleResult.ErrorConcurrentUse, "another thread", call);
            body.Submit(Sheet.Hit(0, 0, 0.01f)); // which is allowed
            leave.Set();
            loader.Wait();
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
