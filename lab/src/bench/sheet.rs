//! A synthetic bumpy sheet in row-major order, of any number of vertices, and dents in it.

use std::sync::Arc;

use anyhow::{Context, Result};
use crumple::{
    Contact, Deltas, ExampleData, ExampleSet, Hit, Instance, InstanceOptions, Mark, MeshData, SetOptions, TaskSystem,
};

use super::baked;

/// A grid 1 m wide.
#[derive(Debug, Clone, Copy)]
pub struct Sheet {
    columns: usize,
    rows: usize,
}

/// A dent in the sheet.
#[derive(Debug, Clone, Copy)]
pub struct Dent {
    /// Where it is deepest: shares of width and height.
    pub centre: [f32; 2],
    /// At the centre, m.
    pub depth: f32,
    pub reach: Reach,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Reach {
    /// Every vertex moves.
    Whole,
    /// Vertices within this distance of the centre move, m.
    Disc(f32),
}

impl Reach {
    /// Radius of a disc with a fifth of the sheet's area, m.
    pub const FIFTH: Reach = Reach::Disc(0.252);
}

impl Sheet {
    /// Of about `n` vertices.
    pub fn new(n: usize) -> Self {
        let columns = (n as f64).sqrt().round() as usize;
        Sheet { columns, rows: n.div_ceil(columns) }
    }

    pub fn len(&self) -> usize {
        self.columns * self.rows
    }

    /// Of the vertex at these shares of width and height.
    pub fn vertex(&self, at: [f32; 2]) -> u32 {
        let index = |share: f32, count: usize| (share * (count - 1) as f32).round() as usize;
        (index(at[1], self.rows) * self.columns + index(at[0], self.columns)) as u32
    }

    pub fn positions(&self) -> Vec<[f32; 3]> {
        let step = 1.0 / (self.columns - 1) as f32;
        let point = |v: usize| {
            let (x, y) = ((v % self.columns) as f32 * step, (v / self.columns) as f32 * step);
            [x, y, 0.02 * (9.0 * x + 1.0).sin() * (7.0 * y + 0.4).cos() + 0.01 * (23.0 * x * y).sin()]
        };
        (0..self.len()).map(point).collect()
    }

    /// Positions alone: its examples stay where they were made.
    pub fn points(&self) -> MeshData {
        MeshData { positions: self.positions(), ..Default::default() }
    }

    /// With triangles, so with normals.
    pub fn surface(&self) -> MeshData {
        let mut triangles = Vec::with_capacity(2 * self.len());
        for v in 0..self.len() - self.columns {
            if v % self.columns + 1 < self.columns {
                let (a, c) = (v as u32, self.columns as u32);
                triangles.extend([[a, a + 1, a + c], [a + c, a + 1, a + c + 1]]);
            }
        }
        MeshData { triangles, ..self.points() }
    }

    /// An example of the dent, hit at its centre.
    pub fn example(&self, dent: &Dent) -> ExampleData {
        let step = 1.0 / (self.columns - 1) as f32;
        let (mut indices, mut values) = (Vec::new(), Vec::new());
        let height = (self.rows - 1) as f32 * step;
        let centre = [dent.centre[0], dent.centre[1] * height];
        for v in 0..self.len() {
            let d =
                dent.at([(v % self.columns) as f32 * step - centre[0], (v / self.columns) as f32 * step - centre[1]]);
            if let Some(d) = d {
                indices.push(v as u32);
                values.push(d);
            }
        }
        let deltas =
            if indices.len() == self.len() { Deltas::Full(values) } else { Deltas::Sparse { indices, values } };
        ExampleData { contact: Some(Contact::Vertex(self.vertex(dent.centre))), ..ExampleData::new("dent", deltas) }
    }

    /// A set of these dents in the sheet without normals.
    pub fn set(&self, dents: &[Dent], tasks: &dyn TaskSystem) -> Result<Arc<ExampleSet>> {
        let examples = dents.iter().map(|d| self.example(d)).collect();
        // A bumpy sheet is no mirror image of itself, which is slow to find out in large meshes.
        let options = SetOptions { mirror: false, ..baked() };
        Ok(Arc::new(ExampleSet::build(self.points(), examples, options, tasks)?))
    }
}

impl Dent {
    pub fn whole(centre: [f32; 2]) -> Self {
        Dent { centre, depth: 0.05, reach: Reach::Whole }
    }

    /// Displacement at this place relative to the centre, m; no component is longer than `depth`.
    fn at(&self, [x, y]: [f32; 2]) -> Option<[f32; 3]> {
        let share = match self.reach {
            Reach::Whole => 0.2 + 0.8 * (-4.0 * (x * x + y * y)).exp(),
            Reach::Disc(radius) => {
                let inside = 1.0 - (x * x + y * y) / (radius * radius);
                if inside <= 0.0 {
                    return None;
                }
                inside * inside
            }
        };
        Some([-0.3 * x, -0.3 * y, -1.0].map(|c| c * share * self.depth))
    }
}

/// The mark of each example's own hit, which gives the example.
pub fn own_marks(set: &Arc<ExampleSet>) -> Result<Vec<Mark>> {
    let instance = Instance::new(set.clone(), InstanceOptions::default())?;
    let mark = |e: &crumple::Example| {
        let hit = Hit::displacement(e.contact_point().to_array(), e.contact_displacement().to_array());
        instance.preview(&hit)?.mark.context("an example's own hit leaves no mark")
    };
    set.examples().iter().map(mark).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dents_move_what_their_reach_says() {
        let sheet = Sheet::new(10_000);
        assert_eq!(sheet.len(), 10_000);
        let moved = |reach| match sheet.example(&Dent { reach, ..Dent::whole([0.5; 2]) }).positions {
            Deltas::Full(values) => values.iter().filter(|d| **d != [0.0; 3]).count(),
            Deltas::Sparse { indices, .. } => indices.len(),
        };
        assert_eq!(moved(Reach::Whole), 10_000);
        assert!((1950..2050).contains(&moved(Reach::FIFTH)), "{}", moved(Reach::FIFTH));
    }

    #[test]
    fn marks_bring_an_example_back() {
        let dents = [Dent::whole([0.5; 2])];
        let set = &Sheet::new(400).set(&dents, &crumple::Serial).unwrap();
        let mut instance = crumple::Instance::new(set.clone(), Default::default()).unwrap();
        instance.set_marks(&own_marks(set).unwrap()).unwrap();
        for v in 0..400 {
            let u = instance.displaced(v).unwrap() - set.mesh().positions()[v as usize];
            let off = (u - set.examples()[0].delta(v)).length();
            // What the set is baked to.
            assert!(off < 1e-4, "vertex {v} is {off} m off");
        }
    }
}
