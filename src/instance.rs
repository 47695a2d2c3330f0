//! One dented copy of a mesh: its inbox of hits, its damage, and which blocks changed when.

use crate::classic::{Blend, State};
use crate::contacts::{Contacts, News, Part};
use crate::damage::{Damage, saved};
use crate::dent::Dent;
use crate::error::at_least_zero;
use crate::examples::ExampleSet;
use crate::select::{Effect, Params, select, to_local};
use crate::tolerance::{rounded, threshold};
use crate::{Cause, Error, Hit, Mark, Outcome, Selection};
use glam::{DMat3, DVec3, Mat4, Vec3};
use std::num::NonZeroU64;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, RwLock};

/// What impulses do to an instance.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Rule {
    /// Marks: bounded, local, free of order, without per-vertex state.
    #[default]
    Marks,
    /// The literature's rule: each vertex keeps the most displaced candidate.
    MostDisplaced,
    /// The literature's other rule: a vertex that is displaced further already blends by this constant, 0 to 1.
    Blend(f32),
}

impl Rule {
    fn name(self) -> &'static str {
        match self {
            Rule::Marks => "Marks",
            Rule::MostDisplaced => "MostDisplaced",
            Rule::Blend(_) => "Blend",
        }
    }
}

/// How an instance is made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InstanceOptions {
    /// What impulses do.
    pub rule: Rule,
    /// How examples are chosen. The classic rules take the classic selections only.
    pub selection: Selection,
    /// How many examples one hit may mix: 1 to 4.
    pub examples_per_hit: u32,
    /// No vertex moves further than this, m. `None`: the set's limit.
    pub depth_limit: Option<f32>,
    /// Marks kept, 1 to 65535; above it marks merge (see [`Instance::marks`]).
    pub capacity: u32,
    /// Impulses shorter than this leave no mark, N·s.
    pub yield_impulse: f32,
    /// Target displacements shorter than this leave no mark, m.
    pub yield_displacement: f32,
    /// Contacts further than this from the nearest vertex are refused, m. `None`: the body's diagonal.
    pub max_contact_distance: Option<f32>,
    /// No vertex is wrong by more than this, m; 0: nothing is left out. See [`Instance::set_tolerance`].
    pub tolerance: f32,
}

impl Default for InstanceOptions {
    fn default() -> Self {
        Self {
            rule: Rule::Marks,
            selection: Selection::Nearest,
            examples_per_hit: 3,
            depth_limit: None,
            capacity: 64,
            yield_impulse: 0.0,
            yield_displacement: 0.0,
            max_contact_distance: None,
            tolerance: 0.0,
        }
    }
}

impl InstanceOptions {
    /// Options for one of the classic rules, with the classic selection.
    pub fn classic(rule: Rule) -> Self {
        Self { rule, selection: Selection::Classic, ..Self::default() }
    }

    fn check(&self) -> Result<(), Error> {
        at_least_zero("yield_impulse", self.yield_impulse, "N·s")?;
        at_least_zero("yield_displacement", self.yield_displacement, "m")?;
        if let Some(d) = self.max_contact_distance {
            at_least_zero("max_contact_distance", d, "m")?;
        }
        check_limit(self.depth_limit)?;
        at_least_zero("tolerance", self.tolerance, "m")?;
        if !(1..=4).contains(&self.examples_per_hit) {
            return Err(Error::invalid("examples_per_hit", self.examples_per_hit, "1 to 4"));
        }
        if !(1..=65535).contains(&self.capacity) {
            return Err(Error::invalid("capacity", self.capacity, "1 to 65535 marks"));
        }
        if let Rule::Blend(k) = self.rule
            && !(0.0..=1.0).contains(&k)
        {
            return Err(Error::invalid("the blend constant", k, "0 to 1"));
        }
        match (self.rule, self.selection) {
            (Rule::Marks, Selection::ClassicUnclamped) => Err(Error::invalid(
                "selection",
                "ClassicUnclamped",
                "Nearest or Classic with the rule Marks, which is bounded",
            )),
            (Rule::MostDisplaced | Rule::Blend(_), Selection::Nearest) => Err(Error::invalid(
                "selection",
                "Nearest",
                &format!("Classic or ClassicUnclamped with the rule {}, which cannot carry examples", self.rule.name()),
            )),
            _ => Ok(()),
        }
    }
}

fn check_limit(limit: Option<f32>) -> Result<(), Error> {
    match limit {
        Some(l) if !(l > 0.0 && l <= 1e9) => Err(Error::invalid("depth_limit", l, "above 0 and at most 1e9 m")),
        _ => Ok(()),
    }
}

