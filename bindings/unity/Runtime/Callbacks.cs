using System;
using System.Runtime.InteropServices;

namespace Crumple.Native
{
    /// <summary>
    /// Marks a static method that native code calls: ahead-of-time compilers (IL2CPP) look for an attribute of this name. The
    /// engine's own cannot be used here, since these files need no engine.
    /// </summary>
    [AttributeUsage(AttributeTargets.Method)]
    internal sealed class MonoPInvokeCallbackAttribute : Attribute
    {
        public MonoPInvokeCallbackAttribute(Type type)
        {
        }
    }
}

namespace Crumple
{
    /// <summary>
    /// Receives one message. Called on the thread that called Crumple, during that call: it must not use the same context.
    /// </summary>
    public delegate void CrumpleLogHandler(CrumpleLogLevel level, string message);

    /// <summary>
    /// Runs tasks of a context on threads of yours: call <see cref="CrumpleTasks.Run"/> once for every index below
    /// <see cref="CrumpleTasks.Count"/>, on any threads and in any order, and return when all have returned. What is forgotten is
    /// run afterwards by Crumple. It must not use the same context, except to submit hits.
    /// </summary>
    public delegate void CrumpleTaskHandler(CrumpleTasks tasks);

    /// <summary>Tasks to be run; valid until the handler that received them returns.</summary>
    public readonly struct CrumpleTasks
    {
        private readonly CrumpleTask task;
        private readonly IntPtr data;

        internal CrumpleTasks(uint count, CrumpleTask task, IntPtr data)
        {
            Count = (int)count;
            this.task = task;
            this.data = data;
        }

        /// <summary>Number of tasks.</summary>
        public int Count { get; }

        /// <summary>
        /// Runs a task; index is 0 to Count - 1. Any thread, several at once. Never throws for an index in range.
        /// </summary>
        public void Run(int index)
        {
            if (index < 0 || index >= Count)
                throw new ArgumentOutOfRangeException("index", index, "there are " + Count + " tasks");
            task((uint)index, data);
        }
    }

    /// <summary>
    /// What native code finds by a context's user pointer. It knows nothing of the context, so that forgetting a context is
    /// enough to end it. No exception leaves it: native frames lie below.
    /// </summary>
    internal sealed class CallbackSink
    {
        // Kept for ever: native code holds their addresses.
        private static readonly CrumpleLog LogThunk = OnLog;
        private static readonly CrumpleParallelFor ParallelForThunk = OnParallelFor;

        /// <summary>The library's task function, of which there is one: a delegate for each call would be garbage.</summary>
        private static volatile TaskFunction known;

        private readonly CrumpleLogHandler log;
        private readonly CrumpleTaskHandler tasks;
        private readonly int workers;

        /// <summary>What a handler threw last.</summary>
        internal volatile Exception Failure;

        internal CallbackSink(ContextOptions options)
        {
            log = options.Log;
            tasks = options.Tasks;
            workers = options.TaskWorkers;
        }

        internal void Fill(ref CrumpleContextDef def, IntPtr user)
        {
            if (log != null)
            {
                def.Log = Marshal.GetFunctionPointerForDelegate(LogThunk);
                def.LogUser = user;
            }
            if (tasks != null)
            {
                def.Tasks.ParallelFor = Marshal.GetFunctionPointerForDelegate(ParallelForThunk);
                def.Tasks.User = user;
                def.Tasks.Workers = (uint)workers;
            }
        }

        [Native.MonoPInvokeCallback(typeof(CrumpleLog))]
        private static void OnLog(CrumpleLogLevel level, IntPtr message, IntPtr user)
        {
            CallbackSink sink = null;
            try
            {
                sink = (CallbackSink)GCHandle.FromIntPtr(user).Target;
                sink.log(level, Utf8.Text(message));
            }
            catch (Exception error)
            {
                if (sink != null) sink.Failure = error;
            }
        }

        [Native.MonoPInvokeCallback(typeof(CrumpleParallelFor))]
        private static void OnParallelFor(uint count, IntPtr task, IntPtr taskData, IntPtr user)
        {
            CallbackSink sink = null;
            try
            {
                sink = (CallbackSink)GCHandle.FromIntPtr(user).Target;
                TaskFunction function = known;
                if (function == null || function.Address != task) known = function = new TaskFunction(task);
                sink.tasks(new CrumpleTasks(count, function.Call, taskData));
            }
            catch (Exception error)
            {
                if (sink != null) sink.Failure = error;
            }
        }

        private sealed class TaskFunction
        {
            internal readonly IntPtr Address;
            internal readonly CrumpleTask Call;

            internal TaskFunction(IntPtr address)
            {
                Address = address;
                Call = (CrumpleTask)Marshal.GetDelegateForFunctionPointer(address, typeof(CrumpleTask));
            }
        }
    }
}
