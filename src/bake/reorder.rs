//! Sorts vertices into a spatially coherent order, so that vertices that move together lie in the same blocks.

use crate::base::math::Aabb;
use crate::example::data::{Contact, Deltas, ExampleData};
use crate::mesh::data::MeshData;
use glam::Vec3;

/// Bits per coordinate of a Morton code.
const BITS: u32 = 21;

/// Reorders the vertices of a mesh and its examples so that neighbours in space are neighbours in memory. Returns the
/// old index of each vertex: the new vertex `v` was `order[v]`.
///
/// Sets store displacements in blocks of 128 consecutive vertices. After reordering a dent touches fewer blocks, which
/// makes files smaller and deformation faster. You must reorder your own vertex buffers, and vertex masses if any, in
/// the same way. Triangles keep their order. Vertices at one position keep their relative order.
///
/// Indices out of range and arrays of the wrong length are left unchanged;
/// [`ExampleSet::build`](crate::ExampleSet::build) rejects them.
pub fn reorder(mesh: &mut MeshData, examples: &mut [ExampleData]) -> Vec<u32> {
    let order = morton(&mesh.positions);
    let mut new_of = vec![0; order.len()];
    for (new, old) in (0..).zip(&order) {
        new_of[*old as usize] = new;
    }
    let renumber = |v: &mut u32| *v = new_of.get(*v as usize).copied().unwrap_or(*v);
    permute(&mut mesh.positions, &order);
    mesh.normals.iter_mut().for_each(|n| permute(n, &order));
    mesh.tangents.iter_mut().for_each(|t| permute(t, &order));
    [&mut mesh.depth_limits, &mut mesh.stiffness].into_iter().flatten().for_each(|x| permute(x, &order));
    mesh.triangles.iter_mut().flatten().for_each(renumber);
    for e in examples {
        for deltas in [Some(&mut e.positions), e.normals.as_mut()].into_iter().flatten() {
            match deltas {
                Deltas::Full(d) => permute(d, &order),
                // Indices that do not increase are left alone: sorting would hide the error.
                Deltas::Sparse { indices, values }
                    if indices.len() == values.len() && indices.is_sorted_by(|a, b| a < b) =>
                {
                    let mut pairs: Vec<(u32, [f32; 3])> = indices.iter().copied().zip(values.iter().copied()).collect();
                    pairs.iter_mut().for_each(|p| renumber(&mut p.0));
                    pairs.sort_by_key(|p| p.0);
                    (*indices, *values) = pairs.into_iter().unzip();
                }
                Deltas::Sparse { .. } => {}
            }
        }
        if let Some(Contact::Vertex(v)) = &mut e.contact {
            renumber(v);
        }
    }
    order
}

fn permute<T: Copy>(values: &mut Vec<T>, order: &[u32]) {
    if values.len() == order.len() {
        *values = order.iter().map(|v| values[*v as usize]).collect();
    }
}

/// Vertices sorted by the Morton code of their position.
fn morton(positions: &[[f32; 3]]) -> Vec<u32> {
    let bounds = Aabb::of(positions.iter().map(|p| Vec3::from_array(*p)).collect::<Vec<_>>().iter());
    let extent = (bounds.max.as_dvec3() - bounds.min.as_dvec3()).max_element();
    let scale = if extent > 0.0 { f64::from((1u32 << BITS) - 1) / extent } else { 0.0 };
    let code = |p: &[f32; 3]| {
        let at = (Vec3::from_array(*p).as_dvec3() - bounds.min.as_dvec3()) * scale;
        // `as` saturates values out of range and maps NaN to 0.
        let [x, y, z] = at.to_array().map(|x| spread(x as u32));
        x | y << 1 | z << 2
    };
    let mut keys: Vec<(u64, u32)> = positions.iter().map(code).zip(0..).collect();
    keys.sort_unstable();
    keys.into_iter().map(|k| k.1).collect()
}