/// A hit that waits for the next fold, in a form that sorts.
#[derive(Debug, Clone, Copy)]
enum Pending {
    Mark(Mark),
    /// Contact vertex, example, bits of the weight (positive, so they sort as the numbers do).
    Classic(u32, u32, u32),
    Part(Part),
    End(NonZeroU64),
}

/// Where hits arrive: may be shared among threads, which may all submit at once, also while the instance is deformed.
#[derive(Debug)]
pub struct Inbox {
    set: Arc<ExampleSet>,
    rule: Rule,
    params: RwLock<Params>,
    pending: Mutex<Vec<Pending>>,
}

impl Inbox {
    /// Selects examples for a hit, in the calling thread, and leaves the mark for the instance's next fold.
    ///
    /// A hit that is too weak, or that no example answers, is no error: see [`Outcome::status`].
    ///
    /// Of a hit with a [`contact`](Hit::contact), the outcome tells what it would do alone. With the contact's other hits
    /// it adds up: displacements (of impulses, `impulse * duration / mass`) add, the point is the mean of their points,
    /// weighted by the lengths of their displacements, and the yield thresholds and the depth limit hold for the sum, which
    /// leaves one mark. It is shown from the first fold on and replaced as more hits come, until the contact ends: when
    /// [`Inbox::end_contact`] says so, when the instance's damage is replaced, repaired or reset, or when more than
    /// [`Instance::MAX_CONTACTS`] are open (the one hit longest ago ends then; of equals the lowest id).
    ///
    /// # Errors
    /// [`Error::NotFinite`], [`Error::InvalidArgument`] (duration or mass not above 0, or no mass known),
    /// [`Error::ContactTooFar`]; [`Error::WrongRule`] for a contact with a classic rule, which cannot replace what it has
    /// deformed. Nothing is left behind then.
    pub fn submit(&self, hit: &Hit) -> Result<Outcome, Error> {
        let params = self.params();
        let (outcome, effect) = self.select(&params, hit)?;
        let pending = match (hit.contact, effect) {
            (Some(id), _) => Pending::Part(Part {
                id,
                point: to_local(&params, hit.point, hit.space),
                target: outcome.target,
                impulse: match hit.cause {
                    Cause::Impulse { impulse, .. } => {
                        Some(DVec3::from_array(impulse.map(f64::from)).length().min(f32::MAX.into()) as f32)
                    }
                    Cause::Displacement(_) => None,
                },
            }),
            (None, Effect::None) => return Ok(outcome),
            (None, Effect::Mark(m)) => Pending::Mark(m),
            (None, Effect::Classic { example, weight }) => {
                Pending::Classic(outcome.contact_vertex, example, weight.to_bits())
            }
        };
        self.push(pending)?;
        Ok(outcome)
    }

    /// Ends a contact: its dent stays as it is, and later hits of the same id begin another one. Counts from the next fold
    /// on, after all hits that have arrived by then: use an id again only after that. An id that is not open is no error,
    /// since the contact may have ended already.
    ///
    /// # Errors
    /// [`Error::WrongRule`] with a classic rule; [`Error::OutOfMemory`].
    pub fn end_contact(&self, id: NonZeroU64) -> Result<(), Error> {
        self.contacts_allowed("end_contact")?;
        self.push(Pending::End(id))
    }

    /// What [`Inbox::submit`] would return, without leaving anything.
    ///
    /// # Errors
    /// Those of [`Inbox::submit`].
    pub fn preview(&self, hit: &Hit) -> Result<Outcome, Error> {
        Ok(self.select(&self.params(), hit)?.0)
    }

    fn select(&self, params: &Params, hit: &Hit) -> Result<(Outcome, Effect), Error> {
        if hit.contact.is_some() {
            self.contacts_allowed("a hit with a contact id")?;
        }
        select(&self.set, params, hit)
    }

    fn contacts_allowed(&self, call: &str) -> Result<(), Error> {
        if self.rule == Rule::Marks { Ok(()) } else { Err(needs_marks(call, self.rule)) }
    }

    fn params(&self) -> Params {
        *self.params.read().unwrap_or_else(|e| e.into_inner())
    }

    fn push(&self, pending: Pending) -> Result<(), Error> {
        let mut queue = self.queue();
        let bytes = (queue.len() as u64 + 1) * size_of::<Pending>() as u64;
        queue.try_reserve(1).map_err(|_| Error::OutOfMemory { what: "hits".into(), bytes })?;
        queue.push(pending);
        Ok(())
    }

