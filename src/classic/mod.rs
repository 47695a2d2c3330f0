//! The classic rule, complete: sections 4.4 to 4.7 of the thesis "Example Based Soft-Body Simulation on Graphics
//! Processing Units". It needs per-vertex state, and its result depends on the order of impulses. Neither is true of
//! the default rule. It is kept for comparison.

use crate::base::error::{Error, reserve};
use crate::damage::saved;
use crate::deform::view::DisplacedVertices;
use crate::example::set::ExampleSet;
use crate::select::hit::Chosen;
use crate::select::target::HitTarget;
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// Figure 4.2. Selects the example with the best cosine similarity (Eq. 4.5) among those that move the contact. Its weight is the
/// length of the target over that of the example's displacement (Eq. 4.7), at most 1 if `clamp`. Also returns
/// the displacement of the contact by the example before weighting, m.
pub(crate) fn select_by_cosine(set: &ExampleSet, target: &HitTarget, clamp: bool) -> Option<(Chosen, Vec3)> {
    let mut best: Option<(f32, usize, Vec3)> = None;
    for (i, whole) in set.base_lod().anchored.iter().enumerate() {
        let d = whole.delta(target.contact);
        let length = d.length();
        if length > 0.0 {
            let cos = d.dot(target.direction) / length;
            if best.is_none_or(|b| cos > b.0) {
                best = Some((cos, i, d));
            }
        }
    }
    let (_, example, delta) = best?;
    let weight = target.size / delta.length();
    let weight = if clamp { weight.min(1.0) } else { weight };
    Some((Chosen { example: example as u32, weight }, delta))
}

/// The displaced vertices of one instance.
#[derive(Debug, Clone)]
pub(crate) struct ClassicState {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    /// The last hits, in order. A copy of the state elsewhere applies those that it lacks.
    journal: Vec<Applied>,
    /// The journal holds every change after this epoch.
    known_since: u64,
}

/// A hit that was applied.
#[derive(Debug, Clone, Copy)]
#[cfg_attr(not(feature = "gpu"), expect(dead_code, reason = "for who keeps the state elsewhere"))]
pub(crate) struct Applied {
    epoch: u64,
    pub example: u32,
    pub weight: f32,
}

/// Capacity of a journal. A copy of the state that is further behind is replaced as a whole.
const JOURNAL: usize = 256;

impl ClassicState {
    pub(crate) fn new(set: &ExampleSet) -> Result<Self, Error> {
        let mut positions = reserve(set.vertex_count(), "an instance's positions")?;
        positions.extend_from_slice(set.mesh().positions());
        let base = set.mesh().normals().unwrap_or(&[]);
        let mut normals = reserve(base.len(), "an instance's normals")?;
        normals.extend_from_slice(base);
        Ok(ClassicState { positions, normals, journal: Vec::new(), known_since: 0 })
    }

    pub(crate) fn memory_bytes(&self) -> usize {
        size_of_val(&self.positions[..]) + size_of_val(&self.normals[..]) + size_of_val(&self.journal[..])
    }

