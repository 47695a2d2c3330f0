// The default rule: marks become vertices, one an invocation. src/deform/kernel.rs, `displace`, operation by operation.

override NORMALS: bool = false;
override TANGENTS: bool = false;

// Words of a carried example in `frame`.
const CARRIED = 56u;

const SEVERAL = 1u;
const SQUARES = 2u;
const LONGEST = 4u;
const LIMITED = 8u;

const LAST = 1u;
const IS_CARRIED = 2u;

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

fn lerp3(a: vec3<f32>, b: vec3<f32>, t: f32) -> vec3<f32> {
    return a + (b - a) * t;
}

// Node `i` of a stamp's field, in steps: 1 packed in a word, 2 in 16 bits, 3 floats.
fn node(at: u32, kind: u32, i: u32) -> vec3<f32> {
    if kind == 1u {
        let w = arena[at + i];
        return vec3(signed(w, 22u, 22u), signed(w, 11u, 21u), signed(w, 0u, 21u));
    }
    if kind == 2u {
        let a = arena[at + 2u * i];
        let b = arena[at + 2u * i + 1u];
        return vec3(signed(a, 16u, 16u), signed(a, 0u, 16u), signed(b, 16u, 16u));
    }
    return arena_vector(at + 3u * i);
}

fn line(at: u32, kind: u32, i: u32, t: f32) -> vec3<f32> {
    return lerp3(node(at, kind, i), node(at, kind, i + 1u), t);
}

fn plane(at: u32, kind: u32, i: u32, row: u32, t: vec3<f32>) -> vec3<f32> {
    return lerp3(line(at, kind, i, t.x), line(at, kind, i + row, t.x), t.y);
}

fn field(at: u32, kind: u32, i: u32, row: u32, layer: u32, t: vec3<f32>) -> vec3<f32> {
    return lerp3(plane(at, kind, i, row, t), plane(at, kind, i + layer, row, t), t.z);
}

// The 3×3 matrix at `m` (columns) times `v`.
fn turned(m: u32, v: vec3<f32>) -> vec3<f32> {
    return frame_vector(m) * v.x + frame_vector(m + 3u) * v.y + frame_vector(m + 6u) * v.z;
}

fn add_carried(part: u32, window: u32, v: u32, position: vec3<f32>, normal: vec3<f32>, sums: ptr<function, Sums>) {
    let c = call.carried + frame[part + 1u] * CARRIED;
    let top = frame_vector(c + 15u);
    let g = turned(c + 3u, position - frame_vector(c)) - frame_vector(c + 12u);
    let h = vec3(held(g.x, 0.0, top.x), held(g.y, 0.0, top.y), held(g.z, 0.0, top.z));
    if !all(g == h) {
        return;
    }
    let dims = vec3(frame[c + 48u], frame[c + 49u], frame[c + 50u]);
    // Nodes are at least two a side, and `h` is at least 0.
    let first = min(vec3<u32>(vec3<i32>(h)), dims - 2u);
    let row = dims.x;
    let layer = dims.x * dims.y;
    let i = first.x + first.y * row + first.z * layer;
    let t = h - vec3<f32>(first);
    let kinds = frame[c + 54u];
    let scale = frame_float(part + 4u);
    var u = cut(turned(c + 18u, field(frame[c + 51u], kinds & 3u, i, row, layer, t)), frame_float(part + 6u));
    var factor = 1.0;
    if window != NONE {
        factor = arena_float(window + v);
    }
    if NORMALS {
        var change = vec3(0.0);
        var facing = vec3(0.0);
        let kind = (kinds >> 2u) & 3u;
        if kind != 0u {
            change = field(frame[c + 52u], kind, i, row, layer, t);
            facing = field(frame[c + 53u], kind, i, row, layer, t);
        }
        facing = facing * frame_vector(c + 45u);
        let length = sqrt(dot3(facing, facing));
        var cosine = dot3(facing, turned(c + 36u, normal)) / length;
        // A facing of length 0 has none.
        cosine = select(0.0, held(cosine, 0.0, 1.0), length > 0.0);
        change = turned(c + 27u, change) * cosine;
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
    let window = frame[item + 6u];
    let flags = frame[item + 5u];
    let begin = frame[item + 3u];
    let end = frame[item + 4u];

    let base = arena_vector(frame[target_] + 3u * vertex);
    var base_normal = vec3(0.0);
    if NORMALS {
        base_normal = arena_vector(frame[target_ + 1u] + 3u * vertex);
    }

    var sums = Sums(vec3(0.0), vec3(0.0), 0.0, vec3(0.0));
    for (var p = begin; p < end; p++) {
        let part = call.parts + p * PART;
        let kind = frame[part];
        if (kind & IS_CARRIED) != 0u {
            add_carried(part, window, v, base, base_normal, &sums);
        } else {
            let groups = frame[part + 1u];
            let u = stored(frame[part + 2u], (kind >> 8u) & 0xFFu, groups & 0xFFFFu, v);
            sums.dent = sums.dent + cut(u, frame_float(part + 6u)) * frame_float(part + 4u);
            if NORMALS {
                let change = stored(frame[part + 3u], kind >> 16u, groups >> 16u, v);
                sums.change = sums.change + change * frame_float(part + 5u);
            }
        }
        if (kind & LAST) != 0u {
            sums.all = sums.all + sums.dent;
            if (flags & SEVERAL) != 0u {
                let square = dot3(sums.dent, sums.dent);
                sums.squares = select(sums.squares + square, most(square, sums.squares), (flags & LONGEST) != 0u);
            }
            sums.dent = vec3(0.0);
        }
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
            allowed = least(frame_float(item + 7u), allowed);
        }
        if length > allowed {
            let factor = allowed / length;
            u = u * factor;
            change = change * factor;
        }
    }
    write_position(target_, vertex, base + u);
    if NORMALS {
        let normal = normal_of(base_normal, sums.change, change);
        write_normal(target_, vertex, normal);
        if TANGENTS && frame[target_ + 8u] != 0u {
            let at = frame[target_ + 2u] + 4u * vertex;
            let tangent = vec4(arena_vector(at), arena_float(at + 3u));
            write_tangent(target_, vertex, tangent_of(tangent, base_normal, normal));
        }
    }
}
