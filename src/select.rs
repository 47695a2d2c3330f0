//! Selection: an impulse becomes a mark.
//!
//! The default takes the K examples that say most of a hit of this place, depth and lean, in shares that extrapolate between
//! them ([`crate::weights`]), and scales them together so that the contact gets the target displacement. The literature's rule
//! ([`Selection::Classic`]) takes the one example whose displacement of the contact has the best cosine with the target.
//!
//! Everything here is IEEE f32/f64 arithmetic with `sqrt` and `libm`, so the same hit makes the same mark everywhere.

use crate::dent::{MAX_PAIRS, Placed, place, turns};
use crate::error::positive;
use crate::examples::{ANCHORED_SIZE, ANCHORED_WITHIN, ExampleSet};
use crate::few::Few;
use crate::images::{Image, automatic};
use crate::mirror::Mirror;
use crate::weights::{self, Axes, CANDIDATES};
use crate::{Error, Mark, Pair, Placement};
use glam::{DMat3, DVec3, Vec3};
use std::num::NonZeroU64;

/// Targets below this share of the depth limit leave no mark.
const NEGLIGIBLE: f64 = 1e-6;

/// The space that a hit is given in.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Space {
    /// The mesh's own space. The default.
    #[default]
    Local = 0,
    /// World space. The instance's transform maps it to the mesh's space.
    World = 1,
}

/// What a hit does to the vertex it hits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Cause {
    /// The literature's target displacement `impulse * duration / mass` (Eq. 4.4). It depends on `duration`, so on the
    /// engine's time step if that is what is passed: give a duration of the material's own, and report a contact once, with
    /// its whole impulse, or in parts with an id ([`Hit::contact`]). [`Cause::Displacement`] has no duration.
    Impulse {
        /// N·s.
        impulse: [f32; 3],
        /// How long it acted, s; above 0.
        duration: f32,
        /// Mass of the vertex, kg, above 0. `None`: the set's.
        mass: Option<f32>,
    },
    /// The displacement the contact should get, m: the engine's own mapping, free of the frame rate.
    Displacement([f32; 3]),
}

/// A hit as the engine's physics reports it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Contact point, m.
    pub point: [f32; 3],
    /// Impulse or displacement; points into the body for a dent.
    pub cause: Cause,
    /// The space of `point` and of the vector in `cause`.
    pub space: Space,
    /// The contact it is part of. `None`: a hit of its own. Hits of one contact, which may come over many steps until
    /// [`Inbox::end_contact`](crate::Inbox::end_contact), make the one dent of their sum, whatever the time step. An
    /// impulse's `duration` is then a constant of the material, not the step. The rule `Marks` only.
    pub contact: Option<NonZeroU64>,
}

impl Hit {
    /// A hit in the mesh's space that should displace the contact by `displacement`, m.
    pub fn displacement(point: [f32; 3], displacement: [f32; 3]) -> Self {
        Hit { point, cause: Cause::Displacement(displacement), space: Space::Local, contact: None }
    }

    /// A hit in the mesh's space by an impulse (N·s) that acted for `duration` (s).
    pub fn impulse(point: [f32; 3], impulse: [f32; 3], duration: f32, mass: Option<f32>) -> Self {
        Hit { point, cause: Cause::Impulse { impulse, duration, mass }, space: Space::Local, contact: None }
    }

    /// The same hit as part of a contact.
    pub fn of_contact(self, id: NonZeroU64) -> Self {
        Hit { contact: Some(id), ..self }
    }
}

/// How examples are chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Selection {
    /// The K that say most of the hit's place, depth and lean, carried or anchored as each example says.
    #[default]
    Nearest,
    /// The paper's Figure 4.2: best cosine among the examples that move the nearest vertex, anchored; weight at most 1.
    Classic,
    /// The same without the limit of the weight: diverges above 2. For comparison, with the classic rules only.
    ClassicUnclamped,
}

/// What became of a hit.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum HitStatus {
    /// It leaves a mark, or with a classic rule a deformation.
    Marked = 0,
    /// It is weaker than a yield threshold, or than a millionth of the depth limit.
    BelowYield = 1,
    /// No example moves the contact vertex towards the target.
    NothingReaches = 2,
}

/// An example chosen for a hit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chosen {
    /// Its index.
    pub example: u32,
    /// Its share of the dent; shares sum to 1. Negative where it corrects others that overshoot.
    pub share: f32,
    /// What its displacements are multiplied with.
    pub scale: f32,
    /// Whether it stays where it was made.
    pub anchored: bool,
    /// The planes that it is mirrored in.
    pub mirror: Mirror,
}

