//! Contacts that last several steps. An engine may report one contact as many small impulses, one per step. If they
//! have one id, they make one dent, whatever the length of a step.
//!
//! An open contact's mark is provisional. It lies on top of the settled marks and is recomputed from the sum of the
//! contact's hits whenever a fold brings more of them. So the damage shown is always that of each open contact reported
//! as a whole, and marks that have merged never need to be taken apart.

use super::selection::select;
use crate::base::math::to_f32;
use crate::damage::list::Damage;
use crate::damage::mark::Mark;
use crate::example::blow::{Blow, Striker};
use crate::example::set::ExampleSet;
use crate::select::hit::{Hit, Outcome};
use crate::select::target::HitParams;
use glam::DVec3;
use std::collections::VecDeque;
use std::num::NonZeroU64;

/// An event of a contact: a part, or its end.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ContactEvent {
    pub id: NonZeroU64,
    /// `None` ends the contact.
    pub part: Option<ContactPart>,
}

/// One hit's part of a contact, in the mesh's space.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ContactPart {
    pub point: DVec3,
    pub push: Push,
}

/// What a part adds to its contact.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Push {
    /// A desired displacement, m, and the length of the impulse that asks for it, N·s; `None` for a hit given as a
    /// displacement.
    Target { target: [f32; 3], impulse: Option<f32> },
    /// A blow whose displacement the set predicts.
    Blow(Blow),
}

impl ContactPart {
    /// Sort key that makes the order of a contact's parts independent of their arrival. Parts with equal keys are
    /// equal.
    fn key(&self) -> ([u32; 3], [u64; 3], Option<u32>, [u32; 13]) {
        let point = self.point.to_array().map(f64::to_bits);
        match self.push {
            Push::Target { target, impulse } => (target.map(f32::to_bits), point, impulse.map(f32::to_bits), [0; 13]),
            Push::Blow(blow) => ([0; 3], point, None, blow.key()),
        }
    }
}

/// The state of one open contact.
#[derive(Debug, Clone)]
struct OpenContact {
    id: NonZeroU64,
    /// The number of the fold that brought its last hit.
    last_fold: u64,
    sum: Sum,
    /// The effect of the sum of its hits; `None` if it is too weak.
    outcome: Option<Outcome>,
}

/// The hits of a contact together.
#[derive(Debug, Clone, Default)]
struct Sum {
    /// Sum of the targets, m.
    target: DVec3,
    /// Sum of the points times the lengths of their targets or impulses, and sum of these lengths.
    point: DVec3,
    weight: f64,
    /// Sum of the impulses, N·s; those of targets each along its target.
    impulse: DVec3,
    /// Whether any hit was given as a displacement; the yield impulse does not apply to these.
    displaced: bool,
    /// Sum of the blows' unit normals times the lengths of their impulses, N·s.
    normal: DVec3,
    /// The blows together, without their impulses and normals. `None` if there is none.
    blow: Option<Blow>,
}

impl OpenContact {
    fn mark(&self) -> Option<Mark> {
        self.outcome.and_then(|outcome| outcome.mark)
    }
}

impl Sum {
    fn add(&mut self, part: &ContactPart) {
        let double = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
        let length = match part.push {
            Push::Target { target, impulse } => {
                let target = double(target);
                let length = target.length();
                self.target += target;
                match impulse {
                    Some(j) if length > 0.0 => self.impulse += target * (f64::from(j) / length),
                    Some(_) => {}
                    None => self.displaced = true,
                }
                length
            }
            Push::Blow(blow) => {
                self.impulse += blow.impulse.map_or(DVec3::ZERO, double);
                self.blow = Some(self.blow.map_or(blow, |other| together(&other, &blow)));
                let length = blow.total_impulse().map_or(0.0, |j| double(j).length());
                self.normal += blow.normal.map_or(DVec3::ZERO, |n| double(n).normalize_or_zero() * length);
                length
            }
        };
        self.point += part.point * length;
        self.weight += length;
    }

    /// The effect of the sum of its hits; `None` if the sum is below the yield impulse or moves nothing.
    fn select(&self, set: &ExampleSet, params: &HitParams) -> Option<Outcome> {
        let by_target = self.blow.is_none();
        let weak = by_target && !self.displaced && self.impulse.length() < f64::from(params.options.yield_impulse);
        if weak || self.weight <= 0.0 {
            return None;
        }
        // Each point was near enough, but their mean may lie inside the body.
        let params = HitParams { max_distance: f32::INFINITY, ..params.clone() };
        let point = to_f32(self.point / self.weight);
        let mut target = self.target;
        if let Some(blow) = self.blow {
            let normal = blow.normal.and_then(|_| self.normal.try_normalize()).map(to_f32);
            let whole = Blow { impulse: blow.impulse.map(|_| to_f32(self.impulse)), normal, ..blow };
            let whole = Hit::blow(point, whole);
            let outcome = select(set, &params, &whole).ok()?;
            if !self.displaced {
                return Some(outcome);
            }
            target += DVec3::from_array(outcome.target.map(f64::from));
        }
        select(set, &params, &Hit::displacement(point, to_f32(target))).ok()
    }
}

