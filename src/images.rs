//! What selection compares a hit with: every example, and its mirror images where the body has mirror planes.

use crate::math::rotation_between;
use crate::mirror::{self, Mirror};
use crate::weights::Axes;
use crate::{Example, Mesh, Placement};
use glam::Vec3;
use rstar::{RTree, primitives::GeomWithData};

/// Axis width over the natural logarithm of the ratio of depths.
const SIZE_WIDTH: f32 = 2.4;
/// Axis width over the lean: the tangential part of a unit displacement.
const LEAN_WIDTH: f32 = 0.05;
/// Place axes of anchored examples, as a share of the diagonal: those that stay where they are say little of other places.
const ANCHORED_WIDTH: f32 = 0.15;
/// An anchored example reaches a vertex that it displaces by at least this share of its own contact's displacement.
const REACH: f32 = 0.1;
/// A target that leans less than this (a tenth of a degree) is along the normal: nobody knew how it leans …
const UPRIGHT: f32 = 0.002;
/// … and one that leans more than the most leaning example by this factor is not what a dent's contact does.
const BEYOND: f32 = 3.0;
/// Two images are one when they differ by no more than this: in place (share of the diagonal), logarithm of depth, and lean.
const SAME: (f32, f32, f32) = (0.01, 0.02, 0.01);
/// Two examples are copies of each other when they differ by no more than this in logarithm of depth and in lean.
const TWIN: (f32, f32) = (1e-3, 2e-3);

/// An example, or its mirror image, at its own contact.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Image {
    pub example: u32,
    pub mirror: Mirror,
    point: Vec3,
    normal: Vec3,
    /// Unit displacement of the contact.
    direction: Vec3,
    /// Its part in the surface.
    lean: Vec3,
    log_depth: f32,
}

impl Image {
    fn new(e: &Example, example: usize, mirror: Mirror, centre: Vec3) -> Self {
        let normal = mirror.direction(e.contact_normal().unwrap_or(Vec3::Z));
        let direction = mirror.direction(e.contact_displacement() / e.depth());
        Image {
            example: example as u32,
            mirror,
            point: mirror.point(e.contact_point(), centre),
            normal,
            direction,
            lean: direction - normal * normal.dot(direction),
            log_depth: e.log_depth(),
        }
    }

    fn same(&self, other: &Image, diagonal: f32) -> bool {
        (self.point - other.point).length() <= SAME.0 * diagonal
            && (self.log_depth - other.log_depth).abs() <= SAME.1
            && (self.lean - other.lean).length() <= SAME.2
    }
}

/// All images of a set, in the order of examples and then of mirrors, without those that another example makes needless.
#[derive(Debug, Default)]
pub(crate) struct Images {
    images: Vec<Image>,
    /// The longest lean of any example.
    lean: f32,
    diagonal: f32,
    planes: Mirror,
    centre: Vec3,
}

impl Images {
    pub(crate) fn new(mesh: &Mesh, examples: &[Example], planes: Mirror) -> Self {
        let (centre, diagonal) = (mirror::centre(&mesh.bounds()), mesh.bounds().diagonal());
        let usable = || examples.iter().enumerate().filter(|(_, e)| !e.is_empty());
        let mut images: Vec<Image> = usable().map(|(i, e)| Image::new(e, i, Mirror::NONE, centre)).collect();
        let mut kept: RTree<GeomWithData<[f32; 3], Image>> = RTree::new();
        images.iter().for_each(|i| kept.insert(GeomWithData::new(i.point.to_array(), *i)));
        let near = (SAME.0 * diagonal).powi(2);
        for (i, e) in usable().filter(|(_, e)| e.stamp().is_some()) {
            for m in planes.choices().filter(|m| *m != Mirror::NONE) {
                let image = Image::new(e, i, m, centre);
                let at = image.point.to_array();
                if !kept.locate_within_distance(at, near).any(|k| k.data.same(&image, diagonal)) {
                    kept.insert(GeomWithData::new(at, image));
                    images.push(image);
                }
            }
        }
        images.sort_by_key(|i| (i.example, i.mirror));
        let lean = images.iter().map(|i| i.lean.length()).fold(0.0, f32::max);
        Images { images, lean, diagonal, planes, centre }
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = &Image> {
        self.images.iter()
    }

    pub(crate) fn len(&self) -> usize {
        self.images.len()
    }

    /// Whether `b` is `a` over again, moved or mirrored (a copy by symmetry): leaving one out and keeping the other teaches
    /// nothing.
    pub(crate) fn twins(&self, a: &Example, b: &Example) -> bool {
        if a.is_empty() || b.is_empty() {
            return false;
        }
        let own = Image::new(a, 0, Mirror::NONE, self.centre);
        self.planes.choices().any(|m| {
            let image = Image::new(b, 0, m, self.centre);
            let lean = turned(image.lean, image.normal, own.normal);
            (image.log_depth - own.log_depth).abs() <= TWIN.0 && (lean - own.lean).length() <= TWIN.1
        })
    }
}

/// A hit, as examples are measured against it.
pub(crate) struct Around<'a> {
    pub examples: &'a [Example],
    pub contact: u32,
    pub point: Vec3,
    normal: Option<Vec3>,
    direction: Vec3,
    /// `None` where it is not known.
    lean: Option<Vec3>,
    log_size: f32,
    /// Widths of the place axes, m: of carried and of anchored examples.
    place: (f32, f32),
    negligible: f32,
}

