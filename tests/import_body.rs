//! The meshes of a glTF's nodes are joined to one body with a part for each node.
#![cfg(feature = "gltf")]

mod import_glb;
mod scenes;

use crumple::glam::Vec3;
use crumple::import::{Imported, MeshChoice, PartKind, Patterns, Reading, gltf_file, gltf_slice, gltf_solids};
use crumple::{Contact, ExampleSet, Hit, Serial, SetOptions, Solid};
use import_glb::{Glb, sparse, square};
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

fn join(glb: &Glb, nodes: &[&str]) -> Result<Imported, crumple::Error> {
    gltf_slice(&glb.bytes(), None, MeshChoice::Nodes(Patterns::new(nodes)))
}

fn body() -> Imported {
    join(&three(), &[]).unwrap()
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
        let own = &body.mesh.positions[part.vertices.clone()];
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
    assert_eq!(sparse(&dense.positions).0, [0, 2, 4, 6, 8, 10]);
    assert_eq!(sparse(&sparse_.positions).0, [1, 3, 9, 11]);
    let (indices, values) = sparse(&pushed.positions);
    assert_eq!(indices, [6]);
    assert!(near(values[0], [0.0, 0.0, -0.25]), "turned with its node: {values:?}");
    let Some(Contact::Point(point)) = pushed.contact else { panic!("a point") };
    assert!(near(point, [2.0, 0.0, 0.1]) && near(pushed.contact_normal.unwrap(), [0.0, 0.0, -1.0]));
    assert!(near(pushed.blow.impulse.unwrap(), [0.0, 0.0, -2.0]));
}

#[test]
fn seams_between_nodes_have_the_same_bits_and_stay_closed() {
    let body = body();
    let parts = body.part_meshes();
    let mut set = ExampleSet::build(body.mesh, body.examples, SetOptions::default(), &Serial).unwrap();
    for (n, part) in parts.into_iter().enumerate() {
        assert_eq!(set.add_lod(part, &Serial).unwrap(), n + 1);
    }
    let mut instance = scenes::new(&Arc::new(set));
    instance.submit(&Hit::displacement([1.1, 0.0, 0.0], [0.0, -0.2, 0.05])).unwrap();
    let shown = [0, 1, 2, 3].map(|lod| scenes::Output::fresh_level(&mut instance, lod).positions);
    let common = |a: usize, b: usize| shown[a].iter().filter(|p| shown[b].contains(p)).count();
    assert_eq!((common(1, 2), common(1, 3), common(2, 3)), (2, 2, 0), "{shown:?}");
    assert!(shown[1].iter().any(|p| p[1] < -0.01), "dented");
}

#[test]
fn what_cannot_be_a_body_is_refused_by_name() {
    let error = |glb: &Glb| join(glb, &[]).unwrap_err().to_string();
    let mut glb = three();
    glb.json["nodes"][3]["mesh"] = json!(7);
    assert!(error(&glb).contains('7'), "{}", error(&glb));
    let mut glb = three();
    glb.json["nodes"] = json!([{}]);
    assert!(error(&glb).contains("which no node shows"), "{}", error(&glb));
    let mut glb = three();
    for mesh in 0..2 {
        glb.json["meshes"][mesh]["primitives"][0]["targets"] = json!(null);
        glb.json["meshes"][mesh]["extras"] = json!(null);
    }
    assert!(error(&glb).contains("morph targets"), "{}", error(&glb));
    assert!(gltf_file("none.glb".as_ref(), MeshChoice::Nodes(Patterns::default())).is_err());
}

#[test]
fn nodes_are_chosen_by_patterns_of_their_names_and_those_above() {
    let mut glb = three();
    glb.json["nodes"][0]["name"] = "Car".into();
    let names = |nodes: &[&str]| -> Vec<String> {
        let body = join(&glb, nodes).unwrap_or_else(|e| panic!("{nodes:?}: {e}"));
        body.parts.into_iter().map(|part| part.name).collect()
    };
    assert_eq!(names(&["car"]), ["hood", "Turned", "mirrored"]);
    assert_eq!(names(&["hood", "m*"]), ["hood", "mirrored"]);
    assert_eq!(names(&["!h??d"]), ["Turned", "mirrored"]);
    assert_eq!(names(&["Car", "!TURNED"]), ["hood", "mirrored"]);
    let error = join(&glb, &["bonnet"]).unwrap_err().to_string();
    let all = "'Car', 'hood', 'Turned', 'mirrored'";
    assert_eq!(
        error,
        format!("a pattern for nodes is 'bonnet'; it must be one that matches a name of the file: {all}")
    );
    let error = join(&glb, &["Car", "!Car"]).unwrap_err().to_string();
    assert!(error.contains("3 nodes with meshes; none of them is chosen and dents"), "{error}");
}

