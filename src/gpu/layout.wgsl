// The data that the CPU packs for a frame. build/layout.rs writes these constants and structs in Rust.
//
// A row is four words, which the kernels read at once. Each struct begins at a row; two `BlockWork` share one.

// Vertices a block.
const BLOCK = 128u;
// Stands for no offset.
const NONE = 0xFFFFFFFFu;

// Number formats of the host: Encoding in src/deform/encoding.rs.
const F16X4 = 1u;
const SNORM16X4 = 2u;
const SNORM8X4 = 3u;
const OCTAHEDRAL16X2 = 4u;

// Flag of a target that follows nodes: the depth limit may be reached.
const LIMITED = 1u;
// Vertices a tile, and the unit of weights: src/basis/mod.rs.
const TILE = 16u;
const WEIGHT: f32 = 0.015625;

// Flag of a target with a classic rule: the vertices are at rest and have no state yet.
const AT_REST = 1u;

// What differs from dispatch to dispatch.
struct Call {
    // Index of the dispatch's first block.
    blocks: u32,
    // First rows of the lists: targets, parts (nodes, or hits of a classic rule), states of a classic rule.
    targets: u32,
    parts: u32,
    states: u32,
    // Workgroups in a row, blocks in all, and the power of two of workgroups that share a block.
    row: u32,
    count: u32,
    split: u32,
}

// A block to write.
struct BlockWork {
    // Index of its target.
    target_index: u32,
    // Index of the block in the mesh.
    block: u32,
}

// A target with a block to write.
struct TargetWork {
    // First words in the arena: base positions, normals and tangents.
    base_positions: u32,
    base_normals: u32,
    base_tangents: u32,
    vertices: u32,
    // First words in the host's buffer, and words from one vertex to the next. A stride of 0 stands for no output.
    position_at: u32,
    position_stride: u32,
    normal_at: u32,
    normal_stride: u32,
    tangent_at: u32,
    tangent_stride: u32,
    // Number formats, a byte each: positions, normals, tangents.
    formats: u32,
    flags: u32,
    // Positions in normalised integers are stored as (p - bias) / scale.
    bias: vec3<f32>,
    // The depth limit, m; for a classic rule the constant that it blends with.
    limit: f32,
    scale: vec3<f32>,
    // For a classic rule: first word of the state that the CPU copies, or NONE.
    given_state: u32,
    // Of a classic rule: the first of its hits, in rows from the first part of the frame, and the end of them. Of nodes, two a row: where
    // the body's first would be; only those that the listed blocks follow are there.
    parts_begin: u32,
    parts_end: u32,
    // First words of the vertices' depth limits and of 1 - stiffness in the arena, or NONE: the upper halves of floats.
    depths: u32,
    gives: u32,
    // First word of the tiles in the arena, and the step of the nodes' displacements, m.
    tiles: u32,
    node_step: f32,
    padding: vec2<u32>,
}

// Rows of a `TargetWork`.
const TARGET_ROWS = 7u;

// A hit on a body with a classic rule.
struct ClassicHit {
    // The example's first word in the arena.
    example: u32,
    position_step: f32,
    normal_step: f32,
    weight: f32,
}
