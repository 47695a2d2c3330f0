// Draws from the vertex buffer that Crumple writes: a hood before and after two hits, side by side in a PNG.
//
//     vulkan_render HOOD.glb PICTURE.png        CRUMPLE_VALIDATION=1 enables the Khronos validation layer
//
// vulkan_record.c explains the calls. This program uses them with a render pass and a typical vertex format: positions are
// floats, normals are 16-bit integers. The buffer holds the hood and the ground below it.
#include "side_by_side.hpp"
#include "vulkan_host.h"

#include "shaders/hood.frag.h"
#include "shaders/hood.vert.h"

#include <crumple.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

namespace {

constexpr uint32_t WIDTH = 640, HEIGHT = 400; // pixels
constexpr VkSampleCountFlagBits SAMPLES = VK_SAMPLE_COUNT_4_BIT;
constexpr VkFormat COLOUR = VK_FORMAT_R8G8B8A8_SRGB, DEPTH = VK_FORMAT_D32_SFLOAT;

struct Vertex {
    CrumpleVec3 position; // m
    int16_t normal[4];    // 32767 means 1; the last is 0 for the hood and 1 for the ground
};

using Matrix = std::array<float, 16>; // column-major
struct Camera {
    Matrix projection, model_view;
};

void fact(bool holds, const std::string &what) {
    if (holds) return;
    std::fprintf(stderr, "this is not so: %s\n", what.c_str());
    std::exit(1);
}

template <class Info>
Info info(VkStructureType type) {
    Info made{};
    made.sType = type;
    return made;
}

CrumpleVec3 operator-(const CrumpleVec3 &a, const CrumpleVec3 &b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
float dot(const CrumpleVec3 &a, const CrumpleVec3 &b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
CrumpleVec3 cross(const CrumpleVec3 &a, const CrumpleVec3 &b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
CrumpleVec3 unit(const CrumpleVec3 &a) {
    const float length = std::sqrt(dot(a, a));
    return {a.x / length, a.y / length, a.z / length};
}

Camera camera(const CrumpleVec3 &eye, const CrumpleVec3 &target) {
    const CrumpleVec3 back = unit(eye - target), right = unit(cross({0, 0, 1}, back)), up = cross(back, right);
    const float near = 0.1f, far = 20, focal = 4.7f, aspect = float(WIDTH) / float(HEIGHT);
    // In Vulkan, y points down and depth goes from 0 to 1.
    return {{focal / aspect, 0, 0, 0, 0, -focal, 0, 0, 0, 0, far / (near - far), -1, 0, 0, near * far / (near - far), 0},
            {right.x, up.x, back.x, 0, right.y, up.y, back.y, 0, right.z, up.z, back.z, 0, -dot(right, eye), -dot(up, eye),
             -dot(back, eye), 1}};
}

// The position of a point on the screen, pixels.
std::array<float, 2> seen_at(const Camera &camera, const CrumpleVec3 &p) {
    const auto times = [](const Matrix &m, const std::array<float, 4> &v) {
        std::array<float, 4> r{};
        for (size_t row = 0; row < 4; ++row)
            for (size_t column = 0; column < 4; ++column) r[row] += m[4 * column + row] * v[column];
        return r;
    };
    const auto clip = times(camera.projection, times(camera.model_view, {p.x, p.y, p.z, 1}));
    return {(clip[0] / clip[3] * 0.5f + 0.5f) * WIDTH, (clip[1] / clip[3] * 0.5f + 0.5f) * HEIGHT};
}

// The engine's renderer: one render pass with one pipeline, which draws into an image.
class Renderer {
public:
    explicit Renderer(const Host &host_) : host(host_) {
        colour = image(COLOUR, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT, SAMPLES, VK_IMAGE_ASPECT_COLOR_BIT);
        depth = image(DEPTH, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT, SAMPLES, VK_IMAGE_ASPECT_DEPTH_BIT);
        resolved = image(COLOUR, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT, VK_SAMPLE_COUNT_1_BIT,
                         VK_IMAGE_ASPECT_COLOR_BIT);
        read_back = host_buffer(&host, WIDTH * HEIGHT * 4, VK_BUFFER_USAGE_TRANSFER_DST_BIT, true);
        make_pass();
        make_pipeline();
    }
    ~Renderer() {
        vkDestroyPipeline(host.device, pipeline, nullptr);
        vkDestroyPipelineLayout(host.device, layout, nullptr);
        vkDestroyFramebuffer(host.device, framebuffer, nullptr);
        vkDestroyRenderPass(host.device, pass, nullptr);
        for (Image *each : {&colour, &depth, &resolved}) {
            vkDestroyImageView(host.device, each->view, nullptr);
            vkDestroyImage(host.device, each->image, nullptr);
            vkFreeMemory(host.device, each->memory, nullptr);
        }
        host_destroy_buffer(&host, &read_back);
    }
    Renderer(const Renderer &) = delete;
    Renderer &operator=(const Renderer &) = delete;

    void draw(VkCommandBuffer commands, const Camera &camera, VkBuffer vertices, VkBuffer indices, uint32_t count) const {
        std::array<VkClearValue, 2> clear{};
        clear[0].color = {{0.75f, 0.77f, 0.79f, 1}};
        clear[1].depthStencil = {1, 0};
        auto begin = info<VkRenderPassBeginInfo>(VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO);
        begin.renderPass = pass;
        begin.framebuffer = framebuffer;
        begin.renderArea.extent = {WIDTH, HEIGHT};
        begin.clearValueCount = uint32_t(clear.size());
        begin.pClearValues = clear.data();
        const VkDeviceSize none = 0;
        vkCmdBeginRenderPass(commands, &begin, VK_SUBPASS_CONTENTS_INLINE);
        vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline);
        vkCmdPushConstants(commands, layout, VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof camera, &camera);
        vkCmdBindVertexBuffers(commands, 0, 1, &vertices, &none);
        vkCmdBindIndexBuffer(commands, indices, 0, VK_INDEX_TYPE_UINT32);
        vkCmdDrawIndexed(commands, count, 1, 0, 0, 0);
        vkCmdEndRenderPass(commands);
        VkBufferImageCopy whole{};
        whole.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
        whole.imageExtent = {WIDTH, HEIGHT, 1};
        vkCmdCopyImageToBuffer(commands, resolved.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, read_back.buffer, 1, &whole);
    }

    // Call this when the device has finished drawing.
    Picture picture() const {
        Picture pixels(size_t(WIDTH) * HEIGHT);
        std::memcpy(pixels.data(), read_back.data, pixels.size() * 4);
        return pixels;
    }

private:
    struct Image {
        VkImage image;
        VkDeviceMemory memory;
        VkImageView view;
    };

    Image image(VkFormat format, VkImageUsageFlags usage, VkSampleCountFlagBits samples, VkImageAspectFlags aspect) const {
        Image made{};
        auto create = info<VkImageCreateInfo>(VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO);
        create.imageType = VK_IMAGE_TYPE_2D;
        create.format = format;
        create.extent = {WIDTH, HEIGHT, 1};
        create.mipLevels = create.arrayLayers = 1;
        create.samples = samples;
        create.usage = usage;
        VK(vkCreateImage(host.device, &create, nullptr, &made.image));
        VkMemoryRequirements needs;
        vkGetImageMemoryRequirements(host.device, made.image, &needs);
        auto allocate = info<VkMemoryAllocateInfo>(VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO);
        allocate.allocationSize = needs.size;
        allocate.memoryTypeIndex = host_memory_type(&host, needs.memoryTypeBits, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
        VK(vkAllocateMemory(host.device, &allocate, nullptr, &made.memory));
        VK(vkBindImageMemory(host.device, made.image, made.memory, 0));
        auto view = info<VkImageViewCreateInfo>(VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO);
        view.image = made.image;
        view.viewType = VK_IMAGE_VIEW_TYPE_2D;
        view.format = format;
        view.subresourceRange = {aspect, 0, 1, 0, 1};
        VK(vkCreateImageView(host.device, &view, nullptr, &made.view));
        return made;
    }

    void make_pass() {
        std::array<VkAttachmentDescription, 3> attachments{};
        for (auto &each : attachments) {
            each.format = COLOUR;
            each.samples = SAMPLES;
            each.loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR;
            each.storeOp = VK_ATTACHMENT_STORE_OP_DONT_CARE;
            each.finalLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
        }
        attachments[1].format = DEPTH;
        attachments[1].finalLayout = VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
        attachments[2].samples = VK_SAMPLE_COUNT_1_BIT;
        attachments[2].loadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE;
        attachments[2].storeOp = VK_ATTACHMENT_STORE_OP_STORE;
        attachments[2].finalLayout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
        const VkAttachmentReference to_colour{0, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
        const VkAttachmentReference to_depth{1, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL};
        const VkAttachmentReference to_resolved{2, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
        VkSubpassDescription subpass{};
        subpass.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS;
        subpass.colorAttachmentCount = 1;
        subpass.pColorAttachments = &to_colour;
        subpass.pResolveAttachments = &to_resolved;
        subpass.pDepthStencilAttachment = &to_depth;
        const VkPipelineStageFlags written = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT |
                                             VK_PIPELINE_STAGE_EARLY_FRAGMENT_TESTS_BIT |
                                             VK_PIPELINE_STAGE_LATE_FRAGMENT_TESTS_BIT;
        const VkAccessFlags writes = VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
        const std::array<VkSubpassDependency, 2> dependencies{
            {{VK_SUBPASS_EXTERNAL, 0, written | VK_PIPELINE_STAGE_TRANSFER_BIT, written, writes | VK_ACCESS_TRANSFER_READ_BIT,
              writes | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_READ_BIT, 0},
             {0, VK_SUBPASS_EXTERNAL, VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT,
              VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT, VK_ACCESS_TRANSFER_READ_BIT, 0}}};
        auto create = info<VkRenderPassCreateInfo>(VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO);
        create.attachmentCount = uint32_t(attachments.size());
        create.pAttachments = attachments.data();
        create.subpassCount = 1;
        create.pSubpasses = &subpass;
        create.dependencyCount = uint32_t(dependencies.size());
        create.pDependencies = dependencies.data();
        VK(vkCreateRenderPass(host.device, &create, nullptr, &pass));
        const std::array<VkImageView, 3> views{colour.view, depth.view, resolved.view};
        auto frame = info<VkFramebufferCreateInfo>(VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO);
        frame.renderPass = pass;
        frame.attachmentCount = uint32_t(views.size());
        frame.pAttachments = views.data();
        frame.width = WIDTH;
        frame.height = HEIGHT;
        frame.layers = 1;
        VK(vkCreateFramebuffer(host.device, &frame, nullptr, &framebuffer));
    }

    VkPipelineShaderStageCreateInfo shader(const uint32_t *code, size_t bytes, VkShaderStageFlagBits which) const {
        auto create = info<VkShaderModuleCreateInfo>(VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO);
        create.codeSize = bytes;
        create.pCode = code;
        auto stage = info<VkPipelineShaderStageCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO);
        stage.stage = which;
        stage.pName = "main";
        VK(vkCreateShaderModule(host.device, &create, nullptr, &stage.module));
        return stage;
    }

    void make_pipeline() {
        const VkPushConstantRange pushed{VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof(Camera)};
        auto create_layout = info<VkPipelineLayoutCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO);
        create_layout.pushConstantRangeCount = 1;
        create_layout.pPushConstantRanges = &pushed;
        VK(vkCreatePipelineLayout(host.device, &create_layout, nullptr, &layout));
        const std::array<VkPipelineShaderStageCreateInfo, 2> stages{
            shader(hood_vert, sizeof hood_vert, VK_SHADER_STAGE_VERTEX_BIT),
            shader(hood_frag, sizeof hood_frag, VK_SHADER_STAGE_FRAGMENT_BIT)};
        const VkVertexInputBindingDescription binding{0, sizeof(Vertex), VK_VERTEX_INPUT_RATE_VERTEX};
        const std::array<VkVertexInputAttributeDescription, 2> attributes{
            {{0, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(Vertex, position)},
             {1, 0, VK_FORMAT_R16G16B16A16_SNORM, offsetof(Vertex, normal)}}};
        auto input = info<VkPipelineVertexInputStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO);
        input.vertexBindingDescriptionCount = 1;
        input.pVertexBindingDescriptions = &binding;
        input.vertexAttributeDescriptionCount = uint32_t(attributes.size());
        input.pVertexAttributeDescriptions = attributes.data();
        auto assembly =
            info<VkPipelineInputAssemblyStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO);
        assembly.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
        const VkViewport viewport{0, 0, WIDTH, HEIGHT, 0, 1};
        const VkRect2D scissor{{0, 0}, {WIDTH, HEIGHT}};
        auto view = info<VkPipelineViewportStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO);
        view.viewportCount = view.scissorCount = 1;
        view.pViewports = &viewport;
        view.pScissors = &scissor;
        auto raster = info<VkPipelineRasterizationStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO);
        raster.lineWidth = 1;
        auto samples = info<VkPipelineMultisampleStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO);
        samples.rasterizationSamples = SAMPLES;
        auto test = info<VkPipelineDepthStencilStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO);
        test.depthTestEnable = test.depthWriteEnable = VK_TRUE;
        test.depthCompareOp = VK_COMPARE_OP_LESS;
        VkPipelineColorBlendAttachmentState opaque{};
        opaque.colorWriteMask = 0xF;
        auto blend = info<VkPipelineColorBlendStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO);
        blend.attachmentCount = 1;
        blend.pAttachments = &opaque;
        auto create = info<VkGraphicsPipelineCreateInfo>(VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO);
        create.stageCount = uint32_t(stages.size());
        create.pStages = stages.data();
        create.pVertexInputState = &input;
        create.pInputAssemblyState = &assembly;
        create.pViewportState = &view;
        create.pRasterizationState = &raster;
        create.pMultisampleState = &samples;
        create.pDepthStencilState = &test;
        create.pColorBlendState = &blend;
        create.layout = layout;
        create.renderPass = pass;
        VK(vkCreateGraphicsPipelines(host.device, VK_NULL_HANDLE, 1, &create, nullptr, &pipeline));
        for (const auto &stage : stages) vkDestroyShaderModule(host.device, stage.module, nullptr);
    }

    const Host &host;
    Image colour{}, depth{}, resolved{};
    HostBuffer read_back{};
    VkRenderPass pass{};
    VkFramebuffer framebuffer{};
    VkPipelineLayout layout{};
    VkPipeline pipeline{};
};

