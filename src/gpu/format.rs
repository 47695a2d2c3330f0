//! The number formats in which a host stores vertex attributes. `common.wgsl` converts to them.

use crate::deform::Encoding;

/// A vertex attribute.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Attribute {
    /// In metres. A fourth number is 1.
    Position,
    /// A unit vector. A fourth number is 0.
    Normal,
    /// A unit vector. The fourth number is the base tangent's.
    Tangent,
}

impl Encoding {
    /// The size of a value in bytes.
    pub(crate) fn bytes(self, attribute: Attribute) -> u64 {
        match (self, attribute) {
            (Encoding::F32, Attribute::Tangent) => 16,
            (Encoding::F32, _) => 12,
            (Encoding::F16x4 | Encoding::Snorm16x4, _) => 8,
            (Encoding::Snorm8x4 | Encoding::Octahedral16x2, _) => 4,
        }
    }
}

impl Attribute {
    /// All attributes.
    pub(crate) const ALL: [Attribute; 3] = [Attribute::Position, Attribute::Normal, Attribute::Tangent];

    /// The encodings that it can have.
    pub(crate) fn encodings(self) -> &'static [Encoding] {
        match self {
            Attribute::Position => &[Encoding::F32, Encoding::F16x4, Encoding::Snorm16x4],
            _ => &[Encoding::F32, Encoding::Snorm16x4, Encoding::Snorm8x4, Encoding::Octahedral16x2],
        }
    }

    pub(crate) fn name(self) -> &'static str {
        match self {
            Attribute::Position => "position",
            Attribute::Normal => "normal",
            Attribute::Tangent => "tangent",
        }
    }

    pub(crate) fn plural(self) -> String {
        format!("{}s", self.name())
    }
}
