using System;
using Crumple.Native;

namespace Crumple
{
    public sealed partial class CrumpleContext
    {
        /// <summary>
        /// Begins to write what is called with this context to a new file, so that it can be played again without your engine:
        /// "crumple replay FILE" makes the same calls and compares. It grows by some hundred bytes a hit and a frame, written at once,
        /// so that a crash loses nothing. End open contacts before. Hits wait for each other meanwhile: for when a bug is looked for.
        /// </summary>
        public void BeginRecording(string path)
        {
            if (path == null) throw new ArgumentNullException("path");
            using (Pins pins = new Pins())
            using (Call call = EnterAlone(this))
                call.Check(NativeMethods.crumple_recording_begin(call.Context, pins.Text(path)), "crumple_recording_begin");
        }

        /// <summary>Ends a recording: the file is whole. The end of the context does so too.</summary>
        public void EndRecording()
        {
            using (Call call = EnterAlone(this))
                call.Check(NativeMethods.crumple_recording_end(call.Context), "crumple_recording_end");
        }
    }
}
