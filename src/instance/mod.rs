//! One dented copy of a mesh: its inbox of hits, its damage, and the epoch of each block's last change.

pub(crate) mod archive;
pub(crate) mod attach;
mod contacts;
pub(crate) mod deform;
mod growth;
pub(crate) mod inbox;
pub(crate) mod mapped;
pub(crate) mod parts;
#[cfg(test)]
pub(crate) mod schedules;
mod selection;

use crate::base::error::{Error, at_least_zero, positive, reserve};
use crate::classic::ClassicState;
use crate::damage::changes::Changes;
use crate::damage::list::Damage;
use crate::damage::mark::Mark;
use crate::damage::saved;
use crate::deform::nodes::NodeState;
use crate::example::mesh_lod::MeshLod;
use crate::example::set::ExampleSet;
use crate::mesh::finite;
use crate::select::hit::{Hit, Outcome};
use crate::select::options::{InstanceOptions, Rule, check_limit};
use crate::select::target::HitParams;
use contacts::Contacts;
use glam::{DMat3, DVec3, Mat4};
use growth::Growth;
use inbox::{Inbox, Pending};
use std::num::NonZeroU64;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

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
/// assert!((positions[0][2] + 0.05).abs() < 1e-5);
/// # Ok::<(), crumple::Error>(())
/// ```
#[derive(Debug)]
pub struct Instance {
    set: Arc<ExampleSet>,
    options: InstanceOptions,
    inbox: Arc<Inbox>,
    /// The damage shown: settled marks and those of open contacts.
    damage: Damage,
    contacts: Contacts,
    growth: Growth,
    parts: PartState,
    shape: ShapeState,
    limit: f32,
    /// Errors of this length are not seen, m; 0 until the view is known.
    unseen: f32,
    changes: Changes,
}

/// What the instance's rule keeps of its shape.
#[derive(Debug)]
enum ShapeState {
    /// The displacements of the set's nodes, which follow from the damage.
    Nodes(NodeState),
    Classic(ClassicState),
}

/// What an instance knows of the parts of its body. Bit `n` stands for the set's mesh `n`.
#[derive(Debug, Clone, Copy, Default)]
struct PartState {
    /// The part that this instance is; 0: the whole body.
    of: usize,
    /// Parts that are not on the body.
    released: u64,
    /// Parts that hits do not dent.
    rigid: u64,
}

/// The nodes of an undamaged instance.
fn new_nodes(set: &ExampleSet, options: &InstanceOptions) -> NodeState {
    // Marks, those of open contacts, and dents that go back.
    let dents = options.capacity + (Contacts::MAX + Growth::MAX) as u32;
    NodeState::new(set.nodes().lod.vertex_count(), set.depth_limit(), dents)
}

/// How many times as long as errors that are not seen the edges of a level of detail may be. Measured in the lab's scene (docs/lab, "A
/// scene"): there, for up to two pixels, the dents of 99 in 100 pixels are wrong by less than a fifth of that.
const EDGES: f32 = 16.0;

impl Instance {
    /// The most contacts that are open at a time (see [`Inbox::submit`]).
    pub const MAX_CONTACTS: usize = Contacts::MAX;

