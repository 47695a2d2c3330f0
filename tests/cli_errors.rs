//! What the `crumple` command says of bad input: one line that names what was wrong, exit code 1, nothing half written.

mod cli_support;

use cli_support::{Text, crumple, names};
use std::path::Path;
use tempfile::TempDir;

const PANEL: &str = "assets/solver/panel.glb";
const GOOD: &str = r#"[{"point": [0, 0, 0.09], "displacement": [0, 0, -0.02]}]"#;

fn folder() -> TempDir {
    tempfile::tempdir().expect("a directory")
}

fn write(folder: &TempDir, name: &str, bytes: impl AsRef<[u8]>) -> String {
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).expect("written");
    path.text().to_owned()
}

/// Complaint about a list of impacts; nothing may be left behind.
#[track_caller]
fn impacts(json: impl AsRef<[u8]>) -> String {
    let folder = folder();
    let list = write(&folder, "impacts.json", json);
    let out = folder.path().join("out.glb");
    let line = crumple(&["apply", PANEL, "--impacts", &list, "-o", out.text()]).complaint();
    assert_eq!(names(folder.path()), ["impacts.json"]);
    assert!(line.contains("impacts.json"), "{line}");
    line
}

/// Complaint about a source file.
#[track_caller]
fn source(path: &str, more: &[&str]) -> String {
    let mut arguments = vec!["info", path];
    arguments.extend(more);
    crumple(&arguments).complaint()
}

#[track_caller]
fn has(line: &str, parts: &[&str]) {
    for part in parts {
        assert!(line.contains(part), "'{part}' is not in: {line}");
    }
}

#[test]
fn impacts_that_are_not_a_list() {
    has(&impacts(""), &["not JSON"]);
    has(&impacts("[{]"), &["not JSON", "line 1 column 3"]);
    has(&impacts("{}"), &["not a list of impacts, [{…}, …]"]);
    has(&impacts("[]"), &["empty"]);
    has(&impacts(b"[\xff]"), &["not UTF-8 at byte 1"]);
    has(&impacts("[1]"), &["impact 0: the impact is 1; it must be an object {…}"]);
    has(&source(&write(&folder(), "list.json", GOOD), &[]), &["list.json holds no mesh", ".crumple"]);
}

