// What the kernels of both rules share: bindings, vectors, limits, and the host's formats.
//
// Every operation is written out, in the order of src/deform/kernel.rs. Built-ins whose result differs between devices (dot, mix,
// normalize, min, max, pack…) are not used.

override NORMALS: bool = false;
override TANGENTS: bool = false;
// Whether an output has another format than 32-bit floats.
override PACKED: bool = false;

var<immediate> call: Call;

// Meshes and examples. They do not change.
@group(0) @binding(0) var<storage, read> arena: array<u32>;
// The frame's lists, in rows. layout.wgsl declares their structs.
@group(0) @binding(1) var<storage, read> work: array<vec4<u32>>;
// The host's buffer, or a window of it.
@group(1) @binding(0) var<storage, read_write> vertices: array<u32>;

fn load_block_work(index: u32) -> BlockWork {
    let both = work[index >> 1u];
    let mine = select(both.xy, both.zw, (index & 1u) != 0u);
    return BlockWork(mine.x, mine.y);
}

fn load_target_work(index: u32) -> TargetWork {
    let row = call.targets + index * TARGET_ROWS;
    let a = work[row];
    let b = work[row + 1u];
    let c = work[row + 2u];
    let bias = bitcast<vec4<f32>>(work[row + 3u]);
    let scale = work[row + 4u];
    let d = work[row + 5u];
    let e = work[row + 6u];
    return TargetWork(
        a.x, a.y, a.z, a.w, b.x, b.y, b.z, b.w, c.x, c.y, c.z, c.w,
        bias.xyz, bias.w, bitcast<vec3<f32>>(scale.xyz), scale.w, d.x, d.y, d.z, d.w, e.x, bitcast<f32>(e.y), e.zw,
    );
}

fn arena_float(at: u32) -> f32 {
    return bitcast<f32>(arena[at]);
}

fn arena_vector(at: u32) -> vec3<f32> {
    return vec3(arena_float(at), arena_float(at + 1u), arena_float(at + 2u));
}

