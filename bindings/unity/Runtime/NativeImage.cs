using System;
using System.IO;

namespace Crumple
{
    internal static class Platform
    {
        internal static readonly bool Windows = Path.DirectorySeparatorChar == '\\';
        internal static readonly bool Mac = !Windows && Directory.Exists("/System/Library/CoreServices");
        internal static readonly bool Linux = !Windows && !Mac;
    }

    /// <summary>Which system and processor a library is for, such as "x86-64 ELF", from the first bytes of its file.</summary>
    internal static class NativeImage
    {
        /// <summary>What files are that are no libraries.</summary>
        internal const string None = "no native library";

        /// <summary>Null where the file cannot be read.</summary>
        internal static string OfFile(string file)
        {
            byte[] bytes = new byte[1024];
            try
            {
                using (FileStream stream = new FileStream(file, FileMode.Open, FileAccess.Read, FileShare.ReadWrite))
                    Array.Resize(ref bytes, stream.Read(bytes, 0, bytes.Length));
            }
            catch (IOException)
            {
                return null;
            }
            catch (UnauthorizedAccessException)
            {
                return null;
            }
            return OfBytes(bytes);
        }

        internal static string OfBytes(byte[] bytes)
        {
            if (Begins(bytes, 0x7F, (byte)'E', (byte)'L', (byte)'F') && bytes.Length >= 20)
                return Elf(Number(bytes, 18, 2, bytes[5] == 2)) + " ELF";
            // Thin Mach-O, little-endian; one for several processors begins with CAFEBABE.
            if (Begins(bytes, 0xCF, 0xFA, 0xED, 0xFE) && bytes.Length >= 8) return Mach(Number(bytes, 4, 4, false)) + " Mach-O";
            if (Begins(bytes, 0xCA, 0xFE, 0xBA, 0xBE) && bytes.Length >= 8) return Universal(bytes);
            if (Begins(bytes, (byte)'M', (byte)'Z') && bytes.Length >= 64)
            {
                uint header = Number(bytes, 60, 4, false);
                if (header + 6 <= bytes.Length && bytes[header] == 'P' && bytes[header + 1] == 'E')
                    return Pe(Number(bytes, (int)header + 4, 2, false)) + " PE";
            }
            return None;
        }

        /// <summary>What a library for this process would be.</summary>
        internal static string OfThisProcess()
        {
            if (Platform.Linux)
            {
                // The running program itself: what it is, its libraries must be.
                string own = OfFile("/proc/self/exe");
                if (own != null) return own;
            }
            string format = Platform.Windows ? " PE" : Platform.Mac ? " Mach-O" : " ELF";
            bool arm = (Environment.GetEnvironmentVariable("PROCESSOR_ARCHITECTURE") ?? "").StartsWith("ARM", StringComparison.Ordinal);
            if (Platform.Mac) arm = Directory.Exists("/opt/homebrew") || File.Exists("/usr/libexec/rosetta/oahd");
            return (IntPtr.Size == 4 ? "x86" : arm ? "ARM64" : "x86-64") + format;
        }

        private static bool Begins(byte[] bytes, params byte[] with)
        {
            if (bytes.Length < with.Length) return false;
            for (int i = 0; i < with.Length; i++)
                if (bytes[i] != with[i]) return false;
            return true;
        }

        private static uint Number(byte[] bytes, int at, int count, bool bigEndian)
        {
            uint number = 0;
            for (int i = 0; i < count; i++) number |= (uint)bytes[at + i] << 8 * (bigEndian ? count - 1 - i : i);
            return number;
        }

        private static string Elf(uint machine)
        {
            switch (machine)
            {
                case 3: return "x86";
                case 40: return "ARM";
                case 62: return "x86-64";
                case 183: return "ARM64";
                case 243: return "RISC-V";
                default: return "machine " + machine;
            }
        }

        private static string Mach(uint cpu)
        {
            switch (cpu)
            {
                case 0x01000007: return "x86-64";
                case 0x0100000C: return "ARM64";
                default: return "processor " + cpu;
            }
        }

        /// <summary>The processor of this process where the file has it, since that one is loaded.</summary>
        private static string Universal(byte[] bytes)
        {
            string first = null;
            string here = OfThisProcess();
            uint count = Math.Min(Number(bytes, 4, 4, true), 8);
            for (int i = 0; i < count && 8 + 20 * i + 4 <= bytes.Length; i++)
            {
                string image = Mach(Number(bytes, 8 + 20 * i, 4, true)) + " Mach-O";
                if (image == here) return image;
                first = first ?? image;
            }
            return first ?? "no processor at all";
        }

        private static string Pe(uint machine)
        {
            switch (machine)
            {
                case 0x014C: return "x86";
                case 0x8664: return "x86-64";
                case 0xAA64: return "ARM64";
                default: return "machine " + machine;
            }
        }
    }
}
