// The default rule: marks become vertices, one an invocation. src/deform/kernel.rs, `displace`, operation by operation.

override NORMALS: bool = false;
override TANGENTS: bool = false;

// Words of a carried example in `frame`.
const CARRIED = 48u;
// What the weights of a bilinear mean sum to: WEIGHTS in src/stamp.rs.
const WEIGHTS = 16384.0;

const SEVERAL = 1u;
const SQUARES = 2u;
const LONGEST = 4u;
const LIMITED = 8u;

const IS_CARRIED = 1u;

// Sums at a vertex.
struct Sums {
    dent: vec3<f32>,
    all: vec3<f32>,
    squares: f32,
    change: vec3<f32>,
}

// Vectors no longer than the root of `square` become zero; all stay where it is negative.
fn cut(v: vec3<f32>, square: f32) -> vec3<f32> {
    return select(vec3(0.0), v, dot3(v, v) > square);
}

// Adds half of a node, four numbers of 16 bits, times a weight.
fn add_half(sum: vec4<i32>, at: u32, weight: i32) -> vec4<i32> {
    let a = bitcast<i32>(arena[at]);
    let b = bitcast<i32>(arena[at + 1u]);
    return sum + vec4((a << 16u) >> 16u, a >> 16u, (b << 16u) >> 16u, b >> 16u) * weight;
}

// The weighted sum of half of the four nodes of a cell, in steps; exact. A node has four words.
fn blend(at: u32, row: u32, weights: vec4<i32>) -> vec4<f32> {
    var sum = add_half(vec4(0), at, weights.x);
    sum = add_half(sum, at + 4u, weights.y);
    sum = add_half(sum, at + 4u * row, weights.z);
    return vec4<f32>(add_half(sum, at + 4u * row + 4u, weights.w));
}

// The 3×3 matrix at `m` (columns) times `v`.
fn turned(m: u32, v: vec3<f32>) -> vec3<f32> {
    return frame_vector(m) * v.x + frame_vector(m + 3u) * v.y + frame_vector(m + 6u) * v.z;
}

fn add_carried(part: u32, window: u32, v: u32, position: vec3<f32>, normal: vec3<f32>, sums: ptr<function, Sums>) {
    let c = call.carried + frame[part + 1u] * CARRIED;
    let p = turned(c + 3u, position - frame_vector(c));
    // stamp.rs, `unrolled`, on into units of nodes.
    let steep = least((p.z * p.z) / (p.x * p.x + p.y * p.y), 2.0);
    let lift = 1.0 + steep * 0.5;
    let gx = (p.x * lift) * frame_float(c + 12u) - frame_float(c + 14u);
    let gy = (p.y * lift) * frame_float(c + 13u) - frame_float(c + 15u);
    let hx = held(gx, 0.0, frame_float(c + 16u));
    let hy = held(gy, 0.0, frame_float(c + 17u));
    if !(gx == hx && gy == hy) {
        return;
    }
    // Nodes are at least two a side, and coordinates at least 0.
    let dims = vec2(frame[c + 42u], frame[c + 43u]);
    let first = min(vec2<u32>(vec2<i32>(vec2(hx, hy))), dims - 2u);
    let x = hx - f32(first.x);
    let y = hy - f32(first.y);
    let both = i32((x * y) * WEIGHTS);
    let wx = i32(x * WEIGHTS);
    let wy = i32(y * WEIGHTS);
    let neither = max(i32(WEIGHTS) - wx - wy + both, 0);
    let weights = vec4(neither, wx - both, wy - both, both);
    let at = frame[c + 44u] + 4u * (first.x + first.y * dims.x);
    let sums4 = blend(at, dims.x, weights);
    let off = abs(p.z - sums4.w * frame_float(c + 36u));
    let keep = held(2.0 - off * frame_float(c + 37u), 0.0, 1.0);
    if !(keep > 0.0) {
        return;
    }
    let scale = frame_float(part + 4u);
    var u = cut(turned(c + 18u, sums4.xyz) * keep, frame_float(part + 6u));
    var factor = 1.0;
    if window != NONE {
        factor = arena_float(window + v);
    }
    if NORMALS {
        let turn = blend(at + 2u, dims.x, weights);
        // A vertex that faces elsewhere than the surface of the example does not take over how that turned.
        let apart = abs(dot3(normal, frame_vector(c + 38u)) - turn.w * frame_float(c + 41u));
        let alike = held(2.0 - (apart + apart), 0.0, 1.0);
        var change = turned(c + 27u, turn.xyz) * (keep * alike);
        if window != NONE {
            // The window's own slope tilts the surface too.
            let at = window + BLOCK + v;
            let slope = vec3(arena_float(at), arena_float(at + BLOCK), arena_float(at + 2u * BLOCK));
            let along = slope - normal * dot3(normal, slope);
            change = change * factor - along * dot3(u, normal);
        }
        (*sums).change = (*sums).change + change * scale;
    }
    if window != NONE {
        u = u * factor;
    }
    (*sums).dent = (*sums).dent + u * scale;
}

