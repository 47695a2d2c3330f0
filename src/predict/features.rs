//! A hit as a point of the space in which hits are near each other or far.

use super::kernel::GROUPS;
use glam::Vec3;

/// Numbers of a point.
pub(super) const AXES: usize = 13;
/// The group of each number; the last number, the kind, is compared for equality.
pub(super) const GROUP: [usize; AXES] = [0, 0, 0, 1, 1, 1, 2, 3, 4, 5, 5, 5, 6];

/// Position over the diagonal, normal, logarithms of strength, mass and radius, direction, kind.
///
/// For a blow the strength is the normal energy (J) and the direction the tangential over the normal velocity. For a
/// displacement they are the length (m) and the part of the unit displacement in the surface, its lean.
pub(super) type Point = [f64; AXES];

/// Index of the strength in a point.
pub(super) const STRENGTH_AXIS: usize = 6;

/// What a point has of a hit besides its place. Unknown numbers are typical ones.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Strike {
    /// Energy of the normal velocity, J, above 0; of a displacement its length, m.
    pub strength: f64,
    /// kg, above 0.
    pub mass: f64,
    /// m, above 0.
    pub radius: f64,
    /// Tangential over normal velocity; of a displacement the part of its direction in the surface.
    pub direction: [f64; 3],
    /// Tells kinds of strikers apart.
    pub kind: f64,
}

impl Strike {
    /// That of a displacement, m, of a place with this unit normal; `None` if it is zero.
    pub(super) fn of_displacement(u: Vec3, normal: Vec3) -> Option<Self> {
        let u = u.as_dvec3();
        let depth = u.length();
        if depth.is_nan() || depth <= 0.0 {
            return None;
        }
        let n = normal.as_dvec3();
        let lean = u / depth;
        let lean = lean - n * lean.dot(n);
        Some(Strike { strength: depth, mass: 1.0, radius: 1.0, direction: lean.to_array(), kind: 0.0 })
    }
}

pub(super) fn point(place: Vec3, normal: Vec3, diagonal: f64, strike: &Strike) -> Point {
    let (p, n) = (place.as_dvec3() / diagonal, normal.as_dvec3());
    let [a, b, c] = strike.direction;
    let [strength, mass, radius] = [strike.strength, strike.mass, strike.radius].map(libm::log);
    [p.x, p.y, p.z, n.x, n.y, n.z, strength, mass, radius, a, b, c, strike.kind]
}

/// Squared differences of two points for each group.
pub(super) fn differences(a: &Point, b: &Point) -> [f64; GROUPS] {
    let mut out = [0.0; GROUPS];
    for k in 0..AXES - 1 {
        let d = a[k] - b[k];
        out[GROUP[k]] += d * d;
    }
    out[6] = f64::from(a[AXES - 1] != b[AXES - 1]);
    out
}

/// Points, one array for each number, and their squared differences to one point.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Points {
    pub count: usize,
    /// [`AXES`] arrays of `count` numbers.
    pub axes: Vec<f64>,
}

impl Points {
    pub(super) fn new(points: &[Point]) -> Self {
        let axes = (0..AXES).flat_map(|k| points.iter().map(move |p| p[k])).collect();
        Self { count: points.len(), axes }
    }

    /// Writes [`GROUPS`] arrays of squared differences to `x`.
    pub(super) fn differences(&self, x: &Point, out: &mut Vec<f64>) {
        let n = self.count;
        out.clear();
        out.resize(GROUPS * n, 0.0);
        for k in 0..AXES {
            let (to, from) = (&mut out[GROUP[k] * n..(GROUP[k] + 1) * n], &self.axes[k * n..(k + 1) * n]);
            if k == AXES - 1 {
                to.iter_mut().zip(from).for_each(|(t, f)| *t = f64::from(*f != x[k]));
            } else {
                for (t, f) in to.iter_mut().zip(from) {
                    let d = f - x[k];
                    *t += d * d;
                }
            }
        }
    }
}