// The hood, and a square of ground behind it in the same buffers.
struct Scene {
    std::vector<Vertex> vertices;
    std::vector<uint32_t> indices;
    uint32_t hood_vertices;
};

Scene load(const crumple::ExampleSet &set) {
    const CrumpleExampleSetInfo about = set.info().value();
    std::vector<CrumpleVec3> positions(about.vertex_count), normals(about.vertex_count);
    Scene scene{{}, std::vector<uint32_t>(size_t(about.triangle_count) * 3), about.vertex_count};
    CrumpleMeshCopyDef copy = crumple_mesh_copy_def_default();
    copy.positions = crumple::stream(positions);
    copy.normals = crumple::stream(normals);
    copy.indices = crumple::stream(scene.indices);
    set.copy_mesh(copy).value();
    const auto snorm = [](float x) { return int16_t(std::lround(x * 32767)); };
    for (size_t v = 0; v < positions.size(); ++v)
        scene.vertices.push_back({positions[v], {snorm(normals[v].x), snorm(normals[v].y), snorm(normals[v].z), 0}});
    for (const auto &corner : {std::array<float, 2>{-1, -1}, {1, -1}, {1, 1}, {-1, 1}})
        scene.vertices.push_back({{9 * corner[0], 9 * corner[1], about.bounds.min.z - 0.06f}, {0, 0, 32767, 32767}});
    for (const uint32_t corner : {0u, 1u, 2u, 0u, 2u, 3u}) scene.indices.push_back(scene.hood_vertices + corner);
    return scene;
}

