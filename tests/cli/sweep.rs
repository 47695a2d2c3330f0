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
    let (mut bad, mut refused) = (0, Vec::new());
    for file in &files {
        let shown = file.strip_prefix(&folder).unwrap_or(file).display().to_string();
        match one(file, &options.split_whitespace().collect::<Vec<_>>()) {
            Err(complaint) => {
                println!("{shown}: {complaint}");
                refused.push(shown);
            }
            Ok(Report { vertices, moved, differences }) => {
                println!("{shown}: {moved} of {vertices} vertices moved");
                differences.iter().for_each(|what| println!("  changed: {what}"));
                bad += usize::from(!differences.is_empty());
            }
        }
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
        let report =
            one(&folder.join(name), &["--mesh", mesh]).unwrap_or_else(|complaint| panic!("{name}: {complaint}"));
        assert!(report.moved > 0 && report.differences.is_empty(), "{name}: {report:?}");
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

/// Runs the commands, and compares. What a command says that fails is the error.
fn one(file: &Path, options: &[&str]) -> Result<Report, String> {
    let work = tempfile::tempdir().unwrap();
    let path = file.canonicalize().unwrap().display().to_string();
    let examples = if path.to_lowercase().ends_with("obj") { examples(file) } else { Vec::new() };
    let source: Vec<&str> =
        std::iter::once(&*path).chain(options.iter().copied()).chain(examples.iter().map(String::as_str)).collect();
    for line in [
        [&["info"], &source[..]].concat(),
        [&["bake"], &source[..], &["-o", "o.crumple"]].concat(),
        [&["sample"], &source[..], &["-o", "s.json", "--count", "3"]].concat(),
        [&["apply"], &source[..], &["--impacts", "s.json", "-o", "o.glb"]].concat(),
    ] {
        let run = crumple_in(work.path(), &line);
        if !run.is_good() {
            return Err(format!("{}: {}", line[0], run.stderr.trim()));
        }
    }
    let mut read = file.to_owned();
    if !examples.is_empty() {
        // An OBJ is read as this glTF.
        let paths: Vec<PathBuf> = examples.iter().skip(1).step_by(2).map(PathBuf::from).collect();
        read = work.path().join("read.glb");
        std::fs::write(&read, crumple::import::obj_glb(file, &paths).unwrap().glb).unwrap();
    }
    Ok(compare::compare(&read, file.parent().unwrap(), &work.path().join("o.glb")))
}
