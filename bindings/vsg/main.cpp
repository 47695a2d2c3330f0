// A hood in a VulkanSceneGraph scene, dented while VSG draws it, without a window.
//
//     vsg_hood HOOD.glb PICTURE.png        writes the first frame and the last, side by side
//
// Exits with 77 where there is no Vulkan driver, unless CRUMPLE_REQUIRE_GPU=1; with CRUMPLE_VALIDATION=1 under the Khronos
// validation layer (VK_LAYER_ENABLES=VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT adds synchronization).
#include "crumple_vsg.hpp"

#include "shaders/hood.frag.h"
#include "shaders/hood.vert.h"
#include "side_by_side.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

namespace {

constexpr uint32_t WIDTH = 640, HEIGHT = 400; // pixels
constexpr VkFormat COLOUR = VK_FORMAT_R8G8B8A8_SRGB, DEPTH = VK_FORMAT_D32_SFLOAT;
constexpr VkSampleCountFlagBits SAMPLES = VK_SAMPLE_COUNT_4_BIT;
constexpr uint64_t FRAMES = 9;

void fact(bool holds, const std::string &what) {
    if (holds) return;
    std::fprintf(stderr, "this is not so: %s\n", what.c_str());
    std::exit(1);
}

bool set(const char *variable) {
    const char *value = std::getenv(variable);
    return value && std::strcmp(value, "1") == 0;
}

unsigned messages = 0;

VKAPI_ATTR VkBool32 VKAPI_CALL said(VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                                    const VkDebugUtilsMessengerCallbackDataEXT *data, void *) {
    ++messages;
    std::fprintf(stderr, "validation: %s\n", data->pMessage);
    return VK_FALSE;
}

// Counts what the validation layer says while it lives.
class Listener {
public:
    explicit Listener(vsg::ref_ptr<vsg::Instance> instance_) : instance(instance_) {
        PFN_vkCreateDebugUtilsMessengerEXT create = nullptr;
        if (!set("CRUMPLE_VALIDATION") || !instance->getProcAddr(create, "vkCreateDebugUtilsMessengerEXT")) return;
        VkDebugUtilsMessengerCreateInfoEXT info{};
        info.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT;
        info.messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
        info.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_GENERAL_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
        info.pfnUserCallback = said;
        fact(create(instance->vk(), &info, nullptr, &messenger) == VK_SUCCESS, "a messenger can be made");
    }
    ~Listener() {
        PFN_vkDestroyDebugUtilsMessengerEXT destroy = nullptr;
        if (messenger && instance->getProcAddr(destroy, "vkDestroyDebugUtilsMessengerEXT"))
            destroy(instance->vk(), messenger, nullptr);
    }
    Listener(const Listener &) = delete;
    Listener &operator=(const Listener &) = delete;

private:
    vsg::ref_ptr<vsg::Instance> instance;
    VkDebugUtilsMessengerEXT messenger = VK_NULL_HANDLE;
};

vsg::ref_ptr<vsg::Instance> make_instance() {
    vsg::Names extensions, layers;
    if (set("CRUMPLE_VALIDATION")) {
        extensions.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
        layers.push_back("VK_LAYER_KHRONOS_validation");
    }
    return vsg::Instance::create(extensions, layers, VK_API_VERSION_1_1);
}

// Positions and normals as VSG arrays; normals are 16-bit integers, as VK_FORMAT_R16G16B16A16_SNORM takes them.
vsg::ref_ptr<vsg::VertexIndexDraw> make_draw(const std::vector<CrumpleVec3> &positions, const std::vector<CrumpleVec3> &normals,
                                             const std::vector<uint32_t> &indices, float fourth) {
    auto at = vsg::vec3Array::create(uint32_t(positions.size()));
    auto facing = vsg::svec4Array::create(uint32_t(normals.size()), vsg::Data::Properties(VK_FORMAT_R16G16B16A16_SNORM));
    const auto snorm = [](float x) { return int16_t(std::lround(x * 32767)); };
    for (uint32_t v = 0; v < positions.size(); ++v) {
        at->set(v, {positions[v].x, positions[v].y, positions[v].z});
        facing->set(v, {snorm(normals[v].x), snorm(normals[v].y), snorm(normals[v].z), snorm(fourth)});
    }
    auto corners = vsg::uintArray::create(uint32_t(indices.size()));
    std::copy(indices.begin(), indices.end(), corners->begin());
    auto draw = vsg::VertexIndexDraw::create();
    draw->assignArrays({at, facing});
    draw->assignIndices(corners);
    draw->indexCount = uint32_t(indices.size());
    draw->instanceCount = 1;
    return draw;
}

vsg::ref_ptr<vsg::BindGraphicsPipeline> make_pipeline() {
    const auto stage = [](VkShaderStageFlagBits which, const uint32_t *begin, const uint32_t *end) {
        return vsg::ShaderStage::create(which, "main", vsg::ShaderModule::create(vsg::ShaderModule::SPIRV(begin, end)));
    };
    const vsg::ShaderStages stages{stage(VK_SHADER_STAGE_VERTEX_BIT, std::begin(hood_vert), std::end(hood_vert)),
                                   stage(VK_SHADER_STAGE_FRAGMENT_BIT, std::begin(hood_frag), std::end(hood_frag))};
    const vsg::VertexInputState::Bindings bindings{{0, 12, VK_VERTEX_INPUT_RATE_VERTEX}, {1, 8, VK_VERTEX_INPUT_RATE_VERTEX}};
    const vsg::VertexInputState::Attributes attributes{{0, 0, VK_FORMAT_R32G32B32_SFLOAT, 0},
                                                       {1, 1, VK_FORMAT_R16G16B16A16_SNORM, 0}};
    auto both_sides = vsg::RasterizationState::create();
    both_sides->cullMode = VK_CULL_MODE_NONE;
    const vsg::GraphicsPipelineStates states{
        vsg::VertexInputState::create(bindings, attributes), vsg::InputAssemblyState::create(), both_sides,
        vsg::MultisampleState::create(SAMPLES), vsg::ColorBlendState::create(), vsg::DepthStencilState::create()};
    // VSG pushes the projection and the model view matrix.
    auto layout = vsg::PipelineLayout::create(vsg::DescriptorSetLayouts{},
                                              vsg::PushConstantRanges{{VK_SHADER_STAGE_VERTEX_BIT, 0, 128}});
    return vsg::BindGraphicsPipeline::create(vsg::GraphicsPipeline::create(layout, stages, states));
}

// An image to draw into, and the render pass that does.
struct Target {
    vsg::ref_ptr<vsg::Image> picture;
    vsg::ref_ptr<vsg::Framebuffer> framebuffer;
};

Target make_target(vsg::ref_ptr<vsg::Device> device) {
    const auto image = [&](VkFormat format, VkImageUsageFlags usage, VkSampleCountFlagBits samples, VkImageAspectFlags aspect) {
        auto made = vsg::Image::create();
        made->imageType = VK_IMAGE_TYPE_2D;
        made->format = format;
        made->extent = {WIDTH, HEIGHT, 1};
        made->mipLevels = made->arrayLayers = 1;
        made->samples = samples;
        made->usage = usage;
        return vsg::createImageView(device, made, aspect);
    };
    const auto attachment = [](VkFormat format, VkSampleCountFlagBits samples, VkImageLayout layout) {
        vsg::AttachmentDescription made{};
        made.format = format;
        made.samples = samples;
        made.loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR;
        made.storeOp = VK_ATTACHMENT_STORE_OP_DONT_CARE;
        made.finalLayout = layout;
        return made;
    };
    vsg::RenderPass::Attachments attachments{
        attachment(COLOUR, SAMPLES, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL),
        attachment(DEPTH, SAMPLES, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL),
        attachment(COLOUR, VK_SAMPLE_COUNT_1_BIT, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL)};
    attachments[2].loadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE;
    attachments[2].storeOp = VK_ATTACHMENT_STORE_OP_STORE;
    vsg::SubpassDescription subpass{};
    const auto reference = [](uint32_t index, VkImageLayout layout) {
        vsg::AttachmentReference made{};
        made.attachment = index;
        made.layout = layout;
        return made;
    };
    subpass.colorAttachments = {reference(0, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL)};
    subpass.depthStencilAttachments = {reference(1, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL)};
    subpass.resolveAttachments = {reference(2, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL)};
    const VkPipelineStageFlags drawn = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT |
                                       VK_PIPELINE_STAGE_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_LATE_FRAGMENT_TESTS_BIT;
    const VkAccessFlags writes = VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
    vsg::SubpassDependency before{}, after{};
    before.srcSubpass = after.dstSubpass = VK_SUBPASS_EXTERNAL;
    before.srcStageMask = drawn | VK_PIPELINE_STAGE_TRANSFER_BIT;
    before.srcAccessMask = writes | VK_ACCESS_TRANSFER_READ_BIT;
    before.dstStageMask = drawn;
    before.dstAccessMask = writes | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_READ_BIT;
    after.srcStageMask = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT;
    after.srcAccessMask = VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT;
    after.dstStageMask = VK_PIPELINE_STAGE_TRANSFER_BIT;
    after.dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT;
    auto pass = vsg::RenderPass::create(device, attachments, vsg::RenderPass::Subpasses{subpass},
                                        vsg::RenderPass::Dependencies{before, after});
    auto resolved = image(COLOUR, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT, VK_SAMPLE_COUNT_1_BIT,
                          VK_IMAGE_ASPECT_COLOR_BIT);
    const vsg::ImageViews views{
        image(COLOUR, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT, SAMPLES, VK_IMAGE_ASPECT_COLOR_BIT),
        image(DEPTH, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT, SAMPLES, VK_IMAGE_ASPECT_DEPTH_BIT), resolved};
    return {resolved->image, vsg::Framebuffer::create(pass, views, WIDTH, HEIGHT, 1)};
}

vsg::ref_ptr<vsg::Buffer> seen_by_cpu(vsg::ref_ptr<vsg::Device> device, VkDeviceSize size) {
    return vsg::createBufferAndMemory(device, size, VK_BUFFER_USAGE_TRANSFER_DST_BIT, VK_SHARING_MODE_EXCLUSIVE,
                                      VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
}

std::vector<uint8_t> contents(vsg::ref_ptr<vsg::Device> device, vsg::ref_ptr<vsg::Buffer> buffer) {
    auto *memory = buffer->getDeviceMemory(device->deviceID);
    void *data = nullptr;
    fact(memory->map(buffer->getMemoryOffset(device->deviceID), buffer->size, 0, &data) == VK_SUCCESS, "memory can be mapped");
    const auto *bytes = static_cast<const uint8_t *>(data);
    std::vector<uint8_t> copy(bytes, bytes + buffer->size);
    memory->unmap();
    return copy;
}

Picture picture(vsg::ref_ptr<vsg::Device> device, vsg::ref_ptr<vsg::Buffer> buffer) {
    const std::vector<uint8_t> bytes = contents(device, buffer);
    Picture pixels(size_t(WIDTH) * HEIGHT);
    std::memcpy(pixels.data(), bytes.data(), pixels.size() * 4);
    return pixels;
}

// The draw's whole VkBuffer, as the device has it.
std::vector<uint8_t> read_back(vsg::ref_ptr<vsg::Device> device, int queue_family, const vsg::Buffer &buffer) {
    auto copy = seen_by_cpu(device, buffer.size);
    auto pool = vsg::CommandPool::create(device, uint32_t(queue_family));
    vsg::submitCommandsToQueue(pool, device->getQueue(uint32_t(queue_family)), [&](vsg::CommandBuffer &commands) {
        const VkBufferCopy all{0, 0, buffer.size};
        vkCmdCopyBuffer(commands, buffer.vk(device->deviceID), copy->vk(device->deviceID), 1, &all);
    });
    vkDeviceWaitIdle(device->vk());
    return contents(device, copy);
}

void run(vsg::ref_ptr<vsg::Instance> instance, const char *hood, const char *path) {
    auto [physical, queue_family] = instance->getPhysicalDeviceAndQueueFamily(VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT);
    fact(physical && queue_family >= 0, "a device draws and computes");
    auto device = vsg::Device::create(physical, vsg::QueueSettings{vsg::QueueSetting{queue_family, {1.0f}}}, vsg::Names{},
                                      vsg::Names{});

    crumple::Context context;
    const crumple::ExampleSet examples = context.load_gltf(hood).value();
    const CrumpleExampleSetInfo about = examples.info().value();
    std::vector<CrumpleVec3> positions(about.vertex_count), normals(about.vertex_count);
    std::vector<uint32_t> indices(size_t(about.triangle_count) * 3);
    CrumpleMeshCopyDef copy = crumple_mesh_copy_def_default();
    copy.positions = crumple::stream(positions);
    copy.normals = crumple::stream(normals);
    copy.indices = crumple::stream(indices);
    examples.copy_mesh(copy).value();

    auto draw = make_draw(positions, normals, indices, 0);
    const float z = about.bounds.min.z - 0.06f;
    auto ground = make_draw({{-9, -9, z}, {9, -9, z}, {9, 9, z}, {-9, 9, z}}, std::vector<CrumpleVec3>(4, {0, 0, 1}),
                            {0, 1, 2, 0, 2, 3}, 1);
    crumple_vsg::share_one_buffer(device, *draw);
    // VSG's pools ask drivers without VK_EXT_memory_budget, such as those of this machine's processor, for a budget that they do
    // not tell; so the ground, which nobody dents, has a buffer of its own too.
    crumple_vsg::share_one_buffer(device, *ground);
    auto scene = vsg::StateGroup::create();
    scene->add(make_pipeline());
    scene->addChild(draw);
    scene->addChild(ground);

    auto camera = vsg::Camera::create(vsg::Perspective::create(24.0, double(WIDTH) / HEIGHT, 0.1, 20.0),
                                      vsg::LookAt::create(vsg::dvec3(1.15, -2.1, 1.5), vsg::dvec3(-0.01, -0.03, -0.035),
                                                          vsg::dvec3(0, 0, 1)),
                                      vsg::ViewportState::create(VkExtent2D{WIDTH, HEIGHT}));
    const Target target = make_target(device);
    auto render_graph = vsg::RenderGraph::create();
    render_graph->framebuffer = target.framebuffer;
    render_graph->renderArea = {{0, 0}, {WIDTH, HEIGHT}};
    render_graph->setClearValues({{0.75f, 0.77f, 0.79f, 1}}, VkClearDepthStencilValue{0, 0}); // VSG's depth is 1 in front
    auto view = vsg::View::create(camera, scene);
    view->viewDependentState = {}; // of lights and shadows of VSG's own shaders, which this does not use
    render_graph->addChild(view);

    auto pixels = seen_by_cpu(device, VkDeviceSize(WIDTH) * HEIGHT * 4);
    auto capture = vsg::CopyImageToBuffer::create();
    capture->srcImage = target.picture;
    capture->srcImageLayout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
    capture->dstBuffer = pixels;
    VkBufferImageCopy whole{};
    whole.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    whole.imageExtent = {WIDTH, HEIGHT, 1};
    capture->regions.push_back(whole);

    auto viewer = vsg::Viewer::create();
    auto deform = crumple_vsg::Deform::create(context, device, queue_family, viewer);
    auto command_graph = vsg::CommandGraph::create(device, queue_family);
    command_graph->addChild(deform); // before the render pass
    command_graph->addChild(render_graph);
    command_graph->addChild(capture);
    viewer->assignRecordAndSubmitTaskAndPresentation({command_graph});
    viewer->compile();
    crumple::Instance body = context.create_instance(examples).value();
    const crumple::Buffer buffer = deform->add(body, *draw);

    Picture first;
    while (viewer->advanceToNextFrame() && viewer->getFrameStamp()->frameCount < FRAMES) {
        const uint64_t frame = viewer->getFrameStamp()->frameCount;
        if (frame == 2) body.submit_displacement({-0.24f, -0.10f, 0.09f}, {0, 0, -0.036f}).value();
        if (frame == 5) body.submit_displacement({0.26f, 0.16f, 0.09f}, {0, 0, -0.028f}).value();
        viewer->handleEvents();
        viewer->update();
        viewer->recordAndSubmit(); // frames follow each other without a wait, as VSG does it: three are in flight
        const bool changed = frame == 0 || frame == 2 || frame == 5;
        fact((deform->report.dispatches == 1) == changed, "frame " + std::to_string(frame) + " records where there is a hit");
        if (frame == 0) {
            viewer->deviceWaitIdle();
            first = picture(device, pixels);
        }
    }
    viewer->deviceWaitIdle();
    const Picture last = picture(device, pixels);
    fact(write_side_by_side(path, WIDTH, first, last), std::string(path) + " was written");

    // VSG's vertex buffer holds what the CPU computes, by bits where the device rounds as IEEE 754 says. The indices in it are as
    // they were.
    const std::vector<uint8_t> seen = read_back(device, queue_family, *draw->indices->buffer);
    const crumple::Buffer on_cpu = body.register_buffer(crumple::stream(positions)).value();
    context.deform().value();
    const bool software = physical->getProperties().deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU;
    for (size_t v = 0; v < positions.size(); ++v) {
        CrumpleVec3 at;
        std::memcpy(&at, seen.data() + draw->arrays[0]->offset + v * sizeof at, sizeof at);
        const CrumpleVec3 &want = positions[v];
        const float off = std::max({std::abs(at.x - want.x), std::abs(at.y - want.y), std::abs(at.z - want.z)});
        const bool equal = std::memcmp(&at, &want, sizeof at) == 0;
        fact(equal || (!software && off < 1e-5f), "vertex " + std::to_string(v) + " is as on the CPU");
    }
    fact(std::memcmp(seen.data() + draw->indices->offset, indices.data(), indices.size() * 4) == 0, "the indices are untouched");
    size_t differ = 0;
    for (size_t i = 0; i < first.size(); ++i) differ += first[i] != last[i];
    fact(differ > 10000 && differ < first.size() / 2, std::to_string(differ) + " pixels differ, but not most of them");
    std::printf("VulkanSceneGraph %s on %s: %s, %zu pixels differ\n", vsgGetVersionString(),
                physical->getProperties().deviceName, path, differ);
}

} // namespace

int main(int argc, char **argv) {
    if (argc != 3) {
        std::fprintf(stderr, "usage: vsg_hood HOOD.glb PICTURE.png\n");
        return 2;
    }
    vsg::ref_ptr<vsg::Instance> instance;
    try {
        instance = make_instance();
        const Listener listener(instance);
        run(instance, argv[1], argv[2]);
    } catch (const crumple::Error &error) {
        std::fprintf(stderr, "%s: %s\n", crumple_result_name(error.result()), error.what());
        return 1;
    } catch (const vsg::Exception &exception) {
        std::fprintf(stderr, "%s (VkResult %d)\n", exception.message.c_str(), exception.result);
        const bool no_driver = !instance && exception.result == VK_ERROR_INCOMPATIBLE_DRIVER;
        return no_driver && !set("CRUMPLE_REQUIRE_GPU") ? 77 : 1;
    }
    fact(messages == 0, "the validation layer had nothing to say");
    return 0;
}
