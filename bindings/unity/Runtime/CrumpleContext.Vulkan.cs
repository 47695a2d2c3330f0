using System;
using System.Runtime.InteropServices;
using Crumple.Native;

namespace Crumple
{
    public sealed partial class CrumpleContext
    {
        /// <summary>Rises when a device goes, and all Vulkan buffers with it.</summary>
        internal int DeviceNumber { get; private set; }

        /// <summary>
        /// Takes your Vulkan device. Its handles must stay valid until <see cref="DetachVulkan"/> or <see cref="Dispose"/>: a
        /// context that is forgotten with a device attached is left alone, since nobody knows whether the device is still there.
        /// </summary>
        public unsafe void AttachVulkan(in CrumpleVulkanAttachDef def)
        {
            CrumpleVulkanAttachDef copy = def;
            using (Call call = EnterAlone(this))
                call.Check(NativeMethods.crumple_vulkan_attach(call.Context, &copy), "crumple_vulkan_attach");
            Handle.HasHostDevice = true;
        }

        /// <summary>Makes a Vulkan device of Crumple's own, with which memory is shared.</summary>
        public unsafe void OpenVulkan(in CrumpleVulkanOpenDef def)
        {
            CrumpleVulkanOpenDef copy = def;
            using (Call call = EnterAlone(this))
                call.Check(NativeMethods.crumple_vulkan_open(call.Context, &copy), "crumple_vulkan_open");
        }

        /// <summary>Lets go of the Vulkan device; all Vulkan buffers end. Damage stays.</summary>
        public void DetachVulkan()
        {
            using (Call call = EnterAlone(this))
                call.Check(NativeMethods.crumple_vulkan_detach(call.Context), "crumple_vulkan_detach");
            Handle.HasHostDevice = false;
            DeviceNumber++;
        }

        /// <summary>What the driver would like to have again at the next start, for CrumpleVulkanAttachDef.PipelineCache.</summary>
        public unsafe byte[] GetVulkanPipelineCache()
        {
            UIntPtr size;
            using (Call call = EnterAlone(this))
            {
                call.Check(NativeMethods.crumple_vulkan_get_pipeline_cache(call.Context, IntPtr.Zero, UIntPtr.Zero, &size),
                    "crumple_vulkan_get_pipeline_cache");
                byte[] bytes = new byte[(int)size];
                fixed (byte* data = bytes)
                    call.Check(NativeMethods.crumple_vulkan_get_pipeline_cache(call.Context, (IntPtr)data, size, &size),
                        "crumple_vulkan_get_pipeline_cache");
                return bytes;
            }
        }

        /// <summary>
        /// Records what brings all Vulkan buffers up to date into a VkCommandBuffer of yours. Allocates nothing.
        /// </summary>
        /// <param name="commandBuffer">In the recording state, outside a render pass.</param>
        /// <param name="frame">Your number of the frame, from 1 on; it never falls.</param>
        public unsafe CrumpleRecordReport RecordDeform(IntPtr commandBuffer, ulong frame)
        {
            CrumpleRecordReport report;
            using (Call call = EnterAlone(this))
                call.Check(NativeMethods.crumple_vulkan_record(call.Context, commandBuffer, frame, null, 0, &report),
                    "crumple_vulkan_record");
            return report;
        }

        /// <summary>The same for some buffers, each named once; nothing for an empty list.</summary>
        public unsafe CrumpleRecordReport RecordDeform(IntPtr commandBuffer, ulong frame, ReadOnlySpan<CrumpleBuffer> buffers)
        {
            CrumpleRecordReport report = default(CrumpleRecordReport);
            // For C no ids are all buffers.
            if (buffers.IsEmpty) return report;
            using (Call call = EnterAlone(this))
            fixed (CrumpleBuffer* ids = &MemoryMarshal.GetReference(buffers))
                call.Check(NativeMethods.crumple_vulkan_record(call.Context, commandBuffer, frame, ids, (uint)buffers.Length, &report),
                    "crumple_vulkan_record");
            return report;
        }

        /// <summary>Says that the device is done with a frame and all before it. Once a frame; allocates nothing.</summary>
        public void CompleteFrames(ulong frame)
        {
            using (Call call = EnterAlone(this))
                call.Check(NativeMethods.crumple_vulkan_complete_frames(call.Context, frame), "crumple_vulkan_complete_frames");
        }