    fn queue(&self) -> MutexGuard<'_, Vec<Pending>> {
        self.pending.lock().unwrap_or_else(|e| e.into_inner())
    }
}

/// One dented copy of an example set's mesh.
///
/// ```
/// use crumple::*;
/// use std::sync::Arc;
/// # let mesh = MeshData { positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], triangles: vec![[0, 1, 2]], ..Default::default() };
/// # let dent = ExampleData::new("dent", Deltas::Sparse { indices: vec![0], values: vec![[0.0, 0.0, -0.1]] });
/// let set = Arc::new(ExampleSet::build(mesh, vec![dent], SetOptions::default(), &Serial)?);
/// let mut body = Instance::new(set.clone(), InstanceOptions::default())?;
/// let outcome = body.submit(&Hit::displacement([0.0, 0.0, 0.0], [0.0, 0.0, -0.05]))?;
/// assert_eq!(outcome.status, HitStatus::Marked);
///
/// let mut positions = vec![[0.0f32; 3]; set.vertex_count()];
/// let mut tracker = Tracker::new();
/// body.deform(&mut tracker, VertexMemory::separate(&mut positions, None, None)?, &Serial)?;
/// assert!((positions[0][2] + 0.05).abs() < 1e-6);
/// # Ok::<(), crumple::Error>(())
/// ```
#[derive(Debug)]
pub struct Instance {
    set: Arc<ExampleSet>,
    options: InstanceOptions,
    inbox: Arc<Inbox>,
    /// What is shown: settled marks and those of open contacts.
    damage: Damage,
    contacts: Contacts,
    classic: Option<State>,
    limit: f32,
    /// In force: a power of two times 1 m, or 0.
    tolerance: f32,
    /// Displacements no longer than this, as scaled, are left out, m.
    least: f32,
    changes: Changes,
}

/// When each block last changed.
#[derive(Debug)]
pub(crate) struct Changes {
    /// Of this instance alone, so that an output notices when it is given another.
    pub instance: u64,
    /// Grows with each change.
    pub epoch: u64,
    /// Of each level of detail the epoch of the last change of each block; 0 for a block at rest since the beginning.
    pub blocks: Vec<Vec<u64>>,
}

impl Instance {
    /// No more contacts than these are open at a time (see [`Inbox::submit`]).
    pub const MAX_CONTACTS: usize = Contacts::MAX;

    /// An undamaged copy.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] naming the option; [`Error::OutOfMemory`] for the per-vertex state of a classic rule.
    pub fn new(set: Arc<ExampleSet>, options: InstanceOptions) -> Result<Self, Error> {
        static NEXT: AtomicU64 = AtomicU64::new(1);
        options.check()?;
        let diagonal = set.mesh().bounds().diagonal();
        let limit = options.depth_limit.unwrap_or(set.depth_limit());
        let params = Params {
            selection: options.selection,
            examples_per_hit: options.examples_per_hit as usize,
            limit,
            yield_impulse: options.yield_impulse,
            yield_displacement: options.yield_displacement,
            max_distance: options.max_contact_distance.unwrap_or(diagonal.max(limit)),
            world_to_local: DMat3::IDENTITY,
            local_origin_in_world: DVec3::ZERO,
            classic: options.rule != Rule::Marks,
        };
        let classic = if options.rule == Rule::Marks { None } else { Some(State::new(&set)?) };
        let blocks = set.skins().map(|s| vec![0; s.blocks()]).collect();
        let tolerance = if options.rule == Rule::Marks { rounded(options.tolerance) } else { 0.0 };
        let least = threshold(&set, &[], tolerance);
        Ok(Self {
            inbox: Arc::new(Inbox {
                set: set.clone(),
                rule: options.rule,
                params: RwLock::new(params),
                pending: Mutex::default(),
            }),
            set,
            options,
            damage: Damage::default(),
            contacts: Contacts::default(),
            classic,
            limit,
            tolerance,
            least,
            changes: Changes { instance: NEXT.fetch_add(1, Ordering::Relaxed), epoch: 0, blocks },
        })
    }

    /// The set it is a copy of.
    pub fn example_set(&self) -> &Arc<ExampleSet> {
        &self.set
    }

    /// The options it was made with.
    pub fn options(&self) -> &InstanceOptions {
        &self.options
    }

    /// Where its hits arrive, to be shared among threads.
    pub fn inbox(&self) -> &Arc<Inbox> {
        &self.inbox
    }

