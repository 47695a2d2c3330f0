//! The `crumple` command with valid input.

use crate::{Folder, PANEL, asset, crumple, has, names};
use crumple::glam::Vec3;
use crumple::import::{Imported, MeshChoice, gltf_file};
use std::path::Path;

fn import(path: &str) -> Imported {
    gltf_file(&asset(path), MeshChoice::First).expect("a glTF")
}

/// Applies a JSON list of impacts and returns the report. The dented body is `out.glb` in the folder.
fn apply(folder: &Folder, source: &[&str], json: &str, more: &[&str]) -> String {
    let (list, out) = (folder.write("i.json", json), folder.at("out.glb"));
    crumple(&[&["apply"], source, &["--impacts", &list, "-o", &out], more].concat()).report()
}

/// Positions of a dented file's first primitive. The file has no morph targets any more, so the importer refuses it.
fn dented(path: &str) -> Vec<[f32; 3]> {
    let file = gltf::Gltf::open(path).expect("a GLB");
    let primitive = file.meshes().next().and_then(|m| m.primitives().next()).expect("a primitive");
    assert_eq!(primitive.morph_targets().count(), 0);
    let blob = file.blob.as_deref().expect("a binary chunk");
    primitive.reader(|_| Some(blob)).read_positions().expect("positions").collect()
}

/// Length of each vertex's displacement between two files, m.
fn displacements(before: &Imported, after: &[[f32; 3]]) -> Vec<f32> {
    assert_eq!(before.mesh.positions.len(), after.len());
    let pairs = before.mesh.positions.iter().zip(after);
    pairs.map(|(a, b)| Vec3::from(*a).distance(Vec3::from(*b))).collect()
}

fn deepest(lengths: &[f32]) -> (usize, f32) {
    lengths.iter().copied().enumerate().fold((0, 0.0), |a, b| if b.1 > a.1 { b } else { a })
}

/// The pixels of a PNG and its description.
fn picture(path: &Path) -> (Vec<u8>, String) {
    let file = std::io::BufReader::new(std::fs::File::open(path).expect("readable"));
    let mut reader = png::Decoder::new(file).read_info().expect("a PNG");
    let mut pixels = vec![0; reader.output_buffer_size().expect("a size")];
    let frame = reader.next_frame(&mut pixels).expect("pixels");
    assert_eq!((frame.width, frame.height, frame.color_type), (320, 200, png::ColorType::Rgb));
    let text = &reader.info().uncompressed_latin1_text;
    let description = text.iter().find(|t| t.keyword == "Description").expect("a description");
    (pixels, description.text.clone())
}

#[test]
fn info_tells_what_a_file_holds() {
    let report = crumple(&["info", PANEL]).report();
    has(&report, &["blows     no example knows its blow"]);
    has(&report, &["panel: 2173 vertices, 4160 triangles, 1 primitive, 0 on seams", "1.200 x 0.900 x 0.090 m"]);
    let row = report.lines().find(|l| l.contains("train_00")).expect("a row");
    let cells: Vec<&str> = row.split_whitespace().collect();
    assert_eq!(cells[..4], ["0", "train_00", "704", "13.6"], "{row}");
    assert!(row.contains("1689  (0.346, -0.270, 0.059)"), "{row}");
    assert_eq!(report.lines().filter(|l| l.contains("  train_")).count(), 32);
    // The rim is pinned, so nothing moves it.
    has(&report, &["do not move", "1 region", "same on both sides in x, y; examples serve both"]);
    has(&report, &["184 vertices on edges that the examples show to be held"]);
    for mesh in ["panel", "0"] {
        assert_eq!(crumple(&["info", PANEL, "--mesh", mesh]).report(), report);
    }

    let after = report.split("Examples predict each other").nth(1).expect("the section");
    let line = |name: &str| after.lines().find(|l| l.trim_start().starts_with(name)).expect(name).to_owned();
    let number = |line: &str| -> f32 {
        line.split_whitespace().nth(1).unwrap().trim_end_matches(',').parse().expect("a number")
    };
    let (median, worst) = (number(&line("error")), number(&line("worst")));
    assert!(median > 0.02 && median < 0.3 && worst > median, "{after}");
    assert!(line("worst").contains("train_") && line("worst").ends_with("one more near it would help most"), "{after}");
    // nothing to learn from one example
    let one = crumple(&["info", "tests/fixtures/nodes.glb"]).report();
    assert!(!one.contains("predict each other") && one.contains("  mirror    "), "{one}");
}

