// Crumple for C++17: the C interface, all its headers, with owners that clean up, and errors as exceptions.
//
//     crumple::Context context;
//     auto set = context.load_gltf("car.glb").value();
//     auto body = context.create_instance(set).value();
//     auto buffer = body.register_buffer(crumple::stream(positions), crumple::stream(normals)).value();
//     body.submit_displacement(point, displacement).value();
//     context.deform().value();
//
// Owners (Context, ExampleSet, Instance, Buffer) can be moved but not copied. They destroy what they own; release()
// gives up ownership of the id instead. A Context destroys everything in it; an owner that outlives its context does
// nothing. For the C functions, use id() of an owner and get() of a Context; this file only wraps them.
//
// Every call that can fail returns a Result. Its value() returns the call's value, or throws Error after a failure. If
// CRUMPLE_NO_EXCEPTIONS is defined, value() runs CRUMPLE_ON_ERROR(result, message) instead of throwing. That must not
// return; the default is std::abort(). Define it to log the message, or call ok() first, or use value_or(). Ignoring a
// Result is a compiler warning. The rules for threads are those of the C interface.
#ifndef CRUMPLE_HPP
#define CRUMPLE_HPP

#include "crumple_contacts.h"
#include "crumple_graph.h"
#include "crumple_host.h"
#include "crumple_import.h"
#include "crumple_parts.h"
#include "crumple_view.h"

#include <cstdlib>
#include <new>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>
#ifndef CRUMPLE_NO_EXCEPTIONS
#include <stdexcept>
#elif !defined(CRUMPLE_ON_ERROR)
#define CRUMPLE_ON_ERROR(result, message) std::abort()
#endif

namespace crumple {

static_assert(sizeof(CrumpleResult) == 4, "enums must be 32 bits wide: compile without -fshort-enums");

#ifndef CRUMPLE_NO_EXCEPTIONS
/// Thrown by Result::value(). what() is the text of crumple_last_error().
class Error : public std::runtime_error {
public:
    Error(CrumpleResult result, const std::string &message) : std::runtime_error(message), result_(result) {}
    CrumpleResult result() const noexcept { return result_; }

private:
    CrumpleResult result_;
};
#endif

/// The value of a call, or its error. T may be void.
template <class T>
class [[nodiscard]] Result {
    struct Nothing {};
    using Stored = std::conditional_t<std::is_void_v<T>, Nothing, T>;

public:
    /// Success.
    Result(Stored value = {}) : value_(std::move(value)) {}

    /// A failure, with the calling thread's last error.
    static Result failed(CrumpleResult result) { return Result(result, crumple_last_error()); }

    /// Whether the call succeeded.
    bool ok() const noexcept { return result_ == CRUMPLE_OK; }
    /// The same as ok(). Not available for Result<bool>, where it could be mistaken for the value: use ok() or value().
    explicit operator bool() const noexcept {
        static_assert(!std::is_same_v<T, bool>, "ask for ok() or for value(): this Result holds a bool");
        return ok();
    }
    CrumpleResult result() const noexcept { return result_; }

    /// The error message; empty after success.
    const std::string &message() const noexcept { return message_; }

    /// The call's value. After a failure it throws Error, or runs CRUMPLE_ON_ERROR. Owners cannot be copied: use take()
    /// if the Result is a variable.
    Stored value() && {
        require();
        return std::move(*value_);
    }
    const Stored &value() const & {
        require();
        return *value_;
    }
    /// Like value(), but moves the value out.
    Stored take() {
        require();
        return std::move(*value_);
    }
    /// The call's value, or other after a failure.
    Stored value_or(Stored other) && { return ok() ? std::move(*value_) : std::move(other); }

private:
    Result(CrumpleResult result, const char *message) : result_(result), message_(message) {}

    void require() const {
        if (ok()) return;
#ifdef CRUMPLE_NO_EXCEPTIONS
        CRUMPLE_ON_ERROR(result_, message_.c_str());
#else
        throw Error(result_, message_);
#endif
    }

