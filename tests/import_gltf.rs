//! Valid glTF files: Blender's, and features that Blender does not write.
#![cfg(feature = "gltf")]

mod import_glb;
mod scenes;

use crumple::import::{Imported, MeshChoice, Patterns, Reading, apply_extras, gltf_file, gltf_slice};
use crumple::{Blow, Contact, Error, ErrorKind, ExampleData, Striker};
use import_glb::{Glb, SQUARE, UP, bytes, fixture, sparse, square};
use scenes::field;
use serde_json::{Value, json};

fn blender(name: &str) -> Imported {
    gltf_file(&fixture(name), MeshChoice::First).unwrap()
}

fn read(glb: &Glb) -> Imported {
    gltf_slice(&glb.bytes(), None, MeshChoice::First).unwrap()
}

/// The dent of tests/fixtures/README.md.
fn dent(at: [f32; 3], centre: [f64; 3], radius: f64, depth: f64, direction: [f64; 3]) -> [f64; 3] {
    let squared: f64 = (0..3).map(|i| (f64::from(at[i]) - centre[i]).powi(2)).sum();
    let share = (1.0 - squared / (radius * radius)).max(0.0).powi(2);
    direction.map(|d| d * depth * share)
}

fn assert_dent(
    imported: &Imported,
    example: &ExampleData,
    centre: [f64; 3],
    radius: f64,
    depth: f64,
    direction: [f64; 3],
) {
    let positions = &imported.mesh.positions;
    let deltas = field(&example.positions, positions.len());
    let mut deepest: f64 = 0.0;
    for (at, delta) in positions.iter().zip(&deltas) {
        let expected = dent(*at, centre, radius, depth, direction);
        for i in 0..3 {
            assert!(
                (f64::from(delta[i]) - expected[i]).abs() < 2e-7,
                "{}: {delta:?} is not {expected:?}",
                example.name
            );
        }
        deepest = deepest.max(expected.iter().map(|x| x * x).sum::<f64>().sqrt());
    }
    assert!(deepest > depth * 0.5, "{} touches the mesh", example.name);
}

/// Asserts that vertices at one position, split by UV seams, hard edges and material borders, move alike. Returns the
/// number of such positions.
fn assert_watertight(imported: &Imported) -> usize {
    let places = scenes::coincident(&imported.mesh.positions);
    for example in &imported.examples {
        let deltas = field(&example.positions, imported.mesh.positions.len());
        for twins in &places {
            assert!(twins.iter().all(|v| deltas[*v] == deltas[twins[0]]), "{} tears {twins:?}", example.name);
        }
    }
    places.len()
}

#[test]
fn two_materials_become_two_ranges_of_one_mesh() {
    for file in ["two_materials.glb", "two_materials_sparse.glb"] {
        let plate = blender(file);
        assert_eq!(plate.name, "Plate");
        assert_eq!(plate.mesh.positions.len(), 90, "two halves of 5 x 9 vertices");
        assert_eq!(plate.mesh.triangles.len(), 128);
        assert_eq!(plate.mesh.normals.as_ref().map(Vec::len), Some(90));
        assert_eq!(plate.mesh.tangents, None);
        let ranges: Vec<_> =
            plate.primitives.iter().map(|p| (p.vertices.clone(), p.triangles.clone(), p.material.as_deref())).collect();
        assert_eq!(ranges, [(0..45, 0..64, Some("Paint, red")), (45..90, 64..128, Some("Rubber"))]);
        for range in &plate.primitives {
            let triangles = &plate.mesh.triangles[range.triangles.clone()];
            assert!(triangles.as_flattened().iter().all(|v| range.vertices.contains(&(*v as usize))));
        }
        assert_eq!(assert_watertight(&plate), 9, "the border between the materials");
    }
}

