//! A body of the truths as a peer simulates it: the same grid or every second or fourth vertex of it, and fields read
//! back at the truth's vertices.

use crate::metric;
use crate::truth::{Body, Field, Truth};

/// The parameters' grid: vertex `i * columns + j`; a tube wraps in `i`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Grid {
    pub rows: usize,
    pub columns: usize,
    pub wraps: bool,
}

impl Grid {
    pub fn of(body: &Body) -> Self {
        Self { rows: body.grid[0], columns: body.grid[1], wraps: body.name == "tube" }
    }

    /// Cells along `i`.
    fn cells(self) -> usize {
        if self.wraps { self.rows } else { self.rows - 1 }
    }

    /// Every `stride`-th vertex. The stride must divide both numbers of cells.
    pub fn coarsened(self, stride: usize) -> Self {
        assert!(self.cells().is_multiple_of(stride) && (self.columns - 1).is_multiple_of(stride));
        let cells = self.cells() / stride;
        Self {
            rows: if self.wraps { cells } else { cells + 1 },
            columns: (self.columns - 1) / stride + 1,
            wraps: self.wraps,
        }
    }

    /// Outward triangles with alternating diagonals, as in the truth.
    pub fn triangles(self) -> Vec<[u32; 3]> {
        let mut triangles = Vec::with_capacity(2 * self.cells() * (self.columns - 1));
        for i in 0..self.cells() {
            for j in 0..self.columns - 1 {
                let (a, b) = (i * self.columns + j, ((i + 1) % self.rows) * self.columns + j);
                let (c, d) = (b + 1, a + 1);
                let pair = if (i + j) % 2 == 1 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] };
                triangles.extend(pair.map(|t| t.map(|v| v as u32)));
            }
        }
        triangles
    }

    /// The vertices of the rim: all four edges of the panel, both end rings of the tube.
    pub fn rim(self) -> Vec<u32> {
        let on_rim = |v: &usize| {
            let (i, j) = (v / self.columns, v % self.columns);
            j == 0 || j == self.columns - 1 || (!self.wraps && (i == 0 || i == self.rows - 1))
        };
        (0..self.rows * self.columns).filter(on_rim).map(|v| v as u32).collect()
    }

    /// The vertices of the grid that this one was coarsened from.
    fn picked(self, fine: Grid, stride: usize) -> impl Iterator<Item = usize> {
        (0..self.rows * self.columns)
            .map(move |v| (v / self.columns * stride) * fine.columns + v % self.columns * stride)
    }

    /// `field` of this grid, bilinear at the vertices of the grid that it was coarsened from.
    pub fn refine(self, field: &[[f32; 3]], fine: Grid, stride: usize) -> Field {
        let at = |v: usize| {
            let (x, y) = (v / fine.columns, v % fine.columns);
            let i = (x / stride).min(self.cells() - 1);
            let j = (y / stride).min(self.columns - 2);
            let u = (x - i * stride) as f32 / stride as f32;
            let w = (y - j * stride) as f32 / stride as f32;
            let next = (i + 1) % self.rows;
            let corner = |i: usize, j: usize| field[i * self.columns + j];
            metric::bilinear([corner(i, j), corner(next, j), corner(i, j + 1), corner(next, j + 1)], u, w)
        };
        (0..fine.rows * fine.columns).map(at).collect()
    }
}

/// A thin sheet in the shape of a body.
#[derive(Debug, Clone)]
pub struct Sheet {
    fine: Grid,
    pub grid: Grid,
    pub stride: usize,
    pub vertices: Vec<[f32; 3]>,
    pub triangles: Vec<[u32; 3]>,
    pub rim: Vec<u32>,
    /// Of each vertex, kg.
    pub masses: Vec<f32>,
}

impl Sheet {
    pub fn new(body: &Body, stride: usize) -> Self {
        let fine = Grid::of(body);
        let grid = fine.coarsened(stride);
        let vertices: Vec<_> = grid.picked(fine, stride).map(|v| body.vertices[v]).collect();
        let triangles = grid.triangles();
        // kg/m²: density times thickness (lab/data/README.md).
        let areal = match body.truth {
            Truth::Shots | Truth::Structure | Truth::Dense => 7800.0 * 0.003,
            Truth::Presses => 7850.0 * 0.002,
            Truth::Steel => 7850.0 * 0.0008,
        };
        let masses = lumped(&vertices, &triangles, areal);
        Self { fine, grid, stride, rim: grid.rim(), vertices, triangles, masses }
    }

    /// A field of this sheet at the truth's vertices.
    pub fn at_truth(&self, field: &[[f32; 3]]) -> Field {
        self.grid.refine(field, self.fine, self.stride)
    }

    /// The truth's field at this sheet's vertices.
    pub fn of_truth(&self, field: &[[f32; 3]]) -> Field {
        self.grid.picked(self.fine, self.stride).map(|v| field[v]).collect()
    }

