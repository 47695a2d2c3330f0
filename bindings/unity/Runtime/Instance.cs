using System;
using System.Collections.Generic;
using System.Runtime.InteropServices;
using Crumple.Native;

namespace Crumple
{
    /// <summary>
    /// A body in the scene: an example set, a transform, and the damage so far. It holds its buffers. One that is not disposed of ends
    /// with its context.
    /// </summary>
    public sealed class Instance : IDisposable
    {
        private readonly CrumpleInstance id;
        private readonly List<HostBuffer> buffers = new List<HostBuffer>();
        private volatile bool disposed;

        /// <summary>The context that it was made in.</summary>
        public CrumpleContext Context { get; }

        internal Instance(CrumpleContext context, CrumpleInstance id)
        {
            Context = context;
            this.id = id;
        }

        /// <summary>Its id, for <see cref="NativeMethods"/>.</summary>
        public CrumpleInstance Id
        {
            get
            {
                if (disposed) throw new ObjectDisposedException("Instance");
                return id;
            }
        }

        /// <summary>
        /// Ends it and its buffers, and unpins their arrays. A second time, or after its context, nothing happens. No thread may
        /// be submitting hits to it.
        /// </summary>
        public void Dispose()
        {
            if (disposed) return;
            if (!Context.IsDisposed)
            {
                using (Call call = Context.Enter())
                    CrumpleException.Check(NativeMethods.crumple_instance_destroy(call.Context, id));
            }
            disposed = true;
            while (buffers.Count > 0) End(buffers[buffers.Count - 1]);
        }

        /// <summary>What it is at the moment.</summary>
        public unsafe CrumpleInstanceInfo GetInfo()
        {
            CrumpleInstanceInfo info;
            using (Call call = Context.Enter())
                CrumpleException.Check(NativeMethods.crumple_instance_get_info(call.Context, Id, &info));
            return info;
        }

        /// <summary>
        /// Where it is: 16 floats, column-major, translation in elements 12 to 14, m. Only hits in world space go through it. Any thread, at
        /// any time.
        /// </summary>
        public unsafe void SetTransform(ReadOnlySpan<float> localToWorld)
        {
            if (localToWorld.Length != 16)
                throw new ArgumentException("a matrix has 16 elements, this one " + localToWorld.Length, "localToWorld");
            using (Call call = Context.Enter())
            fixed (float* matrix = &MemoryMarshal.GetReference(localToWorld))
                CrumpleException.Check(NativeMethods.crumple_instance_set_transform(call.Context, Id, matrix));
        }

        /// <summary>
        /// Reports a hit. One that is too weak, or that no example answers, is no error: see Status of the result. Any thread, at
        /// any time. Allocates nothing.
        /// </summary>
        public unsafe CrumpleHitResult Submit(in CrumpleHitDef def)
        {
            CrumpleHitDef copy = def;
            CrumpleHitResult result;
            using (Call call = Context.Enter())
                CrumpleException.Check(NativeMethods.crumple_instance_submit_hit(call.Context, Id, &copy, &result));
            return result;
        }

        /// <summary>
        /// Reports an impulse in the mesh's space. Any thread, at any time. Allocates nothing.
        /// </summary>
        /// <param name="point">Where it hit, m.</param>
        /// <param name="impulse">What the body received, N s.</param>
        /// <param name="duration">How long it acted, s: a constant of the material, say 0.01, not the time step.</param>
        /// <param name="mass">Mass of the contact vertex, kg; 0: that of the set.</param>
        public CrumpleHitResult SubmitImpulse(CrumpleVec3 point, CrumpleVec3 impulse, float duration, float mass = 0)
        {
            CrumpleHitDef def = CrumpleHitDef.Default;
            def.Point = point;
            def.Impulse = impulse;
            def.Duration = duration;
            def.Mass = mass;
            return Submit(in def);
        }

