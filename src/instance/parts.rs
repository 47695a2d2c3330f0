//! Bodies of several parts. The base mesh of the set is the whole body, and each part is another mesh of the set
//! ([`ExampleSet::add_lod`]), so that parts have buffers of their own and seams between them stay closed. An instance is
//! a body with all parts. A part that comes off gets an instance of its own with the same damage.
//!
//! A base vertex is in a part if a vertex of the part's mesh lies at its position. It is the part's own if the base mesh
//! has no further vertices there, as it has on a seam between parts. Hits land on vertices that are not the own ones of
//! what is off, taken together.

use super::inbox::Inbox;
use super::{Instance, PartState};
use crate::base::error::Error;
use crate::damage::energy::depth_of_one;
use crate::damage::mark::Mark;
use crate::deform::evaluate::{BlockJob, Scratch, block};
use crate::deform::view::Shape;
use crate::example::set::ExampleSet;
use crate::mesh::vertex_blocks::{BLOCK, block_range};
use crate::select::options::{InstanceOptions, Rule};
use crate::select::target::Landing;
use glam::Vec3;
use std::collections::HashMap;
use std::sync::{Arc, Weak};

/// How far the vertices of a part have moved.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PartDamage {
    /// Distance of the vertex that moved furthest, m.
    pub deepest: f32,
    /// Mean distance over all vertices, m.
    pub mean: f32,
    /// Depth of one hit that has the energy of all marks whose contact is on the mesh, m. It grows with every hit, also
    /// where hits lie far apart. A repair takes energy away. 0 with a classic rule.
    pub energy: f32,
}

impl Instance {
    /// Takes a part off the body: mesh `part` of the set, which is not 0. Returns an instance of its own with the same
    /// set, options, transform and damage. Hits on it land only on the part, and hits on this one land only on what is
    /// left. It may have the base mesh's vertices of the part, so write only the part's mesh from it, and no longer from
    /// this one. Hits that other threads report meanwhile wait.
    ///
    /// # Errors
    /// [`Error::IndexOutOfRange`]; [`Error::InvalidArgument`] for 0, a part that is off already, a mesh that has no
    /// vertex of its own in common with the base mesh, or the last part; [`Error::WrongRule`] with a classic rule. After
    /// an error nothing has changed.
    pub fn release(&mut self, part: usize) -> Result<Instance, Error> {
        let known = self.part(part, "release")?;
        if self.parts.released & 1 << part != 0 {
            return Err(Error::invalid("part", part, "a part that is on the body; this one is off"));
        }
        let parts = PartState { released: self.parts.released | 1 << part, ..self.parts };
        let landing = self.landing(&parts)?;
        let alone = known.landing(&self.set, part)?;
        let options = InstanceOptions { depth_limit: Some(self.limit), ..self.options };
        let mut released = Instance::new(self.set.clone(), options)?;
        let inbox = self.inbox.clone();
        let mut followers = inbox.followers_mut();
        let bytes = self.save();
        released.load(&bytes)?;
        released.set_time(self.growth.time())?;
        released.unseen = self.unseen;
        released.parts.of = part;
        let own = self.inbox.params();
        let mut params = released.inbox.params_mut();
        (params.world_to_local, params.local_origin_in_world) = (own.world_to_local, own.local_origin_in_world);
        params.landing = Some(alone);
        drop(params);
        self.parts = parts;
        self.set_landing(landing, &mut followers);
        Ok(released)
    }

    /// Puts a part on the body again. It keeps its own damage. Hits on the body, and ends of their contacts, now also
    /// reach the part, as long as both exist. Other changes of the body's damage do not: repair and load both.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for an instance that is not a part of this body's set, or not one that is off. After an
    /// error nothing has changed.
    pub fn mount(&mut self, part: &mut Instance) -> Result<(), Error> {
        let of = self.checked_part(part, true)?;
        let parts = PartState { released: self.parts.released & !(1 << of), ..self.parts };
        let landing = self.landing(&parts)?;
        let inbox = self.inbox.clone();
        let mut followers = inbox.followers_mut();
        self.fold();
        part.fold();
        self.parts = parts;
        followers.push(Arc::downgrade(&part.inbox));
        self.set_landing(landing, &mut followers);
        Ok(())
    }

