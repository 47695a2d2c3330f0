//! The vector math that marks depend on. It gives the same bits on every platform, because it uses only IEEE
//! operations: glam's scalar `Vec3` and `Mat3`, square roots, and `libm` for the rest.

use super::simd::Work;
use glam::{DVec3, IVec3, Mat3, Mat4, Vec3, Vec4};

/// An axis-aligned box, m. Empty when `min > max`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aabb {
    /// Smallest coordinates.
    pub min: Vec3,
    /// Largest coordinates.
    pub max: Vec3,
}

impl Aabb {
    /// The empty box.
    pub const EMPTY: Aabb = Aabb { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// The smallest box around `points`.
    pub fn of<'a>(points: impl IntoIterator<Item = &'a Vec3>) -> Self {
        let mut b = Aabb::EMPTY;
        for p in points {
            b.add(*p);
        }
        b
    }

    /// The smallest box around `points`: the same as [`Aabb::of`], but vectorized.
    pub(crate) fn of_slice(points: &[Vec3]) -> Self {
        // x y z x, y z x y, z x y z: four points.
        let (fours, rest) = points.as_chunks::<4>();
        let (mut low, mut high) = ([Vec4::INFINITY; 3], [Vec4::NEG_INFINITY; 3]);
        for four in fours {
            let numbers: &[f32; 12] = bytemuck::cast_ref(four);
            for k in 0..3 {
                let x = Vec4::from_slice(&numbers[4 * k..]);
                (low[k], high[k]) = (low[k].min(x), high[k].max(x));
            }
        }
        let mut b = Aabb::of(rest);
        let (low, high): ([f32; 12], [f32; 12]) = (bytemuck::cast(low), bytemuck::cast(high));
        for (low, high) in low.chunks_exact(3).zip(high.chunks_exact(3)) {
            b.union(&Aabb { min: Vec3::from_slice(low), max: Vec3::from_slice(high) });
        }
        b
    }

    /// Grows the box to hold `p`.
    pub fn add(&mut self, p: Vec3) {
        self.min = self.min.min(p);
        self.max = self.max.max(p);
    }

    /// Grows the box to hold `other`.
    pub fn union(&mut self, other: &Aabb) {
        self.min = self.min.min(other.min);
        self.max = self.max.max(other.max);
    }

    /// Length of the diagonal, m; 0 for an empty box.
    pub fn diagonal(&self) -> f32 {
        if self.min.x > self.max.x { 0.0 } else { (self.max - self.min).length() }
    }

    /// The middle of the box, m.
    pub(crate) fn centre(&self) -> Vec3 {
        self.min + (self.max - self.min) * 0.5
    }

    /// Squared distance from `p` to the box, m²; 0 inside.
    pub fn distance_squared(&self, p: Vec3) -> f32 {
        let d = (self.min - p).max(p - self.max).max(Vec3::ZERO);
        d.dot(d)
    }
}

/// The smallest rotation that takes unit vector `a` to unit vector `b`. For opposite vectors it is a half turn about
/// the axis perpendicular to `a` that is nearest to z (nearest to x if `a` is along z). Vectors mirrored in a
/// coordinate plane give the mirrored rotation.
///
/// Normalizes the vectors again and computes in f64: for nearly opposite vectors `1 / (1 + cos)` amplifies f32 rounding
/// errors.
pub(crate) fn rotation_between(a: Vec3, b: Vec3) -> Mat3 {
    if a.dot(b) < -0.9999 {
        // A half turn about u, then the small rotation from -a to b.
        let towards = if a.z.abs() < 0.99 { Vec3::Z } else { Vec3::X };
        let u = unit(towards - a * a.dot(towards)).unwrap_or(towards);
        let half = Mat3::from_cols(u * (2.0 * u.x), u * (2.0 * u.y), u * (2.0 * u.z)) - Mat3::IDENTITY;
        return rotation_between(-a, b) * half;
    }
    let (a, b) = (a.as_dvec3(), b.as_dvec3());
    let (a, b) = (a / a.length(), b / b.length());
    let v = a.cross(b);
    let k = 1.0 / (1.0 + a.dot(b));
    Mat3::from_cols(
        DVec3::new(1.0 - (v.y * v.y + v.z * v.z) * k, v.z + v.x * v.y * k, -v.y + v.x * v.z * k).as_vec3(),
        DVec3::new(-v.z + v.x * v.y * k, 1.0 - (v.x * v.x + v.z * v.z) * k, v.x + v.y * v.z * k).as_vec3(),
        DVec3::new(v.y + v.x * v.z * k, -v.x + v.y * v.z * k, 1.0 - (v.x * v.x + v.y * v.y) * k).as_vec3(),
    )
}

