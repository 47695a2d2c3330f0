using System;
using System.Text;

namespace Crumple
{
    internal static unsafe class Utf8
    {
        /// <summary>A copy of UTF-8 text that ends with a zero; null for a null pointer.</summary>
        internal static string Text(IntPtr text)
        {
            if (text == IntPtr.Zero) return null;
            byte* bytes = (byte*)text;
            int length = 0;
            while (bytes[length] != 0) length++;
            return length == 0 ? "" : Encoding.UTF8.GetString(bytes, length);
        }

        /// <summary>UTF-8 with a zero at its end; null for null.</summary>
        internal static byte[] Bytes(string text)
        {
            return text == null ? null : Encoding.UTF8.GetBytes(text + "\0");
        }
    }
}
