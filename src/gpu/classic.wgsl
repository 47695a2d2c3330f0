// The literature's rule: hits move the state of each vertex, one an invocation. src/classic.rs, `State::apply`, operation by
// operation.

override NORMALS: bool = false;
override TANGENTS: bool = false;

// The vertex is at rest; its state is nowhere yet.
const AT_REST = 1u;

// Of each vertex its position and, with NORMALS, its normal, not of unit length.
@group(2) @binding(0) var<storage, read_write> state: array<u32>;

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
    let invocation = id.y * call.row + id.x;
    if invocation >= call.count {
        return;
    }
    let item = call.items + (invocation / BLOCK) * ITEM;
    let v = invocation % BLOCK;
    if v >= frame[item + 2u] {
        return;
    }
    let vertex = frame[item + 1u] + v;
    let target_ = call.targets + frame[item] * TARGET;
    let given = frame[item + 6u];
    let constant = frame_float(item + 7u);
    let end = frame[item + 4u];
    let words = select(3u, 6u, NORMALS);

    let base = arena_vector(frame[target_] + 3u * vertex);
    var position = base;
    var base_normal = vec3(0.0);
    if NORMALS {
        base_normal = arena_vector(frame[target_ + 1u] + 3u * vertex);
    }
    var normal = base_normal;
    if (frame[item + 5u] & AT_REST) == 0u {
        if given != NONE {
            let at = call.carried + given + words * v;
            position = frame_vector(at);
            if NORMALS {
                normal = frame_vector(at + 3u);
            }
        } else {
            position = state_vector(words * vertex);
            if NORMALS {
                normal = state_vector(words * vertex + 3u);
            }
        }
    }

    for (var p = frame[item + 3u]; p < end; p++) {
        let part = call.parts + p * PART;
        let kind = frame[part];
        let groups = frame[part + 1u];
        let weight = frame_float(part + 6u);
        let d = stored(frame[part + 2u], (kind >> 8u) & 0xFFu, groups & 0xFFFFu, v) * frame_float(part + 4u);
        let moved = any(d != vec3(0.0));
        var change = vec3(0.0);
        if NORMALS {
            change = stored(frame[part + 3u], kind >> 16u, groups >> 16u, v) * frame_float(part + 5u);
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

    set_state(words * vertex, position);
    write_position(target_, vertex, position);
    if NORMALS {
        set_state(words * vertex + 3u, normal);
        var shown = normal;
        if any(normal != base_normal) {
            shown = unit(normal, base_normal);
        }
        write_normal(target_, vertex, shown);
        if TANGENTS && frame[target_ + 8u] != 0u {
            let at = frame[target_ + 2u] + 4u * vertex;
            let tangent = vec4(arena_vector(at), arena_float(at + 3u));
            write_tangent(target_, vertex, tangent_of(tangent, base_normal, shown));
        }
    }
}
