//! Compiles each kernel for each level and calls the one in use.

use super::follow::{self, Following, Moves, Normals};
use super::kernel::{self, Flat};
use super::simd::Portable;
#[cfg(target_arch = "x86_64")]
use super::simd::{Avx2, Avx512};
use crate::base::simd::SimdLevel;
use crate::mesh::vertex_blocks::BLOCK;
use glam::Vec3;

type Bounds = (Vec3, Vec3);

/// Compiles a kernel for a level's instructions, as a function with the same arguments.
macro_rules! compiled {
    ($name:ident, $features:literal, $kernel:expr, ($($arg:ident: $of:ty),*) -> $out:ty) => {
        #[cfg(target_arch = "x86_64")]
        #[target_feature(enable = $features)]
        fn $name($($arg: $of),*) -> $out {
            // SAFETY: the attribute enables the instructions.
            unsafe { $kernel($($arg),*) }
        }
    };
}

compiled!(octahedral_avx2, "avx2", kernel::octahedral::<Avx2>, (normals: &Flat, to: &mut [u32; BLOCK]) -> ());
compiled!(follow_avx2, "avx2", follow::follow::<Avx2, 2, false>,
    (block: &Following<'_>, moves: &mut Moves, positions: &mut Flat, normals: Normals<'_>) -> Bounds);
compiled!(follow_normals_avx2, "avx2", follow::follow::<Avx2, 2, true>,
    (block: &Following<'_>, moves: &mut Moves, positions: &mut Flat, normals: Normals<'_>) -> Bounds);
compiled!(follow_avx512, "avx512f,avx512bw,avx512dq,avx512vl,avx512vnni,avx2", follow::follow::<Avx512, 1, false>,
    (block: &Following<'_>, moves: &mut Moves, positions: &mut Flat, normals: Normals<'_>) -> Bounds);
compiled!(follow_normals_avx512, "avx512f,avx512bw,avx512dq,avx512vl,avx512vnni,avx2", follow::follow::<Avx512, 1, true>,
    (block: &Following<'_>, moves: &mut Moves, positions: &mut Flat, normals: Normals<'_>) -> Bounds);

/// [`follow::follow`].
#[inline]
pub(crate) fn follow(block: &Following<'_>, moves: &mut Moves, positions: &mut Flat, normals: Normals<'_>) -> Bounds {
    // SAFETY: a level is in use only if the processor supports it.
    unsafe {
        match (SimdLevel::current(), normals.is_some()) {
            #[cfg(target_arch = "x86_64")]
            (SimdLevel::Avx512, false) => follow_avx512(block, moves, positions, normals),
            #[cfg(target_arch = "x86_64")]
            (SimdLevel::Avx512, true) => follow_normals_avx512(block, moves, positions, normals),
            #[cfg(target_arch = "x86_64")]
            (SimdLevel::Avx2, false) => follow_avx2(block, moves, positions, normals),
            #[cfg(target_arch = "x86_64")]
            (SimdLevel::Avx2, true) => follow_normals_avx2(block, moves, positions, normals),
            (_, false) => follow::follow::<Portable, 2, false>(block, moves, positions, normals),
            (_, true) => follow::follow::<Portable, 2, true>(block, moves, positions, normals),
        }
    }
}

/// [`kernel::octahedral`].
#[inline]
pub(crate) fn octahedral(normals: &Flat, to: &mut [u32; BLOCK]) {
    match SimdLevel::current() {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: as above.
        SimdLevel::Avx2 | SimdLevel::Avx512 => unsafe { octahedral_avx2(normals, to) },
        // SAFETY: always supported.
        _ => unsafe { kernel::octahedral::<Portable>(normals, to) },
    }
}
