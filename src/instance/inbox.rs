//! The inbox, where hits arrive from any thread.

use super::contacts::{ContactEvent, ContactPart, Contacts, Push};
use super::selection::select;
use crate::base::error::Error;
use crate::base::sync::{Mutex, MutexGuard, RwLock, RwLockReadGuard, RwLockWriteGuard};
use crate::damage::mark::Mark;
use crate::example::set::ExampleSet;
use crate::select::hit::{Cause, Hit, HitStatus, Outcome};
use crate::select::options::Rule;
use crate::select::target::HitParams;
use glam::{DMat3, DVec3, Mat4};
use std::collections::BTreeSet;
use std::num::NonZeroU64;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Weak};

/// A hit that waits for the next fold.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Pending {
    Mark(Mark),
    /// Contact vertex, example, bits of the weight. The weight is positive, so its bits sort as the number does.
    Classic(u32, u32, u32),
    Contact(ContactEvent),
}

/// What has arrived since the last fold, and which contacts have begun.
#[derive(Debug, Default)]
pub(super) struct Queue {
    /// In order of arrival.
    pub pending: Vec<Pending>,
    /// Ids of contacts that hits began and no call ended, also of some that ended by themselves.
    begun: BTreeSet<NonZeroU64>,
}

impl Queue {
    /// The most ids that are kept of contacts that ended by themselves.
    const KEPT: usize = 16 * Contacts::MAX;

    fn add(&mut self, pending: Pending) {
        self.note(&pending);
        self.pending.push(pending);
    }

    fn note(&mut self, pending: &Pending) {
        if let Pending::Contact(event) = pending {
            _ = if event.part.is_some() { self.begun.insert(event.id) } else { self.begun.remove(&event.id) };
        }
    }

    /// Takes what has arrived. Where many contacts are never ended, it forgets those that ended by themselves.
    pub(super) fn take(&mut self, contacts: &Contacts) -> Vec<Pending> {
        let pending = std::mem::take(&mut self.pending);
        if self.begun.len() > Self::KEPT {
            self.begun.retain(|id| contacts.is_open(*id));
            pending.iter().for_each(|pending| self.note(pending));
        }
        pending
    }
}

/// Receives hits. It may be shared among threads, which may all submit at once, also while the instance is deformed.
#[derive(Debug)]
pub struct Inbox {
    /// Later inboxes have higher numbers.
    number: u64,
    set: Arc<ExampleSet>,
    rule: Rule,
    params: RwLock<HitParams>,
    queue: Mutex<Queue>,
    /// Parts that are mounted on the body: what arrives here also arrives there.
    followers: RwLock<Vec<Weak<Inbox>>>,
}