#[test]
fn impacts_with_wrong_keys() {
    let unknown = r#"[{"point": [0,0,0], "displacement": [0,0,-1]}, {"point": [0,0,0], "displacment": [0,0,-1]}]"#;
    has(&impacts(unknown), &["impact 1", "unknown field `displacment`", "`displacement`"]);
    has(&impacts(r#"[{"displacement": [0,0,-1]}]"#), &["impact 0", "missing field `point`"]);
    has(&impacts(r#"[{"point": [0,0,0]}]"#), &["impact 0", "neither 'displacement' (m) nor 'impulse' (N s)"]);
    has(&impacts(r#"[{"point": [0,0,0], "displacement": [0,0,1], "impulse": [0,0,1]}]"#), &["both"]);
    has(&impacts(r#"[{"point": [0,0,0], "displacement": [0,0,1], "mass": 1}]"#), &["'mass' needs 'impulse'"]);
    has(&impacts(r#"[{"point": [0,0,0], "impulse": [0,0,1], "mass": 1}]"#), &["'impulse' needs 'duration'"]);
    has(&impacts(r#"[{"point": [0,0], "displacement": [0,0,1]}]"#), &["impact 0: point has 2 numbers; it must have 3"]);
    has(
        &impacts(r#"[{"point": [0,0,0], "displacement": [0,0,1], "space": "wrold"}]"#),
        &["unknown variant `wrold`", "`local` or `world`"],
    );
    has(&impacts(r#"[{"point": [0,0,0], "point": [0,0,0], "displacement": [0,0,1]}]"#), &["duplicate field `point`"]);
}

#[test]
fn impacts_with_bad_numbers() {
    has(
        &impacts(r#"[{"point": [0,0,1e999], "displacement": [0,0,1]}]"#),
        &["impact 0: point[2]: 1e999 is out of range"],
    );
    let second = "[\n{\"point\": [0,0,0], \"displacement\": [0,0,-0.01]},\n{\"point\": [0,0,0],\n\"displacement\": [0,-1e999,0]}]";
    has(&impacts(second), &["impact 1", "-1e999"]);
    has(&impacts(r#"[{"point": [0,4e38,0], "displacement": [0,0,1]}]"#), &["impact 0", "point[1] is 4e38"]);
    has(
        &impacts(r#"[{"point": [0,0,0], "impulse": [0,0,1], "duration": 0, "mass": 1}]"#),
        &["duration is 0", "above 0"],
    );
    has(&impacts(r#"[{"point": [0,0,0], "impulse": [0,0,1], "duration": 1, "mass": -2}]"#), &["mass is -2", "above 0"]);
    has(
        &impacts(r#"[{"point": [0,0,0], "impulse": [0,0,1], "duration": 1e-60, "mass": 1}]"#),
        &["duration", "above 0"],
    );
    has(&impacts(r#"[{"point": [0,0,NaN], "displacement": [0,0,1]}]"#), &["not JSON"]);
    has(
        &impacts(r#"[{"point": [0,0,"1"], "displacement": [0,0,1]}]"#),
        &["impact 0: point[2] is the text \"1\"; it must be a number"],
    );
    for (value, is) in [("{}", "an object {…}"), ("true", "true"), ("null", "null"), ("[0]", "a list")] {
        let json = format!(r#"[{{"point": [0,{value},0], "displacement": [0,0,1]}}]"#);
        has(&impacts(json), &[&format!("impact 0: point[1] is {is}; it must be a number")]);
    }
    has(&impacts(r#"[{"point": 7, "displacement": [0,0,1]}]"#), &["point is 7; it must be a list of 3 numbers"]);
    let contact = r#"[{"point": [0,0,0], "displacement": [0,0,1], "contact": 0}]"#;
    has(&impacts(contact), &["contact is 0; it must be a whole number above 0"]);
    has(
        &impacts(r#"[{"point": [5000,0,0], "displacement": [0,0,-0.01]}]"#),
        &["impact 0", "5000", "from the nearest vertex"],
    );
}

#[test]
fn huge_and_tiny_hits_are_no_errors() {
    let folder = folder();
    let json =
        r#"[{"point": [0,0,0.09], "displacement": [0,0,-1e30]}, {"point": [0,0,0.09], "displacement": [0,0,-1e-30]}]"#;
    let (list, out) = (write(&folder, "i.json", json), folder.path().join("out.glb"));
    let report = crumple(&["apply", PANEL, "--impacts", &list, "-o", out.text()]).report();
    has(&report, &["1 of 2 impacts left a dent", "below yield"]);
    has(&report, &["Warning: 1 impact asked for more than the depth limit", "impact 0 asked for"]);
    let far = GOOD.replace("0.09]", "0.39], \"name\": \"miss\"");
    let far = write(&folder, "far.json", far);
    let report = crumple(&["apply", PANEL, "--impacts", &far, "-o", out.text()]).report();
    has(&report, &["Warning: 1 impact lies more than", "impact 0 'miss' is", "mm off"]);
    let report = crumple(&["apply", PANEL, "--impacts", &write(&folder, "good.json", GOOD), "-o", out.text()]).report();
    assert!(!report.contains("Warning"), "{report}");
}

#[test]
fn missing_files_are_named() {
    has(&source("no/such.glb", &[]), &["cannot read no/such.glb", "No such file"]);
    has(&source("assets", &[]), &["cannot read assets", "directory"]);
    let folder = folder();
    let (list, out) = (write(&folder, "i.json", GOOD), folder.path().join("o.glb"));
    let apply = |file: &str, list: &str| crumple(&["apply", file, "--impacts", list, "-o", out.text()]).complaint();
    has(&apply(PANEL, "none.json"), &["cannot read none.json"]);
    has(&apply("none.glb", &list), &["cannot read none.glb"]);
    has(&source("no.obj", &["--example", "a.obj"]), &["no.obj"]);
    has(&source("tests/fixtures/plate.obj", &["--example", "none.obj"]), &["none.obj"]);
    assert_eq!(names(folder.path()), ["i.json"]);
}

#[test]
fn files_that_are_not_what_they_say() {
    let folder = folder();
    has(&source(&write(&folder, "a.glb", "\u{89}PNG"), &[]), &["a.glb", "neither a GLB", "a glTF"]);
    has(&source(&write(&folder, "b.glb", ""), &[]), &["b.glb", "neither a GLB"]);
    has(&source(&write(&folder, "c.gltf", "{]"), &[]), &["c.gltf", "malformed"]);
    has(&source(&write(&folder, "d.glb", "glTF\x02\0\0\0\x0c\0\0\0"), &[]), &["d.glb", "malformed"]);
    let whole = std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join(PANEL)).expect("readable");
    has(&source(&write(&folder, "e.glb", &whole[..whole.len() / 2]), &[]), &["e.glb", "malformed"]);
    has(&source(&write(&folder, "f.obj", &whole[..100]), &["--example", "tests/fixtures/plate.obj"]), &["f.obj"]);
}

#[test]
fn files_without_examples_or_meshes() {
    let folder = folder();
    has(&source(&write(&folder, "empty.gltf", r#"{"asset": {"version": "2.0"}}"#), &[]), &["empty.gltf", "mesh"]);
    let (list, out) = (write(&folder, "i.json", GOOD), folder.path().join("out.glb"));
    crumple(&["apply", PANEL, "--impacts", &list, "-o", out.text()]).report();
    has(&source(out.text(), &[]), &["out.glb", "morph target"]);
    has(&source("tests/fixtures/plate.obj", &[]), &["plate.obj", "--example"]);
    has(&source(PANEL, &["--mesh", "bonnet"]), &["bonnet", "panel"]);
    has(&source(PANEL, &["--mesh", "3"]), &["3", "panel"]);
    has(&source(PANEL, &["--example", "a.obj"]), &["--example needs an OBJ base"]);
    has(&source("tests/fixtures/plate.obj", &["--mesh", "a"]), &["--mesh chooses a mesh of a glTF file"]);
}

#[test]
fn places_that_cannot_be_written() {
    let folder = folder();
    let list = write(&folder, "i.json", GOOD);
    let apply = |out: &str, more: &[&str]| {
        let mut arguments = vec!["apply", PANEL, "--impacts", list.as_str(), "-o", out];
        arguments.extend(more);
        crumple(&arguments).complaint()
    };
    let inside = |name: &str| folder.path().join(name).text().to_owned();
    has(&apply(&inside("no/out.glb"), &[]), &["cannot write", "out.glb", "there is no directory"]);
    let directory = inside("directory.glb");
    std::fs::create_dir(&directory).expect("made");
    has(&apply(&directory, &[]), &["cannot write", "it is a directory"]);
    std::fs::remove_dir(&directory).expect("removed");
    for name in ["d.obj", "d", "d.gltf"] {
        has(&apply(&inside(name), &[]), &["cannot write", name, "writes a GLB", ".glb"]);
    }
    has(&crumple(&["bake", PANEL, "-o", &inside("set.glb")]).complaint(), &["set.glb", "writes a .crumple file"]);
    has(&crumple(&["sample", PANEL, "-o", &inside("list.txt")]).complaint(), &["list.txt", "writes JSON", ".json"]);
    has(&apply(&inside("i.json/out.glb"), &[]), &["cannot write", "there is no directory"]);
    has(&apply(&inside("out.glb"), &["--png", &list]), &["i.json", "directory"]);
    let line = crumple(&["sample", PANEL, "-o", &inside("no/i.json")]).complaint();
    has(&line, &["cannot write", "no/i.json"]);
    assert_eq!(names(folder.path()), ["i.json"], "nothing half written stays");

    let copy = inside("panel.glb");
    std::fs::copy(Path::new(env!("CARGO_MANIFEST_DIR")).join(PANEL), &copy).expect("copied");
    has(&crumple(&["apply", &copy, "--impacts", &list, "-o", &copy]).complaint(), &["is the input"]);
    assert_eq!(names(folder.path()), ["i.json", "panel.glb"]);
}

#[test]
fn wrong_usage_is_exit_code_two() {
    let usage = |arguments: &[&str], part: &str| {
        let run = crumple(arguments);
        assert_eq!(run.code, Some(2), "{arguments:?}: {}", run.stderr);
        has(&run.stderr, &[part]);
    };
    usage(&[], "Usage");
    usage(&["dent"], "dent");
    usage(&["info"], "<FILE>");
    usage(&["apply", PANEL, "-o", "x.glb"], "--impacts");
    let apply = ["apply", PANEL, "--impacts", "i.json", "-o", "x.glb"];
    let with = |more: &[&'static str]| [&apply[..], more].concat();
    usage(&with(&["--rule", "blend=2"]), "from 0 to 1");
    usage(&with(&["--rule", "sum"]), "marks, most-displaced or blend=K");
    usage(&with(&["--examples", "5"]), "1..=4");
    usage(&with(&["--threads", "-1"]), "-1");
    usage(&["sample", PANEL, "-o", "i.json", "--count", "0"], "--count");
    assert_eq!(crumple(&["--version"]).code, Some(0));
    assert_eq!(crumple(&["apply", "--help"]).code, Some(0));
}

#[test]
fn a_rule_and_a_selection_that_do_not_go_together() {
    let folder = folder();
    let (list, out) = (write(&folder, "i.json", GOOD), folder.path().join("out.glb"));
    let arguments =
        ["apply", PANEL, "--impacts", &list, "-o", out.text(), "--rule", "most-displaced", "--selection", "nearest"];
    has(&crumple(&arguments).complaint(), &["selection"]);
    assert_eq!(names(folder.path()), ["i.json"]);
}

#[test]
fn bake_says_what_is_wrong() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).to_str().expect("UTF-8").to_owned();
    let (panel, out) = ("assets/solver/panel.glb", at("out.crumple"));
    for (tolerance, part) in
        [("1km", "'km'"), ("0", "above 0"), ("-1mm", "above 0"), ("much", "length"), ("0,1mm", "',1mm'")]
    {
        let run = crumple(&["bake", panel, "-o", &out, &format!("--tolerance={tolerance}")]);
        assert!(run.code == Some(2) && run.stderr.contains(part), "{tolerance}: {}", run.stderr);
    }
    let run = crumple(&["bake", panel, "-o", &out, "--permutation", &at("order")]);
    assert!(run.code == Some(2) && run.stderr.contains("--reorder"), "{}", run.stderr);

    crumple(&["bake", panel, "-o", &out, "--tolerance", "1mm", "--stamp-resolution", "4"]).report();
    let again = crumple(&["bake", &out, "-o", &at("again.crumple")]).complaint();
    assert!(again.contains("baked already"), "{again}");
    let mesh = crumple(&["info", &out, "--mesh", "0"]).complaint();
    assert!(mesh.contains("--mesh"), "{mesh}");
    let mut bytes = std::fs::read(&out).expect("written");
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(&out, bytes).expect("written");
    let damaged = crumple(&["info", &out]).complaint();
    assert!(damaged.contains("checksum") && damaged.contains("out.crumple"), "{damaged}");
}

#[test]
fn replay_says_what_is_no_recording_and_where_one_is_damaged() {
    let folder = folder();
    has(&crumple(&["replay", "no/such/file"]).complaint(), &["no/such/file", "No such file"]);
    has(&crumple(&["replay", PANEL]).complaint(), &["panel.glb", "this is no recording"]);
    let mut bytes = std::fs::read("tests/fixtures/sheet.crumplerec").expect("readable");
    let last = bytes.len() - 1000;
    bytes[last] ^= 1;
    let damaged = write(&folder, "damaged.crumplerec", bytes);
    has(&crumple(&["replay", &damaged]).complaint(), &["damaged.crumplerec", "event ", " at byte ", "checksum"]);
}
