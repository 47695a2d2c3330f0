//! What the `crumple` command does with good input.

mod cli_support;

use cli_support::{Text, asset, crumple, names};
use crumple::{
    glam::{Mat4, Vec3},
    import::{Imported, MeshChoice, gltf_slice},
};
use std::path::Path;

const PANEL: &str = "assets/solver/panel.glb";

fn import(path: &Path) -> Imported {
    let bytes = std::fs::read(path).expect("readable");
    gltf_slice(&bytes, path.parent(), MeshChoice::First).expect("a glTF")
}

/// Positions of a dented file's first primitive; its morph targets are gone, so it is no source of examples any more.
fn dented(path: &Path) -> Vec<[f32; 3]> {
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

/// Pixels of a PNG and its description.
fn picture(path: &Path) -> (Vec<u8>, String) {
    let file = std::io::BufReader::new(std::fs::File::open(path).expect("readable"));
    let mut reader = png::Decoder::new(file).read_info().expect("a PNG");
    let mut pixels = vec![0; reader.output_buffer_size().expect("a size")];
    let frame = reader.next_frame(&mut pixels).expect("pixels");
    assert_eq!((frame.width, frame.height, frame.color_type), (1280, 800, png::ColorType::Rgb));
    let text = &reader.info().uncompressed_latin1_text;
    let description = text.iter().find(|t| t.keyword == "Description").expect("a description");
    (pixels, description.text.clone())
}

#[test]
fn info_tells_what_a_file_holds() {
    let report = crumple(&["info", PANEL]).report();
    assert!(report.contains("panel: 2173 vertices, 4160 triangles, 1 primitive, 0 on seams"), "{report}");
    assert!(report.contains("1.200 x 0.900 x 0.090 m"), "{report}");
    let row = report.lines().find(|l| l.contains("train_00")).expect("a row");
    let cells: Vec<&str> = row.split_whitespace().collect();
    assert_eq!(cells[..4], ["0", "train_00", "704", "13.6"], "{row}");
    assert!(row.contains("1689  (0.346, -0.270, 0.059)") && row.ends_with("automatic"), "{row}");
    assert_eq!(report.lines().filter(|l| l.contains("train_") && l.ends_with("automatic")).count(), 32);
    // The rim is pinned: nothing moves it.
    assert!(report.contains("do not move") && report.contains("1 region"), "{report}");
}

#[test]
fn info_tells_what_the_examples_show() {
    let report = crumple(&["info", PANEL]).report();
    assert!(report.contains("same on both sides in x, y; examples serve both"), "{report}");
    assert!(report.contains("184 vertices on edges that the examples show to be held"), "{report}");
    let after = report.split("Examples predict each other").nth(1).expect("the section");
    let line = |name: &str| after.lines().find(|l| l.trim_start().starts_with(name)).expect(name).to_owned();
    let number = |line: &str| -> f32 {
        line.split_whitespace().nth(1).unwrap().trim_end_matches(',').parse().expect("a number")
    };
    let (median, worst) = (number(&line("error")), number(&line("worst")));
    assert!(median > 0.02 && median < 0.3 && worst > median, "{after}");
    assert!(line("worst").contains("train_") && line("worst").ends_with("one more near it would help most"), "{after}");
    assert!(line("reach").ends_with("over 1.3 diagonals"), "{after}");
    assert!(line("placement").contains("carry them"), "{after}");
    // nothing to learn from one example
    let one = crumple(&["info", "tests/fixtures/nodes.glb"]).report();
    assert!(!one.contains("predict each other") && one.contains("  mirror    "), "{one}");
}

#[test]
fn info_chooses_a_mesh_by_name_and_by_index() {
    let by_name = crumple(&["info", PANEL, "--mesh", "panel"]).report();
    assert_eq!(by_name, crumple(&["info", PANEL, "--mesh", "0"]).report());
}

#[test]
fn apply_dents_the_body_where_it_was_hit() {
    let folder = tempfile::tempdir().expect("a directory");
    let (list, out, png) = (folder.path().join("i.json"), folder.path().join("out.glb"), folder.path().join("a/b"));
    let point = Vec3::new(-0.2, 0.1, 0.078);
    let json = r#"[{"name": "here", "point": [-0.2, 0.1, 0.078], "displacement": [0, 0, -0.025]}]"#;
    std::fs::write(&list, json).expect("written");
    let arguments = ["apply", PANEL, "--impacts", list.text(), "-o", out.text(), "--png", png.text()];
    let report = crumple(&arguments).report();
    assert!(report.contains("here") && report.contains("1 of 1 impact left a dent; the damage is 1 mark"), "{report}");

    let (before, after) = (import(&asset(PANEL)), dented(&out));
    assert_eq!(gltf::Gltf::open(&out).expect("a GLB").materials().next().and_then(|m| m.name()), Some("metal"));
    let moved = displacements(&before, &after);
    let (vertex, depth) = deepest(&moved);
    assert!(Vec3::from(before.mesh.positions[vertex]).distance(point) < 0.05, "vertex {vertex}");
    // the contact gets what was asked for; the dent may be a little deeper beside it
    let distance = |v: &usize| Vec3::from(before.mesh.positions[*v]).distance(point);
    let contact = (0..moved.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).expect("a vertex");
    assert!((moved[contact] - 0.025).abs() < 0.001 && depth < 1.2 * moved[contact], "{} {depth}", moved[contact]);
    assert!(report.contains(&format!("{:.1} mm", depth * 1e3)), "{report}");

    assert_eq!(names(folder.path()), ["a", "i.json", "out.glb"], "nothing temporary stays");
    assert_eq!(names(&png), ["after.png", "base.png", "before_after.png", "heat.png"]);
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
fn apply_takes_impulses_and_world_space() {
    let folder = tempfile::tempdir().expect("a directory");
    let file = "tests/fixtures/nodes.glb";
    let source = import(&asset(file));
    let to_world = Mat4::from_cols_array_2d(&source.node_transform.expect("a node"));
    let contact = Vec3::from(source.mesh.positions[0]);
    let push = Vec3::new(0.01, -0.03, 0.02);
    let (point, shift) = (to_world.transform_point3(contact), to_world.transform_vector3(push));
    let run = |name: &str, json: String| {
        let (list, out) = (folder.path().join("i.json"), folder.path().join(name));
        std::fs::write(&list, json).expect("written");
        let report = crumple(&["apply", file, "--impacts", list.text(), "-o", out.text()]).report();
        let row = report.lines().nth(1).expect("a row").to_owned();
        row.split_whitespace().skip(1).take(5).map(str::to_owned).collect::<Vec<_>>()
    };
    let list = |v: Vec3| format!("[{}, {}, {}]", v.x, v.y, v.z);
    let local = run("a.glb", format!(r#"[{{"point": {}, "displacement": {}}}]"#, list(contact), list(push)));
    let world = format!(r#"[{{"point": {}, "displacement": {}, "space": "world"}}]"#, list(point), list(shift));
    assert_eq!(local, run("b.glb", world));
    let impulse =
        format!(r#"[{{"point": {}, "impulse": {}, "duration": 0.5, "mass": 2}}]"#, list(contact), list(push * 4.0));
    assert_eq!(local, run("c.glb", impulse));
}

#[test]
fn apply_reads_obj_and_the_literatures_rules() {
    let folder = tempfile::tempdir().expect("a directory");
    let (list, out) = (folder.path().join("i.json"), folder.path().join("out.glb"));
    let obj = ["tests/fixtures/plate.obj", "--example", "tests/fixtures/plate_dent.obj"];
    assert_eq!(crumple(&["sample", obj[0], obj[1], obj[2], "-o", list.text(), "--count", "3"]).code, Some(0));
    for rule in ["marks", "most-displaced", "blend=0.5"] {
        let arguments = [
            "apply",
            obj[0],
            obj[1],
            obj[2],
            "--impacts",
            list.text(),
            "-o",
            out.text(),
            "--rule",
            rule,
            "--threads",
            "1",
        ];
        let report = crumple(&arguments).report();
        assert!(report.contains("on 1 thread."), "{report}");
        assert!(!dented(&out).is_empty());
    }
    let classic =
        ["apply", obj[0], obj[1], obj[2], "--impacts", list.text(), "-o", out.text(), "--selection", "classic"];
    crumple(&classic).report();
}

#[test]
fn sample_is_the_same_for_the_same_seed_and_can_be_applied() {
    let folder = tempfile::tempdir().expect("a directory");
    let sample = |name: &str, seed: &str| {
        let path = folder.path().join(name);
        crumple(&["sample", PANEL, "-o", path.text(), "--count", "12", "--seed", seed]).report();
        std::fs::read_to_string(path).expect("readable")
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
    let (list, out) = (folder.path().join("a.json"), folder.path().join("out.glb"));
    let report = crumple(&["apply", PANEL, "--impacts", list.text(), "-o", out.text()]).report();
    assert!(report.contains("12 of 12 impacts left a dent"), "{report}");
    let (before, after) = (import(&asset(PANEL)), dented(&out));
    assert!(deepest(&displacements(&before, &after)).1 > 0.005);
}

#[test]
fn apply_gives_the_same_file_on_any_number_of_threads() {
    let folder = tempfile::tempdir().expect("a directory");
    let list = folder.path().join("i.json");
    crumple(&["sample", PANEL, "-o", list.text()]).report();
    let run = |threads: &str| {
        let out = folder.path().join(format!("{threads}.glb"));
        crumple(&["apply", PANEL, "--impacts", list.text(), "-o", out.text(), "--threads", threads]).report();
        std::fs::read(out).expect("readable")
    };
    assert!(run("1") == run("8"));
}

#[test]
fn parts_of_one_contact_are_one_dent() {
    let folder = tempfile::tempdir().expect("a directory");
    let (list, out) = (folder.path().join("i.json"), folder.path().join("out.glb"));
    let apply = |json: &str, rule: &str| {
        std::fs::write(&list, json).expect("written");
        crumple(&["apply", PANEL, "--impacts", list.text(), "-o", out.text(), "--rule", rule])
    };
    let part = r#"{"point": [-0.2, 0.1, 0.078], "displacement": [0, 0, -0.0125], "contact": 7}"#;
    let report = apply(&format!("[{part}, {part}]"), "marks").report();
    assert!(report.contains("2 of 2 impacts left a dent; the damage is 1 mark"), "{report}");
    let split = dented(&out);
    apply(r#"[{"point": [-0.2, 0.1, 0.078], "displacement": [0, 0, -0.025]}]"#, "marks").report();
    assert_eq!(split, dented(&out));
    let complaint = apply(&format!("[{part}]"), "most-displaced").complaint();
    assert!(complaint.contains("contact id") && complaint.contains("rule Marks"), "{complaint}");
    let complaint = apply(&format!("[{}]", part.replace('7', "0")), "marks").complaint();
    assert!(complaint.contains("impact 0: contact is 0; it must be a whole number above 0"), "{complaint}");
}

#[test]
fn bake_writes_a_set_that_the_other_commands_take() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).to_str().expect("UTF-8").to_owned();
    let (baked, order) = (at("panel.crumple"), at("panel.order"));
    let report = crumple(&[
        "bake",
        PANEL,
        "-o",
        &baked,
        "--tolerance",
        "0.5mm",
        "--normal-tolerance",
        "2deg",
        "--stamp-resolution",
        "8",
        "--vertex-mass",
        "500g",
        "--reorder",
        "--permutation",
        &order,
    ])
    .report();
    assert!(report.contains("plain sparse displacements") && report.contains("16.00"), "{report}");
    let row = report.lines().find(|l| l.trim_start().starts_with("positions")).expect("a row");
    let numbers: Vec<f64> = row.split_whitespace().filter_map(|w| w.parse().ok()).collect();
    assert!(numbers[0] <= 0.5 && numbers[0] > 0.1 && numbers[1] < numbers[0] && numbers[2] == 0.5, "{row}");
    // Eight nodes a side cannot hold half a millimetre, and that is said.
    assert!(report.contains("of 32 stamps hold the tolerance when carried"), "{report}");
    assert_eq!(names(folder.path()), ["panel.crumple", "panel.order"]);

    let mut vertices: Vec<u32> = std::fs::read(&order)
        .expect("written")
        .chunks_exact(4)
        .map(|b| u32::from_le_bytes(b.try_into().expect("four")))
        .collect();
    let set = crumple::ExampleSet::load_file(&baked, &crumple::Serial).expect("a set");
    assert_eq!(set.source_order(), Some(&vertices[..]));
    let set = std::sync::Arc::new(set);
    let body = crumple::Instance::new(set.clone(), crumple::InstanceOptions::default()).expect("a body");
    let contact = set.mesh().positions()[0].to_array();
    let told = body.preview(&crumple::Hit::impulse(contact, [0.0, 0.0, -0.1], 0.01, None)).expect("a mass");
    assert_eq!(told.target, [0.0, 0.0, -0.002]); // 0.1 N s * 0.01 s / 0.5 kg
    let source = import(&asset(PANEL));
    for (v, old) in vertices.iter().enumerate() {
        assert_eq!(set.mesh().positions()[v].to_array(), source.mesh.positions[*old as usize]);
    }
    vertices.sort_unstable();
    assert!(vertices.into_iter().eq(0..2173));

    let info = crumple(&["info", &baked]).report();
    assert!(info.contains("panel: 2173 vertices") && info.contains("train_31"), "{info}");
    let (impacts, dented_file) = (at("impacts.json"), at("dented.glb"));
    crumple(&["sample", &baked, "-o", &impacts, "--count", "3"]).report();
    crumple(&["apply", &baked, "--impacts", &impacts, "-o", &dented_file]).report();
    assert_eq!(dented(Path::new(&dented_file)).len(), 2173);
}

#[test]
fn replay_makes_the_calls_of_a_recording_again() {
    let report = crumple(&["replay", "tests/fixtures/sheet.crumplerec"]).report();
    assert!(report.contains("recorded by 0.1.0"), "{report}");
    assert!(
        report.contains("53 calls (21 hits among them) match the recording; 20 deforms wrote 6973 vertices"),
        "{report}"
    );
    assert!(report.contains("repair_damage: CRUMPLE_ERROR_NOT_FINITE: keep is NaN"), "{report}");
    assert!(!report.contains("no end"), "{report}");

    let listed = crumple(&["replay", "--list", "--threads", "1", "tests/fixtures/sheet.crumplerec"]).report();
    assert!(listed.contains("    14  crumple_context_deform: Deform { buffers: [1, 2] }\n"), "{listed}");
    assert_eq!(listed.lines().count(), 53 + report.lines().count());
}

#[test]
fn replay_of_what_a_crash_left_goes_as_far_as_it_does() {
    let folder = tempfile::tempdir().expect("a directory");
    let path = folder.path().join("cut.crumplerec");
    let bytes = std::fs::read("tests/fixtures/sheet.crumplerec").expect("readable");
    std::fs::write(&path, &bytes[..bytes.len() - 700]).expect("writable");
    let report = crumple(&["replay", path.to_str().expect("UTF-8")]).report();
    assert!(
        report.contains("the recording has no end: the program ended, perhaps inside the last of these calls"),
        "{report}"
    );
}
