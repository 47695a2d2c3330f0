// The classic kernel, as it stands: for each vertex that an example moves, an entry of vertex and target, 16 bytes, read at
// once; 12 bytes of base position; 12 of state, read and written. 52 bytes a vertex. "The most displaced" stays.
// lab/src/bench/reference.rs, `most_displaced`, operation by operation.

struct Call {
    // Entries, and invocations in a row of workgroups.
    count: u32,
    row: u32,
    weight: f32,
}
var<immediate> call: Call;

// Vertex, and where the example has it.
@group(0) @binding(0) var<storage, read> entries: array<vec4<u32>>;
@group(0) @binding(1) var<storage, read> base: array<f32>;
// The host's vertex buffer, which is the state.
@group(0) @binding(2) var<storage, read_write> current: array<f32>;

fn square(v: vec3<f32>) -> f32 {
    return v.x * v.x + v.y * v.y + v.z * v.z;
}

@compute @workgroup_size(128)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let i = id.x + id.y * call.row;
    if i >= call.count {
        return;
    }
    let entry = entries[i];
    let at = 3u * entry.x;
    let goal = bitcast<vec3<f32>>(entry.yzw);
    let rest = vec3(base[at], base[at + 1u], base[at + 2u]);
    let now = vec3(current[at], current[at + 1u], current[at + 2u]);
    let result = now + (goal - now) * call.weight;
    if square(result - rest) >= square(now - rest) {
        current[at] = result.x;
        current[at + 1u] = result.y;
        current[at + 2u] = result.z;
    }
}
