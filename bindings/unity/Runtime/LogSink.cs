using System;
using System.Runtime.InteropServices;

namespace Crumple
{
    /// <summary>
    /// Receives one message. Called on the thread that called Crumple, during that call: it must not use the same context.
    /// </summary>
    public delegate void CrumpleLogHandler(CrumpleLogLevel level, string message);

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

    /// <summary>
    /// What native code finds by a context's user pointer. It knows nothing of the context, so that forgetting a context is
    /// enough to end it. No exception leaves it: native frames lie below.
    /// </summary>
    internal sealed class LogSink
    {
        // Kept for ever: native code holds its address.
        private static readonly CrumpleLog Thunk = OnLog;

        private readonly CrumpleLogHandler log;

        /// <summary>What the handler threw last.</summary>
        internal volatile Exception Failure;

        internal LogSink(CrumpleLogHandler log)
        {
            this.log = log;
        }

        internal void Fill(ref CrumpleContextDef def, IntPtr user)
        {
            def.Log = Marshal.GetFunctionPointerForDelegate(Thunk);
            def.LogUser = user;
        }

        [MonoPInvokeCallback(typeof(CrumpleLog))]
        private static void OnLog(CrumpleLogLevel level, IntPtr message, IntPtr user)
        {
            LogSink sink = null;
            try
            {
                sink = (LogSink)GCHandle.FromIntPtr(user).Target;
                sink.log(level, Utf8.Text(message));
            }
            catch (Exception error)
            {
                if (sink != null) sink.Failure = error;
            }
        }
    }
}
