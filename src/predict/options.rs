//! What a set is told to learn, and what it learned.

/// What to learn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LearnOptions {
    /// Whether examples may count mirrored in the symmetric planes of the body. They do if that predicts better.
    pub mirror: bool,
}

impl Default for LearnOptions {
    fn default() -> Self {
        Self { mirror: true }
    }
}

/// What a set learned.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Learned {
    /// Relative L2 error of each sample's field when the others predict it from the blow (from the displacement if it
    /// knows no blow), in the order of the samples.
    pub errors: Vec<f32>,
    /// The same from the displacement, whatever is known of blows.
    pub displacement_errors: Vec<f32>,
    /// Share of the anchored part for blows and for displacements, 0 to 1.
    pub anchored: [f32; 2],
    /// Exponent of the stretch, likewise.
    pub stretch: [f32; 2],
    /// Whether mirror images count, likewise.
    pub mirrored: [bool; 2],
}
