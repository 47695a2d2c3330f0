//! The default model: displacements from marks, one vertex at a time.

use super::body::mirrored;
use super::vector::{Matrix, V, add, apply, dot, from_f32, length, product, rotation_between, scale, sub, transpose};
use super::{Example, Model};

/// A mark's pair of example and share.
#[derive(Debug, Clone, Copy)]
pub struct Part {
    pub example: usize,
    /// 1 is the whole; may be negative.
    pub share: f64,
    pub anchored: bool,
    /// The planes that it is mirrored in.
    pub mirror: u8,
}

/// One dent.
#[derive(Debug, Clone)]
pub struct Mark {
    pub contact: usize,
    /// Target depth, m.
    pub depth: f64,
    /// Energy in hits.
    pub hits: f64,
    /// Factors for the displacements and for the stretch; 1 for one hit alone.
    pub strength: f64,
    pub wide: f64,
    pub parts: Vec<Part>,
}

/// The documented layout of a pair: the share in 1/1024 in the low 12 bits, two's complement; the mirror planes x, y, z
/// in the next three bits; anchored in the top bit.
pub fn part_of(pair: crumple::Pair) -> Part {
    let units = f64::from(pair.share & 0xfff);
    Part {
        example: usize::from(pair.example),
        share: if units < 2048.0 { units } else { units - 4096.0 } / 1024.0,
        anchored: pair.share & 0x8000 != 0,
        mirror: (pair.share >> 12 & 7) as u8,
    }
}

/// The documented layout of a mark: energy in units of 2^-32. Unused pairs have example 0xFFFF.
pub fn mark_of(mark: &crumple::Mark) -> Mark {
    let energy = mark.energy as f64 / 2f64.powi(32);
    Mark {
        contact: mark.contact as usize,
        depth: f64::from(mark.depth),
        hits: energy,
        strength: energy,
        wide: 1.0,
        parts: mark.pairs.iter().filter(|p| p.example != 0xFFFF).map(|p| part_of(*p)).collect(),
    }
}

/// The documented marks of an instance, with the strengths and widths that they have together.
pub fn marks_of(model: &Model, marks: &[crumple::Mark]) -> Vec<Mark> {
    let mut marks: Vec<Mark> = marks.iter().map(mark_of).collect();
    upon_each_other(model, &mut marks);
    marks
}

/// The power of the depth that energy goes with.
pub const POWER: f64 = 2.4;

/// Hits upon hits: each mark gets its part of all the energy near its contact, and the width of the dent that this
/// energy makes.
fn upon_each_other(model: &Model, marks: &mut [Mark]) {
    let scales: Vec<Vec<f64>> = marks.iter().map(|m| scales(model, m)).collect();
    let moved = |j: usize, contact: usize| {
        let mut u = [0.0; 3];
        for (part, s) in marks[j].parts.iter().zip(&scales[j]) {
            u = add(u, scale(*s, open_at(model, &marks[j], part, contact)));
        }
        length(u)
    };
    let share = |j: usize, contact: usize| {
        let own = moved(j, marks[j].contact);
        if own > 0.0 { moved(j, contact) / own } else { 0.0 }
    };
    let mut together = Vec::new();
    for m in 0..marks.len() {
        let mut energy = 0.0;
        for j in 0..marks.len() {
            let near = share(j, marks[m].contact).max(share(m, marks[j].contact));
            let overlap = if j == m { 1.0 } else { ((near - 0.3) / 0.7).clamp(0.0, 1.0) };
            energy += overlap * marks[j].hits * (marks[j].depth / marks[m].depth).powf(POWER);
        }
        let deeper = energy.powf(1.0 / POWER);
        let room = 0.11 * model.diagonal / radius(model, &marks[m]);
        let wide = (deeper.sqrt().min(room) * 8.0).floor() / 8.0;
        together.push((marks[m].hits / energy * deeper, wide.max(1.0)));
    }
    for (mark, (strength, wide)) in marks.iter_mut().zip(together) {
        (mark.strength, mark.wide) = (strength, wide);
    }
}

/// The radius of a cylinder as deep as one hit of the mark, with the same integral of squared displacements. Infinite
/// if no part has a stamp.
fn radius(model: &Model, mark: &Mark) -> f64 {
    let (mut sum, mut shares) = (0.0, 0.0);
    for part in &mark.parts {
        let example = &model.examples[part.example];
        if let Some(grid) = &example.grid {
            let squares: f64 = grid.displacements.iter().map(|u| dot(*u, *u)).sum();
            let own = (squares * grid.step[0] * grid.step[1] / std::f64::consts::PI).sqrt() / example.depth();
            let stretch = if part.anchored { 1.0 } else { stretch(mark.depth, example, 1.0) };
            sum += part.share.abs() * stretch * own;
            shares += part.share.abs();
        }
    }
    if shares > 0.0 { sum / shares } else { f64::INFINITY }
}

/// Documented bounds of the stretch in the surface.
pub const STRETCH: (f64, f64) = (0.25, 4.0);
/// Examples that cancel each other at the contact are scaled up together by at most this factor.
pub const TOGETHER: f64 = 4.0;

