//! Instruction sets, and work that is compiled for each of them.

use crate::base::error::Error;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU8, Ordering};

/// Instruction sets that predictions and kernels are compiled for. The result has the same bits at every level.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum SimdLevel {
    /// The target's baseline: SSE2 on x86-64, NEON on AArch64.
    Portable = 1,
    /// AVX2: eight lanes.
    Avx2 = 2,
    /// AVX-512 (F, BW, DQ, VL, VNNI): sixteen lanes where they are faster.
    Avx512 = 3,
}

/// The level that [`SimdLevel::force`] set; 0: none.
static LEVEL: AtomicU8 = AtomicU8::new(0);

impl SimdLevel {
    /// Returns the best level of this processor. The environment variable `CRUMPLE_SIMD` caps it if it is `portable` or
    /// `avx2` at the first call, for tools that do not know newer instructions.
    pub fn best() -> Self {
        static BEST: OnceLock<SimdLevel> = OnceLock::new();
        *BEST.get_or_init(|| match std::env::var("CRUMPLE_SIMD").as_deref() {
            Ok("portable") => SimdLevel::Portable,
            Ok("avx2") => Self::of_processor().min(SimdLevel::Avx2),
            _ => Self::of_processor(),
        })
    }

    fn of_processor() -> Self {
        #[cfg(target_arch = "x86_64")]
        {
            use std::arch::is_x86_feature_detected as has;
            let has_512 =
                has!("avx512f") && has!("avx512bw") && has!("avx512dq") && has!("avx512vl") && has!("avx512vnni");
            if has_512 && has!("avx2") {
                return SimdLevel::Avx512;
            }
            if has!("avx2") {
                return SimdLevel::Avx2;
            }
        }
        SimdLevel::Portable
    }

    /// Returns the levels up to [`SimdLevel::best`], simplest first.
    pub fn available() -> impl Iterator<Item = SimdLevel> {
        [SimdLevel::Portable, SimdLevel::Avx2, SimdLevel::Avx512].into_iter().filter(|l| *l <= Self::best())
    }

    /// Returns the level in use in this process: the best, unless [`SimdLevel::force`] set another.
    pub fn current() -> Self {
        match LEVEL.load(Ordering::Relaxed) {
            1 => SimdLevel::Portable,
            2 => SimdLevel::Avx2,
            3 => SimdLevel::Avx512,
            _ => Self::best(),
        }
    }

    /// Sets the level of the whole process from now on. For tests and comparisons: results do not depend on the level.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the level is above [`SimdLevel::best`].
    pub fn force(self) -> Result<(), Error> {
        if self > Self::best() {
            return Err(Error::Unsupported { what: format!("{self:?}: this processor goes up to {:?}", Self::best()) });
        }
        LEVEL.store(self as u8, Ordering::Relaxed);
        Ok(())
    }
}

/// Work on many numbers that is compiled for every level: [`Work::run`] and what it calls must be inlined. Loops without branches
/// become vectors.
pub(crate) trait Work {
    type Done;
    fn run(self) -> Self::Done;
}

/// Does the work at the level in use.
pub(crate) fn widest<W: Work>(work: W) -> W::Done {
    #[cfg(target_arch = "x86_64")]
    {
        #[target_feature(enable = "avx2")]
        fn avx2<W: Work>(work: W) -> W::Done {
            work.run()
        }
        #[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx512vnni,avx2")]
        fn avx512<W: Work>(work: W) -> W::Done {
            work.run()
        }
        match SimdLevel::current() {
            // SAFETY: a level is in use only if the processor supports it.
            SimdLevel::Avx512 => return unsafe { avx512(work) },
            // SAFETY: the same.
            SimdLevel::Avx2 => return unsafe { avx2(work) },
            SimdLevel::Portable => {}
        }
    }
    work.run()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_that_the_processor_lacks_are_refused() {
        assert_eq!(SimdLevel::available().last(), Some(SimdLevel::best()));
        if SimdLevel::best() < SimdLevel::Avx512 {
            assert!(SimdLevel::Avx512.force().is_err());
        }
    }
}
