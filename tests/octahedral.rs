//! Octahedral normals and tangents: the bits that Godot writes, and the vectors that they stand for.

use crumple::glam::{DVec3, Vec3};
use crumple::{MeshData, Serial, SetOptions, SimdLevel, Tracker, VertexMemory};
use scenes::{Dice, octahedral_normal, octahedral_tangent};

mod scenes;

/// The unit vector that two numbers stand for, by folding the square to an octahedron.
fn decoded([x, y]: [f64; 2]) -> DVec3 {
    let (x, y) = (x * 2.0 - 1.0, y * 2.0 - 1.0);
    let z = 1.0 - x.abs() - y.abs();
    let folded = (-z).max(0.0);
    DVec3::new(x - folded.copysign(x), y - folded.copysign(y), z).normalize()
}

fn degrees(a: DVec3, b: &[f32]) -> f64 {
    let b = Vec3::from_slice(b).as_dvec3();
    a.cross(b).length().atan2(a.dot(b)).to_degrees()
}

/// Checks packed vectors against floats, and returns the largest angle of the normals and of the tangents.
fn check(normals: &[[f32; 3]], packed: &[[u16; 2]], tangents: &[[f32; 4]], packed_tangents: &[[u16; 2]]) -> [f64; 2] {
    let mut worst = [0.0f64; 2];
    for (v, (n, words)) in normals.iter().zip(packed).enumerate() {
        assert_eq!(*words, octahedral_normal(*n), "vertex {v}: {n:?}");
        worst[0] = worst[0].max(degrees(decoded(words.map(|w| f64::from(w) / 65535.0)), n));
    }
    for (v, (t, words)) in tangents.iter().zip(packed_tangents).enumerate() {
        assert_eq!(*words, octahedral_tangent(*t), "vertex {v}: {t:?}");
        let [x, y] = words.map(|w| f64::from(w) / 65535.0);
        let y = y * 2.0 - 1.0;
        assert_eq!(y > 0.0, t[3] >= 0.0, "vertex {v}: {t:?} {words:?}");
        worst[1] = worst[1].max(degrees(decoded([x, y.abs()]), t));
    }
    worst
}

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
        let [normal, tangent] = check(&base, &n, &base_tangents, &t);
        assert!(normal < 0.0075 && tangent < 0.0115, "{level:?}: off by {normal} and {tangent} degrees");
        // The bounds are not loose.
        assert!(normal > 0.006 && tangent > 0.009, "{level:?}: off by only {normal} and {tangent} degrees");
    }
}