    pub fn inverted(&self, field: &[[f32; 3]]) -> usize {
        metric::inverted(field, &self.vertices, &self.triangles)
    }

    /// Longest diagonal of the bounding box, m.
    pub fn diagonal(&self) -> f64 {
        let extent = |k: usize| {
            let values = self.vertices.iter().map(|p| p[k]);
            values.clone().fold(f32::MIN, f32::max) - values.fold(f32::MAX, f32::min)
        };
        metric::length([0, 1, 2].map(extent))
    }
}

/// A third of the mass of its triangles for each vertex.
fn lumped(vertices: &[[f32; 3]], triangles: &[[u32; 3]], areal: f64) -> Vec<f32> {
    let mut masses = vec![0.0f32; vertices.len()];
    for t in triangles {
        let [a, b, c] = t.map(|v| vertices[v as usize]);
        let (u, v) = (metric::sub(b, a), metric::sub(c, a));
        let squared = metric::dot64(u, u) * metric::dot64(v, v) - metric::dot64(u, v).powi(2);
        let area = 0.5 * squared.max(0.0).sqrt();
        for corner in t {
            masses[*corner as usize] += (area * areal / 3.0) as f32;
        }
    }
    masses
}

/// How far a peer's dent is from the truth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FieldError {
    pub relative_l2: f64,
    /// After one factor gave the contact the true displacement, which our method is told.
    pub scaled_relative_l2: f64,
    pub max_mm: f64,
}

/// Errors at the truth's vertices. What is not finite is infinitely wrong; a dent under a twentieth of the true one cannot
/// be scaled and counts as no dent at all (1).
pub fn field_error(field: &[[f32; 3]], truth: &[[f32; 3]], contact: usize) -> FieldError {
    if field.iter().flatten().any(|x| !x.is_finite()) {
        return FieldError { relative_l2: f64::INFINITY, scaled_relative_l2: f64::INFINITY, max_mm: f64::INFINITY };
    }
    let (got, asked) = (field[contact].map(f64::from), truth[contact].map(f64::from));
    let along = metric::dot64(got, asked);
    let scaled_relative_l2 = if along > 0.05 * metric::dot64(asked, asked) {
        let factor = (along / metric::dot64(got, got)) as f32;
        let scaled: Field = field.iter().map(|u| u.map(|x| x * factor)).collect();
        metric::relative_l2(&scaled, truth)
    } else {
        1.0
    };
    FieldError {
        relative_l2: metric::relative_l2(field, truth),
        scaled_relative_l2,
        max_mm: metric::max_error_mm(field, truth),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_finest_sheet_is_the_truths_own() {
        for body in Truth::SMOOTH_BODIES.map(|b| Body::read(Truth::Shots, b).unwrap()) {
            let sheet = Sheet::new(&body, 1);
            assert_eq!(sheet.vertices, body.vertices);
            assert_eq!(sheet.triangles, body.triangles);
            let pinned: Vec<u32> = (0..body.vertices.len() as u32).filter(|v| body.pinned[*v as usize]).collect();
            assert_eq!(sheet.rim, pinned);
            assert_eq!(sheet.at_truth(&body.heldout[0].field), body.heldout[0].field);
        }
    }

    #[test]
    fn a_coarse_sheet_weighs_the_same_and_reads_back_what_is_linear() {
        for body in Truth::SMOOTH_BODIES.map(|b| Body::read(Truth::Presses, b).unwrap()) {
            let weight = |s: &Sheet| s.masses.iter().sum::<f32>();
            let (fine, coarse) = (Sheet::new(&body, 1), Sheet::new(&body, 4));
            assert!((weight(&coarse) / weight(&fine) - 1.0).abs() < 0.03);
            let columns = body.grid[1] as f32;
            let slope: Field = (0..body.vertices.len()).map(|v| [(v % body.grid[1]) as f32 / columns; 3]).collect();
            let back = coarse.at_truth(&coarse.of_truth(&slope));
            assert!(metric::max_error_mm(&back, &slope) < 1e-3);
        }
    }

    #[test]
    fn scaling_forgives_depth_and_not_shape() {
        let truth = [[0.0, 0.0, -0.02], [0.0, 0.0, -0.01]];
        let deeper = truth.map(|u| u.map(|x| 3.0 * x));
        let error = field_error(&deeper, &truth, 0);
        assert!(error.scaled_relative_l2 < 1e-6 && (error.relative_l2 - 2.0).abs() < 1e-6);
        assert_eq!(field_error(&[[0.0; 3]; 2], &truth, 0).scaled_relative_l2, 1.0);
        assert_eq!(field_error(&[[f32::NAN; 3]; 2], &truth, 0).relative_l2, f64::INFINITY);
    }
}