    /// [`Inbox::submit`].
    ///
    /// # Errors
    /// Those of [`Inbox::submit`].
    pub fn submit(&self, hit: &Hit) -> Result<Outcome, Error> {
        self.inbox.submit(hit)
    }

    /// [`Inbox::end_contact`].
    ///
    /// # Errors
    /// Those of [`Inbox::end_contact`].
    pub fn end_contact(&self, id: NonZeroU64) -> Result<(), Error> {
        self.inbox.end_contact(id)
    }

    /// How many contacts are open.
    pub fn contact_count(&mut self) -> usize {
        self.fold();
        self.contacts.len()
    }

    /// [`Inbox::preview`].
    ///
    /// # Errors
    /// Those of [`Inbox::submit`].
    pub fn preview(&self, hit: &Hit) -> Result<Outcome, Error> {
        self.inbox.preview(hit)
    }

    /// Sets the transform from mesh to world space that hits in [`crate::Space::World`] go through backwards.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::InvalidArgument`] where the matrix cannot be inverted or its last row is not
    /// (0, 0, 0, 1).
    pub fn set_transform(&mut self, local_to_world: Mat4) -> Result<(), Error> {
        let bad = |expected: &str| Error::invalid("transform", local_to_world, expected);
        if !local_to_world.is_finite() {
            return Err(Error::NotFinite { name: "transform".into(), value: local_to_world.to_string() });
        }
        if local_to_world.row(3) != glam::Vec4::W {
            return Err(bad("an affine matrix: columns x, y, z, translation; last row 0, 0, 0, 1"));
        }
        let m = local_to_world.as_dmat4();
        let linear = DMat3::from_cols(m.x_axis.truncate(), m.y_axis.truncate(), m.z_axis.truncate());
        let inverse = linear.inverse();
        if linear.determinant() == 0.0 || !inverse.is_finite() {
            return Err(bad("invertible; its determinant is 0"));
        }
        let mut p = self.inbox.params.write().unwrap_or_else(|e| e.into_inner());
        p.world_to_local = inverse;
        p.local_origin_in_world = m.w_axis.truncate();
        Ok(())
    }

    /// The depth limit in force, m.
    pub fn depth_limit(&self) -> f32 {
        self.limit
    }

    /// Sets the depth limit, m (`None`: the set's). Marks stay; vertices obey at the next deform.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`].
    pub fn set_depth_limit(&mut self, limit: Option<f32>) -> Result<(), Error> {
        check_limit(limit)?;
        self.limit = limit.unwrap_or(self.set.depth_limit());
        self.inbox.params.write().unwrap_or_else(|e| e.into_inner()).limit = self.limit;
        let mut touch = Touch::new(&self.set, &mut self.changes, self.least);
        self.damage.touch_all(&mut |d: &Dent| touch.dent(d));
        Ok(())
    }

    /// The tolerance in force, m: what was asked for, rounded down to a power of two times 1 m; 0 where nothing is left out.
    pub fn tolerance(&self) -> f32 {
        self.tolerance
    }

    /// Lets vertices be wrong by up to `tolerance` (m, in the mesh's space; 0: by nothing) so that deforming costs less:
    /// displacements too short to matter are left out, whole blocks and whole examples of them unread. Seams stay closed bit for
    /// bit. [`crate::pixel_tolerance`] tells how much is invisible at a distance. Rounding of f32 comes on top.
    ///
    /// The tolerance is rounded down to a power of two times 1 m, so that a camera which moves a little changes nothing; where
    /// it changes, what is dented by more is written anew. Instances with a classic rule ignore it.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a tolerance that is negative or not finite.
    pub fn set_tolerance(&mut self, tolerance: f32) -> Result<(), Error> {
        at_least_zero("tolerance", tolerance, "m")?;
        let tolerance = rounded(tolerance);
        if self.classic.is_none() && tolerance != self.tolerance {
            self.tolerance = tolerance;
            self.update_threshold();
        }
        Ok(())
    }

    /// After every change of damage or tolerance.
    fn update_threshold(&mut self) {
        let least = threshold(&self.set, self.damage.dents(), self.tolerance);
        if least != self.least {
            // What neither shows looks as before.
            let mut touch = Touch::new(&self.set, &mut self.changes, least.min(self.least));
            self.least = least;
            self.damage.touch_all(&mut |d: &Dent| touch.dent(d));
        }
    }

