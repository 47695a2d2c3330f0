// The default rule: marks become vertices. An invocation computes one vertex, with the operations of `displace` in
// src/deform/kernel.rs, in their order.

// Whether there are carried examples.
override CARRIED: bool = false;

// Sums at a vertex.
struct Sums {
    dent: vec3<f32>,
    all: vec3<f32>,
    change: vec3<f32>,
    // What carried examples add to `all` and to `change`, in steps.
    carried_all: vec3<i32>,
    carried_change: vec3<i32>,
}

// A vector in whole steps, rounded towards zero.
fn in_steps(v: vec3<f32>, per_step: f32) -> vec3<i32> {
    let s = v * per_step;
    return vec3(
        i32(clamped(s.x, -MOST_STEPS, MOST_STEPS)),
        i32(clamped(s.y, -MOST_STEPS, MOST_STEPS)),
        i32(clamped(s.z, -MOST_STEPS, MOST_STEPS)),
    );
}

// 1 / x of a power of two. It is exact; a device may round a division otherwise.
fn inverse(power: f32) -> f32 {
    return bitcast<f32>(0x7F000000u - bitcast<u32>(power));
}

// Zero for a vector no longer than the root of `square`, else the vector. A negative `square` keeps all vectors.
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

// The 3×3 matrix with these columns times `v`, and the transpose of the matrix times `v`.
fn turned(x: vec3<f32>, y: vec3<f32>, z: vec3<f32>, v: vec3<f32>) -> vec3<f32> {
    return x * v.x + y * v.y + z * v.z;
}

fn turned_back(x: vec3<f32>, y: vec3<f32>, z: vec3<f32>, v: vec3<f32>) -> vec3<f32> {
    return vec3(dot3(x, v), dot3(y, v), dot3(z, v));
}

// Adds carried examples at one contact: a `CarriedWork` and its `LookupWork`s, which begin at `row`.
fn add_carried(
    row: u32,
    part: DentPart,
    out: TargetWork,
    window: u32,
    v: u32,
    position: vec3<f32>,
    normal: vec3<f32>,
    sums: ptr<function, Sums>,
) {
    let at = load_carried_work(row);
    let p = turned(at.to_frame_x, at.to_frame_y, at.to_frame_z, position - at.contact);
    let steep = (p.z * p.z) / (p.x * p.x + p.y * p.y);
    let facing = dot3(normal, vec3(at.to_frame_x.z, at.to_frame_y.z, at.to_frame_z.z));
    var displacement = vec3(0.0);
    var turns = vec3(0.0);
    let first = row + ROWS_CARRIED_WORK;
    let end = first + part.lookups * ROWS_LOOKUP_WORK;
    for (var r = first; r < end; r += ROWS_LOOKUP_WORK) {
        let look = load_lookup_work(r);
        // `unrolled` in src/example/stamp.rs, in units of 1 / WEIGHTS cells.
        let lift = 1.0 + minimum(steep * look.stretch_square, 2.0) * 0.5;
        let g = look.to_grid_x * p.x + look.to_grid_y * p.y;
        let gx = g.x * lift - look.origin.x;
        let gy = g.y * lift - look.origin.y;
        let hx = clamped(gx, 0.0, look.last.x);
        let hy = clamped(gy, 0.0, look.last.y);
        if !(gx == hx && gy == hy) {
            continue;
        }
        let fx = u32(i32(hx));
        let fy = u32(i32(hy));
        let x = i32(fx & 0x3FFFu);
        let y = i32(fy & 0x3FFFu);
        let both = (x * y) >> 14u;
        let weights = vec4(i32(WEIGHTS) - x - y + both, x - both, y - both, both);
        let node = look.nodes + 4u * ((fx >> 14u) + (fy >> 14u) * look.columns);
        let sums4 = blend(node, look.columns, weights);
        let off = abs(p.z - sums4.w * look.height);
        let keep = clamped(2.0 - off * look.fade, 0.0, 1.0);
        if !(keep > 0.0) {
            continue;
        }
        let flat = look.displacement_x * sums4.x + look.displacement_y * sums4.y;
        let u = vec3(flat, sums4.z * look.displacement_z) * keep;
        displacement = displacement + cut(u, part.dropped_square);
        if NORMALS {
            let turn = blend(node + 2u, look.columns, weights);
            // A vertex that faces elsewhere than the example's surface does not turn with it.
            let apart = abs(facing - turn.w * FACING);
            let alike = clamped(2.0 - (apart + apart), 0.0, 1.0);
            let bent = look.normal_x * turn.x + look.normal_y * turn.y;
            turns = turns + vec3(bent, turn.z * look.normal_z) * (keep * alike);
        }
    }
    var u = turned_back(at.to_frame_x, at.to_frame_y, at.to_frame_z, displacement) * part.scale;
    var factor = 1.0;
    if window != NONE {
        factor = arena_float(window + v);
    }
    if NORMALS {
        var change = turned_back(at.to_frame_x, at.to_frame_y, at.to_frame_z, turns) * part.scale;
        if window != NONE {
            // The slope of the window tilts the surface too.
            let slope_at = window + BLOCK + v;
            let slope =
                vec3(arena_float(slope_at), arena_float(slope_at + BLOCK), arena_float(slope_at + 2u * BLOCK));
            let along = slope - normal * dot3(normal, slope);
            change = change * factor - along * dot3(u, normal);
        }
        (*sums).carried_change = (*sums).carried_change + in_steps(change, inverse(TURN_STEP * out.coarse));
    }
    if window != NONE {
        u = u * factor;
    }
    (*sums).carried_all = (*sums).carried_all + in_steps(u, out.per_step);
}