    CrumpleResult result_ = CRUMPLE_OK;
    std::string message_;
    std::optional<Stored> value_;
};

namespace detail {

inline Result<void> done(CrumpleResult result) {
    return result == CRUMPLE_OK ? Result<void>() : Result<void>::failed(result);
}

/// Runs call(out) and returns the value that it wrote.
template <class T, class Call>
Result<T> get(Call &&call) {
    T out{};
    const CrumpleResult result = call(&out);
    return result == CRUMPLE_OK ? Result<T>(std::move(out)) : Result<T>::failed(result);
}

/// Gets the count, then fills a vector of that size.
template <class T, class Count, class Call>
Result<std::vector<T>> fill(Call &&call) {
    Count count = 0;
    CrumpleResult result = call(nullptr, 0, &count);
    std::vector<T> values(result == CRUMPLE_OK ? count : 0);
    if (result == CRUMPLE_OK && count != 0) result = call(values.data(), count, &count);
    return result == CRUMPLE_OK ? Result<std::vector<T>>(std::move(values)) : Result<std::vector<T>>::failed(result);
}

/// Owns an id of a context and destroys it with Destroy.
template <class Id, CrumpleResult (*Destroy)(CrumpleContext *, Id)>
class Owner {
public:
    Owner() = default;
    Owner(CrumpleContext *context, Id id) noexcept : context_(context), id_(id) {}
    Owner(Owner &&other) noexcept : context_(std::exchange(other.context_, nullptr)), id_(std::exchange(other.id_, Id{})) {}
    Owner &operator=(Owner &&other) noexcept {
        if (this != &other) {
            reset();
            context_ = std::exchange(other.context_, nullptr);
            id_ = std::exchange(other.id_, Id{});
        }
        return *this;
    }
    Owner(const Owner &) = delete;
    Owner &operator=(const Owner &) = delete;
    ~Owner() { reset(); }

    /// The id, for the C functions; null if this owns nothing.
    Id id() const noexcept { return id_; }
    CrumpleContext *context() const noexcept { return context_; }
    explicit operator bool() const noexcept { return id_.index != 0; }

    /// Gives up ownership. The caller must destroy the id.
    Id release() noexcept {
        context_ = nullptr;
        return std::exchange(id_, Id{});
    }

    /// Destroys the object now.
    void reset() noexcept {
        if (id_.index != 0) Destroy(context_, id_);
        context_ = nullptr;
        id_ = Id{};
    }

private:
    CrumpleContext *context_ = nullptr;
    Id id_{};
};

} // namespace detail

/// count elements of type T, stride bytes apart. For vertex structs, pass the address of a member and sizeof(Vertex) as
/// stride.
template <class T>
CrumpleInput input(const T *first, std::size_t count, std::size_t stride = sizeof(T)) {
    CrumpleInput in{};
    in.data = first;
    in.size = count == 0 ? 0 : (count - 1) * stride + sizeof(T);
    in.stride = stride;
    return in;
}

/// All elements of a std::vector, std::array, std::span or similar.
template <class Container, class = decltype(std::declval<const Container &>().data())>
CrumpleInput input(const Container &values) {
    return input(values.data(), values.size());
}

/// count elements of type T, stride bytes apart, to be written. T is a whole value: CrumpleVec3, float[3] or similar.
template <class T>
CrumpleStream stream(T *first, std::size_t count, std::size_t stride = sizeof(T)) {
    static_assert(!std::is_same_v<T, float>, "a value has 3 or 4 floats: give a pointer to an array of them, or a member");
    CrumpleStream out{};
    out.data = first;
    out.size = count == 0 ? 0 : (count - 1) * stride + sizeof(T);
    out.stride = stride;
    return out;
}

/// One member of each of the count vertices, to be written: stream(vertices, count, &Vertex::normal).
template <class Vertex, class Member>
CrumpleStream stream(Vertex *vertices, std::size_t count, Member Vertex::*member) {
    CrumpleStream out{};
    if (vertices == nullptr) return out;
    out.data = vertices;
    out.size = count * sizeof(Vertex);
    out.offset = static_cast<std::size_t>(reinterpret_cast<char *>(&(vertices->*member)) - reinterpret_cast<char *>(vertices));
    out.stride = sizeof(Vertex);
    return out;
}

/// All elements of a std::vector, std::array, std::span or similar, to be written. Each element is one value, such as
/// CrumpleVec3.
template <class Container, class = decltype(std::declval<Container &>().data())>
CrumpleStream stream(Container &values) {
    static_assert(sizeof(*values.data()) <= 4 * sizeof(float), "name the member: stream(vertices, &Vertex::position)");
    return stream(values.data(), values.size());
}

/// One member of each vertex in a std::vector or similar, to be written: stream(vertices, &Vertex::normal).
template <class Container, class Vertex, class Member, class = decltype(std::declval<Container &>().data())>
CrumpleStream stream(Container &vertices, Member Vertex::*member) {
    return stream(vertices.data(), vertices.size(), member);
}

/// Depth limits for a mesh whose dents must not enter these solids. See crumple_mesh_keep_out().
inline Result<std::vector<float>> keep_out(const CrumpleMeshDef &mesh, const std::vector<CrumpleCapsule> &capsules,
                                           const std::vector<CrumpleMeshDef> &meshes = {}) {
    std::vector<float> limits(mesh.vertex_count);
    const CrumpleResult result = crumple_mesh_keep_out(&mesh, capsules.data(), uint32_t(capsules.size()), meshes.data(),
                                                       uint32_t(meshes.size()), limits.data());
    return result == CRUMPLE_OK ? Result<std::vector<float>>(std::move(limits)) : Result<std::vector<float>>::failed(result);
}

/// Memory that receives an instance's vertices. Unregisters itself. See crumple_buffer_register_host().
class Buffer : public detail::Owner<CrumpleBuffer, crumple_buffer_unregister> {
public:
    using Owner::Owner;