    /// Turns the hits that have arrived into damage, in an order of their own: the result does not depend on the order
    /// or the threads they were submitted from. Every call that reads damage does this first.
    pub fn fold(&mut self) {
        let pending = std::mem::take(&mut *self.inbox.queue());
        if pending.is_empty() {
            return;
        }
        let constant = self.blend_constant();
        let mut touch = Touch::new(&self.set, &mut self.changes, self.least);
        let mut news = News { marks: Vec::new(), parts: Vec::new(), ended: Vec::new() };
        let mut classic = Vec::new();
        for p in pending {
            match p {
                Pending::Mark(m) => news.marks.push(m),
                Pending::Classic(contact, example, weight) => classic.push((contact, example, weight)),
                Pending::Part(part) => news.parts.push(part),
                Pending::End(id) => news.ended.push(id),
            }
        }
        let capacity = self.options.capacity as usize;
        let mut touched = |d: &Dent| touch.dent(d);
        if self.contacts.len() > 0 || !news.parts.is_empty() {
            let params = self.inbox.params();
            self.contacts.fold(&self.set, &params, capacity, news, &mut self.damage, &mut touched);
        } else if !news.marks.is_empty() {
            self.damage.add(&self.set, news.marks, capacity, &mut touched);
        }
        classic.sort_unstable();
        if let Some(state) = &mut self.classic {
            for (_, example, weight) in classic {
                let weight = f32::from_bits(weight);
                state.apply(&self.set, example, weight, Blend { constant });
                state.note(touch.changes.epoch, example, weight);
                touch.example(example as usize);
            }
        }
        self.update_threshold();
    }

    /// The marks, sorted. Above the capacity, the weakest mark (least strength times depth) gives its energy, in metres
    /// squared, to the mark whose contact is nearest; ties go to the first in order.
    ///
    /// # Errors
    /// [`Error::WrongRule`] with a classic rule.
    pub fn marks(&mut self) -> Result<&[Mark], Error> {
        self.fold();
        self.only_marks("marks")?;
        Ok(self.damage.marks())
    }

    /// Replaces all marks, forgets hits that have not been folded yet, and ends all contacts.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] naming the mark and its value; [`Error::WrongRule`]. Nothing changes then.
    pub fn set_marks(&mut self, marks: &[Mark]) -> Result<(), Error> {
        self.only_marks("set_marks")?;
        let mut touch = Touch::new(&self.set, &mut self.changes, self.least);
        self.damage.replace(&self.set, marks, self.options.capacity as usize, &mut |d: &Dent| touch.dent(d))?;
        self.contacts.close_all();
        self.inbox.queue().clear();
        self.update_threshold();
        Ok(())
    }

    /// The damage as bytes, with a version and the set's fingerprint; the same bytes for the same damage everywhere.
    pub fn save(&mut self) -> Vec<u8> {
        self.fold();
        match &self.classic {
            Some(state) => state.save(&self.set),
            None => {
                let mut out = saved::header(&self.set, saved::MARKS, self.damage.marks().len());
                self.damage.marks().iter().for_each(|m| saved::write_mark(m, &mut out));
                out
            }
        }
    }

    /// Replaces the damage by saved bytes, forgets hits that have not been folded yet, and ends all contacts.
    ///
    /// # Errors
    /// [`Error::DamageMismatch`] for bytes of another version, set or rule, or cut short; [`Error::InvalidArgument`] for
    /// a mark that the set cannot have. Nothing changes then.
    pub fn load(&mut self, bytes: &[u8]) -> Result<(), Error> {
        if self.classic.is_some() {
            let mut state = State::load(&self.set, bytes)?;
            self.inbox.queue().clear();
            Touch::new(&self.set, &mut self.changes, 0.0).everything();
            state.replaced(self.changes.epoch);
            self.classic = Some(state);
            return Ok(());
        }
        let entries = saved::entries(&self.set, bytes, saved::MARKS, size_of::<Mark>())?;
        let marks: Vec<Mark> = entries.chunks_exact(size_of::<Mark>()).map(saved::read_mark).collect();
        self.set_marks(&marks)
    }

    /// Repairs: every dent keeps this share of its depth, 0 to 1. Ends all contacts.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`].
    pub fn repair(&mut self, keep: f32) -> Result<(), Error> {
        if !(0.0..=1.0).contains(&keep) {
            return Err(Error::invalid("keep", keep, "0 (as new) to 1 (nothing repaired)"));
        }
        self.fold();
        self.contacts.close_all();
        let mut touch = Touch::new(&self.set, &mut self.changes, self.least);
        self.damage.scale(&self.set, keep, &mut |d: &Dent| touch.dent(d));
        if let Some(state) = &mut self.classic {
            state.scale(&self.set, keep);
            state.replaced(touch.changes.epoch);
            touch.everything();
        }
        self.update_threshold();
        Ok(())
    }

