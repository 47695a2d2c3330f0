//! Thresholds on parts and attached points, as an instance keeps them.

use super::attachment::Attachment;

/// What a threshold is compared with. It counts dents in full while they grow, and the tolerance leaves out nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Measure {
    /// [`PartDamage::deepest`](crate::PartDamage::deepest) of this mesh of the set, m.
    Deepest(usize),
    /// [`PartDamage::mean`](crate::PartDamage::mean) of this mesh of the set, m.
    Mean(usize),
    /// [`PartDamage::energy`](crate::PartDamage::energy) of this mesh of the set, m.
    Energy(usize),
    /// Distance of this attached point from its place at rest, m.
    Displacement(Attachment),
}

impl Measure {
    pub(super) fn lod(&self) -> Option<usize> {
        match self {
            Measure::Deepest(lod) | Measure::Mean(lod) | Measure::Energy(lod) => Some(*lod),
            Measure::Displacement(_) => None,
        }
    }
}

/// A threshold that the damage passed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Passed {
    /// The threshold's number.
    pub number: u32,
    /// What was measured, m: the limit or more.
    pub value: f32,
}

/// The thresholds of an instance, sorted by number.
#[derive(Debug, Clone, Default)]
pub(super) struct Thresholds {
    pub(super) list: Vec<Threshold>,
    /// The instance's epoch when the values were measured. `None`: they are to be measured.
    pub(super) epoch: Option<u64>,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Threshold {
    pub(super) number: u32,
    pub(super) measure: Measure,
    pub(super) limit: f32,
    pub(super) value: f32,
    /// Whether it was returned and the value has not been below the limit since.
    pub(super) passed: bool,
}

impl Thresholds {
    pub(super) fn memory_bytes(&self) -> usize {
        self.list.len() * size_of::<Threshold>()
    }

    /// Takes out the thresholds of a part that comes off: those on its mesh and on points of its surface. `is_of_part` tells
    /// whether a triangle is the part's.
    pub(super) fn of_part(&mut self, part: usize, is_of_part: impl Fn([u32; 3]) -> bool) -> Self {
        let goes = |t: &mut Threshold| match t.measure {
            Measure::Displacement(point) => is_of_part(point.vertices),
            measure => measure.lod() == Some(part),
        };
        Thresholds { list: self.list.extract_if(.., goes).collect(), epoch: None }
    }
}
