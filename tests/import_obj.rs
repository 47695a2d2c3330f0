//! A base OBJ with example OBJs: Blender's files, other programs' files, and broken files.
#![cfg(feature = "obj")]

use crumple::import::{Imported, obj_files, obj_slices};
use crumple::{Deltas, Error, ErrorKind};
use proptest::prelude::*;
use std::path::{Path, PathBuf};

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures").join(name)
}

fn read(base: &str, example: &str) -> Result<Imported, Error> {
    obj_slices(("base", base.as_bytes()), &[("dent", example.as_bytes())])
}

fn sparse(imported: &Imported) -> (&[u32], &[[f32; 3]]) {
    match &imported.examples[0].positions {
        Deltas::Sparse { indices, values } => (indices, values),
        Deltas::Full(_) => panic!("the importer writes sparse deltas"),
    }
}

#[track_caller]
fn refuse(base: &str, example: &str, kind: ErrorKind, part: &str) {
    let error = read(base, example).expect_err("broken files were read");
    assert_eq!(error.kind(), kind, "{error}");
    assert!(error.to_string().contains(part), "{error}");
}

const TWO: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n";
const DENT: &str = "v 0 0 0\nv 1 0 -0.5\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n";

#[test]
fn blenders_plate() {
    let plate = obj_files(&fixture("plate.obj"), &[fixture("plate_dent.obj")]).unwrap();
    assert_eq!((plate.name.as_str(), plate.examples[0].name.as_str()), ("plate", "plate_dent"));
    assert_eq!((plate.mesh.positions.len(), plate.mesh.triangles.len()), (25, 32));
    assert_eq!(plate.texcoords.as_ref().map(Vec::len), Some(25));
    assert!(plate.mesh.normals.as_ref().unwrap().iter().all(|n| *n == [0.0, 1.0, 0.0]));
    assert_eq!(plate.primitives[0].triangle_count, 32);
    let (indices, values) = sparse(&plate);
    let mut deltas = vec![[0.0; 3]; 25];
    indices.iter().zip(values).for_each(|(i, d)| deltas[*i as usize] = *d);
    for ((p, d), uv) in plate.mesh.positions.iter().zip(&deltas).zip(plate.texcoords.iter().flatten()) {
        // OBJ files have six decimals.
        let share = (1.0 - (p[0] * p[0] + p[2] * p[2]) / 0.16).max(0.0).powi(2);
        assert!((d[1] + 0.1 * share).abs() < 2e-6 && d[0] == 0.0 && d[2] == 0.0, "{p:?} {d:?}");
        // Blender's v is 0.5 + y upwards, which is -z as exported. Ours counts downwards.
        assert!((uv[0] - (p[0] + 0.5)).abs() < 1e-6 && (uv[1] - (p[2] + 0.5)).abs() < 1e-6);
    }
    for t in &plate.mesh.triangles {
        let [a, b, c] = t.map(|i| plate.mesh.positions[i as usize]);
        assert!((c[0] - a[0]) * (b[2] - a[2]) - (c[2] - a[2]) * (b[0] - a[0]) != 0.0);
    }
}

#[test]
fn vertices_are_the_distinct_corners_in_order_of_use() {
    // A quad whose corner 2 has two texture coordinates, and a v that no face uses.
    let base = "v 9 9 9\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0.25\nf 3/2 4/1 5/1 2/1\nf 4/1 3/1 2/1\n";
    let moved = base.replace("v 1 0 0", "v 1 0 -2").replace("v 9 9 9", "v 8 8 8");
    let imported = read(base, &moved).unwrap();
    let positions = [[1., 0., 0.], [1., 1., 0.], [0., 1., 0.], [0., 0., 0.], [1., 0., 0.]];
    assert_eq!(imported.mesh.positions, positions);
    assert_eq!(imported.mesh.triangles, [[0, 1, 2], [0, 2, 3], [1, 4, 3]], "polygons are fans");
    assert_eq!(imported.texcoords.as_deref(), Some(&[[1., 0.75], [0., 1.], [0., 1.], [0., 1.], [0., 1.]][..]));
    assert_eq!(imported.mesh.normals, None);
    assert_eq!(sparse(&imported), (&[0, 4][..], &[[0., 0., -2.], [0., 0., -2.]][..]), "both halves of the seam move");
}

#[test]
fn normals_are_kept_when_every_corner_has_one() {
    let with = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//-1\n";
    assert_eq!(read(with, with).unwrap().mesh.normals, Some(vec![[0., 0., 1.]; 3]));
    let without = with.replace("2//1", "2");
    assert_eq!(read(&without, with).unwrap().mesh.normals, None);
}

#[test]
fn files_without_faces_and_files_in_odd_dress() {
    let points = read("v 0 0 0\nv 1 2 3\n", "v 0 0 0\nv 1 2 4\n").unwrap();
    assert_eq!((points.mesh.positions.len(), points.mesh.triangles.len()), (2, 0));
    assert_eq!(sparse(&points), (&[1][..], &[[0., 0., 1.]][..]));
    let plain = read(TWO, DENT).unwrap();
    // Positions only, as a solver writes them.
    assert_eq!(read(TWO, DENT.split('f').next().unwrap()).unwrap(), plain);
    // Names, groups, comments, vendors' commands, spaces, carriage returns, a byte order mark, relative indices, a continued line.
    let odd = "\u{feff}# T\u{fc}r\r\nmtllib a b.mtl\r\no\u{2003}\u{2003}x\r\n  v 0 0 0 1 0 0\r\n\tv  1 0 0\r\nv 1 1 0\r\nv 0 1 0\r\n\u{2003}g x\r\ng\r\nusemtl\r\ns off\r\n\
               vendor_thing 1 2\r\nf -4 -3 \\\r\n -2\r\ng \u{fc}\u{e9}\r\no\r\nl 1 2\r\np 1\r\nf 1 3 4";
    assert_eq!(read(odd, DENT).unwrap(), plain);
    // A name in Latin-1.
    let mut latin = b"o T\xFCr\n".to_vec();
    latin.extend_from_slice(TWO.as_bytes());
    assert_eq!(obj_slices(("base", &latin), &[("dent", DENT.as_bytes())]).unwrap(), plain);
}

