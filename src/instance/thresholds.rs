//! Sets thresholds, and returns those that the damage passed since the last call.

use super::Instance;
use super::parts::PartDamage;
use super::threshold_state::{Measure, Passed, Threshold, Thresholds};
use crate::base::error::Error;
use std::collections::HashMap;

impl Instance {
    /// Sets a threshold, or replaces the one of this number. [`Instance::passed`] returns the number once the measure
    /// reaches `limit` (m, above 0). A limit of infinity is never reached and costs nothing. Thresholds are no damage: they
    /// are not saved, loaded or repaired. Those of a part that comes off go with it ([`Instance::release`]).
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for the limit; [`Error::IndexOutOfRange`] for a mesh that the set does not have;
    /// [`Error::IndexOutOfRange`] or [`Error::NotFinite`] for an attachment that this set did not make;
    /// [`Error::WrongRule`] with a classic rule for a mesh other than 0 or an energy. After an error nothing has changed.
    pub fn set_threshold(&mut self, number: u32, measure: Measure, limit: f32) -> Result<(), Error> {
        if limit.is_nan() || limit <= 0.0 {
            return Err(Error::invalid("limit", limit, "above 0 m"));
        }
        match measure {
            Measure::Displacement(point) => drop(self.attached_frame(&point)?),
            Measure::Deepest(lod) | Measure::Mean(lod) | Measure::Energy(lod) => {
                self.set.lod(lod)?;
                if lod > 0 || matches!(measure, Measure::Energy(_)) {
                    self.only_marks("set_threshold on another mesh than 0, or on an energy")?;
                }
            }
        }
        let list = &mut self.thresholds.list;
        let threshold = Threshold { number, measure, limit, value: 0.0, passed: false };
        match list.binary_search_by_key(&number, |t| t.number) {
            Ok(at) => list[at] = threshold,
            Err(at) => list.insert(at, threshold),
        }
        self.thresholds.epoch = None;
        Ok(())
    }

    /// Returns the thresholds that the damage has passed since the last call, by increasing number, after folding the hits
    /// that have arrived. A threshold is returned again only after a call that found its measure below the limit, as after
    /// a repair. Loaded damage counts like any other. The same damage and the same calls give the same result on every
    /// platform.
    ///
    /// A call costs one comparison if nothing changed, and otherwise a [measurement](Instance::measure) of each mesh that
    /// has thresholds.
    ///
    /// # Errors
    /// Those of [`Instance::measure`] and [`Instance::attached_frame`], which [`Instance::set_threshold`] has excluded.
    pub fn passed(&mut self) -> Result<Vec<Passed>, Error> {
        let mut all = Vec::new();
        while let Some(passed) = self.next_passed()? {
            all.push(passed);
        }
        Ok(all)
    }

    /// The first of [`Instance::passed`]; the next call returns the next.
    pub(crate) fn next_passed(&mut self) -> Result<Option<Passed>, Error> {
        if self.thresholds.list.is_empty() {
            return Ok(None);
        }
        self.fold();
        if self.thresholds.epoch != Some(self.changes.epoch) {
            self.compare_thresholds()?;
        }
        let next = self.thresholds.list.iter_mut().find(|t| t.value >= t.limit && !t.passed);
        Ok(next.map(|t| {
            t.passed = true;
            Passed { number: t.number, value: t.value }
        }))
    }

    fn compare_thresholds(&mut self) -> Result<(), Error> {
        let mut meshes: HashMap<usize, PartDamage> = HashMap::new();
        let mut list = std::mem::take(&mut self.thresholds.list);
        let compared = list.iter_mut().filter(|t| t.limit < f32::INFINITY).try_for_each(|t| {
            if let Some(lod) = t.measure.lod()
                && !meshes.contains_key(&lod)
            {
                meshes.insert(lod, self.measure(lod)?);
            }
            t.value = match t.measure {
                Measure::Deepest(lod) => meshes[&lod].deepest,
                Measure::Mean(lod) => meshes[&lod].mean,
                Measure::Energy(lod) => meshes[&lod].energy,
                Measure::Displacement(point) => self.moved(&point)?,
            };
            t.passed &= t.value >= t.limit;
            Ok(())
        });
        self.thresholds = Thresholds { list, epoch: Some(self.changes.epoch) };
        compared
    }
}