impl Inbox {
    pub(super) fn new(set: Arc<ExampleSet>, params: HitParams) -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(1);
        Inbox {
            number: NEXT.fetch_add(1, Ordering::Relaxed),
            set,
            rule: params.options.rule,
            params: RwLock::new(params),
            queue: Mutex::default(),
            followers: RwLock::default(),
        }
    }

    /// Selects examples for a hit in the calling thread and queues the mark for the instance's next fold.
    ///
    /// A hit that is too weak, or that no example can answer, is no error: see [`Outcome::status`].
    ///
    /// A hit with a [`contact`](Hit::contact) adds to that contact. The displacements of its hits add up; that of an
    /// impulse is `impulse * duration / mass`. If the set predicts blows, impulses add up
    /// instead, and the sum is one blow by the fastest, heaviest and largest striker among the hits. The contact's
    /// point is the mean of the hits' points, weighted by the lengths of their displacements or impulses. The yield thresholds and the depth limit apply to the sum, which leaves one
    /// mark. The mark is shown from the first fold on and is replaced as more hits come, until the contact ends. A
    /// contact ends with [`Inbox::end_contact`], or when the instance's damage is replaced, repaired or reset. If more
    /// than [`Instance::MAX_CONTACTS`](crate::Instance::MAX_CONTACTS) are open, the one hit longest ago ends (among
    /// equals the one with the lowest id). The outcome is that of the hit alone;
    /// [`Instance::contact`](crate::Instance::contact) returns that of the contact.
    ///
    /// # Errors
    /// [`Error::NotFinite`], [`Error::InvalidArgument`] (a bad part of the blow, or no impulse, duration or mass known),
    /// [`Error::ContactTooFar`]; [`Error::WrongRule`] for a contact with a classic rule, which cannot replace what it
    /// has deformed. After an error nothing has been queued.
    pub fn submit(&self, hit: &Hit) -> Result<Outcome, Error> {
        // No part comes off or on until the hit has arrived everywhere.
        let followers = self.followers();
        let (outcome, pending) = self.prepare(hit)?;
        pending.map_or(Ok(()), |pending| self.push(pending, &followers))?;
        Ok(outcome)
    }

    /// Selects examples for a hit without queuing it.
    pub(crate) fn prepare(&self, hit: &Hit) -> Result<(Outcome, Option<Pending>), Error> {
        let params = self.params();
        let mut outcome = self.select(&params, hit)?;
        let Some(id) = hit.contact else {
            let classic =
                outcome.classic.map(|c| Pending::Classic(outcome.contact_vertex, c.example, c.weight.to_bits()));
            return Ok((outcome, outcome.mark.map(Pending::Mark).or(classic)));
        };
        if !matches!(outcome.status, HitStatus::Marked | HitStatus::Rigid) {
            outcome.status = HitStatus::Accumulated;
        }
        let length = |j: [f32; 3]| DVec3::from_array(j.map(f64::from)).length().min(f32::MAX.into()) as f32;
        let push = match hit.cause {
            Cause::Displacement(_) => Push::Target { target: outcome.target, impulse: None },
            Cause::Impulse { blow, .. } if self.set.predicts_blows() => Push::Blow(params.local_blow(&blow, hit.space)),
            Cause::Impulse { blow, .. } => {
                Push::Target { target: outcome.target, impulse: blow.total_impulse().map(length) }
            }
        };
        let part = Some(ContactPart { point: params.local(hit.point, hit.space), push });
        Ok((outcome, Some(Pending::Contact(ContactEvent { id, part }))))
    }

    /// Queues what was prepared. No part may come off or on between the two.
    #[cfg(feature = "capi")]
    pub(crate) fn queue_prepared(&self, pending: Option<Pending>) {
        if let Some(pending) = pending {
            self.queue().add(pending);
            forward(pending, &self.followers());
        }
    }

    /// Ends a contact: its dent stays as it is. The dent is the sum of the hits of this id that arrived before this
    /// call. A later hit of the same id begins another contact. If the contact has ended by itself, nothing happens.
    ///
    /// # Errors
    /// [`Error::UnknownContact`] for an id that no hit has, or that this call ended before; [`Error::WrongRule`] with a
    /// classic rule; [`Error::OutOfMemory`].
    pub fn end_contact(&self, id: NonZeroU64) -> Result<(), Error> {
        self.rule.only_marks("end_contact")?;
        self.push(Pending::Contact(ContactEvent { id, part: None }), &self.followers())
    }

    /// Returns what [`Inbox::submit`] would return for the hit alone, without queuing it.
    ///
    /// # Errors
    /// Those of [`Inbox::submit`].
    pub fn preview(&self, hit: &Hit) -> Result<Outcome, Error> {
        self.select(&self.params(), hit)
    }

    /// Sets the transform from mesh to world space. Hits in [`crate::Space::World`] are transformed by its inverse. Any
    /// thread may call this at any time. A hit uses the transform set at the time it is submitted.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::InvalidArgument`] if the matrix cannot be inverted or its last row is not (0, 0,
    /// 0, 1).
    pub fn set_transform(&self, local_to_world: Mat4) -> Result<(), Error> {
        let bad = |expected: &str| Error::invalid("transform", local_to_world, expected);
        if !local_to_world.is_finite() {
            return Err(Error::NotFinite { name: "transform".into(), value: local_to_world.to_string() });
        }
        if local_to_world.row(3) != glam::Vec4::W {
            return Err(bad(
                "an affine matrix in column-major order: columns x, y, z, translation; last row 0, 0, 0, 1 (a row-major \
                 matrix must be transposed)",
            ));
        }
        let m = local_to_world.as_dmat4();
        let linear = DMat3::from_cols(m.x_axis.truncate(), m.y_axis.truncate(), m.z_axis.truncate());
        let inverse = linear.inverse();
        if linear.determinant() == 0.0 || !inverse.is_finite() {
            return Err(bad("invertible; its determinant is 0"));
        }
        let mut params = self.params_mut();
        params.world_to_local = inverse;
        params.local_origin_in_world = m.w_axis.truncate();
        Ok(())
    }

    pub(crate) fn example_set(&self) -> &Arc<ExampleSet> {
        &self.set
    }

    /// A number that no other inbox of the process has.
    pub(crate) fn number(&self) -> u64 {
        self.number
    }

    /// The linear part of the transform from world to mesh space, and the mesh's origin in world space, m.
    pub(crate) fn world_to_local(&self) -> (DMat3, DVec3) {
        let params = self.params.read().unwrap_or_else(|e| e.into_inner());
        (params.world_to_local, params.local_origin_in_world)
    }

    fn select(&self, params: &HitParams, hit: &Hit) -> Result<Outcome, Error> {
        if hit.contact.is_some() {
            self.rule.only_marks("a hit with a contact id")?;
        }
        select(&self.set, params, hit)
    }

    pub(crate) fn contacts_allowed(&self, call: &str) -> Result<(), Error> {
        self.rule.only_marks(call)
    }

    pub(super) fn params(&self) -> HitParams {
        self.params.read().unwrap_or_else(|e| e.into_inner()).clone()
    }

    pub(super) fn params_mut(&self) -> RwLockWriteGuard<'_, HitParams> {
        self.params.write().unwrap_or_else(|e| e.into_inner())
    }

    fn push(&self, pending: Pending, followers: &[Weak<Inbox>]) -> Result<(), Error> {
        let mut queue = self.queue();
        if let Pending::Contact(ContactEvent { id, part: None }) = pending
            && !queue.begun.contains(&id)
        {
            return Err(Error::UnknownContact { id: id.get() });
        }
        let bytes = (queue.pending.len() as u64 + 1) * size_of::<Pending>() as u64;
        queue.pending.try_reserve(1).map_err(|_| Error::OutOfMemory { what: "hits".into(), bytes })?;
        queue.add(pending);
        drop(queue);
        forward(pending, followers);
        Ok(())
    }

    pub(super) fn followers(&self) -> RwLockReadGuard<'_, Vec<Weak<Inbox>>> {
        self.followers.read().unwrap_or_else(|e| e.into_inner())
    }

    /// Whoever holds it keeps hits from arriving. Their threads wait.
    pub(super) fn followers_mut(&self) -> RwLockWriteGuard<'_, Vec<Weak<Inbox>>> {
        self.followers.write().unwrap_or_else(|e| e.into_inner())
    }

    pub(super) fn queue(&self) -> MutexGuard<'_, Queue> {
        self.queue.lock().unwrap_or_else(|e| e.into_inner())
    }
}

fn forward(pending: Pending, followers: &[Weak<Inbox>]) {
    followers.iter().filter_map(Weak::upgrade).for_each(|inbox| inbox.queue().add(pending));
}
