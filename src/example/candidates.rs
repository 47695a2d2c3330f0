//! The candidates of selection: every example, and its mirror images if the body has mirror planes.

use super::blocks::DeltaBlocks;
use super::data::Placement;
use super::example::Example;
use super::response::Response;
use crate::base::math::turn_tangent;
use crate::mesh::Mesh;
use crate::mesh::mirror::{self, Mirror};
use glam::{Vec3, Vec4};
use rstar::{RTree, primitives::GeomWithData};

/// Two candidates are duplicates if they differ by at most this in place (share of the diagonal), logarithm of depth,
/// and lean.
const SAME: (f32, f32, f32) = (0.01, 0.02, 0.01);
/// Two examples are copies if they differ by at most this in logarithm of depth and in lean.
const COPY: (f32, f32) = (1e-3, 2e-3);

/// An anchored example reaches a vertex if it displaces it by at least this share of its contact's displacement.
pub(crate) const REACH: f32 = 0.1;
/// A hit counts as being at an example's own contact within this share of its support radius.
pub(crate) const OWN_PLACE: f32 = 0.1;

/// An example or its mirror image, described at its own contact.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Candidate {
    pub example: u32,
    pub mirror: Mirror,
    pub point: Vec3,
    pub normal: Vec3,
    /// Unit displacement of the contact.
    pub direction: Vec3,
    /// The tangential part of `direction`.
    pub lean: Vec3,
    pub depth: f32,
    pub log_depth: f32,
    pub placement: Placement,
    /// The tangential part of its blow, as [`super::response::Strike`] has it, and the logarithm of the striker's
    /// radius. `None` if unknown.
    pub tangent: Option<Vec3>,
    pub log_radius: Option<f32>,
    /// Squared distance between the hit and the contact, m², up to which the example may be used anchored. Slightly
    /// rounded up. -1 if it may not.
    pub own_place_square: f32,
}

impl Candidate {
    fn new(e: &Example, example: usize, mirror: Mirror, centre: Vec3) -> Self {
        let normal = mirror.direction(e.contact_normal().unwrap_or(Vec3::Z));
        let direction = mirror.direction(e.contact_displacement() / e.depth());
        let own_place_square = match (mirror, e.placement()) {
            (Mirror::NONE, Placement::Automatic) => a_little_more((OWN_PLACE * e.support_radius()).powi(2)),
            _ => -1.0,
        };
        Candidate {
            example: example as u32,
            mirror,
            point: mirror.point(e.contact_point(), centre),
            normal,
            direction,
            lean: direction - normal * normal.dot(direction),
            depth: e.depth(),
            log_depth: e.log_depth(),
            placement: e.placement(),
            tangent: None,
            log_radius: None,
            own_place_square,
        }
    }

    fn with_blow(self, e: &Example, response: Option<&Response>) -> Self {
        let strike = response.and_then(|r| r.strike_of(e));
        Candidate {
            tangent: strike.map(|s| self.mirror.direction(s.tangent.as_vec3())),
            log_radius: strike.and_then(|s| s.radius).map(|r| r as f32),
            ..self
        }
    }

    fn same(&self, other: &Candidate, diagonal: f32) -> bool {
        (self.point - other.point).length() <= SAME.0 * diagonal
            && (self.log_depth - other.log_depth).abs() <= SAME.1
            && (self.lean - other.lean).length() <= SAME.2
    }
}

/// Candidates per [`CandidateLanes`].
pub(crate) const LANES: usize = 4;

/// Four candidates as a structure of arrays, for vector operations.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CandidateLanes {
    pub point: [Vec4; 3],
    pub normal: [Vec4; 3],
    pub lean: [Vec4; 3],
    pub log_depth: Vec4,
    pub own_place_square: Vec4,
}

impl CandidateLanes {
    /// A candidate that cannot be carried gets an infinite `log_depth`, so its distance when carried is infinite.
    fn new(candidates: &[Candidate]) -> Self {
        let cannot_move = |c: &Candidate| c.placement == Placement::Anchored;
        // Unused lanes repeat the last candidate. They are never read.
        let lane = |i: usize| &candidates[i.min(candidates.len() - 1)];
        let wide = |f: &dyn Fn(&Candidate) -> f32| Vec4::from_array(std::array::from_fn(|i| f(lane(i))));
        let wide3 = |f: fn(&Candidate) -> Vec3| [0, 1, 2].map(|axis| wide(&|c| f(c)[axis]));
        CandidateLanes {
            point: wide3(|c| c.point),
            normal: wide3(|c| c.normal),
            lean: wide3(|c| c.lean),
            log_depth: wide(&|c| if cannot_move(c) { f32::INFINITY } else { c.log_depth }),
            own_place_square: wide(&|c| c.own_place_square),
        }
    }
}

