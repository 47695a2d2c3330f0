//! The list of marks: hits that repeat a mark add their energy. Beyond the capacity the weakest mark gives its energy
//! away.

use std::collections::BTreeMap;

use crumple::Mark;
use crumple::glam::Vec3;

use super::marks::POWER;

/// Contact, depth (its bits) and the numbers of the hit. Marks with the same key are one. Marks are kept in this order.
pub type Key = (u32, u32, [u16; 8]);

pub fn key(mark: &Mark) -> Key {
    let Mark { told, striker, direction: [x, y], strength, mass, radius, reserved, .. } = *mark;
    (mark.contact, mark.depth.to_bits(), [told, striker, x, y, strength, mass, radius, reserved])
}

/// Marks as a plain map.
#[derive(Debug, Clone, Default)]
pub struct Ledger {
    pub energies: BTreeMap<Key, u64>,
}

fn depth(key: &Key) -> f64 {
    f64::from(f32::from_bits(key.1))
}

impl Ledger {
    /// Adds the marks of one frame, one after another in canonical order.
    pub fn frame(&mut self, positions: &[Vec3], marks: &[Mark], capacity: usize) {
        let mut marks = marks.to_vec();
        marks.sort_by_key(|m| (key(m), m.energy));
        for mark in marks {
            let energy = self.energies.entry(key(&mark)).or_insert(0);
            *energy = energy.saturating_add(mark.energy);
            if self.energies.len() > capacity {
                self.merge_weakest(positions);
            }
        }
    }

    fn merge_weakest(&mut self, positions: &[Vec3]) {
        // f32, as documented for the size of a mark: the choice must not depend on the oracle's extra digits
        let size = |(k, e): (&Key, &u64)| {
            let energy = *e as f64 / 2f64.powi(32);
            // libm's, as the model says: the last digit may decide which mark is the weakest
            libm::pow(energy, 1.0 / POWER) as f32 * depth(k) as f32
        };
        let weakest = *self.energies.iter().min_by(|a, b| size(*a).total_cmp(&size(*b))).unwrap().0;
        let energy = self.energies.remove(&weakest).unwrap();
        // squared and in f32 as well, so that equally near contacts tie as they do in the library
        let at = |k: &Key| positions[k.0 as usize];
        let distance = |k: &Key| at(k).distance_squared(at(&weakest));
        let Some(heir) = self.energies.keys().min_by(|a, b| distance(a).total_cmp(&distance(b))).copied() else {
            return;
        };
        // conserves the depth of the mark alone
        let ratio = depth(&weakest) / depth(&heir);
        let given = energy as f64 * libm::pow(ratio, POWER);
        let entry = self.energies.get_mut(&heir).unwrap();
        *entry = entry.saturating_add(given as u64);
    }

    pub fn marks(&self) -> Vec<Mark> {
        let of = |(k, e): (&Key, &u64)| {
            let [told, striker, x, y, strength, mass, radius, reserved] = k.2;
            let (depth, direction) = (f32::from_bits(k.1), [x, y]);
            Mark { contact: k.0, depth, energy: *e, told, striker, direction, strength, mass, radius, reserved }
        };
        self.energies.iter().map(of).collect()
    }
}