/// The kinds of the parts, and the stiffness of the first vertex of each.
fn kinds(glb: &Glb, reading: Reading) -> Vec<(String, PartKind, f32)> {
    let body = gltf_slice(&glb.bytes(), None, reading).unwrap();
    let stiffness = |v: usize| body.mesh.stiffness.as_ref().map_or(0.0, |s| s[v]);
    body.parts.iter().map(|p| (p.name.clone(), p.kind, stiffness(p.vertices.start))).collect()
}

#[test]
fn what_is_rigid_glass_or_moves_is_said_by_patterns_and_by_extras() {
    use PartKind::{Dents, Glass, Rigid};
    let reading = |rigid: &[&str], glass: &[&str], moving: &[&str]| Reading {
        rigid: Patterns::new(rigid),
        glass: Patterns::new(glass),
        moving: Patterns::new(moving),
        ..MeshChoice::Nodes(Patterns::default()).into()
    };
    let part = |name: &str, kind: PartKind| (name.to_owned(), kind, if kind == Rigid { 1.0 } else { 0.0 });
    let mut glb = three();
    glb.json["materials"] = json!([{ "name": "Window" }]);
    let frame = glb.json["meshes"][1]["primitives"][0].clone();
    glb.json["meshes"][1]["primitives"][0]["material"] = 0.into();
    glb.json["meshes"][1]["primitives"].as_array_mut().unwrap().push(frame);
    let plain = kinds(&glb, reading(&[], &[], &[]));
    assert_eq!(plain, [part("hood", Dents), part("Turned", Dents), part("mirrored", Dents)]);
    let marked = kinds(&glb, reading(&["hood"], &["Turned"], &["mirrored"]));
    assert_eq!(marked, [part("hood", Rigid), part("Turned", Glass)]);
    let by_material = kinds(&glb, reading(&[], &["window"], &[]));
    let dents = [part("hood", Dents), part("Turned", Dents)];
    assert_eq!(by_material, [&dents[..], &[part("mirrored", Dents), part("Window", Glass)]].concat());
    // The file says the same, for a node and those below, and for a material.
    glb.json["nodes"][0]["extras"] = json!({ "crumple": "rigid" });
    glb.json["nodes"][3]["extras"] = json!({ "crumple": "Moving" });
    assert_eq!(kinds(&glb, reading(&[], &[], &[])), [part("hood", Rigid), part("Turned", Rigid)]);
    glb.json["nodes"][0]["extras"] = json!({ "crumple": { "made": "by hand" } });
    glb.json["materials"][0]["extras"] = json!({ "crumple": "glass" });
    assert_eq!(kinds(&glb, reading(&[], &[], &[])), [&dents[..], &[part("Window", Glass)]].concat());
    // A single mesh has its glass too.
    assert_eq!(kinds(&glb, MeshChoice::Index(1).into()), [part("Window", Glass)]);
    // A node of glass alone is glass itself.
    glb.json["meshes"][1]["primitives"].as_array_mut().unwrap().pop();
    assert_eq!(kinds(&glb, reading(&[], &[], &[])), [part("hood", Dents), part("Turned", Glass)]);
    assert_eq!(kinds(&glb, MeshChoice::Index(1).into()), [part("Window", Glass)]);
    glb.json["nodes"][3]["extras"] = json!({ "crumple": "solid" });
    let error = gltf_slice(&glb.bytes(), None, reading(&[], &[], &[])).unwrap_err().to_string();
    assert_eq!(error, "malformed: nodes[3]: extras.crumple is 'solid'; it must be rigid, glass or moving");
}

#[test]
fn targets_of_one_name_that_lie_apart_are_examples_of_their_own() {
    let mut glb = three();
    let names = |glb: &Glb| join(glb, &[]).unwrap().examples.into_iter().map(|e| e.name).collect::<Vec<_>>();
    assert_eq!(names(&glb), ["dense", "sparse", "pushed"], "beside each other");
    glb.json["nodes"][3]["translation"] = json!([40, 0, 0]);
    assert_eq!(names(&glb), ["dense (hood)", "dense (mirrored)", "sparse (hood)", "sparse (mirrored)", "pushed"]);
    let notes = join(&glb, &[]).unwrap().notes;
    let told = "the targets 'dense' of 'hood' and of other parts lie apart, so they are examples of their own";
    assert_eq!(notes, [format!("{told}; so are those of 1 more names")]);
    glb.json["scenes"][0]["extras"] = json!({ "targets": "joined" });
    assert_eq!(names(&glb), ["dense", "sparse", "pushed"], "the file says that they are one");
    // A mesh that has a name twice has two examples.
    let mut glb = three();
    glb.json["meshes"][1]["extras"]["targetNames"] = json!(["dense", "dense"]);
    glb.json["meshes"][1]["extras"]["impacts"] = json!(null);
    assert_eq!(names(&glb), ["dense", "sparse", "dense"]);
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
    let body = join(&glb, &[]).unwrap();
    assert_eq!((body.parts.len(), body.examples.len()), (4, 2 + MANY));
    assert_eq!(body.mesh.positions[body.parts[2].vertices.clone()], vec![[0.0; 3]; MANY]);
}
