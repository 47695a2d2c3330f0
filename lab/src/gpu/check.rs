//! Whether the device computed what the CPU does: a fast wrong answer is none.

use std::fmt;

use anyhow::{Result, ensure};
use xxhash_rust::xxh3::xxh3_64;

use super::engine::Gpu;

/// A unit in the last place at 1 m, which is the size of the bodies: 2^-23 m. (Places near 0 have far smaller ones, which
/// nobody sees.)
const ULP: f64 = f32::EPSILON as f64;
/// How far devices may be off that round divisions and square roots otherwise than IEEE 754 says: 2 µm.
pub const ULPS: f64 = 16.0;

/// How far two results agree.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Agreement {
    pub words: usize,
    /// Words whose bits differ.
    pub differing: usize,
    /// The largest difference, in units of 2^-23 m.
    pub ulps: f64,
    /// xxh3 of the device's bits.
    pub hash: u64,
}

impl Agreement {
    /// Holds the device's vertices against the CPU's: bits on software drivers, `most` units of 2^-23 m elsewhere.
    ///
    /// # Errors
    /// Where they are further apart.
    pub fn of(gpu: &Gpu, what: &str, (got, wanted): (&[f32], &[f32]), most: f64) -> Result<Self> {
        ensure!(got.len() == wanted.len(), "{what}: {} words for {}", got.len(), wanted.len());
        let a = Self::between(got, wanted);
        let well = if gpu.software { a.differing == 0 } else { a.ulps <= most };
        ensure!(
            well,
            "{what} on {}: {} of {} words differ, by up to {:.1} ulp",
            gpu.name,
            a.differing,
            a.words,
            a.ulps
        );
        Ok(a)
    }

    /// Of a result that was found to be what it should.
    pub fn same(got: &[f32]) -> Self {
        Self::between(got, got)
    }

    fn between(got: &[f32], wanted: &[f32]) -> Self {
        let mut a = Agreement { words: got.len(), differing: 0, ulps: 0.0, hash: xxh3_64(bytemuck::cast_slice(got)) };
        for (g, w) in got.iter().zip(wanted) {
            // Devices may take what is below 1.2e-38 for zero.
            if g.to_bits() == w.to_bits() || *g == 0.0 && w.is_subnormal() {
                continue;
            }
            a.differing += 1;
            let apart = (f64::from(*g) - f64::from(*w)).abs() / ULP;
            a.ulps = if apart.is_nan() { f64::INFINITY } else { a.ulps.max(apart) };
        }
        a
    }
}

impl fmt::Display for Agreement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.differing == 0 {
            return f.write_str("same bits");
        }
        write!(f, "{} of {} words differ by up to {:.2} ulp", self.differing, self.words, self.ulps)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_are_counted_and_measured() {
        let same = Agreement::between(&[1.0, 0.0, 0.0], &[1.0, 0.0, 1e-40]);
        assert_eq!((same.differing, same.ulps, same.to_string().as_str()), (0, 0.0, "same bits"));
        let off = Agreement::between(&[1.0 + 2.0 * f32::EPSILON, 0.0], &[1.0, f32::EPSILON]);
        assert_eq!((off.words, off.differing, off.ulps), (2, 2, 2.0));
        assert_eq!(Agreement::between(&[f32::NAN], &[1.0]).ulps, f64::INFINITY);
    }
}