#[test]
fn uv_seams_hard_edges_and_odd_keys() {
    for file in ["seams.glb", "seams_sparse.glb"] {
        let drum = blender(file);
        // 60 wall and rim positions and 2 cap centres. The UV seam splits 5, the hard rims split 24; one position on
        // each rim is split by both.
        assert_eq!(drum.mesh.positions.len(), 91);
        assert_eq!(assert_watertight(&drum), 27);
        let names: Vec<_> = drum.examples.iter().map(|e| e.name.as_str()).collect();
        assert_eq!(names, ["Delle ü 凹み 🚗", "rim \"quoted\" \\ /", "unmoved"], "muted keys are not exported");
        assert_dent(&drum, &drum.examples[0], [0.3, 0.0, 0.0], 0.25, 0.08, [-1.0, 0.0, 0.0]);
        assert_dent(&drum, &drum.examples[1], [0.0, 0.3, -0.3], 0.25, 0.06, [0.0, -0.8, 0.6]);
        assert_eq!(sparse(&drum.examples[2].positions).0, [0u32; 0]);
        assert!(drum.examples.iter().all(|e| e.contact.is_none()));
        let split: usize = drum.mesh.normals.iter().flatten().filter(|n| n[1].abs() > 0.999).count();
        assert_eq!(split, 26, "the caps keep their own normals at the hard edge");
    }
    assert_eq!(blender("seams.glb").mesh.tangents.map(|t| t.len()), Some(91));
    assert_eq!(blender("seams_sparse.glb").mesh.tangents, None);
}

#[test]
fn external_buffers_are_found_beside_the_file() {
    let path = fixture("separate/bent door.gltf");
    let door = gltf_file(&path, MeshChoice::First).unwrap();
    assert_eq!(door.mesh.positions.len(), 25);
    assert_dent(&door, &door.examples[0], [0.0; 3], 0.4, 0.1, [0.0, -1.0, 0.0]);
    let text = std::fs::read(&path).unwrap();
    assert_eq!(gltf_slice(&text, path.parent(), MeshChoice::First).unwrap(), door);
    let error = gltf_slice(&text, None, MeshChoice::First).unwrap_err();
    assert_eq!((error.kind(), error.to_string().contains("base_dir")), (ErrorKind::Io, true), "{error}");
}

#[test]
fn buffers_in_data_uris_and_in_files_with_any_name() {
    let glb = square();
    let expected = read(&glb);
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("Tür & 凹.bin"), &glb.bin).unwrap();
    let base64 = base64::Engine::encode(&base64::prelude::BASE64_STANDARD, &glb.bin);
    let percent: String = glb.bin.iter().map(|b| format!("%{b:02x}")).collect();
    let uris = [
        format!("data:application/octet-stream;base64,{base64}"),
        format!("data:application/gltf-buffer;base64,{}", base64.trim_end_matches('=')),
        format!("DATA:;base64,{}", base64.replace('+', "%2B")),
        format!("data:application/octet-stream,{percent}"),
        "T%C3%BCr%20&%20%E5%87%B9.bin".into(),
        "Tür & 凹.bin".into(),
        "./sub/../T%C3%bcr & 凹.bin".into(),
    ];
    std::fs::create_dir(folder.path().join("sub")).unwrap();
    for uri in uris {
        let mut json = glb.json.clone();
        json["buffers"][0]["uri"] = uri.as_str().into();
        let text = format!("\u{feff} \n{json}");
        let read = gltf_slice(text.as_bytes(), Some(folder.path()), MeshChoice::First)
            .unwrap_or_else(|e| panic!("{uri}: {e}"));
        assert_eq!(read, expected, "{uri}");
    }
}

