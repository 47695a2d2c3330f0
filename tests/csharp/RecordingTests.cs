using System.IO;
using System.Text;
using Crumple;

/// <summary>Calls written to a file; that they can be played again is tested with the C functions.</summary>
static class RecordingTests
{
    public static void BeginAndEnd()
    {
        string file = Path.Combine(Path.GetTempPath(), Path.GetRandomFileName() + ".crumplerec");
        try
        {
            using (CrumpleContext context = Sheet.Context())
            {
                Check.Fails(CrumpleResult.ErrorInvalidArgument, "no recording runs", context.EndRecording);
                Check.Fails(CrumpleResult.ErrorIo, "no-such-folder", () => context.BeginRecording("no-such-folder/file"));
                Instance body = context.CreateInstance(context.CreateExampleSet(Sheet.Def()));
                context.BeginRecording(file);
                Check.Fails(CrumpleResult.ErrorInvalidArgument, "runs already", () => context.BeginRecording(file));
                long before = new FileInfo(file).Length;
                body.SubmitDisplacement(Sheet.Hit(0, 0, 0.02f));
                Check.That(new FileInfo(file).Length > before, "a call is in the file when it returns");
                context.EndRecording();
            }
            byte[] bytes = File.ReadAllBytes(file);
            Check.Same("CRUMPREC", Encoding.ASCII.GetString(bytes, 0, 8), "the file's first bytes");
        }
        finally
        {
            File.Delete(file);
        }
    }
}