/// Two blows of one contact as one: the fastest velocity, the heaviest mass and the largest radius. Does not depend on
/// their order. Impulses and normals are summed elsewhere.
fn together(a: &Blow, b: &Blow) -> Blow {
    let size = |v: Option<[f32; 3]>| v.map_or(-1.0, |v| v.iter().map(|x| f64::from(*x) * f64::from(*x)).sum());
    // Bits decide between vectors of equal length.
    let longer = |a: Option<[f32; 3]>, b: Option<[f32; 3]>| {
        let order = size(a)
            .total_cmp(&size(b))
            .then_with(|| a.map(|a| a.map(f32::to_bits)).cmp(&b.map(|b| b.map(f32::to_bits))));
        if order.is_ge() { a } else { b }
    };
    let larger = |a: Option<f32>, b: Option<f32>| a.zip(b).map(|(a, b)| a.max(b)).or(a).or(b);
    Blow {
        impulse: a.impulse.or(b.impulse),
        duration: larger(a.duration, b.duration),
        normal: a.normal.or(b.normal),
        striker: Striker {
            mass: larger(a.striker.mass, b.striker.mass),
            velocity: longer(a.striker.velocity, b.striker.velocity),
            radius: larger(a.striker.radius, b.striker.radius),
            shape: a.striker.shape.max(b.striker.shape),
        },
    }
}

/// The open contacts of one instance.
#[derive(Debug, Default)]
pub(crate) struct Contacts {
    /// Sorted by id.
    open: Vec<OpenContact>,
    /// The contacts that ended last and their outcomes, the latest at the end.
    ended: VecDeque<(NonZeroU64, Option<Outcome>)>,
    /// The damage without the open contacts; kept only while there are any.
    settled: Damage,
    folds: u64,
}

impl Contacts {
    /// The most contacts that are open at a time. Beyond it, the contact hit longest ago ends first. Also the number of
    /// ended contacts whose outcomes are kept.
    pub(crate) const MAX: usize = 256;

    pub(crate) fn len(&self) -> usize {
        self.open.len()
    }

    /// Ends all open contacts. `damage` stays as shown.
    pub(crate) fn close_all(&mut self) {
        while !self.open.is_empty() {
            self.end(0);
        }
        self.settled = Damage::default();
    }

    /// Ends an open contact and returns its mark.
    fn end(&mut self, at: usize) -> Option<Mark> {
        let open = self.open.remove(at);
        if self.ended.len() == Self::MAX {
            self.ended.pop_front();
        }
        self.ended.push_back((open.id, open.outcome));
        open.mark()
    }

    pub(crate) fn memory_bytes(&self) -> usize {
        self.open.len() * size_of::<OpenContact>()
            + self.ended.len() * size_of::<(NonZeroU64, Option<Outcome>)>()
            + self.settled.memory_bytes()
    }

    pub(crate) fn is_open(&self, id: NonZeroU64) -> bool {
        self.open.binary_search_by_key(&id, |o| o.id).is_ok()
    }

    /// The outcome of a contact: an open one so far, or that of the last one with this id that ended. `None` if it is
    /// unknown, and inside that if it is too weak to leave a mark.
    pub(crate) fn outcome(&self, id: NonZeroU64) -> Option<Option<Outcome>> {
        match self.open.binary_search_by_key(&id, |o| o.id) {
            Ok(at) => Some(self.open[at].outcome),
            Err(_) => self.ended.iter().rev().find(|(ended, _)| *ended == id).map(|(_, outcome)| *outcome),
        }
    }

    /// Updates `damage`, which holds the settled marks and those of open contacts, by new marks and events. Events are in order of
    /// arrival.
    pub(crate) fn fold(
        &mut self,
        set: &ExampleSet,
        params: &HitParams,
        capacity: usize,
        (mut marks, events): (Vec<Mark>, Vec<ContactEvent>),
        damage: &mut Damage,
    ) {
        let shown = std::mem::take(damage);
        let mut settled = if self.open.is_empty() { shown } else { std::mem::take(&mut self.settled) };
        self.apply(events, set, params, &mut marks);
        while self.open.len() > Self::MAX {
            let stalest = (0..self.open.len()).min_by_key(|i| (self.open[*i].last_fold, self.open[*i].id));
            marks.extend(stalest.and_then(|i| self.end(i)));
        }
        settled.add(set, marks, capacity);
        let open: Vec<Mark> = self.open.iter().filter_map(OpenContact::mark).collect();
        if self.open.is_empty() {
            *damage = settled;
        } else {
            *damage = settled.clone();
            damage.add(set, open, capacity);
            self.settled = settled;
        }
    }

    /// Adds parts to their contacts. Appends the marks of contacts that end to `ended`.
    ///
    /// Each id has its own sequence of parts and ends. So the result depends neither on the order of different contacts
    /// nor on how often damage was folded in between.
    fn apply(&mut self, mut events: Vec<ContactEvent>, set: &ExampleSet, params: &HitParams, ended: &mut Vec<Mark>) {
        self.folds += 1;
        // The sort is stable, so events of one id stay in order of arrival.
        events.sort_by_key(|event| event.id);
        let mut parts = Vec::new();
        for of_one in events.chunk_by(|a, b| a.id == b.id) {
            let id = of_one[0].id;
            for event in of_one {
                match event.part {
                    Some(part) => parts.push(part),
                    None => {
                        self.add_parts(id, &mut parts, set, params);
                        if let Ok(at) = self.open.binary_search_by_key(&id, |o| o.id) {
                            ended.extend(self.end(at));
                        }
                    }
                }
            }
            self.add_parts(id, &mut parts, set, params);
        }
    }

    /// Adds parts to the contact of this id, which is opened if needed. Empties the list.
    fn add_parts(&mut self, id: NonZeroU64, parts: &mut Vec<ContactPart>, set: &ExampleSet, params: &HitParams) {
        if parts.is_empty() {
            return;
        }
        parts.sort_unstable_by_key(ContactPart::key);
        let at = self.open.binary_search_by_key(&id, |o| o.id).unwrap_or_else(|at| {
            self.open.insert(at, OpenContact { id, last_fold: 0, sum: Sum::default(), outcome: None });
            at
        });
        let open = &mut self.open[at];
        parts.drain(..).for_each(|p| open.sum.add(&p));
        open.last_fold = self.folds;
        open.outcome = open.sum.select(set, params);
    }
}
