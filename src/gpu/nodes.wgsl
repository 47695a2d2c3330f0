// Vertices that follow nodes: weighted sums of the nodes' displacements. An invocation computes two vertices of a
// tile, with the operations of `follow` in src/deform/follow.rs, so that the nodes' displacements are read once for both. All sums are
// whole numbers below 2^24.

// Words of a tile's head: its first node, the number of its nodes, its first weight, its first slope, the first unit of its slopes
// (1/m). All but the number count words from the tiles on.
const TILE_WORDS = 5u;
// Words of the weights of a pair of nodes: two vertices a word.
const PAIR_WORDS = TILE / 2u;

// The steps of a node along x, y and z.
fn node_steps(first: u32, node: u32) -> vec3<i32> {
    let row = first + (node >> 1u);
    let half = (node & 1u) << 1u;
    let xy = bitcast<i32>(work[row][half]);
    let z = bitcast<i32>(work[row][half + 1u]);
    return vec3((xy << 16u) >> 16u, xy >> 16u, (z << 16u) >> 16u);
}

// The weights of two vertices for a pair of nodes, which are the bytes of a word: first vertex, then node.
fn four(word: u32) -> vec4<i32> {
    let w = bitcast<i32>(word);
    return vec4((w << 24u) >> 24u, (w << 16u) >> 24u, (w << 8u) >> 24u, w >> 24u);
}

// The sums of a vertex: its displacement and its slopes along both tangents, in units.
struct Sums {
    moved: vec3<i32>,
    along_x: vec3<i32>,
    along_y: vec3<i32>,
}

@compute @workgroup_size(128)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let vertex = vertex_of(group, 2u * local);
    if !vertex.wanted {
        return;
    }
    let out = vertex.out;
    let v = vertex.index % TILE;
    let head = out.tiles + (vertex.index / TILE) * TILE_WORDS;
    let nodes = out.tiles + arena[head];
    let pairs = arena[head + 1u] >> 1u;
    let weights = out.tiles + arena[head + 2u] + (v >> 1u);
    let slopes = out.tiles + arena[head + 3u] + (v >> 1u);
    let steps = call.parts + out.parts_begin;
    var first = Sums();
    var second = Sums();
    for (var pair = 0u; pair < pairs; pair += 1u) {
        let a = node_steps(steps, arena[nodes + 2u * pair]);
        let b = node_steps(steps, arena[nodes + 2u * pair + 1u]);
        let w = four(arena[weights + pair * PAIR_WORDS]);
        first.moved += a * w.x + b * w.y;
        second.moved += a * w.z + b * w.w;
        if NORMALS {
            let x = four(arena[slopes + pair * PAIR_WORDS]);
            let y = four(arena[slopes + (pairs + pair) * PAIR_WORDS]);
            first.along_x += a * x.x + b * x.y;
            second.along_x += a * x.z + b * x.w;
            first.along_y += a * y.x + b * y.y;
            second.along_y += a * y.z + b * y.w;
        }
    }
    let slope_unit = out.tiles + arena[head + 4u] + v;
    write(vertex, first, slope_unit);
    if vertex.index + 1u < out.vertices {
        write(Vertex(true, vertex.block, vertex.v + 1u, vertex.index + 1u, out), second, slope_unit + 1u);
    }
}

// The unit vector along `n + change`; `n` itself if the `sum` of changes is zero.
fn normal_of(n: vec3<f32>, sum: vec3<f32>, change: vec3<f32>) -> vec3<f32> {
    let v = n + change;
    let square = dot3(v, v);
    if all(sum == vec3(0.0)) || !(square > 1e-12 && square < 1e38) {
        return n;
    }
    return v * (1.0 / sqrt(square));
}

// Writes a vertex; the unit of its slopes (1/m) is at `slope_unit`.
fn write(vertex: Vertex, sums: Sums, slope_unit: u32) {
    let out = vertex.out;
    let base = arena_vector(out.base_positions + 3u * vertex.index);
    var u = vec3<f32>(sums.moved) * (out.node_step * WEIGHT);
    var n = vec3(0.0);
    var turn = vec3(0.0);
    if NORMALS {
        n = arena_vector(out.base_normals + 3u * vertex.index);
        let unit = out.node_step * arena_float(slope_unit);
        let a = vec3<f32>(sums.along_x) * unit;
        let b = vec3<f32>(sums.along_y) * unit;
        // The tangents of the normal: `turned` in src/deform/follow.rs.
        let sign = select(1.0, -1.0, 0.0 > n.z);
        let c = -1.0 / (sign + n.z);
        let d = n.x * n.y * c;
        let sx = sign * n.x;
        let x = vec3(1.0 + sx * n.x * c, sign * d, 0.0 - sx);
        let y = vec3(d, sign + n.y * n.y * c, 0.0 - n.y);
        turn = cross3(x, b) + cross3(a, y) + cross3(a, b);
    }
    var change = turn;
    let limited = (out.flags & LIMITED) != 0u;
    if limited || out.depths != NONE || out.gives != NONE {
        let length = maximum(sqrt(dot3(u, u)), LEAST_LENGTH);
        var allowed = within_own_limits(out, vertex.index, length);
        if limited {
            allowed = minimum(out.limit, allowed);
        }
        if length > allowed {
            let factor = allowed / length;
            u = u * factor;
            change = change * factor;
        }
    }
    write_position(out, vertex.index, base + u);
    if NORMALS {
        write_directions(out, vertex.index, n, normal_of(n, turn, change));
    }
}
