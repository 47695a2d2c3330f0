//! Rewritten glTFs show the deformed vertices and keep everything else.
#![cfg(feature = "gltf")]

mod import_glb;

use crumple::export::mesh_glb;
use crumple::import::{Imported, MeshChoice, Reading, gltf_file};
use crumple::{Error, ErrorKind};
use import_glb::{Glb, SQUARE, UP, bytes, fixture, parts, square};
use serde_json::{Value, json};
use std::path::Path;

const FIXTURES: [(&str, usize); 9] = [
    ("two_materials.glb", 0),
    ("two_materials_sparse.glb", 0),
    ("seams.glb", 0),
    ("seams_sparse.glb", 0),
    ("nodes.glb", 1),
    ("nodes.glb", 2),
    ("animated.glb", 0),
    ("animated.glb", 2),
    ("separate/bent door.gltf", 0),
];

/// The bytes of an export that has nothing to note.
fn deformed_glb(
    source: &[u8],
    folder: Option<&Path>,
    reading: impl Into<Reading>,
    positions: &[[f32; 3]],
    normals: Option<&[[f32; 3]]>,
    tangents: Option<&[[f32; 4]]>,
) -> Result<Vec<u8>, Error> {
    let exported = crumple::export::deformed_glb(source, folder, reading, positions, normals, tangents)?;
    assert_eq!(exported.notes, [""; 0]);
    Ok(exported.glb)
}

/// Bends the whole mesh along x, by so little that the normals still fit.
fn bend(imported: &Imported) -> Vec<[f32; 3]> {
    imported.mesh.positions.iter().map(|[x, y, z]| [*x, y + 0.25 * x * x, *z]).collect()
}

/// A bent fixture whose targets are at weight zero by default.
fn deformed(name: &str, mesh: usize) -> (Imported, Vec<u8>) {
    let path = fixture(name);
    let imported = gltf_file(&path, MeshChoice::Index(mesh)).unwrap();
    let (mut json, bin) = source(name);
    json["meshes"][mesh].as_object_mut().unwrap().remove("weights");
    let bytes = match name.ends_with(".glb") {
        true => import_glb::container(json.to_string().as_bytes(), Some(&bin)),
        false => json.to_string().into_bytes(),
    };
    let glb = deformed_glb(
        &bytes,
        path.parent(),
        MeshChoice::Index(mesh),
        &bend(&imported),
        imported.mesh.normals.as_deref(),
        imported.mesh.tangents.as_deref(),
    );
    (imported, glb.unwrap())
}

/// The source's JSON and its one buffer, wherever the buffer is stored.
fn source(name: &str) -> (Value, Vec<u8>) {
    let bytes = std::fs::read(fixture(name)).unwrap();
    if name.ends_with(".glb") {
        return parts(&bytes);
    }
    let json: Value = serde_json::from_slice(&bytes).unwrap();
    let uri = json["buffers"][0]["uri"].as_str().unwrap().replace("%20", " ");
    let bin = std::fs::read(fixture(name).parent().unwrap().join(uri)).unwrap();
    (json, bin)
}

fn view<'b>(json: &Value, bin: &'b [u8], view: &Value) -> &'b [u8] {
    let view = &json["bufferViews"][view.as_u64().unwrap() as usize];
    assert_eq!(view["buffer"], 0);
    let offset = view["byteOffset"].as_u64().unwrap_or(0) as usize;
    &bin[offset..offset + view["byteLength"].as_u64().unwrap() as usize]
}

/// An accessor with its bufferViews replaced by their content, so that files with different layouts can be compared.
fn content(json: &Value, bin: &[u8], accessor: &Value) -> Value {
    let mut accessor = json["accessors"][accessor.as_u64().unwrap() as usize].clone();
    for pointer in ["", "/sparse/indices", "/sparse/values"] {
        if let Some(index) = accessor.pointer_mut(pointer).and_then(|a| a.get_mut("bufferView")) {
            *index = view(json, bin, index).into();
        }
    }
    accessor
}

#[test]
fn what_only_the_targets_used_is_gone() {
    for (name, mesh) in FIXTURES {
        let (_, glb) = deformed(name, mesh);
        let (json, bin) = parts(&glb);
        assert_eq!(json["buffers"].as_array().unwrap().len(), 1);
        assert!(json["buffers"][0].get("uri").is_none());
        let length = json["buffers"][0]["byteLength"].as_u64().unwrap() as usize;
        assert!((length..length + 4).contains(&bin.len()));
        let viewed: u64 =
            json["bufferViews"].as_array().unwrap().iter().map(|v| v["byteLength"].as_u64().unwrap()).sum();
        let slack = json["bufferViews"].as_array().unwrap().len() as u64 * 16;
        assert!(length as u64 <= viewed + slack, "{name}: {length} bytes for {viewed}");
        if !name.starts_with("separate") {
            assert!(glb.len() < std::fs::metadata(fixture(name)).unwrap().len() as usize, "{name}");
        }
    }
    let (_, glb) = deformed("two_materials.glb", 0);
    let (json, _) = parts(&glb);
    // Positions, normals and texture coordinates of two parts, and indices, which the parts share in Blender's file.
    assert_eq!(json["accessors"].as_array().unwrap().len(), 7);
}

