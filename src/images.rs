//! What selection compares a hit with: every example, and its mirror images where the body has mirror planes.

use crate::examples::ANCHORED_WITHIN;
use crate::few::Few;
use crate::math::rotation_between;
use crate::mirror::{self, Mirror};
use crate::weights::{Axes, CANDIDATES};
use crate::{Example, Learned, Mesh, Placement};
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
/// One plus the cosine of two normals: below it they are nearly opposite.
const OPPOSITE: f32 = 1e-2;
/// Two images are one when they differ by no more than this: in place (share of the diagonal), logarithm of depth, and lean.
const SAME: (f32, f32, f32) = (0.01, 0.02, 0.01);
/// Two examples are copies of each other when they differ by no more than this in logarithm of depth and in lean.
const TWIN: (f32, f32) = (1e-3, 2e-3);

/// Images that are measured together, in vector operations.
const LANES: usize = 8;
/// What a bound on a squared distance may be off by: a few roundings, relative and (below the normal numbers) absolute.
const SLACK: (f32, f32) = (4e-6, 1e-30);

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
    /// The same, side by side; empty until [`Images::arrange`].
    lanes: Vec<Lanes>,
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
        Images { images, lanes: Vec::new(), lean, diagonal, planes, centre }
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = &Image> {
        self.images.iter()
    }

    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&self.images[..]) + size_of_val(&self.lanes[..])
    }

    /// Makes ready for [`Images::search`]: what was learned decides which examples may stay where they were made.
    pub(crate) fn arrange(&mut self, mesh: &Mesh, examples: &[Example], learned: &Learned) {
        let lane = |image: &Image| {
            let i = image.example as usize;
            let e = &examples[i];
            let here = ANCHORED_WITHIN * e.support_radius();
            let stays = e.placement() == Placement::Anchored || learned.anchored[i];
            if image.mirror != Mirror::NONE || e.placement() == Placement::Carried {
                return (-1.0, e.depth());
            }
            let near = if stays { here.max(reach(mesh, e)) } else { here };
            let depth = if e.placement() == Placement::Anchored { -1.0 } else { e.depth() };
            (near * near * (1.0 + 1e-5) + f32::MIN_POSITIVE, depth)
        };
        self.lanes = self
            .images
            .chunks(LANES)
            .map(|chunk| {
                let mut lanes = Lanes::EMPTY;
                for (i, image) in chunk.iter().enumerate() {
                    let (near, depth) = lane(image);
                    lanes.set(i, image, near, depth);
                }
                lanes
            })
            .collect();
    }

    /// Calls `here` with every image whose example may be anchored for the hit (it returns the squared distance of what answers
    /// otherwise than alone), and `near` with those others that can be among the [`CANDIDATES`] nearest when they are
    /// carried: all of these, and few besides.
    pub(crate) fn search(
        &self,
        hit: &Around,
        mut here: impl FnMut(&Image) -> Option<f32>,
        mut near: impl FnMut(&Image),
    ) {
        let mut nearest = Bar::new();
        let mut waiting: Few<(f32, usize), 32> = Few::new();
        let mut settle = |waiting: &mut Few<(f32, usize), 32>, limit: f32| {
            waiting.iter().filter(|w| w.0 <= limit).for_each(|w| near(&self.images[w.1]));
            waiting.clear();
        };
        for (lanes, first) in self.lanes.iter().zip((0..).step_by(LANES)) {
            for (bound, i) in hit.bounds(lanes).into_iter().zip(first..) {
                if bound > nearest.limit {
                    continue;
                }
                if bound == f32::NEG_INFINITY {
                    here(&self.images[i]).into_iter().for_each(|d| nearest.add(d));
                    continue;
                }
                if waiting.len() == 32 {
                    settle(&mut waiting, nearest.limit);
                }
                waiting.push((bound, i));
                nearest.add(bound);
            }
        }
        settle(&mut waiting, nearest.limit);
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

/// Nothing further from an example's contact is moved enough for the example to answer there without being carried, m.
fn reach(mesh: &Mesh, e: &Example) -> f32 {
    let least = REACH * e.depth() * (1.0 - 1e-5);
    let moved = e.anchored().iter().filter(|(_, u, _)| u.length() >= least);
    moved.map(|(v, _, _)| (mesh.positions()[v as usize] - e.contact_point()).length()).fold(0.0, f32::max)
}

/// Some images side by side. Places without one never answer.
#[derive(Debug, Clone, Copy)]
struct Lanes {
    point: [[f32; LANES]; 3],
    normal: [[f32; LANES]; 3],
    lean: [[f32; LANES]; 3],
    /// Normal times direction.
    along: [f32; LANES],
    log_depth: [f32; LANES],
    /// Depth of the example, m; -1 where it is not carried.
    depth: [f32; LANES],
    /// Squared distance, m², up to which the example may be anchored for a hit; -1 where it never is.
    near: [f32; LANES],
}

impl Lanes {
    const EMPTY: Lanes = {
        let zero = [0.0; LANES];
        Lanes {
            point: [zero; 3],
            normal: [zero; 3],
            lean: [zero; 3],
            along: zero,
            log_depth: zero,
            depth: [-1.0; LANES],
            near: [-1.0; LANES],
        }
    };

    fn set(&mut self, i: usize, image: &Image, near: f32, depth: f32) {
        for axis in 0..3 {
            self.point[axis][i] = image.point[axis];
            self.normal[axis][i] = image.normal[axis];
            self.lean[axis][i] = image.lean[axis];
        }
        self.along[i] = image.normal.dot(image.direction);
        self.log_depth[i] = image.log_depth;
        (self.depth[i], self.near[i]) = (depth, near);
    }
}

/// The least bounds so far, and from them the distance beyond which no image can be among the nearest.
struct Bar {
    least: [f32; CANDIDATES],
    limit: f32,
}

impl Bar {
    fn new() -> Self {
        Bar { least: [f32::MAX; CANDIDATES], limit: f32::MAX }
    }

    fn add(&mut self, bound: f32) {
        for i in (1..CANDIDATES).rev() {
            self.least[i] = self.least[i].min(self.least[i - 1].max(bound));
        }
        self.least[0] = self.least[0].min(bound);
        // Twice the slack and more: the bounds were lowered by it.
        self.limit = (self.least[CANDIDATES - 1] * (1.0 + 3.0 * SLACK.0) + 3.0 * SLACK.1).min(f32::MAX);
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

    /// Bounds from below on the squared distances of images when they are carried: infinity where one does not answer, minus
    /// infinity where its example may be anchored, or where only [`Around::axes`] can tell.
    ///
    /// Whether one answers is decided by the very operations of [`Around::axes`]. Of the distance only the divisions by widths
    /// are made products, which is within the slack.
    #[inline]
    fn bounds(&self, lanes: &Lanes) -> [f32; LANES] {
        let (normal, known) = (self.normal.unwrap_or(Vec3::ZERO), self.lean.unwrap_or(Vec3::ZERO));
        let negligible = if self.normal.is_some() { self.negligible } else { f32::INFINITY };
        let (place, size) = (1.0 / self.place.0, 1.0 / SIZE_WIDTH);
        let leaning = if self.lean.is_some() { 1.0 / LEAN_WIDTH } else { 0.0 };
        let at = |of: &[[f32; LANES]; 3], i: usize| Vec3::new(of[0][i], of[1][i], of[2][i]);
        let mut bounds = [0.0; LANES];
        for (i, bound) in bounds.iter_mut().enumerate() {
            let off = at(&lanes.point, i) - self.point;
            let (a, v) = (at(&lanes.normal, i), at(&lanes.lean, i));
            let k = 1.0 + a.dot(normal);
            let lean = v - (a + normal) * (v.dot(normal) / k);
            let cos = (normal * lanes.along[i] + lean).dot(self.direction);
            let (p, l) = (off * place, (lean - known) * leaning);
            let depth = (lanes.log_depth[i] - self.log_size) * size;
            let d = p.dot(p) + depth * depth + l.dot(l);
            let answers = cos > 1e-3 && lanes.depth[i] >= negligible;
            let d = if answers { d * (1.0 - SLACK.0) - SLACK.1 } else { f32::INFINITY };
            let unclear = off.dot(off) <= lanes.near[i] || k < OPPOSITE;
            *bound = if unclear { f32::NEG_INFINITY } else { d };
        }
        bounds
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
    if k < OPPOSITE { rotation_between(a, b) * v } else { v - (a + b) * (v.dot(b) / k) }
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
