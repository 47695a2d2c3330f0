//! What selection compares a hit with: every example, and its mirror images where the body has mirror planes.

use crate::examples::ANCHORED_WITHIN;
use crate::few::Few;
use crate::math::{Aabb, rotation_between};
use crate::mirror::{self, Mirror};
use crate::weights::{Axes, CANDIDATES};
use crate::{Example, Learned, Mesh, Placement};
use glam::{Vec3, Vec4};
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
const LANES: usize = 4;
/// Images that wait until the bounds of the others are known: more than usually come to be among the nearest on the way.
const WAITING: usize = 96;
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
        let mut order: Vec<u32> = (0..self.images.len() as u32).collect();
        cluster(&self.images, &mut order);
        let group = |group: &[u32]| {
            let mut lanes = Lanes::EMPTY;
            for (i, at) in group.iter().enumerate() {
                let image = &self.images[*at as usize];
                let (near, depth) = lane(image);
                lanes.set(i, *at, image, near, depth);
            }
            lanes
        };
        self.lanes = order.chunks(LANES).map(group).collect();
    }

    /// Calls `consider` with true and every image whose example may be anchored for the hit (it returns the squared distance of
    /// what answers otherwise than alone), and with false and those others that can be among the [`CANDIDATES`] nearest when
    /// they are carried: all of these, and few besides.
    pub(crate) fn search(&self, hit: &Around, mut consider: impl FnMut(&Image, bool) -> Option<f32>) {
        let wide = Wide::new(hit);
        let mut nearest = Bar::new();
        let mut waiting: Few<(f32, u32), WAITING> = Few::new();
        for lanes in &self.lanes {
            let Some(bounds) = wide.bounds(lanes, nearest.limit) else { continue };
            for (bound, i) in bounds.to_array().into_iter().zip(lanes.image) {
                if bound > nearest.limit {
                    continue;
                }
                if bound == f32::NEG_INFINITY {
                    consider(&self.images[i as usize], true).into_iter().for_each(|d| nearest.add(d));
                    continue;
                }
                if waiting.len() == WAITING {
                    let near = waiting.iter().filter(|w| w.0 <= nearest.limit);
                    near.for_each(|w| _ = consider(&self.images[w.1 as usize], false));
                    waiting.clear();
                }
                waiting.push((bound, i));
                nearest.add(bound);
            }
        }
        let near = waiting.iter().filter(|w| w.0 <= nearest.limit);
        near.for_each(|w| _ = consider(&self.images[w.1 as usize], false));
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
    point: [Vec4; 3],
    normal: [Vec4; 3],
    lean: [Vec4; 3],
    /// Normal times direction.
    along: Vec4,
    log_depth: Vec4,
    /// Depth of the example, m; -1 where it is not carried.
    depth: Vec4,
    /// Squared distance, m², up to which the example may be anchored for a hit; -1 where it never is.
    near: Vec4,
    /// Their numbers.
    image: [u32; LANES],
}

impl Lanes {
    const EMPTY: Lanes = Lanes {
        point: [Vec4::ZERO; 3],
        normal: [Vec4::ZERO; 3],
        lean: [Vec4::ZERO; 3],
        along: Vec4::ZERO,
        log_depth: Vec4::ZERO,
        depth: Vec4::NEG_ONE,
        near: Vec4::NEG_ONE,
        image: [0; LANES],
    };