    /// As new. Hits that have not been folded yet are forgotten too, and all contacts end.
    pub fn reset(&mut self) {
        self.contacts.close_all();
        self.inbox.queue().clear();
        let mut touch = Touch::new(&self.set, &mut self.changes, self.least);
        self.damage.clear(&mut |d: &Dent| touch.dent(d));
        if let Some(state) = &mut self.classic {
            state.scale(&self.set, 0.0);
            state.replaced(touch.changes.epoch);
            touch.everything();
        }
        self.update_threshold();
    }

    /// Takes over the damage of another instance of the same set and kind of rule.
    ///
    /// # Errors
    /// [`Error::DamageMismatch`] where the sets or the rules differ. Nothing changes then.
    pub fn copy_damage_from(&mut self, other: &mut Instance) -> Result<(), Error> {
        let bytes = other.save();
        self.load(&bytes)
    }

    /// Position of vertex `v` as deformed, m: what [`Instance::deform`] writes, without writing. Hits that have not been
    /// folded yet do not count.
    ///
    /// # Errors
    /// [`Error::IndexOutOfRange`].
    pub fn displaced(&self, v: u32) -> Result<Vec3, Error> {
        if v as usize >= self.set.vertex_count() {
            return Err(Error::IndexOutOfRange {
                name: "vertex".into(),
                index: v.into(),
                len: self.set.vertex_count() as u64,
            });
        }
        Ok(crate::deform::displaced(self, v as usize).0)
    }

    /// Memory held for this instance, bytes (without the shared set).
    pub fn memory_bytes(&self) -> usize {
        let state = self
            .classic
            .as_ref()
            .map_or(0, |_| self.set.vertex_count() * if self.set.mesh().normals().is_some() { 24 } else { 12 });
        size_of::<Self>()
            + state
            + self.changes.blocks.iter().map(|b| b.len() * 8).sum::<usize>()
            + self.damage.memory_bytes()
            + self.contacts.memory_bytes()
    }

    pub(crate) fn damage(&self) -> &Damage {
        &self.damage
    }

    /// What a classic rule blends by; 0 keeps the most displaced candidate.
    pub(crate) fn blend_constant(&self) -> f32 {
        if let Rule::Blend(k) = self.options.rule { k } else { 0.0 }
    }

    pub(crate) fn classic_state(&self) -> Option<&State> {
        self.classic.as_ref()
    }

    /// Displacements no longer than this, as scaled, are left out, m.
    pub(crate) fn least(&self) -> f32 {
        self.least
    }

    pub(crate) fn changes(&self) -> &Changes {
        &self.changes
    }

    fn only_marks(&self, call: &str) -> Result<(), Error> {
        if self.classic.is_none() { Ok(()) } else { Err(self.needs_marks(call)) }
    }

    pub(crate) fn needs_marks(&self, call: &str) -> Error {
        needs_marks(call, self.options.rule)
    }
}

fn needs_marks(call: &str, rule: Rule) -> Error {
    Error::WrongRule { call: call.into(), needed: "the rule Marks".into(), rule: rule.name().into() }
}

/// Notes blocks as changed, at an epoch of its own.
struct Touch<'a> {
    set: &'a ExampleSet,
    changes: &'a mut Changes,
    /// Displacements no longer than this do not show, m.
    least: f32,
}

impl<'a> Touch<'a> {
    fn new(set: &'a ExampleSet, changes: &'a mut Changes, least: f32) -> Self {
        changes.epoch += 1;
        Touch { set, changes, least }
    }

    fn dent(&mut self, d: &Dent) {
        for (skin, blocks) in self.set.skins().zip(&mut self.changes.blocks) {
            d.blocks(self.set, skin, self.least, |b| blocks[b] = self.changes.epoch);
        }
    }

    /// All that an anchored example moves.
    fn example(&mut self, example: usize) {
        for (skin, blocks) in self.set.skins().zip(&mut self.changes.blocks) {
            skin.anchored[example].blocks().for_each(|b| blocks[b as usize] = self.changes.epoch);
        }
    }

    fn everything(&mut self) {
        self.changes.blocks.iter_mut().for_each(|b| b.fill(self.changes.epoch));
    }
}
