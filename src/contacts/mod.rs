//! From a physics engine's contact points to hits.
//!
//! An engine reports points, several a step, for as long as bodies touch. A set knows blows. Between them:
//!
//! 1. `point`: a point is checked and waits for the step's end;
//! 2. `manifold`: the points of a pair in a step become one blow, or several if they are further apart than a dent;
//! 3. `touch`: the blows of successive steps at one place become one contact of the body, and so one dent;
//! 4. `scale` has the thresholds under which a body rests, and `share` divides a blow between two bodies that dent.
//!
//! The energy of a blow is half of the normal impulse times the approach speed. So parts of a contact add up to the
//! whole, and what does not approach leaves nothing.

mod manifold;
pub(crate) mod options;
pub(crate) mod point;
pub(crate) mod report;
mod scale;
mod share;
mod touch;

use crate::base::error::{Error, positive};
use crate::base::sync::{Mutex, MutexGuard};
use crate::instance::inbox::Inbox;
use crate::select::hit::Hit;
use glam::{DMat3, DVec3};
use manifold::{Part, Push, next_blow};
use options::ContactOptions;
use point::{Body, ContactPoint, Reported};
use report::{ContactHit, ContactReport};
use scale::{Scale, Scales};
use share::shares;
use std::num::NonZeroU64;
use std::ops::Range;
use std::sync::Arc;
use touch::{Fit, Key, Touch};

/// Contacts of the layer have ids from here on, so that they are not those of a host.
const FIRST_ID: u64 = 1 << 63;

/// Who is told of each hit.
type Told<'a> = dyn FnMut(&ContactHit<'_>) + 'a;

/// m/s².
const GRAVITY: f64 = 9.81;

/// Turns the contact points that a physics engine reports into hits on instances.
///
/// Report the points of a step of the physics from any thread, and call [`step`](Self::step) once after it. All points of
/// one place make one dent, at any rate of steps; what rests, rolls, slides or jitters makes none. The dents depend on the
/// points of each step, not on the order in which threads report them.
///
/// Hits are given contact ids from 2^63 on; give other ids to hits of your own. Points are in world space: keep the
/// instances' [transforms](crate::Instance::set_transform) up to date.
///
/// All functions may be called from any thread. It does not allocate in steady state, apart from what the hits
/// themselves need.
///
/// ```
/// use crumple::*;
/// use std::sync::Arc;
/// # let mesh = MeshData { positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], triangles: vec![[0, 1, 2]], ..Default::default() };
/// let mut dent = ExampleData::new("dent", Deltas::Sparse { indices: vec![0], values: vec![[0.0, 0.0, -0.1]] });
/// let striker = Striker { mass: Some(8.0), velocity: Some([0.0, 0.0, -5.0]), radius: None, ..Default::default() };
/// dent.blow = Blow::of_striker(striker);
/// let set = Arc::new(ExampleSet::build(mesh, vec![dent], SetOptions::default(), &Serial)?);
/// let mut body = Instance::new(set, InstanceOptions::default())?;
///
/// let contacts = ContactLayer::new(ContactOptions::default())?;
/// let mut point = ContactPoint::new(7, [Some(body.inbox().clone()), None], [0.0; 3], [0.0, 0.0, 1.0]);
/// point.velocity = Some([0.0, 0.0, -4.0]); // of the other body, before the step
/// point.impulse = Some(32.0);
/// contacts.report(&[point])?;
/// let report = contacts.step(1.0 / 60.0)?;
/// assert_eq!(report.hits, 1);
/// assert_eq!(body.marks()?.len(), 1);
/// # Ok::<(), crumple::Error>(())
/// ```
#[derive(Debug)]
pub struct ContactLayer {
    waiting: Mutex<Waiting>,
    state: Mutex<State>,
}

/// Points that wait for the step.
#[derive(Debug)]
struct Waiting {
    points: Vec<Reported>,
    most: usize,
}

#[derive(Debug, Default)]
struct State {
    options: ContactOptions,
    scales: Scales,
    /// Sorted by key, then by id.
    touches: Vec<Touch>,
    /// Time of the physics, and how long the step lasted, s.
    now: f64,
    seconds: f64,
    last_id: u64,
    totals: ContactReport,
    // Memory that steps use again.
    points: Vec<Reported>,
    pushes: Vec<Push>,
    parts: Vec<Part>,
}

impl ContactLayer {
    /// Makes a layer without touches.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] naming the option.
    pub fn new(options: ContactOptions) -> Result<Self, Error> {
        options.check()?;
        let state = State { options, last_id: FIRST_ID, ..State::default() };
        let waiting = Waiting { points: Vec::new(), most: options.max_points as usize };
        Ok(ContactLayer { waiting: Mutex::new(waiting), state: Mutex::new(state) })
    }