// Creates a buffer in device-local memory with these contents.
template <class T>
HostBuffer upload(const Host &host, const std::vector<T> &values, VkBufferUsageFlags usage) {
    const VkDeviceSize size = values.size() * sizeof(T);
    HostBuffer staging = host_buffer(&host, size, VK_BUFFER_USAGE_TRANSFER_SRC_BIT, true);
    HostBuffer buffer = host_buffer(&host, size, usage | VK_BUFFER_USAGE_TRANSFER_DST_BIT, false);
    std::memcpy(staging.data, values.data(), size);
    const VkBufferCopy all{0, 0, size};
    VkCommandBuffer commands = host_begin(&host);
    vkCmdCopyBuffer(commands, staging.buffer, buffer.buffer, 1, &all);
    host_barrier(commands);
    host_run(&host, commands);
    host_destroy_buffer(&host, &staging);
    return buffer;
}

// The pixels that triangles with a changed vertex may cover before or after the change, with a margin of one pixel.
std::vector<bool> touched(const Camera &camera, const Scene &scene, const std::vector<Vertex> &now) {
    std::vector<bool> mask(size_t(WIDTH) * HEIGHT);
    for (size_t i = 0; i < scene.indices.size(); i += 3) {
        bool changed = false;
        std::array<float, 2> low{WIDTH, HEIGHT}, high{0, 0};
        for (size_t k = i; k < i + 3; ++k) {
            const size_t v = scene.indices[k];
            changed |= std::memcmp(&scene.vertices[v], &now[v], sizeof(Vertex)) != 0;
            for (const auto &at : {seen_at(camera, scene.vertices[v].position), seen_at(camera, now[v].position)})
                for (size_t axis = 0; axis < 2; ++axis)
                    low[axis] = std::min(low[axis], at[axis]), high[axis] = std::max(high[axis], at[axis]);
        }
        if (!changed) continue;
        const auto clamped = [](float x, uint32_t end) { return uint32_t(std::clamp(x, 0.0f, float(end - 1))); };
        for (uint32_t y = clamped(low[1] - 1, HEIGHT); y <= clamped(high[1] + 1, HEIGHT); ++y)
            for (uint32_t x = clamped(low[0] - 1, WIDTH); x <= clamped(high[0] + 1, WIDTH); ++x) mask[y * WIDTH + x] = true;
    }
    return mask;
}

