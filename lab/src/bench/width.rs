//! How exactly displacements are stored: the one place that says which options give which width.

use crumple::SetOptions;

/// Of a stored component of a displacement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Width {
    F32,
    I16,
    I8,
}

impl Width {
    pub const ALL: [Width; 3] = [Width::F32, Width::I16, Width::I8];

    /// As in the names of results.
    pub fn name(self) -> &'static str {
        match self {
            Width::F32 => "f32",
            Width::I16 => "i16",
            Width::I8 => "i8",
        }
    }

    /// Steps that the largest component takes. 16 bits: half of what they hold, far more than 8 bits do.
    fn steps(self) -> Option<f32> {
        match self {
            Width::F32 => None,
            Width::I16 => Some(16_000.0),
            Width::I8 => Some(127.0),
        }
    }
}

/// The tolerance (m) at which components up to `largest` (m) are stored in this width; `None` for exact f32. A step of
/// `2 tolerance / sqrt(3)` leaves a vertex within the tolerance.
pub fn tolerance(width: Width, largest: f32) -> Option<f32> {
    // A little above, so that rounding does not make it one step more.
    width.steps().map(|steps| 1.002 * largest / steps * 3f32.sqrt() / 2.0)
}

/// Options of a set whose largest component of any displacement is `largest`, m.
/// What `crumple bake` takes where nothing else is said, m.
pub const BAKED: f32 = 1e-4;

/// Options of a set as it is baked for a game.
pub fn baked() -> SetOptions {
    SetOptions { tolerance: Some(BAKED), ..SetOptions::default() }
}

pub fn options(width: Width, largest: f32) -> SetOptions {
    SetOptions { tolerance: tolerance(width, largest), ..SetOptions::default() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_component_fits_its_width() {
        let step = |w| 2.0 * tolerance(w, 0.05).unwrap() / 3f32.sqrt();
        assert!((0.05 / step(Width::I8)).round() <= 127.0);
        assert!((127.0..32767.0).contains(&(0.05 / step(Width::I16)).round()));
        assert_eq!(tolerance(Width::F32, 0.05), None);
    }
}