/// Spreads the low 21 bits: two zero bits follow each.
fn spread(x: u32) -> u64 {
    let mut x = u64::from(x) & 0x1F_FFFF;
    for (shift, mask) in [
        (32, 0x001F_0000_0000_FFFF),
        (16, 0x001F_0000_FF00_00FF),
        (8, 0x100F_00F0_0F00_F00F),
        (4, 0x10C3_0C30_C30C_30C3),
        (2, 0x1249_2492_4924_9249),
    ] {
        x = (x | x << shift) & mask;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scattered() -> (MeshData, Vec<ExampleData>) {
        // A plane of 32 by 32 vertices in scattered order.
        let at = |i: u32| (i * 389) % 1024;
        let positions: Vec<[f32; 3]> = (0..1024).map(|i| [(at(i) % 32) as f32, (at(i) / 32) as f32, 0.0]).collect();
        let near = |p: &[f32; 3]| (p[0] - 8.0).hypot(p[1] - 20.0) < 5.0;
        let full = positions.iter().map(|p| if near(p) { [0.0, 0.0, p[0]] } else { [0.0; 3] }).collect();
        let indices: Vec<u32> = (0..1024).filter(|v| near(&positions[*v as usize])).collect();
        let values = indices.iter().map(|v| [0.0, 0.0, positions[*v as usize][0]]).collect();
        let contact = indices[3];
        let mesh = MeshData {
            normals: Some(positions.clone()),
            positions,
            triangles: vec![[5, 9, 1023]],
            ..Default::default()
        };
        let sparse = ExampleData {
            contact: Some(Contact::Vertex(contact)),
            ..ExampleData::new("sparse", Deltas::Sparse { indices, values })
        };
        (mesh, vec![ExampleData::new("full", Deltas::Full(full)), sparse])
    }

    #[test]
    fn everything_follows_its_vertex() {
        let (old, old_examples) = scattered();
        let (mut mesh, mut examples) = scattered();
        let order = reorder(&mut mesh, &mut examples);
        for (new, old_v) in order.iter().enumerate() {
            assert_eq!(mesh.positions[new], old.positions[*old_v as usize]);
            assert_eq!(mesh.normals.as_ref().unwrap()[new], old.normals.as_ref().unwrap()[*old_v as usize]);
        }
        assert_eq!(mesh.triangles[0].map(|v| order[v as usize]), [5, 9, 1023]);
        let (Deltas::Full(f), Deltas::Full(g)) = (&examples[0].positions, &old_examples[0].positions) else { panic!() };
        assert!(order.iter().enumerate().all(|(new, v)| f[new] == g[*v as usize]));
        let Deltas::Sparse { indices, values } = &examples[1].positions else { panic!() };
        assert!(indices.is_sorted());
        assert!(indices.iter().zip(values).all(|(v, d)| f[*v as usize] == *d));
        let Some(Contact::Vertex(c)) = examples[1].contact else { panic!() };
        let Some(Contact::Vertex(d)) = old_examples[1].contact else { panic!() };
        assert_eq!(order[c as usize], d);
        // The dent of 80 vertices lies in few blocks.
        let blocks: std::collections::BTreeSet<u32> = indices.iter().map(|v| v / 128).collect();
        assert!(blocks.len() <= 4, "{blocks:?}");
    }

    #[test]
    fn what_does_not_fit_is_left_for_building_to_refuse() {
        let mut mesh = MeshData {
            positions: vec![[f32::NAN; 3], [1.0; 3], [f32::INFINITY; 3]],
            normals: Some(vec![[0.0; 3]]),
            triangles: vec![[0, 1, 77]],
            ..Default::default()
        };
        let deltas = Deltas::Sparse { indices: vec![2, 1, 90], values: vec![[0.0; 3]] };
        let mut order = reorder(&mut mesh, &mut [ExampleData::new("", deltas)]);
        assert_eq!(mesh.triangles[0][2], 77);
        order.sort_unstable();
        assert_eq!(order, [0, 1, 2]);
        assert!(reorder(&mut MeshData::default(), &mut []).is_empty());
    }
}