    /// What it shows, and the numbers that it and its instance were given.
    Result<CrumpleBufferInfo> info() const {
        return detail::get<CrumpleBufferInfo>(
            [&](CrumpleBufferInfo *info) { return crumple_buffer_get_info(context(), id(), info); });
    }
    Result<void> invalidate() { return detail::done(crumple_buffer_invalidate(context(), id())); }
    Result<void> set_memory(const CrumpleHostBufferDef &def) {
        return detail::done(crumple_buffer_set_memory(context(), id(), &def));
    }
    /// The vertices written by the last deform or recording that included this buffer.
    Result<std::vector<CrumpleRange>> changes() const {
        return detail::fill<CrumpleRange, uint32_t>([&](CrumpleRange *ranges, uint32_t capacity, uint32_t *count) {
            return crumple_buffer_get_changes(context(), id(), ranges, capacity, count, nullptr);
        });
    }
    /// The triangles with such a vertex. bounds, unless null, receives a box around these vertices before and now, m.
    Result<std::vector<CrumpleRange>> changed_triangles(CrumpleAabb *bounds = nullptr) const {
        return detail::fill<CrumpleRange, uint32_t>([&](CrumpleRange *ranges, uint32_t capacity, uint32_t *count) {
            return crumple_buffer_get_changed_triangles(context(), id(), ranges, capacity, count, bounds);
        });
    }
    /// The bounds of all its vertices, m.
    Result<CrumpleAabb> bounds() const {
        uint32_t count = 0;
        return detail::get<CrumpleAabb>(
            [&](CrumpleAabb *bounds) { return crumple_buffer_get_changes(context(), id(), nullptr, 0, &count, bounds); });
    }
};

/// A body in the scene. Destroys itself. See crumple_instance_create().
class Instance : public detail::Owner<CrumpleInstance, crumple_instance_destroy> {
public:
    using Owner::Owner;

    Result<CrumpleInstanceInfo> info() const {
        return detail::get<CrumpleInstanceInfo>(
            [&](CrumpleInstanceInfo *info) { return crumple_instance_get_info(context(), id(), info); });
    }
    Result<uint64_t> user_data() const {
        return detail::get<uint64_t>(
            [&](uint64_t *user_data) { return crumple_instance_get_user_data(context(), id(), user_data); });
    }
    Result<void> set_user_data(uint64_t user_data) {
        return detail::done(crumple_instance_set_user_data(context(), id(), user_data));
    }
    /// local_to_world is 16 floats, column-major. May be called from any thread at any time.
    Result<void> set_transform(const float *local_to_world) {
        return detail::done(crumple_instance_set_transform(context(), id(), local_to_world));
    }
    /// limit in m; 0: the set's limit.
    Result<void> set_depth_limit(float limit) {
        return detail::done(crumple_instance_set_depth_limit(context(), id(), limit));
    }
    /// Chooses how finely to show the instance, and returns the level of detail to show.
    Result<uint32_t> set_view(float pixels, float distance, float fov_y, float viewport_height) {
        return detail::get<uint32_t>([&](uint32_t *lod) {
            return crumple_instance_set_view(context(), id(), pixels, distance, fov_y, viewport_height, lod);
        });
    }

    /// May be called from any thread at any time.
    Result<CrumpleHitResult> submit(const CrumpleHitDef &def) {
        return detail::get<CrumpleHitResult>(
            [&](CrumpleHitResult *out) { return crumple_instance_submit_hit(context(), id(), &def, out); });
    }
    /// Returns the result of a hit without leaving a mark. May be called from any thread at any time.
    Result<CrumpleHitResult> preview(const CrumpleHitDef &def) const {
        return detail::get<CrumpleHitResult>(
            [&](CrumpleHitResult *out) { return crumple_instance_preview_hit(context(), id(), &def, out); });
    }
    /// point in m, impulse in N s, duration in s, mass in kg (0: the set's mass), contact_id (0: none). Use submit() to
    /// describe the striker too. May be called from any thread at any time.
    Result<CrumpleHitResult> submit_impulse(CrumpleVec3 point, CrumpleVec3 impulse, float duration, float mass = 0,
                                            CrumpleSpace space = CRUMPLE_SPACE_LOCAL, uint64_t contact_id = 0) {
        CrumpleHitDef def = crumple_hit_def_default();
        def.space = space;
        def.point = point;
        def.impulse = impulse;
        def.duration = duration;
        def.mass = mass;
        def.contact_id = contact_id;
        return submit(def);
    }
    /// point and displacement in m, contact_id (0: none). May be called from any thread at any time.
    Result<CrumpleHitResult> submit_displacement(CrumpleVec3 point, CrumpleVec3 displacement,
                                                 CrumpleSpace space = CRUMPLE_SPACE_LOCAL, uint64_t contact_id = 0) {
        CrumpleHitDef def = crumple_hit_def_default();
        def.kind = CRUMPLE_HIT_KIND_DISPLACEMENT;
        def.space = space;
        def.point = point;
        def.displacement = displacement;
        def.contact_id = contact_id;
        return submit(def);
    }

