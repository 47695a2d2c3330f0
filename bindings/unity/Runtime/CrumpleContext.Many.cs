using System;
using System.Runtime.InteropServices;
using Crumple.Native;

namespace Crumple
{
    public sealed partial class CrumpleContext
    {
        /// <summary>
        /// The buffers that the last deform, and the last recording, wrote to, and whose they are. Allocates nothing.
        /// </summary>
        /// <returns>How many there are.</returns>
        /// <exception cref="CrumpleException">Among others: there are more than the destination has room for.</exception>
        public unsafe int GetChangedBuffers(Span<CrumpleBufferInfo> destination)
        {
            CrumpleBufferInfo none;
            uint count;
            using (Call call = EnterAlone(this))
            fixed (CrumpleBufferInfo* buffers = &MemoryMarshal.GetReference(destination))
            {
                // No room is not the same as asking for the number.
                CrumpleBufferInfo* room = buffers == null ? &none : buffers;
                call.Check(NativeMethods.crumple_context_get_changed_buffers(call.Context, room, (uint)destination.Length, &count),
                    "crumple_context_get_changed_buffers");
            }
            return (int)count;
        }

        /// <summary>
        /// Reports hits, each on the instance at the same index: all or none. Results may be empty. Any thread, at any time.
        /// Allocates nothing.
        /// </summary>
        public unsafe void SubmitHits(ReadOnlySpan<CrumpleInstance> instances, ReadOnlySpan<CrumpleHitDef> defs,
            Span<CrumpleHitResult> results)
        {
            uint count = Together(instances.Length, defs.Length, results.Length);
            using (Call call = Enter(this))
            fixed (CrumpleInstance* ids = &MemoryMarshal.GetReference(instances))
            fixed (CrumpleHitDef* first = &MemoryMarshal.GetReference(defs))
            fixed (CrumpleHitResult* told = &MemoryMarshal.GetReference(results))
                call.Check(NativeMethods.crumple_context_submit_hits(call.Context, ids, first, count, told),
                    "crumple_context_submit_hits");
        }

        /// <summary>
        /// Takes contact points of the current step of the physics: all or none. Any thread, at any time.
        /// </summary>
        public unsafe void ReportContacts(ReadOnlySpan<CrumpleContactPointDef> points)
        {
            using (Call call = Enter(this))
            fixed (CrumpleContactPointDef* first = &MemoryMarshal.GetReference(points))
                call.Check(NativeMethods.crumple_context_report_contacts(call.Context, first, (uint)points.Length),
                    "crumple_context_report_contacts");
        }

        /// <summary>
        /// Makes hits of the points of a step that lasted so many seconds. Call it once after each step. Any thread, at any time.
        /// </summary>
        public unsafe CrumpleContactReport StepContacts(float seconds)
        {
            CrumpleContactReport report;
            using (Call call = Enter(this))
                call.Check(NativeMethods.crumple_context_step_contacts(call.Context, seconds, &report), "crumple_context_step_contacts");
            return report;
        }

        /// <summary>
        /// The hits that the last step brought to instances, at most as many as its report's hits. Any thread, at any time.
        /// Allocates nothing.
        /// </summary>
        /// <returns>How many there are.</returns>
        /// <exception cref="CrumpleException">Among others: there are more than the destination has room for.</exception>
        public unsafe int GetContactHits(Span<CrumpleContactHit> destination)
        {
            CrumpleContactHit none;
            uint count;
            using (Call call = Enter(this))
            fixed (CrumpleContactHit* hits = &MemoryMarshal.GetReference(destination))
            {
                // No room is not the same as asking for the number.
                CrumpleContactHit* room = hits == null ? &none : hits;
                call.Check(NativeMethods.crumple_context_get_contact_hits(call.Context, room, (uint)destination.Length, &count),
                    "crumple_context_get_contact_hits");
            }
            return (int)count;
        }

        /// <summary>Changes the options of contacts. Any thread, at any time.</summary>
        public unsafe void SetContactOptions(CrumpleContactOptionsDef options)
        {
            using (Call call = Enter(this))
                call.Check(NativeMethods.crumple_context_set_contact_options(call.Context, &options), "crumple_context_set_contact_options");
        }

        /// <summary>The sums of all steps' reports. Any thread, at any time.</summary>
        public unsafe CrumpleContactReport ContactTotals()
        {
            CrumpleContactReport report;
            using (Call call = Enter(this))
                call.Check(NativeMethods.crumple_context_get_contact_totals(call.Context, &report), "crumple_context_get_contact_totals");
            return report;
        }

        /// <summary>Ends all touches and forgets the points that wait, as after loading a saved game. Any thread, at any time.</summary>
        public void ClearContacts()
        {
            using (Call call = Enter(this))
                call.Check(NativeMethods.crumple_context_clear_contacts(call.Context), "crumple_context_clear_contacts");
        }

        private static uint Together(int instances, int defs, int results)
        {
            if (instances != defs) throw new ArgumentException(defs + " hits for " + instances + " instances", "defs");
            if (results != 0 && results < defs) throw new ArgumentException("room for " + results + " results of " + defs + " hits", "results");
            return (uint)defs;
        }

        /// <summary>Saves the damage of these instances as one array of bytes; of all instances for none.</summary>
        public unsafe byte[] SaveDamage(ReadOnlySpan<CrumpleInstance> instances = default(ReadOnlySpan<CrumpleInstance>))
        {
            using (Call call = EnterAlone(this))
            fixed (CrumpleInstance* ids = &MemoryMarshal.GetReference(instances))
            {
                UIntPtr size;
                uint count = (uint)instances.Length;
                call.Check(NativeMethods.crumple_context_save_damage(call.Context, ids, count, IntPtr.Zero, UIntPtr.Zero, &size),
                    "crumple_context_save_damage");
                byte[] saved = new byte[(int)size];
                fixed (byte* bytes = saved)
                    call.Check(NativeMethods.crumple_context_save_damage(call.Context, ids, count, (IntPtr)bytes, size, &size),
                        "crumple_context_save_damage");
                return saved;
            }
        }

        /// <summary>
        /// Replaces the damage of as many instances of the same sets, in the same order: of all of them, or of none.
        /// </summary>
        public unsafe void LoadDamage(ReadOnlySpan<byte> saved, ReadOnlySpan<CrumpleInstance> instances = default(ReadOnlySpan<CrumpleInstance>))
        {
            byte none;
            using (Call call = EnterAlone(this))
            fixed (CrumpleInstance* ids = &MemoryMarshal.GetReference(instances))
            fixed (byte* bytes = &MemoryMarshal.GetReference(saved))
            {
                byte* data = bytes == null ? &none : bytes;
                call.Check(NativeMethods.crumple_context_load_damage(call.Context, ids, (uint)instances.Length, (IntPtr)data,
                    (UIntPtr)(uint)saved.Length), "crumple_context_load_damage");
            }
        }

        /// <summary>
        /// Sets the time, s, for instances with a GrowTime. Call it once a frame before <see cref="Deform()"/>.
        /// </summary>
        public void SetTime(double time)
        {
            using (Call call = EnterAlone(this))
                call.Check(NativeMethods.crumple_context_set_time(call.Context, time), "crumple_context_set_time");
        }
    }
}