/// What a hit was turned into.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outcome {
    /// What became of it.
    pub status: HitStatus,
    /// The vertex nearest to the contact point.
    pub contact_vertex: u32,
    /// Its distance from the contact point, m.
    pub contact_distance: f32,
    /// Displacement asked for at the contact, in the mesh's space, m.
    pub target: [f32; 3],
    /// Displacement that this hit alone achieves there, m.
    pub achieved: [f32; 3],
    /// Whether the target was longer than the depth limit and was cut to it.
    pub clamped: bool,
    /// The examples chosen, the weightiest first.
    pub chosen: [Option<Chosen>; 4],
    /// The mark it leaves; none with the classic rules.
    pub mark: Option<Mark>,
}

impl Outcome {
    /// The part of the target that was not achieved: `target - achieved`, m.
    pub fn shortfall(&self) -> [f32; 3] {
        std::array::from_fn(|i| self.target[i] - self.achieved[i])
    }
}

/// What selection needs to know of an instance.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Params {
    pub selection: Selection,
    pub examples_per_hit: usize,
    pub limit: f32,
    pub yield_impulse: f32,
    pub yield_displacement: f32,
    pub max_distance: f32,
    /// Mesh space from world space, and its inverse's translation.
    pub world_to_local: DMat3,
    pub local_origin_in_world: DVec3,
    /// Whether the instance follows a classic rule.
    pub classic: bool,
}

/// What the rule needs of a hit.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Effect {
    None,
    Mark(Mark),
    /// The classic rules: blend towards the example by the weight.
    Classic {
        example: u32,
        weight: f32,
    },
}

/// Turns a hit into its outcome and its effect.
pub(crate) fn select(set: &ExampleSet, p: &Params, hit: &Hit) -> Result<(Outcome, Effect), Error> {
    check(hit)?;
    let point = to_local(p, hit.point, hit.space);
    let contact = contact(set, p, point)?;
    let mass = |given: Option<f32>| {
        given.or_else(|| set.mass(contact.vertex)).ok_or_else(|| Error::InvalidArgument {
            name: "mass".into(),
            value: "absent".into(),
            expected: "given with the impulse, or for the example set's vertices (kg)".into(),
        })
    };
    let vector = |v: [f32; 3]| {
        let v = DVec3::new(v[0].into(), v[1].into(), v[2].into());
        if hit.space == Space::World { p.world_to_local * v } else { v }
    };
    let (target, weak) = match hit.cause {
        Cause::Displacement(d) => (vector(d), false),
        Cause::Impulse { impulse, duration, mass: m } => {
            // Equation 4.4.
            let t = vector(impulse) * (f64::from(duration) / f64::from(mass(m)?));
            let j = DVec3::new(impulse[0].into(), impulse[1].into(), impulse[2].into()).length();
            (t, j < f64::from(p.yield_impulse))
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
        chosen: [None; MAX_PAIRS],
        mark: None,
    };
    if weak || length < f64::from(p.yield_displacement) || length <= NEGLIGIBLE * f64::from(p.limit) {
        return Ok((outcome, Effect::None));
    }
    outcome.status = HitStatus::NothingReaches;
    let unclamped = p.selection == Selection::ClassicUnclamped;
    outcome.clamped = length > f64::from(p.limit) && !unclamped;
    let size = if outcome.clamped { p.limit } else { length.min(f64::from(f32::MAX)) as f32 };
    let direction = (target / length).as_vec3();
    let effect = match p.selection {
        Selection::Nearest => nearest(set, p, contact.vertex, direction, size, &mut outcome),
        Selection::Classic | Selection::ClassicUnclamped => {
            classic(set, p, contact.vertex, direction, size, !unclamped, &mut outcome)
        }
    };
    Ok((outcome, effect))
}

fn check(hit: &Hit) -> Result<(), Error> {
    let finite = |name: &str, v: [f32; 3]| crate::mesh::finite(v, || name.into()).map(|_| ());
    finite("point", hit.point)?;
    match hit.cause {
        Cause::Displacement(d) => finite("displacement", d),
        Cause::Impulse { impulse, duration, mass } => {
            finite("impulse", impulse)?;
            positive("duration", duration, "s")?;
            mass.map_or(Ok(()), |m| positive("mass", m, "kg"))
        }
    }
}

pub(crate) fn to_local(p: &Params, point: [f32; 3], space: Space) -> DVec3 {
    let x = DVec3::new(point[0].into(), point[1].into(), point[2].into());
    if space == Space::World { p.world_to_local * (x - p.local_origin_in_world) } else { x }
}

/// Rounded; what f32 cannot hold becomes the largest it can.
pub(crate) fn to_f32(v: DVec3) -> [f32; 3] {
    v.to_array().map(|x| x.clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32)
}

fn contact(set: &ExampleSet, p: &Params, point: DVec3) -> Result<crate::Nearest, Error> {
    let too_far =
        |distance: f64| Error::ContactTooFar { point: to_f32(point), distance: distance as f32, limit: p.max_distance };
    // Against the bounds first, in double precision: points so far off that f32 overflows end here.
    let b = set.mesh().bounds();
    let off = (b.min.as_dvec3() - point).max(point - b.max.as_dvec3()).max(DVec3::ZERO).length();
    if off > f64::from(p.max_distance) {
        return Err(too_far(off));
    }
    let near = set.nearest_vertex(to_f32(point))?;
    if near.distance > p.max_distance { Err(too_far(near.distance.into())) } else { Ok(near) }
}

/// An example that could answer a hit.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Candidate {
    pub example: u32,
    pub mirror: Mirror,
    pub anchored: bool,
    pub axes: Axes,
    /// Squared distance from the hit.
    d: f32,
}