    fn set(&mut self, i: usize, at: u32, image: &Image, near: f32, depth: f32) {
        self.image[i] = at;
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

/// Scalar products, summed as those of [`Vec3`] are.
#[inline]
fn dot(a: [Vec4; 3], b: [Vec4; 3]) -> Vec4 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Brings images that are near each other in place into groups of [`LANES`].
fn cluster(images: &[Image], order: &mut [u32]) {
    if order.len() <= LANES {
        return;
    }
    let bounds = Aabb::of(order.iter().map(|i| &images[*i as usize].point));
    let axis = (bounds.max - bounds.min).max_position();
    let half = (order.len() / 2).next_multiple_of(LANES).min(order.len() - 1);
    order.select_nth_unstable_by(half, |a, b| {
        let at = |i: u32| images[i as usize].point[axis];
        at(*a).total_cmp(&at(*b)).then(a.cmp(b))
    });
    let (a, b) = order.split_at_mut(half);
    cluster(images, a);
    cluster(images, b);
}

/// The least bounds so far, least first, and from them the distance beyond which no image can be among the nearest.
struct Bar {
    least: [Vec4; CANDIDATES / LANES],
    limit: f32,
}

impl Bar {
    fn new() -> Self {
        Bar { least: [Vec4::MAX; CANDIDATES / LANES], limit: f32::MAX }
    }

    /// Every place takes the bound, or what was in the place before it, if that is less than what it has.
    #[inline]
    fn add(&mut self, bound: f32) {
        let mut before = bound;
        for least in &mut self.least {
            let moved = Vec4::new(before, least.x, least.y, least.z).max(Vec4::splat(bound));
            before = least.w;
            *least = least.min(moved);
        }
        // Twice the slack and more: the bounds were lowered by it.
        let last = self.least[CANDIDATES / LANES - 1].w;
        self.limit = (last * (1.0 + 3.0 * SLACK.0) + 3.0 * SLACK.1).min(f32::MAX);
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
            let u = e.met_at(self.contact, self.point);
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

/// A hit, the same in all lanes.
struct Wide {
    point: [Vec4; 3],
    normal: [Vec4; 3],
    direction: [Vec4; 3],
    lean: [Vec4; 3],
    log_size: Vec4,
    negligible: Vec4,
    /// One over the widths of the place axes, m, and of the lean axes (0 where the lean is not known).
    place: Vec4,
    leaning: Vec4,
}

impl Wide {
    fn new(hit: &Around) -> Self {
        let wide = |v: Option<Vec3>| v.unwrap_or(Vec3::ZERO).to_array().map(Vec4::splat);
        Wide {
            point: wide(Some(hit.point)),
            normal: wide(hit.normal),
            direction: wide(Some(hit.direction)),
            lean: wide(hit.lean),
            log_size: Vec4::splat(hit.log_size),
            // Without normals nothing is carried.
            negligible: Vec4::splat(if hit.normal.is_some() { hit.negligible } else { f32::INFINITY }),
            place: Vec4::splat(1.0 / hit.place.0),
            leaning: Vec4::splat(if hit.lean.is_some() { 1.0 / LEAN_WIDTH } else { 0.0 }),
        }
    }

    /// Bounds from below on the squared distances of images when they are carried: infinity where one does not answer, minus
    /// infinity where its example may be anchored, or where only [`Around::axes`] can tell. `None` where all are above `limit`.
    ///
    /// Whether one answers is decided by the very operations of [`Around::axes`]. Of the distance only the divisions by widths
    /// are made products, which is within the slack.
    #[inline]
    fn bounds(&self, lanes: &Lanes, limit: f32) -> Option<Vec4> {
        #[inline]
        fn each(f: impl Fn(usize) -> Vec4) -> [Vec4; 3] {
            [f(0), f(1), f(2)]
        }
        let off = each(|i| lanes.point[i] - self.point[i]);
        let p = each(|i| off[i] * self.place);
        let depth = (lanes.log_depth - self.log_size) * (1.0 / SIZE_WIDTH);
        let d = dot(p, p) + depth * depth;
        let least = d * (1.0 - SLACK.0) - SLACK.1;
        let here = dot(off, off).cmple(lanes.near);
        if !(here | least.cmple(Vec4::splat(limit))).any() {
            return None;
        }
        let k = Vec4::ONE + dot(lanes.normal, self.normal);
        let t = dot(lanes.lean, self.normal) / k;
        let lean = each(|i| lanes.lean[i] - (lanes.normal[i] + self.normal[i]) * t);
        let cos = dot(each(|i| self.normal[i] * lanes.along + lean[i]), self.direction);
        let l = each(|i| (lean[i] - self.lean[i]) * self.leaning);
        let d = d + dot(l, l);
        let answers = cos.cmpgt(Vec4::splat(1e-3)) & lanes.depth.cmpge(self.negligible);
        let d = Vec4::select(answers, d * (1.0 - SLACK.0) - SLACK.1, Vec4::INFINITY);
        let unclear = here | k.cmplt(Vec4::splat(OPPOSITE));
        Some(Vec4::select(unclear, Vec4::NEG_INFINITY, d))
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
