using System;
using Crumple;
using Crumple.Native;

/// <summary>Application domains that come and go over one native library, as at every script reload of Unity's editor.</summary>
static class DomainTests
{
    /// <summary>Lives in this domain, and is told by the other what it saw last.</summary>
    public sealed class Witness : MarshalByRefObject
    {
        public string Saw = "nothing";

        public override object InitializeLifetimeService()
        {
            return null;
        }
    }

    /// <summary>Lives in the other domain.</summary>
    public sealed class Guest : MarshalByRefObject
    {
        CrumpleContext context;
        Instance body;
        CrumpleVec3[] vertices;
        int messages;

        /// <summary>
        /// Makes contexts with callbacks and pinned arrays, disposes of nothing, and tells a context's address.
        /// </summary>
        public long[] Work(bool shutdown, Witness witness)
        {
            // One that is reachable and one that only its finalizer knows of.
            CrumpleContext forgotten = new CrumpleContext(1, (level, message) => messages++);
            context = new CrumpleContext(1, (level, message) => messages++);
            body = context.CreateInstance(context.CreateExampleSet(Sheet.Def()));
            vertices = new CrumpleVec3[Sheet.Vertices];
            body.RegisterHostBuffer(StridedArray.Of(vertices));
            body.Submit(Sheet.Hit(0, 0, 0.03f));
            context.Deform();
            Check.Near(0.03f, Sheet.Deepest(vertices), 5e-4f, "in the other domain");
            Check.That(messages > 0, "messages in the other domain");
            long[] addresses = { forgotten.Pointer.ToInt64(), context.Pointer.ToInt64() };
            // Handlers run in their order: Crumple's has run when this one does, before any finalizer.
            AppDomain.CurrentDomain.DomainUnload += (sender, arguments) => witness.Saw = context.IsDisposed ? "an ended context" : "a live context";
            if (shutdown) Check.Same(0, CrumpleRuntime.Shutdown(), "left behind in the other domain");
            return addresses;
        }

        public override object InitializeLifetimeService()
        {
            return null;
        }
    }

    public static void UnloadedWithoutDisposing()
    {
        using (CrumpleContext context = new CrumpleContext(2))
        {
            ExampleSet set = context.CreateExampleSet(Sheet.Def());
            CrumpleVec3[] vertices = new CrumpleVec3[Sheet.Vertices];
            Instance body = context.CreateInstance(set);
            body.RegisterHostBuffer(StridedArray.Of(vertices));
            for (int round = 0; round < 2; round++)
            {
                AppDomain domain = AppDomain.CreateDomain("scripts " + round);
                Guest guest = (Guest)domain.CreateInstanceAndUnwrap(typeof(Guest).Assembly.FullName, typeof(Guest).FullName);
                Witness witness = new Witness();
                long[] addresses = guest.Work(round % 2 == 1, witness);
                AppDomain.Unload(domain);
                Check.Same("an ended context", witness.Saw, "at the end of the domain");
                foreach (long address in addresses)
                {
                    // The library knows: the context is no more.
                    Check.Same(CrumpleResult.ErrorInvalidId, NativeMethods.crumple_context_destroy(new IntPtr(address)), "a context of the unloaded domain");
                }
                GC.Collect();
                // Nothing of this domain was touched.
                body.Submit(Sheet.Hit(0.1f * round - 0.2f, 0, 0.03f));
                context.Deform();
                Check.Same(round + 1u, body.GetInfo().MarkCount, "marks");
                Check.That(Sheet.Deepest(vertices) > 0.028f, "dented");
            }
        }
    }
}
