//! A base OBJ with example OBJs: Blender's files, other programs' files, and broken files.
#![cfg(feature = "obj")]

mod import_glb;

use crumple::glam::Vec3;
use crumple::import::{Imported, obj_files, obj_glb, obj_slices};
use crumple::{Error, ErrorKind};
use import_glb::fixture;

fn read(base: &str, example: &str) -> Result<Imported, Error> {
    obj_slices(("base", base.as_bytes()), &[("dent", example.as_bytes())])
}

fn sparse(imported: &Imported) -> (&[u32], &[[f32; 3]]) {
    import_glb::sparse(&imported.examples[0].positions)
}

/// The texture coordinates of the first primitive.
fn texcoords(glb: &[u8]) -> Vec<[f32; 2]> {
    let file = gltf::Gltf::from_slice(glb).unwrap();
    let primitive = file.meshes().next().and_then(|m| m.primitives().next()).unwrap();
    primitive.reader(|_| file.blob.as_deref()).read_tex_coords(0).unwrap().into_f32().collect()
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
    let glb = obj_glb(&fixture("plate.obj"), &[fixture("plate_dent.obj")]).unwrap().glb;
    let texcoords = texcoords(&glb);
    assert_eq!(texcoords.len(), 25);
    assert!(plate.mesh.normals.as_ref().unwrap().iter().all(|n| *n == [0.0, 1.0, 0.0]));
    assert_eq!(plate.primitives[0].triangles.len(), 32);
    let (indices, values) = sparse(&plate);
    let mut deltas = vec![[0.0; 3]; 25];
    indices.iter().zip(values).for_each(|(i, d)| deltas[*i as usize] = *d);
    for ((p, d), uv) in plate.mesh.positions.iter().zip(&deltas).zip(&texcoords) {
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
    assert_eq!(imported.mesh.normals, None);
    assert_eq!(sparse(&imported), (&[0, 4][..], &[[0., 0., -2.], [0., 0., -2.]][..]), "both halves of the seam move");
}

#[test]
fn normals_are_kept_and_what_is_missing_is_computed() {
    let with = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//-1\n";
    assert_eq!(read(with, with).unwrap().mesh.normals, Some(vec![[0., 0., 1.]; 3]));
    let some = read(&with.replace("2//1", "2"), with).unwrap();
    assert_eq!(some.mesh.normals, Some(vec![[0., 0., 1.]; 3]));
    assert!(some.notes[0].starts_with("1 of 3 normals have no length"), "{:?}", some.notes);
    let odd = read(&with.replace("vn 0 0 1", "vn 0 inf -nan(ind)"), with).unwrap();
    assert_eq!(odd.mesh.normals, Some(vec![[0., 0., 1.]; 3]));
    assert!(odd.notes[0].starts_with("base, from line 4: 1 vt and vn lines are no numbers"), "{:?}", odd.notes);
    // Without vn lines glTF shows faces flat, unless they are of a smoothing group.
    let bent = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 -1\ns off\nf 1 2 3\nf 2 4 3\n";
    assert_eq!(read(bent, bent).unwrap().mesh.normals, None);
    let smooth = read(&bent.replace("s off", "s 1"), bent).unwrap().mesh.normals.unwrap();
    assert!(smooth[0] == [0., 0., 1.] && smooth[1] != smooth[0] && smooth[1] == smooth[2], "{smooth:?}");
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
    let odd = "\u{feff}# T\u{fc}r\r\nmtllib a b.mtl\r\no\u{2003}\u{2003}x\r\n  v 0 0 0 1 0 0\r\n\tv  1 0 0\r\nv 1 1 0\r\nv 0 1 0\r\n\u{2003}g x\r\ng\r\ng \u{fc}\u{e9}\r\nusemtl\r\ns off\r\n\
               vendor_thing 1 2\r\nf -4 -3 \\\r\n -2 # first\r\nl 1 2\r\n# a comment \\\r\nf 1 3 4 # last";
    assert_eq!(read(odd, DENT).unwrap(), plain);
    for text in [odd.replace("\r\n", "\r"), format!("{}\n\n", odd.replace("\r\n", "\n"))] {
        assert_eq!(read(&text, DENT).unwrap(), plain);
        let wide: Vec<u16> = text.encode_utf16().collect();
        let [little, big] =
            [u16::to_le_bytes, u16::to_be_bytes].map(|to| wide.iter().flat_map(|c| to(*c)).collect::<Vec<u8>>());
        for bytes in [little, big] {
            assert_eq!(obj_slices(("base", &bytes), &[("dent", DENT.as_bytes())]).unwrap(), plain);
        }
    }
    let bare: Vec<u8> = TWO.encode_utf16().flat_map(u16::to_le_bytes).collect();
    assert_eq!(obj_slices(("base", &bare), &[("dent", DENT.as_bytes())]).unwrap(), plain, "UTF-16 without a mark");
    // A name in Latin-1.
    let mut latin = b"o T\xFCr\n".to_vec();
    latin.extend_from_slice(TWO.as_bytes());
    assert_eq!(obj_slices(("base", &latin), &[("dent", DENT.as_bytes())]).unwrap(), plain);
}

#[test]
fn examples_that_do_not_fit() {
    let mismatch = ErrorKind::ExampleMismatch;
    refuse(TWO, &format!("v 0 0 0\n{DENT}"), mismatch, "example 0 'dent': it has 5 vertices (v lines); the base has 4");
    // Only positions are read: faces may be cut otherwise, turned, or missing.
    let quad = "v 0 0 0\nv 1 0 -0.5\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
    for same in [&DENT.replace("f 1 3 4", "f 3 4 1"), quad, &DENT.replace("f 1 3 4\n", ""), &format!("{DENT}f 1 2 3\n")]
    {
        assert_eq!(read(TWO, same).unwrap(), read(TWO, DENT).unwrap(), "{same}");
    }
    let apart = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 5 0 0\nv 6 0 0\nv 6 1 0\nf 1 2 3\nf 4 5 6\n";
    let other = read(apart, &apart.replace("v 1 0 0", "v 1 0 1").replace("2 3", "5 3").replace("5 6", "2 6")).unwrap();
    assert!(
        other.notes[0].starts_with("the faces of 'dent' use other vertices than those of the base"),
        "{:?}",
        other.notes
    );
    let error = obj_slices(("base", TWO.as_bytes()), &[]).unwrap_err();
    assert!(
        matches!(&error, Error::NoExamples { what } if what.contains("'base' came without example files")),
        "{error}"
    );
    let two = obj_slices(("base", TWO.as_bytes()), &[("a", DENT.as_bytes()), ("b", b"v 1 1 1")]).unwrap_err();
    assert!(two.to_string().starts_with("example 1 'b'"), "{two}");
}

#[test]
fn broken_files() {
    let format = ErrorKind::Format;
    refuse("", DENT, format, "base: no v lines");
    refuse("\u{89}PNG\r\n\u{1a}\n", DENT, format, "base: no v lines");
    refuse(TWO, "", format, "dent: no v lines");
    refuse("v 1 2\n", "", format, "base: line 1: v has 2 numbers; it needs x y z");
    refuse("\n\nv 1 2 x\n", "", format, "base: line 3: 'x' is no number");
    refuse("v 1 2 \\\n x\nf", "", format, "base: line 1: 'x' is no number");
    refuse("v 0 0 0\nf 1 1 2\n", "", format, "base: line 2: a face uses v 2; there are 1");
    refuse("v 0 0 0\nf 1 1 0\n", "", format, "base: line 2: a face uses v 0; indices start at 1");
    refuse("v 0 0 0\nf 1 1 -2\n", "", format, "base: line 2: a face uses v -2; there are 1 before it");
    refuse("v 0 0 0\nf 1 1 -9223372036854775808\n", "", format, "uses v -9223372036854775808");
    refuse("v 0 0 0\nf 1 1 99999999999999999999\n", "", format, "'99999999999999999999' is no face corner");
    refuse("v 0 0 0\nf a b c\n", "", format, "base: line 2: 'a' is no face corner");
    refuse("v 0 nan 0\n", "", ErrorKind::NotFinite, "base: v line 1.y is NaN");
    refuse("v 0 0 1e39\n", "", ErrorKind::NotFinite, "base: v line 1.z is inf");
    refuse("v 3e38 0 0\n", "v -3e38 0 0\n", ErrorKind::NotFinite, "dent: displacement of v line 1.x is -inf");
    let error = obj_files(&fixture("plate.obj"), &[fixture("nowhere.obj")]).unwrap_err();
    assert!(error.kind() == ErrorKind::Io && error.to_string().contains("nowhere.obj"), "{error}");
}

#[test]
fn small_faces_and_missing_normals_are_left_out_and_noted() {
    let base =
        format!("{TWO}f 1 2\nf\nf 1/1 2/2 3//9\np 1 2\ncstype bezier\ndeg 3\ncurv 0 1 1 2 3 4\nparm u 0 1\nend\n");
    let imported = read(&base, DENT).unwrap();
    assert_eq!(imported.mesh.triangles.len(), 3);
    assert_eq!(
        imported.notes,
        [
            "base, from line 7: 2 faces have fewer than three corners and are left out",
            "base, from line 9: 3 corners of faces name a vt or vn line that the file lacks; they are read without it",
            "base, from line 10: 2 points, curves or curved surfaces are left out; export curved surfaces as polygons",
        ]
    );
    // Faces may stand before their vertices.
    let before = "f 1 2 3\nf 1 3 4\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
    assert_eq!(read(before, DENT).unwrap(), read(TWO, DENT).unwrap());
}

#[test]
fn concave_faces_are_clipped_and_stay_on_their_side() {
    // An L, an arrowhead, a U, and a comb with more corners between others on a line, each also turned over and standing upright.
    let mut comb: Vec<[f32; 2]> = [0., 1., 3., 5., 7., 9., 11., 12.].map(|x| [x, 0.]).to_vec();
    let tooth = |n: u8| [[2., 3.], [1., 3.], [1., 1.], [0., 1.]].map(|[x, y]| [x + 2. * f32::from(n), y]);
    comb.extend((0..6).rev().flat_map(tooth));
    let shapes: [(&[[f32; 2]], f32); 4] = [
        (&[[2., 0.], [2., 1.], [1., 1.], [1., 2.], [0., 2.], [0., 0.]], 3.0),
        (&[[0., 0.], [2., 2.], [0., 1.], [-2., 2.]], 2.0),
        (&[[0., 0.], [3., 0.], [3., 2.], [2., 2.], [2., 1.], [1., 1.], [1., 2.], [0., 2.]], 5.0),
        (&comb, 24.0),
    ];
    let place: [fn([f32; 2]) -> [f32; 3]; 3] =
        [|[x, y]| [x, y, 0.0], |[x, y]| [0.0, x, y], |[x, y]| [x + y, 7.0 - x, y - x]];
    for (shape, area) in shapes {
        for start in 0..shape.len() {
            for (turned, place) in [false, true].into_iter().flat_map(|t| place.map(|p| (t, p))) {
                let mut corners: Vec<[f32; 3]> =
                    shape.iter().cycle().skip(start).take(shape.len()).map(|c| place(*c)).collect();
                if turned {
                    corners.reverse();
                }
                let vertices: String = corners.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect();
                let face: String = (1..=shape.len()).map(|i| format!(" {i}")).collect();
                let text = format!("{vertices}f{face}\n");
                let moved = text.replacen("\nv ", "\nv 9", 1).replacen("9-", "9", 1);
                let mesh = read(&text, &moved).unwrap().mesh;
                let at = |v: u32| Vec3::from(mesh.positions[v as usize]);
                let areas: Vec<_> =
                    mesh.triangles.iter().map(|[a, b, c]| (at(*b) - at(*a)).cross(at(*c) - at(*a)) / 2.0).collect();
                let [x, y, o] = [[1., 0.], [0., 1.], [0., 0.]].map(|corner| Vec3::from(place(corner)));
                let whole = (x - o).cross(y - o) * if turned { -area } else { area };
                assert!(areas.iter().all(|a| a.dot(whole) >= 0.0), "{text}: turned over");
                let sum: Vec3 = areas.iter().sum();
                assert!(sum.distance(whole) < 1e-3, "{text}: {sum} instead of {whole}");
            }
        }
    }
}

#[test]
fn objects_groups_materials_and_colours_are_kept() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: Vec<u8>| std::fs::write(folder.path().join(name), bytes).unwrap();
    // Tools of one pipeline write different encodings.
    let utf_16 = |text: &str| text.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let latin_1 = |text: &str| text.chars().map(|c| c as u8).collect();
    write(
        "car.mtl",
        utf_16(
            "\u{feff}newmtl röt paint\r\nKd 1 0 0\r\nNs 250\r\nd 0.5\r\nPm 1\r\nmap_Bump bump.png\r\n\
         newmtl seat\nKd .8 .8 .8\nmap_Kd -s 1 1 1 -clamp on C:\\work\\tex tures\\seat 1.tga\nmap_Ke glow.png\nTr 0.25\n",
        ),
    );
    let base = "mtllib C:\\elsewhere\\car.mtl none.mtl\no Tür\nv 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 1 1 0 0 0 1\nv 0 1 0\n\
                usemtl röt paint\ng left\nf 1 2 3\ng right\nusemtl seat\nf 1 3 4\no floor\nusemtl unknown\nf 4 3 2\nl 1 2 3\n";
    write("car.obj", latin_1(base));
    write("car_dent.obj", latin_1(&base.replace("v 1 1 0", "v 1 1 -1")));
    let converted = obj_glb(&folder.path().join("car.obj"), &[folder.path().join("car_dent.obj")]).unwrap();
    let file = gltf::Gltf::from_slice_without_validation(&converted.glb).unwrap();
    let tree: Vec<_> =
        file.nodes().map(|n| (n.name().unwrap().to_owned(), n.children().count(), n.mesh().is_some())).collect();
    let leaf = |name: &str| (name.to_owned(), 0, true);
    assert_eq!(tree, [leaf("left"), leaf("right"), ("Tür".into(), 2, false), leaf("floor")]);
    let json = file.as_json();
    let materials = serde_json::to_value(&json.materials).unwrap();
    assert_eq!(materials[0]["name"], "röt paint");
    let metal = &materials[0]["pbrMetallicRoughness"];
    assert_eq!(metal["baseColorFactor"], serde_json::json!([1.0, 0.0, 0.0, 0.5]));
    assert!((metal["roughnessFactor"].as_f64().unwrap() - 0.2988).abs() < 1e-3, "{metal}");
    assert_eq!(
        (&materials[0]["alphaMode"], &materials[0]["extras"]["map_Bump"]),
        (&"BLEND".into(), &"bump.png".into())
    );
    assert_eq!(materials[1]["pbrMetallicRoughness"]["baseColorFactor"], serde_json::json!([1.0, 1.0, 1.0, 0.75]));
    assert_eq!(materials[2]["name"], "unknown");
    let images: Vec<_> = json.images.iter().map(|image| image.uri.clone().unwrap()).collect();
    assert_eq!(images, ["seat%201.tga", "glow.png"]);
    let floor: Vec<_> = file.meshes().last().unwrap().primitives().map(|p| p.mode()).collect();
    assert_eq!(floor, [gltf::mesh::Mode::Triangles, gltf::mesh::Mode::Lines]);
    let left = file.meshes().next().unwrap().primitives().next().unwrap();
    let colours: Vec<_> = left.reader(|_| file.blob.as_deref()).read_colors(0).unwrap().into_rgb_f32().collect();
    assert_eq!(colours, [[1., 0., 0.], [0., 1., 0.], [0., 0., 1.]]);
    assert!(
        converted.notes.iter().any(|n| n.contains("the materials of 'none.mtl' cannot be read")),
        "{:?}",
        converted.notes
    );
    assert!(converted.notes.iter().any(|n| n.contains("has the material 'unknown'")), "{:?}", converted.notes);
    // One file is one blow: what it moves in several objects is one example.
    let imported = obj_files(&folder.path().join("car.obj"), &[folder.path().join("car_dent.obj")]).unwrap();
    assert_eq!((imported.examples.len(), imported.primitives.len(), imported.parts.len()), (1, 3, 0));
    assert_eq!(imported.primitives[0].material.as_deref(), Some("röt paint"));
}
