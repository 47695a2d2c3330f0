// The data that the CPU packs for a frame. build/layout.rs checks that the structs of src/gpu/layout.rs have these members at
// these offsets, defines the constants in Rust, and generates a `load_…` function for each struct that a kernel reads.
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

// Flag of a target with marks: the depth limit may be reached.
const LIMITED = 1u;
// Vertices a tile, and the unit of weights: src/basis/mod.rs.
const TILE = 64u;
const WEIGHT: f32 = 0.015625;

// Flag of a target with a classic rule: the vertices are at rest and have no state yet.
const AT_REST = 1u;

// The weights of a bilinear mean sum to this.
const WEIGHTS: f32 = 16384.0;
// The step of changes of normals by carried examples, and the most steps that one dent contributes.
const TURN_STEP: f32 = 0.0000002384185791015625;
const MOST_STEPS: f32 = 134217728.0;
// The step of the stored cosine between a normal and the stamp's z, over WEIGHTS.
const FACING: f32 = 1.0 / (32767.0 * 16384.0);

// What differs from dispatch to dispatch.
struct Call {
    // Index of the dispatch's first block.
    blocks: u32,
    // First rows of the lists: targets, parts, carried examples. For a classic rule `parts` are hits, and `carried` are states.
    targets: u32,
    parts: u32,
    carried: u32,
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
    // First words in the arena: base positions, normals and tangents, bounds of blocks.
    base_positions: u32,
    base_normals: u32,
    base_tangents: u32,
    block_bounds: u32,
    // First words in the host's buffer, and words from one vertex to the next. A stride of 0 stands for no output.
    position_at: u32,
    position_stride: u32,
    normal_at: u32,
    normal_stride: u32,
    tangent_at: u32,
    tangent_stride: u32,
    // Number formats, a byte each: positions, normals, tangents.
    formats: u32,
    vertices: u32,
    // Positions in normalised integers are stored as (p - bias) / scale.
    bias: vec3<f32>,
    // The depth limit, m; for a classic rule the constant that it blends with.
    limit: f32,
    scale: vec3<f32>,
    flags: u32,
    // The first of its parts, in rows from the first part of the frame, and the end of them. For a classic rule they are hits.
    parts_begin: u32,
    parts_end: u32,
    // First word of the windows of held rims in the arena, or NONE.
    windows: u32,
    // For a classic rule: first word of the state that the CPU copies, or NONE.
    given_state: u32,
    // First words of the vertices' depth limits and of 1 - stiffness in the arena, or NONE: the upper halves of floats.
    depths: u32,
    gives: u32,
    // Of displacements of carried examples: a step, m, and steps per m. Powers of two.
    step: f32,
    per_step: f32,
    // Factor of the steps: 1, or a power of two where many dents overlap. `step` and `per_step` include it.
    coarse: f32,
    // For vertices that follow nodes: first word of the tiles in the arena, and the step of the nodes' displacements, m. The parts
    // are then the nodes, two a row.
    tiles: u32,
    @size(8) node_step: f32,
}

// A dent. Its parts follow.
struct DentHead {
    contact: vec3<f32>,
    // Nothing further from the contact moves, m².
    reach_square: f32,
    @size(16) parts: u32,
}

// What moves vertices in a dent: an anchored example, or carried examples at one contact.
struct DentPart {
    scale: f32,
    // For an anchored example.
    normal_scale: f32,
    // Displacements with a length of this square or less are dropped, in the units of the examples. -1 keeps all.
    dropped_square: f32,
    // The number of carried examples; 0 stands for an anchored one.
    lookups: u32,
    // Anchored: the example's first word in the arena. Carried: the first row of its `CarriedWork` among those of the frame.
    @size(16) source: u32,
}

// Carried examples at one contact: `Carried` in src/damage/carried.rs. Its `LookupWork`s follow.
struct CarriedWork {
    contact: vec3<f32>,
    // Columns of the matrix into the shared frame.
    to_frame_x: vec3<f32>,
    to_frame_y: vec3<f32>,
    to_frame_z: vec3<f32>,
}

// A carried example: `Lookup` in src/damage/carried.rs. Names that end in x and y are columns of matrices.
struct LookupWork {
    to_grid_x: vec2<f32>,
    to_grid_y: vec2<f32>,
    origin: vec2<f32>,
    last: vec2<f32>,
    // First word of the stamp's nodes in the arena, and nodes along x.
    nodes: u32,
    columns: u32,
    stretch_square: f32,
    height: f32,
    displacement_x: vec2<f32>,
    displacement_y: vec2<f32>,
    displacement_z: f32,
    fade: f32,
    @size(8) normal_z: f32,
    normal_x: vec2<f32>,
    normal_y: vec2<f32>,
}

// A hit on a body with a classic rule.
struct ClassicHit {
    // The example's first word in the arena.
    example: u32,
    position_step: f32,
    normal_step: f32,
    weight: f32,
}
