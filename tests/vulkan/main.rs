//! Deformation recorded into Vulkan command buffers, on every driver there is, under core and synchronization validation. The
//! vertices are the CPU's (see `tests/gpu/compare.rs`), and nothing else is written.

mod backend;
#[path = "../gpu/mod.rs"]
mod gpu;
mod harness;
#[path = "../scenes/mod.rs"]
mod scenes;
#[path = "../../build/spirv.rs"]
mod spirv;

mod errors;
mod frames;
mod graph;

/// What the build does to SPIR-V: no access chain continues another, and no operation may be contracted.
#[test]
fn chains_are_folded_and_nothing_is_contracted() {
    let op = |opcode: u32, words: &[u32]| [&[(words.len() as u32 + 1) << 16 | opcode], words].concat();
    let header = vec![0x0723_0203, 0x0001_0300, 0, 20, 0];
    let module = [
        header.clone(),
        op(71, &[7, 33, 0]),       // decorate %7 binding 0
        op(22, &[1, 32]),          // %1 = type float
        op(65, &[2, 9, 7, 3]),     // %9 = chain %7 [%3]
        op(65, &[2, 10, 9, 4]),    // %10 = chain %9 [%4]
        op(65, &[2, 11, 10, 5]),   // %11 = chain %10 [%5]
        op(129, &[1, 12, 13, 14]), // %12 = %13 + %14
    ]
    .concat();
    let folded = spirv::with_folded_chains(&module);
    let chains: Vec<&[u32]> = spirv::instructions(&folded).filter(|(o, _)| *o == 65).map(|(_, w)| &w[1..]).collect();
    assert_eq!(chains, [&[2, 9, 7, 3][..], &[2, 10, 7, 3, 4], &[2, 11, 7, 3, 4, 5]]);
    let exact = spirv::without_contraction(&module);
    assert_eq!(exact[header.len()..][..7], [4 << 16 | 71, 7, 33, 0, 3 << 16 | 71, 12, 42]);
    assert_eq!(exact.len(), module.len() + 3);
}