    pub(crate) fn vertices(&self) -> DisplacedVertices<'_> {
        DisplacedVertices { positions: &self.positions, normals: &self.normals }
    }

    /// Returns the hits applied after `epoch`. `None` if the journal does not reach back that far, or if something
    /// other than a hit changed the state since.
    #[cfg(feature = "gpu")]
    pub(crate) fn applied_since(&self, epoch: u64) -> Option<&[Applied]> {
        (epoch >= self.known_since).then(|| &self.journal[self.journal.partition_point(|a| a.epoch <= epoch)..])
    }

    /// Records that a hit was applied at `epoch`.
    pub(crate) fn note(&mut self, epoch: u64, example: u32, weight: f32) {
        if self.journal.len() == JOURNAL {
            self.known_since = self.journal[JOURNAL / 2].epoch;
            self.journal.retain(|a| a.epoch > self.known_since);
        }
        self.journal.push(Applied { epoch, example, weight });
    }

    /// Records that something other than a hit changed the state at `epoch`.
    pub(crate) fn replaced(&mut self, epoch: u64) {
        self.known_since = epoch;
        self.journal.clear();
    }

    /// Applies Figure 4.3 to every vertex that `example` moves. Blends by `constant` where a vertex is already displaced further
    /// (lines 5 to 9); 0 keeps the most displaced candidate. Drops a candidate that is not finite (after many unclamped weights
    /// far above 2).
    pub(crate) fn apply(&mut self, set: &ExampleSet, example: u32, weight: f32, constant: f32) {
        let base = set.mesh().positions();
        let lerp = |a: Vec3, b: Vec3, w: f32| a + (b - a) * w;
        for (v, displacement, turn) in set.base_lod().anchored[example as usize].iter() {
            let v = v as usize;
            let current = self.positions[v];
            let result = lerp(current, base[v] + displacement, weight);
            if !result.is_finite() {
                continue;
            }
            let further = (result - base[v]).length_squared() >= (current - base[v]).length_squared();
            // Vertices around the dent only change their normal: the paper's example does not contain them.
            if displacement != Vec3::ZERO {
                self.positions[v] = if further { result } else { lerp(current, result, constant) };
            }
            if let (Some(normal), Some(base)) = (self.normals.get_mut(v), set.mesh().normals()) {
                let result = lerp(*normal, base[v] + turn, weight);
                if result.is_finite() {
                    *normal = if further { result } else { lerp(*normal, result, constant) };
                }
            }
        }
    }

    /// Scales the displacement of every vertex by `keep`.
    pub(crate) fn scale(&mut self, set: &ExampleSet, keep: f32) {
        for (p, b) in self.positions.iter_mut().zip(set.mesh().positions()) {
            *p = *b + (*p - *b) * keep;
        }
        if let Some(base) = set.mesh().normals() {
            for (n, b) in self.normals.iter_mut().zip(base) {
                *n = *b + (*n - *b) * keep;
            }
        }
    }

    /// Saves the changed vertices.
    pub(crate) fn save(&self, set: &ExampleSet) -> Vec<u8> {
        let mesh = set.mesh();
        let changed = |v: &usize| {
            self.positions[*v] != mesh.positions()[*v] || mesh.normals().is_some_and(|n| n[*v] != self.normals[*v])
        };
        let entry = |v: usize| SavedVertex {
            vertex: v as u32,
            position: self.positions[v].to_array(),
            normal: self.normals.get(v).map_or([0.0; 3], Vec3::to_array),
        };
        let entries: Vec<SavedVertex> = (0..self.positions.len()).filter(changed).map(entry).collect();
        saved::write(set, saved::CLASSIC, &entries)
    }

    /// Reads the state that [`ClassicState::save`] wrote.
    pub(crate) fn load(set: &ExampleSet, bytes: &[u8]) -> Result<Self, Error> {
        let mut state = ClassicState::new(set)?;
        for (at, entry) in saved::read::<SavedVertex>(set, saved::CLASSIC, bytes)?.into_iter().enumerate() {
            let v = entry.vertex as usize;
            let (p, n) = (Vec3::from(entry.position), Vec3::from(entry.normal));
            if v >= state.positions.len() || !p.is_finite() || !n.is_finite() {
                let last = set.vertex_count() - 1;
                let what = format!("entry {at}: vertex {v} at {p}; vertices go to {last}, numbers must be finite");
                return Err(Error::DamageMismatch { what });
            }
            state.positions[v] = p;
            if let Some(slot) = state.normals.get_mut(v) {
                *slot = n;
            }
        }
        Ok(state)
    }
}

/// A vertex of saved damage.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct SavedVertex {
    vertex: u32,
    /// m.
    position: [f32; 3],
    /// Zero if the mesh has none.
    normal: [f32; 3],
}
