using System;
using Crumple.Native;

namespace Crumple
{
    public sealed partial class CrumpleContext
    {
        /// <summary>
        /// Begins to write what is called to a file, from which "crumple replay FILE" makes the same calls again and compares what
        /// they give: how a bug becomes a test. The file first gets what there is: sets, instances and their damage, buffers. It is
        /// written call by call, so that a crash loses nothing. Leave it off in what you ship.
        /// </summary>
        /// <exception cref="CrumpleException">
        /// The file cannot be written, a recording runs already, or an instance has open contacts. Nothing is recorded then.
        /// </exception>
        public unsafe void BeginRecording(string path)
        {
            if (path == null) throw new ArgumentNullException("path");
            using (Pins pins = new Pins())
            using (Call call = EnterAlone(this))
                call.Check(NativeMethods.crumple_recording_begin(call.Context, pins.Text(path)), "crumple_recording_begin");
        }

        /// <summary>Ends the recording, as <see cref="Dispose"/> does.</summary>
        /// <exception cref="CrumpleException">No recording runs, or the file could not be written to its end.</exception>
        public void EndRecording()
        {
            using (Call call = EnterAlone(this))
                call.Check(NativeMethods.crumple_recording_end(call.Context), "crumple_recording_end");
        }
    }
}
