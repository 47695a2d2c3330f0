//! The meshes of a glTF's nodes are joined to one body with a part for each node.
#![cfg(feature = "gltf")]

mod import_glb;

use crumple::glam::Vec3;
use crumple::import::{Imported, gltf_body, gltf_body_file, gltf_solids};
use crumple::{
    Contact, DeformJob, Deltas, ExampleData, ExampleSet, Hit, Instance, InstanceOptions, Placement, Serial, SetOptions,
    Solid, Tracker, VertexMemory, deform,
};
use import_glb::{Glb, square};
use serde_json::json;
use std::sync::Arc;

/// Three squares with a common parent: the middle one, one that is turned to lie beside it, and the middle one mirrored to
/// its other side. The turned one meets it only up to rounding.
fn three() -> Glb {
    let mut glb = square();
    let pushed = glb.floats("VEC3", &[0., 0., 0., 0., 0., 0., 0.25, 0., 0., 0., 0., 0.]);
    let middle = glb.json["meshes"][0].clone();
    glb.push("meshes", middle);
    let turned = &mut glb.json["meshes"][1];
    turned["name"] = "Turned".into();
    turned["primitives"][0]["targets"] = json!([{ "POSITION": 3 }, { "POSITION": pushed }]);
    turned["extras"] = json!({
        "targetNames": ["dense", "pushed"],
        "impacts": [{ "name": "pushed", "point": [0.9, 0, 0.9], "normal": [1, 0, 0], "impulse": [2, 0, 0] }],
        "placements": { "dense": "anchored" },
    });
    let half = std::f32::consts::FRAC_1_SQRT_2;
    glb.json["nodes"] = json!([
        { "translation": [0.1, 0, 0], "children": [1, 2, 3] },
        { "mesh": 0, "name": "hood" },
        { "mesh": 1, "rotation": [0, half, 0, half], "translation": [1, 0, 1] },
        { "mesh": 0, "name": "mirrored", "scale": [-1, 1, 1] },
    ]);
    glb
}

fn body() -> Imported {
    gltf_body(&three().bytes(), None).unwrap()
}

fn sparse(example: &ExampleData) -> (&[u32], &[[f32; 3]]) {
    let Deltas::Sparse { indices, values } = &example.positions else { panic!("sparse") };
    (indices, values)
}

fn near(a: [f32; 3], b: [f32; 3]) -> bool {
    Vec3::from(a).distance(Vec3::from(b)) < 1e-6
}

