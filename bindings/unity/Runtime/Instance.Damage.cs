using System;
using System.Runtime.InteropServices;
using Crumple.Native;

namespace Crumple
{
    public sealed partial class Instance
    {
        /// <summary>Number of marks, hits that wait among them.</summary>
        public unsafe int MarkCount
        {
            get
            {
                uint count;
                using (Call call = Context.EnterAlone(this))
                    call.Check(NativeMethods.crumple_instance_get_marks(call.Context, Id, null, 0, &count), "crumple_instance_get_marks");
                return (int)count;
            }
        }

        /// <summary>
        /// Copies the marks, sorted: the same hits give the same marks whatever their order. Allocates nothing.
        /// </summary>
        /// <returns>How many there are.</returns>
        /// <exception cref="CrumpleException">Among others: there are more than the destination has room for.</exception>
        public unsafe int CopyMarks(Span<CrumpleMark> destination)
        {
            CrumpleMark none;
            uint count;
            using (Call call = Context.EnterAlone(this))
            fixed (CrumpleMark* marks = &MemoryMarshal.GetReference(destination))
            {
                // No room is not the same as asking for the number.
                CrumpleMark* room = marks == null ? &none : marks;
                call.Check(NativeMethods.crumple_instance_get_marks(call.Context, Id, room, (uint)destination.Length, &count),
                    "crumple_instance_get_marks");
            }
            return (int)count;
        }

        /// <summary>The marks, sorted, in an array of their own: 32 bytes each, the same on every machine.</summary>
        public CrumpleMark[] GetMarks()
        {
            CrumpleMark[] marks = new CrumpleMark[MarkCount];
            CopyMarks(marks);
            return marks;
        }

        /// <summary>Replaces the marks by others of the same set, forgets hits that wait and ends contacts.</summary>
        public unsafe void SetMarks(ReadOnlySpan<CrumpleMark> marks)
        {
            using (Call call = Context.EnterAlone(this))
            fixed (CrumpleMark* first = &MemoryMarshal.GetReference(marks))
                call.Check(NativeMethods.crumple_instance_set_marks(call.Context, Id, first, (uint)marks.Length), "crumple_instance_set_marks");
        }

        /// <summary>Number of bytes that <see cref="SaveDamage(Span{byte})"/> writes.</summary>
        public unsafe int SavedSize
        {
            get
            {
                UIntPtr size;
                using (Call call = Context.EnterAlone(this))
                    call.Check(NativeMethods.crumple_instance_save_damage(call.Context, Id, IntPtr.Zero, UIntPtr.Zero, &size),
                        "crumple_instance_save_damage");
                return (int)size;
            }
        }

        /// <summary>
        /// Saves the damage as bytes, with a version and the set's fingerprint; the same bytes for the same damage on every
        /// machine. Allocates nothing.
        /// </summary>
        /// <returns>How many bytes were written.</returns>
        public unsafe int SaveDamage(Span<byte> destination)
        {
            byte none;
            UIntPtr size;
            using (Call call = Context.EnterAlone(this))
            fixed (byte* bytes = &MemoryMarshal.GetReference(destination))
            {
                byte* room = bytes == null ? &none : bytes;
                call.Check(NativeMethods.crumple_instance_save_damage(call.Context, Id, (IntPtr)room, (UIntPtr)(uint)destination.Length, &size),
                    "crumple_instance_save_damage");
            }
            return (int)size;
        }

        /// <summary>The same, in an array of its own.</summary>
        public byte[] SaveDamage()
        {
            byte[] bytes = new byte[SavedSize];
            SaveDamage(bytes);
            return bytes;
        }

        /// <summary>Replaces the damage by saved bytes; forgets hits that wait and ends contacts.</summary>
        public unsafe void LoadDamage(ReadOnlySpan<byte> bytes)
        {
            byte none;
            using (Call call = Context.EnterAlone(this))
            fixed (byte* first = &MemoryMarshal.GetReference(bytes))
            {
                byte* data = first == null ? &none : first;
                call.Check(NativeMethods.crumple_instance_load_damage(call.Context, Id, (IntPtr)data, (UIntPtr)(uint)bytes.Length),
                    "crumple_instance_load_damage");
            }
        }

        /// <summary>Every dent keeps this share of its depth, 0 (as new) to 1 (nothing repaired). Ends contacts.</summary>
        public void RepairDamage(float keep)
        {
            using (Call call = Context.EnterAlone(this))
                call.Check(NativeMethods.crumple_instance_repair_damage(call.Context, Id, keep), "crumple_instance_repair_damage");
        }

        /// <summary>
        /// Repairs dents near a point, m, in the mesh's space: one there keeps this share of its depth, 0 to 1, those radius
        /// away, m, keep all of it. Ends contacts.
        /// </summary>
        public void RepairAround(CrumpleVec3 point, float radius, float keep)
        {
            using (Call call = Context.EnterAlone(this))
                call.Check(NativeMethods.crumple_instance_repair_around(call.Context, Id, point, radius, keep),
                    "crumple_instance_repair_around");
        }

        /// <summary>
        /// A number for the marks, hits that wait among them: equal marks have equal revisions, on every machine. 0 without marks.
        /// </summary>
        public ulong Revision
        {
            get { return GetInfo().Revision; }
        }

        /// <summary>Makes it as new, forgets hits that wait and ends contacts.</summary>
        public void ResetDamage()
        {
            using (Call call = Context.EnterAlone(this))
                call.Check(NativeMethods.crumple_instance_reset_damage(call.Context, Id), "crumple_instance_reset_damage");
        }

        /// <summary>
        /// Replaces the damage by that of another instance of the same context with an equal set and the same kind of rule.
        /// </summary>
        public void CopyDamageFrom(Instance source)
        {
            if (source == null) throw new ArgumentNullException("source");
            using (Call call = Context.EnterAlone(this))
                call.Check(NativeMethods.crumple_instance_copy_damage(call.Context, Id, source.Id), "crumple_instance_copy_damage");
        }
    }
}
