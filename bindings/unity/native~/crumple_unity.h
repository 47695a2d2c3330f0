// Crumple in Unity's Vulkan renderer: the few calls that the C# component makes beside those of crumple.h.
//
// Unity loads this library, crumple_unity, and tells it of its Vulkan device. It finds the library crumple in the same folder,
// the very file that C# calls too, so that contexts, instances and hits are the same on both sides.
//
//   crumple_unity_device()           is there a Vulkan device? if not, why not
//   crumple_unity_add_context()      a context whose instances are to be deformed on the device
//   crumple_unity_register_buffer()  a mesh's vertex buffer, by GraphicsBuffer.GetNativeBufferPtr()
//   crumple_unity_want()             bring it up to date at the next event; nothing else records
//   crumple_unity_event()            what CommandBuffer.IssuePluginEvent() takes, while crumple_unity_pending() is above 0
//   crumple_unity_buffer_info()      what became of it
//
// Threads. Every function may be called from any thread. Unity's render thread runs the event while the main thread may be inside
// the same context, and two threads must not be (crumple.h, "Threads"). So the main thread puts its calls between
// crumple_unity_lock() and crumple_unity_unlock(); crumple_instance_submit_hit() and crumple_instance_end_contact() need no lock.
// The main thread waits for at most one recording of its context. The render thread never waits for the main thread: the buffers
// of a locked context stay wanted, and the next event records them. Only the end of a device (and UnityPluginUnload) waits for
// the lock, so call nothing of Unity's while you hold it.
//
// Frames. Unity's own counters tell which frames the device is done with; what belongs to earlier ones is kept until then.
//
// Results are those of crumple.h. After anything but CRUMPLE_OK nothing has changed, and crumple_unity_last_error() tells what
// was wrong and what would be right. Nothing here throws, prints or ends the program.
#ifndef CRUMPLE_UNITY_H
#define CRUMPLE_UNITY_H

#include <crumple.h>

#if defined(_WIN32)
#define CRUMPLE_UNITY_CALL __stdcall
#define CRUMPLE_UNITY_API __declspec(dllexport)
#else
#define CRUMPLE_UNITY_CALL
#define CRUMPLE_UNITY_API __attribute__((visibility("default")))
#endif