    /// Returns the options in use.
    pub fn options(&self) -> ContactOptions {
        self.state().options
    }

    /// Changes the options. Touches that last go on with them.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] naming the option. After an error nothing has changed.
    pub fn set_options(&self, options: ContactOptions) -> Result<(), Error> {
        options.check()?;
        self.state().options = options;
        self.waiting().most = options.max_points as usize;
        Ok(())
    }

    /// Takes points of the current step: all, or none if one is wrong. Any number of threads may call it at once.
    ///
    /// # Errors
    /// [`Error::NotFinite`] or [`Error::InvalidArgument`] naming the point and its part (also if there are more than
    /// [`max_points`](ContactOptions::max_points) since the last step); [`Error::WrongRule`] for a body with a classic
    /// rule; [`Error::OutOfMemory`].
    pub fn report(&self, points: &[ContactPoint]) -> Result<(), Error> {
        self.report_each(points.iter().map(|point| Ok(point.clone())))
    }

    /// Takes points that are made one after the other.
    pub(crate) fn report_each<E: From<Error>>(
        &self,
        points: impl ExactSizeIterator<Item = Result<ContactPoint, E>>,
    ) -> Result<(), E> {
        let mut waiting = self.waiting();
        let (before, most) = (waiting.points.len(), waiting.most);
        let all = before + points.len();
        if all > most {
            let expected = format!("at most {most} (max_points): call step after each step of the physics");
            return Err(Error::invalid("points", format!("{all} since the last step"), &expected).into());
        }
        let bytes = (all * size_of::<Reported>()) as u64;
        waiting
            .points
            .try_reserve(points.len())
            .map_err(|_| Error::OutOfMemory { what: "contact points".into(), bytes })?;
        for (i, point) in points.enumerate() {
            let checked = point.and_then(|point| {
                point.check(i)?;
                Ok(Reported::new(&point))
            });
            match checked {
                Ok(point) => waiting.points.push(point),
                Err(error) => {
                    waiting.points.truncate(before);
                    return Err(error);
                }
            }
        }
        Ok(())
    }

    /// Ends a step of the physics that lasted `seconds`: turns the points reported since the last call into hits. Call it
    /// once after each step, also if nothing touched. A hit that a body refuses does not keep others back; see
    /// [`ContactReport::refusal`]. Two calls at once take turns.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] if `seconds` is not above 0; [`Error::OutOfMemory`]. After an error nothing has changed.
    pub fn step(&self, seconds: f32) -> Result<ContactReport, Error> {
        self.step_each(seconds, |_| ())
    }

    /// Like [`step`](Self::step), and calls `told` with each hit and its effect, for sounds and sparks. A call back into
    /// the layer never returns.
    ///
    /// # Errors
    /// Those of [`step`](Self::step).
    pub fn step_each(&self, seconds: f32, mut told: impl FnMut(&ContactHit<'_>)) -> Result<ContactReport, Error> {
        positive("seconds", seconds, "s")?;
        let mut state = self.state();
        let state = &mut *state;
        let mut waiting = self.waiting();
        state.make_room(waiting.points.len())?;
        // Points that come from now on go to memory that an earlier step left.
        let mut points = std::mem::replace(&mut waiting.points, std::mem::take(&mut state.points));
        drop(waiting);
        state.seconds = f64::from(seconds);
        state.now += state.seconds;
        points.sort_unstable_by(Reported::order);
        let mut report = ContactReport { points: points.len() as u64, ..Default::default() };
        for pair in points.chunk_by(|a, b| a.key() == b.key()) {
            state.pair(pair, &mut report, &mut told);
        }
        points.clear();
        state.points = points;
        state.end_old(&mut report);
        report.open = state.touches.len() as u64;
        state.totals.add(&report);
        Ok(report)
    }

    /// Returns the sums of all steps' counts; `open` is that of the last step.
    pub fn totals(&self) -> ContactReport {
        self.state().totals.clone()
    }

    /// Ends all touches and forgets the points that wait, as after loading a saved game. Dents stay.
    pub fn clear(&self) {
        self.waiting().points.clear();
        let mut report = ContactReport::default();
        self.state().touches.drain(..).for_each(|touch| report.end(&touch));
    }

    fn waiting(&self) -> MutexGuard<'_, Waiting> {
        self.waiting.lock().unwrap_or_else(|e| e.into_inner())
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(|e| e.into_inner())
    }
}

impl ContactReport {
    /// Brings a hit to a body, and counts it.
    fn hit(&mut self, pair: u64, inbox: &Arc<Inbox>, hit: &Hit, told: &mut Told<'_>) {
        match inbox.submit(hit) {
            Ok(outcome) => {
                self.hits += 1;
                told(&ContactHit { pair, inbox, hit, outcome: &outcome });
            }
            Err(error) => {
                self.refused += 1;
                self.refusal.get_or_insert(error);
            }
        }
    }

