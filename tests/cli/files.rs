//! Files as people have them. Each folder in `tests/files` is a case: files, and `case.json`, which says what to run and what holds.
//! The folders are named after the kind of file. `cargo xtask sweep` runs the same comparison over any folder.

use crate::{asset, compare, crumple_in};
use serde_json::Value;
use std::path::{Path, PathBuf};
/// The keys of `case.json`, or of each case of its list:
///
/// - `about`: the kind of file, in a sentence.
/// - `run`: command lines; without it `in.gltf` or `in.glb` is applied to `hits.json`. `error`: the last one fails.
/// - `says`, `never`: texts that the output has, or has not.
/// - `of`: the file of which `o.glb` was made, that of a case without `run` anyway; they may differ only where a dent reached.
/// - `moved`: how many vertices of triangles moved: a number, or the least and the most.
/// - `is`: values in `o.glb` by JSON pointer; `{n}` after that of an accessor's index is its n-th element.
const KEYS: [&str; 8] = ["about", "run", "error", "says", "never", "of", "moved", "is"];

fn cases(folder: &Path) -> Vec<Value> {
    let text = std::fs::read_to_string(folder.join("case.json")).unwrap();
    match serde_json::from_str(&text).unwrap_or_else(|e| panic!("{}: {e}", folder.display())) {
        Value::Array(cases) => cases,
        one => vec![one],
    }
}

fn check(folder: &Path, case: &Value) -> Vec<String> {
    let mut wrong: Vec<String> =
        case.as_object().unwrap().keys().filter(|k| !KEYS.contains(&k.as_str())).cloned().collect();
    let work = tempfile::tempdir().unwrap();
    copy(folder, work.path());
    let texts = |key: &str| -> Vec<String> {
        case[key].as_array().into_iter().flatten().map(|v| v.as_str().unwrap().to_owned()).collect()
    };
    let mut printed = String::new();
    let (mut lines, mut of) = (texts("run"), case["of"].as_str());
    if lines.is_empty() {
        of = ["in.gltf", "in.glb"].into_iter().find(|name| folder.join(name).exists());
        lines.push(format!("apply {} --impacts hits.json -o o.glb", of.unwrap()));
    }
    for (i, line) in lines.iter().enumerate() {
        let run = crumple_in(work.path(), &line.split(' ').collect::<Vec<_>>());
        let (text, should_fail) = (run.text(), case["error"] == true && i + 1 == lines.len());
        if run.is_good() == should_fail {
            wrong.push(format!("'{line}' {}", if should_fail { "succeeded" } else { "failed" }));
        }
        // A message that fits into three lines of a terminal.
        let long = text.lines().find(|l| (l.contains("arning") || l.starts_with("error")) && l.chars().count() > 300);
        wrong.extend(long.map(|l| format!("a message of {} characters: {l}", l.chars().count())));
        printed.push_str(&text);
    }
    wrong.extend(texts("says").into_iter().filter(|t| !printed.contains(t)).map(|t| format!("it does not say '{t}'")));
    wrong.extend(texts("never").into_iter().filter(|t| printed.contains(t)).map(|t| format!("it says '{t}'")));
    let output = work.path().join("o.glb");
    if let Some(source) = of {
        let report = compare::compare(&work.path().join(source), work.path(), &output);
        wrong.extend(report.differences);
        let (least, most) = match &case["moved"] {
            Value::Array(range) => (range[0].as_u64().unwrap(), range[1].as_u64().unwrap()),
            one => (one.as_u64().unwrap_or(0), one.as_u64().unwrap_or(u64::MAX)),
        };
        if !(least..=most).contains(&(report.moved as u64)) {
            wrong.push(format!("{} vertices moved", report.moved));
        }
    }
    for (pointer, value) in case["is"].as_object().into_iter().flatten() {
        let found = compare::at(&compare::File::open(&output), pointer);
        if !alike(&found, value) {
            wrong.push(format!("{pointer} is {found}, not {value}"));
        }
    }
    if !wrong.is_empty() {
        wrong.push(printed);
    }
    wrong
}

/// Equal values; numbers may differ by a rounding, which is that of nodes for positions.
fn alike(a: &Value, b: &Value) -> bool {
    match (a, b) {
        (Value::Array(a), Value::Array(b)) => a.len() == b.len() && a.iter().zip(b).all(|(a, b)| alike(a, b)),
        (Value::Number(a), Value::Number(b)) => {
            let (a, b) = (a.as_f64().unwrap(), b.as_f64().unwrap());
            (a - b).abs() <= 1e-4 * b.abs().max(1.0)
        }
        _ => a == b,
    }
}

fn copy(from: &Path, to: &Path) {
    for entry in std::fs::read_dir(from).unwrap().map(Result::unwrap) {
        let target = to.join(entry.file_name());
        if entry.file_type().unwrap().is_dir() {
            std::fs::create_dir(&target).unwrap();
            copy(&entry.path(), &target);
        } else {
            std::fs::copy(entry.path(), target).unwrap();
        }
    }
}

#[test]
#[cfg_attr(windows, ignore = "a hundred runs of the command take long under Wine")]
fn files_as_people_have_them() {
    let folders =
        std::fs::read_dir(asset("tests/files")).unwrap().map(|e| e.unwrap().path()).filter(|path| path.is_dir());
    let mut folders: Vec<PathBuf> = folders.collect();
    folders.sort();
    assert!(folders.len() >= 34, "{}", folders.len());
    let mut wrong = String::new();
    for folder in folders {
        let found: Vec<String> = cases(&folder).iter().flat_map(|case| check(&folder, case)).collect();
        if !found.is_empty() {
            wrong.push_str(&format!("\n{}:\n  {}\n", folder.file_name().unwrap().display(), found.join("\n  ")));
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}
