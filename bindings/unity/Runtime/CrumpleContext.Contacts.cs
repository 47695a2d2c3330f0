using System;
using System.Runtime.InteropServices;
using Crumple.Native;

namespace Crumple
{
    // Contact points of a physics engine. Any thread may call these at any time.
    public sealed partial class CrumpleContext
    {
        /// <summary>Takes contact points of the current step of the physics: all or none.</summary>
        public unsafe void ReportContacts(ReadOnlySpan<CrumpleContactPointDef> points)
        {
            using (Call call = Enter())
            fixed (CrumpleContactPointDef* first = &MemoryMarshal.GetReference(points))
                CrumpleException.Check(NativeMethods.crumple_context_report_contacts(call.Context, first, (uint)points.Length));
        }

        /// <summary>Makes hits of the points of a step that lasted so many seconds. Call it once after each step.</summary>
        public unsafe CrumpleContactReport StepContacts(float seconds)
        {
            CrumpleContactReport report;
            using (Call call = Enter())
                CrumpleException.Check(NativeMethods.crumple_context_step_contacts(call.Context, seconds, &report));
            return report;
        }

        /// <summary>
        /// The hits that the last step brought to instances, at most as many as its report's hits. An empty destination only counts
        /// them. Allocates nothing.
        /// </summary>
        /// <returns>How many there are.</returns>
        /// <exception cref="CrumpleException">Among others: there are more than the destination has room for.</exception>
        public unsafe int GetContactHits(Span<CrumpleContactHit> destination)
        {
            uint count;
            using (Call call = Enter())
            fixed (CrumpleContactHit* hits = &MemoryMarshal.GetReference(destination))
                CrumpleException.Check(NativeMethods.crumple_context_get_contact_hits(call.Context, destination.IsEmpty ? null : hits,
                    (uint)destination.Length, &count));
            return (int)count;
        }

        /// <summary>Changes the options of contacts.</summary>
        public unsafe void SetContactOptions(CrumpleContactOptionsDef options)
        {
            using (Call call = Enter())
                CrumpleException.Check(NativeMethods.crumple_context_set_contact_options(call.Context, &options));
        }

        /// <summary>The sums of all steps' reports.</summary>
        public unsafe CrumpleContactReport ContactTotals()
        {
            CrumpleContactReport report;
            using (Call call = Enter())
                CrumpleException.Check(NativeMethods.crumple_context_get_contact_totals(call.Context, &report));
            return report;
        }
    }
}