impl Candidate {
    pub(crate) fn new(image: &Image, anchored: bool, axes: Axes) -> Self {
        Candidate { example: image.example, mirror: image.mirror, anchored, axes, d: weights::distance(&axes) }
    }

    fn order(&self, other: &Self) -> std::cmp::Ordering {
        self.d.total_cmp(&other.d).then((self.example, self.mirror).cmp(&(other.example, other.mirror)))
    }
}

/// The nearest of the candidates, nearest first; of equally near ones the first example.
pub(crate) struct Candidates(Few<Candidate, CANDIDATES>);

impl Candidates {
    pub(crate) fn new() -> Self {
        Candidates(Few::new())
    }

    fn of(c: Candidate) -> Self {
        let mut one = Self::new();
        one.add(c);
        one
    }

    pub(crate) fn add(&mut self, c: Candidate) {
        let after = self.0.iter().rev().take_while(|other| c.order(other).is_lt()).count();
        self.0.insert(self.0.len() - after, c);
    }
}

fn nearest(set: &ExampleSet, p: &Params, contact: u32, direction: Vec3, size: f32, out: &mut Outcome) -> Effect {
    let at = set.around(contact, direction, size, set.learned().place_width);
    let mut found = Candidates::new();
    let mut own: Option<Candidate> = None;
    let consider = |image: &Image| {
        let e = &set.examples()[image.example as usize];
        let here = (e.contact_point() - at.point).length() <= ANCHORED_WITHIN * e.support_radius()
            && image.mirror == Mirror::NONE;
        let own_size = (1.0 - ANCHORED_SIZE..=1.001).contains(&(size / e.depth()));
        let may_carry = automatic(e);
        let anchored = e.placement() == Placement::Anchored
            || (may_carry && (here && own_size || set.learned().anchored[image.example as usize]));
        // An automatic example that does not reach this far in place can still be carried here.
        let placed = at.axes(image, anchored).map(|a| (anchored, a));
        let placed =
            placed.or_else(|| if anchored && may_carry { at.axes(image, false).map(|a| (false, a)) } else { None });
        let (anchored, axes) = placed?;
        let c = Candidate::new(image, anchored, axes);
        let alone = anchored && here && (own_size || e.placement() == Placement::Anchored);
        Some((c, alone))
    };
    set.images().search(&at, |image, may_stay| {
        if !may_stay {
            found.add(Candidate::new(image, false, at.axes(image, false)?));
            return None;
        }
        let (c, alone) = consider(image)?;
        if !alone {
            found.add(c);
            return Some(c.d);
        }
        // At an example's own contact it answers alone: the artist's dent, not a mixture.
        if own.as_ref().is_none_or(|o| c.order(o).is_lt()) {
            own = Some(c);
        }
        None
    });
    let pairs = match own {
        Some(c) => pairs(&Candidates::of(c), 1),
        None => pairs(&found, p.examples_per_hit),
    };
    if pairs[0].is_none() {
        return Effect::None;
    }
    // The dent's own direction at the contact decides how much of the target it can meet.
    let turns = turns(set, contact, &pairs);
    let placed = place(set, contact, size, &pairs, &turns);
    let open = placed.open;
    let along = open.length();
    let depth = if along > 0.0 { (direction * size).dot(open / along) } else { 0.0 };
    // A target along the dent to within rounding is the dent.
    let depth = if (depth - size).abs() <= 1e-6 * size { size } else { depth };
    if depth.is_nan() || depth <= 0.0 {
        return Effect::None;
    }
    let placed = if depth == size { placed } else { place(set, contact, depth, &pairs, &turns) };
    marked(&placed, Mark::new(contact, depth, pairs), out)
}