        /// <summary>Where an attached point is, hits that wait among them. Allocates nothing.</summary>
        public unsafe CrumplePose GetAttachedPose(in CrumpleAttachment attachment)
        {
            CrumpleAttachment copy = attachment;
            CrumplePose pose;
            using (Call call = Context.Enter())
                CrumpleException.Check(NativeMethods.crumple_instance_get_attached_pose(call.Context, Id, &copy, &pose));
            return pose;
        }

        /// <summary>
        /// Saves the damage as bytes, with a version and the set's fingerprint; the same bytes for the same damage on every machine.
        /// </summary>
        public unsafe byte[] SaveDamage()
        {
            using (Call call = Context.Enter())
            {
                UIntPtr size;
                CrumpleException.Check(NativeMethods.crumple_instance_save_damage(call.Context, Id, IntPtr.Zero, UIntPtr.Zero, &size));
                byte[] bytes = new byte[(int)size];
                fixed (byte* data = bytes)
                    CrumpleException.Check(NativeMethods.crumple_instance_save_damage(call.Context, Id, (IntPtr)data, size, &size));
                return bytes;
            }
        }

        /// <summary>Replaces the damage by saved bytes; forgets hits that wait and ends contacts.</summary>
        public unsafe void LoadDamage(ReadOnlySpan<byte> bytes)
        {
            using (Call call = Context.Enter())
            fixed (byte* data = &MemoryMarshal.GetReference(bytes))
                CrumpleException.Check(NativeMethods.crumple_instance_load_damage(call.Context, Id, (IntPtr)data, (UIntPtr)(uint)bytes.Length));
        }

        /// <summary>Every dent keeps this share of its depth, 0 (as new) to 1 (nothing repaired). Ends contacts.</summary>
        public void RepairDamage(float keep)
        {
            using (Call call = Context.Enter())
                CrumpleException.Check(NativeMethods.crumple_instance_repair_damage(call.Context, Id, keep));
        }

        /// <summary>Makes it as new, forgets hits that wait and ends contacts.</summary>
        public void ResetDamage()
        {
            using (Call call = Context.Enter())
                CrumpleException.Check(NativeMethods.crumple_instance_reset_damage(call.Context, Id));
        }

        /// <summary>
        /// Registers arrays, which stay pinned until the buffer's end, or memory of yours, that <see cref="CrumpleContext.Deform"/>
        /// writes the vertices to. Positions and normals are 3 floats a vertex, tangents 4; absent ones are not written.
        /// </summary>
        /// <param name="positions">Required.</param>
        /// <param name="normals">Unit normals.</param>
        /// <param name="tangents">xyz of unit length and orthogonal to the normal, w as in the base mesh.</param>
        /// <param name="lod">0 the base mesh, else a number from <see cref="ExampleSet.AddLod"/>.</param>
        public unsafe HostBuffer RegisterHostBuffer(StridedArray positions, StridedArray normals = default(StridedArray),
            StridedArray tangents = default(StridedArray), int lod = 0)
        {
            Pins pins = new Pins();
            try
            {
                CrumpleHostBufferDef def = CrumpleHostBufferDef.Default;
                def.Lod = (uint)lod;
                def.Positions = pins.Stream(positions);
                def.Normals = pins.Stream(normals);
                def.Tangents = pins.Stream(tangents);
                CrumpleBuffer buffer;
                using (Call call = Context.Enter())
                    CrumpleException.Check(NativeMethods.crumple_buffer_register_host(call.Context, Id, &def, &buffer));
                Context.Handle.Keep(pins);
                HostBuffer made = new HostBuffer(this, buffer, pins);
                buffers.Add(made);
                return made;
            }
            catch
            {
                pins.Dispose();
                throw;
            }
        }

        /// <summary>A buffer is unregistered: its memory is let go.</summary>
        internal void End(HostBuffer buffer)
        {
            buffer.Ended = true;
            buffers.Remove(buffer);
            Context.Handle.Unpin(buffer.Memory);
        }
    }
}
