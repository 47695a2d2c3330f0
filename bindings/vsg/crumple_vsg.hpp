// Crumple in VulkanSceneGraph: a command that dents the meshes of VSG's own draws, in VSG's own vertex buffers, from VSG's own
// command buffers. Header only; needs crumple.hpp and VSG 1.1.
//
//     crumple_vsg::share_one_buffer(device, *draw);                    // before the viewer compiles
//     auto deform = crumple_vsg::Deform::create(context, device, queue_family, viewer);
//     command_graph->addChild(deform);                                 // before the RenderGraph: outside its render pass
//     command_graph->addChild(render_graph);
//     viewer->assignRecordAndSubmitTaskAndPresentation({command_graph});
//     viewer->compile();
//     auto buffer = deform->add(body, *draw);                          // as long as the body is to be shown dented
//
// The context must outlive the Deform, which detaches the device when the viewer and all else let go of it. VSG records on the
// thread that calls recordAndSubmit() unless Viewer::setupThreading() was called; then nothing else may use the context
// meanwhile, but for submitting hits. Errors are crumple::Error. Where VSG transfers a mesh's arrays again (vsg::Data::dirty()),
// call Buffer::invalidate().
#ifndef CRUMPLE_VSG_HPP
#define CRUMPLE_VSG_HPP

#include <crumple.hpp>

#include <vsg/all.h>

namespace crumple_vsg {

namespace detail {

/// The VkFormat of a draw's array: what the Data says, or what its type is.
inline VkFormat format_of(const vsg::Data &data) {
    if (data.properties.format != VK_FORMAT_UNDEFINED) return data.properties.format;
    if (data.is_compatible(typeid(vsg::vec3Array))) return VK_FORMAT_R32G32B32_SFLOAT;
    if (data.is_compatible(typeid(vsg::vec4Array))) return VK_FORMAT_R32G32B32A32_SFLOAT;
    return VK_FORMAT_UNDEFINED; // which Crumple refuses, and says what it takes
}

} // namespace detail

/// Gives a draw's arrays and indices one VkBuffer that shaders may write, with memory of its own. VSG's would be for vertices and
/// indices alone, and what a VkBuffer may be used for is fixed when it is made.
inline void share_one_buffer(vsg::ref_ptr<vsg::Device> device, vsg::VertexIndexDraw &draw) {
    vsg::BufferInfoList all = draw.arrays;
    all.push_back(draw.indices);
    // As VSG lays them out: one behind the other, each from a multiple of 4 bytes on.
    VkDeviceSize size = 0;
    for (const auto &info : all) size += (info->data->dataSize() + 3) / 4 * 4;
    const VkBufferUsageFlags usage = VK_BUFFER_USAGE_VERTEX_BUFFER_BIT | VK_BUFFER_USAGE_INDEX_BUFFER_BIT |
                                     VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT |
                                     VK_BUFFER_USAGE_TRANSFER_SRC_BIT;
    auto buffer = vsg::createBufferAndMemory(device, size, usage, VK_SHARING_MODE_EXCLUSIVE,
                                             VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
    auto whole = vsg::BufferInfo::create(buffer.get(), 0, size);
    for (const auto &info : all) info->parent = whole;
}

/// Records what brings all added bodies up to date.
class Deform : public vsg::Inherit<vsg::Command, Deform> {
public:
    /// Attaches VSG's device to the context.
    Deform(crumple::Context &context_, vsg::ref_ptr<vsg::Device> device_, int queue_family, vsg::ref_ptr<vsg::Viewer> viewer_)
        : context(context_), device(device_), viewer(viewer_) {
        CrumpleVulkanAttachDef def = crumple_vulkan_attach_def_default();
        // VSG links the Vulkan loader, so this is the one that its instance came from.
        def.get_instance_proc_addr = reinterpret_cast<CrumpleVulkanFunction>(vkGetInstanceProcAddr);
        def.instance = device->getInstance()->vk();
        def.physical_device = device->getPhysicalDevice()->vk();
        def.device = device->vk();
        def.queue_family = static_cast<uint32_t>(queue_family);
        context.attach_vulkan(def).value();
    }

    /// Shows a body's dents in a compiled draw whose buffer came from share_one_buffer(). The numbers say which of the draw's
    /// arrays hold what; below 0: none.
    crumple::Buffer add(crumple::Instance &body, const vsg::VertexIndexDraw &draw, int positions = 0, int normals = 1,
                        int tangents = -1) {
        const auto &buffer = draw.indices->buffer;
        CrumpleVulkanBufferDef def = crumple_vulkan_buffer_def_default();
        def.buffer = (uint64_t)buffer->vk(device->deviceID); // a pointer or an integer, as VK_NON_DISPATCHABLE_HANDLE has it
        def.buffer_size = def.size = buffer->size;
        def.usage = buffer->usage;
        // Draws also fetch indices from it.
        def.before_access |= VK_ACCESS_INDEX_READ_BIT;
        def.after_access |= VK_ACCESS_INDEX_READ_BIT;
        const auto stream = [&](int array) {
            CrumpleVulkanStream made{};
            if (array < 0) return made;
            const vsg::BufferInfo &info = *draw.arrays.at(static_cast<size_t>(array));
            made.offset = info.offset;
            made.stride = info.data->properties.stride;
            made.format = static_cast<uint32_t>(detail::format_of(*info.data));
            return made;
        };
        def.positions = stream(positions);
        def.normals = stream(normals);
        def.tangents = stream(tangents);
        return body.register_buffer(def).value();
    }

    void record(vsg::CommandBuffer &commands) const override {
        const vsg::ref_ptr<vsg::Viewer> of = viewer;
        const uint64_t frame = of->getFrameStamp()->frameCount + 1; // VSG's first is 0
        // VSG keeps a fence for each frame in flight. fence(0) is this frame's own, which VSG has waited for: the frame that used
        // it last is done, whatever the others say.
        auto &task = *of->recordAndSubmitTasks.front();
        uint64_t back = 1;
        for (auto fence = task.fence(back); fence && fence->status() != VK_SUCCESS; fence = task.fence(back)) ++back;
        if (frame > back) context.complete_frames(frame - back).value();
        last = frame;
        report = context.record_deform(commands.vk(), frame).value();
    }

    /// What the last frame recorded.
    mutable CrumpleRecordReport report{};

protected:
    /// Waits for the device, and detaches it.
    ~Deform() override {
        vkDeviceWaitIdle(device->vk());
        crumple_vulkan_complete_frames(context.get(), last);
        crumple_vulkan_detach(context.get());
    }

private:
    crumple::Context &context;
    vsg::ref_ptr<vsg::Device> device;
    vsg::observer_ptr<vsg::Viewer> viewer; // which owns this, by way of its command graphs
    mutable uint64_t last = 0;
};

} // namespace crumple_vsg

#endif