    /// Makes an undamaged copy.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] naming the option; for a classic rule [`Error::OutOfMemory`] for its state of every vertex, and
    /// [`Error::Unsupported`] if the set does not hold its [examples whole](crate::SetOptions::whole_examples).
    pub fn new(set: Arc<ExampleSet>, options: InstanceOptions) -> Result<Self, Error> {
        static NEXT: AtomicU64 = AtomicU64::new(1);
        options.check()?;
        let diagonal = set.mesh().bounds().diagonal();
        let limit = options.depth_limit.unwrap_or(set.depth_limit());
        let params = HitParams {
            options,
            depth_limit: limit,
            max_distance: options.max_contact_distance.unwrap_or(diagonal.max(limit)),
            world_to_local: DMat3::IDENTITY,
            local_origin_in_world: DVec3::ZERO,
            landing: None,
        };
        let shape = match options.rule {
            Rule::Marks => ShapeState::Nodes(new_nodes(&set, &options)),
            Rule::MostDisplaced | Rule::Blend(_) if set.has_whole_examples() => {
                ShapeState::Classic(ClassicState::new(&set)?)
            }
            Rule::MostDisplaced | Rule::Blend(_) => {
                let what = "a classic rule with a set baked without whole examples; bake it with whole_examples (--whole-examples)";
                return Err(Error::Unsupported { what: what.into() });
            }
        };
        let blocks = set.lods().map(|s| vec![0; s.blocks()]).collect();
        Ok(Self {
            inbox: Arc::new(Inbox::new(set.clone(), params)),
            set,
            options,
            damage: Damage::default(),
            contacts: Contacts::default(),
            growth: Growth::new(options.grow_time),
            parts: PartState::default(),
            shape,
            limit,
            unseen: 0.0,
            changes: Changes { instance: NEXT.fetch_add(1, Ordering::Relaxed), epoch: 0, blocks },
        })
    }

    /// Returns the set that it is a copy of.
    pub fn example_set(&self) -> &Arc<ExampleSet> {
        &self.set
    }

    /// Returns the options it was made with.
    pub fn options(&self) -> &InstanceOptions {
        &self.options
    }

    /// Returns the inbox of its hits, which threads may share.
    pub fn inbox(&self) -> &Arc<Inbox> {
        &self.inbox
    }

    /// Calls [`Inbox::submit`].
    ///
    /// # Errors
    /// Those of [`Inbox::submit`].
    pub fn submit(&self, hit: &Hit) -> Result<Outcome, Error> {
        self.inbox.submit(hit)
    }

    /// Calls [`Inbox::end_contact`].
    ///
    /// # Errors
    /// Those of [`Inbox::end_contact`].
    pub fn end_contact(&self, id: NonZeroU64) -> Result<(), Error> {
        self.inbox.end_contact(id)
    }

    /// Returns the number of open contacts, after folding the hits that have arrived.
    pub fn contact_count(&mut self) -> usize {
        self.fold();
        self.contacts.len()
    }

    /// Calls [`Inbox::preview`].
    ///
    /// # Errors
    /// Those of [`Inbox::submit`].
    pub fn preview(&self, hit: &Hit) -> Result<Outcome, Error> {
        self.inbox.preview(hit)
    }

    /// Returns the outcome of a contact, all its hits taken as one, after folding the hits that have arrived. The
    /// contact is open, or among the [`Instance::MAX_CONTACTS`] that ended last. `None` if its sum is too weak to leave
    /// a mark.
    ///
    /// # Errors
    /// [`Error::UnknownContact`] for another id; [`Error::WrongRule`] with a classic rule.
    pub fn contact(&mut self, id: NonZeroU64) -> Result<Option<Outcome>, Error> {
        self.only_marks("contact")?;
        self.fold();
        self.contacts.outcome(id).ok_or(Error::UnknownContact { id: id.get() })
    }

    /// Calls [`Inbox::set_transform`].
    ///
    /// # Errors
    /// Those of [`Inbox::set_transform`].
    pub fn set_transform(&self, local_to_world: Mat4) -> Result<(), Error> {
        self.inbox.set_transform(local_to_world)
    }

    /// Returns the depth limit in use, m.
    pub fn depth_limit(&self) -> f32 {
        self.limit
    }

    /// Sets the depth limit, m; `None` restores the set's. Marks do not change. Vertices follow at the next deform.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`].
    pub fn set_depth_limit(&mut self, limit: Option<f32>) -> Result<(), Error> {
        check_limit(limit)?;
        self.limit = limit.unwrap_or(self.set.depth_limit());
        self.inbox.params_mut().depth_limit = self.limit;
        self.show();
        Ok(())
    }