    /// Ends a contact. Until then, hits with its contact_id make one dent. An id that no hit has is an error. Any thread may
    /// call this at any time.
    Result<void> end_contact(uint64_t contact_id) {
        return detail::done(crumple_instance_end_contact(context(), id(), contact_id));
    }

    /// The result of a contact, all its hits taken as one. The contact is open or among the 256 that ended last.
    Result<CrumpleHitResult> contact(uint64_t contact_id) {
        return detail::get<CrumpleHitResult>(
            [&](CrumpleHitResult *out) { return crumple_instance_get_contact(context(), id(), contact_id, out); });
    }
    Result<std::vector<CrumpleMark>> marks() const {
        return detail::fill<CrumpleMark, uint32_t>([&](CrumpleMark *marks, uint32_t capacity, uint32_t *count) {
            return crumple_instance_get_marks(context(), id(), marks, capacity, count);
        });
    }
    Result<void> set_marks(const CrumpleMark *marks, std::size_t count) {
        return detail::done(crumple_instance_set_marks(context(), id(), marks, static_cast<uint32_t>(count)));
    }
    Result<void> set_marks(const std::vector<CrumpleMark> &marks) { return set_marks(marks.data(), marks.size()); }
    Result<std::vector<unsigned char>> save() const {
        return detail::fill<unsigned char, std::size_t>([&](unsigned char *data, std::size_t capacity, std::size_t *size) {
            return crumple_instance_save_damage(context(), id(), data, capacity, size);
        });
    }
    Result<void> load(const void *data, std::size_t size) {
        return detail::done(crumple_instance_load_damage(context(), id(), data, size));
    }
    Result<void> load(const std::vector<unsigned char> &saved) { return load(saved.data(), saved.size()); }
    /// keep is the share of its depth that every dent keeps: 0 (as new) to 1 (unchanged).
    Result<void> repair(float keep) { return detail::done(crumple_instance_repair_damage(context(), id(), keep)); }
    /// Repairs dents near a point, m: one there keeps this share of its depth, those radius away keep all of it.
    Result<void> repair_around(CrumpleVec3 point, float radius, float keep) {
        return detail::done(crumple_instance_repair_around(context(), id(), point, radius, keep));
    }
    Result<void> reset_damage() { return detail::done(crumple_instance_reset_damage(context(), id())); }
    Result<void> copy_damage(CrumpleInstance source) { return detail::done(crumple_instance_copy_damage(context(), id(), source)); }

    /// Takes a part off the body: mesh part of the set. See crumple_instance_release_part().
    Result<Instance> release_part(uint32_t part) {
        CrumpleInstance released{};
        const CrumpleResult result = crumple_instance_release_part(context(), id(), part, &released);
        return result == CRUMPLE_OK ? Result<Instance>(Instance(context(), released)) : Result<Instance>::failed(result);
    }
    /// Puts a released part on the body again, or with false takes it off.
    Result<void> mount_part(const Instance &part, bool mounted = true) {
        return detail::done(crumple_instance_mount_part(context(), id(), part.id(), mounted));
    }
    /// Makes a part rigid, such as glass, or no longer.
    Result<void> set_part_rigid(uint32_t part, bool rigid) {
        return detail::done(crumple_instance_set_part_rigid(context(), id(), part, rigid));
    }
    struct PartDamage {
        float deepest; ///< m
        float mean;    ///< m
        float equivalent_depth;  ///< of the single hit that does as much damage as all marks, m
    };
    /// How far the vertices of mesh lod have moved, and what hit it.
    Result<PartDamage> measure_part(uint32_t lod) const {
        return detail::get<PartDamage>([&](PartDamage *damage) {
            return crumple_instance_measure_part(context(), id(), lod, &damage->deepest, &damage->mean, &damage->equivalent_depth);
        });
    }

    Result<CrumplePose> attached_pose(const CrumpleAttachment &attachment) const {
        return detail::get<CrumplePose>(
            [&](CrumplePose *pose) { return crumple_instance_get_attached_pose(context(), id(), &attachment, pose); });
    }