/// The distance from the contact beyond which an example of this depth moves no vertex enough to be used there anchored, m.
pub(crate) fn reach(mesh: &Mesh, contact: Vec3, depth: f32, moves: &DeltaBlocks) -> f32 {
    let threshold = REACH * depth * (1.0 - 1e-5);
    let moved = moves.iter().filter(|(_, u, _)| u.length() >= threshold);
    moved.map(|(v, _, _)| (mesh.positions()[v as usize] - contact).length()).fold(0.0, f32::max)
}

fn a_little_more(square: f32) -> f32 {
    square * (1.0 + 2e-5) + f32::MIN_POSITIVE
}

/// All candidates of a set, ordered by example, then by mirror. Mirror images that duplicate another candidate are left
/// out.
#[derive(Debug, Default)]
pub(crate) struct Candidates {
    all: Vec<Candidate>,
    lanes: Vec<CandidateLanes>,
    /// Length of the longest lean of all candidates.
    pub max_lean: f32,
    pub diagonal: f32,
    planes: Mirror,
    centre: Vec3,
}

impl Candidates {
    pub(crate) fn new(mesh: &Mesh, examples: &[Example], planes: Mirror, response: Option<&Response>) -> Self {
        let (centre, diagonal) = (mirror::centre(&mesh.bounds()), mesh.bounds().diagonal());
        let usable = || examples.iter().enumerate().filter(|(_, e)| !e.is_empty());
        let candidate = |e: &Example, i: usize, m: Mirror| Candidate::new(e, i, m, centre).with_blow(e, response);
        let mut all: Vec<Candidate> = usable().map(|(i, e)| candidate(e, i, Mirror::NONE)).collect();
        let mut kept: RTree<GeomWithData<[f32; 3], Candidate>> = RTree::new();
        all.iter().for_each(|c| kept.insert(GeomWithData::new(c.point.to_array(), *c)));
        let near = (SAME.0 * diagonal).powi(2);
        for (i, e) in usable().filter(|(_, e)| e.stamp().is_some()) {
            for m in planes.choices().filter(|m| *m != Mirror::NONE) {
                let image = candidate(e, i, m);
                let at = image.point.to_array();
                if !kept.locate_within_distance(at, near).any(|k| k.data.same(&image, diagonal)) {
                    kept.insert(GeomWithData::new(at, image));
                    all.push(image);
                }
            }
        }
        all.sort_by_key(|c| (c.example, c.mirror));
        let max_lean = all.iter().map(|c| c.lean.length()).fold(0.0, f32::max);
        Candidates { all, lanes: Vec::new(), max_lean, diagonal, planes, centre }
    }

    /// Lets examples be used anchored for any hit that they reach. Applies to anchored examples and to those marked in
    /// `learned`.
    pub(crate) fn let_stay(&mut self, examples: &[Example], learned: &[bool]) {
        for c in self.all.iter_mut().filter(|c| c.mirror == Mirror::NONE) {
            let e = &examples[c.example as usize];
            if c.placement == Placement::Anchored || learned[c.example as usize] {
                let within = (OWN_PLACE * e.support_radius()).max(e.reach);
                c.own_place_square = a_little_more(within * within);
            }
        }
        self.lanes = self.all.chunks(LANES).map(CandidateLanes::new).collect();
    }

    pub(crate) fn all(&self) -> &[Candidate] {
        &self.all
    }

    /// The candidates in groups of [`LANES`]. The last group may have fewer.
    pub(crate) fn lanes(&self) -> &[CandidateLanes] {
        &self.lanes
    }

    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&self.all[..]) + size_of_val(&self.lanes[..])
    }

    /// Whether `b` is a moved or mirrored copy of `a`. Leaving out one of two copies teaches nothing, since the other
    /// remains.
    pub(crate) fn are_copies(&self, a: &Example, b: &Example) -> bool {
        if a.is_empty() || b.is_empty() {
            return false;
        }
        let own = Candidate::new(a, 0, Mirror::NONE, self.centre);
        self.planes.choices().any(|m| {
            let image = Candidate::new(b, 0, m, self.centre);
            let lean = turn_tangent(image.lean, image.normal, own.normal);
            (image.log_depth - own.log_depth).abs() <= COPY.0 && (lean - own.lean).length() <= COPY.1
        })
    }
}