/// Up to `k` of the candidates with their shares, the weightiest first.
pub(crate) fn pairs(found: &Candidates, k: usize) -> [Pair; MAX_PAIRS] {
    let mut pairs = [Pair::NONE; MAX_PAIRS];
    let found = &found.0;
    if found.is_empty() {
        return pairs;
    }
    let mut axes: Few<Axes, CANDIDATES> = Few::new();
    found.iter().for_each(|c| axes.push(c.axes));
    let mut chosen = weights::choose(&axes, k);
    chosen.sort_unstable_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    let units = |w: f64| (w * f64::from(Pair::WHOLE)).round_ties_even() as i32;
    // The first takes what rounding leaves, so that shares sum to the whole.
    let mut shares: Few<(usize, i32), MAX_PAIRS> = Few::new();
    chosen.iter().for_each(|(i, w)| shares.push((*i, units(*w))));
    shares[0].1 = i32::from(Pair::WHOLE) - shares[1..].iter().map(|s| s.1).sum::<i32>();
    if shares.iter().any(|s| !(-2048..2048).contains(&s.1)) {
        // Far outside what the examples span, no mixture is better than the nearest.
        shares.clear();
        shares.push((0, i32::from(Pair::WHOLE)));
    }
    for (slot, (i, share)) in pairs.iter_mut().zip(shares.iter().filter(|s| s.1 != 0)) {
        let c = &found[*i];
        *slot = if c.anchored {
            Pair::anchored(c.example as u16, *share as i16)
        } else {
            Pair::carried(c.example as u16, *share as i16, c.mirror)
        };
    }
    pairs
}

fn marked(Placed { parts, achieved, .. }: &Placed, mark: Mark, out: &mut Outcome) -> Effect {
    for (slot, (pair, part)) in out.chosen.iter_mut().zip(mark.pairs.iter().filter(|p| !p.is_none()).zip(parts)) {
        *slot = Some(Chosen {
            example: u32::from(pair.example),
            share: pair.share_fraction(),
            scale: part.scale,
            anchored: pair.is_anchored(),
            mirror: pair.mirror(),
        });
    }
    out.achieved = achieved.to_array();
    out.status = HitStatus::Marked;
    out.mark = Some(mark);
    Effect::Mark(mark)
}

/// Figure 4.2 of the paper: of the examples that move the contact, the one with the best cosine similarity (Eq. 4.5);
/// its weight is target over example displacement (Eq. 4.7).
fn classic(
    set: &ExampleSet,
    p: &Params,
    contact: u32,
    direction: Vec3,
    size: f32,
    clamp: bool,
    out: &mut Outcome,
) -> Effect {
    let mut best: Option<(f32, usize, Vec3)> = None;
    for (i, e) in set.examples().iter().enumerate() {
        let d = e.delta(contact);
        let length = d.length();
        if length > 0.0 {
            let cos = d.dot(direction) / length;
            if best.is_none_or(|b| cos > b.0) {
                best = Some((cos, i, d));
            }
        }
    }
    let Some((_, example, d)) = best else { return Effect::None };
    let weight = size / d.length();
    let weight = if clamp { weight.min(1.0) } else { weight };
    if p.classic {
        out.chosen[0] =
            Some(Chosen { example: example as u32, share: 1.0, scale: weight, anchored: true, mirror: Mirror::NONE });
        out.achieved = (d * weight).to_array();
        out.status = HitStatus::Marked;
        return Effect::Classic { example: example as u32, weight };
    }
    let mut pairs = [Pair::NONE; MAX_PAIRS];
    pairs[0] = Pair::anchored(example as u16, Pair::WHOLE);
    let placed = place(set, contact, size, &pairs, &turns(set, contact, &pairs));
    marked(&placed, Mark::new(contact, size, pairs), out)
}