impl<'a> Around<'a> {
    /// A hit on vertex `contact` that asks for `size` (m) along the unit vector `direction`. `place` is the width of the place
    /// axes as a share of the diagonal, `negligible` the depth (m) below which an example says nothing.
    pub(crate) fn new(
        (mesh, examples, images): (&Mesh, &'a [Example], &Images),
        (contact, direction, size): (u32, Vec3, f32),
        place: f32,
        negligible: f32,
    ) -> Self {
        let normal = mesh.contact_normal(contact);
        let lean = normal.map_or(Vec3::ZERO, |n| direction - n * n.dot(direction));
        // The direction of an impulse, or a displacement made up along the normal, says nothing of how a dent leans.
        let length = lean.length();
        let cut = if length > images.lean { lean * (images.lean / length) } else { lean };
        let lean = (UPRIGHT..=BEYOND * images.lean).contains(&length).then_some(cut);
        let width = |share: f32| (share * images.diagonal).max(f32::MIN_POSITIVE);
        Around {
            examples,
            contact,
            point: mesh.positions()[contact as usize],
            normal,
            direction,
            lean,
            log_size: libm::logf(size),
            place: (width(place), width(ANCHORED_WIDTH)),
            negligible,
        }
    }

    /// An image relative to the hit; `None` where it cannot answer it.
    pub(crate) fn axes(&self, image: &Image, anchored: bool) -> Option<Axes> {
        let e = &self.examples[image.example as usize];
        if e.depth() < self.negligible {
            return None;
        }
        let (log_depth, lean, cos, width) = if anchored {
            let u = e.delta(self.contact);
            let depth = u.length();
            if depth < REACH * e.depth() || image.mirror != Mirror::NONE {
                return None;
            }
            let u = u / depth;
            let lean = self.normal.map_or(Vec3::ZERO, |n| u - n * n.dot(u));
            (libm::logf(depth), lean, u.dot(self.direction), self.place.1)
        } else {
            let normal = self.normal?;
            let lean = turned(image.lean, image.normal, normal);
            let along = normal * image.normal.dot(image.direction);
            (image.log_depth, lean, (along + lean).dot(self.direction), self.place.0)
        };
        if cos.is_nan() || cos <= 1e-3 {
            return None;
        }
        let p = (image.point - self.point) / width;
        let l = self.lean.map_or(Vec3::ZERO, |known| (lean - known) / LEAN_WIDTH);
        Some([p.x, p.y, p.z, (log_depth - self.log_size) / SIZE_WIDTH, l.x, l.y, l.z])
    }
}

/// `v`, at right angles to unit vector `a`, turned by the smallest rotation from `a` to unit vector `b`.
fn turned(v: Vec3, a: Vec3, b: Vec3) -> Vec3 {
    let k = 1.0 + a.dot(b);
    if k < 1e-2 { rotation_between(a, b) * v } else { v - (a + b) * (v.dot(b) / k) }
}

/// Whether an automatic example's placement is decided by what it knows of its surroundings.
pub(crate) fn automatic(e: &Example) -> bool {
    e.placement() == Placement::Automatic && e.stamp().is_some()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{tangent_basis, unit};

    #[test]
    fn turned_is_the_smallest_rotation() {
        for (a, b) in [
            (Vec3::Z, Vec3::X),
            (Vec3::new(0.3, -0.5, 0.8), Vec3::new(-0.2, 0.9, 0.1)),
            (Vec3::Y, Vec3::new(0.05, -1.0, 0.0)),
        ] {
            let (a, b) = (unit(a).unwrap(), unit(b).unwrap());
            let v = tangent_basis(a).x_axis * 0.3 + tangent_basis(a).y_axis * 0.1;
            assert!((turned(v, a, b) - rotation_between(a, b) * v).length() < 1e-5);
        }
    }
}