void run(Host &host, const char *hood, const char *path) {
    crumple::Context context;
    const crumple::ExampleSet set = context.load_gltf(hood).value();
    const Scene scene = load(set);
    HostBuffer vertices = upload(host, scene.vertices,
                                 VK_BUFFER_USAGE_VERTEX_BUFFER_BIT | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |
                                     VK_BUFFER_USAGE_TRANSFER_SRC_BIT);
    HostBuffer indices = upload(host, scene.indices, VK_BUFFER_USAGE_INDEX_BUFFER_BIT);
    HostBuffer read_back = host_buffer(&host, vertices.size, VK_BUFFER_USAGE_TRANSFER_DST_BIT, true);

    CrumpleVulkanAttachDef vulkan = crumple_vulkan_attach_def_default();
    vulkan.get_instance_proc_addr = reinterpret_cast<CrumpleVulkanFunction>(vkGetInstanceProcAddr);
    vulkan.instance = host.instance;
    vulkan.physical_device = host.physical_device;
    vulkan.device = host.device;
    vulkan.queue_family = host.queue_family;
    context.attach_vulkan(vulkan).value();

    crumple::Instance body = context.create_instance(set).value();
    CrumpleVulkanBufferDef def = crumple_vulkan_buffer_def_default();
    def.buffer = (uint64_t)vertices.buffer; // the handle is a pointer or an integer, depending on the platform
    def.buffer_size = vertices.size;
    def.usage = vertices.usage;
    def.size = scene.hood_vertices * sizeof(Vertex);
    def.positions = {offsetof(Vertex, position), sizeof(Vertex), VK_FORMAT_R32G32B32_SFLOAT, 0};
    def.normals = {offsetof(Vertex, normal), sizeof(Vertex), VK_FORMAT_R16G16B16A16_SNORM, 0};
    // Draws fetch vertices from the buffer, which is the default. This program also copies it, to check it.
    def.before_stages |= VK_PIPELINE_STAGE_TRANSFER_BIT;
    def.before_access |= VK_ACCESS_TRANSFER_READ_BIT;
    def.after_stages |= VK_PIPELINE_STAGE_TRANSFER_BIT;
    def.after_access |= VK_ACCESS_TRANSFER_READ_BIT;
    const crumple::Buffer buffer = body.register_buffer(def).value();

    // The same vertices on the CPU, for comparison.
    std::vector<CrumpleVec3> positions(scene.hood_vertices);
    const crumple::Buffer on_cpu = body.register_buffer(crumple::stream(positions)).value();

    const Camera view = camera({-1.15f, -2.1f, 1.5f}, {0.01f, -0.03f, -0.035f});
    const Renderer renderer(host);
    std::vector<Vertex> now(scene.vertices.size());
    const auto frame = [&](uint64_t number) {
        VkCommandBuffer commands = host_begin(&host);
        context.record_deform(commands, number).value();
        renderer.draw(commands, view, vertices.buffer, indices.buffer, uint32_t(scene.indices.size()));
        const VkBufferCopy all{0, 0, vertices.size};
        vkCmdCopyBuffer(commands, vertices.buffer, read_back.buffer, 1, &all);
        host_barrier(commands);
        host_run(&host, commands); // this waits: a program that draws two pictures needs no frames in flight
        context.complete_frames(number).value();
        std::memcpy(now.data(), read_back.data, vertices.size);
        return renderer.picture();
    };

    const Picture before = frame(1);
    const CrumpleHitResult first = body.submit_displacement({0.24f, -0.10f, 0.09f}, {0, 0, -0.036f}).value();
    const CrumpleHitResult second = body.submit_displacement({-0.26f, 0.16f, 0.09f}, {0, 0, -0.028f}).value();
    const Picture after = frame(2);
    fact(write_side_by_side(path, WIDTH, before, after), std::string(path) + " was written");

    // The vertices equal the CPU's, bit for bit if the device rounds as IEEE 754 requires. The ground is unchanged.
    context.deform().value();
    for (uint32_t v = 0; v < scene.hood_vertices; ++v) {
        const CrumpleVec3 off = now[v].position - positions[v];
        const bool equal = std::memcmp(&now[v].position, &positions[v], sizeof off) == 0;
        fact(equal || (!host.software && dot(off, off) < 1e-10f), "vertex " + std::to_string(v) + " is as on the CPU");
    }
    const size_t hood_bytes = scene.hood_vertices * sizeof(Vertex);
    const Vertex *ground = scene.vertices.data() + scene.hood_vertices;
    fact(std::memcmp(now.data() + scene.hood_vertices, ground, vertices.size - hood_bytes) == 0,
         "what lies behind the hood in the vertex buffer is untouched");

    // The pictures differ only where the dents are.
    const std::vector<bool> mask = touched(view, scene, now);
    size_t differ = 0, inside = 0;
    for (size_t i = 0; i < mask.size(); ++i) {
        const bool other = before[i] != after[i];
        fact(mask[i] || !other, "pixel " + std::to_string(i) + " differs, but nothing moved there");
        differ += other;
        inside += mask[i];
    }
    fact(differ > 10000, std::to_string(differ) + " pixels differ, more than 10000");
    fact(inside < mask.size() / 2, "more than half of the picture shows nothing that moved");
    for (const CrumpleHitResult *hit : {&first, &second}) {
        const auto at = seen_at(view, now[hit->contact_vertex].position);
        int strongest = 0;
        for (int y = int(at[1]) - 30; y <= int(at[1]) + 30; ++y)
            for (int x = int(at[0]) - 30; x <= int(at[0]) + 30; ++x) {
                const size_t i = size_t(y) * WIDTH + size_t(x);
                strongest = std::max(strongest, std::abs(int(before[i][1]) - int(after[i][1])));
            }
        fact(strongest > 40, "the dent at vertex " + std::to_string(hit->contact_vertex) + " is seen");
    }
    std::printf("%s: %s; %zu of %zu pixels differ, all of them where vertices moved\n", host.name, path, differ, mask.size());
    context.reset(); // before the buffers and the device
    host_destroy_buffer(&host, &vertices);
    host_destroy_buffer(&host, &indices);
    host_destroy_buffer(&host, &read_back);
}

} // namespace

int main(int argc, char **argv) {
    if (argc != 3) {
        std::fprintf(stderr, "usage: vulkan_render HOOD.glb PICTURE.png\n");
        return 2;
    }
    Host host;
    host_open(&host);
    try {
        run(host, argv[1], argv[2]);
    } catch (const crumple::Error &error) {
        std::fprintf(stderr, "%s: %s\n", crumple_result_name(error.result()), error.what());
        return 1;
    }
    host_close(&host);
    return 0;
}