/// Rotates `t` by the smallest rotation that takes unit vector `a` to unit vector `b`. Same as [`rotation_between`],
/// but in f32 only, which every CPU and GPU has. For nearly opposite vectors it is accurate to 1e-3.
pub(crate) fn turned_as(a: Vec3, b: Vec3, t: Vec3) -> Vec3 {
    let (mut from, mut v) = (a, t);
    if a.dot(b) < -0.9999 {
        let towards = if a.z.abs() < 0.99 { Vec3::Z } else { Vec3::X };
        let u = unit(towards - a * a.dot(towards)).unwrap_or(towards);
        v = u * (2.0 * u.dot(t)) - t;
        from = -a;
    }
    let c = from.cross(b);
    let w = c.cross(v);
    v + w + c.cross(w) * (1.0 / (1.0 + from.dot(b)))
}

/// A right-handed orthonormal frame whose z axis is the unit vector `n`
/// (Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 2017).
pub(crate) fn tangent_basis(n: Vec3) -> Mat3 {
    let sign = 1.0f32.copysign(n.z);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    Mat3::from_cols(
        Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x),
        Vec3::new(b, sign + n.y * n.y * a, -n.y),
        n,
    )
}

/// Returns `v` scaled to unit length, or `None` if its length is zero or not finite.
pub(crate) fn unit(v: Vec3) -> Option<Vec3> {
    // Divide by the largest component first, so that tiny vectors do not underflow and huge ones do not overflow.
    let m = v.abs().max_element();
    if !(m > 0.0 && m.is_finite()) {
        return None;
    }
    let w = v / m;
    Some(w / w.length())
}

/// Rounds to f32. Values out of range become the largest finite value.
pub(crate) fn to_f32(v: DVec3) -> [f32; 3] {
    v.to_array().map(|x| x.clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32)
}

/// The nearest whole number, the even one of two that are as near. For numbers that an `i32` can hold: added to this constant, they
/// are in the lowest bits.
#[inline]
pub(crate) fn nearest_whole(x: f64) -> i32 {
    const MAGIC: f64 = 6_755_399_441_055_744.0; // 1.5 * 2^52
    (x + MAGIC).to_bits() as i32
}

/// The largest number that [`small_whole`] rounds.
pub(crate) const MOST_WHOLE: i32 = 1 << 22;

/// The same of numbers up to [`MOST_WHOLE`], negative or not.
#[inline]
pub(crate) fn small_whole(x: f32) -> i32 {
    const MAGIC: f32 = 12_582_912.0; // 1.5 * 2^23
    (x + MAGIC).to_bits() as i32 - MAGIC.to_bits() as i32
}

/// The greatest whole number that is not above one from 0 to 2^22; of others, any number.
#[inline(always)]
pub(crate) fn small_floor(x: f32) -> f32 {
    const ONES: f32 = 8_388_608.0; // 2^23
    let near = (x + ONES) - ONES;
    if near > x { near - 1.0 } else { near }
}

/// The number from 0 to 1 that is nearest; 0 for NaN. Compiled for vectors, unlike `clamp`.
#[inline(always)]
pub(crate) fn within_one(x: f32) -> f32 {
    let x = if x > 0.0 { x } else { 0.0 };
    if x < 1.0 { x } else { 1.0 }
}

/// The first numbers of four vectors, their second numbers, and so on.
#[inline(always)]
pub(crate) fn transposed([a, b, c, d]: [Vec4; 4]) -> [Vec4; 4] {
    let columns = Mat4::from_cols(a, b, c, d).transpose();
    [columns.x_axis, columns.y_axis, columns.z_axis, columns.w_axis]
}

/// Adds up to four rows of small whole numbers to `to`, each times its factor, one after the other.
pub(crate) struct AddRows<'a> {
    pub to: &'a mut [f32],
    pub factors: [f32; 4],
    pub rows: &'a [i16],
}

