// Vertices that follow nodes: weighted sums of the nodes' displacements. An invocation computes one vertex, with the operations of
// `follow` in src/deform/follow.rs. All sums are whole numbers below 2^24.

// Words of a tile's head: its first node, the number of its nodes, its first weight, its first slope, the first unit of its slopes
// (1/m). All but the number count words from the tiles on.
const TILE_WORDS = 5u;
// Words of the weights of a pair of nodes: two vertices a word.
const PAIR_WORDS = TILE / 2u;

// The steps of a node along x, y and z.
fn node_steps(first: u32, node: u32) -> vec3<i32> {
    let row = work[first + (node >> 1u)];
    let words = select(row.xy, row.zw, (node & 1u) != 0u);
    let xy = bitcast<vec2<i32>>(words);
    return vec3((xy.x << 16u) >> 16u, xy.x >> 16u, (xy.y << 16u) >> 16u);
}

// The two weights of a vertex of the tile for a pair of nodes.
fn weights_of(pair: u32, v: u32) -> vec2<i32> {
    let both = bitcast<i32>(arena[pair + (v >> 1u)] << ((1u - (v & 1u)) * 16u));
    return vec2((both << 8u) >> 24u, both >> 24u);
}

@compute @workgroup_size(128)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let vertex = vertex_of(group, local);
    if !vertex.wanted {
        return;
    }
    let out = vertex.out;
    let v = vertex.index % TILE;
    let head = out.tiles + (vertex.index / TILE) * TILE_WORDS;
    let nodes = out.tiles + arena[head];
    let pairs = arena[head + 1u] >> 1u;
    let weights = out.tiles + arena[head + 2u];
    let slopes = out.tiles + arena[head + 3u];
    let steps = call.parts + out.parts_begin;
    var moved = vec3(0);
    var along_x = vec3(0);
    var along_y = vec3(0);
    for (var pair = 0u; pair < pairs; pair += 1u) {
        let a = node_steps(steps, arena[nodes + 2u * pair]);
        let b = node_steps(steps, arena[nodes + 2u * pair + 1u]);
        let w = weights_of(weights + pair * PAIR_WORDS, v);
        moved += a * w.x + b * w.y;
        if NORMALS {
            let x = weights_of(slopes + pair * PAIR_WORDS, v);
            let y = weights_of(slopes + (pairs + pair) * PAIR_WORDS, v);
            along_x += a * x.x + b * x.y;
            along_y += a * y.x + b * y.y;
        }
    }
    let base = arena_vector(out.base_positions + 3u * vertex.index);
    let s = vec3<f32>(moved) * (out.node_step * WEIGHT);
    var n = vec3(0.0);
    var change = vec3(0.0);
    if NORMALS {
        n = arena_vector(out.base_normals + 3u * vertex.index);
        let unit = out.node_step * arena_float(out.tiles + arena[head + 4u] + v);
        let a = vec3<f32>(along_x) * unit;
        let b = vec3<f32>(along_y) * unit;
        // The tangents of the normal: `turned` in src/deform/follow.rs.
        let sign = select(1.0, -1.0, 0.0 > n.z);
        let c = -1.0 / (sign + n.z);
        let d = n.x * n.y * c;
        let sx = sign * n.x;
        let x = vec3(1.0 + sx * n.x * c, sign * d, 0.0 - sx);
        let y = vec3(d, sign + n.y * n.y * c, 0.0 - n.y);
        change = cross3(x, b) + cross3(a, y) + cross3(a, b);
    }
    write_vertex(vertex, base, n, s, change);
}