#[test]
fn weights_and_their_animation_go() {
    for (mesh, left) in [(0, &["StillAction"][..]), (2, &["FlagAction", "StillAction"])] {
        let (_, glb) = deformed("animated.glb", mesh);
        let (json, _) = parts(&glb);
        let names: Vec<_> = json["animations"].as_array().unwrap().iter().map(|a| &a["name"]).collect();
        assert_eq!(names, left);
    }
    let mut glb = square();
    let (time, weights, moves) =
        (glb.floats("SCALAR", &[0., 1.]), glb.floats("SCALAR", &[0., 1., 1., 0.]), glb.floats("VEC3", &SQUARE[..6]));
    glb.json["nodes"] = json!([{ "mesh": 0, "weights": [1, 1] }, { "mesh": 1, "weights": [1, 1] }]);
    let other = glb.json["meshes"][0].clone();
    glb.push("meshes", other);
    let sampler = |output: usize| json!({ "input": time, "output": output });
    let channel = |sampler: usize, node: usize, path: &str| json!({ "sampler": sampler, "target": { "node": node, "path": path } });
    let pointer = |text: &str| json!({ "sampler": 1, "target": { "path": "pointer", "extensions": { "KHR_animation_pointer": { "pointer": text } } } });
    glb.json["animations"] = json!([
        { "samplers": [sampler(weights), sampler(weights), sampler(moves)],
          "channels": [channel(0, 0, "weights"), channel(1, 1, "weights"), channel(2, 0, "translation")] },
        { "samplers": [sampler(weights)], "channels": [channel(0, 0, "weights")] },
        { "samplers": [sampler(moves), sampler(weights)],
          "channels": [pointer("/meshes/0/weights"), pointer("/nodes/0/weights/1"), pointer("/nodes/1/weights"), channel(0, 1, "translation")] },
    ]);
    let out = deformed_glb(&glb.bytes(), None, MeshChoice::Index(0), &[[0.0; 3]; 4], None, None).unwrap();
    let (json, _) = parts(&out);
    assert_eq!(json["nodes"], json!([{ "mesh": 0 }, { "mesh": 1, "weights": [1, 1] }]));
    let animations = json["animations"].as_array().unwrap();
    assert_eq!(animations.len(), 2);
    assert_eq!(animations[0]["channels"], json!([channel(0, 1, "weights"), channel(1, 0, "translation")]));
    assert_eq!(animations[0]["samplers"].as_array().unwrap().len(), 2);
    assert_eq!(animations[1]["channels"], json!([pointer("/nodes/1/weights"), channel(0, 1, "translation")]));
    // If all animations animate weights only, the list is removed, since glTF allows no empty list.
    let list = glb.json["animations"].as_array_mut().unwrap();
    *list = vec![list[1].clone()];
    let out = deformed_glb(&glb.bytes(), None, MeshChoice::Index(0), &[[0.0; 3]; 4], None, None).unwrap();
    assert!(parts(&out).0.get("animations").is_none());
}

/// `tests/files/images_of_other_kinds` has those that are embedded.
#[test]
fn images_that_cannot_be_embedded_are_noted_and_stay() {
    let folder = tempfile::tempdir().unwrap();
    let outside = "is not in the file's folder or below";
    for (uri, why) in [("/etc/a.png", outside), ("", outside), ("../a.png", outside), ("b.png", "cannot be read")] {
        let mut glb = square();
        glb.json["images"] = json!([{ "uri": uri, "extras": 7 }]);
        let (bytes, at) = (glb.bytes(), [[0.0; 3]; 4]);
        let out =
            crumple::export::deformed_glb(&bytes, Some(folder.path()), MeshChoice::First, &at, None, None).unwrap();
        assert_eq!(parts(&out.glb).0["images"], glb.json["images"]);
        assert!(out.notes[0].starts_with(&format!("image 0, '{uri}', {why}")), "{:?}", out.notes);
    }
}

#[test]
fn parts_that_share_vertices_still_do() {
    let mut glb = square();
    let again = glb.json["meshes"][0]["primitives"][0].clone();
    glb.json["meshes"][0]["primitives"].as_array_mut().unwrap().push(again);
    let out = deformed_glb(&glb.bytes(), None, MeshChoice::First, &[[0.0; 3]; 4], None, None).unwrap();
    let (json, bin) = parts(&out);
    let [a, b] = [0, 1].map(|i| &json["meshes"][0]["primitives"][i]["attributes"]);
    assert_eq!(a, b);
    assert_eq!(content(&json, &bin, &a["NORMAL"])["bufferView"], json!(bytes(&UP)), "kept where no new ones are given");
    assert_eq!(json["accessors"].as_array().unwrap().len(), 3);
}