    Result<Buffer> register_buffer(const CrumpleHostBufferDef &def) {
        CrumpleBuffer buffer{};
        const CrumpleResult result = crumple_buffer_register_host(context(), id(), &def, &buffer);
        return result == CRUMPLE_OK ? Result<Buffer>(Buffer(context(), buffer)) : Result<Buffer>::failed(result);
    }
    /// Writes normals and tangents only if their streams are given.
    Result<Buffer> register_buffer(CrumpleStream positions, CrumpleStream normals = {}, CrumpleStream tangents = {}) {
        CrumpleHostBufferDef def = crumple_host_buffer_def_default();
        def.positions = positions;
        def.normals = normals;
        def.tangents = tangents;
        return register_buffer(def);
    }
    /// Registers a range of a buffer of your render graph. Context::plan_graph() plans its passes.
    Result<Buffer> register_graph_buffer(const CrumpleVulkanBufferDef &def) {
        CrumpleBuffer buffer{};
        const CrumpleResult result = crumple_buffer_register_graph(context(), id(), &def, &buffer);
        return result == CRUMPLE_OK ? Result<Buffer>(Buffer(context(), buffer)) : Result<Buffer>::failed(result);
    }
    /// Registers a range of a VkBuffer. Context::record_deform() or submit_deform() writes it.
    Result<Buffer> register_buffer(const CrumpleVulkanBufferDef &def) {
        CrumpleBuffer buffer{};
        const CrumpleResult result = crumple_buffer_register_vulkan(context(), id(), &def, &buffer);
        return result == CRUMPLE_OK ? Result<Buffer>(Buffer(context(), buffer)) : Result<Buffer>::failed(result);
    }
};

/// A base mesh and its examples. Destroys itself; instances keep the memory that they need. See
/// crumple_example_set_create().
class ExampleSet : public detail::Owner<CrumpleExampleSet, crumple_example_set_destroy> {
public:
    using Owner::Owner;

    /// The strings are valid until the set is destroyed.
    Result<CrumpleExampleSetInfo> info() const {
        return detail::get<CrumpleExampleSetInfo>(
            [&](CrumpleExampleSetInfo *info) { return crumple_example_set_get_info(context(), id(), info); });
    }
    /// Adds another mesh that shows the same damage and returns its lod number. Call it before creating the first
    /// instance.
    Result<uint32_t> add_lod(const CrumpleMeshDef &mesh) {
        return detail::get<uint32_t>(
            [&](uint32_t *lod) { return crumple_example_set_add_lod(context(), id(), &mesh, lod); });
    }
    /// The strings are valid until the set is destroyed.
    Result<CrumpleExampleInfo> example(uint32_t index) const {
        return detail::get<CrumpleExampleInfo>(
            [&](CrumpleExampleInfo *info) { return crumple_example_set_get_example(context(), id(), index, info); });
    }
    /// The strings are valid until the set is destroyed.
    Result<CrumplePrimitive> primitive(uint32_t index) const {
        return detail::get<CrumplePrimitive>(
            [&](CrumplePrimitive *primitive) { return crumple_example_set_get_primitive(context(), id(), index, primitive); });
    }
    /// Returns the bytes of a .crumple file.
    Result<std::vector<unsigned char>> save() const {
        return detail::fill<unsigned char, std::size_t>([&](unsigned char *data, std::size_t capacity, std::size_t *size) {
            return crumple_example_set_save_baked(context(), id(), data, capacity, size);
        });
    }
    /// Gives the set to another context too, without a copy.
    Result<ExampleSet> share(CrumpleContext *other) const {
        CrumpleExampleSet shared{};
        const CrumpleResult result = crumple_example_set_share(context(), id(), other, &shared);
        return result == CRUMPLE_OK ? Result<ExampleSet>(ExampleSet(other, shared)) : Result<ExampleSet>::failed(result);
    }
    Result<void> copy_mesh(const CrumpleMeshCopyDef &def) const {
        return detail::done(crumple_example_set_copy_mesh(context(), id(), &def));
    }
    struct Nearest {
        uint32_t vertex;
        float distance; ///< m
    };
    Result<Nearest> nearest_vertex(CrumpleVec3 point) const {
        return detail::get<Nearest>([&](Nearest *nearest) {
            return crumple_example_set_find_nearest_vertex(context(), id(), point, &nearest->vertex, &nearest->distance);
        });
    }
    struct MappedDamage {
        std::vector<unsigned char> bytes;
        CrumpleDamageMapping mapping;
    };
    /// Maps damage that was saved with another revision of this set. See crumple_example_set_map_damage().
    Result<MappedDamage> map_damage(CrumpleExampleSet old_set, const std::vector<unsigned char> &saved, float max_distance) const {
        CrumpleDamageMapping mapping{};
        auto bytes = detail::fill<unsigned char, std::size_t>([&](unsigned char *data, std::size_t capacity, std::size_t *size) {
            return crumple_example_set_map_damage(context(), id(), old_set, saved.data(), saved.size(), max_distance, data, capacity,
                                                  size, &mapping);
        });
        if (!bytes.ok()) return Result<MappedDamage>::failed(bytes.result());
        return MappedDamage{bytes.take(), mapping};
    }
    /// The number of a part by its name, for sets that were loaded with join_nodes.
    Result<uint32_t> find_part(const char *name) const {
        return detail::get<uint32_t>([&](uint32_t *lod) { return crumple_example_set_find_part(context(), id(), name, lod); });
    }
    /// The name, the kind and the sizes of a part of such a set: a lod from 1 on. The name is valid until the set is destroyed.
    Result<CrumplePart> part(uint32_t lod) const {
        return detail::get<CrumplePart>([&](CrumplePart *part) { return crumple_example_set_get_part(context(), id(), lod, part); });
    }
    Result<CrumpleAttachment> attach(CrumpleVec3 point) const {
        return detail::get<CrumpleAttachment>(
            [&](CrumpleAttachment *attachment) { return crumple_example_set_attach_point(context(), id(), point, attachment); });
    }
};

/// A context. Destroys itself and everything in it. See crumple_context_create().
class Context {
public:
    static Result<Context> create(const CrumpleContextDef &def = crumple_context_def_default()) {
        CrumpleContext *context = nullptr;
        const CrumpleResult result = crumple_context_create(&def, &context);
        return result == CRUMPLE_OK ? Result<Context>(Context(context)) : Result<Context>::failed(result);
    }

#ifndef CRUMPLE_NO_EXCEPTIONS
    /// Creates a context, or throws Error.
    explicit Context(const CrumpleContextDef &def = crumple_context_def_default()) : Context(create(def).value()) {}
#endif
    /// Takes ownership of a context of the C interface. May be null.
    explicit Context(CrumpleContext *context) noexcept : context_(context) {}
    Context(Context &&other) noexcept : context_(std::exchange(other.context_, nullptr)) {}
    Context &operator=(Context &&other) noexcept {
        if (this != &other) {
            reset();
            context_ = std::exchange(other.context_, nullptr);
        }
        return *this;
    }
    Context(const Context &) = delete;
    Context &operator=(const Context &) = delete;
    ~Context() { reset(); }