/// The stretch in the surface of an example carried to a hit of depth `depth`, in a dent `wide` times as wide.
pub fn stretch(depth: f64, example: &Example, wide: f64) -> f64 {
    (wide * (depth / example.depth()).sqrt()).clamp(STRETCH.0, STRETCH.1)
}

/// Whether a part is read from the example's stamp: carried parts are, and anchored ones that are widened if they have
/// a stamp.
pub fn stamped(model: &Model, mark: &Mark, part: &Part) -> bool {
    !part.anchored || (mark.wide > 1.0 && model.examples[part.example].grid.is_some())
}

/// A stamp in f64.
#[derive(Debug, Clone)]
pub struct Chart {
    pub dims: [usize; 2],
    pub first: [f64; 2],
    pub step: [f64; 2],
    pub displacements: Vec<V>,
    pub heights: Vec<f64>,
    pub fade: f64,
    /// The rows are the contact frame's x, y, z in mesh space.
    pub frame: Matrix,
}

impl Chart {
    pub fn of(stamp: &crumple::Stamp, frame: crumple::glam::Mat3) -> Self {
        let (first, step) = stamp.grid();
        Self {
            dims: stamp.dims().map(|n| n as usize),
            first: first.map(f64::from),
            step: step.map(f64::from),
            displacements: stamp.nodes().iter().map(|u| from_f32(u.to_array())).collect(),
            heights: stamp.height_nodes().into_iter().map(f64::from).collect(),
            fade: f64::from(stamp.fade()),
            frame: [frame.x_axis, frame.y_axis, frame.z_axis].map(|axis| from_f32(axis.to_array())),
        }
    }

    /// The place of `p` on the unrolled surface, in units of nodes.
    fn unrolled(&self, p: V) -> [f64; 2] {
        let across = p[0] * p[0] + p[1] * p[1];
        let steep = if across > 0.0 { (p[2] * p[2] / across).min(2.0) } else { 2.0 };
        [0, 1].map(|k| (p[k] * (1.0 + steep / 2.0) - self.first[k]) / self.step[k])
    }

    /// Bilinear interpolation; `None` outside.
    fn look_up(&self, p: V) -> Option<V> {
        let at = self.unrolled(p);
        let mut cell = [0usize; 2];
        let mut part = [0.0; 2];
        for k in 0..2 {
            if !(0.0..=(self.dims[k] - 1) as f64).contains(&at[k]) {
                return None;
            }
            cell[k] = (at[k].floor() as usize).min(self.dims[k] - 2);
            part[k] = at[k] - cell[k] as f64;
        }
        let (mut height, mut sum) = (0.0, [0.0; 3]);
        for corner in 0..4 {
            let weight: f64 = (0..2).map(|k| if corner >> k & 1 == 1 { part[k] } else { 1.0 - part[k] }).product();
            let node = cell[0] + (corner & 1) + self.dims[0] * (cell[1] + (corner >> 1));
            sum = add(sum, scale(weight, self.displacements[node]));
            height += weight * self.heights[node];
        }
        // everything is kept up to half the fade above or below the surface, and nothing beyond the whole fade
        Some(scale((2.0 - 2.0 * (p[2] - height).abs() / self.fade).clamp(0.0, 1.0), sum))
    }
}

/// The place of `vertex` in the stamp of an example carried to the mark (contact frame, m, stretch undone), and the inverse
/// transform.
fn place<'a>(model: &'a Model, mark: &Mark, part: &Part, vertex: usize) -> (&'a Chart, Matrix, V) {
    let example = &model.examples[part.example];
    let grid = example.grid.as_ref().expect("a carried example has a stamp");
    if part.anchored {
        // widened where it was made
        let back = transpose(grid.frame);
        let p = apply(grid.frame, sub(model.positions[vertex], example.contact_point));
        let s = mark.wide.clamp(STRETCH.0, STRETCH.1);
        return (grid, back, [p[0] / s, p[1] / s, p[2]]);
    }
    let normal = mirrored(example.contact_normal, part.mirror);
    let rotation = rotation_between(normal, model.contact_normals[mark.contact]);
    let mirror = [0, 1, 2].map(|i| mirrored([0, 1, 2].map(|j| f64::from(u8::from(i == j))), part.mirror));
    // from stamp to mesh: out of the contact frame, mirrored, rotated
    let back = product(rotation, product(mirror, transpose(grid.frame)));
    let p = apply(transpose(back), sub(model.positions[vertex], model.positions[mark.contact]));
    let s = stretch(mark.depth, example, mark.wide);
    (grid, back, [p[0] / s, p[1] / s, p[2]])
}

/// Whether `vertex` is so near the border of a stamp that rounding decides whether it is inside.
pub fn on_a_border(model: &Model, mark: &Mark, vertex: usize) -> bool {
    mark.parts.iter().filter(|p| stamped(model, mark, p)).any(|part| {
        let (grid, _, p) = place(model, mark, part, vertex);
        let at = grid.unrolled(p);
        (0..2).any(|k| at[k].abs() < 1e-3 || (at[k] - (grid.dims[k] - 1) as f64).abs() < 1e-3)
    })
}