    /// Chooses how finely to show the instance where errors of `pixels` pixels do not matter, and returns the level of
    /// detail to show: the coarsest whose edges cover at most 16 times as many pixels in the mean. Under a
    /// [budget](crate::deform_within) near instances wait less than distant ones. `distance` (m, in the mesh's space) is that of the
    /// instance's nearest point to the camera; `fov_y` (radians) and `viewport_height` (pixels) are the camera's. It is cheap; call it
    /// every frame.
    ///
    /// Not for sets whose further meshes are parts of the body.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] naming the value.
    pub fn set_view(&mut self, pixels: f32, distance: f32, fov_y: f32, viewport_height: f32) -> Result<usize, Error> {
        at_least_zero("pixels", pixels, "pixels")?;
        at_least_zero("distance", distance, "m")?;
        if !(fov_y > 0.0 && fov_y < std::f32::consts::PI) {
            return Err(Error::invalid("fov_y", fov_y, "between 0 and pi radians"));
        }
        if !(viewport_height > 0.0 && viewport_height.is_finite()) {
            return Err(Error::invalid("viewport_height", viewport_height, "above 0 pixels"));
        }
        let a_pixel = distance * 2.0 * libm::tanf(fov_y * 0.5) / viewport_height;
        self.unseen = (pixels * a_pixel).min(1e9);
        if self.classic_state().is_some() {
            return Ok(0);
        }
        let fits = |(_, lod): &(usize, &MeshLod)| lod.edge() <= EDGES * self.unseen;
        Ok(self.set.lods().enumerate().skip(1).filter(fits).last().map_or(0, |(l, _)| l))
    }

    /// Moves the nodes to where the damage puts them now, and marks the blocks that follow them.
    fn show(&mut self) {
        if let ShapeState::Nodes(nodes) = &mut self.shape {
            let (changes, set) = (&mut self.changes, &self.set);
            changes.epoch += 1;
            nodes.show(self.growth.shown(&self.damage), self.limit, |group, moved| changes.nodes(set, group, moved));
        }
    }

    /// Turns the hits that have arrived into damage. The result does not depend on the order or the threads in which
    /// they were submitted. Methods that take `&mut self` and read the damage do this first.
    pub fn fold(&mut self) {
        let pending = self.inbox.queue().take(&self.contacts);
        if pending.is_empty() {
            return;
        }
        let constant = self.blend_constant();
        let (mut marks, mut classic, mut events) = (Vec::new(), Vec::new(), Vec::new());
        for p in pending {
            match p {
                Pending::Mark(m) => marks.push(m),
                Pending::Classic(contact, example, weight) => classic.push((contact, example, weight)),
                Pending::Contact(event) => events.push(event),
            }
        }
        if let ShapeState::Classic(state) = &mut self.shape {
            classic.sort_unstable();
            self.changes.epoch += 1;
            for (_, example, weight) in classic {
                let weight = f32::from_bits(weight);
                state.apply(&self.set, example, weight, constant);
                state.note(self.changes.epoch, example, weight);
                self.changes.example(&self.set, example as usize);
            }
            return;
        }
        let capacity = self.options.capacity as usize;
        self.change(|instance| {
            let (set, damage) = (&instance.set, &mut instance.damage);
            if instance.contacts.len() > 0 || !events.is_empty() {
                instance.contacts.fold(set, &instance.inbox.params(), capacity, (marks, events), damage);
            } else {
                damage.add(set, marks, capacity);
            }
        });
    }

    /// Changes the damage. Dents go from where they are shown to where it puts them.
    fn change(&mut self, change: impl FnOnce(&mut Self)) {
        let before = self.growth.is_on().then(|| self.damage.clone());
        change(self);
        if let Some(before) = before {
            self.growth.begin(&self.set, before, &self.damage);
        }
        self.show();
    }

    /// Returns the marks, sorted. Beyond the capacity, the mark with the least depth (of all its hits) gives its energy
    /// to the mark with the nearest contact; among equals to the first in order.
    ///
    /// # Errors
    /// [`Error::WrongRule`] with a classic rule.
    pub fn marks(&mut self) -> Result<&[Mark], Error> {
        self.fold();
        self.only_marks("marks")?;
        Ok(self.damage.marks())
    }