    /// The context for the C functions.
    CrumpleContext *get() const noexcept { return context_; }
    CrumpleContext *release() noexcept { return std::exchange(context_, nullptr); }
    /// Destroys the context now. Call complete_frames() first: with Vulkan frames in flight nothing is destroyed, and
    /// the context leaks.
    void reset() noexcept {
        if (context_ != nullptr) crumple_context_destroy(context_);
        context_ = nullptr;
    }

    Result<ExampleSet> create_example_set(const CrumpleExampleSetDef &def) {
        return own<ExampleSet, CrumpleExampleSet>(
            [&](CrumpleExampleSet *out) { return crumple_example_set_create(context_, &def, out); });
    }
    Result<ExampleSet> load_gltf(const CrumpleGltfDef &def) {
        return own<ExampleSet, CrumpleExampleSet>(
            [&](CrumpleExampleSet *out) { return crumple_example_set_load_gltf(context_, &def, out); });
    }
    /// Loads the first mesh with morph targets, with default options.
    Result<ExampleSet> load_gltf(const char *path) {
        CrumpleGltfDef def = crumple_gltf_def_default();
        def.path = path;
        return load_gltf(def);
    }
    Result<ExampleSet> load_gltf(const void *data, std::size_t size,
                                 const CrumpleGltfDef &def = crumple_gltf_def_default()) {
        return own<ExampleSet, CrumpleExampleSet>([&](CrumpleExampleSet *out) {
            return crumple_example_set_load_gltf_memory(context_, data, size, &def, out);
        });
    }
    Result<ExampleSet> load_obj(const CrumpleObjDef &def) {
        return own<ExampleSet, CrumpleExampleSet>(
            [&](CrumpleExampleSet *out) { return crumple_example_set_load_obj(context_, &def, out); });
    }

    /// Loads the bytes of a .crumple file. With CRUMPLE_BYTES_KEEP they must outlive the set and its instances.
    Result<ExampleSet> load_baked(const void *data, std::size_t size, CrumpleBytes bytes = CRUMPLE_BYTES_COPY) {
        return own<ExampleSet, CrumpleExampleSet>([&](CrumpleExampleSet *out) {
            return crumple_example_set_load_baked_memory(context_, data, size, bytes, out);
        });
    }
    Result<ExampleSet> load_baked(const char *path) {
        return own<ExampleSet, CrumpleExampleSet>(
            [&](CrumpleExampleSet *out) { return crumple_example_set_load_baked(context_, path, out); });
    }