#[test]
fn extras_and_unknown_things_survive() {
    let mut glb = square();
    glb.json["extras"] = json!({ "deep": [1, { "x": null }], "precise": 0.1 });
    glb.json["asset"]["copyright"] = "somebody".into();
    glb.json["unheard_of"] = json!({ "list": [1, 2, 3] });
    glb.json["meshes"][0]["extras"]["mine"] = 5.into();
    glb.json["meshes"][0]["primitives"][0]["extras"] = json!({ "targetNames": ["a"], "also": "mine" });
    // Nothing uses these, before or after.
    let spare = glb.floats("VEC3", &UP);
    let out = deformed_glb(&glb.bytes(), None, MeshChoice::First, &[[0.0; 3]; 4], None, None).unwrap();
    let (json, bin) = parts(&out);
    for key in ["extras", "asset", "unheard_of", "nodes", "scenes"] {
        assert_eq!(json[key], glb.json[key]);
    }
    assert_eq!(json["meshes"][0]["extras"], json!({ "mine": 5 }));
    assert_eq!(json["meshes"][0]["primitives"][0]["extras"], json!({ "also": "mine" }));
    let kept = content(&glb.json, &glb.bin, &spare.into());
    assert!(
        (0..json["accessors"].as_array().unwrap().len()).any(|i| content(&json, &bin, &i.into()) == kept),
        "unused before is kept"
    );
    let order: Vec<_> = json.as_object().unwrap().keys().collect();
    assert_eq!(order[..2], ["asset", "scene"], "the order of keys is kept");
}

#[test]
fn with_unknown_extensions_nothing_is_renumbered() {
    let folder = tempfile::tempdir().unwrap();
    let mut glb = square();
    glb.json["extensionsUsed"] = json!(["VENDOR_points_into_buffers"]);
    glb.json["extensions"] = json!({ "VENDOR_points_into_buffers": { "bufferView": 5, "buffer": 1, "accessor": 3 } });
    let extra: Vec<u8> = (0..48).collect();
    std::fs::write(folder.path().join("extra.bin"), &extra).unwrap();
    glb.push("buffers", json!({ "byteLength": 48, "uri": "extra.bin" }));
    glb.push("bufferViews", json!({ "buffer": 1, "byteLength": 48 }));
    let out = deformed_glb(&glb.bytes(), Some(folder.path()), MeshChoice::First, &[[2.0; 3]; 4], None, None).unwrap();
    let (json, bin) = parts(&out);
    let before = |key: &str| glb.json[key].as_array().unwrap().clone();
    assert_eq!(json["accessors"].as_array().unwrap()[..6], before("accessors"));
    assert_eq!(json["bufferViews"].as_array().unwrap()[..8], before("bufferViews"));
    assert_eq!(bin[..glb.bin.len()], glb.bin, "old offsets hold");
    assert!(json["buffers"][1]["uri"].as_str().unwrap().starts_with("data:application/octet-stream;base64,AAECAwQF"));
    let position = &json["meshes"][0]["primitives"][0]["attributes"]["POSITION"];
    assert_eq!(content(&json, &bin, position)["bufferView"], json!(bytes(&[2.0; 12])));
    assert!(json["meshes"][0]["primitives"][0].get("targets").is_none());
    // An extension that is used without being listed counts as unknown too.
    glb.json.as_object_mut().unwrap().remove("extensionsUsed");
    let again = deformed_glb(&glb.bytes(), Some(folder.path()), MeshChoice::First, &[[2.0; 3]; 4], None, None).unwrap();
    assert_eq!(parts(&again).0["accessors"], json["accessors"]);
}

#[test]
fn an_optional_compressed_copy_does_not_win() {
    let mut glb = square();
    glb.json["extensionsUsed"] = json!(["KHR_draco_mesh_compression"]);
    let draco = json!({ "KHR_draco_mesh_compression": { "bufferView": 0, "attributes": { "POSITION": 0 } } });
    glb.json["meshes"][0]["primitives"][0]["extensions"] = draco;
    let out = deformed_glb(&glb.bytes(), None, MeshChoice::First, &[[2.0; 3]; 4], None, None).unwrap();
    assert!(parts(&out).0["meshes"][0]["primitives"][0].get("extensions").is_none());
}