    /// Replaces all marks. Discards hits that have not been folded yet, and ends all contacts.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] naming the mark and its value; [`Error::WrongRule`]. After an error nothing has
    /// changed.
    pub fn set_marks(&mut self, marks: &[Mark]) -> Result<(), Error> {
        self.only_marks("set_marks")?;
        Mark::check_all(marks, &self.set)?;
        let mut copy = reserve(marks.len(), "marks")?;
        copy.extend_from_slice(marks);
        self.become_saved(Saved::Marks(copy));
        Ok(())
    }

    /// Returns a number for the marks, after folding the hits that have arrived. Equal marks have equal revisions, on
    /// every machine and whatever led to them; other marks have others, up to an accident of 1 in 2^64. 0 without marks
    /// and with a classic rule.
    pub fn revision(&mut self) -> u64 {
        self.fold();
        self.damage.revision()
    }

    /// Returns the damage as bytes, with a version, the set's fingerprint and a checksum. The same damage gives the same bytes on
    /// every platform.
    pub fn save(&mut self) -> Vec<u8> {
        self.fold();
        match &self.shape {
            ShapeState::Classic(state) => state.save(&self.set),
            ShapeState::Nodes(_) => saved::of_marks(&self.set, self.damage.marks()),
        }
    }

    /// Replaces the damage by saved bytes. Discards hits that have not been folded yet, and ends all contacts.
    ///
    /// # Errors
    /// [`Error::DamageMismatch`] for bytes that were changed, are cut short or belong to another version, set or rule;
    /// [`Error::InvalidArgument`] for a mark that the set cannot have. After an error nothing has changed.
    pub fn load(&mut self, bytes: &[u8]) -> Result<(), Error> {
        let saved = self.read(bytes)?;
        self.become_saved(saved);
        Ok(())
    }

    /// Reads the bytes of [`Instance::save`].
    pub(crate) fn read(&self, bytes: &[u8]) -> Result<Saved, Error> {
        if self.classic_state().is_some() {
            return Ok(Saved::Classic(ClassicState::load(&self.set, bytes)?));
        }
        Ok(Saved::Marks(saved::marks(&self.set, bytes)?))
    }

    /// Replaces the damage. Discards hits that have not been folded yet, and ends all contacts.
    pub(crate) fn become_saved(&mut self, saved: Saved) {
        self.contacts.close_all();
        self.inbox.queue().pending.clear();
        self.growth.finish();
        match saved {
            Saved::Marks(marks) => self.damage.replace(&self.set, marks, self.options.capacity as usize),
            Saved::Classic(state) => {
                self.shape = ShapeState::Classic(state);
                self.replace_classic(|_, _| ());
            }
        }
        self.show();
    }

    /// Changes a classic rule's state otherwise than by a hit, and marks everything as changed.
    fn replace_classic(&mut self, change: impl FnOnce(&mut ClassicState, &ExampleSet)) {
        if let ShapeState::Classic(state) = &mut self.shape {
            change(state, &self.set);
            self.changes.everything();
            state.replaced(self.changes.epoch);
        }
    }

    /// Repairs: scales the depth of every dent by `keep`, 0 to 1. Dents of several hits also get narrower. Ends all
    /// contacts.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`].
    pub fn repair(&mut self, keep: f32) -> Result<(), Error> {
        check_keep(keep)?;
        self.scale(|_| keep.into());
        self.replace_classic(|state, set| state.scale(set, keep));
        Ok(())
    }