    /// Takes a part off the body that was put on it again.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for an instance that is not such a part. After an error nothing has changed.
    pub fn unmount(&mut self, part: &mut Instance) -> Result<(), Error> {
        let of = self.checked_part(part, false)?;
        let own = part.inbox.clone();
        let is_part = |inbox: &Weak<_>| std::ptr::eq(inbox.as_ptr(), Arc::as_ptr(&own));
        if !self.inbox.followers().iter().any(is_part) {
            return Err(Error::invalid("part", of, "a part that was mounted on this body"));
        }
        let parts = PartState { released: self.parts.released | 1 << of, ..self.parts };
        let landing = self.landing(&parts)?;
        let alone = self.part(of, "unmount")?.landing(&self.set, of)?;
        let inbox = self.inbox.clone();
        let mut followers = inbox.followers_mut();
        self.fold();
        part.fold();
        followers.retain(|inbox| !is_part(inbox));
        part.inbox.params_mut().landing = Some(alone);
        self.parts = parts;
        self.set_landing(landing, &mut followers);
        Ok(())
    }

    /// Makes a part rigid, such as glass, or no longer: hits whose contact is a vertex of its own leave no mark, and
    /// their status is [`Rigid`](crate::HitStatus::Rigid). Dents of other parts still show on its mesh; do not write that
    /// mesh if it should not move at all.
    ///
    /// # Errors
    /// [`Error::IndexOutOfRange`]; [`Error::InvalidArgument`] for 0, or a mesh that has no vertex of its own in common
    /// with the base mesh; [`Error::WrongRule`] with a classic rule.
    pub fn set_rigid(&mut self, part: usize, rigid: bool) -> Result<(), Error> {
        self.part(part, "set_rigid")?;
        let all = self.parts.rigid & !(1 << part) | u64::from(rigid) << part;
        let parts = PartState { rigid: all, ..self.parts };
        let landing = self.landing(&parts)?;
        self.parts = parts;
        self.set_landing(landing, &mut self.inbox.followers_mut());
        Ok(())
    }

    /// Measures how far the vertices of a mesh of the set have moved, and what hit it, after folding the hits that have
    /// arrived. Dents count in full while they grow. So the same damage gives the same
    /// numbers on every platform. Takes about as long as a deform of the whole mesh.
    ///
    /// # Errors
    /// [`Error::IndexOutOfRange`]; [`Error::WrongRule`] for a mesh other than 0 with a classic rule.
    pub fn measure(&mut self, lod: usize) -> Result<PartDamage, Error> {
        self.fold();
        let mesh = self.set.lod(lod)?;
        if lod > 0 {
            self.only_marks("measure of another mesh than 0")?;
        }
        // Where dents grow, what is shown is not the damage.
        let complete = self.growth.is_growing().then(|| {
            let mut nodes = super::new_nodes(&self.set, &self.options);
            nodes.show(&self.damage, self.limit, |_, _| ());
            nodes
        });
        let mut view = self.view();
        if let Some(nodes) = &complete {
            view.shape = Shape::Nodes(nodes.view());
        }
        let (mut scratch, mut positions) = (Scratch::new(), [0.0; 3 * BLOCK]);
        let (mut deepest, mut sum) = (0.0f64, 0.0f64);
        let marks = self.damage.marks();
        let contact = |mark: &Mark| self.set.mesh().positions()[mark.contact as usize];
        let mut is_on_mesh = vec![false; marks.len()];
        for (at, bounds) in mesh.mesh.block_bounds().iter().enumerate() {
            let range = block_range(at, mesh.vertex_count());
            let at_rest = &mesh.mesh.positions()[range.clone()];
            for (mark, is_on_mesh) in marks.iter().zip(&mut is_on_mesh) {
                let near = bounds.distance_squared(contact(mark)) <= 0.0;
                *is_on_mesh |= near && at_rest.contains(&contact(mark));
            }
            block(BlockJob { view: &view, lod: mesh, block: at }, &mut scratch, &mut positions, None);
            for (base, now) in at_rest.iter().zip(positions.chunks_exact(3)) {
                let moved = (Vec3::from_slice(now).as_dvec3() - base.as_dvec3()).length();
                deepest = deepest.max(moved);
                sum += moved;
            }
        }
        let on_mesh = marks.iter().zip(is_on_mesh).filter_map(|(mark, is_on_mesh)| is_on_mesh.then_some(mark));
        Ok(PartDamage {
            deepest: deepest as f32,
            mean: (sum / mesh.vertex_count().max(1) as f64) as f32,
            energy: depth_of_one(on_mesh),
        })
    }