#[test]
fn sparse_accessors_over_zeros_and_over_a_base() {
    let mut glb = square();
    let imported = read(&glb);
    assert_eq!(sparse(&imported.examples[0].positions), (&[0, 2][..], &[[0., -0.5, 0.], [0., -0.25, 0.]][..]));
    assert_eq!(sparse(imported.examples[0].normals.as_ref().unwrap()), (&[0][..], &[[0.5, -0.5, 0.]][..]));
    assert_eq!(sparse(&imported.examples[1].positions), (&[1, 3][..], &[[0., -1., 0.], [0., -2., 0.]][..]));
    assert_eq!(imported.examples[1].normals, None);
    // Sparse values over the dense target's view: vertex 0 becomes zero again, vertex 3 moves.
    for width in [1, 2, 4] {
        let accessor = glb.sparse(4, Some(3), width, &[0, 3], &[0., 0., 0., 9., 9., 9.]);
        glb.json["accessors"][accessor]["bufferView"] = glb.json["accessors"][3]["bufferView"].clone();
        glb.json["meshes"][0]["primitives"][0]["targets"][1]["POSITION"] = accessor.into();
        let imported = read(&glb);
        assert_eq!(sparse(&imported.examples[1].positions), (&[2, 3][..], &[[0., -0.25, 0.], [9., 9., 9.]][..]));
    }
    // Sparse base positions, and an accessor without any data, which is all zeros.
    let positions = glb.sparse(4, None, 1, &[1, 2, 3], &SQUARE[3..]);
    let zeros = glb.push("accessors", json!({ "componentType": 5126, "count": 4, "type": "VEC3" }));
    glb.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = positions.into();
    glb.json["meshes"][0]["primitives"][0]["targets"][1]["POSITION"] = zeros.into();
    let again = read(&glb);
    assert_eq!(again.mesh, imported.mesh);
    assert_eq!(sparse(&again.examples[1].positions).0, [0u32; 0]);
}

#[test]
fn index_widths_strips_fans_and_no_indices() {
    for width in [1, 2, 4] {
        let mut glb = square();
        let indices = glb.indices(width, &[0, 2, 1, 0, 3, 2]);
        glb.json["meshes"][0]["primitives"][0]["indices"] = indices.into();
        assert_eq!(read(&glb).mesh.triangles, [[0, 2, 1], [0, 3, 2]]);
    }
    let triangles = |mode: Option<u32>, corners: Option<&[u32]>| {
        let mut glb = square();
        let primitive = &mut glb.json["meshes"][0]["primitives"][0];
        primitive.as_object_mut().unwrap().remove("indices");
        if let Some(mode) = mode {
            primitive["mode"] = mode.into();
        }
        if let Some(corners) = corners {
            let indices = glb.indices(4, corners);
            glb.json["meshes"][0]["primitives"][0]["indices"] = indices.into();
        }
        read(&glb).mesh.triangles
    };
    assert_eq!(triangles(Some(5), None), [[0, 1, 2], [1, 3, 2]]);
    assert_eq!(triangles(Some(5), Some(&[3, 2, 0, 0, 1])), [[3, 2, 0]], "a repeated corner is a jump");
    assert_eq!(triangles(Some(6), None), [[1, 2, 0], [2, 3, 0]]);
    assert_eq!(triangles(Some(6), Some(&[3, 0, 1, 2])), [[0, 1, 3], [1, 2, 3]]);
    assert_eq!(triangles(Some(4), Some(&[3, 0, 1])), [[3, 0, 1]]);
    // Without indices: three vertices in sequence.
    let mut glb = Glb::empty();
    glb.floats("VEC3", &SQUARE[..9]);
    glb.push("meshes", json!({ "primitives": [{ "attributes": { "POSITION": 0 }, "targets": [{ "POSITION": 0 }] }] }));
    assert_eq!(read(&glb).mesh.triangles, [[0, 1, 2]]);
    assert_eq!(read(&glb).examples[0].name, "target 0");
}

