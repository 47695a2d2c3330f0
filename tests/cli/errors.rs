//! The `crumple` command with bad input: one line that names what was wrong, exit code 1, and no half-written file.

use crate::{Folder, PANEL, asset, crumple, has};

const GOOD: &str = r#"[{"point": [0, 0, 0.09], "displacement": [0, 0, -0.02]}]"#;

/// Runs `crumple` with these words, in which `IN` stands for the folder, and checks that the message has these parts.
#[track_caller]
fn refused(folder: &Folder, words: &str, parts: &[&str]) {
    let words: Vec<String> =
        words.split(' ').map(|w| w.replace("IN", &folder.at("")).replace("PANEL", PANEL)).collect();
    has(&crumple(&words.iter().map(String::as_str).collect::<Vec<_>>()).complaint(), parts);
}

/// The tests of the messages are beside the parser, in `src/bin/crumple/impacts.rs`.
#[test]
fn bad_impacts_are_named_with_their_file() {
    let folder = Folder::empty();
    folder.write("i.json", r#"[{"point": [0,0,0], "displacment": [0,0,-1]}]"#);
    refused(&folder, "apply PANEL --impacts INi.json -o INout.glb", &["i.json: impact 0: unknown field `displacment`"]);
    folder.write("i.json", r#"[{"point": [5000,0,0], "displacement": [0,0,-0.01]}]"#);
    let far = &["i.json: impact 0", "5000", "from the nearest vertex"];
    refused(&folder, "apply PANEL --impacts INi.json -o INout.glb", far);
    folder.write("i.json", r#"[{"point": [0,0,0], "displacement": [0,0,-1], "contact": 7}]"#);
    let apply = "apply PANEL --impacts INi.json -o INout.glb --rule most-displaced";
    refused(&folder, apply, &["contact id", "rule Marks"]);
    assert_eq!(folder.names(), ["i.json"]);
}

#[test]
fn numbers_in_the_wrong_unit_are_warned_of() {
    let folder = Folder::empty();
    let report = |json: &str| {
        let (list, out) = (folder.write("i.json", json), folder.at("out.glb"));
        crumple(&["apply", PANEL, "--impacts", &list, "-o", &out]).report()
    };
    let huge = &GOOD[1..GOOD.len() - 1].replace("-0.02", "-1e30");
    let huge_and_tiny = report(&format!("[{huge}, {}]", huge.replace("1e30", "1e-30")));
    has(&huge_and_tiny, &["1 of 2 impacts left a dent", "below yield"]);
    has(&huge_and_tiny, &["Warning: 1 impact asked for more than the depth limit", "impact 0 asked for"]);
    let missed = report(&GOOD.replace("0.09]", "0.39], \"name\": \"miss\""));
    has(&missed, &["Warning: 1 impact lies more than", "impact 0 'miss' is", "mm off"]);
    assert!(!report(GOOD).contains("Warning"));
}

#[test]
fn files_that_are_missing_or_something_else() {
    let folder = Folder::empty();
    folder.write("i.json", GOOD);
    folder.write("png.glb", b"\x89PNG");
    crumple(&["apply", PANEL, "--impacts", &folder.at("i.json"), "-o", &folder.at("dented.glb")]).report();
    let before = folder.names();
    for (words, parts) in [
        ("info no/such.glb", &["cannot read no/such.glb", "(os error "][..]),
        ("info assets", &["cannot read assets", "(os error "]),
        ("apply PANEL --impacts none.json -o INo.glb", &["cannot read none.json"]),
        ("apply none.glb --impacts INi.json -o INo.glb", &["cannot read none.glb"]),
        ("info no.obj --example a.obj", &["no.obj"]),
        ("info tests/fixtures/plate.obj --example none.obj", &["none.obj"]),
        ("info INpng.glb", &["png.glb", "neither a GLB", "a glTF"]),
        ("info INi.json", &["i.json holds no mesh", ".crumple"]),
        ("info INdented.glb", &["dented.glb", "morph target"]),
        ("info tests/fixtures/plate.obj", &["plate.obj", "--example"]),
        ("info PANEL --example a.obj", &["--example needs an OBJ base"]),
        ("info tests/fixtures/plate.obj --mesh a", &["--mesh is for glTF files", "--nodes"]),
    ] {
        refused(&folder, words, parts);
    }
    assert_eq!(folder.names(), before);
}

#[test]
fn places_that_cannot_be_written() {
    let folder = Folder::empty();
    folder.write("i.json", GOOD);
    std::fs::create_dir(folder.at("directory.glb")).expect("made");
    std::fs::copy(asset(PANEL), folder.at("panel.glb")).expect("copied");
    let before = folder.names();
    for (out, parts) in [
        ("INno/out.glb", &["cannot write", "out.glb", "there is no directory"][..]),
        ("INdirectory.glb", &["cannot write", "it is a directory"]),
        ("INi.json/out.glb", &["cannot write", "there is no directory"]),
        ("INout.glb --png INi.json", &["i.json", "directory"]),
        ("INd.obj", &["cannot write", "d.obj", "writes a GLB", ".glb"]),
        ("INd", &["cannot write", "writes a GLB", ".glb"]),
        ("INd.gltf", &["cannot write", "d.gltf", "writes a GLB", ".glb"]),
    ] {
        refused(&folder, &format!("apply PANEL --impacts INi.json -o {out}"), parts);
    }
    refused(&folder, "apply INpanel.glb --impacts INi.json -o INpanel.glb", &["is the input"]);
    refused(&folder, "sample PANEL -o INno/i.json", &["cannot write", "no/i.json"]);
    refused(&folder, "sample PANEL -o INlist.txt", &["list.txt", "writes JSON", ".json"]);
    refused(&folder, "bake PANEL -o INset.glb", &["set.glb", "writes a .crumple file"]);
    assert_eq!(folder.names(), before, "nothing half written stays");
}

#[test]
fn wrong_usage_is_exit_code_two() {
    for (words, part) in [
        ("dent", "dent"),
        ("info", "<FILE>"),
        ("apply PANEL --impacts i.json -o x.glb --rule blend=2", "from 0 to 1"),
        ("apply PANEL --impacts i.json -o x.glb --rule sum", "marks, most-displaced or blend=K"),
        ("apply PANEL --impacts i.json -o x.glb --size 320", "WIDTHxHEIGHT"),
        ("apply PANEL --impacts i.json -o x.glb --size 63x40", "from 64x40 to 8192x8192"),
        ("bake PANEL -o x.crumple --tolerance=1km", "'km'"),
        ("bake PANEL -o x.crumple --permutation order", "--reorder"),
    ] {
        let words: Vec<&str> = words.split(' ').map(|w| if w == "PANEL" { PANEL } else { w }).collect();
        let run = crumple(&words);
        assert_eq!(run.code, Some(2), "{words:?}: {}", run.stderr);
        has(&run.stderr, &[part]);
    }
    let bare = crumple(&[]);
    assert_eq!(bare.code, Some(2));
    has(&bare.stderr, &["Usage"]);
    assert_eq!(crumple(&["--version"]).code, Some(0));
    assert_eq!(crumple(&["apply", "--help"]).code, Some(0));
}

#[test]
fn baked_sets_are_not_sources_and_damage_in_them_is_found() {
    let folder = Folder::empty();
    refused(&folder, "bake PANEL -o INout.crumple --tolerance 0.1", &["tolerance is 0.1 m", "did you mean 0.1 mm?"]);
    assert!(folder.names().is_empty());
    let out = folder.at("out.crumple");
    crumple(&["bake", PANEL, "-o", &out, "--tolerance", "1mm"]).report();
    refused(&folder, "bake INout.crumple -o INagain.crumple", &["baked already"]);
    refused(&folder, "info INout.crumple --mesh 0", &["is a baked set", "give these options to `crumple bake`"]);
    let mut bytes = std::fs::read(&out).expect("written");
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(&out, bytes).expect("written");
    refused(&folder, "info INout.crumple", &["checksum", "out.crumple"]);
}