    /// Checks the number of a part and finds its vertices.
    fn part(&self, part: usize, call: &str) -> Result<Known, Error> {
        self.only_marks(call)?;
        if part == 0 || self.parts.of != 0 {
            let expected = "1 or more, a part of a whole body; 0 is the base mesh, and a part has no parts";
            return Err(Error::invalid("part", part, expected));
        }
        self.set.lod_mesh(part)?;
        let known = Known::new(&self.set, 1 << part)?;
        if known.is_own.contains(&true) { Ok(known) } else { Err(nothing_in_common(part)) }
    }

    /// The number of a part of this body that is off it, or not.
    fn checked_part(&self, part: &Instance, off: bool) -> Result<usize, Error> {
        let of = part.parts.of;
        let fits =
            of != 0 && self.parts.of == 0 && Arc::ptr_eq(&self.set, &part.set) && self.options.rule == Rule::Marks;
        if fits && (self.parts.released & 1 << of != 0) == off {
            return Ok(of);
        }
        let expected =
            if off { "a part of this body's set that is off the body" } else { "a part that is on this body" };
        Err(Error::invalid("part", of, expected))
    }

    /// Where hits on the body land. `None`: everywhere.
    fn landing(&self, parts: &PartState) -> Result<Option<Arc<Landing>>, Error> {
        if parts.released | parts.rigid == 0 {
            return Ok(None);
        }
        let off = Known::new(&self.set, parts.released)?.is_own;
        let rigid = Known::new(&self.set, parts.rigid)?.is_own;
        let landing = Landing::new(&self.set, |v| !off[v], |v| rigid[v]);
        let landing = landing.ok_or_else(|| Error::invalid("part", "the last one", "one of several on the body"))?;
        Ok(Some(Arc::new(landing)))
    }

    /// Sets where hits on the body and on what is mounted on it land.
    fn set_landing(&self, landing: Option<Arc<Landing>>, followers: &mut Vec<Weak<Inbox>>) {
        followers.retain(|inbox| inbox.upgrade().is_some());
        for inbox in followers.iter().filter_map(Weak::upgrade) {
            inbox.params_mut().landing.clone_from(&landing);
        }
        self.inbox.params_mut().landing = landing;
    }
}

/// The base vertices that lie at positions of some parts.
struct Known {
    is_in: Vec<bool>,
    /// The base mesh has no further vertices there than these parts.
    is_own: Vec<bool>,
}

impl Known {
    /// `parts` has a bit for each part.
    fn new(set: &ExampleSet, parts: u64) -> Result<Self, Error> {
        // -0 and 0 are one position.
        let key = |p: &Vec3| p.to_array().map(|x| (x + 0.0).to_bits());
        let mut there: HashMap<[u32; 3], (u32, u32)> = HashMap::new();
        for part in (1..64).filter(|part| parts & 1 << part != 0) {
            for p in set.lod_mesh(part)?.positions() {
                there.entry(key(p)).or_default().0 += 1;
            }
        }
        let base = set.mesh().positions();
        for p in base {
            if let Some((_, in_base)) = there.get_mut(&key(p)) {
                *in_base += 1;
            }
        }
        let of = |p: &Vec3| there.get(&key(p)).copied();
        Ok(Known {
            is_in: base.iter().map(|p| of(p).is_some()).collect(),
            is_own: base.iter().map(|p| of(p).is_some_and(|(in_parts, in_base)| in_base <= in_parts)).collect(),
        })
    }

    /// Where hits on the part alone land.
    fn landing(&self, set: &ExampleSet, part: usize) -> Result<Arc<Landing>, Error> {
        let landing = Landing::new(set, |v| self.is_in[v], |_| false);
        landing.map(Arc::new).ok_or_else(|| nothing_in_common(part))
    }
}

fn nothing_in_common(part: usize) -> Error {
    let expected = "a mesh of the set with vertices at positions of base vertices that no other part has";
    Error::invalid("part", part, expected)
}
