//! From all examples of a set to the displacement field of a hit, at given points of the body.
//!
//! The field is the product of a size and a shape. Both are Gaussian process regressions over what is known of a hit
//! (see `features`). The shape is the sum of two parts. The *carried* part is what dents look like: all examples,
//! resampled once into the frame of their contacts (`stamp`), mixed with kriging weights and read at the contact. The
//! *anchored* part is what places do: the examples where they were made. Each set learns lengths, noise and the share of
//! both parts from its own examples (`learn`). `docs/model.md` has the equations.
//!
//! Everything is computed with IEEE operations, in a fixed order, in double precision where sums are long. So the
//! result has the same bits on every platform.

mod body;
mod features;
mod fit;
mod flat;
mod hits;
mod kernel;
mod kriging;
mod learn;
mod linear;
mod own;
mod predictor;
mod rank;
mod size;
mod stamp;
#[cfg(test)]
mod tests;

pub use body::{Body, Sample};
pub use features::Strike;
pub use hits::{Blow, Hit, Prediction, Told};
pub use own::Fields;
pub(crate) use predictor::MOST_SCALE;
pub use predictor::{Predictor, Scratch};