#[test]
fn primitives_that_share_accessors_share_vertices() {
    let mut glb = square();
    let primitive = glb.json["meshes"][0]["primitives"][0].clone();
    let flipped = glb.indices(2, &[0, 1, 2]);
    let list = glb.json["meshes"][0]["primitives"].as_array_mut().unwrap();
    list.push(primitive.clone());
    list[1]["indices"] = flipped.into();
    // A primitive with other targets may not share vertices.
    list.push(primitive);
    list[2]["targets"][0]["POSITION"] = 5.into();
    let imported = read(&glb);
    assert_eq!(imported.mesh.positions.len(), 8);
    let firsts: Vec<_> = imported.primitives.iter().map(|p| (p.vertices.clone(), p.triangles.start)).collect();
    assert_eq!(firsts, [(0..4, 0), (0..4, 2), (4..8, 3)]);
    assert_eq!(imported.mesh.triangles[2], [0, 1, 2]);
    assert_eq!(sparse(&imported.examples[0].positions).0, [0, 2, 5, 7]);
}

#[test]
fn quantised_attributes_and_targets() {
    for (component, width, most) in [(5120, 1usize, 127.0f32), (5121, 1, 255.0), (5122, 2, 32767.0), (5123, 2, 65535.0)]
    {
        let mut glb = square();
        let mut quantised = |values: &[f32], normalized: bool| {
            // Elements begin at multiples of four bytes.
            let stride = (3 * width).next_multiple_of(4);
            let mut raw = Vec::new();
            for v in values.chunks(3) {
                let at = raw.len();
                v.iter().for_each(|x| raw.extend_from_slice(&(*x as i32).to_le_bytes()[..width]));
                raw.resize(at + stride, 0);
            }
            let view = glb.view(&raw);
            glb.json["bufferViews"][view]["byteStride"] = stride.into();
            glb.push(
                "accessors",
                json!({
                    "bufferView": view, "componentType": component, "count": values.len() / 3, "type": "VEC3",
                    "normalized": normalized,
                }),
            )
        };
        let positions = quantised(&SQUARE.map(|x| x * 100.0), false);
        let normals = quantised(&UP.map(|x| x * most), true);
        let moved = quantised(&[0., 7., 0., 0., 0., 0., 0., 0., 0., 0., 0., 0.], false);
        let primitive = &mut glb.json["meshes"][0]["primitives"][0];
        primitive["attributes"] = json!({ "POSITION": positions, "NORMAL": normals });
        primitive["targets"] = json!([{ "POSITION": moved }]);
        let imported = read(&glb);
        assert_eq!(imported.mesh.positions.as_flattened(), SQUARE.map(|x| x * 100.0), "{component}");
        assert_eq!(imported.mesh.normals.as_deref(), Some(&[[0., 1., 0.]; 4][..]), "{component}");
        assert_eq!(sparse(&imported.examples[0].positions), (&[0][..], &[[0., 7., 0.]][..]), "{component}");
    }
}

#[test]
fn a_mesh_whose_targets_move_nothing_has_no_examples() {
    let mut glb = square();
    let zeros = glb.floats("VEC3", &[0.0; 12]);
    glb.json["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": zeros }]);
    let error = gltf_slice(&glb.bytes(), None, MeshChoice::First).unwrap_err().to_string();
    let why = "no examples: no morph target of mesh 0 'Square' moves a vertex";
    assert_eq!(error, format!("{why}; the file's meshes with morph targets are mesh 0 'Square'"));
}