    Result<Instance> create_instance(const CrumpleInstanceDef &def) {
        return own<Instance, CrumpleInstance>(
            [&](CrumpleInstance *out) { return crumple_instance_create(context_, &def, out); });
    }
    /// Creates an instance with default options.
    Result<Instance> create_instance(const ExampleSet &set) {
        CrumpleInstanceDef def = crumple_instance_def_default();
        def.set = set.id();
        return create_instance(def);
    }

    /// Deforms all host buffers.
    Result<CrumpleDeformReport> deform() { return deform(nullptr, 0); }
    /// Deforms some host buffers, each given once.
    Result<CrumpleDeformReport> deform(const CrumpleBuffer *buffers, std::size_t count) {
        return detail::get<CrumpleDeformReport>([&](CrumpleDeformReport *report) {
            return crumple_context_deform(context_, buffers, static_cast<uint32_t>(count), report);
        });
    }

    /// Limits how many vertices a call writes; 0: no limit.
    Result<void> set_vertex_budget(uint64_t vertices) {
        return detail::done(crumple_context_set_vertex_budget(context_, vertices));
    }
    /// The buffers that the last deform, and the last recording, wrote to, and whose they are.
    Result<std::vector<CrumpleBufferInfo>> changed_buffers() const {
        return detail::fill<CrumpleBufferInfo, uint32_t>([&](CrumpleBufferInfo *buffers, uint32_t capacity, uint32_t *count) {
            return crumple_context_get_changed_buffers(context_, buffers, capacity, count);
        });
    }
    /// Takes contact points of the current step of the physics: all or none. May be called from any thread at any time.
    Result<void> report_contacts(const CrumpleContactPointDef *points, std::size_t count) {
        return detail::done(crumple_context_report_contacts(context_, points, static_cast<uint32_t>(count)));
    }
    /// Makes hits of the points of a step that lasted so many seconds. May be called from any thread at any time.
    Result<CrumpleContactReport> step_contacts(float seconds) {
        return detail::get<CrumpleContactReport>(
            [&](CrumpleContactReport *report) { return crumple_context_step_contacts(context_, seconds, report); });
    }
    Result<void> set_contact_options(const CrumpleContactOptionsDef &options) {
        return detail::done(crumple_context_set_contact_options(context_, &options));
    }
    /// The hits that the last step brought to instances.
    Result<std::vector<CrumpleContactHit>> contact_hits() const {
        return detail::fill<CrumpleContactHit, uint32_t>([&](CrumpleContactHit *hits, uint32_t capacity, uint32_t *count) {
            return crumple_context_get_contact_hits(context_, hits, capacity, count);
        });
    }
    /// The sums of all steps' reports.
    Result<CrumpleContactReport> contact_totals() const {
        return detail::get<CrumpleContactReport>(
            [&](CrumpleContactReport *report) { return crumple_context_get_contact_totals(context_, report); });
    }
    /// Ends all touches and forgets the points that wait.
    Result<void> clear_contacts() { return detail::done(crumple_context_clear_contacts(context_)); }

    /// Submits each hit to the instance at the same index: all or none. May be called from any thread at any time.
    Result<std::vector<CrumpleHitResult>> submit(const CrumpleInstance *instances, const CrumpleHitDef *defs,
                                                 std::size_t count) {
        std::vector<CrumpleHitResult> results(count);
        const CrumpleResult result =
            crumple_context_submit_hits(context_, instances, defs, static_cast<uint32_t>(count), results.data());
        return submitted(result, std::move(results));
    }
    /// Saves the damage of these instances, or of all, as one piece of bytes.
    Result<std::vector<unsigned char>> save_damage(const CrumpleInstance *instances = nullptr, std::size_t count = 0) const {
        return detail::fill<unsigned char, std::size_t>([&](unsigned char *data, std::size_t capacity, std::size_t *size) {
            return crumple_context_save_damage(context_, instances, static_cast<uint32_t>(count), data, capacity, size);
        });
    }
    /// Replaces the damage of as many instances of the same sets, in the same order.
    Result<void> load_damage(const std::vector<unsigned char> &saved, const CrumpleInstance *instances = nullptr,
                             std::size_t count = 0) {
        return detail::done(crumple_context_load_damage(context_, instances, static_cast<uint32_t>(count), saved.data(),
                                                        saved.size()));
    }
    /// Sets the time, s, for instances with a grow_time. Call it once a frame before deform().
    Result<void> set_time(double time) { return detail::done(crumple_context_set_time(context_, time)); }

