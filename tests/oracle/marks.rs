//! Marks near each other: displacements from what each hit alone leaves, one vertex at a time.

use crumple::glam::DVec3;

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
    /// What one hit alone moves each vertex by, m, and the depth limit for which that was computed.
    pub field: Vec<DVec3>,
    pub limit: f64,
}

impl Mark {
    /// A mark of the library. `alone` is what one hit of it moves each vertex by, m, with a depth limit that is far.
    pub fn of(mark: &crumple::Mark, alone: &impl Fn(&crumple::Mark) -> (Vec<DVec3>, f64)) -> Mark {
        let (field, limit) = alone(mark);
        let hits = mark.energy as f64 / crumple::Mark::ONE as f64;
        Mark { contact: mark.contact as usize, depth: mark.depth.into(), hits, field, limit }
    }

    /// The longest displacement, m.
    pub fn longest(&self) -> f64 {
        self.field.iter().map(|u| u.length()).fold(0.0, f64::max)
    }
}

/// All the energy near each contact, in hits of the mark's depth.
fn energies(marks: &[Mark]) -> Vec<f64> {
    let share = |of: &Mark, at: &Mark| {
        let own = of.field[of.contact].length();
        if own > 0.0 { of.field[at.contact].length() / own } else { 0.0 }
    };
    let energy = |(m, mark): (usize, &Mark)| -> f64 {
        let energy = |(j, other): (usize, &Mark)| {
            let near = share(other, mark).max(share(mark, other));
            let overlap = if j == m { 1.0 } else { ((near - 0.3) / 0.7).clamp(0.0, 1.0) };
            overlap * other.hits * (other.depth / mark.depth).powf(POWER)
        };
        marks.iter().enumerate().map(energy).sum()
    };
    marks.iter().enumerate().map(energy).collect()
}

/// The part of all the energy near its contact that each mark has: the factor on its field.
fn strengths(marks: &[Mark], energies: &[f64]) -> Vec<f64> {
    marks.iter().zip(energies).map(|(mark, all)| mark.hits / all * all.powf(1.0 / POWER)).collect()
}

/// The energies if the contacts' own displacements are as much longer or shorter as rounding may make them. Where little changes much, such
/// as the energy of a small dent at the rim of a great one, rounding does too.
fn doubtful_energies(marks: &[Mark], sign: f64) -> Vec<f64> {
    let off = |mark: &Mark| {
        let mut off = mark.clone();
        let (own, step) = (&mut off.field[mark.contact], 0.87 * mark.limit / 16000.0);
        *own *= 1.0 + sign * (2e-4 + step / own.length().max(2.0 * step));
        off
    };
    energies(&marks.iter().map(off).collect::<Vec<_>>())
}

/// The power of two to which a mark's own energy is rounded, at most 3.
fn level(energy: f64) -> u16 {
    energy.max(1.0).log2().round().min(3.0) as u16
}

/// Dents with the fields that are shown, and their strengths.
#[derive(Debug)]
pub struct Shown {
    pub marks: Vec<Mark>,
    strengths: Vec<f64>,
    /// What rounding may make of the strengths.
    others: [Vec<f64>; 2],
    /// How far rounding of the fields may move a vertex, m.
    rounding: f64,
}

impl Shown {
    /// What is shown of the library's marks. `alone` is that of [`Mark::of`].
    pub fn of(given: &[crumple::Mark], alone: impl Fn(&crumple::Mark) -> (Vec<DVec3>, f64)) -> Shown {
        let mut marks: Vec<Mark> = given.iter().map(|mark| Mark::of(mark, &alone)).collect();
        let all = energies(&marks);
        let strengths = strengths(&marks, &all);
        let others = [1.0, -1.0].map(|sign| self::strengths(&marks, &doubtful_energies(&marks, sign)));
        for (mark, given) in marks.iter_mut().zip(given) {
            let level = level(mark.hits);
            if level == 0 {
                continue;
            }
            // A blow is stored as 500 times the logarithm to base 2 of its energy.
            let deeper = f64::from(level).exp2().powf(1.0 / POWER);
            let strength = if given.told == 1 { given.strength + 500 * level } else { 0 };
            let depth = given.depth * deeper as f32;
            let (field, limit) = alone(&crumple::Mark { depth, strength, ..*given });
            if field[mark.contact].length() > 0.0 {
                mark.field = field.iter().map(|u| *u / deeper).collect();
                mark.limit = limit / deeper;
            }
        }
        // Each hit alone was rounded to steps of its own limit.
        let off = |(m, s): (&Mark, &f64)| s * (1e-4 * m.longest() + 0.87 * m.limit / 16000.0);
        let rounding = marks.iter().zip(&strengths).map(off).sum();
        Shown { marks, strengths, others, rounding }
    }

    /// Displacement of `vertex` by all marks, on a body with this depth limit, m.
    pub fn displacement(&self, vertex: usize, limit: f64, own: Limit) -> DVec3 {
        displacement(&self.marks, &self.strengths, vertex, limit, own)
    }

    /// How far the library may be from that: nodes move in at least 16 000 steps up to the limit.
    pub fn doubt(&self, vertex: usize, limit: f64, own: Limit) -> f64 {
        let ought = self.displacement(vertex, limit, own);
        let of = |strengths: &Vec<f64>| displacement(&self.marks, strengths, vertex, limit, own);
        let strengths: f64 = self.others.iter().map(|others| 2.0 * of(others).distance(ought)).sum();
        strengths + self.rounding + 0.87 * limit / 16000.0
    }
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
fn displacement(marks: &[Mark], strengths: &[f64], vertex: usize, limit: f64, own: Limit) -> DVec3 {
    let sum = marks.iter().zip(strengths).map(|(m, s)| m.field[vertex] * *s).sum::<DVec3>();
    let s = sum.length();
    if s == 0.0 {
        return DVec3::ZERO;
    }
    sum * ((own.give * soft(s, limit)).min(own.depth) / s)
}