#[test]
fn targets_that_are_dents_are_chosen_by_name() {
    let chosen = |targets: &[&str], extras: Value| {
        let mut glb = square();
        glb.json["meshes"][0]["extras"]["dents"] = extras;
        let reading = Reading { targets: Patterns::new(targets), ..Reading::default() };
        let names = |imported: Imported| imported.examples.into_iter().map(|e| e.name).collect::<Vec<_>>();
        gltf_slice(&glb.bytes(), None, reading).map(names).map_err(|e| e.to_string())
    };
    let of = |list: &[&str]| Ok(list.iter().map(|n| n.to_string()).collect::<Vec<_>>());
    assert_eq!(chosen(&[], Value::Null), of(&["dense", "sparse"]));
    assert_eq!(chosen(&["SP*"], Value::Null), of(&["sparse"]));
    assert_eq!(chosen(&["!sparse"], Value::Null), of(&["dense"]));
    assert_eq!(chosen(&[], json!(["d?nse"])), of(&["dense"]));
    assert_eq!(chosen(&[], json!("sparse, dense")), of(&["dense", "sparse"]));
    assert_eq!(chosen(&["dense"], json!("sparse")), of(&["dense"]), "the caller's patterns come first");
    let none =
        "no examples: none of the morph targets of mesh 0 'Square' is chosen as a dent: it has 'dense', 'sparse'";
    assert_eq!(chosen(&[], json!("door*")).unwrap_err(), none);
    let unknown =
        "a pattern for morph targets is 'door*'; it must be one that matches a name of the file: 'dense', 'sparse'";
    for patterns in [&["door*"][..], &["dense", "door*"]] {
        assert_eq!(chosen(patterns, Value::Null).unwrap_err(), unknown);
    }
    assert!(chosen(&[], json!(7)).unwrap_err().contains("extras.dents is 7; it must be a list of names"));
}

#[test]
fn a_unit_scales_lengths_and_leaves_the_scene_where_it_was() {
    let mut glb = square();
    glb.json["nodes"] = json!([{ "mesh": 0, "translation": [300, 0, 0] }]);
    glb.json["meshes"][0]["extras"]["impacts"] = json!([{ "point": [50, 0, 0], "striker": { "radius": 0.2 } }]);
    let reading = Reading { unit: 0.01, ..Reading::default() };
    let imported = gltf_slice(&glb.bytes(), None, &reading).unwrap();
    assert_eq!(imported.mesh.positions[2], [0.01, 0.0, 0.01]);
    assert_eq!(sparse(&imported.examples[0].positions).1[0], [0.0, -0.005, 0.0]);
    assert_eq!(imported.examples[0].contact, Some(Contact::Point([0.5, 0.0, 0.0])));
    assert_eq!(imported.examples[0].blow.striker.radius, Some(0.2), "in metres anyway");
    assert_eq!(imported.node_transform.unwrap()[3], [3.0, 0.0, 0.0, 1.0]);
    for unit in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        let error = gltf_slice(&glb.bytes(), None, Reading { unit, ..Reading::default() }).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::InvalidArgument, "{unit}");
    }
}

#[test]
fn a_skinned_mesh_stands_where_its_joints_place_it() {
    let mut glb = square();
    // Bound at x = 2, and now the joint stands at x = 5: the mesh is shown at x = 3.
    let bind = glb.view(&bytes(&[1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., -2., 0., 0., 1.]));
    let bind = glb.push("accessors", json!({ "bufferView": bind, "componentType": 5126, "count": 1, "type": "MAT4" }));
    glb.json["nodes"] = json!([{ "mesh": 0, "skin": 0, "translation": [70, 0, 0] }, { "translation": [5, 0, 0] }]);
    glb.json["skins"] = json!([{ "joints": [1], "inverseBindMatrices": bind }]);
    let place = |glb: &Glb| read(glb).node_transform.unwrap()[3];
    assert_eq!(place(&glb), [3.0, 0.0, 0.0, 1.0]);
    for broken in [json!({ "joints": [9] }), json!({ "joints": [] }), json!(7)] {
        glb.json["skins"][0] = broken;
        assert_eq!(place(&glb), [70.0, 0.0, 0.0, 1.0], "a broken skin is none");
    }
}

fn with_extras(extras: Value) -> Result<Imported, Error> {
    let mut glb = square();
    glb.json["meshes"][0]["extras"] = extras;
    gltf_slice(&glb.bytes(), None, MeshChoice::First)
}

