//! Octahedral normals and tangents are the bits that Godot writes. `promises.rs` has those of dents.

use crumple::glam::Vec3;
use crumple::{MeshData, Serial, SetOptions, SimdLevel, Tracker, VertexMemory};
use scenes::{Dice, octahedral_normal, octahedral_tangent};

mod scenes;

/// Directions all over the sphere, the edges of the octahedron among them.
fn directions(count: usize) -> Vec<[f32; 3]> {
    let mut dice = Dice::new(7);
    let edges = (0..64).map(|i| [i, i / 4, i / 16].map(|k| [-1.0, -0.0, 0.0, 1.0][k % 4]));
    let edges: Vec<[f32; 3]> = edges.collect();
    let random = (edges.len()..count).map(|_| dice.vector(1.0));
    let directions = edges.into_iter().chain(random).map(Vec3::from).filter_map(Vec3::try_normalize);
    directions.map(|v| v.to_array()).collect()
}

#[test]
fn an_undamaged_mesh_gets_the_bits_that_godot_gives_it() {
    let normals = directions(40_000);
    let count = normals.len();
    let signs = [1.0, -1.0, 0.0];
    let tangents: Vec<[f32; 4]> =
        (0..count).map(|v| (normals[count - 1 - v], signs[v % 3])).map(|([x, y, z], w)| [x, y, z, w]).collect();
    let mesh = MeshData {
        positions: (0..count).map(|v| [(v % 200) as f32 * 0.01, (v / 200) as f32 * 0.01, 0.0]).collect(),
        normals: Some(normals),
        tangents: Some(tangents),
        ..MeshData::default()
    };
    let set = scenes::build(mesh, vec![scenes::poke(0, 0.1)], SetOptions::default());
    let instance = &mut scenes::new(&set);
    let base: Vec<[f32; 3]> = set.mesh().normals().unwrap().iter().map(|n| n.to_array()).collect();
    let base_tangents: Vec<[f32; 4]> = set.mesh().tangents().unwrap().iter().map(|t| t.to_array()).collect();
    for level in SimdLevel::available() {
        level.force().unwrap();
        let (mut p, mut n, mut t) = (vec![[0.0; 3]; count], vec![[7; 2]; count], vec![[7; 2]; count]);
        let memory = VertexMemory::separate(&mut p, None, None).unwrap();
        let memory = memory.with_octahedral_normals(&mut n).with_octahedral_tangents(&mut t);
        instance.deform(&mut Tracker::new(), memory, &Serial).unwrap();
        let of_godot =
            (base.iter().map(|n| octahedral_normal(*n)), base_tangents.iter().map(|t| octahedral_tangent(*t)));
        assert!(n.into_iter().eq(of_godot.0) && t.into_iter().eq(of_godot.1), "{level:?}");
    }
}
