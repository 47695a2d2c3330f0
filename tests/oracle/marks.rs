//! Marks near each other: displacements from what each hit alone leaves, one vertex at a time.

use super::vector::{V, add, length, scale};

/// The power of the depth that energy goes with.
pub const POWER: f64 = 2.4;

/// One dent.
#[derive(Debug, Clone)]
pub struct Mark {
    pub contact: usize,
    /// m.
    pub depth: f64,
    /// Energy in hits.
    pub hits: f64,
    /// What one hit alone moves each vertex by, m.
    pub field: Vec<V>,
}

/// The part of all the energy near its contact that each mark has: the factor on its field.
pub fn strengths(marks: &[Mark]) -> Vec<f64> {
    let share = |of: &Mark, at: &Mark| {
        let own = length(of.field[of.contact]);
        if own > 0.0 { length(of.field[at.contact]) / own } else { 0.0 }
    };
    let strength = |(m, mark): (usize, &Mark)| {
        let energy = |(j, other): (usize, &Mark)| {
            let near = share(other, mark).max(share(mark, other));
            let overlap = if j == m { 1.0 } else { ((near - 0.3) / 0.7).clamp(0.0, 1.0) };
            overlap * other.hits * (other.depth / mark.depth).powf(POWER)
        };
        let all: f64 = marks.iter().enumerate().map(energy).sum();
        mark.hits / all * all.powf(1.0 / POWER)
    };
    marks.iter().enumerate().map(strength).collect()
}

/// The strengths if the contacts' own displacements are as much longer and shorter as rounding by `step` (of each mark, m) may make them. Where little
/// changes much, such as the energy of a small dent at the rim of a great one, rounding does too.
pub fn doubtful_strengths(marks: &[Mark], step: impl Fn(usize) -> f64) -> [Vec<f64>; 2] {
    [1.0, -1.0].map(|sign| {
        let off = |(i, mark): (usize, &Mark)| {
            let mut off = mark.clone();
            let (own, step) = (&mut off.field[mark.contact], step(i));
            *own = scale(1.0 + sign * (2e-4 + step / length(*own).max(2.0 * step)), *own);
            off
        };
        strengths(&marks.iter().enumerate().map(off).collect::<Vec<_>>())
    })
}

/// How far the library's f32 may be from a point of the oracle, where a node is at each vertex. `size` is the size of the
/// displacements summed. Nodes move in at least 16 000 steps up to the limit.
pub fn rounding(ought: V, size: f64, limit: f64) -> f64 {
    1e-4 * size + 4e-7 * length(ought) + 0.87 * limit / 16000.0
}

/// How far a vertex may move: its own depth limit, m, and 1 - stiffness.
#[derive(Debug, Clone, Copy)]
pub struct Limit {
    pub depth: f64,
    pub give: f64,
}

/// Where a displacement of this length ends up on its way to the limit: three quarters of the limit are free.
fn soft(length: f64, limit: f64) -> f64 {
    let (free, rest) = (0.75 * limit, 0.25 * limit);
    if length <= free { length } else { free + rest * (length - free) / (rest + length - free) }
}

/// Displacement of `vertex` by all marks with their strengths, on a body with this depth limit, m.
pub fn displacement(marks: &[Mark], strengths: &[f64], vertex: usize, limit: f64, own: Limit) -> V {
    let sum = marks.iter().zip(strengths).fold([0.0; 3], |sum, (m, s)| add(sum, scale(*s, m.field[vertex])));
    let s = length(sum);
    if s == 0.0 {
        return [0.0; 3];
    }
    scale((own.give * soft(s, limit)).min(own.depth) / s, sum)
}