    Result<void> attach_vulkan(const CrumpleVulkanAttachDef &def) {
        return detail::done(crumple_vulkan_attach(context_, &def));
    }
    /// Creates a Vulkan device of Crumple's own, for sharing memory.
    Result<void> open_vulkan(const CrumpleVulkanOpenDef &def) { return detail::done(crumple_vulkan_open(context_, &def)); }
    Result<void> detach_vulkan() { return detail::done(crumple_vulkan_detach(context_)); }
    Result<std::vector<unsigned char>> vulkan_pipeline_cache() {
        return detail::fill<unsigned char, std::size_t>([&](unsigned char *data, std::size_t capacity, std::size_t *size) {
            return crumple_vulkan_get_pipeline_cache(context_, data, capacity, size);
        });
    }
    /// Records all Vulkan buffers into a VkCommandBuffer.
    Result<CrumpleRecordReport> record_deform(void *command_buffer, uint64_t frame) {
        return record_deform(command_buffer, frame, nullptr, 0);
    }
    /// Records some Vulkan buffers, each given once.
    Result<CrumpleRecordReport> record_deform(void *command_buffer, uint64_t frame, const CrumpleBuffer *buffers,
                                              std::size_t count) {
        return detail::get<CrumpleRecordReport>([&](CrumpleRecordReport *report) {
            return crumple_vulkan_record(context_, command_buffer, frame, buffers, static_cast<uint32_t>(count), report);
        });
    }
    Result<void> complete_frames(uint64_t frame) { return detail::done(crumple_vulkan_complete_frames(context_, frame)); }
    Result<void> discard_frames(uint64_t frame) { return detail::done(crumple_vulkan_discard_frames(context_, frame)); }

    /// Plans the passes of all graph buffers.
    Result<CrumpleGraphPlan> plan_graph(CrumpleRecordReport *report = nullptr) {
        return detail::get<CrumpleGraphPlan>(
            [&](CrumpleGraphPlan *plan) { return crumple_graph_plan(context_, nullptr, 0, plan, report); });
    }
    /// Returns the SPIR-V of a kernel that a dispatch names.
    static Result<std::vector<unsigned char>> graph_kernel(uint32_t kernel) {
        return detail::fill<unsigned char, std::size_t>([&](unsigned char *data, std::size_t capacity, std::size_t *size) {
            return crumple_graph_get_kernel(kernel, data, capacity, size);
        });
    }

    Result<uint64_t> import_vulkan_buffer(const CrumpleVulkanImportDef &def) {
        return detail::get<uint64_t>(
            [&](uint64_t *buffer) { return crumple_vulkan_import_buffer(context_, &def, buffer); });
    }
    Result<void> unimport_vulkan_buffer(uint64_t buffer) {
        return detail::done(crumple_vulkan_unimport_buffer(context_, buffer));
    }
    Result<uint64_t> import_vulkan_semaphore(CrumpleHandleType type, int64_t handle) {
        return detail::get<uint64_t>(
            [&](uint64_t *semaphore) { return crumple_vulkan_import_semaphore(context_, type, handle, semaphore); });
    }
    /// Submits all Vulkan buffers to Crumple's own device. Returns the frame number.
    Result<uint64_t> submit_deform(const std::vector<uint64_t> &waits = {}, const std::vector<uint64_t> &signals = {},
                                   CrumpleRecordReport *report = nullptr) {
        return detail::get<uint64_t>([&](uint64_t *frame) {
            return crumple_vulkan_submit(context_, nullptr, 0, waits.data(), static_cast<uint32_t>(waits.size()),
                                         signals.data(), static_cast<uint32_t>(signals.size()), frame, report);
        });
    }
    /// Returns whether the device completed the frame within timeout nanoseconds. That is value(), not ok().
    Result<bool> wait_frame(uint64_t frame, uint64_t timeout = UINT64_MAX) {
        return detail::get<bool>([&](bool *done) { return crumple_vulkan_wait_frame(context_, frame, timeout, done); });
    }

private:
    static Result<std::vector<CrumpleHitResult>> submitted(CrumpleResult result, std::vector<CrumpleHitResult> &&results) {
        using Results = Result<std::vector<CrumpleHitResult>>;
        return result == CRUMPLE_OK ? Results(std::move(results)) : Results::failed(result);
    }

    template <class Handle, class Id, class Call>
    Result<Handle> own(Call &&call) {
        Id id{};
        const CrumpleResult result = call(&id);
        return result == CRUMPLE_OK ? Result<Handle>(Handle(context_, id)) : Result<Handle>::failed(result);
    }

    CrumpleContext *context_ = nullptr;
};

} // namespace crumple

#endif // CRUMPLE_HPP