        /// <summary>Says that what was recorded for a frame and those after it will not be submitted.</summary>
        public void DiscardFrames(ulong frame)
        {
            using (Call call = EnterAlone(this))
                call.Check(NativeMethods.crumple_vulkan_discard_frames(call.Context, frame), "crumple_vulkan_discard_frames");
        }

        /// <summary>
        /// Makes a VkBuffer of your device known to Crumple's own; what stands for it in CrumpleVulkanBufferDef.Buffer.
        /// </summary>
        public unsafe ulong ImportVulkanBuffer(in CrumpleVulkanImportDef def)
        {
            CrumpleVulkanImportDef copy = def;
            ulong buffer;
            using (Call call = EnterAlone(this))
                call.Check(NativeMethods.crumple_vulkan_import_buffer(call.Context, &copy, &buffer),
                    "crumple_vulkan_import_buffer");
            return buffer;
        }

        /// <summary>Forgets an imported buffer that no range is registered of.</summary>
        public void ReleaseVulkanBuffer(ulong buffer)
        {
            using (Call call = EnterAlone(this))
                call.Check(NativeMethods.crumple_vulkan_unimport_buffer(call.Context, buffer), "crumple_vulkan_unimport_buffer");
        }

        /// <summary>Makes a binary semaphore of your device known to Crumple's own; its number for SubmitDeform.</summary>
        public unsafe ulong ImportVulkanSemaphore(CrumpleHandleType handleType, long handle)
        {
            ulong semaphore;
            using (Call call = EnterAlone(this))
                call.Check(NativeMethods.crumple_vulkan_import_semaphore(call.Context, handleType, handle, &semaphore),
                    "crumple_vulkan_import_semaphore");
            return semaphore;
        }

        /// <summary>
        /// Brings all Vulkan buffers up to date on Crumple's own device, which waits for some semaphores before and signals
        /// others after. Allocates nothing.
        /// </summary>
        /// <returns>The frame's number, for <see cref="WaitFrame"/>.</returns>
        public unsafe ulong SubmitDeform(ReadOnlySpan<ulong> waits, ReadOnlySpan<ulong> signals, out CrumpleRecordReport report)
        {
            CrumpleRecordReport written;
            ulong frame;
            using (Call call = EnterAlone(this))
            fixed (ulong* first = &MemoryMarshal.GetReference(waits), second = &MemoryMarshal.GetReference(signals))
                call.Check(NativeMethods.crumple_vulkan_submit(call.Context, null, 0, first, (uint)waits.Length, second,
                    (uint)signals.Length, &frame, &written), "crumple_vulkan_submit");
            report = written;
            return frame;
        }

        /// <summary>The same for some buffers, at least one, each named once.</summary>
        public unsafe ulong SubmitDeform(ReadOnlySpan<CrumpleBuffer> buffers, ReadOnlySpan<ulong> waits, ReadOnlySpan<ulong> signals,
            out CrumpleRecordReport report)
        {
            // For C no ids are all buffers.
            if (buffers.IsEmpty) throw new ArgumentException("name a buffer, or leave the list out to mean all", "buffers");
            CrumpleRecordReport written;
            ulong frame;
            using (Call call = EnterAlone(this))
            fixed (CrumpleBuffer* ids = &MemoryMarshal.GetReference(buffers))
            fixed (ulong* first = &MemoryMarshal.GetReference(waits), second = &MemoryMarshal.GetReference(signals))
                call.Check(NativeMethods.crumple_vulkan_submit(call.Context, ids, (uint)buffers.Length, first, (uint)waits.Length,
                    second, (uint)signals.Length, &frame, &written), "crumple_vulkan_submit");
            report = written;
            return frame;
        }

        /// <summary>
        /// Waits until Crumple's own device is done with a frame, for so many nanoseconds (ulong.MaxValue: as long as it takes).
        /// </summary>
        /// <returns>Whether it is done.</returns>
        public unsafe bool WaitFrame(ulong frame, ulong timeout)
        {
            CrumpleBool done;
            using (Call call = EnterAlone(this))
                call.Check(NativeMethods.crumple_vulkan_wait_frame(call.Context, frame, timeout, &done), "crumple_vulkan_wait_frame");
            return done;
        }
    }
}
