//! Compiles each kernel for each level and calls the one in use.

use super::follow::{self, Following};
use super::kernel::{self, Block, CarriedSums, Flat};
#[cfg(target_arch = "x86_64")]
use super::simd::{Avx2, Avx512};
use super::simd::{Portable, SimdLevel};
use crate::example::blocks::Stored;
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

compiled!(stored_avx2, "avx2", kernel::displace_stored::<Avx2>,
    (base: &[f32], stored: &Stored<'_>, scale: f32, to: &mut [f32]) -> Bounds);
compiled!(turn_avx2, "avx2", kernel::turn_stored::<Avx2>,
    (base: &Flat, stored: &Stored<'_>, scale: f32, to: &mut Flat) -> ());
compiled!(octahedral_avx2, "avx2", kernel::octahedral::<Avx2>, (normals: &Flat, to: &mut [u32; BLOCK]) -> ());
compiled!(longest_avx2, "avx2", kernel::longest::<Avx2>, (stored: &Stored<'_>) -> f32);
compiled!(stored_positions_avx2, "avx2", kernel::displace::<Avx2, false, false>,
    (block: &Block<'_>, kept: Option<&mut CarriedSums>, positions: &mut Flat, normals: &mut Flat) -> Bounds);
compiled!(stored_normals_avx2, "avx2", kernel::displace::<Avx2, true, false>,
    (block: &Block<'_>, kept: Option<&mut CarriedSums>, positions: &mut Flat, normals: &mut Flat) -> Bounds);
compiled!(positions_avx2, "avx2", kernel::displace::<Avx2, false, true>,
    (block: &Block<'_>, kept: Option<&mut CarriedSums>, positions: &mut Flat, normals: &mut Flat) -> Bounds);
compiled!(normals_avx2, "avx2", kernel::displace::<Avx2, true, true>,
    (block: &Block<'_>, kept: Option<&mut CarriedSums>, positions: &mut Flat, normals: &mut Flat) -> Bounds);
compiled!(positions_avx512, "avx512f,avx512bw,avx512dq,avx512vl,avx2", kernel::displace::<Avx512, false, true>,
    (block: &Block<'_>, kept: Option<&mut CarriedSums>, positions: &mut Flat, normals: &mut Flat) -> Bounds);
compiled!(normals_avx512, "avx512f,avx512bw,avx512dq,avx512vl,avx2", kernel::displace::<Avx512, true, true>,
    (block: &Block<'_>, kept: Option<&mut CarriedSums>, positions: &mut Flat, normals: &mut Flat) -> Bounds);

compiled!(follow_avx2, "avx2", follow::follow::<Avx2, false>,
    (tile: &Following<'_>, positions: &mut Flat, normals: &mut Flat) -> Bounds);
compiled!(follow_normals_avx2, "avx2", follow::follow::<Avx2, true>,
    (tile: &Following<'_>, positions: &mut Flat, normals: &mut Flat) -> Bounds);
compiled!(follow_avx512, "avx512f,avx512bw,avx512dq,avx512vl,avx2", follow::follow::<Avx512, false>,
    (tile: &Following<'_>, positions: &mut Flat, normals: &mut Flat) -> Bounds);
compiled!(follow_normals_avx512, "avx512f,avx512bw,avx512dq,avx512vl,avx2", follow::follow::<Avx512, true>,
    (tile: &Following<'_>, positions: &mut Flat, normals: &mut Flat) -> Bounds);

/// [`follow::follow`].
#[inline]
pub(crate) fn follow(tile: &Following<'_>, positions: &mut Flat, normals: &mut Flat) -> Bounds {
    // SAFETY: as below.
    unsafe {
        match (SimdLevel::current(), tile.base_normals.is_some()) {
            #[cfg(target_arch = "x86_64")]
            (SimdLevel::Avx512, false) => follow_avx512(tile, positions, normals),
            #[cfg(target_arch = "x86_64")]
            (SimdLevel::Avx512, true) => follow_normals_avx512(tile, positions, normals),
            #[cfg(target_arch = "x86_64")]
            (SimdLevel::Avx2, false) => follow_avx2(tile, positions, normals),
            #[cfg(target_arch = "x86_64")]
            (SimdLevel::Avx2, true) => follow_normals_avx2(tile, positions, normals),
            (_, false) => follow::follow::<Portable, false>(tile, positions, normals),
            (_, true) => follow::follow::<Portable, true>(tile, positions, normals),
        }
    }
}

/// [`kernel::displace_stored`].
#[inline]
pub(crate) fn displace_stored(base: &[f32], stored: &Stored<'_>, scale: f32, to: &mut [f32]) -> Bounds {
    match SimdLevel::current() {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: a level is in use only if the processor supports it. The same holds below.
        SimdLevel::Avx2 | SimdLevel::Avx512 => unsafe { stored_avx2(base, stored, scale, to) },
        // SAFETY: always supported. The same holds below.
        _ => unsafe { kernel::displace_stored::<Portable>(base, stored, scale, to) },
    }
}

/// [`kernel::turn_stored`].
#[inline]
pub(crate) fn turn_stored(base: &Flat, stored: &Stored<'_>, scale: f32, to: &mut Flat) {
    match SimdLevel::current() {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: as above.
        SimdLevel::Avx2 | SimdLevel::Avx512 => unsafe { turn_avx2(base, stored, scale, to) },
        // SAFETY: as above.
        _ => unsafe { kernel::turn_stored::<Portable>(base, stored, scale, to) },
    }
}

/// [`kernel::octahedral`].
#[inline]
pub(crate) fn octahedral(normals: &Flat, to: &mut [u32; BLOCK]) {
    match SimdLevel::current() {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: as above.
        SimdLevel::Avx2 | SimdLevel::Avx512 => unsafe { octahedral_avx2(normals, to) },
        // SAFETY: as above.
        _ => unsafe { kernel::octahedral::<Portable>(normals, to) },
    }
}

/// [`kernel::displace`] for blocks with stored parts, carried ones, or both.
#[inline]
pub(crate) fn displace(
    block: &Block<'_>,
    (stored, carried): (bool, bool),
    kept: Option<&mut CarriedSums>,
    positions: &mut Flat,
    normals: &mut Flat,
) -> Bounds {
    // Stored parts need as many lanes as a group has vertices. Other processors have one number of lanes.
    #[cfg(not(target_arch = "x86_64"))]
    let _ = stored;
    // SAFETY: as above.
    unsafe {
        match (SimdLevel::current(), block.base_normals.is_some(), carried) {
            #[cfg(target_arch = "x86_64")]
            (SimdLevel::Avx512, false, true) if !stored => positions_avx512(block, kept, positions, normals),
            #[cfg(target_arch = "x86_64")]
            (SimdLevel::Avx512, true, true) if !stored => normals_avx512(block, kept, positions, normals),
            #[cfg(target_arch = "x86_64")]
            (SimdLevel::Avx2 | SimdLevel::Avx512, false, true) => positions_avx2(block, kept, positions, normals),
            #[cfg(target_arch = "x86_64")]
            (SimdLevel::Avx2 | SimdLevel::Avx512, true, true) => normals_avx2(block, kept, positions, normals),
            #[cfg(target_arch = "x86_64")]
            (SimdLevel::Avx2 | SimdLevel::Avx512, false, _) => stored_positions_avx2(block, kept, positions, normals),
            #[cfg(target_arch = "x86_64")]
            (SimdLevel::Avx2 | SimdLevel::Avx512, true, _) => stored_normals_avx2(block, kept, positions, normals),
            (_, false, true) => kernel::displace::<Portable, false, true>(block, kept, positions, normals),
            (_, true, true) => kernel::displace::<Portable, true, true>(block, kept, positions, normals),
            (_, false, _) => kernel::displace::<Portable, false, false>(block, kept, positions, normals),
            (_, true, _) => kernel::displace::<Portable, true, false>(block, kept, positions, normals),
        }
    }
}

/// Length of the longest stored vector, with the same bits as `Vec3::length`. All its numbers must be finite.
pub(crate) fn longest(stored: &Stored<'_>) -> f32 {
    match SimdLevel::current() {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: as above.
        SimdLevel::Avx2 | SimdLevel::Avx512 => unsafe { longest_avx2(stored) },
        // SAFETY: as above.
        _ => unsafe { kernel::longest::<Portable>(stored) },
    }
}
