//! The target of a hit: which vertex is displaced, in which direction and how far.

use super::hit::{Cause, Hit, HitStatus, Outcome, Selection, Space};
use super::options::InstanceOptions;
use crate::base::error::{Error, positive};
use crate::base::math::to_f32;
use crate::damage::mark::Mark;
use crate::damage::told::predicted;
use crate::example::blow::Blow;
use crate::example::set::ExampleSet;
use crate::mesh::finite;
use crate::mesh::nearest::{Nearest, VertexIndex};
use crate::predict::Told;
use glam::{DMat3, DVec3, Vec3};
use std::sync::Arc;

/// Targets below this share of the depth limit leave no mark.
const NEGLIGIBLE: f64 = 1e-6;

/// What selection needs of an instance.
#[derive(Debug, Clone)]
pub(crate) struct HitParams {
    pub options: InstanceOptions,
    /// The limits in use, m.
    pub depth_limit: f32,
    pub max_distance: f32,
    /// Linear part of the transform from world to mesh space, and the mesh origin in world space, m.
    pub world_to_local: DMat3,
    pub local_origin_in_world: DVec3,
    /// Where hits land. `None`: on the whole base mesh.
    pub landing: Option<Arc<Landing>>,
}

impl HitParams {
    /// Maps a point given in `space` to the mesh's space, m.
    pub(crate) fn local(&self, point: [f32; 3], space: Space) -> DVec3 {
        let x = DVec3::from_array(point.map(f64::from));
        if space == Space::World { self.world_to_local * (x - self.local_origin_in_world) } else { x }
    }

    /// Maps a blow given in `space` to the mesh's space.
    pub(crate) fn local_blow(&self, blow: &Blow, space: Space) -> Blow {
        if space == Space::World { blow.transformed(self.world_to_local) } else { *blow }
    }
}

/// The base vertices that may become contacts, if not all.
#[derive(Debug)]
pub(crate) struct Landing {
    index: VertexIndex,
    /// For each base vertex, whether hits there leave no mark.
    rigid: Vec<bool>,
}

impl Landing {
    /// Of the base vertices for which `may` is true. `None` if there is none. Both functions agree for vertices at one
    /// position.
    pub(crate) fn new(set: &ExampleSet, may: impl Fn(usize) -> bool, is_rigid: impl Fn(usize) -> bool) -> Option<Self> {
        let (mesh, count) = (set.mesh(), set.vertex_count());
        let lowest = |v: usize| if may(v) { mesh.weld()[v] } else { u32::MAX };
        let weld: Vec<u32> = (0..count).map(lowest).collect();
        let index = weld.iter().any(|w| *w != u32::MAX).then(|| VertexIndex::new(mesh.positions(), &weld))?;
        Some(Landing { index, rigid: (0..count).map(is_rigid).collect() })
    }
}

/// The displacement that a hit asks of a vertex.
#[derive(Debug, Clone, Copy)]
pub(crate) struct HitTarget {
    pub contact: u32,
    /// Unit vector.
    pub direction: Vec3,
    /// Length, m. At most the depth limit, unless selection is unclamped.
    pub size: f32,
    /// The contact's unit normal; against the hit if the mesh has no normals.
    pub normal: Vec3,
    /// What a mark holds of the hit: a strike, or a displacement of length 1.
    pub told: Told,
}

