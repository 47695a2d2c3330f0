// The literature's rule: hits move the state of each vertex, one an invocation. src/classic.rs, `State::apply`, operation by
// operation.

override NORMALS: bool = false;
override TANGENTS: bool = false;

// The vertex is at rest; its state is nowhere yet.
const AT_REST = 1u;

// Of each vertex its position and, with NORMALS, its normal, not of unit length.
@group(2) @binding(0) var<storage, read_write> state: array<u32>;

// Any word of the frame.
fn frame_float(at: u32) -> f32 {
    return bitcast<f32>(frame[at >> 2u][at & 3u]);
}

fn frame_vector(at: u32) -> vec3<f32> {
    return vec3(frame_float(at), frame_float(at + 1u), frame_float(at + 2u));
}

fn finite(v: vec3<f32>) -> bool {
    return all((bitcast<vec3<u32>>(v) & vec3(0x7F800000u)) != vec3(0x7F800000u));
}

fn lerp3(a: vec3<f32>, b: vec3<f32>, t: f32) -> vec3<f32> {
    return a + (b - a) * t;
}

fn state_vector(at: u32) -> vec3<f32> {
    return vec3(bitcast<f32>(state[at]), bitcast<f32>(state[at + 1u]), bitcast<f32>(state[at + 2u]));
}

fn set_state(at: u32, v: vec3<f32>) {
    state[at] = bitcast<u32>(v.x);
    state[at + 1u] = bitcast<u32>(v.y);
    state[at + 2u] = bitcast<u32>(v.z);
}

@compute @workgroup_size(128)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let vertex = vertex_of(id);
    if !vertex.wanted {
        return;
    }
    let target_ = vertex.target_;
    let constant = bitcast<f32>(target_.f.x);
    let given = target_.f.w;
    let words = select(3u, 6u, NORMALS);

    let base = arena_vector(target_.a.x + 3u * vertex.index);
    var position = base;
    var base_normal = vec3(0.0);
    if NORMALS {
        base_normal = arena_vector(target_.a.y + 3u * vertex.index);
    }
    var normal = base_normal;
    if (target_.e.w & AT_REST) == 0u {
        if given != NONE {
            let at = call.carried + given + words * vertex.index;
            position = frame_vector(at);
            if NORMALS {
                normal = frame_vector(at + 3u);
            }
        } else {
            position = state_vector(words * vertex.index);
            if NORMALS {
                normal = state_vector(words * vertex.index + 3u);
            }
        }
    }

    for (var p = target_.e.y; p < target_.e.z; p++) {
        let part = call.parts + p * PART;
        let example = quad(part).y;
        let factors = float_quad(part + 4u);
        let head = head_of(example, vertex.block);
        if head == NONE {
            continue;
        }
        let weight = factors.z;
        let d = stored_displacement(example, head, vertex.v) * factors.x;
        let moved = any(d != vec3(0.0));
        var change = vec3(0.0);
        if NORMALS {
            change = stored_normal_change(example, head, vertex.v) * factors.y;
        }
        if !moved && all(change == vec3(0.0)) {
            continue;
        }
        let result = lerp3(position, base + d, weight);
        if !finite(result) {
            continue;
        }
        let was = position - base;
        let now = result - base;
        let further = dot3(now, now) >= dot3(was, was);
        if moved {
            position = select(lerp3(position, result, constant), result, further);
        }
        if NORMALS {
            let turned = lerp3(normal, base_normal + change, weight);
            if finite(turned) {
                normal = select(lerp3(normal, turned, constant), turned, further);
            }
        }
    }

    set_state(words * vertex.index, position);
    write_position(target_, vertex.index, position);
    if NORMALS {
        set_state(words * vertex.index + 3u, normal);
        var shown = normal;
        if any(normal != base_normal) {
            shown = unit(normal, base_normal);
        }
        write_normal(target_, vertex.index, shown);
        if TANGENTS && target_.c.x != 0u {
            let at = target_.a.z + 4u * vertex.index;
            let tangent = vec4(arena_vector(at), arena_float(at + 3u));
            write_tangent(target_, vertex.index, tangent_of(tangent, base_normal, shown));
        }
    }
}