#[test]
fn each_node_is_a_part_where_the_node_places_it() {
    let body = body();
    let names: Vec<&str> = body.parts.iter().map(|part| part.name.as_str()).collect();
    assert_eq!(names, ["hood", "Turned", "mirrored"]);
    let corners = [[0.1, 1.1, 1.1, 0.1], [1.1, 2.1, 2.1, 1.1], [0.1, -0.9, -0.9, 0.1]];
    for (part, corners) in body.parts.iter().zip(corners) {
        let own = &body.mesh.positions[part.vertices()];
        let mut xs: Vec<f32> = own.iter().map(|p| p[0]).collect();
        xs.sort_by(f32::total_cmp);
        let mut expected = corners;
        expected.sort_by(f32::total_cmp);
        assert!(xs.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{}: {xs:?}", part.name);
    }
    assert!(body.mesh.normals.as_ref().unwrap().iter().all(|n| near(*n, [0.0, 1.0, 0.0])));
    // A mirrored mesh has its triangles turned over, so all face the same way.
    for t in &body.mesh.triangles {
        let [a, b, c] = t.map(|v| Vec3::from(body.mesh.positions[v as usize]));
        assert!((b - a).cross(c - a).y > 0.9, "{t:?}");
    }
    assert_eq!(body.node_transform, None);
}

#[test]
fn targets_of_one_name_are_one_example_in_the_scenes_space() {
    let body = body();
    let names: Vec<&str> = body.examples.iter().map(|e| e.name.as_str()).collect();
    assert_eq!(names, ["dense", "sparse", "pushed"]);
    let [dense, sparse_, pushed] = &body.examples[..] else { panic!("three") };
    assert_eq!(sparse(dense).0, [0, 2, 4, 6, 8, 10]);
    assert_eq!(sparse(sparse_).0, [1, 3, 9, 11]);
    let (indices, values) = sparse(pushed);
    assert_eq!(indices, [6]);
    assert!(near(values[0], [0.0, 0.0, -0.25]), "turned with its node: {values:?}");
    let Some(Contact::Point(point)) = pushed.contact else { panic!("a point") };
    assert!(near(point, [2.0, 0.0, 0.1]) && near(pushed.contact_normal.unwrap(), [0.0, 0.0, -1.0]));
    assert!(near(pushed.blow.impulse.unwrap(), [0.0, 0.0, -2.0]));
    assert_eq!((dense.placement, pushed.placement), (Placement::Anchored, Placement::Automatic));
}

#[test]
fn seams_between_nodes_have_the_same_bits_and_stay_closed() {
    let body = body();
    let parts = body.part_meshes();
    let mut set = ExampleSet::build(body.mesh, body.examples, SetOptions::default(), &Serial).unwrap();
    for (n, part) in parts.into_iter().enumerate() {
        assert_eq!(set.add_lod(part, &Serial).unwrap(), n + 1);
    }
    let mut instance = Instance::new(Arc::new(set), InstanceOptions::default()).unwrap();
    instance.submit(&Hit::displacement([1.1, 0.0, 0.0], [0.0, -0.2, 0.05])).unwrap();
    instance.fold();
    let mut shown = [[[0.0f32; 3]; 4]; 4];
    for (lod, positions) in shown.iter_mut().enumerate().skip(1) {
        let memory = VertexMemory::separate(positions, None, None).unwrap();
        let mut tracker = Tracker::new();
        deform(&mut [DeformJob { lod, instance: &instance, tracker: &mut tracker, memory }], &Serial).unwrap();
    }
    let common = |a: usize, b: usize| shown[a].iter().filter(|p| shown[b].contains(p)).count();
    assert_eq!((common(1, 2), common(1, 3), common(2, 3)), (2, 2, 0), "{shown:?}");
    assert!(shown[1].iter().any(|p| p[1] < -0.01), "dented");
}

#[test]
fn what_cannot_be_a_body_is_refused_by_name() {
    let error = |glb: &Glb| gltf_body(&glb.bytes(), None).unwrap_err().to_string();
    let mut glb = three();
    glb.json["meshes"][1]["extras"]["targetNames"] = json!(["dense", "dense"]);
    glb.json["meshes"][1]["extras"]["impacts"] = json!(null);
    assert!(error(&glb).contains("mesh 1 'Turned' has two targets named 'dense'"), "{}", error(&glb));
    let mut glb = three();
    glb.json["nodes"][3]["scale"] = json!([0, 1, 1]);
    assert!(error(&glb).contains("node 3 has no inverse"), "{}", error(&glb));
    let mut glb = three();
    glb.json["nodes"][3]["mesh"] = json!(7);
    assert!(error(&glb).contains('7'), "{}", error(&glb));
    let mut glb = three();
    glb.json["nodes"] = json!([{}]);
    assert!(error(&glb).contains("a node with a mesh"), "{}", error(&glb));
    let mut glb = three();
    glb.json["nodes"] = (0..64).map(|_| json!({ "mesh": 0 })).collect();
    assert!(error(&glb).contains("64 nodes have meshes; a body has at most 63"), "{}", error(&glb));
    let mut glb = three();
    for mesh in 0..2 {
        glb.json["meshes"][mesh]["primitives"][0]["targets"] = json!(null);
        glb.json["meshes"][mesh]["extras"] = json!(null);
    }
    assert!(error(&glb).contains("morph targets"), "{}", error(&glb));
    assert!(gltf_body_file("none.glb".as_ref()).is_err());
}

/// Each mesh was placed by a walk from its node to the root, which took time in proportion to the meshes times the depth.
#[test]
fn solids_of_many_nodes_in_a_deep_tree_are_placed_in_linear_time() {
    const NODES: usize = 30_000;
    let mut glb = square();
    let mesh = json!({ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 2 }] });
    glb.json["meshes"] = vec![mesh; NODES].into();
    let node = |i: usize| match i + 1 {
        NODES => json!({ "mesh": i }),
        // Naming a child twice does not visit it twice.
        next => json!({ "mesh": i, "translation": [0, 1, 0], "children": [next, next] }),
    };
    glb.json["nodes"] = (0..NODES).map(node).collect();
    let solids = gltf_solids(&glb.bytes(), None, None).unwrap();
    let Solid::Mesh { positions, .. } = &solids[NODES - 1] else { panic!("a mesh") };
    assert_eq!(positions[0], [0.0, (NODES - 1) as f32, 0.0]);
}

/// Each vertex was compared with all at its place, and each name of a target with all before it.
#[test]
fn parts_with_all_vertices_at_one_place_and_many_targets_are_joined_in_linear_time() {
    const MANY: usize = 60_000;
    let mut glb = three();
    let heap = glb.floats("VEC3", &vec![0.0; 3 * MANY]);
    let still = json!({ "attributes": { "POSITION": heap } });
    glb.push("meshes", json!({ "primitives": [still] }));
    let targets: Vec<_> = (0..MANY).map(|_| json!({})).collect();
    let square = json!({ "attributes": { "POSITION": 0 }, "indices": 2, "targets": targets });
    glb.push("meshes", json!({ "primitives": [square] }));
    glb.json["nodes"] = json!([{ "mesh": 0 }, { "mesh": 2 }, { "mesh": 2 }, { "mesh": 3 }]);
    let body = gltf_body(&glb.bytes(), None).unwrap();
    assert_eq!((body.parts.len(), body.examples.len()), (4, 2 + MANY));
    assert_eq!(body.mesh.positions[body.parts[2].vertices()], vec![[0.0; 3]; MANY]);
}
