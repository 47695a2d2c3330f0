//! Changes to the SPIR-V that naga writes.

/// Words before the first instruction.
const HEADER: usize = 5;
const NO_CONTRACTION: u32 = 42;

mod op {
    pub const TYPE_VOID: u32 = 19;
    pub const TYPE_FORWARD_POINTER: u32 = 39;
    pub const ACCESS_CHAIN: u32 = 65;
    pub const DECORATE: u32 = 71;
    pub const F_NEGATE: u32 = 127;
    pub const F_ADD: u32 = 129;
    pub const F_SUB: u32 = 131;
    pub const F_MUL: u32 = 133;
    pub const F_DIV: u32 = 136;
    pub const VECTOR_TIMES_SCALAR: u32 = 142;
}

/// Opcode and words of each instruction. The first word holds the opcode and the length.
pub fn instructions(module: &[u32]) -> impl Iterator<Item = (u32, &[u32])> {
    let mut rest = &module[HEADER..];
    std::iter::from_fn(move || {
        let length = (*rest.first()? >> 16) as usize;
        let (instruction, after) = rest.split_at(length);
        rest = after;
        Some((instruction[0] & 0xFFFF, instruction))
    })
}

/// Joins each access chain with the one that it continues. naga steps from a buffer to its array, and from there to an element.
/// Synchronization validation does not see stores through the second step, so it would not report a missing barrier.
pub fn with_folded_chains(module: &[u32]) -> Vec<u32> {
    // The base and indices of each chain, already joined.
    let mut chains: Vec<(u32, Vec<u32>)> = Vec::new();
    let mut out = module[..HEADER].to_vec();
    for (opcode, words) in instructions(module) {
        if opcode != op::ACCESS_CHAIN {
            out.extend(words);
            continue;
        }
        let (result, mut base, mut indices) = (words[2], words[3], words[4..].to_vec());
        if let Some((_, before)) = chains.iter().find(|(id, _)| *id == base) {
            indices.splice(0..0, before[1..].iter().copied());
            base = before[0];
        }
        let length = 4 + indices.len() as u32;
        out.extend([length << 16 | op::ACCESS_CHAIN, words[1], result, base]);
        out.extend(&indices);
        indices.insert(0, base);
        chains.push((result, indices));
    }
    out
}

/// Decorates every floating-point operation with NoContraction. Drivers then fuse no multiplication with an addition, and the
/// results equal the CPU's.
pub fn without_contraction(module: &[u32]) -> Vec<u32> {
    use op::*;
    let decorations: Vec<u32> = instructions(module)
        .filter(|(opcode, _)| [F_NEGATE, F_ADD, F_SUB, F_MUL, F_DIV, VECTOR_TIMES_SCALAR].contains(opcode))
        .flat_map(|(_, words)| [3 << 16 | DECORATE, words[2], NO_CONTRACTION])
        .collect();
    // Annotations end where types begin.
    let before: usize = instructions(module)
        .take_while(|(opcode, _)| !(TYPE_VOID..=TYPE_FORWARD_POINTER).contains(opcode))
        .map(|(_, words)| words.len())
        .sum();
    let (head, tail) = module.split_at(HEADER + before);
    [head, &decorations, tail].concat()
}
