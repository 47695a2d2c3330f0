using System;
using System.Collections.Generic;
using System.Runtime.InteropServices;
using Crumple.Native;

namespace Crumple
{
    /// <summary>
    /// A body in the scene: an example set, a transform, and the damage so far. It holds its buffers; one that is forgotten
    /// together with them is destroyed by a later call into its context.
    /// </summary>
    public sealed partial class Instance : IDisposable
    {
        private readonly CrumpleInstance id;
        private readonly List<DeformBuffer> buffers = new List<DeformBuffer>();
        /// <summary>Of host buffers; read by the finalizer, when the buffers may be finalized already.</summary>
        private readonly List<Pins> memory = new List<Pins>();
        private volatile bool disposed;

        /// <summary>The context that it was made in.</summary>
        public CrumpleContext Context { get; }

        /// <summary>The set that it was made with, which may be disposed of by now.</summary>
        public ExampleSet Set { get; }

        internal Instance(CrumpleContext context, ExampleSet set, CrumpleInstance id)
        {
            Context = context;
            Set = set;
            this.id = id;
        }

        /// <summary>Leaves it to a later call.</summary>
        ~Instance()
        {
            if (Context != null && !disposed) Context.Handle.Leave(id, memory);
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
                using (Call call = Context.EnterAlone(this))
                    call.Check(NativeMethods.crumple_instance_destroy(call.Context, id), "crumple_instance_destroy");
            }
            disposed = true;
            GC.SuppressFinalize(this);
            foreach (DeformBuffer buffer in buffers) buffer.Ended();
            buffers.Clear();
            foreach (Pins pins in memory) Context.Handle.Unpin(pins);
            memory.Clear();
        }

        /// <summary>What it is at the moment.</summary>
        public unsafe CrumpleInstanceInfo GetInfo()
        {
            CrumpleInstanceInfo info;
            using (Call call = Context.EnterAlone(this))
                call.Check(NativeMethods.crumple_instance_get_info(call.Context, Id, &info), "crumple_instance_get_info");
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
            using (Call call = Context.Enter(this))
            fixed (float* matrix = &MemoryMarshal.GetReference(localToWorld))
                call.Check(NativeMethods.crumple_instance_set_transform(call.Context, Id, matrix),
                    "crumple_instance_set_transform");
        }

        /// <summary>No vertex moves further than this, m; 0: the set's limit.</summary>
        public void SetDepthLimit(float depthLimit)
        {
            using (Call call = Context.EnterAlone(this))
                call.Check(NativeMethods.crumple_instance_set_depth_limit(call.Context, Id, depthLimit),
                    "crumple_instance_set_depth_limit");
        }

        /// <summary>
        /// Reports a hit. One that is too weak, or that no example answers, is no error: see Status of the result. Any thread, at
        /// any time. Allocates nothing.
        /// </summary>
        public unsafe CrumpleHitResult Submit(in CrumpleHitDef def)
        {
            CrumpleHitDef copy = def;
            CrumpleHitResult result;
            using (Call call = Context.Enter(this))
                call.Check(NativeMethods.crumple_instance_submit_hit(call.Context, Id, &copy, &result), "crumple_instance_submit_hit");
            return result;
        }

        /// <summary>
        /// Reports an impulse in the mesh's space. Any thread, at any time. Allocates nothing.
        /// </summary>
        /// <param name="point">Where it hit, m.</param>
        /// <param name="impulse">What the body received, N s.</param>
        /// <param name="duration">How long it acted, s: a constant of the material, say 0.01, not the time step.</param>
        /// <param name="mass">Mass of the contact vertex, kg; 0: that of the set.</param>
        /// <param name="contactId">Hits with the same number, not 0, make one dent until <see cref="EndContact"/>.</param>
        public CrumpleHitResult SubmitImpulse(CrumpleVec3 point, CrumpleVec3 impulse, float duration, float mass = 0, ulong contactId = 0)
        {
            CrumpleHitDef def = CrumpleHitDef.Default;
            def.Point = point;
            def.Impulse = impulse;
            def.Duration = duration;
            def.Mass = mass;
            def.ContactId = contactId;
            return Submit(in def);
        }

        /// <summary>
        /// Reports a hit at a point, m, that should displace its contact so far, m, both in the mesh's space. Any thread, at any
        /// time.
        /// </summary>
        public CrumpleHitResult SubmitDisplacement(CrumpleVec3 point, CrumpleVec3 displacement)
        {
            CrumpleHitDef def = CrumpleHitDef.Default;
            def.Kind = CrumpleHitKind.Displacement;
            def.Point = point;
            def.Displacement = displacement;
            return Submit(in def);
        }

        /// <summary>The result of a hit that leaves no mark. Any thread, at any time.</summary>
        public unsafe CrumpleHitResult Preview(in CrumpleHitDef def)
        {
            CrumpleHitDef copy = def;
            CrumpleHitResult result;
            using (Call call = Context.Enter(this))
                call.Check(NativeMethods.crumple_instance_preview_hit(call.Context, Id, &copy, &result), "crumple_instance_preview_hit");
            return result;
        }

        /// <summary>
        /// The result of a contact, all its hits taken as one. It is open, or among the 256 that ended last; another id is an error.
        /// </summary>
        public unsafe CrumpleHitResult GetContact(ulong contactId)
        {
            CrumpleHitResult result;
            using (Call call = Context.EnterAlone(this))
                call.Check(NativeMethods.crumple_instance_get_contact(call.Context, Id, contactId, &result), "crumple_instance_get_contact");
            return result;
        }