fn names(extras: Value) -> Vec<String> {
    with_extras(extras).unwrap().examples.into_iter().map(|e| e.name).collect()
}

#[test]
fn target_names_may_be_anything() {
    assert_eq!(names(json!({ "targetNames": ["", ""] })), ["", ""]);
    assert_eq!(names(json!({ "targetNames": ["same", "same"] })), ["same", "same"]);
    assert_eq!(names(json!({ "targetNames": ["\u{0}\u{202e}🚗", "凹み"] })), ["\u{0}\u{202e}🚗", "凹み"]);
    assert_eq!(names(json!({ "targetNames": ["one"] })), ["one", "target 1"]);
    assert_eq!(names(json!({ "targetNames": ["one", null, "three"] })), ["one", "target 1"]);
    assert_eq!(names(json!({})), ["target 0", "target 1"]);
    assert_eq!(names(json!(7)), ["target 0", "target 1"], "extras may be anything");
    let mut named = square();
    named.json["meshes"][0]["extras"] = Value::Null;
    (named.json["accessors"][3]["name"], named.json["accessors"][5]["name"]) = ("left".into(), "right".into());
    let names_of = |glb: &Glb| read(glb).examples.into_iter().map(|e| e.name).collect::<Vec<_>>();
    assert_eq!(names_of(&named), ["left", "right"], "some exporters name the accessors");
    named.json["accessors"][5]["name"] = "left".into();
    assert_eq!(names_of(&named), ["target 0", "target 1"], "names that do not differ tell nothing");
    let mut glb = square();
    let mesh = glb.json["meshes"][0].as_object_mut().unwrap();
    let extras = mesh.remove("extras").unwrap();
    mesh["primitives"][0]["extras"] = extras;
    assert_eq!(read(&glb).examples[1].name, "sparse", "some exporters write them to the primitive");
}

#[test]
fn impacts_match_by_name_where_names_decide_and_by_order_elsewhere() {
    let contacts = |extras: Value| -> Vec<Option<Contact>> {
        with_extras(extras).unwrap().examples.into_iter().map(|e| e.contact).collect()
    };
    let (a, b) = (Some(Contact::Point([1.0, 2.0, 3.0])), Some(Contact::Vertex(2)));
    let point = |name: &str| json!({ "name": name, "point": [1, 2, 3], "contact_vertex": 0 });
    let vertex = |name: &str| json!({ "name": name, "contact_vertex": 2 });
    assert_eq!(contacts(json!({ "targetNames": ["p", "q"], "impacts": [point("q"), vertex("p")] })), [b, a]);
    assert_eq!(contacts(json!({ "targetNames": ["p", "q"], "impacts": [vertex("q")] })), [None, b]);
    assert_eq!(contacts(json!({ "targetNames": ["p", "p"], "impacts": [point("p"), vertex("p")] })), [a, b]);
    assert_eq!(contacts(json!({ "impacts": [{ "point": [1, 2, 3] }] })), [a, None]);
    assert_eq!(contacts(json!({ "impacts": "[{\"point\": [1, 2, 3]}]" })), [a, None], "typed into Blender");
    assert_eq!(contacts(json!({ "impacts": [{ "contact_vertex": 2.0 }] })), [b, None], "Blender's floats");
    assert_eq!(contacts(json!({ "impacts": null })), [None, None]);
    assert_eq!(contacts(json!({ "impacts": [] })), [None, None]);
}