#[test]
fn info_warns_of_a_level_of_detail_far_off_the_body() {
    let Imported { mesh, examples, .. } = import(PANEL);
    let mut set = crumple::ExampleSet::build(mesh.clone(), examples, Default::default(), &crumple::Serial).unwrap();
    set.add_lod(mesh.clone(), &crumple::Serial).unwrap();
    let mut shifted = mesh;
    shifted.positions.iter_mut().for_each(|p| p[2] += 22.0);
    set.add_lod(shifted, &crumple::Serial).unwrap();
    let folder = Folder::empty();
    let report = crumple(&["info", &folder.write("levels.crumple", set.save().unwrap())]).report();
    has(&report, &["level 1   2173 vertices, at most 0.0 mm off the base surface", "warning   level 2 lies far off"]);
    assert!(!report.contains("level 1 lies"), "{report}");
}

#[test]
fn apply_dents_the_body_where_it_was_hit() {
    let folder = Folder::empty();
    let png = folder.at("a/b");
    let point = Vec3::new(-0.2, 0.1, 0.078);
    let json = r#"[{"name": "here", "point": [-0.2, 0.1, 0.078], "displacement": [0, 0, -0.025]}]"#;
    let report = apply(&folder, &[PANEL], json, &["--png", &png, "--size", "320x200"]);
    has(&report, &["here", "1 of 1 impact left a dent; the damage is 1 mark"]);

    let out = folder.at("out.glb");
    let (before, after) = (import(PANEL), dented(&out));
    assert_eq!(gltf::Gltf::open(&out).expect("a GLB").materials().next().and_then(|m| m.name()), Some("metal"));
    let moved = displacements(&before, &after);
    let (vertex, depth) = deepest(&moved);
    let away = Vec3::from(before.mesh.positions[vertex]).distance(point);
    assert!(away < 0.06 && (0.024..0.033).contains(&depth), "{depth} m, {away} m from the hit");
    has(&report, &[&format!("{:.1} mm", depth * 1e3)]);

    assert_eq!(folder.names(), ["a", "i.json", "out.glb"], "nothing temporary stays");
    let png = Path::new(&png);
    assert_eq!(names(png), ["after.png", "base.png", "before_after.png", "heat.png"]);
    let pictures = ["base", "after", "heat", "before_after"].map(|n| picture(&png.join(format!("{n}.png"))));
    for (pixels, _) in &pictures {
        let colours: std::collections::HashSet<&[u8]> = pixels.chunks(3).collect();
        assert!(colours.len() > 500, "{} colours", colours.len());
    }
    assert_ne!(pictures[0].0, pictures[1].0, "the dent shows");
    let maximum = pictures[2].1.strip_prefix("displacement, 0 to ").and_then(|t| t.strip_suffix(" mm"));
    let maximum: f32 = maximum.expect("the legend's range").parse().expect("a number");
    assert!((maximum - depth * 1e3).abs() <= 1e-4 * maximum, "{maximum} {depth}");
}

#[test]
fn apply_reads_obj_and_the_classic_rules() {
    let folder = Folder::empty();
    let obj = ["tests/fixtures/plate.obj", "--example", "tests/fixtures/plate_dent.obj"];
    let list = folder.at("sample.json");
    crumple(&[&["sample"], &obj[..], &["-o", &list, "--count", "3"]].concat()).report();
    let json = std::fs::read_to_string(list).expect("readable");
    for rule in ["marks", "most-displaced", "blend=0.5"] {
        has(&apply(&folder, &obj, &json, &["--rule", rule, "--threads", "1"]), &["on 1 thread."]);
        assert!(!dented(&folder.at("out.glb")).is_empty());
    }
}