/// Displacement of `vertex` by one example of a mark of strength 1, without held rims.
pub fn open_at(model: &Model, mark: &Mark, part: &Part, vertex: usize) -> V {
    if !stamped(model, mark, part) {
        return model.examples[part.example].deltas[vertex];
    }
    let (grid, back, p) = place(model, mark, part, vertex);
    grid.look_up(p).map_or([0.0; 3], |u| apply(back, u))
}

/// The same with held rims: what is carried falls to zero towards them.
pub fn example_at(model: &Model, mark: &Mark, part: &Part, vertex: usize) -> V {
    let factor = if stamped(model, mark, part) { model.windows[vertex] } else { 1.0 };
    scale(factor, open_at(model, mark, part, vertex))
}

/// The factor of each part of a mark. Each part is scaled by its share of the target depth over its own depth. Then all
/// are scaled together so that the contact gets the target depth if no rim is held. Factors of anchored parts stay
/// between -1 and 1.
pub fn scales(model: &Model, mark: &Mark) -> Vec<f64> {
    let at_contact: Vec<V> = mark.parts.iter().map(|p| open_at(model, mark, p, mark.contact)).collect();
    let mut scales = Vec::new();
    let mut sum = [0.0; 3];
    for (part, u) in mark.parts.iter().zip(&at_contact) {
        let own = if part.anchored { length(*u) } else { model.examples[part.example].depth() };
        let scale_of_part = part.share * mark.depth / own;
        sum = add(sum, scale(scale_of_part, *u));
        scales.push(scale_of_part);
    }
    let together = if length(sum) > 0.0 { (mark.depth / length(sum)).min(TOGETHER) } else { 1.0 };
    for (s, part) in scales.iter_mut().zip(&mark.parts) {
        *s *= together;
        if part.anchored {
            *s = s.clamp(-1.0, 1.0);
        }
    }
    scales
}

/// Displacement of the contact by one mark of strength 1, without held rims.
pub fn open(model: &Model, mark: &Mark) -> V {
    let mut sum = [0.0; 3];
    for (part, w) in mark.parts.iter().zip(scales(model, mark)) {
        sum = add(sum, scale(w, open_at(model, mark, part, mark.contact)));
    }
    sum
}

/// Displacement of the contact by one mark of strength 1.
pub fn met(model: &Model, mark: &Mark) -> V {
    let mut sum = [0.0; 3];
    for (part, w) in mark.parts.iter().zip(scales(model, mark)) {
        sum = add(sum, scale(w, example_at(model, mark, part, mark.contact)));
    }
    sum
}

/// A mark and the factors of its parts, computed once.
pub struct Scaled<'a>(pub &'a Mark, pub Vec<f64>);

/// The factors are those of one hit alone: a dent does not get deeper by getting wider.
pub fn scaled<'a>(model: &Model, marks: &'a [Mark]) -> Vec<Scaled<'a>> {
    let alone = |m: &Mark| scales(model, &Mark { wide: 1.0, ..m.clone() });
    marks.iter().map(|m| Scaled(m, alone(m))).collect()
}

/// Displacement of `vertex` by one mark.
pub fn mark_at(model: &Model, Scaled(mark, scales): &Scaled<'_>, vertex: usize) -> V {
    let mut sum = [0.0; 3];
    for (part, s) in mark.parts.iter().zip(scales) {
        sum = add(sum, scale(mark.strength * s, example_at(model, mark, part, vertex)));
    }
    sum
}

/// The largest displacement that a mark makes anywhere near; its rounding errors are relative to it. (At one vertex neighbouring
/// nodes of a stamp may cancel, but their errors do not.)
pub fn size(model: &Model, Scaled(mark, scales): &Scaled<'_>) -> f64 {
    let longest = |list: &[V]| list.iter().map(|u| length(*u)).fold(0.0, f64::max);
    let of_part = |(part, s): (&Part, &f64)| mark.strength * s.abs() * longest(&model.examples[part.example].deltas);
    mark.parts.iter().zip(scales).map(of_part).sum()
}

/// Resolution of the weights of a stamp's bilinear mean, with a margin: integers of 14 bits, rounded down.
pub const WEIGHTS: f64 = 2.0 / 16384.0;

/// How far the library's f32 may be from a point of the oracle, where a node is at each vertex. `size` is the size of the
/// displacements summed. Nodes move in at least 16 000 steps up to the limit.
pub fn rounding(ought: V, size: f64, limit: f64) -> f64 {
    WEIGHTS * size + 4e-7 * length(ought) + 0.87 * limit / 16000.0
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

/// Displacement of `vertex` by all marks, on a body with this depth limit, m.
pub fn displacement(model: &Model, marks: &[Scaled<'_>], vertex: usize, limit: f64, own: Limit) -> V {
    let sum = marks.iter().fold([0.0; 3], |sum, mark| add(sum, mark_at(model, mark, vertex)));
    let s = length(sum);
    if s == 0.0 {
        return [0.0; 3];
    }
    let kept = soft(s, limit.min(16.0 * model.depth_limit));
    scale((own.give * kept).min(own.depth) / s, sum)
}
