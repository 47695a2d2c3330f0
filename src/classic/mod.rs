//! The classic rule, complete: sections 4.4 to 4.7 of the thesis "Example Based Soft-Body Simulation on Graphics
//! Processing Units". It needs per-vertex state, and its result depends on the order of impulses. Neither is true of
//! the default rule. It is kept for comparison.

pub(crate) mod select;

use crate::base::error::{Error, reserve};
use crate::damage::saved;
use crate::deform::view::DisplacedVertices;
use crate::example::blocks::DeltaBlocks;
use crate::example::set::ExampleSet;
use glam::Vec3;

/// What a classic instance does with a vertex that is already displaced further (Figure 4.3, lines 5 to 9).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Blend {
    /// The "fine constant" of line 8; 0 keeps the most displaced candidate.
    pub constant: f32,
}

/// An example as the paper stores it: an index and three floats per moved vertex.
#[derive(Debug, Clone)]
pub(crate) struct Sparse {
    entries: Vec<SparseEntry>,
    /// Change of normal of each entry; empty if the mesh has no normals.
    normals: Vec<Vec3>,
}

#[repr(C)]
#[derive(Debug, Clone, Copy)]
struct SparseEntry {
    vertex: u32,
    /// m.
    displacement: Vec3,
}

impl Sparse {
    pub(crate) fn new(example: &DeltaBlocks, normals: bool) -> Self {
        let moved = || example.iter().filter(move |(_, d, _)| normals || *d != Vec3::ZERO);
        Sparse {
            entries: moved().map(|(vertex, displacement, _)| SparseEntry { vertex, displacement }).collect(),
            normals: if normals { moved().map(|(_, _, n)| n).collect() } else { Vec::new() },
        }
    }

    fn bytes(&self) -> usize {
        size_of_val(&self.entries[..]) + size_of_val(&self.normals[..])
    }
}

/// The displaced vertices of one instance.
#[derive(Debug, Clone)]
pub(crate) struct ClassicState {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    /// The examples used so far, in the form that the rule reads.
    sparse: Vec<Option<Sparse>>,
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
        let sparse = set.examples().iter().map(|_| None).collect();
        Ok(ClassicState { positions, normals, sparse, journal: Vec::new(), known_since: 0 })
    }

    pub(crate) fn memory_bytes(&self) -> usize {
        size_of_val(&self.positions[..])
            + size_of_val(&self.normals[..])
            + self.sparse.iter().flatten().map(Sparse::bytes).sum::<usize>()
            + size_of_val(&self.journal[..])
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

    /// Applies Figure 4.3 to every vertex that `example` moves. Drops a candidate that is not finite (after many
    /// unclamped weights far above 2).
    pub(crate) fn apply(&mut self, set: &ExampleSet, example: u32, weight: f32, blend: Blend) {
        let base = set.mesh().positions();
        let lerp = |a: Vec3, b: Vec3, w: f32| a + (b - a) * w;
        let i = example as usize;
        let with_normals = set.mesh().normals().is_some();
        let sparse = self.sparse[i].get_or_insert_with(|| Sparse::new(&set.base_lod().anchored[i], with_normals));
        for (i, e) in sparse.entries.iter().enumerate() {
            let v = e.vertex as usize;
            let current = self.positions[v];
            let result = lerp(current, base[v] + e.displacement, weight);
            if !result.is_finite() {
                continue;
            }
            let further = (result - base[v]).length_squared() >= (current - base[v]).length_squared();
            // Vertices around the dent only change their normal: the paper's example does not contain them.
            if e.displacement != Vec3::ZERO {
                self.positions[v] = if further { result } else { lerp(current, result, blend.constant) };
            }
            if let (Some(normal), Some(base)) = (self.normals.get_mut(v), set.mesh().normals()) {
                let result = lerp(*normal, base[v] + sparse.normals[i], weight);
                if result.is_finite() {
                    *normal = if further { result } else { lerp(*normal, result, blend.constant) };
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

    /// Saves changed vertices as entries of 28 bytes: u32 vertex, 3 × f32 position (m), 3 × f32 normal (zero if the
    /// mesh has none).
    pub(crate) fn save(&self, set: &ExampleSet) -> Vec<u8> {
        let changed: Vec<usize> = (0..self.positions.len())
            .filter(|v| {
                self.positions[*v] != set.mesh().positions()[*v]
                    || set.mesh().normals().is_some_and(|n| n[*v] != self.normals[*v])
            })
            .collect();
        let mut out = saved::header(set, saved::CLASSIC, changed.len());
        for v in changed {
            out.extend((v as u32).to_le_bytes());
            let n = self.normals.get(v).copied().unwrap_or(Vec3::ZERO);
            for x in self.positions[v].to_array().into_iter().chain(n.to_array()) {
                out.extend(x.to_bits().to_le_bytes());
            }
        }
        saved::seal(&mut out);
        out
    }

    /// Reads the state that [`State::save`] wrote.
    pub(crate) fn load(set: &ExampleSet, bytes: &[u8]) -> Result<Self, Error> {
        let mut state = ClassicState::new(set)?;
        for (at, e) in saved::entries(set, bytes, saved::CLASSIC, 28)?.chunks_exact(28).enumerate() {
            let word = |i: usize| u32::from_le_bytes([e[i], e[i + 1], e[i + 2], e[i + 3]]);
            let vec =
                |i: usize| Vec3::new(f32::from_bits(word(i)), f32::from_bits(word(i + 4)), f32::from_bits(word(i + 8)));
            let v = word(0) as usize;
            let (p, n) = (vec(4), vec(16));
            if v >= state.positions.len() || !p.is_finite() || !n.is_finite() {
                return Err(Error::DamageMismatch {
                    what: format!(
                        "entry {at}: vertex {v} at {p}; vertices go to {}, numbers must be finite",
                        set.vertex_count() - 1
                    ),
                });
            }
            state.positions[v] = p;
            if let Some(slot) = state.normals.get_mut(v) {
                *slot = n;
            }
        }
        Ok(state)
    }
}
