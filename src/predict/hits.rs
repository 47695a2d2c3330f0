//! A hit and what is predicted of it.

use super::Strike;
use glam::Vec3;

/// What is known of a hit's strength.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Told {
    /// The blow, as [`Predictor::strike`](super::Predictor::strike) reads it.
    Strike(Strike),
    /// The displacement of the contact, m.
    Displacement(Vec3),
}

/// A hit on the undented body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Where the body is hit, m.
    pub contact: Vec3,
    /// Unit normal of the body there, out of it.
    pub normal: Vec3,
    /// How hard.
    pub told: Told,
}

/// What is predicted of a hit, besides its field.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Prediction {
    /// Root of the sum of the squared displacements of all points, m. 0 if the hit leaves nothing. A harder blow is
    /// never predicted smaller.
    pub size: f32,
    /// Displacement of the point nearest to the contact if no rim were held, m.
    pub depth: f32,
    /// Expected relative L2 error of the field; 1 is the error of no dent at all.
    pub expected_error: f32,
}
