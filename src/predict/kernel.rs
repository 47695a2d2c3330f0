//! The covariance of two hits: Matern 3/2 with a length for each group of features.

/// Groups of features: place, normal, energy or depth, mass, radius, direction, kind.
pub(super) const GROUPS: usize = 7;
/// The group of the energy of a blow, or of the depth of a displacement; its feature is a logarithm.
pub(super) const STRENGTH: usize = 2;

/// Logarithms of the length of each group, and of the variance of the noise over that of the process.
pub(super) type Lengths = [f64; GROUPS + 1];

/// Factors of squared differences: 3 over the squared lengths.
pub(super) fn factors(lengths: &Lengths) -> [f64; GROUPS] {
    std::array::from_fn(|g| 3.0 * exp(-2.0 * lengths[g].clamp(-4.0, 6.0)))
}

/// Variance of the noise over that of the process.
pub(super) fn noise_ratio(lengths: &Lengths) -> f64 {
    exp(lengths[GROUPS].clamp(-12.0, 6.0))
}

/// The exponential for arguments from -700 to 700, to 1e-9. Only additions and products, so that compilers vectorize it
/// and every platform gives the same bits.
#[inline]
pub(super) fn exp(x: f64) -> f64 {
    const MAGIC: f64 = 6_755_399_441_055_744.0; // 1.5 * 2^52: adding it rounds to integers
    let x = x.clamp(-700.0, 700.0);
    let t = x * std::f64::consts::LOG2_E + MAGIC;
    let k = t - MAGIC;
    let r = (x - k * 0.693_147_180_369_123_8) - k * 1.908_214_929_270_587_7e-10;
    let p = 1.0 / 40320.0;
    let p = p * r + 1.0 / 5040.0;
    let p = p * r + 1.0 / 720.0;
    let p = p * r + 1.0 / 120.0;
    let p = p * r + 1.0 / 24.0;
    let p = p * r + 1.0 / 6.0;
    let p = p * r + 0.5;
    let p = p * r + 1.0;
    let p = p * r + 1.0;
    p * f64::from_bits(t.to_bits().wrapping_add(1023) << 52)
}

/// Matern 3/2 of 3 times the squared scaled distance.
#[inline]
pub(super) fn matern(d2: f64) -> f64 {
    let d = (d2 + 1e-12).sqrt();
    (1.0 + d) * exp(-d)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponential_and_covariance_have_their_values() {
        for x in [-600.0, -30.0, -1.0, -1e-9, 0.0, 0.3, 5.0] {
            assert!((exp(x) / f64::exp(x) - 1.0).abs() < 1e-9, "{x}");
        }
        assert!((matern(0.0) - 1.0).abs() < 1e-9);
        // One length apart: (1 + sqrt 3) exp(-sqrt 3).
        assert!((matern(3.0) - 0.483_357_7).abs() < 1e-6);
    }
}
