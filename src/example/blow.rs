//! What is known of the blow that dents a body, for hits and for examples alike.

use crate::base::error::{Error, positive};
use crate::base::math::{to_f32, unit};
use crate::mesh::finite;
use glam::{DMat3, DVec3};

/// A blow on a body. Vectors are in the mesh's space for examples and in the hit's space for hits. Each part may be
/// unknown, which costs accuracy and not correctness.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Blow {
    /// Impulse on the body, N·s. `None`: the striker's mass times its velocity, if both are known.
    pub impulse: Option<[f32; 3]>,
    /// How long the impulse acted, s. Above 0.
    pub duration: Option<f32>,
    /// Contact normal, out of the body. Any length above 0.
    pub normal: Option<[f32; 3]>,
    /// What struck the body.
    pub striker: Striker,
}

/// The shape of what strikes, at the contact.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub enum StrikerShape {
    /// The default.
    #[default]
    Unknown = 0,
    /// A ball, or anything round.
    Ball = 1,
    /// A pole, an edge, or anything long.
    Pole = 2,
    /// A corner of a box.
    Corner = 3,
    /// A wall, or any flat face.
    Wall = 4,
}

impl StrikerShape {
    /// <!--
    /// cbindgen:ignore
    /// -->
    /// All of them, by number.
    pub const ALL: [Self; 5] = [Self::Unknown, Self::Ball, Self::Pole, Self::Corner, Self::Wall];

    /// The shape of this name in files: `ball`, `pole`, `corner` or `wall`. Shapes of other names are unknown.
    pub fn named(name: &str) -> Self {
        match name {
            "ball" => Self::Ball,
            "pole" => Self::Pole,
            "corner" => Self::Corner,
            "wall" => Self::Wall,
            _ => Self::Unknown,
        }
    }
}

/// The body that strikes. Each part may be unknown.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Striker {
    /// Mass, kg. Above 0.
    pub mass: Option<f32>,
    /// Velocity relative to the struck body, just before the bodies touch, m/s.
    pub velocity: Option<[f32; 3]>,
    /// Radius of its surface at the contact, m. Above 0: small for a corner, large for a flat face.
    pub radius: Option<f32>,
    /// Its shape at the contact. Strikers of one shape leave dents that are alike.
    pub shape: StrikerShape,
}

impl Blow {
    /// A blow of which only the impulse (N·s) and its duration (s) are known.
    pub fn of_impulse(impulse: [f32; 3], duration: f32) -> Self {
        Blow { impulse: Some(impulse), duration: Some(duration), ..Self::default() }
    }

    /// A blow of which only the striker is known.
    pub fn of_striker(striker: Striker) -> Self {
        Blow { striker, ..Self::default() }
    }

    /// The impulse on the body, N·s: the one given, or the striker's mass times its velocity, rounded to f32. `None` if
    /// neither is known.
    pub fn total_impulse(&self) -> Option<[f32; 3]> {
        self.impulse.or_else(|| {
            let (mass, velocity) = (self.striker.mass?, self.striker.velocity?);
            Some(velocity.map(|v| mass * v))
        })
    }

    /// The same blow after a change of space by the linear map `to`. Impulse and velocity are mapped as vectors. The
    /// normal is mapped so that it stays normal to the surface, and gets length 1. Mass, duration and radius stay.
    /// Components out of range become the largest finite value.
    pub fn transformed(&self, to: DMat3) -> Self {
        let map = |m: DMat3, v: [f32; 3]| m * DVec3::from_array(v.map(f64::from));
        let normals = to.inverse().transpose();
        Blow {
            impulse: self.impulse.map(|v| to_f32(map(to, v))),
            normal: self.normal.and_then(|v| map(normals, v).try_normalize()).map(to_f32),
            striker: Striker { velocity: self.striker.velocity.map(|v| to_f32(map(to, v))), ..self.striker },
            ..*self
        }
    }

    /// The parts as bits, for sorting. Blows with equal keys are equal.
    pub(crate) fn key(&self) -> [u32; 13] {
        let vector = |v: Option<[f32; 3]>| v.unwrap_or([f32::NAN; 3]);
        let [jx, jy, jz] = vector(self.impulse);
        let [nx, ny, nz] = vector(self.normal);
        let [vx, vy, vz] = vector(self.striker.velocity);
        let size = |x: Option<f32>| x.unwrap_or(f32::NAN);
        let shape = f32::from(self.striker.shape as u8);
        let sizes = [self.duration, self.striker.mass, self.striker.radius].map(size);
        let [duration, mass, radius] = sizes;
        [jx, jy, jz, nx, ny, nz, vx, vy, vz, duration, mass, radius, shape].map(f32::to_bits)
    }