#[test]
fn sample_is_the_same_for_the_same_seed_and_can_be_applied() {
    let folder = Folder::empty();
    let sample = |name: &str, seed: &str| {
        crumple(&["sample", PANEL, "-o", &folder.at(name), "--count", "12", "--seed", seed]).report();
        std::fs::read_to_string(folder.at(name)).expect("readable")
    };
    let (a, b, c) = (sample("a.json", "7"), sample("b.json", "7"), sample("c.json", "8"));
    assert_eq!(a, b);
    assert_ne!(a, c);
    let list: serde_json::Value = serde_json::from_str(&a).expect("JSON");
    let vector = |v: &serde_json::Value| Vec3::from_array([0, 1, 2].map(|i| v[i].as_f64().expect("a number") as f32));
    let entries = list.as_array().expect("a list");
    assert_eq!(entries.len(), 12);
    for (i, e) in entries.iter().enumerate() {
        let (p, u) = (vector(&e["point"]), vector(&e["displacement"]));
        assert!(p.abs().cmple(Vec3::new(0.6, 0.45, 0.0901)).all() && p.z >= 0.0, "{p} lies on the body");
        assert!(u.z < 0.0 && (0.007..0.059).contains(&u.length()), "{u} points inward, as deep as the examples");
        for other in &entries[..i] {
            assert!(vector(&other["point"]).distance(p) > 0.05, "spread");
        }
    }
    has(&apply(&folder, &[PANEL], &a, &[]), &["12 of 12 impacts left a dent"]);
    assert!(deepest(&displacements(&import(PANEL), &dented(&folder.at("out.glb")))).1 > 0.005);
}

#[test]
fn parts_of_one_contact_are_one_dent() {
    let folder = Folder::empty();
    let part = r#"{"point": [-0.2, 0.1, 0.078], "displacement": [0, 0, -0.0125], "contact": 7}"#;
    let report = apply(&folder, &[PANEL], &format!("[{part}, {part}]"), &[]);
    has(&report, &["2 of 2 impacts left a dent; the damage is 1 mark"]);
    let split = dented(&folder.at("out.glb"));
    apply(&folder, &[PANEL], r#"[{"point": [-0.2, 0.1, 0.078], "displacement": [0, 0, -0.025]}]"#, &[]);
    assert_eq!(split, dented(&folder.at("out.glb")));
}

#[test]
fn bake_writes_a_set_that_the_other_commands_take() {
    let folder = Folder::empty();
    let (baked, order) = (folder.at("panel.crumple"), folder.at("panel.order"));
    let options = "--tolerance 0.5mm --normal-tolerance 2deg --vertex-mass 500g --reorder";
    let options: Vec<&str> = options.split(' ').collect();
    let report = crumple(&[&["bake", PANEL, "-o", &baked, "--permutation", &order], &options[..]].concat()).report();
    has(&report, &["plain sparse displacements", "16.00"]);
    let bytes = |row: &str| -> usize {
        let row = report.lines().find(|l| l.trim_start().starts_with(row)).expect("a row");
        row.split_whitespace().find_map(|word| word.parse().ok()).expect("a number")
    };
    assert_eq!(
        (bytes("whole examples"), bytes("file")),
        (0, std::fs::metadata(&baked).expect("written").len() as usize)
    );
    assert_eq!(folder.names(), ["panel.crumple", "panel.order"]);

    let order = std::fs::read(&order).expect("written");
    let vertices: Vec<u32> = order.chunks_exact(4).map(|b| u32::from_le_bytes(b.try_into().expect("four"))).collect();
    let set = std::sync::Arc::new(crumple::ExampleSet::load_file(&baked, &crumple::Serial).expect("a set"));
    assert_eq!(set.source_order(), Some(&vertices[..]));
    let body = crumple::Instance::new(set.clone(), crumple::InstanceOptions::default()).expect("a body");
    let contact = set.mesh().positions()[0].to_array();
    let outcome = body.preview(&crumple::Hit::impulse(contact, [0.0, 0.0, -0.1], 0.01, None)).expect("a mass");
    assert_eq!(outcome.target, [0.0, 0.0, -0.002]); // 0.1 N s * 0.01 s / 0.5 kg
    has(&crumple(&["info", &baked]).report(), &["panel: 2173 vertices", "train_31"]);
    let list = folder.at("sample.json");
    crumple(&["sample", &baked, "-o", &list, "--count", "3"]).report();
    apply(&folder, &[&baked], &std::fs::read_to_string(list).expect("readable"), &[]);
    assert_eq!(dented(&folder.at("out.glb")).len(), 2173);
}
