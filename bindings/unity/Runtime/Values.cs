using System;

namespace Crumple
{
    public partial struct CrumpleVec3
    {
        /// <summary>A point or a vector.</summary>
        public CrumpleVec3(float x, float y, float z)
        {
            X = x;
            Y = y;
            Z = z;
        }

        /// <inheritdoc/>
        public override string ToString()
        {
            IFormatProvider plain = System.Globalization.CultureInfo.InvariantCulture;
            return string.Format(plain, "({0}, {1}, {2})", X, Y, Z);
        }
    }

    public partial struct CrumpleStriker
    {
        /// <summary>What struck a body: mass, kg; radius at the contact, m; velocity relative to the body before the touch, m/s;
        /// shape. Zeros are unknown.</summary>
        public CrumpleStriker(float mass, float radius, CrumpleVec3 velocity, CrumpleStrikerShape shape = CrumpleStrikerShape.Unknown) : this()
        {
            Mass = mass;
            Radius = radius;
            Velocity = velocity;
            Shape = shape;
        }
    }

    public partial struct CrumpleInstanceDef
    {
        /// <summary>From mesh to world space: 16 floats, column-major, translation in elements 12 to 14, m.</summary>
        public unsafe void SetLocalToWorld(ReadOnlySpan<float> matrix)
        {
            if (matrix.Length != 16) throw new ArgumentException("a matrix has 16 elements, this one " + matrix.Length, "matrix");
            fixed (float* elements = LocalToWorld)
            {
                for (int i = 0; i < 16; i++) elements[i] = matrix[i];
            }
        }
    }

    public partial struct CrumpleExampleSetOptions
    {
        /// <summary>The defaults: begin with these.</summary>
        public static CrumpleExampleSetOptions Default
        {
            get { return CrumpleExampleSetDef.Default.Options; }
        }
    }
}