#ifdef __cplusplus
extern "C" {
#endif

/// Where one attribute lies in the vertex buffer. dimension 0: it has none.
typedef struct {
    /// UnityEngine.Rendering.VertexAttributeFormat, as number.
    int32_t format;
    /// Numbers a value: Mesh.GetVertexAttributeDimension().
    int32_t dimension;
    /// Bytes from a vertex's begin: Mesh.GetVertexAttributeOffset().
    int32_t offset;
} CrumpleUnityAttribute;

/// A mesh's vertex buffer. Positions may be Float32 x 3 or Float16 x 4, normals Float32 x 3, SNorm16 x 4 or SNorm8 x 4,
/// tangents Float32 x 4, SNorm16 x 4 or SNorm8 x 4. All of them lie in this one vertex stream.
typedef struct {
    /// Whose damage.
    CrumpleInstance instance;
    /// GraphicsBuffer.GetNativeBufferPtr() of Mesh.GetVertexBuffer(), with GraphicsBuffer.Target.Raw in Mesh.vertexBufferTarget.
    /// Must stay until the buffer is unregistered.
    void *native_buffer;
    /// The mesh of the example set that it shows: 0 the base mesh, else a number from crumple_example_set_add_lod().
    uint32_t lod;
    /// Mesh.vertexCount; that of the lod.
    uint32_t vertex_count;
    /// Mesh.GetVertexBufferStride(), bytes.
    uint32_t stride;
    CrumpleUnityAttribute position, normal, tangent;
} CrumpleUnityBufferDef;

/// What became of a buffer.
typedef struct {
    /// How often it was recorded.
    uint64_t recordings;
    /// A box around its vertices after the last recording, m; may be too large, never too small.
    CrumpleAabb bounds;
} CrumpleUnityBufferInfo;

/// CommandBuffer.IssuePluginEvent() takes it.
typedef void(CRUMPLE_UNITY_CALL *CrumpleUnityEvent)(int event_id);

/// The version of crumple.h that this library was compiled with, as crumple_version() counts. Never fails.
CRUMPLE_UNITY_API uint32_t crumple_unity_version(void);

/// What was wrong in the calling thread's last failed call. Never null; valid until the thread's next failed call.
CRUMPLE_UNITY_API const char *crumple_unity_last_error(void);

/// The number of Unity's Vulkan device, 1 for the first; buffers belong to one device. 0 if there is none: then `why` gets the
/// reason, at most capacity bytes with the zero at its end. `why` may be null.
CRUMPLE_UNITY_API uint32_t crumple_unity_device(char *why, uint32_t capacity);

/// What CommandBuffer.IssuePluginEvent() takes; out_id gets the number of the event. It does nothing where there is nothing to
/// do: no device, no context, a foreign number. Null and no number before UnityPluginLoad().
CRUMPLE_UNITY_API CrumpleUnityEvent crumple_unity_event(int32_t *out_id);

/// How many buffers and contexts wait for an event: to be recorded, or for what earlier frames used. 0: none need be issued.
CRUMPLE_UNITY_API uint32_t crumple_unity_pending(void);

/// Takes the message of the last event that could do nothing, at most capacity bytes with the zero. 0: there is none.
CRUMPLE_UNITY_API uint32_t crumple_unity_take_message(char *text, uint32_t capacity);

/// Makes a context known. From here on it is used under the lock, and destroyed by crumple_unity_destroy_context(); it must not
/// have a Vulkan device attached. Errors: CRUMPLE_ERROR_INVALID_ARGUMENT (null, or known already), CRUMPLE_ERROR_UNSUPPORTED (no
/// device: why), CRUMPLE_ERROR_OUT_OF_MEMORY.
CRUMPLE_UNITY_API CrumpleResult crumple_unity_add_context(CrumpleContext *context);

/// Unregisters a known context's buffers and destroys it: at once, or, while the device runs frames that it recorded, in the
/// event that learns of their end, or with the device. For the caller it is gone in any case. Waits for a recording of it. An
/// event that comes later does nothing. Errors: CRUMPLE_ERROR_INVALID_ID (not known).
CRUMPLE_UNITY_API CrumpleResult crumple_unity_destroy_context(CrumpleContext *context);

/// Waits until nobody is inside the context, and keeps it for the calling thread. Errors: CRUMPLE_ERROR_INVALID_ID (not
/// known, or destroyed meanwhile), CRUMPLE_ERROR_CONCURRENT_USE (this thread holds it already).
CRUMPLE_UNITY_API CrumpleResult crumple_unity_lock(CrumpleContext *context);

/// Gives it back. Errors: CRUMPLE_ERROR_INVALID_ID, CRUMPLE_ERROR_CONCURRENT_USE (this thread does not hold it).
CRUMPLE_UNITY_API CrumpleResult crumple_unity_unlock(CrumpleContext *context);

/// Registers a mesh's vertex buffer; it is wanted from the start, and its first recording writes every vertex. The first event
/// looks at the rest: usage, size, offsets. out_buffer gets a number that is never used again. Errors: CRUMPLE_ERROR_NULL_POINTER,
/// CRUMPLE_ERROR_INVALID_ID (a context that is not known), CRUMPLE_ERROR_UNSUPPORTED (a format that Crumple does not write, which
/// is named; no device: why), CRUMPLE_ERROR_OUT_OF_MEMORY.
CRUMPLE_UNITY_API CrumpleResult crumple_unity_register_buffer(CrumpleContext *context, const CrumpleUnityBufferDef *def,
                                                              uint64_t *out_buffer);

/// Forgets a buffer. Waits for a recording of its context; may be called with or without the lock. Call it before the
/// GraphicsBuffer or the mesh goes. Errors: CRUMPLE_ERROR_INVALID_ID.
CRUMPLE_UNITY_API CrumpleResult crumple_unity_unregister_buffer(uint64_t buffer);

/// The next event brings the buffer up to date. Errors: as crumple_unity_buffer_info().
CRUMPLE_UNITY_API CrumpleResult crumple_unity_want(uint64_t buffer);

/// Tells what became of a buffer. Errors: CRUMPLE_ERROR_INVALID_ID; CRUMPLE_ERROR_DEVICE_LOST (its device is gone: unregister it,
/// and register the mesh's buffer anew when there is a device again); any other is why it cannot be recorded: unregister it and
/// take the CPU path.
CRUMPLE_UNITY_API CrumpleResult crumple_unity_buffer_info(uint64_t buffer, CrumpleUnityBufferInfo *out_info);

#ifdef __cplusplus
}
#endif

#endif
