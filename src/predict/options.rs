//! What a set learned.

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