#[test]
fn examples_that_do_not_fit() {
    let mismatch = ErrorKind::ExampleMismatch;
    refuse(TWO, &format!("v 0 0 0\n{DENT}"), mismatch, "example 0 'dent': it has 5 vertices (v lines); the base has 4");
    let turned = DENT.replace("f 1 3 4", "f 3 4 1");
    refuse(TWO, &turned, mismatch, "face 2 has the corners [3, 4, 1]; in the base it has [1, 3, 4]");
    refuse(TWO, &DENT.replace("f 1 3 4\n", ""), mismatch, "it has 1 faces; the base has 2");
    refuse(TWO, &format!("{DENT}f 1 2 4\n"), mismatch, "it has 3 faces; the base has 2");
    let error = obj_slices(("base", TWO.as_bytes()), &[]).unwrap_err();
    assert!(
        matches!(&error, Error::NoExamples { what } if what.contains("'base' came without example files")),
        "{error}"
    );
    let two = obj_slices(("base", TWO.as_bytes()), &[("a", DENT.as_bytes()), ("b", turned.as_bytes())]).unwrap_err();
    assert!(two.to_string().starts_with("example 1 'b'"), "{two}");
}

#[test]
fn broken_files() {
    let format = ErrorKind::Format;
    refuse("", DENT, format, "base: no v lines");
    refuse("\u{89}PNG\r\n\u{1a}\n", DENT, format, "base: no v lines");
    refuse(TWO, "", format, "dent: no v lines");
    refuse("v 1 2\n", "", format, "base: line 1: numbers are missing");
    refuse("\n\nv 1 2 x\n", "", format, "base: line 3: numbers are missing or unreadable");
    refuse("v 1 2 \\\n x\nf", "", format, "base: line 1: numbers are missing or unreadable");
    refuse("v 0 0 0\nf 1 1 2\n", "", format, "base: face 1 uses v 2; there are 1");
    refuse("v 0 0 0\nf 1 1 0\n", "", format, "base: line 2: a face uses v 0");
    refuse("v 0 0 0\nf 1 1 -2\n", "", format, "base: face 1 uses v -1; there are 1");
    refuse("v 0 0 0\nf 1 1 9223372036854775807\n", "", format, "uses v 9223372036854775807");
    refuse("v 0 0 0\nf 1 1 -9223372036854775808\n", "", format, "uses v -92233720368547758");
    refuse("v 0 0 0\nf 1 1 99999999999999999999\n", "", format, "'99999999999999999999' is no face corner");
    refuse("v 0 0 0\nf 1 1\n", "", format, "face 1 has 2 corners");
    refuse("v 0 0 0\nf\n", "", format, "face 1 has 0 corners");
    refuse("v 0 0 0\nf a b c\n", "", format, "base: line 2: 'a' is no face corner");
    refuse("v 0 0 0\nf 1/1 1/1 1/1\n", "", format, "face 1 uses vt 1; there are 0");
    refuse("v 0 0 0\nf 1//2 1//2 1//2\n", "", format, "face 1 uses vn 2; there are 0");
    refuse("v 0 nan 0\n", "", ErrorKind::NotFinite, "base: v line 1.y is NaN");
    refuse("v 0 0 1e39\n", "", ErrorKind::NotFinite, "base: v line 1.z is inf");
    refuse("v 0 0 0\nvn 0 inf 0\n", "", ErrorKind::NotFinite, "base: vn line 1.y is inf");
    refuse("v 0 0 0\nvt 0 -inf\n", "", ErrorKind::NotFinite, "base: vt line 1.y is -inf");
    refuse("v 3e38 0 0\n", "v -3e38 0 0\n", ErrorKind::NotFinite, "dent: displacement of v line 1.x is -inf");
    let error = obj_files(&fixture("plate.obj"), &[fixture("nowhere.obj")]).unwrap_err();
    assert!(error.kind() == ErrorKind::Io && error.to_string().contains("nowhere.obj"), "{error}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: ProptestConfig::default().cases * 8, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_mutation_panics(edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..12), cut in any::<prop::sample::Index>()) {
        let mut bytes = std::fs::read(fixture("plate_dent.obj")).unwrap();
        for (at, value) in edits {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        let end = cut.index(bytes.len());
        for broken in [&bytes[..], &bytes[..end]] {
            let _ = obj_slices(("a", broken), &[("b", broken)]);
        }
    }

    #[test]
    fn no_text_panics(words in prop::collection::vec(prop::sample::select(vec![
        "v", "vt", "vn", "f", "o", "g", "usemtl", "mtllib", "s", "\n", "\n", "\\", "\\\n", "0", "1", "-1", "2", "1/1", "1//1", "-1/-1/-1", "/", "//",
        "1e38", "-1e38", "nan", "\u{2003}", "\u{e9}", "\u{feff}", "#",
    ]), 0..60), glue in prop::sample::select(vec![" ", "", "\u{a0}"])) {
        let text = words.join(glue);
        let _ = read(&text, &text);
    }
}