        /// <summary>
        /// Ends a contact: its dent stays as it is, and later hits with the same id begin another one. An id that no hit has is an error. Any
        /// thread, at any time.
        /// </summary>
        public void EndContact(ulong contactId)
        {
            using (Call call = Context.Enter(this))
                call.Check(NativeMethods.crumple_instance_end_contact(call.Context, Id, contactId), "crumple_instance_end_contact");
        }

        /// <summary>
        /// Takes a part off the body: a mesh of the set, a number of <see cref="ExampleSet.AddLod"/>. It has the same damage, and
        /// from now on its own. Register its buffer anew.
        /// </summary>
        public unsafe Instance ReleasePart(int part)
        {
            CrumpleInstance released;
            using (Call call = Context.EnterAlone(this))
                call.Check(NativeMethods.crumple_instance_release_part(call.Context, Id, MeshDef.Count(part, "part"), &released),
                    "crumple_instance_release_part");
            return new Instance(Context, Set, released);
        }

        /// <summary>Puts a released part on the body again, or with false takes it off. Hits on the body reach it too.</summary>
        public void MountPart(Instance part, bool mounted = true)
        {
            if (part == null) throw new ArgumentNullException("part");
            using (Call call = Context.EnterAlone(this))
                call.Check(NativeMethods.crumple_instance_mount_part(call.Context, Id, part.Id, mounted), "crumple_instance_mount_part");
        }

        /// <summary>Makes a part rigid, such as glass, or no longer: hits on it leave no mark.</summary>
        public void SetPartRigid(int part, bool rigid)
        {
            using (Call call = Context.EnterAlone(this))
                call.Check(NativeMethods.crumple_instance_set_part_rigid(call.Context, Id, MeshDef.Count(part, "part"), rigid),
                    "crumple_instance_set_part_rigid");
        }

        /// <summary>How far the vertices of a mesh of the set have moved, m: the furthest, and their mean.</summary>
        public float MeasurePart(int lod, out float mean)
        {
            float depth;
            return MeasurePart(lod, out mean, out depth);
        }

        /// <summary>The same, with the depth of the single hit that does as much damage as all marks on the mesh, m.</summary>
        public unsafe float MeasurePart(int lod, out float mean, out float equivalentDepth)
        {
            float deepest, all, one;
            using (Call call = Context.EnterAlone(this))
                call.Check(NativeMethods.crumple_instance_measure_part(call.Context, Id, MeshDef.Count(lod, "lod"), &deepest, &all, &one),
                    "crumple_instance_measure_part");
            mean = all;
            equivalentDepth = one;
            return deepest;
        }

        /// <summary>Where an attached point is, hits that wait among them.</summary>
        public unsafe CrumplePose GetAttachedPose(in CrumpleAttachment attachment)
        {
            CrumpleAttachment copy = attachment;
            CrumplePose pose;
            using (Call call = Context.EnterAlone(this))
                call.Check(NativeMethods.crumple_instance_get_attached_pose(call.Context, Id, &copy, &pose),
                    "crumple_instance_get_attached_pose");
            return pose;
        }

        /// <summary>
        /// Registers arrays, which stay pinned until the buffer's end, or memory of yours, that
        /// <see cref="CrumpleContext.Deform()"/> writes the vertices to. Positions and normals are 3 floats a vertex, tangents 4;
        /// absent ones are not written.
        /// </summary>
        /// <param name="positions">Required.</param>
        /// <param name="normals">Unit normals.</param>
        /// <param name="tangents">xyz of unit length and orthogonal to the normal, w as in the base mesh.</param>
        /// <param name="lod">0 the base mesh, else a number from <see cref="ExampleSet.AddLod"/>.</param>
        public unsafe HostBuffer RegisterHostBuffer(StridedArray positions, StridedArray normals = default(StridedArray),
            StridedArray tangents = default(StridedArray), int lod = 0)
        {
            Pins pins = new Pins();
            bool kept = false;
            try
            {
                CrumpleHostBufferDef def = HostBuffer.Def(pins, positions, normals, tangents, lod);
                CrumpleBuffer buffer;
                using (Call call = Context.EnterAlone(this))
                    call.Check(NativeMethods.crumple_buffer_register_host(call.Context, Id, &def, &buffer),
                        "crumple_buffer_register_host");
                Context.Handle.Keep(pins);
                kept = true;
                HostBuffer made = new HostBuffer(this, buffer, pins);
                memory.Add(pins);
                buffers.Add(made);
                return made;
            }
            finally
            {
                if (!kept) pins.Dispose();
            }
        }

        /// <summary>
        /// Registers a range of a VkBuffer that <see cref="CrumpleContext.RecordDeform(IntPtr, ulong)"/> or
        /// <see cref="CrumpleContext.SubmitDeform(ReadOnlySpan{ulong}, ReadOnlySpan{ulong}, out CrumpleRecordReport)"/> writes
        /// the vertices to.
        /// </summary>
        public unsafe VulkanBuffer RegisterVulkanBuffer(in CrumpleVulkanBufferDef def)
        {
            CrumpleVulkanBufferDef copy = def;
            CrumpleBuffer buffer;
            using (Call call = Context.EnterAlone(this))
                call.Check(NativeMethods.crumple_buffer_register_vulkan(call.Context, Id, &copy, &buffer),
                    "crumple_buffer_register_vulkan");
            VulkanBuffer made = new VulkanBuffer(this, buffer);
            buffers.Add(made);
            return made;
        }

        internal void Forget(DeformBuffer buffer, Pins pins)
        {
            buffers.Remove(buffer);
            if (pins == null) return;
            memory.Remove(pins);
            Context.Handle.Unpin(pins);
        }

        internal void Exchange(Pins old, Pins fresh)
        {
            memory.Remove(old);
            memory.Add(fresh);
            Context.Handle.Keep(fresh);
            Context.Handle.Unpin(old);
        }
    }
}