fn dot3(a: vec3<f32>, b: vec3<f32>) -> f32 {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

fn cross3(a: vec3<f32>, b: vec3<f32>) -> vec3<f32> {
    return vec3(a.y * b.z - b.y * a.z, a.z * b.x - b.z * a.x, a.x * b.y - b.x * a.y);
}

// The smaller of two numbers; `b` if `a` is not a number.
fn minimum(a: f32, b: f32) -> f32 {
    return select(b, a, a < b);
}

fn maximum(a: f32, b: f32) -> f32 {
    return select(b, a, a > b);
}

fn clamped(x: f32, low: f32, high: f32) -> f32 {
    return minimum(maximum(x, low), high);
}

// A vertex's number among floats of which the arena holds the upper halves.
fn half_float(at: u32, vertex: u32) -> f32 {
    return bitcast<f32>((arena[at + (vertex >> 1u)] >> ((vertex & 1u) * 16u)) << 16u);
}

// `LEAST_LENGTH` in src/mesh/limits.rs.
const LEAST_LENGTH: f32 = 1e-18;

// How far a vertex moves that would move by `length`, by its own stiffness and depth limit.
fn within_own_limits(t: TargetWork, vertex: u32, length: f32) -> f32 {
    var allowed = length;
    if t.gives != NONE {
        allowed = allowed * half_float(t.gives, vertex);
    }
    if t.depths != NONE {
        allowed = minimum(half_float(t.depths, vertex), allowed);
    }
    return allowed;
}

// `v` of unit length, or `other` where it has no length.
fn unit(v: vec3<f32>, other: vec3<f32>) -> vec3<f32> {
    let m = maximum(maximum(abs(v.x), abs(v.y)), abs(v.z));
    if !(m > 0.0 && m <= 3.4028234e38) {
        return other;
    }
    let w = v / m;
    return w / sqrt(dot3(w, w));
}

// `turned_as` in src/base/math.rs.
fn turned_as(a: vec3<f32>, b: vec3<f32>, t: vec3<f32>) -> vec3<f32> {
    var from_ = a;
    var v = t;
    if dot3(a, b) < -0.9999 {
        let towards = select(vec3(1.0, 0.0, 0.0), vec3(0.0, 0.0, 1.0), abs(a.z) < 0.99);
        let u = unit(towards - a * dot3(a, towards), towards);
        v = u * (2.0 * dot3(u, t)) - t;
        from_ = -a;
    }
    let c = cross3(from_, b);
    let w = cross3(c, v);
    return v + w + cross3(c, w) * (1.0 / (1.0 + dot3(from_, b)));
}

// `tangent` in src/deform/evaluate.rs.
fn tangent_of(base: vec4<f32>, base_normal: vec3<f32>, normal: vec3<f32>) -> vec4<f32> {
    if all(base_normal == normal) {
        return base;
    }
    let turned = turned_as(base_normal, normal, base.xyz);
    let flat = turned - normal * dot3(normal, turned);
    // `tangent_basis` in src/base/math.rs.
    let sign = select(1.0, -1.0, (bitcast<u32>(normal.z) >> 31u) != 0u);
    let a = -1.0 / (sign + normal.z);
    let b = normal.x * normal.y * a;
    let across = vec3(1.0 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x);
    return vec4(unit(flat, across), base.w);
}

// ----------------------------------------------------------------------------------------------------- the invocation's vertex

struct Vertex {
    wanted: bool,
    // Index of the block, of the vertex in the block, and of the vertex in the mesh.
    block: u32,
    v: u32,
    index: u32,
    out: TargetWork,
}

// A workgroup lies within one block. So what is read of the block and its target depends on the workgroup alone, and
// a device can read it once for all invocations. `first` is the invocation's vertex among those of its workgroup.
fn vertex_of(group: vec3<u32>, first: u32) -> Vertex {
    let number = group.y * call.row + group.x;
    // Workgroups beyond the last block read the data of the first.
    let slot = number >> call.split;
    let wanted = slot < call.count;
    let listed = load_block_work(call.blocks + select(0u, slot, wanted));
    let out = load_target_work(listed.target_index);
    let v = (number & ((1u << call.split) - 1u)) * (BLOCK >> call.split) + first;
    let index = listed.block * BLOCK + v;
    return Vertex(wanted && index < out.vertices, listed.block, v, index, out);
}

// ---------------------------------------------------------------------------------------------------- the host's formats
// The conversions of src/gpu/format.rs and src/deform/encoding.rs.

fn f16_bits(x: f32) -> u32 {
    let bits = bitcast<u32>(x);
    let sign = (bits >> 16u) & 0x8000u;
    let size = bits & 0x7FFFFFFFu;
    if size >= 0x477FE000u {
        return sign | select(0x7BFFu, 0x7E00u, size > 0x7F800000u);
    }
    if size < 0x38800000u {
        return sign | (bitcast<u32>(bitcast<f32>(size) + 0.5) - 0x3F000000u);
    }
    return sign | ((size - 0x38000000u + 0xFFFu + ((size >> 13u) & 1u)) >> 13u);
}

fn snorm_bits(x: f32, top: f32) -> u32 {
    let y = clamped(x, -1.0, 1.0) * top;
    return bitcast<u32>(i32(y + select(0.5, -0.5, y < 0.0)));
}

// A vector on the unfolded octahedron, each number 0 to 1.
fn octahedral(v: vec3<f32>) -> vec2<f32> {
    let length = abs(v.x) + abs(v.y) + abs(v.z);
    if !(length > 0.0 && length <= 3.4028234e38) {
        return vec2(0.5);
    }
    let n = v / length;
    let folded = (vec2(1.0) - abs(n.yx)) * select(vec2(-1.0), vec2(1.0), n.xy >= vec2(0.0));
    return select(folded, n.xy, n.z >= 0.0) * 0.5 + 0.5;
}

fn octahedral_words(o: vec2<f32>) -> u32 {
    return u32(o.x * 65535.0) | (u32(o.y * 65535.0) << 16u);
}

fn octahedral_tangent(v: vec4<f32>) -> u32 {
    let o = octahedral(v.xyz);
    let y = maximum(o.y, 1.0 / 32767.0) * 0.5 + 0.5;
    let words = octahedral_words(vec2(o.x, select(1.0 - y, y, v.w >= 0.0)));
    return select(words, 0xFFFFFFFFu, words == 0xFFFF0000u);
}

fn write4(at: u32, format: u32, v: vec4<f32>) {
    if format == F16X4 {
        vertices[at] = f16_bits(v.x) | (f16_bits(v.y) << 16u);
        vertices[at + 1u] = f16_bits(v.z) | (f16_bits(v.w) << 16u);
    } else if format == SNORM16X4 {
        vertices[at] = (snorm_bits(v.x, 32767.0) & 0xFFFFu) | (snorm_bits(v.y, 32767.0) << 16u);
        vertices[at + 1u] = (snorm_bits(v.z, 32767.0) & 0xFFFFu) | (snorm_bits(v.w, 32767.0) << 16u);
    } else {
        let low = (snorm_bits(v.x, 127.0) & 0xFFu) | ((snorm_bits(v.y, 127.0) & 0xFFu) << 8u);
        vertices[at] = low | ((snorm_bits(v.z, 127.0) & 0xFFu) << 16u) | (snorm_bits(v.w, 127.0) << 24u);
    }
}

fn write3(at: u32, v: vec3<f32>) {
    vertices[at] = bitcast<u32>(v.x);
    vertices[at + 1u] = bitcast<u32>(v.y);
    vertices[at + 2u] = bitcast<u32>(v.z);
}

fn write_position(t: TargetWork, vertex: u32, p: vec3<f32>) {
    let at = t.position_at + vertex * t.position_stride;
    let format = t.formats & 0xFFu;
    if !(PACKED && format != 0u) {
        write3(at, p);
    } else if format == F16X4 {
        write4(at, format, vec4(p, 1.0));
    } else {
        write4(at, format, vec4((p - t.bias) / t.scale, 1.0));
    }
}

fn write_normal(t: TargetWork, vertex: u32, n: vec3<f32>) {
    if t.normal_stride == 0u {
        return;
    }
    let at = t.normal_at + vertex * t.normal_stride;
    let format = (t.formats >> 8u) & 0xFFu;
    if !(PACKED && format != 0u) {
        write3(at, n);
    } else if format == OCTAHEDRAL16X2 {
        vertices[at] = octahedral_words(octahedral(n));
    } else {
        write4(at, format, vec4(n, 0.0));
    }
}

fn write_tangent(t: TargetWork, vertex: u32, v: vec4<f32>) {
    let at = t.tangent_at + vertex * t.tangent_stride;
    let format = (t.formats >> 16u) & 0xFFu;
    if !(PACKED && format != 0u) {
        write3(at, v.xyz);
        vertices[at + 3u] = bitcast<u32>(v.w);
    } else if format == OCTAHEDRAL16X2 {
        vertices[at] = octahedral_tangent(v);
    } else {
        write4(at, format, v);
    }
}

// Writes a vertex's normal, and its tangent, which turns as the normal does.
fn write_directions(t: TargetWork, vertex: u32, base_normal: vec3<f32>, normal: vec3<f32>) {
    write_normal(t, vertex, normal);
    if TANGENTS && t.tangent_stride != 0u {
        let at = t.base_tangents + 4u * vertex;
        let tangent = vec4(arena_vector(at), arena_float(at + 3u));
        write_tangent(t, vertex, tangent_of(tangent, base_normal, normal));
    }
}
