//! Runs info, bake, sample and apply over the files of a folder, and compares what apply wrote with what it read.

use crate::compare::{self, Report};
use crate::{asset, crumple_in};
use std::path::{Path, PathBuf};

/// `cargo xtask sweep DIR` sets CRUMPLE_SWEEP to the folder, and CRUMPLE_SWEEP_OPTIONS to what follows it. CRUMPLE_SWEEP_REFUSED is a
/// list of files: these and no others must be refused.
#[test]
fn sweep() {
    let Some(folder) = std::env::var_os("CRUMPLE_SWEEP") else { return };
    let options = std::env::var("CRUMPLE_SWEEP_OPTIONS").unwrap_or_default();
    let mut files = Vec::new();
    gather(Path::new(&folder), &mut files);
    files.sort();
    println!(
        "| file | info, bake, sample, apply | says | examples | vertices | moved | what changed that should not |"
    );
    println!("|---|---|---|---|---|---|---|");
    let (mut bad, mut refused) = (0, Vec::new());
    for file in &files {
        let shown = file.strip_prefix(&folder).unwrap_or(file).display().to_string();
        let Swept { outcome, says, examples, report } = one(file, &options.split_whitespace().collect::<Vec<_>>());
        bad += usize::from(!report.differences.is_empty());
        if outcome.contains("refused") {
            refused.push(shown.clone());
        }
        let first = report.differences.first().map(|d| d.replace('|', "/"));
        let more = report.differences.len().saturating_sub(1);
        let changed = match (first, more) {
            (None, _) => "nothing".to_owned(),
            (Some(first), 0) => first,
            (Some(first), more) => format!("{first}, and {more} more"),
        };
        println!("| {shown} | {outcome} | {says} | {examples} | {} | {} | {changed} |", report.vertices, report.moved);
    }
    assert!(bad == 0, "{bad} of {} files lost something", files.len());
    if let Ok(expected) = std::env::var("CRUMPLE_SWEEP_REFUSED") {
        assert_eq!(refused, expected.split(',').filter(|name| !name.is_empty()).collect::<Vec<_>>(), "refused");
    }
}

#[test]
#[cfg_attr(windows, ignore = "many runs of the command take long under Wine")]
fn what_blender_wrote_stays_where_no_dent_reached() {
    let folder = asset("tests/fixtures");
    for (name, mesh) in [
        ("two_materials.glb", "0"),
        ("two_materials_sparse.glb", "0"),
        ("seams.glb", "0"),
        ("seams_sparse.glb", "0"),
        ("nodes.glb", "1"),
        ("nodes.glb", "2"),
        ("animated.glb", "0"),
        ("animated.glb", "2"),
        ("separate/bent door.gltf", "0"),
    ] {
        let Swept { outcome, says, report, .. } = one(&folder.join(name), &["--mesh", mesh]);
        assert!(report.moved > 0 && report.differences.is_empty(), "{name}: {outcome}, {says}: {report:?}");
    }
}

fn gather(folder: &Path, files: &mut Vec<PathBuf>) {
    for path in std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()) {
        let ending = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        if path.is_dir() {
            gather(&path, files);
        } else if ["gltf", "glb"].contains(&&*ending) || ending == "obj" && examples(&path).len() > 1 {
            files.push(path);
        }
    }
}

/// The examples of an OBJ are the files whose names begin with its name and `_`.
fn examples(obj: &Path) -> Vec<String> {
    let stem = obj.file_stem().unwrap().to_string_lossy().into_owned() + "_";
    let beside = std::fs::read_dir(obj.parent().unwrap()).unwrap().map(|e| e.unwrap().path());
    let is_example = |p: &PathBuf| {
        p.extension() == obj.extension() && p.file_stem().is_some_and(|s| s.to_string_lossy().starts_with(&stem))
    };
    let mut files: Vec<PathBuf> = beside.filter(is_example).collect();
    files.sort();
    files.into_iter().flat_map(|p| ["--example".to_owned(), p.display().to_string()]).collect()
}

struct Swept {
    /// What the commands did: in a word each unless all are good.
    outcome: String,
    /// The first thing that they said.
    says: String,
    /// The names of the examples.
    examples: String,
    /// What apply changed.
    report: Report,
}

fn one(file: &Path, options: &[&str]) -> Swept {
    let work = tempfile::tempdir().unwrap();
    let path = file.canonicalize().unwrap().display().to_string();
    let examples = if path.to_lowercase().ends_with("obj") { examples(file) } else { Vec::new() };
    let source: Vec<&str> =
        std::iter::once(&*path).chain(options.iter().copied()).chain(examples.iter().map(String::as_str)).collect();
    let (mut words, mut says) = (Vec::new(), String::new());
    for line in [
        [&["info"], &source[..]].concat(),
        [&["bake"], &source[..], &["-o", "o.crumple"]].concat(),
        [&["sample"], &source[..], &["-o", "s.json", "--count", "3"]].concat(),
        [&["apply"], &source[..], &["--impacts", "s.json", "-o", "o.glb"]].concat(),
    ] {
        let run = crumple_in(work.path(), &line);
        let text = run.text();
        let first = |start: &str| text.lines().map(str::trim).find_map(|l| Some(l.strip_prefix(start)?.trim()));
        let said = first("error:").or(first("Warning:")).or(first("warning")).unwrap_or_default();
        words.push(if !run.is_good() {
            "refused"
        } else if said.is_empty() {
            "good"
        } else {
            "warns"
        });
        if says.is_empty() {
            says = said.replace('|', "/").replace(&path, "it");
        }
        if !run.is_good() {
            break;
        }
    }
    let output = work.path().join("o.glb");
    let mut read = file.to_owned();
    if !examples.is_empty() {
        // An OBJ is read as this glTF.
        let paths: Vec<PathBuf> = examples.iter().skip(1).step_by(2).map(PathBuf::from).collect();
        read = work.path().join("read.glb");
        std::fs::write(&read, crumple::import::obj_glb(file, &paths).map_or(Vec::new(), |c| c.glb)).unwrap();
    }
    let compared = words.len() == 4 && words[3] != "refused";
    let report = if compared { compare::compare(&read, file.parent().unwrap(), &output) } else { Report::default() };
    let all = words.iter().all(|word| *word == words[0]);
    let outcome = if all { words[0].to_owned() } else { words.join(", ") };
    let imported = crumple::import::gltf_file(&read, crumple::import::MeshChoice::First);
    let names = imported.map_or(Vec::new(), |imported| imported.examples.into_iter().map(|e| e.name).collect());
    Swept { outcome, says, examples: names.join(", "), report }
}
