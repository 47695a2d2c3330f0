// The classic rules: hits move the state of each vertex. An invocation computes one vertex, with the operations of
// `State::apply` in src/classic/mod.rs, in their order.

// The position of each vertex and, with NORMALS, its normal, which is not of unit length.
@group(2) @binding(0) var<storage, read_write> state: array<u32>;

// Word `at` of the frame's lists.
fn work_float(at: u32) -> f32 {
    return bitcast<f32>(work[at >> 2u][at & 3u]);
}

fn work_vector(at: u32) -> vec3<f32> {
    return vec3(work_float(at), work_float(at + 1u), work_float(at + 2u));
}

// The `n`-th of whole numbers of one or two bytes.
fn stored_number(at: u32, width: u32, n: u32) -> f32 {
    let bit = n * width * 8u;
    let unused = 32u - width * 8u;
    return f32(bitcast<i32>((arena[at + (bit >> 5u)] >> (bit & 31u)) << unused) >> unused);
}

// The stored vector of vertex `v` of a block, in steps. A number has `width` bytes; one of four is a float. A bit of `groups` says
// whether the example stores the numbers of eight vertices.
fn stored(at: u32, width: u32, groups: u32, v: u32) -> vec3<f32> {
    let group = v >> 3u;
    if ((groups >> group) & 1u) == 0u {
        return vec3(0.0);
    }
    let before = countOneBits(groups & ((1u << group) - 1u));
    let n = 3u * (before * 8u + (v & 7u));
    if width == 4u {
        return arena_vector(at + n);
    }
    return vec3(stored_number(at, width, n), stored_number(at, width, n + 1u), stored_number(at, width, n + 2u));
}

// The first word of a block's head, or NONE if the example stores nothing of the block.
fn head_of(example: u32, block: u32) -> u32 {
    let at = arena[example + block];
    return select(example + at, NONE, at == NONE);
}

fn stored_displacement(example: u32, head: u32, v: u32) -> vec3<f32> {
    return stored(example + arena[head + 2u], arena[head] & 0xFFu, arena[head + 1u] & 0xFFFFu, v);
}

fn stored_normal_change(example: u32, head: u32, v: u32) -> vec3<f32> {
    return stored(example + arena[head + 3u], arena[head] >> 8u, arena[head + 1u] >> 16u, v);
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

fn load_classic_hit(row: u32) -> ClassicHit {
    let r = work[row];
    return ClassicHit(r.x, bitcast<f32>(r.y), bitcast<f32>(r.z), bitcast<f32>(r.w));
}

@compute @workgroup_size(128)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let vertex = vertex_of(group, local);
    if !vertex.wanted {
        return;
    }
    let out = vertex.out;
    let constant = out.limit;
    let given = out.given_state;
    let words = select(3u, 6u, NORMALS);

    let base = arena_vector(out.base_positions + 3u * vertex.index);
    var position = base;
    var base_normal = vec3(0.0);
    if NORMALS {
        base_normal = arena_vector(out.base_normals + 3u * vertex.index);
    }
    var normal = base_normal;
    if (out.flags & AT_REST) == 0u {
        if given != NONE {
            let at = 4u * call.states + given + words * vertex.index;
            position = work_vector(at);
            if NORMALS {
                normal = work_vector(at + 3u);
            }
        } else {
            position = state_vector(words * vertex.index);
            if NORMALS {
                normal = state_vector(words * vertex.index + 3u);
            }
        }
    }

    for (var row = out.parts_begin; row < out.parts_end; row++) {
        let hit = load_classic_hit(call.parts + row);
        let head = head_of(hit.example, vertex.block);
        if head == NONE {
            continue;
        }
        let d = stored_displacement(hit.example, head, vertex.v) * hit.position_step;
        let moved = any(d != vec3(0.0));
        var change = vec3(0.0);
        if NORMALS {
            change = stored_normal_change(hit.example, head, vertex.v) * hit.normal_step;
        }
        if !moved && all(change == vec3(0.0)) {
            continue;
        }
        let result = lerp3(position, base + d, hit.weight);
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
            let turned = lerp3(normal, base_normal + change, hit.weight);
            if finite(turned) {
                normal = select(lerp3(normal, turned, constant), turned, further);
            }
        }
    }

    set_state(words * vertex.index, position);
    // `factor` in src/mesh/limits.rs.
    let u = position - base;
    let length = maximum(sqrt(dot3(u, u)), LEAST_LENGTH);
    let allowed = within_own_limits(out, vertex.index, length);
    let shortened = length > allowed;
    let factor = allowed / length;
    write_position(out, vertex.index, select(position, base + u * factor, shortened));
    if NORMALS {
        set_state(words * vertex.index + 3u, normal);
        var shown = select(normal, base_normal + (normal - base_normal) * factor, shortened);
        if any(shown != base_normal) {
            shown = unit(shown, base_normal);
        }
        write_directions(out, vertex.index, base_normal, shown);
    }
}
