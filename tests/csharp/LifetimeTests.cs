using System;
using System.Collections.Generic;
using System.Runtime.CompilerServices;
using System.Threading;
using Crumple;
using Crumple.Native;

/// <summary>What is disposed of, in which order, and what becomes of what is forgotten.</summary>
static class LifetimeTests
{
    sealed class Scene
    {
        public CrumpleContext Context = new CrumpleContext(1);
        public ExampleSet Set;
        public Instance Body;
        public HostBuffer Buffer;
        public WeakReference Memory;

        public Scene()
        {
            Set = Context.CreateExampleSet(Sheet.Def());
            Body = Context.CreateInstance(Set);
            Register();
        }

        [MethodImpl(MethodImplOptions.NoInlining)]
        void Register()
        {
            CrumpleVec3[] vertices = new CrumpleVec3[Sheet.Vertices];
            Memory = new WeakReference(vertices);
            Buffer = Body.RegisterHostBuffer(StridedArray.Of(vertices));
        }
    }

    /// <summary>All 24 orders, each twice; afterwards everything says what it is.</summary>
    public static void AnyOrder()
    {
        for (int order = 0; order < 24; order++)
        {
            Scene scene = new Scene();
            IntPtr native = scene.Context.Pointer;
            IDisposable[] all = { scene.Context, scene.Set, scene.Body, scene.Buffer };
            for (int left = 4, code = order; left > 0; code /= left, left--)
            {
                int which = code % left;
                all[which].Dispose();
                all[which].Dispose();
                all[which] = all[left - 1];
            }
            Check.Throws<ObjectDisposedException>(() => scene.Context.Deform(), "CrumpleContext");
            Check.Throws<ObjectDisposedException>(() => scene.Context.CreateInstance(scene.Set));
            Check.Throws<ObjectDisposedException>(() => scene.Set.GetInfo());
            Check.Throws<ObjectDisposedException>(() => scene.Body.Submit(Sheet.Hit(0, 0, 0.1f)));
            Check.Throws<ObjectDisposedException>(() => scene.Buffer.Id.ToString());
            Check.Throws<ObjectDisposedException>(() => scene.Context.Pointer.ToString());
            Check.That(scene.Context.IsDisposed, "disposed");
            Check.Same(CrumpleResult.ErrorInvalidId, NativeMethods.crumple_context_destroy(native), "the library's context is gone");
        }
    }

    public static void OneByOne()
    {
        Scene scene = new Scene();
        scene.Set.Dispose();
        Check.Throws<ObjectDisposedException>(() => scene.Context.CreateInstance(scene.Set), "ExampleSet");
        scene.Body.Submit(Sheet.Hit(0, 0, 0.03f)); // which keeps what it needs of its set
        scene.Buffer.Dispose();
        Check.Same(0u, scene.Body.GetInfo().BufferCount, "buffers");
        HostBuffer second = scene.Body.RegisterHostBuffer(StridedArray.Of(new CrumpleVec3[Sheet.Vertices]));
        scene.Body.Dispose();
        Check.Throws<ObjectDisposedException>(() => second.Id.ToString(), "HostBuffer");
        Check.Throws<ObjectDisposedException>(() => scene.Body.GetInfo(), "Instance");
        scene.Context.Deform(); // the context goes on
        scene.Context.Dispose();
    }

    /// <summary>Whether an array can be collected, once it is nobody's.</summary>
    static bool Collected(WeakReference memory)
    {
        // The stack is scanned conservatively: what lies there may be held by chance for a while.
        for (int i = 0; i < 50 && memory.IsAlive; i++)
        {
            Scrub(40);
            GC.Collect();
            GC.WaitForPendingFinalizers();
        }
        return !memory.IsAlive;
    }

    [MethodImpl(MethodImplOptions.NoInlining)]
    static unsafe int Scrub(int depth)
    {
        byte* zeros = stackalloc byte[512];
        for (int i = 0; i < 512; i++) zeros[i] = 0;
        return depth == 0 ? zeros[5] : Scrub(depth - 1) + zeros[7];
    }

    /// <summary>Registered arrays stay where they are as long as they are written, and are let go after that.</summary>
    public static void ArraysAreLetGo()
    {
        Func<Scene, IDisposable>[] ends = { scene => scene.Buffer, scene => scene.Body, scene => scene.Context };
        foreach (Func<Scene, IDisposable> end in ends) Check.That(Collected(Ended(end)), "let go");
        Scene held = new Scene();
        GC.Collect();
        Check.That(held.Memory.IsAlive, "held while it is registered");
        held.Context.Deform();
        Check.Near(0, Sheet.Deepest((CrumpleVec3[])held.Memory.Target), 1e-6f, "written");
        held.Context.Dispose();
    }

    [MethodImpl(MethodImplOptions.NoInlining)]
    static WeakReference Ended(Func<Scene, IDisposable> end)
    {
        Scene scene = new Scene();
        end(scene).Dispose();
        Kept.Add(scene.Context); // the rest of the scene stays: what was ended must have been enough
        return scene.Memory;
    }

    static readonly List<CrumpleContext> Kept = new List<CrumpleContext>();

    /// <summary>A context that nobody disposes of is destroyed by the collector, with everything in it.</summary>
    public static void AForgottenContextGoes()
    {
        // On a stack of its own, which the collector has no reason to scan afterwards.
        WeakReference context = null;
        Thread thread = new Thread(() => context = Forget());
        thread.Start();
        thread.Join();
        Check.That(Collected(context), "the arrays of a forgotten context");
    }

    [MethodImpl(MethodImplOptions.NoInlining)]
    static WeakReference Forget()
    {
        return new Scene().Memory;
    }

    /// <summary>Shutdown ends all contexts, and new ones work.</summary>
    public static void Shutdown()
    {
        Scene one = new Scene(), two = new Scene();
        two.Context.Dispose();
        Check.Same(0, CrumpleRuntime.Shutdown(), "left behind");
        Check.Throws<ObjectDisposedException>(() => one.Context.Deform(), "CrumpleContext");
        one.Buffer.Dispose();
        one.Body.Dispose();
        one.Context.Dispose();
        Check.Same(0, CrumpleRuntime.Shutdown(), "again");
        Scene three = new Scene();
        three.Context.Deform();
        three.Context.Dispose();
    }
}
