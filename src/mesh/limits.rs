//! How far each vertex may move: its own depth limit, and the share of a displacement that its stiffness leaves.
//!
//! A vertex whose dents sum to `S` moves by `S`, shortened to the length `allowed = min(give * |S|, limit)`, where `give`
//! is 1 - stiffness. Both numbers are stored as the upper half of a 32-bit float, rounded down. So a limit is never
//! exceeded, 0, 1 and infinity are exact, and vertices at one position have the same bits in every block and mesh.

use super::data::MeshData;
use super::vertex_blocks::BLOCK;
use crate::base::array::Array;
use crate::base::error::Error;
use glam::Vec3;

/// The upper halves of one block's floats.
pub(crate) type Halves = [u16; BLOCK];

/// Limits treat shorter displacements as if they had this length, m. So a vertex that does not move still has a factor
/// for the change of its normal. The square of this length is a normal float.
pub(crate) const LEAST_LENGTH: f32 = 1e-18;

/// The float whose upper half this is.
pub(crate) fn whole(half: u16) -> f32 {
    f32::from_bits(u32::from(half) << 16)
}

/// The upper half of a number that is not negative: the number rounded down.
pub(crate) fn half(x: f32) -> u16 {
    (x.to_bits() >> 16) as u16
}

/// The values of a mesh's vertices. Both arrays have one element per block, or none.
#[derive(Debug, Default, Clone)]
pub(crate) struct Limits {
    /// Depth limits, m; infinite without one.
    depths: Array<Halves>,
    /// 1 - stiffness.
    gives: Array<Halves>,
    /// For each block, dents that sum to less than this are not shortened, m. Empty if both arrays are.
    least: Vec<f32>,
}

/// The values of a block's vertices.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BlockLimits<'a> {
    pub depths: Option<&'a Halves>,
    pub gives: Option<&'a Halves>,
}

impl Limits {
    /// Checks the values of a mesh with these seams. Vertices at one position take the least limit and the greatest
    /// stiffness.
    pub(crate) fn new(data: &MeshData, weld: &[u32]) -> Result<Self, Error> {
        let depths =
            check(data.depth_limits.as_deref(), "depth_limits", f32::INFINITY, "at least 0 m; infinity: none", weld)?;
        let stiffness = check(data.stiffness.as_deref(), "stiffness", 1.0, "0 to 1", weld)?;
        let gives: Option<Vec<f32>> = stiffness.map(|s| s.iter().map(|s| 1.0 - s).collect());
        Ok(Limits::of(blocks(depths, weld, f32::INFINITY), blocks(gives, weld, 1.0)))
    }

    /// Makes the values from arrays as [`Limits::new`] makes them.
    pub(crate) fn of(depths: Array<Halves>, gives: Array<Halves>) -> Self {
        let least = |b: usize| {
            if gives.get(b).is_some_and(|g| g.iter().any(|g| *g < half(1.0))) {
                return 0.0;
            }
            depths.get(b).map_or(f32::INFINITY, |d| whole(d.iter().copied().min().unwrap_or_default()))
        };
        let least = (0..depths.len().max(gives.len())).map(least).collect();
        Limits { depths, gives, least }
    }

    /// The values of another mesh whose vertices take those of these vertices. Values of its own have precedence.
    pub(crate) fn completed(self, from: &Limits, nearest: &[u32], weld: &[u32]) -> Self {
        let taken = |of: &Array<Halves>, other: f32| {
            let values = (!of.is_empty()).then(|| nearest.iter().map(|v| at(of, *v, other)).collect());
            blocks(values, weld, other)
        };
        let depths = if self.depths.is_empty() { taken(&from.depths, f32::INFINITY) } else { self.depths };
        let gives = if self.gives.is_empty() { taken(&from.gives, 1.0) } else { self.gives };
        Limits::of(depths, gives)
    }

    /// Depth limits and 1 - stiffness by blocks, as [`Limits::of`] takes them.
    pub(crate) fn parts(&self) -> [&Array<Halves>; 2] {
        [&self.depths, &self.gives]
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.least.is_empty()
    }

    /// For each block the length of dents up to which nothing is shortened, m.
    pub(crate) fn least(&self) -> &[f32] {
        &self.least
    }

    /// The values of a block.
    pub(crate) fn block(&self, b: usize) -> BlockLimits<'_> {
        BlockLimits { depths: self.depths.get(b), gives: self.gives.get(b) }
    }

    /// The depth limit of vertex `v`, m; infinite without one.
    pub(crate) fn depth(&self, v: u32) -> f32 {
        at(&self.depths, v, f32::INFINITY)
    }

    /// 1 - stiffness of vertex `v`.
    pub(crate) fn give(&self, v: u32) -> f32 {
        at(&self.gives, v, 1.0)
    }

    /// The factor for a displacement of vertex `v`, with the operations of the kernels; 1 where nothing is shortened.
    pub(crate) fn factor(&self, v: u32, displacement: Vec3) -> f32 {
        if self.is_empty() {
            return 1.0;
        }
        let length = displacement.length_squared().sqrt().max(LEAST_LENGTH);
        let most = length * self.give(v);
        let limit = self.depth(v);
        let allowed = if limit < most { limit } else { most };
        if length > allowed { allowed / length } else { 1.0 }
    }

    pub(crate) fn bytes(&self) -> usize {
        self.depths.bytes() + self.gives.bytes() + size_of_val(&self.least[..])
    }

    /// Number of vertices with a depth limit, with a stiffness above 0, and with a limit of 0 or a stiffness of 1.
    pub(crate) fn count(&self) -> [usize; 3] {
        let of = |counts: fn(f32, f32) -> bool| {
            let vertices = 0..(self.least.len() * BLOCK) as u32;
            vertices.filter(|&v| counts(self.depth(v), self.give(v))).count()
        };
        [of(|depth, _| depth < f32::INFINITY), of(|_, give| give < 1.0), of(|depth, give| depth.min(give) == 0.0)]
    }
}

fn at(of: &Array<Halves>, v: u32, other: f32) -> f32 {
    of.get(v as usize / BLOCK).map_or(other, |b| whole(b[v as usize % BLOCK]))
}

fn check(
    values: Option<&[f32]>,
    name: &str,
    most: f32,
    expected: &str,
    weld: &[u32],
) -> Result<Option<Vec<f32>>, Error> {
    let Some(values) = values else { return Ok(None) };
    if values.len() != weld.len() {
        let what = format!("{} {name} for {} positions; there must be as many", values.len(), weld.len());
        return Err(Error::Mesh { what });
    }
    if let Some(v) = values.iter().position(|x| !(0.0..=most).contains(x)) {
        return Err(Error::invalid(&format!("{name}[{v}]"), values[v], expected));
    }
    // -0 becomes +0, so that the bits sort as the numbers do.
    Ok(Some(values.iter().map(|x| x + 0.0).collect()))
}

/// Values by blocks: the least of those at one position, rounded down. None if all are `other`, which fills the last block.
fn blocks(values: Option<Vec<f32>>, weld: &[u32], other: f32) -> Array<Halves> {
    let Some(values) = values.filter(|v| v.iter().any(|x| *x < other)) else { return Array::default() };
    let mut least: Vec<u16> = values.iter().map(|x| half(*x)).collect();
    for v in 0..weld.len() {
        let w = weld[v] as usize;
        least[w] = least[w].min(least[v]);
    }
    let mut all = vec![[half(other); BLOCK]; weld.len().div_ceil(BLOCK)];
    for (to, w) in all.as_flattened_mut().iter_mut().zip(weld) {
        *to = least[*w as usize];
    }
    all.into()
}