    /// Ends a touch, and counts it.
    fn end(&mut self, touch: &Touch) {
        self.ended += 1;
        if touch.has_struck() {
            // Refused if the instance refused all hits of the touch.
            let _ = touch.body.inbox.upgrade().map(|inbox| inbox.end_contact(touch.id));
        } else {
            self.weak += 1;
        }
    }
}

/// One body of a pair that dents.
struct Dented<'a> {
    key: Key,
    body: &'a Body,
    scale: Scale,
    /// The transform from world space.
    to_body: (DMat3, DVec3),
}

impl State {
    /// The points of one pair in this step.
    fn pair(&mut self, points: &[Reported], report: &mut ContactReport, told: &mut Told<'_>) {
        self.seen(points[0].key(), report);
        let bodies = [0, 1].map(|side| points[0].bodies[side].as_ref());
        let inboxes = bodies.map(|body| body.and_then(|body| body.inbox.upgrade()));
        if inboxes.iter().all(Option::is_none) {
            return;
        }
        let mut pushes = std::mem::take(&mut self.pushes);
        manifold::pushes(points, &self.options, &mut pushes);
        let mut share = None;
        for side in 0..2 {
            let (Some(body), Some(inbox)) = (bodies[side], &inboxes[side]) else { continue };
            let (pair, numbers) = points[0].key();
            let scale = self.scales.of(inbox.example_set()).with(&self.options);
            let dented = Dented { key: (pair, numbers, side), body, scale, to_body: inbox.world_to_local() };
            if !self.live(points, &pushes, &dented, report) {
                continue;
            }
            // Only touches that begin need it, and it takes two predictions.
            let mut own = || {
                (*share.get_or_insert_with(|| match &inboxes {
                    [Some(a), Some(b)] => shares(points, &pushes, [a, b]),
                    _ => [1.0; 2],
                }))[side]
            };
            let cap = self.cap(dented.key);
            while let Some(blow) = next_blow(&mut self.parts, dented.scale.radius) {
                if let Some(hit) = self.blow(&dented, &blow, cap, &mut own, report) {
                    report.hit(pair, inbox, &hit, told);
                }
            }
        }
        self.pushes = pushes;
    }

    /// Reserves the memory that a step of so many points may need.
    fn make_room(&mut self, points: usize) -> Result<(), Error> {
        let touches = (2 * points).min((self.options.max_touches as usize).saturating_sub(self.touches.len()));
        let each = size_of::<Push>() + size_of::<Part>() + size_of::<Touch>();
        let full = |_| Error::OutOfMemory { what: "contacts".into(), bytes: (points * each) as u64 };
        self.pushes.try_reserve(points).map_err(full)?;
        self.parts.try_reserve(points).map_err(full)?;
        self.touches.try_reserve(touches).map_err(full)
    }

    /// Notes that a pair touches. Ends the touches of other bodies that had its number.
    fn seen(&mut self, (pair, numbers): (u64, [u64; 2]), report: &mut ContactReport) {
        let from = self.touches.partition_point(|touch| touch.key.0 < pair);
        let mut at = from;
        while at < self.touches.len() && self.touches[at].key.0 == pair {
            if self.touches[at].key.1 == numbers {
                self.touches[at].last = self.now;
                at += 1;
            } else {
                report.end(&self.touches.remove(at));
            }
        }
    }

    /// Fills `parts` with the points that push the body fast enough. Whether there are any.
    fn live(&mut self, points: &[Reported], pushes: &[Push], dented: &Dented<'_>, report: &mut ContactReport) -> bool {
        self.parts.clear();
        let scale = &dented.scale;
        let total: f64 = pushes.iter().map(|push| push.impulse).sum();
        // A touch goes on at less speed than it needs to begin. Solvers stop bodies in several steps, and the last may be as
        // slow as a body that rests. The touch's cap keeps the weight out, if the approach is known.
        let (begins, resting) = (self.touches_of(dented.key).is_empty(), self.resting(scale));
        let least = |push: &Push| match push.approach() {
            _ if begins => scale.speed,
            Some(_) => 0.0,
            None => resting,
        };
        let fast = |push: &Push| push.speed.map_or(total >= scale.impulse, |speed| speed >= least(push));
        for (point, push) in points.iter().zip(pushes) {
            if push.impulse <= 0.0 {
                continue;
            }
            if fast(push) {
                self.parts.push(Part::new(point, *push, dented.key.2, dented.to_body));
            } else if push.speed.is_some_and(|speed| speed < -scale.speed) {
                report.separating += 1;
            } else {
                report.slow += 1;
            }
        }
        !self.parts.is_empty()
    }