fn add_anchored(part: DentPart, block: u32, v: u32, sums: ptr<function, Sums>) {
    let head = head_of(part.source, block);
    if head == NONE {
        return;
    }
    let u = stored_displacement(part.source, head, v);
    (*sums).dent = (*sums).dent + cut(u, part.dropped_square) * part.scale;
    if NORMALS {
        (*sums).change = (*sums).change + stored_normal_change(part.source, head, v) * part.normal_scale;
    }
}

@compute @workgroup_size(128)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let vertex = vertex_of(group, local);
    if !vertex.wanted {
        return;
    }
    let out = vertex.out;
    var window = out.windows;
    if window != NONE {
        let at = arena[window + vertex.block];
        window = select(window + at, NONE, at == NONE);
    }
    let bounds = out.block_bounds + 6u * vertex.block;
    let low = arena_vector(bounds);
    let high = arena_vector(bounds + 3u);

    let base = arena_vector(out.base_positions + 3u * vertex.index);
    var base_normal = vec3(0.0);
    if NORMALS {
        base_normal = arena_vector(out.base_normals + 3u * vertex.index);
    }

    var sums = Sums(vec3(0.0), vec3(0.0), vec3(0.0), vec3(0), vec3(0));
    var row = call.parts + out.parts_begin;
    let end = call.parts + out.parts_end;
    while row < end {
        let dent = load_dent_head(row);
        let first = row + ROWS_DENT_HEAD;
        let after = first + dent.parts * ROWS_DENT_PART;
        let off = vec3(
            maximum(maximum(low.x - dent.contact.x, dent.contact.x - high.x), 0.0),
            maximum(maximum(low.y - dent.contact.y, dent.contact.y - high.y), 0.0),
            maximum(maximum(low.z - dent.contact.z, dent.contact.z - high.z), 0.0),
        );
        if dot3(off, off) <= dent.reach_square {
            for (var at = first; at < after; at += ROWS_DENT_PART) {
                let part = load_dent_part(at);
                if CARRIED && part.lookups != 0u {
                    add_carried(call.carried + part.source, part, out, window, vertex.v, base, base_normal, &sums);
                } else {
                    add_anchored(part, vertex.block, vertex.v, &sums);
                }
            }
            sums.all = sums.all + sums.dent;
            sums.dent = vec3(0.0);
        }
        row = after;
    }

    if CARRIED {
        sums.all = sums.all + vec3<f32>(sums.carried_all) * out.step;
        sums.change = sums.change + vec3<f32>(sums.carried_change) * (TURN_STEP * out.coarse);
    }
    write_vertex(vertex, base, base_normal, sums.all, sums.change);
}