impl Work for AddRows<'_> {
    type Done = ();

    #[inline(always)]
    fn run(self) {
        let AddRows { to, factors, rows } = self;
        let n = to.len();
        // Four rows at a time take half the reads and writes.
        if rows.len() == 4 * n {
            let ((ab, cd), [ka, kb, kc, kd]) = (rows.split_at(2 * n), factors);
            let ((a, b), (c, d)) = (ab.split_at(n), cd.split_at(n));
            for ((((t, a), b), c), d) in to.iter_mut().zip(a).zip(b).zip(c).zip(d) {
                let sum = *t + ka * f32::from(*a) + kb * f32::from(*b);
                *t = sum + kc * f32::from(*c) + kd * f32::from(*d);
            }
            return;
        }
        for (k, row) in factors.iter().zip(rows.chunks_exact(n.max(1))) {
            to.iter_mut().zip(row).for_each(|(t, f)| *t += k * f32::from(*f));
        }
    }
}

/// A cell of a grid and the 26 around it.
pub(crate) fn cells_around(cell: IVec3) -> impl Iterator<Item = IVec3> {
    (0..27).map(move |i| cell.wrapping_add(IVec3::new(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1)))
}

#[cfg(test)]
mod tests {
    use super::super::simd::widest;
    use super::*;

    #[test]
    fn rotation_takes_a_to_b_also_when_opposite() {
        let dirs =
            [Vec3::X, -Vec3::X, Vec3::Y, Vec3::Z, -Vec3::Z, Vec3::new(0.6, 0.0, 0.8), Vec3::new(-0.6, 1e-4, -0.8)];
        for a in dirs.map(|v| unit(v).unwrap()) {
            for b in dirs.map(|v| unit(v).unwrap()) {
                let r = rotation_between(a, b);
                assert!((r * a - b).length() < 1e-5, "{a} to {b}: {}", r * a);
                for t in [Vec3::X, Vec3::Y, Vec3::Z] {
                    assert!((turned_as(a, b, t) - r * t).length() < 1e-3, "{a} to {b}: {t}");
                }
                assert!((r.determinant() - 1.0).abs() < 1e-5);
                assert!((r.transpose() * r - Mat3::IDENTITY).to_cols_array().iter().all(|x| x.abs() < 1e-5));
            }
        }
    }

    #[test]
    fn rotation_is_one_to_rounding_also_between_nearly_opposite_vectors() {
        let a = unit(Vec3::new(0.3, -0.5, 0.8)).unwrap();
        for off in [0.3f32, 0.1, 0.03, 0.02, 0.015, 0.014, 0.01, 1e-3] {
            let b = unit(-a + tangent_basis(a).y_axis * off).unwrap();
            let r = rotation_between(a, b);
            assert!((r * a - b).length() < 5e-7, "{off}: {}", (r * a - b).length());
            assert!((r.transpose() * r - Mat3::IDENTITY).to_cols_array().iter().all(|x| x.abs() < 5e-7), "{off}");
        }
    }

    #[test]
    fn tangent_basis_is_right_handed_and_keeps_n() {
        for n in [Vec3::Z, -Vec3::Z, Vec3::X, unit(Vec3::new(1.0, -2.0, -1e-8)).unwrap()] {
            let b = tangent_basis(n);
            assert_eq!(b.z_axis, n);
            assert!((b.determinant() - 1.0).abs() < 1e-5);
        }
    }

    #[test]
    fn rows_are_added_one_after_the_other() {
        let n = 21;
        for count in 1..=4 {
            let rows: Vec<i16> = (0..count * n).map(|i| (i as i32 * 7919 % 65536 - 32768) as i16).collect();
            let factors = [1e-5, -3e-4, 0.1, 7.3];
            let mut sums: Vec<f32> = (0..n).map(|i| i as f32 / 3.0).collect();
            let mut expected = sums.clone();
            for (k, row) in factors.iter().zip(rows.chunks(n)) {
                expected.iter_mut().zip(row).for_each(|(sum, x)| *sum += k * f32::from(*x));
            }
            widest(AddRows { to: &mut sums, factors, rows: &rows });
            assert_eq!(sums, expected);
        }
    }

    #[test]
    fn unit_survives_extremes() {
        for s in [1e-40f32, 1e-20, 1.0, 1e20, 3e38] {
            assert!((unit(Vec3::new(s, 0.0, 0.0)).unwrap() - Vec3::X).length() < 1e-6);
        }
        assert!(unit(Vec3::ZERO).is_none());
        assert!(unit(Vec3::splat(f32::NAN)).is_none());
    }
}