#[test]
fn views_that_overlap_are_stored_once_and_stay_aligned() {
    let mut glb = Glb::empty();
    let values: Vec<f32> = (0..3000).map(|i| i as f32).collect();
    let whole = glb.floats("VEC3", &values);
    let target = glb.floats("VEC3", &values);
    // A hundred views of the same bytes, each one vertex further on.
    for i in 0..100 {
        let view = glb.push("bufferViews", json!({ "buffer": 0, "byteOffset": i * 12, "byteLength": 10_000 }));
        glb.push("accessors", json!({ "bufferView": view, "componentType": 5126, "count": 800, "type": "VEC3" }));
    }
    let attributes: serde_json::Map<String, Value> = (0..100).map(|i| (format!("_X{i}"), (i + 2).into())).collect();
    let mut attributes = Value::Object(attributes);
    attributes["POSITION"] = whole.into();
    glb.push(
        "meshes",
        json!({ "primitives": [{ "attributes": attributes, "mode": 5, "targets": [{ "POSITION": target }] }] }),
    );
    let positions = vec![[0.0; 3]; 1000];
    let out = deformed_glb(&glb.bytes(), None, MeshChoice::First, &positions, None, None).unwrap();
    let (json, bin) = parts(&out);
    assert!(bin.len() < 24_100, "{}", bin.len());
    let primitive = |json: &Value| json["meshes"][0]["primitives"][0]["attributes"].clone();
    for i in 0..100 {
        let key = format!("_X{i}");
        let (before, after) = (&primitive(&glb.json)[&key], &primitive(&json)[&key]);
        assert_eq!(content(&glb.json, &glb.bin, before), content(&json, &bin, after));
    }
    assert!(json["bufferViews"].as_array().unwrap().iter().all(|v| v["byteOffset"].as_u64().unwrap() % 4 == 0));
}

#[test]
fn vertices_that_do_not_fit_are_named() {
    let glb = square().bytes();
    let refuse = |positions: &[[f32; 3]], normals: Option<&[[f32; 3]]>, tangents: Option<&[[f32; 4]]>| -> Error {
        deformed_glb(&glb, None, MeshChoice::First, positions, normals, tangents).unwrap_err()
    };
    let good = [[0.0; 3]; 4];
    assert_eq!(
        refuse(&good[..3], None, None).to_string(),
        "positions.len() is 3; it must be 4, as many as the mesh has vertices"
    );
    assert_eq!(
        refuse(&good, Some(&[]), None).to_string(),
        "normals.len() is 0; it must be 4, as many as the mesh has vertices"
    );
    assert_eq!(refuse(&good, None, Some(&[[0.0; 4]; 5])).kind(), ErrorKind::InvalidArgument);
    let mut bad = good;
    bad[2][1] = f32::NAN;
    assert_eq!(refuse(&bad, None, None).to_string(), "positions[2].y is NaN; every component must be finite");
    assert_eq!(refuse(&good, Some(&bad), None).to_string(), "normals[2].y is NaN; every component must be finite");
}

#[test]
fn new_files_from_arrays() {
    let plate = gltf_file(&fixture("two_materials.glb"), MeshChoice::First).unwrap();
    let (triangles, normals) = (&plate.mesh.triangles, plate.mesh.normals.as_deref());
    let glb = mesh_glb("plate", triangles, &bend(&plate), normals, None).unwrap();
    let (json, bin) = parts(&glb);
    let primitive = &json["meshes"][0]["primitives"][0];
    let positions = content(&json, &bin, &primitive["attributes"]["POSITION"]);
    assert_eq!(positions["bufferView"], json!(bytes(bend(&plate).as_flattened())));
    assert_eq!(content(&json, &bin, &primitive["indices"])["count"], triangles.len() * 3);
    let points = mesh_glb("", &[], &[[0.0; 3], [1.0; 3]], None, None).unwrap();
    assert_eq!(parts(&points).0["meshes"][0]["primitives"][0]["mode"], 0);
    for_others("plate", &glb);
    for_others("points", &points);
    assert_eq!(mesh_glb("", &[], &[], None, None).unwrap_err().kind(), ErrorKind::InvalidArgument);
    let error = mesh_glb("", &[[0, 1, 2]], &[[0.0; 3]; 2], None, None).unwrap_err().to_string();
    assert_eq!(error, "triangles[0][2] is 2; it must be below 2");
}

/// `cargo xtask test --only gltf-validator` and `--only blender` let other programs read the files; tests/cli/compare.rs compares what is
/// in them.
fn for_others(name: &str, glb: &[u8]) {
    if let Some(folder) = std::env::var_os("CRUMPLE_EXPORTED") {
        std::fs::write(Path::new(&folder).join(name.replace(['/', '.'], "_") + ".glb"), glb).unwrap();
    }
}

#[test]
fn deformed_fixtures_are_for_other_programs() {
    FIXTURES.iter().for_each(|(name, mesh)| for_others(&format!("{mesh} {name}"), &deformed(name, *mesh).1));
}