// The unit vector along `n + change`; `n` itself where the `sum` of changes is nothing.
fn normal_of(n: vec3<f32>, sum: vec3<f32>, change: vec3<f32>) -> vec3<f32> {
    let v = n + change;
    let square = dot3(v, v);
    if all(sum == vec3(0.0)) || !(square > 1e-12) {
        return n;
    }
    return v * (1.0 / sqrt(square));
}

fn add_stored(part: u32, block: u32, v: u32, sums: ptr<function, Sums>) {
    let example = frame[part + 1u];
    let head = head_of(example, block);
    if head == NONE {
        return;
    }
    let u = stored_displacement(example, head, v);
    (*sums).dent = (*sums).dent + cut(u, frame_float(part + 6u)) * frame_float(part + 4u);
    if NORMALS {
        (*sums).change = (*sums).change + stored_normal_change(example, head, v) * frame_float(part + 5u);
    }
}

@compute @workgroup_size(128)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let vertex = vertex_of(id);
    if !vertex.wanted {
        return;
    }
    let target_ = vertex.target_;
    let flags = frame[target_ + 19u];
    let end = call.parts + frame[target_ + 18u] * PART;
    var window = frame[target_ + 22u];
    if window != NONE {
        let at = arena[window + vertex.block];
        window = select(window + at, NONE, at == NONE);
    }
    let bounds = frame[target_ + 21u] + 6u * vertex.block;
    let low = arena_vector(bounds);
    let high = arena_vector(bounds + 3u);

    let base = arena_vector(frame[target_] + 3u * vertex.index);
    var base_normal = vec3(0.0);
    if NORMALS {
        base_normal = arena_vector(frame[target_ + 1u] + 3u * vertex.index);
    }

    var sums = Sums(vec3(0.0), vec3(0.0), 0.0, vec3(0.0));
    // A dent is a head, which tells how far it reaches and how many parts follow.
    var at = call.parts + frame[target_ + 17u] * PART;
    while at < end {
        let after = at + PART + frame[at + 4u] * PART;
        let contact = frame_vector(at);
        let off = vec3(
            most(most(low.x - contact.x, contact.x - high.x), 0.0),
            most(most(low.y - contact.y, contact.y - high.y), 0.0),
            most(most(low.z - contact.z, contact.z - high.z), 0.0),
        );
        if dot3(off, off) <= frame_float(at + 3u) {
            for (var part = at + PART; part < after; part += PART) {
                if (frame[part] & IS_CARRIED) != 0u {
                    add_carried(part, window, vertex.v, base, base_normal, &sums);
                } else {
                    add_stored(part, vertex.block, vertex.v, &sums);
                }
            }
            sums.all = sums.all + sums.dent;
            if (flags & SEVERAL) != 0u {
                let square = dot3(sums.dent, sums.dent);
                sums.squares = select(sums.squares + square, most(square, sums.squares), (flags & LONGEST) != 0u);
            }
            sums.dent = vec3(0.0);
        }
        at = after;
    }

    var u = sums.all;
    var change = sums.change;
    if (flags & (SEVERAL | LIMITED)) != 0u {
        let length = sqrt(dot3(u, u));
        var allowed = length;
        if (flags & SEVERAL) != 0u && (flags & (SQUARES | LONGEST)) != 0u {
            allowed = least(sqrt(sums.squares), allowed);
        }
        if (flags & LIMITED) != 0u {
            allowed = least(frame_float(target_ + 20u), allowed);
        }
        if length > allowed {
            let factor = allowed / length;
            u = u * factor;
            change = change * factor;
        }
    }
    write_position(target_, vertex.index, base + u);
    if NORMALS {
        let normal = normal_of(base_normal, sums.change, change);
        write_normal(target_, vertex.index, normal);
        if TANGENTS && frame[target_ + 8u] != 0u {
            let at = frame[target_ + 2u] + 4u * vertex.index;
            let tangent = vec4(arena_vector(at), arena_float(at + 3u));
            write_tangent(target_, vertex.index, tangent_of(tangent, base_normal, normal));
        }
    }
}