    /// One blow on one body: adds it to its touch. Returns what is strong enough for a hit.
    fn blow(
        &mut self,
        dented: &Dented<'_>,
        blow: &Part,
        cap: f64,
        share: &mut dyn FnMut() -> f64,
        report: &mut ContactReport,
    ) -> Option<Hit> {
        let (key, scale) = (dented.key, &dented.scale);
        let begins = blow.push.speed.is_none_or(|speed| speed >= scale.speed);
        let at = match self.nearest(key, blow, scale.radius) {
            None if !begins => {
                report.slow += 1;
                return None;
            }
            Some(at) => match self.touches[at].fit(blow) {
                Fit::Holds => {
                    report.slow += 1;
                    return None;
                }
                Fit::Same => at,
                Fit::Another => {
                    report.end(&self.touches.remove(at));
                    self.begin(dented, blow, share(), report)
                }
            },
            None => self.begin(dented, blow, share(), report),
        };
        let others = self.whole(key) - self.touches[at].whole().unwrap_or(0.0);
        let touch = &mut self.touches[at];
        touch.cap = cap;
        touch.add(blow, cap - others);
        touch.hit(scale.energy, dented.to_body)
    }

    /// Energy of the touches of a key before the bodies share it, J.
    fn whole(&self, key: Key) -> f64 {
        self.touches[self.touches_of(key)].iter().filter_map(Touch::whole).sum()
    }

    /// The most energy that the touches of a key may have, J. `parts` has the step's points.
    ///
    /// Solvers push bodies apart over several steps, and corners of one that tumbles follow each other. Together they bring
    /// no more than the bodies' approach had when they met, unless a single step does: then something else pushes.
    fn cap(&mut self, key: Key) -> f64 {
        let step: f64 = self.parts.iter().map(|part| part.push.energy()).sum();
        let touches = &self.touches[self.touches_of(key)];
        let faster = |part: &Part| touches.iter().all(|touch| touch.is_slower_than(part));
        let cap = if self.parts.iter().any(faster) {
            let approach = self.parts.iter().map(|part| part.push.approach().unwrap_or(f64::INFINITY));
            self.whole(key) + approach.fold(step, f64::max)
        } else {
            touches.iter().map(|touch| touch.cap).fold(step, f64::max)
        };
        let touches = self.touches_of(key);
        self.touches[touches].iter_mut().for_each(|touch| touch.cap = cap);
        cap
    }

    /// The touches of a key.
    fn touches_of(&self, key: Key) -> Range<usize> {
        let from = self.touches.partition_point(|touch| touch.key < key);
        from..from + self.touches[from..].partition_point(|touch| touch.key == key)
    }

    /// The approach speed that bodies at rest may have in this step, m/s: gravity's, twice over.
    fn resting(&self, scale: &Scale) -> f64 {
        scale.speed.min(2.0 * GRAVITY * self.seconds)
    }

    /// The touch of a key whose place is nearest to a blow, within `radius`.
    fn nearest(&self, key: Key, blow: &Part, radius: f64) -> Option<usize> {
        let distance = |at: &usize| self.touches[*at].place.distance_squared(blow.place);
        self.touches_of(key)
            .filter(|at| distance(at) <= radius * radius)
            .min_by(|a, b| distance(a).total_cmp(&distance(b)))
    }

    /// Begins a touch and returns its index. If there are too many, the oldest ends.
    fn begin(&mut self, dented: &Dented<'_>, blow: &Part, share: f64, report: &mut ContactReport) -> usize {
        if self.touches.len() >= self.options.max_touches as usize {
            let oldest = (0..self.touches.len()).min_by_key(|at| self.touches[*at].id);
            if let Some(at) = oldest {
                report.crowded += 1;
                report.end(&self.touches.remove(at));
            }
        }
        let id = NonZeroU64::new(self.last_id).unwrap_or(NonZeroU64::MAX);
        self.last_id = self.last_id.checked_add(1).unwrap_or(FIRST_ID);
        report.begun += 1;
        let at = self.touches.partition_point(|touch| touch.key <= dented.key);
        self.touches.insert(at, Touch::new(dented.key, id, dented.body.clone(), blow.place, self.now, share));
        at
    }

    /// Ends the touches that lasted long enough, whose bodies separated, or whose body is gone.
    fn end_old(&mut self, report: &mut ContactReport) {
        let (now, options) = (self.now, self.options);
        // Times are sums of f32: a step more or less must not depend on rounding.
        let over = |from: f64, time: f32| now - from > f64::from(time) - 1e-6;
        self.touches.retain(|touch| {
            let over = over(touch.begin, options.touch_time)
                || over(touch.last, options.separation_time) && touch.last < now
                || touch.body.inbox.strong_count() == 0;
            if over {
                report.end(touch);
            }
            !over
        });
    }
}
