using System;
using System.Collections.Generic;
using System.Linq;
using System.Threading;
using Crumple;

/// <summary>Handlers that native code calls.</summary>
static class CallbackTests
{
    public static void Log()
    {
        List<string> said = new List<string>();
        int thread = Thread.CurrentThread.ManagedThreadId;
        ContextOptions options = new ContextOptions
        {
            Log = (level, message) =>
            {
                Check.Same(thread, Thread.CurrentThread.ManagedThreadId, "thread");
                said.Add(level + ": " + message);
            },
        };
        using (CrumpleContext context = new CrumpleContext(options))
        {
            ExampleSetDef def = Sheet.Def();
            def.Examples.Add(new ExampleDef { Name = "nothing ü", TargetPositions = StridedArray.Of(Sheet.Points()) });
            context.CreateExampleSet(def);
            Check.That(said.Any(line => line == "Warning: example 'nothing ü' moves no vertex"), string.Join("; ", said));
            Check.That(said.Any(line => line.StartsWith("Info: ")), string.Join("; ", said));
            // A collection between calls moves what it can; the callback is still found.
            GC.Collect();
            said.Clear();
            context.CreateExampleSet(def);
            Check.That(said.Count > 1, "after a collection");
            Check.Same(null, context.LastCallbackException, "exceptions");
        }
    }

    /// <summary>What a handler throws stays in the handler, and can be asked for; the call goes on.</summary>
    public static void ExceptionsStayManaged()
    {
        CrumpleContext context = null;
        Exception inner = null;
        ContextOptions options = new ContextOptions
        {
            Log = (level, message) =>
            {
                // It is not allowed in: that is an exception too, and not a deadlock.
                inner = inner ?? Check.Throws<CrumpleException>(() => context.Deform(), "callback");
                throw new InvalidOperationException("thrown by a log handler");
            },
            Tasks = tasks => { throw new InvalidOperationException("thrown by a task handler"); },
            TaskWorkers = 4,
        };
        using (context = new CrumpleContext(options))
        {
            ExampleSet set = context.CreateExampleSet(Sheet.Def());
            Check.Same(CrumpleResult.ErrorConcurrentUse, ((CrumpleException)inner).Result, "callback into the context");
            Check.Same("thrown by a log handler", context.LastCallbackException.Message, "kept");
            CrumpleVec3[] vertices = new CrumpleVec3[Sheet.Vertices];
            Instance body = context.CreateInstance(set);
            body.RegisterHostBuffer(StridedArray.Of(vertices));
            body.Submit(Sheet.Hit(0, 0, 0.04f));
            context.Deform();
            Check.Same("thrown by a task handler", context.LastCallbackException.Message, "kept");
            Check.Near(0.04f, Sheet.Deepest(vertices), 5e-4f, "Crumple does what the handler forgot");
        }
    }

    /// <summary>The host's own threads give the vertices of Crumple's own.</summary>
    public static void Tasks()
    {
        int ran = 0;
        CrumpleVec3[][] seen = new CrumpleVec3[2][];
        for (int own = 0; own < 2; own++)
        {
            ContextOptions options = new ContextOptions { TaskWorkers = 4 };
            if (own == 0)
            {
                options.Tasks = tasks =>
                {
                    using (CountdownEvent left = new CountdownEvent(tasks.Count))
                    {
                        for (int i = 0; i < tasks.Count; i++)
                        {
                            int index = i;
                            ThreadPool.QueueUserWorkItem(_ =>
                            {
                                tasks.Run(index);
                                Interlocked.Increment(ref ran);
                                left.Signal();
                            });
                        }
                        left.Wait();
                    }
                    Check.Throws<ArgumentOutOfRangeException>(() => tasks.Run(tasks.Count));
                };
            }
            using (CrumpleContext context = new CrumpleContext(options))
            {
                Instance body = context.CreateInstance(context.CreateExampleSet(Sheet.Def()));
                seen[own] = new CrumpleVec3[Sheet.Vertices];
                body.RegisterHostBuffer(StridedArray.Of(seen[own]));
                body.Submit(Sheet.Hit(0.1f, 0.1f, 0.04f));
                context.Deform();
                Check.Same(null, context.LastCallbackException, "exceptions");
            }
        }
        Check.That(ran > 1, ran + " tasks ran on the pool");
        Check.That(seen[0].SequenceEqual(seen[1]), "the same vertices");
    }
}
