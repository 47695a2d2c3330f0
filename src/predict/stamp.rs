//! Frames of contacts, and a field resampled into a grid there.

use super::linear::Banded;
use crate::base::math::{small_floor, small_whole, transposed, within_one};
use crate::basis::field::{GROUP, Group, side_by_side};
use glam::{DMat3, DVec3, Vec3, Vec4};

/// Nodes of the grid a side.
pub(super) const SIDE: usize = 29;
/// Numbers of a stamp: three for each node.
pub(super) const STAMP: usize = SIDE * SIDE * 3;
/// The grid is densest at the contact: node spacing grows with distance from this one on, as a share of the diagonal.
const NEAR: f64 = 0.15;
/// The grid ends there, as a share of the diagonal.
const END: f64 = 0.75;
/// Weight of smoothness against agreement with the field, and of smallness against smoothness.
const SMOOTH: f64 = 1e-3;
const SMALL: f64 = 0.2;
/// Points whose normals have less of the contact's than this are on the other side; above `FRONT` they count fully.
const BACK: f32 = -0.3;
const FRONT: f32 = -0.1;

/// Turns the frame of one contact into that of another: rotations with the contact's normal as third column.
///
/// If normals of the body have a mean direction, a frame is the smallest rotation from that direction. Otherwise (drums)
/// its first axis is the projection of the coordinate axis along which the fewest normals point.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Frames {
    /// The mean direction, or 0.
    mean: DVec3,
    /// Index of a coordinate axis.
    axis: usize,
}

impl Frames {
    pub(super) fn of(normals: &[Vec3]) -> Self {
        let (mut sum, mut along) = (DVec3::ZERO, DVec3::ZERO);
        for n in normals {
            sum += n.as_dvec3();
            along += n.as_dvec3().abs();
        }
        let count = normals.len().max(1) as f64;
        let mut mean = sum / count;
        // Symmetric bodies: rounding must not tilt the mean.
        mean = DVec3::select(mean.abs().cmplt(DVec3::splat(1e-3)), DVec3::ZERO, mean);
        let least = |v: DVec3| (0..3).fold(0, |best, k| if v[k] < v[best] - 1e-6 { k } else { best });
        if mean.length() > 0.3 {
            let mean = mean / mean.length();
            Self { mean, axis: least(mean.abs()) }
        } else {
            Self { mean: DVec3::ZERO, axis: least(along) }
        }
    }

    /// The frame at a unit normal.
    pub(super) fn at(&self, normal: Vec3) -> DMat3 {
        let n = normal.as_dvec3();
        let n = if n.length() > 0.0 { n / n.length() } else { DVec3::Z };
        let first = |axis: usize, n: DVec3| {
            let a = DVec3::AXES[axis];
            let e = a - n * n.dot(a);
            e / e.length()
        };
        if self.mean == DVec3::ZERO {
            let axis = if n[self.axis].abs() < 0.95 { self.axis } else { (self.axis + 1) % 3 };
            let e = first(axis, n);
            return DMat3::from_cols(e, n.cross(e), n);
        }
        let m = self.mean;
        let e = first(self.axis, m);
        let frame = DMat3::from_cols(e, m.cross(e), m);
        let c = m.dot(n);
        if c < -0.999 {
            return DMat3::from_cols(e, n.cross(e), n);
        }
        let v = m.cross(n);
        let turn = |x: DVec3| x * c + v.cross(x) + v * (v.dot(x) / (1.0 + c));
        DMat3::from_cols(turn(frame.x_axis), turn(frame.y_axis), turn(frame.z_axis))
    }
}

/// Successive points, side by side. What is missing of the last group is infinitely far away.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Places {
    /// m.
    pub points: Group,
    /// Unit normals, out of the body; zero where there is none.
    pub normals: Group,
    /// How much of what is carried to each point it takes: 1, and less towards held rims.
    pub held: [f32; GROUP],
}

impl Places {
    /// Points with as many normals, and the shares that they take of what is carried to them (none: all of it).
    pub(super) fn of(points: &[Vec3], normals: &[Vec3], held: &[f32]) -> Vec<Self> {
        let places = (0..points.len()).step_by(GROUP).map(|first| Places {
            points: side_by_side(&points[first..], Vec3::INFINITY),
            normals: side_by_side(&normals[first..], Vec3::ZERO),
            held: std::array::from_fn(|i| held.get(first + i).copied().unwrap_or(1.0)),
        });
        places.collect()
    }
}

