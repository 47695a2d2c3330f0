using System;
using System.Runtime.InteropServices;

namespace Crumple
{
    /// <summary>C's bool: one byte, so that structs with it are the same in both languages. Converts from and to bool.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct CrumpleBool : IEquatable<CrumpleBool>
    {
        private readonly byte value;

        /// <summary>True or false.</summary>
        public CrumpleBool(bool value)
        {
            this.value = value ? (byte)1 : (byte)0;
        }

        /// <summary>From bool.</summary>
        public static implicit operator CrumpleBool(bool value)
        {
            return new CrumpleBool(value);
        }

        /// <summary>To bool.</summary>
        public static implicit operator bool(CrumpleBool value)
        {
            return value.value != 0;
        }

        /// <inheritdoc/>
        public bool Equals(CrumpleBool other)
        {
            return (bool)this == (bool)other;
        }

        /// <inheritdoc/>
        public override bool Equals(object other)
        {
            return other is CrumpleBool && Equals((CrumpleBool)other);
        }

        /// <inheritdoc/>
        public override int GetHashCode()
        {
            return value != 0 ? 1 : 0;
        }

        /// <inheritdoc/>
        public override string ToString()
        {
            return value != 0 ? "true" : "false";
        }
    }
}