/// Computes the target of a hit. There is none if the hit is too weak; the outcome's status is then `BelowYield`.
/// Otherwise the status is `NothingReaches` until it is known what moves.
pub(crate) fn resolve(set: &ExampleSet, p: &HitParams, hit: &Hit) -> Result<(Outcome, Option<HitTarget>), Error> {
    check(hit)?;
    let contact = contact(set, p, p.local(hit.point, hit.space))?;
    // Read early: it waits for memory together with what the contact's distance needs.
    let normal = set.mesh().contact_normal(contact.vertex);
    let mass = |given: Option<f32>| {
        let expected = "given with the impulse, or for the example set's vertices (kg)";
        given.or_else(|| set.mass(contact.vertex)).ok_or_else(|| Error::invalid("mass", "absent", expected))
    };
    let vector = |v: [f32; 3]| {
        let v = DVec3::from_array(v.map(f64::from));
        if hit.space == Space::World { p.world_to_local * v } else { v }
    };
    let mut strike = None;
    let (target, weak) = match hit.cause {
        Cause::Displacement(d) => (vector(d), false),
        Cause::Impulse { blow, mass: m } => {
            let impulse = impulse_of(&blow)?;
            let weak = DVec3::from_array(impulse.map(f64::from)).length() < f64::from(p.options.yield_impulse);
            if set.predicts_blows() {
                let normal = normal.unwrap_or(-vector(impulse).normalize_or_zero().as_vec3());
                let known = set.rule().strike(&p.local_blow(&blow, hit.space), normal);
                strike = known.map(|strike| (Told::Strike(strike), normal));
                (strike.map_or(DVec3::ZERO, |(told, normal)| aimed(set, contact.vertex, &told, normal)), weak)
            } else if let Some(compliance) = p.options.compliance {
                (vector(impulse) * f64::from(compliance), weak)
            } else {
                // Equation 4.4 of the paper.
                (vector(impulse) * (f64::from(duration_of(&blow)?) / f64::from(mass(m)?)), weak)
            }
        }
    };
    let length = target.length();
    let mut outcome = Outcome {
        status: HitStatus::BelowYield,
        contact_vertex: contact.vertex,
        contact_distance: contact.distance,
        target: to_f32(target),
        achieved: [0.0; 3],
        clamped: false,
        classic: None,
        mark: None,
        expected_error: None,
    };
    let limits = set.mesh().limits();
    let limit = p.depth_limit.min(limits.depth(contact.vertex));
    let of_rigid_part = p.landing.as_ref().is_some_and(|landing| landing.rigid[contact.vertex as usize]);
    let held = f64::from(limit) <= NEGLIGIBLE * f64::from(p.depth_limit) || limits.give(contact.vertex) == 0.0;
    if of_rigid_part || held {
        outcome.status = HitStatus::Rigid;
        return Ok((outcome, None));
    }
    if weak || length < f64::from(p.options.yield_displacement) || length <= NEGLIGIBLE * f64::from(p.depth_limit) {
        return Ok((outcome, None));
    }
    outcome.status = HitStatus::NothingReaches;
    outcome.clamped = length > f64::from(limit) && p.options.selection != Selection::ClassicUnclamped;
    let size = if outcome.clamped { limit } else { length.min(f64::from(f32::MAX)) as f32 };
    let direction = (target / length).as_vec3();
    let (told, normal) = strike.unwrap_or((Told::Displacement(direction), normal.unwrap_or(-direction)));
    Ok((outcome, Some(HitTarget { contact: contact.vertex, normal, direction, size, told })))
}

/// The displacement of a contact that the set predicts of a blow, m.
fn aimed(set: &ExampleSet, contact: u32, told: &Told, normal: Vec3) -> DVec3 {
    let found = predicted(set, &Mark::new(contact, 1.0, told, normal));
    found.moved.normalize_or(-normal).as_dvec3() * f64::from(found.predicted.depth)
}

fn check(hit: &Hit) -> Result<(), Error> {
    let finite = |name: &str, v: [f32; 3]| finite(v, || name.into()).map(|_| ());
    finite("point", hit.point)?;
    match hit.cause {
        Cause::Displacement(d) => finite("displacement", d),
        Cause::Impulse { blow, mass } => {
            blow.checked(str::to_owned)?;
            impulse_of(&blow)?;
            mass.map_or(Ok(()), |m| positive("mass", m, "kg"))
        }
    }
}

/// The impulse on the body, N·s, in the hit's space.
fn impulse_of(blow: &Blow) -> Result<[f32; 3], Error> {
    let expected = "given (N·s), or the striker's mass (kg) and velocity (m/s)";
    blow.total_impulse().ok_or_else(|| Error::invalid("impulse", "absent", expected))
}

/// The duration that the paper's formula needs, s.
fn duration_of(blow: &Blow) -> Result<f32, Error> {
    let expected =
        "given with the impulse (s), as a constant of the material, since no example of the set knows its blow";
    blow.duration.ok_or_else(|| Error::invalid("duration", "absent", expected))
}

fn contact(set: &ExampleSet, p: &HitParams, point: DVec3) -> Result<Nearest, Error> {
    let too_far =
        |distance: f64| Error::ContactTooFar { point: to_f32(point), distance: distance as f32, limit: p.max_distance };
    // Tests the bounds first in double precision. This rejects points so far off that f32 would overflow.
    let b = set.mesh().bounds();
    let off = (b.min.as_dvec3() - point).max(point - b.max.as_dvec3()).max(DVec3::ZERO).length();
    if off > f64::from(p.max_distance) {
        return Err(too_far(off));
    }
    let index = p.landing.as_ref().map_or(set.index(), |landing| &landing.index);
    let near = index.of_point(to_f32(point), set.mesh().positions())?;
    if near.distance > p.max_distance { Err(too_far(near.distance.into())) } else { Ok(near) }
}