#[test]
fn blows_come_from_impacts_in_the_mesh_s_own_space() {
    let impact = json!({
        "contact_vertex": 2, "normal": [0, 3, 4], "impulse": [1, -2, -8], "duration": 0.0625, "displacement": [0, 0, 1],
        "striker": { "mass": 2, "radius": 0.5, "velocity": [0.5, -1, -4], "shape": "ball", "colour": "red" },
    });
    let unknown = json!({ "point": [1, 2, 3], "impulse": null, "striker": {}, "mass": "any" });
    let mut glb = square();
    glb.json["meshes"][0]["extras"] = json!({ "impacts": [impact, unknown] });
    glb.json["nodes"] = json!([{ "mesh": 0, "rotation": [0, 0, 1, 0], "scale": [2, 2, 2] }]);
    let imported = read(&glb);
    assert!(imported.node_transform.is_some());
    let expected = Blow {
        impulse: Some([1.0, -2.0, -8.0]),
        duration: Some(0.0625),
        normal: Some([0.0, 0.6, 0.8]),
        striker: Striker {
            mass: Some(2.0),
            velocity: Some([0.5, -1.0, -4.0]),
            radius: Some(0.5),
            shape: crumple::StrikerShape::Ball,
        },
    };
    assert_eq!(imported.examples[0].blow, expected);
    assert_eq!(imported.examples[0].contact_normal, expected.normal, "one normal serves both");
    assert_eq!(imported.examples[1].blow, Blow::default());
    let plain = with_extras(json!({ "impacts": [{ "contact_vertex": 2, "normal": [0, 1, 0] }] })).unwrap();
    assert_eq!(plain.examples[0].blow, Blow { normal: Some([0.0, 1.0, 0.0]), ..Blow::default() });
}

/// `extras | kind | part of the message`
const MALFORMED_EXTRAS: &str = r#"
{"targetNames": "one"} | Format | extras.targetNames is "one"
{"targetNames": ["one", 2]} | Format | extras.targetNames[1] is 2
{"impacts": 3} | Format | extras.impacts is 3
{"impacts": "nonsense"} | Format | extras.impacts is a text that is not JSON
{"impacts": [[]]} | Format | extras.impacts[0] is []
{"impacts": [{}]} | Format | extras.impacts[0] has neither
{"impacts": [{"point": [1, 2]}]} | Format | extras.impacts[0].point is [1,2]
{"impacts": [{"point": [1, 2, 1e300]}]} | NotFinite | extras.impacts[0].point.z is inf
{"impacts": [{"contact_vertex": 4}]} | IndexOutOfRange | contact_vertex is 4; it must be below 4
{"impacts": [{"contact_vertex": -1}]} | Format | contact_vertex is -1
{"impacts": [{"contact_vertex": 0.5}]} | Format | contact_vertex is 0.5
{"impacts": [{"point": [0, 0, 0], "normal": [0, 0, 0]}]} | Format | normal is [0.0, 0.0, 0.0]
{"impacts": [{"point": [0, 0, 0], "impulse": 7}]} | Format | extras.impacts[0].impulse is 7; it must be three numbers
{"impacts": [{"point": [0, 0, 0], "duration": 0}]} | Format | extras.impacts[0].duration is 0; it must be a number above 0
{"impacts": [{"point": [0, 0, 0], "striker": 7}]} | Format | extras.impacts[0].striker is 7; it must be an object
{"impacts": [{"point": [0, 0, 0], "striker": {"mass": -1}}]} | Format | extras.impacts[0].striker.mass is -1
{"impacts": [{"point": [0, 0, 0], "striker": {"radius": "1"}}]} | Format | extras.impacts[0].striker.radius is "1"
{"impacts": [{"point": [0, 0, 0], "striker": {"velocity": [1e300, 0, 0]}}]} | NotFinite | extras.impacts[0].striker.velocity.x is inf
{"impacts": [{"point": [0, 0, 0]}, {"point": [0, 0, 0]}, {"point": [0, 0, 0]}]} | Format | extras.impacts has 3 entries for 2 targets
{"targetNames": ["p", "q"], "impacts": [{"name": "x", "point": [0, 0, 0]}]} | Format | impacts[0] is for 'x'; there is no such target (there are 'p', 'q')
"#;