/// A contact, from which points are seen in the grid.
#[derive(Debug, Clone, Copy)]
pub(super) struct View {
    pub contact: Vec3,
    normal: Vec3,
    /// Columns are the frame.
    frame: glam::Mat3,
    near: f32,
    scale: f32,
}

/// Where a group of points lies in the grid.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cells {
    /// The node with the smallest coordinates; the others are 1, `SIDE` and `SIDE + 1` further.
    pub node: [i32; GROUP],
    /// The weights of each of the four nodes; their sum is below 1 near the other side of the body, and 0 there and outside.
    pub weights: [[f32; GROUP]; 4],
}

impl View {
    /// `wide` stretches the grid.
    pub(super) fn new(frames: &Frames, contact: Vec3, normal: Vec3, diagonal: f64, wide: f64) -> Self {
        let near = NEAR * diagonal * wide;
        let end = END / (END + NEAR);
        let scale = (SIDE - 1) as f64 / (2.0 * end);
        Self { contact, normal, frame: frames.at(normal).as_mat3(), near: near as f32, scale: scale as f32 }
    }

    /// The places of a group of points in the grid.
    #[inline(always)]
    pub(super) fn cells(&self, places: &Places) -> Cells {
        let mut cells = Cells { node: [0; GROUP], weights: [[0.0; GROUP]; 4] };
        let (contact, normal) = (self.contact, self.normal);
        let (x_axis, y_axis, z_axis) = (self.frame.x_axis, self.frame.y_axis, self.frame.z_axis);
        let (near, scale) = (self.near, self.scale);
        let flat = 1e-10 * near * near;
        let last = (SIDE - 1) as f32;
        let [px, py, pz] = &places.points;
        let [nx, ny, nz] = &places.normals;
        let [w0, w1, w2, w3] = &mut cells.weights;
        for i in 0..GROUP {
            let (rx, ry, rz) = (px[i] - contact.x, py[i] - contact.y, pz[i] - contact.z);
            let x = rx * x_axis.x + ry * x_axis.y + rz * x_axis.z;
            let y = rx * y_axis.x + ry * y_axis.y + rz * y_axis.z;
            let z = rx * z_axis.x + ry * z_axis.y + rz * z_axis.z;
            // The surface around the contact, unrolled on a plane.
            let square = x * x + y * y;
            let steep = z * z / if square > flat { square } else { flat };
            let unroll = 1.0 + 0.5 * if steep < 2.0 { steep } else { 2.0 };
            let (x, y) = (x * unroll, y * unroll);
            let a = x / (x.abs() + near) * scale + 0.5 * last;
            let b = y / (y.abs() + near) * scale + 0.5 * last;
            // Not for NaN.
            let is_inside = (a > 0.0) & (b > 0.0) & (a < last) & (b < last);
            let along = nx[i] * normal.x + ny[i] * normal.y + nz[i] * normal.z;
            let facing = within_one((along - BACK) / (FRONT - BACK));
            // Points without a normal are on both sides.
            let is_flat = (nx[i] == 0.0) & (ny[i] == 0.0) & (nz[i] == 0.0);
            let f = if is_flat { 1.0 } else { facing };
            let f = if is_inside { f } else { 0.0 };
            // Elsewhere the first node.
            let a = if is_inside { a } else { 0.0 };
            let b = if is_inside { b } else { 0.0 };
            let (row, column) = (small_floor(a), small_floor(b));
            let (u, v) = (a - row, b - column);
            w0[i] = f * (1.0 - u) * (1.0 - v);
            w1[i] = f * (1.0 - u) * v;
            w2[i] = f * u * (1.0 - v);
            w3[i] = f * u * v;
            cells.node[i] = small_whole(row * SIDE as f32 + column);
        }
        cells
    }

