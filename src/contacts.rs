//! Contacts that last: an engine that reports one contact as many small impulses, one a step, gives them one id, and they
//! make one dent, whatever the length of the step.
//!
//! While a contact is open its mark is provisional: it lies upon the settled marks and is made anew, from the sum of all
//! hits so far, with each fold that brings more. What is shown is therefore always what it would be had every open contact
//! been reported whole; nothing is taken back from marks that have merged.

use crate::damage::Damage;
use crate::dent::Dent;
use crate::examples::ExampleSet;
use crate::select::{Effect, Params, select, to_f32};
use crate::{Hit, Mark};
use glam::DVec3;
use std::num::NonZeroU64;

/// One hit's part of a contact, in the mesh's space.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Part {
    pub id: NonZeroU64,
    pub point: DVec3,
    /// Displacement asked for, m.
    pub target: [f32; 3],
    /// Length of the impulse, N·s; `None` of a hit by displacement.
    pub impulse: Option<f32>,
}

impl Part {
    /// Sorts parts the same way whatever order they came in; equal keys are equal parts.
    fn key(&self) -> (NonZeroU64, [u32; 3], [u64; 3], Option<u32>) {
        let point = self.point.to_array().map(f64::to_bits);
        (self.id, self.target.map(f32::to_bits), point, self.impulse.map(f32::to_bits))
    }
}

/// What one open contact has come to.
#[derive(Debug, Clone)]
struct Open {
    id: NonZeroU64,
    /// The fold that brought its last hit.
    last: u64,
    /// Sum of the targets, m.
    target: DVec3,
    /// Sum of points times the lengths of their targets, and of these lengths.
    point: DVec3,
    weight: f64,
    /// Sum of the impulses, N·s, each along its target.
    impulse: DVec3,
    /// Whether any hit was given as a displacement, which the yield impulse says nothing about.
    displaced: bool,
    mark: Option<Mark>,
}

impl Open {
    fn new(id: NonZeroU64) -> Self {
        let zero = DVec3::ZERO;
        Open { id, last: 0, target: zero, point: zero, weight: 0.0, impulse: zero, displaced: false, mark: None }
    }

    fn add(&mut self, part: &Part) {
        let target = DVec3::from_array(part.target.map(f64::from));
        let length = target.length();
        self.target += target;
        self.point += part.point * length;
        self.weight += length;
        match part.impulse {
            Some(j) if length > 0.0 => self.impulse += target * (f64::from(j) / length),
            Some(_) => {}
            None => self.displaced = true,
        }
    }

    /// The mark that the sum makes.
    fn select(&self, set: &ExampleSet, params: &Params) -> Option<Mark> {
        let weak = !self.displaced && self.impulse.length() < f64::from(params.yield_impulse);
        if weak || self.weight <= 0.0 {
            return None;
        }
        // Each point was near enough; their mean may lie inside the body.
        let params = Params { max_distance: f32::INFINITY, ..*params };
        match select(set, &params, &Hit::displacement(to_f32(self.point / self.weight), to_f32(self.target))) {
            Ok((_, Effect::Mark(mark))) => Some(mark),
            _ => None,
        }
    }
}

/// What a fold brings.
pub(crate) struct News {
    pub marks: Vec<Mark>,
    pub parts: Vec<Part>,
    /// Contacts that end, after the parts of this fold.
    pub ended: Vec<NonZeroU64>,
}

/// The open contacts of one instance.
#[derive(Debug, Default)]
pub(crate) struct Contacts {
    /// By id.
    open: Vec<Open>,
    /// The damage without them; kept only while there are any.
    settled: Damage,
    folds: u64,
}

impl Contacts {
    /// More than these are never open: the one that was hit longest ago is closed first.
    pub(crate) const MAX: usize = 256;

    pub(crate) fn len(&self) -> usize {
        self.open.len()
    }

    /// Ends all of them. What `damage` shows is what stays.
    pub(crate) fn close_all(&mut self) {
        self.open.clear();
        self.settled = Damage::default();
    }

    pub(crate) fn memory_bytes(&self) -> usize {
        self.open.len() * size_of::<Open>() + self.settled.memory_bytes()
    }

    /// Brings `damage`, which shows settled marks and open contacts together, up to date.
    pub(crate) fn fold(
        &mut self,
        set: &ExampleSet,
        params: &Params,
        capacity: usize,
        mut news: News,
        damage: &mut Damage,
        touched: &mut dyn FnMut(&Dent),
    ) {
        let before = std::mem::take(damage);
        let mut settled = if self.open.is_empty() { before.clone() } else { std::mem::take(&mut self.settled) };
        self.add(&mut news.parts, set, params);
        let mut marks = news.marks;
        while self.open.len() > Self::MAX {
            let stalest = (0..self.open.len()).min_by_key(|i| (self.open[*i].last, self.open[*i].id));
            marks.extend(stalest.and_then(|i| self.open.remove(i).mark));
        }
        for id in news.ended {
            if let Ok(at) = self.open.binary_search_by_key(&id, |o| o.id) {
                marks.extend(self.open.remove(at).mark);
            }
        }
        settled.add(set, marks, capacity, &mut |_| {});
        let open: Vec<Mark> = self.open.iter().filter_map(|o| o.mark).collect();
        if self.open.is_empty() {
            *damage = settled;
        } else {
            *damage = settled.clone();
            damage.add(set, open, capacity, &mut |_| {});
            self.settled = settled;
        }
        damage.differences(&before, touched);
    }

    fn add(&mut self, parts: &mut [Part], set: &ExampleSet, params: &Params) {
        self.folds += 1;
        parts.sort_unstable_by_key(Part::key);
        for of_one in parts.chunk_by(|a, b| a.id == b.id) {
            let id = of_one[0].id;
            let at = self.open.binary_search_by_key(&id, |o| o.id).unwrap_or_else(|at| {
                self.open.insert(at, Open::new(id));
                at
            });
            let open = &mut self.open[at];
            of_one.iter().for_each(|p| open.add(p));
            open.last = self.folds;
            open.mark = open.select(set, params);
        }
    }
}
