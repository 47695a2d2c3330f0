//! What an instance knows of the parts of its body.

/// Bit `n` stands for the set's mesh `n`.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct PartState {
    /// The part that this instance is; 0: the whole body.
    pub of: usize,
    /// Parts that are not on the body.
    pub released: u64,
    /// Parts that hits do not dent.
    pub rigid: u64,
}