    /// Repairs around a point, as with a hammer: scales the depth of the dents whose contact is nearer than `radius` (m)
    /// to `point` (m, in the mesh's space). A dent at the point keeps `keep` of its depth, 0 to 1. Dents further away
    /// keep more, by the factor `(1 - (distance / radius)^2)^2` of what the one at the point loses. Ends all contacts.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`], [`Error::NotFinite`]; [`Error::WrongRule`] with a classic rule.
    pub fn repair_around(&mut self, point: [f32; 3], radius: f32, keep: f32) -> Result<(), Error> {
        self.only_marks("repair_around")?;
        let point = finite(point, || "point".into())?.as_dvec3();
        positive("radius", radius, "m")?;
        check_keep(keep)?;
        let set = self.set.clone();
        self.scale(|mark| {
            let contact = set.mesh().positions()[mark.contact as usize].as_dvec3();
            let inside = 1.0 - (contact - point).length_squared() / (f64::from(radius) * f64::from(radius));
            if inside > 0.0 { 1.0 - (1.0 - f64::from(keep)) * inside * inside } else { 1.0 }
        });
        Ok(())
    }

    /// Scales the depth that each mark's dent has alone. Ends all contacts.
    fn scale(&mut self, keep: impl Fn(&Mark) -> f64) {
        self.fold();
        self.contacts.close_all();
        self.change(|instance| instance.damage.scale(&instance.set, keep));
    }

    /// Sets the time, s, for the options' [`grow_time`](InstanceOptions::grow_time). A dent that appears, changes or is
    /// repaired goes evenly from where it was at the last time given before the fold, to where its mark puts it. Dents
    /// that are read, saved and sent are complete at once; vertices and attached points follow the time. Costs nothing
    /// if no dent grows. Replaced and reset damage is shown at once.
    ///
    /// # Errors
    /// [`Error::NotFinite`].
    pub fn set_time(&mut self, time: f64) -> Result<(), Error> {
        if !time.is_finite() {
            return Err(Error::NotFinite { name: "time".into(), value: time.to_string() });
        }
        if self.growth.time() != time {
            self.growth.advance(&self.set, &self.damage, time);
            self.show();
        }
        Ok(())
    }

    /// Removes all damage. Discards hits that have not been folded yet, and ends all contacts.
    pub fn reset(&mut self) {
        self.become_saved(Saved::Marks(Vec::new()));
        self.replace_classic(|state, set| state.scale(set, 0.0));
    }

    /// Copies the damage of another instance with the same set and the same kind of rule.
    ///
    /// # Errors
    /// [`Error::DamageMismatch`] if the sets or the rules differ. After an error nothing has changed.
    pub fn copy_damage_from(&mut self, other: &mut Instance) -> Result<(), Error> {
        let bytes = other.save();
        self.load(&bytes)
    }

    /// Returns the memory held for this instance, without the shared set, bytes.
    pub fn memory_bytes(&self) -> usize {
        let shape = match &self.shape {
            ShapeState::Nodes(nodes) => nodes.memory_bytes(),
            ShapeState::Classic(state) => state.memory_bytes(),
        };
        size_of::<Self>()
            + shape
            + self.changes.blocks.iter().map(|b| b.len() * 8).sum::<usize>()
            + self.damage.memory_bytes()
            + self.contacts.memory_bytes()
            + self.growth.memory_bytes()
    }

    /// The blend constant of a classic rule; 0 keeps the most displaced candidate.
    pub(crate) fn blend_constant(&self) -> f32 {
        if let Rule::Blend(k) = self.options.rule { k } else { 0.0 }
    }

    pub(crate) fn classic_state(&self) -> Option<&ClassicState> {
        if let ShapeState::Classic(state) = &self.shape { Some(state) } else { None }
    }

    /// Fails if the instance has a classic rule. `call` is what needs marks.
    pub(crate) fn only_marks(&self, call: &str) -> Result<(), Error> {
        self.options.rule.only_marks(call)
    }
}

fn check_keep(keep: f32) -> Result<(), Error> {
    let right = (0.0..=1.0).contains(&keep);
    if right { Ok(()) } else { Err(Error::invalid("keep", keep, "0 (as new) to 1 (nothing repaired)")) }
}

/// Damage that was read and checked.
pub(crate) enum Saved {
    Marks(Vec<Mark>),
    Classic(ClassicState),
}
