//! The wear of vertices: its definition, and where it is 0.

use crumple::{Deltas, ExampleData, Hit, Placement, SetOptions};
use glam::Vec3;
use scenes::Output;

mod scenes;

/// The four numbers by their definition, in double precision.
fn defined(base: Vec3, normal: Vec3, position: Vec3, turned: Vec3) -> [f64; 4] {
    let (u, n, t) = ((position - base).as_dvec3(), normal.as_dvec3(), turned.as_dvec3());
    [u.length(), 1.0 - n.dot(t), (-u.dot(n)).max(0.0), u.reject_from(n).length()]
}

#[test]
fn wear_is_as_defined_and_zero_where_nothing_is_dented() {
    for (name, set) in scenes::small_bodies() {
        let mut instance = scenes::new(&set);
        assert!(Output::fresh(&mut instance).wear.iter().all(|w| w.map(f32::to_bits) == [0; 4]), "{name}");
        for hit in scenes::random_hits(&set, 3, 5) {
            instance.submit(&hit).unwrap();
        }
        let out = Output::fresh(&mut instance);
        let (base, normals) = (set.mesh().positions(), set.mesh().normals().unwrap());
        let mut dented = 0;
        for v in 0..set.vertex_count() {
            let (position, turned, wear) = (Vec3::from(out.positions[v]), Vec3::from(out.normals[v]), out.wear[v]);
            let expected = defined(base[v], normals[v], position, turned);
            for (is, ought) in wear.iter().zip(expected) {
                assert!((f64::from(*is) - ought).abs() < 1e-6, "{name}, vertex {v}: {wear:?}, not {expected:?}");
                assert!(*is >= 0.0, "{name}, vertex {v}: {wear:?}");
            }
            let moved = position != base[v];
            assert_eq!(wear[0] > 0.0, moved, "{name}, vertex {v}");
            if !moved && turned == normals[v] {
                assert_eq!(wear.map(f32::to_bits), [0; 4], "{name}, vertex {v}");
            }
            dented += usize::from(moved);
        }
        assert!(dented > 0, "{name}");
    }
}

/// A flat sheet of which one vertex is moved by (3, 0, -4) mm: 5 mm in all, 4 mm inwards, 3 mm along the surface.
#[test]
fn wear_of_a_known_dent() {
    let mesh = scenes::sheet(4);
    let at = mesh.positions[7];
    for with_normals in [true, false] {
        let mut mesh = mesh.clone();
        if !with_normals {
            (mesh.normals, mesh.tangents, mesh.triangles) = (None, None, Vec::new());
        }
        let deltas = Deltas::Sparse { indices: vec![7], values: vec![[0.003, 0.0, -0.004]] };
        let example = ExampleData { placement: Placement::Anchored, ..ExampleData::new("known", deltas) };
        let set = scenes::build(mesh, vec![example], SetOptions::default());
        let mut instance = scenes::new(&set);
        instance.submit(&Hit::displacement(at, [0.003, 0.0, -0.004])).unwrap();
        let mut out = Output::fresh(&mut instance);
        let [dent, _, press, scrape] = out.wear.remove(7);
        let expected = if with_normals { [0.005, 0.004, 0.003] } else { [0.005, 0.0, 0.0] };
        for (is, ought) in [dent, press, scrape].into_iter().zip(expected) {
            assert!((is - ought).abs() < 1e-6, "{is} is not {ought}");
        }
        assert!(with_normals || out.wear.iter().all(|w| *w == [0.0; 4]));
    }
}