#[test]
fn malformed_impacts_are_named() {
    for line in MALFORMED_EXTRAS.lines().skip(1) {
        let [extras, kind, part] = line.split(" | ").collect::<Vec<_>>()[..] else { panic!("{line}") };
        let error = with_extras(serde_json::from_str(extras).unwrap()).unwrap_err();
        assert_eq!(format!("{:?}", error.kind()), kind, "{line}: {error}");
        assert!(error.to_string().contains(part), "{line}: {error}");
    }
}

#[test]
fn an_engine_that_imported_the_file_can_apply_its_extras() {
    let extras = json!({
        "targetNames": ["p", "q"],
        "impacts": [{ "name": "q", "contact_vertex": 2, "normal": [0, 1, 0], "striker": { "mass": 2 } }],
    });
    let expected = with_extras(extras.clone()).unwrap();
    let mut examples = with_extras(json!({})).unwrap().examples;
    let vertices = expected.mesh.positions.len();
    apply_extras(&extras.to_string(), vertices, &mut examples).unwrap();
    assert_eq!(examples, expected.examples);
    for (bad, part) in [("[]", "must be an object"), ("{", "not JSON"), (r#"{"impacts": 7}"#, "extras.impacts is 7")] {
        let error = apply_extras(bad, vertices, &mut examples).unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
        assert_eq!(examples, expected.examples, "an error changes nothing");
    }
    apply_extras("{}", vertices, &mut examples).unwrap();
    assert_eq!(examples, expected.examples, "what extras do not say stays");
}

#[test]
fn extensions_that_do_not_touch_geometry_are_no_hindrance() {
    let mut glb = square();
    glb.json["extensionsRequired"] = json!(["KHR_texture_basisu", "KHR_materials_unlit", "KHR_mesh_quantization"]);
    // The importer ignores broken materials and images.
    glb.json["materials"] = json!([{ "pbrMetallicRoughness": 7 }]);
    glb.json["images"] = json!("none");
    glb.json["meshes"][0]["primitives"][0]["material"] = 0.into();
    assert_eq!(read(&glb).primitives[0].material.as_deref(), Some("material 0"));
}

#[test]
fn limits_of_vertices_are_custom_attributes() {
    let mut glb = square();
    let limits = glb.floats("SCALAR", &[0.0, 0.5, f32::MAX, 1.0]);
    let stiffness = glb.floats("SCALAR", &[0.0, 0.25, 0.5, 1.0]);
    let attributes = &mut glb.json["meshes"][0]["primitives"][0]["attributes"];
    (attributes["_DEPTH_LIMIT"], attributes["_STIFFNESS"]) = (limits.into(), stiffness.into());
    let mesh = gltf_slice(&glb.bytes(), None, MeshChoice::First).unwrap().mesh;
    assert_eq!(mesh.depth_limits.as_deref(), Some(&[0.0, 0.5, f32::MAX, 1.0][..]));
    assert_eq!(mesh.stiffness.as_deref(), Some(&[0.0, 0.25, 0.5, 1.0][..]));
    // Both stand in one scene: the solid 2 m along x, the body 3 m along x and half as large.
    glb.json["nodes"] = json!([{ "mesh": 0, "translation": [2, 0, 0] }]);
    let body = [[0.5, 0.0, 0.0, 0.0], [0.0, 0.5, 0.0, 0.0], [0.0, 0.0, 0.5, 0.0], [3.0, 0.0, 0.0, 1.0]];
    let solids = crumple::import::gltf_solids(&glb.bytes(), None, Some(body)).unwrap();
    let positions = mesh.positions.iter().map(|p| [2.0 * (p[0] - 1.0), 2.0 * p[1], 2.0 * p[2]]).collect();
    assert_eq!(solids, [crumple::Solid::Mesh { positions, triangles: mesh.triangles }]);
    assert!(crumple::import::gltf_solids(&glb.bytes(), None, Some([[0.0; 4]; 4])).is_err());
}
