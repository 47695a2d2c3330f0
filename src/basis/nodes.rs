//! Chooses the nodes: vertices spread evenly over the body, and more of them where fields are wrong. A node's mirror images are nodes,
//! so that mirrored examples fit them exactly.

use crate::base::math::cells_around;
use crate::mesh::Mesh;
use crate::mesh::mirror::Images;
use glam::{IVec3, Vec3};
use std::collections::HashMap;

/// Points no two of which are nearer than a distance, found by a grid of cells of that size.
struct Spread<'a> {
    positions: &'a [Vec3],
    /// The least coordinates, so that cells have small numbers.
    origin: Vec3,
    distance: f32,
    cells: HashMap<IVec3, Vec<u32>>,
}

impl<'a> Spread<'a> {
    fn new(mesh: &'a Mesh, distance: f32) -> Self {
        let distance = distance.max(f32::MIN_POSITIVE);
        Spread { positions: mesh.positions(), origin: mesh.bounds().min, distance, cells: HashMap::new() }
    }

    fn cell(&self, v: u32) -> IVec3 {
        ((self.positions[v as usize] - self.origin) / self.distance).floor().as_ivec3()
    }

    /// Whether a point within `distance` (at most the cells' size) is there already.
    fn is_near(&self, v: u32, distance: f32) -> bool {
        let (cell, p) = (self.cell(v), self.positions[v as usize]);
        cells_around(cell)
            .filter_map(|near| self.cells.get(&near))
            .flatten()
            .any(|q| self.positions[*q as usize].distance_squared(p) < distance * distance)
    }

    /// Adds a vertex and its mirror images to the nodes, if none of them is within `distance` of a point that is there already. They
    /// may be nearer to each other: on a thin plate both skins get nodes.
    fn add(&mut self, v: u32, distance: f32, images: &Images, nodes: &mut Vec<u32>) {
        if self.is_near(v, distance) {
            return;
        }
        let mut all: Vec<u32> = std::iter::once(v).chain(images.of(v)).collect();
        // Images in two planes may be one vertex.
        all.sort_unstable();
        all.dedup();
        if all.iter().any(|w| self.is_near(*w, distance)) {
            return;
        }
        all.iter().for_each(|w| self.cells.entry(self.cell(*w)).or_default().push(*w));
        nodes.extend(all);
    }
}

/// Spreads at least `count` nodes evenly over the mesh, or all its positions if there are fewer. Ascending.
pub(crate) fn spread(images: &Images, count: usize) -> Vec<u32> {
    let mesh = images.mesh;
    let own: Vec<u32> = (0..mesh.weld().len() as u32).filter(|v| mesh.weld()[*v as usize] == *v).collect();
    let mut distance = mesh.bounds().diagonal() / 4.0;
    loop {
        let mut spread = Spread::new(mesh, distance);
        let mut nodes = Vec::new();
        own.iter().for_each(|v| spread.add(*v, distance, images, &mut nodes));
        if nodes.len() >= count.min(own.len()) {
            nodes.sort_unstable();
            return nodes;
        }
        // On a surface the number grows by two thirds.
        distance *= if nodes.len() * 4 < count { 0.5 } else { 0.775 };
    }
}

/// Adds nodes where vertices are wrong by more than `tolerance`, the worst first, none nearer to another new one than
/// `spacing` times the distance from its nearest node. `errors` (m) and `distances` (m, from the nearest node) are those of all
/// vertices.
pub(crate) fn refine(images: &Images, nodes: &mut Vec<u32>, errors: &[f32], distances: &[f32], tolerance: f32) {
    /// Of the distance from the nearest node.
    const SPACING: f32 = 1.2;
    let mesh = images.mesh;
    let mut wrong: Vec<u32> = (0..errors.len() as u32)
        .filter(|v| mesh.weld()[*v as usize] == *v && errors[*v as usize] > tolerance && distances[*v as usize] > 0.0)
        .collect();
    wrong.sort_by(|a, b| errors[*b as usize].total_cmp(&errors[*a as usize]).then(a.cmp(b)));
    let longest = wrong.iter().map(|v| distances[*v as usize]).fold(0.0, f32::max);
    let mut new = Spread::new(mesh, SPACING * longest);
    for v in wrong {
        new.add(v, SPACING * distances[v as usize], images, nodes);
    }
    nodes.sort_unstable();
    // An image may have been a node.
    nodes.dedup();
}