    /// The grid whose bilinear mean is nearest to the field (`STAMP` numbers in the frame of the contact), smooth where
    /// there are no points.
    pub(super) fn resample(&self, places: &[Places], field: impl Fn(usize) -> Vec3) -> Vec<f32> {
        let nodes = SIDE * SIDE;
        let mut matrix = Banded::new(nodes, 2 * SIDE);
        let mut right = vec![[0.0f64; 3]; nodes];
        for (first, places) in (0..).step_by(GROUP).zip(places) {
            let cells = self.cells(places);
            for i in (0..GROUP).filter(|i| cells.weights.iter().any(|w| w[*i] > 0.0)) {
                let u = self.frame.transpose() * field(first + i);
                let at = [0, 1, SIDE, SIDE + 1].map(|k| cells.node[i] as usize + k);
                let weights = cells.weights.map(|w| f64::from(w[i]));
                for a in 0..4 {
                    (0..3).for_each(|c| right[at[a]][c] += weights[a] * f64::from(u[c]));
                    (0..=a).for_each(|b| matrix.add(at[a], at[b], weights[a] * weights[b]));
                }
            }
        }
        // Squared second differences along both axes.
        for i in 0..SIDE {
            for j in 1..SIDE - 1 {
                for (low, mid, high) in [
                    (i * SIDE + j - 1, i * SIDE + j, i * SIDE + j + 1),
                    ((j - 1) * SIDE + i, j * SIDE + i, (j + 1) * SIDE + i),
                ] {
                    let terms = [(low, 1.0), (mid, -2.0), (high, 1.0)];
                    for (k, (a, x)) in terms.iter().enumerate() {
                        terms[..=k].iter().for_each(|(b, y)| matrix.add(*a, *b, SMOOTH * x * y));
                    }
                }
            }
        }
        (0..nodes).for_each(|k| matrix.add(k, k, SMOOTH * SMALL));
        matrix.solve(&mut right);
        right.iter().flatten().map(|x| *x as f32).collect()
    }

    /// A stamp in the space of the body, one vector for each node, times `k`.
    pub(super) fn turned(&self, stamp: &[f32], k: f32, out: &mut Vec<Vec4>) {
        let frame = self.frame * k;
        out.clear();
        out.extend(stamp.as_chunks::<3>().0.iter().map(|u| (frame * Vec3::from_array(*u)).extend(0.0)));
    }
}

/// A turned stamp's displacements at the cells.
#[inline(always)]
pub(super) fn read(turned: &[Vec4], cells: &Cells) -> Group {
    let mut out = [[0.0; GROUP]; 3];
    for i in (0..GROUP).step_by(4) {
        let four = [
            read_one(turned, cells, i),
            read_one(turned, cells, i + 1),
            read_one(turned, cells, i + 2),
            read_one(turned, cells, i + 3),
        ];
        let [x, y, z, _] = transposed(four);
        x.write_to_slice(&mut out[0][i..]);
        y.write_to_slice(&mut out[1][i..]);
        z.write_to_slice(&mut out[2][i..]);
    }
    out
}

/// At one of the cells; the last number is 0.
#[inline(always)]
fn read_one(turned: &[Vec4], cells: &Cells, i: usize) -> Vec4 {
    let [a, b, c, d] = &cells.weights;
    let k = cells.node[i] as usize;
    let (low, high) = (&turned[k..k + 2], &turned[k + SIDE..k + SIDE + 2]);
    (low[0] * a[i] + low[1] * b[i]) + (high[0] * c[i] + high[1] * d[i])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_rotations_with_the_normal_as_third_axis() {
        for normals in [vec![Vec3::Z, Vec3::X], vec![Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y]] {
            let frames = Frames::of(&normals);
            for n in [Vec3::X, Vec3::Y, -Vec3::Z, Vec3::new(0.6, -0.48, 0.64)] {
                let f = frames.at(n);
                assert!((f.determinant() - 1.0).abs() < 1e-9 && (f.z_axis - n.as_dvec3()).length() < 1e-6, "{n}");
            }
        }
    }

    #[test]
    fn a_field_is_read_back_at_its_own_contact() {
        let points: Vec<Vec3> = (0..41 * 41).map(|k| Vec3::new((k / 41) as f32, (k % 41) as f32, 0.0) / 40.0).collect();
        let normals = vec![Vec3::Z; points.len()];
        let centre = Vec3::new(0.4, 0.55, 0.0);
        let field = |v: usize| Vec3::new(0.0, 0.002, -0.03) * (-40.0 * (points[v] - centre).length_squared()).exp();
        let view = View::new(&Frames::of(&normals), centre, Vec3::Z, 2f64.sqrt(), 1.0);
        let places = Places::of(&points, &normals, &[]);
        let stamp = view.resample(&places, field);
        let mut turned = Vec::new();
        view.turned(&stamp, 1.0, &mut turned);
        let read: Vec<Group> = places.iter().map(|at| read(&turned, &view.cells(at))).collect();
        let mut sums = (0.0, 0.0);
        for v in 0..points.len() {
            let read = Vec3::from([0, 1, 2].map(|k| read[v / GROUP][k][v % GROUP]));
            sums.0 += (read - field(v)).length_squared();
            sums.1 += field(v).length_squared();
        }
        assert!(sums.0 < 0.02 * 0.02 * sums.1, "{}", (sums.0 / sums.1).sqrt());
    }
}