    /// Checks every part that is known, and returns the blow with a normal of length 1. `name` makes the name of a part
    /// for the error.
    pub(crate) fn checked(&self, name: impl Fn(&str) -> String) -> Result<Self, Error> {
        let vector = |part: &str, v: Option<[f32; 3]>| v.map_or(Ok(()), |v| finite(v, || name(part)).map(|_| ()));
        // Names are made for errors only.
        let size = |part: &str, x: Option<f32>, unit: &str| {
            x.map_or(Ok(()), |x| positive("", x, unit).or_else(|_| positive(&name(part), x, unit)))
        };
        vector("impulse", self.impulse)?;
        size("duration", self.duration, "s")?;
        size("striker.mass", self.striker.mass, "kg")?;
        vector("striker.velocity", self.striker.velocity)?;
        size("striker.radius", self.striker.radius, "m")?;
        if let Some(j) = self.total_impulse() {
            finite(j, || name("striker.mass * striker.velocity"))?;
        }
        let no_length = |n| Error::invalid(&name("normal"), format!("{n:?}"), "longer than 0");
        let direction = |n| unit(finite(n, || name("normal"))?).ok_or_else(|| no_length(n)).map(|n| n.to_array());
        Ok(Blow { normal: self.normal.map(direction).transpose()?, ..*self })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn known() -> Blow {
        Blow {
            impulse: None,
            duration: Some(0.01),
            normal: Some([0.0, 0.0, 2.0]),
            striker: Striker {
                mass: Some(2.5),
                velocity: Some([0.1, -0.3, -4.0]),
                radius: Some(0.05),
                shape: StrikerShape::Ball,
            },
        }
    }

    #[test]
    fn an_unknown_impulse_is_the_striker_s_momentum() {
        let given = known().striker.velocity.map(|v| v.map(|v| 2.5 * v));
        assert_eq!(known().total_impulse(), given);
        assert_eq!(Blow { impulse: Some([1.0, 2.0, 3.0]), ..known() }.total_impulse(), Some([1.0, 2.0, 3.0]));
        let mut unknown = known();
        unknown.striker.mass = None;
        assert_eq!(unknown.total_impulse(), None);
        assert_eq!(Blow::default().checked(str::to_owned), Ok(Blow::default()));
    }

    #[test]
    fn bad_parts_are_refused_with_name_and_value() {
        type Change = fn(&mut Blow);
        let cases: [(Change, &str); 5] = [
            (|b| b.normal = Some([f32::NAN; 3]), "normal of x is"),
            (|b| b.striker.mass = Some(-1.0), "striker.mass of x is -1; it must be above 0 and finite, kg"),
            (|b| b.striker.velocity = Some([f32::INFINITY; 3]), "striker.velocity of x is"),
            (|b| b.striker.radius = Some(0.0), "striker.radius of x is 0; it must be above 0 and finite, m"),
            (|b| b.striker.mass = Some(f32::MAX), "striker.mass * striker.velocity of x is"),
        ];
        for (change, message) in cases {
            let mut blow = known();
            change(&mut blow);
            let error = blow.checked(|part| format!("{part} of x")).expect_err(message).to_string();
            assert!(error.starts_with(message), "{error} is not {message}");
        }
        assert_eq!(known().checked(str::to_owned).map(|b| b.normal), Ok(Some([0.0, 0.0, 1.0])));
    }

    #[test]
    fn a_stretched_space_keeps_the_normal_normal() {
        let to = DMat3::from_diagonal(DVec3::new(2.0, 1.0, 1.0));
        let blow = Blow { normal: Some([1.0, 1.0, 0.0]), impulse: Some([1.0, -1.0, 3.0]), ..known() };
        let (there, unit) = (blow.transformed(to), DVec3::new(0.5, 1.0, 0.0).normalize());
        assert_eq!(there.impulse, Some([2.0, -1.0, 3.0]));
        assert_eq!(there.striker.velocity, Some([0.2, -0.3, -4.0]));
        assert_eq!(there.normal, Some(to_f32(unit)));
        assert_eq!((there.duration, there.striker.radius), (blow.duration, blow.striker.radius));
    }
}
