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

// The 3×3 matrix with these columns times `v`.
fn turned(x: vec3<f32>, y: vec3<f32>, z: vec3<f32>, v: vec3<f32>) -> vec3<f32> {
    return x * v.x + y * v.y + z * v.z;
}

// `c` is the carried part's place in `frame`, `factors` are the part's own: src/gpu/frame.rs, `add_carried`.
fn add_carried(
    c: u32,
    factors: vec4<f32>,
    window: u32,
    v: u32,
    position: vec3<f32>,
    normal: vec3<f32>,
    sums: ptr<function, Sums>,
) {
    let q0 = float_quad(c);
    let q1 = float_quad(c + 4u);
    let q2 = float_quad(c + 8u);
    let p = turned(vec3(q0.w, q1.xy), vec3(q1.zw, q2.x), q2.yzw, position - q0.xyz);
    // stamp.rs, `unrolled`, on into units of nodes.
    let steep = least((p.z * p.z) / (p.x * p.x + p.y * p.y), 2.0);
    let lift = 1.0 + steep * 0.5;
    let cells = float_quad(c + 12u);
    let q4 = float_quad(c + 16u);
    let gx = (p.x * lift) * cells.x - cells.z;
    let gy = (p.y * lift) * cells.y - cells.w;
    let hx = held(gx, 0.0, q4.x);
    let hy = held(gy, 0.0, q4.y);
    if !(gx == hx && gy == hy) {
        return;
    }
    // Nodes are at least two a side, and coordinates at least 0.
    let q10 = quad(c + 40u);
    let dims = q10.zw;
    let first = min(vec2<u32>(vec2<i32>(vec2(hx, hy))), dims - 2u);
    let x = hx - f32(first.x);
    let y = hy - f32(first.y);
    let both = i32((x * y) * WEIGHTS);
    let wx = i32(x * WEIGHTS);
    let wy = i32(y * WEIGHTS);
    let neither = max(i32(WEIGHTS) - wx - wy + both, 0);
    let weights = vec4(neither, wx - both, wy - both, both);
    let at = quad(c + 44u).x + 4u * (first.x + first.y * dims.x);
    let sums4 = blend(at, dims.x, weights);
    let q9 = float_quad(c + 36u);
    let off = abs(p.z - sums4.w * q9.x);
    let keep = held(2.0 - off * q9.y, 0.0, 1.0);
    if !(keep > 0.0) {
        return;
    }
    let scale = factors.x;
    let q5 = float_quad(c + 20u);
    let q6 = float_quad(c + 24u);
    var u = cut(turned(vec3(q4.zw, q5.x), q5.yzw, q6.xyz, sums4.xyz) * keep, factors.z);
    var factor = 1.0;
    if window != NONE {
        factor = arena_float(window + v);
    }
    if NORMALS {
        let turn = blend(at + 2u, dims.x, weights);
        // A vertex that faces elsewhere than the surface of the example does not take over how that turned.
        let up = bitcast<vec2<f32>>(q10.xy);
        let apart = abs(dot3(normal, vec3(q9.zw, up.x)) - turn.w * up.y);
        let alike = held(2.0 - (apart + apart), 0.0, 1.0);
        let q7 = float_quad(c + 28u);
        let q8 = float_quad(c + 32u);
        var change = turned(vec3(q6.w, q7.xy), vec3(q7.zw, q8.x), q8.yzw, turn.xyz) * (keep * alike);
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

fn add_stored(example: u32, factors: vec4<f32>, block: u32, v: u32, sums: ptr<function, Sums>) {
    let head = head_of(example, block);
    if head == NONE {
        return;
    }
    let u = stored_displacement(example, head, v);
    (*sums).dent = (*sums).dent + cut(u, factors.z) * factors.x;
    if NORMALS {
        (*sums).change = (*sums).change + stored_normal_change(example, head, v) * factors.y;
    }
}

@compute @workgroup_size(128)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let vertex = vertex_of(id);
    if !vertex.wanted {
        return;
    }
    let target_ = vertex.target_;
    let flags = target_.e.w;
    let end = call.parts + target_.e.z * PART;
    var window = target_.f.z;
    if window != NONE {
        let at = arena[window + vertex.block];
        window = select(window + at, NONE, at == NONE);
    }
    let bounds = target_.f.y + 6u * vertex.block;
    let low = arena_vector(bounds);
    let high = arena_vector(bounds + 3u);

    let base = arena_vector(target_.a.x + 3u * vertex.index);
    var base_normal = vec3(0.0);
    if NORMALS {
        base_normal = arena_vector(target_.a.y + 3u * vertex.index);
    }

    var sums = Sums(vec3(0.0), vec3(0.0), 0.0, vec3(0.0));
    // A dent is a head, which tells how far it reaches and how many parts follow.
    var at = call.parts + target_.e.y * PART;
    while at < end {
        let after = at + PART + quad(at + 4u).x * PART;
        let contact = float_quad(at);
        let off = vec3(
            most(most(low.x - contact.x, contact.x - high.x), 0.0),
            most(most(low.y - contact.y, contact.y - high.y), 0.0),
            most(most(low.z - contact.z, contact.z - high.z), 0.0),
        );
        if dot3(off, off) <= contact.w {
            for (var part = at + PART; part < after; part += PART) {
                let what = quad(part);
                let factors = float_quad(part + 4u);
                if (what.x & IS_CARRIED) != 0u {
                    let c = call.carried + what.y * CARRIED;
                    add_carried(c, factors, window, vertex.v, base, base_normal, &sums);
                } else {
                    add_stored(what.y, factors, vertex.block, vertex.v, &sums);
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
            allowed = least(bitcast<f32>(target_.f.x), allowed);
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
        if TANGENTS && target_.c.x != 0u {
            let at = target_.a.z + 4u * vertex.index;
            let tangent = vec4(arena_vector(at), arena_float(at + 3u));
            write_tangent(target_, vertex.index, tangent_of(tangent, base_normal, normal));
        }
    }
}
