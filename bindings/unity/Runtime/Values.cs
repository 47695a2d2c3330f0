namespace Crumple
{
    /// <summary>C's bool: one byte, so that structs with it are the same in both languages. Converts from and to bool.</summary>
    public struct CrumpleBool
    {
        private byte value;

        /// <summary>From bool.</summary>
        public static implicit operator CrumpleBool(bool value)
        {
            return new CrumpleBool { value = value ? (byte)1 : (byte)0 };
        }

        /// <summary>To bool.</summary>
        public static implicit operator bool(CrumpleBool value)
        {
            return value.value != 0;
        }
    }

    /// <summary>A point or a vector.</summary>
    public partial struct CrumpleVec3
    {
        /// <summary>From its parts.</summary>
        public CrumpleVec3(float x, float y, float z)
        {
            X = x;
            Y = y;
            Z = z;
        }
    }
}
