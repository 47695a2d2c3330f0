//! Broken glTF files. Each gives a typed error that names the value. That none panics is for the fuzz target `gltf`.
#![cfg(feature = "gltf")]

mod import_glb;

use crumple::export::deformed_glb;
use crumple::import::{MeshChoice, gltf_file, gltf_slice};
use crumple::{Error, ErrorKind};
use import_glb::{Glb, container, square};
use serde_json::{Value, json};

fn refuse(bytes: &[u8]) -> Error {
    gltf_slice(bytes, None, MeshChoice::First).expect_err("a broken file was read")
}

#[track_caller]
fn expect(bytes: &[u8], kind: ErrorKind, part: &str) {
    let error = refuse(bytes);
    assert_eq!(error.kind(), kind, "{error}");
    assert!(error.to_string().contains(part), "{error}");
    // The exporter must refuse the same files.
    let exported = deformed_glb(bytes, None, MeshChoice::First, &[], None, None);
    assert!(exported.is_err());
}

use ErrorKind::{Format, IndexOutOfRange, NotFinite, Unsupported};

/// Changes of the square: `pointer | value | kind of error | part of its message`. `!` repeats the pointer of the line
/// before, and `&` stands between several pointers and values.
const LIES: &str = r#"
versions:
/asset/version    | "1.0" | Unsupported | glTF version 1.0; version 2.0 is read
!                 | 2.0   | Format      | no asset.version
/asset/minVersion | "2.1" | Unsupported | glTF version 2.1

buffers:
/buffers/0/byteLength | 100000 | Format | buffer 0 says it has 100000 bytes; there are
! | -1 | Format | buffers[0] of the glTF: invalid value
! | 4 | Format | bufferView 0 is 48 bytes from byte 0; buffer 0 has 4
/buffers | {} | Format | the glTF's buffers is not a list
! | [] | IndexOutOfRange | buffer is 0; it must be below 0
/buffers/0 | [1] | Format | buffers[0] of the glTF is not made of objects
/buffers/0/uri | "data:application/octet-stream;base64,@@" | Format | buffer 0: the data: URI is not base64
! | "data:application/octet-stream;base64" | Format | no comma
! | "data:;base64,AAAA" | Format | there are 3
! | "http://example.com/a.bin" | Unsupported | 'http://example.com/a.bin'; only files beside this one
! | "file:///etc/hostname" | Unsupported | only files beside this one
! | "C:\\a.bin" | Unsupported | only files beside this one
! | "/etc/hostname" | Unsupported | absolute path '/etc/hostname'
! | "../a.bin" | Unsupported | '../a.bin', outside the file's folder
! | "a/%2e%2e/..\\a.bin" | Unsupported | outside the file's folder
! | "%2Fetc/hostname" | Unsupported | absolute path '%2Fetc/hostname'
! | "" | Format | buffer 0 has an empty uri
! | "a.bin" | Io | a.bin
/bufferViews/0/buffer | 1 | IndexOutOfRange | buffer is 1; it must be below 1
/buffers/1 & /bufferViews/0/buffer | {"byteLength": 48} & 1 | Format | buffer 1 has no uri

buffer views:
/bufferViews/0/byteLength | 40 | Format | 4 elements of 12 bytes, 12 apart, from byte 0 do not fit into bufferView 0 of 40 bytes
/bufferViews/0/byteOffset | 18446744073709551615 | Format | from byte 18446744073709551615
/bufferViews/3/byteOffset | 1048576 | Format | bufferView 3 is 48 bytes from byte 1048576
/bufferViews/0/byteStride | 0 | Format | byteStride of 0; an element has 12 bytes
! | 18446744073709551615 | Format | do not fit
/accessors/0/byteOffset | 4 | Format | from byte 4 do not fit
! | 18446744073709551615 | Format | from byte 18446744073709551615
/accessors/0/bufferView | 99 | IndexOutOfRange | bufferView is 99; it must be below 7

counts and types:
/accessors/0/count | 0 | Format | mesh 0 'Square', primitive 0 POSITION (accessor 0) has a count of 0
! | 4294967295 | Format | has a count of 4294967295
! | 4294967294 | Format | do not fit into bufferView 0
! | 4.5 | Format | accessors[0] of the glTF: invalid type: floating point `4.5`, expected a whole number
! | 3 | IndexOutOfRange | indices (accessor 2)[4] is 3; it must be below 3
/accessors/1/count | 3 | Format | NORMAL has 3 elements; POSITION has 4
/accessors/3/count | 2 | Format | target 0 POSITION has 2 elements; POSITION has 4
/accessors/0/type | "VEC2" | Format | is of type VEC2; it must be VEC3
! | "VEC5" | Format | unknown componentType or type
/accessors/0/componentType | 5130 | Format | unknown componentType
! | 5125 | Format | has components of UNSIGNED_INT (5125); they must be floats, or bytes or shorts of KHR_mesh_quantization
/accessors/2/componentType | 5126 | Format | indices must be unsigned integers
/accessors/2/type | "VEC3" | Format | must be SCALAR
/accessors/2/count | 5 | Format | has 5 triangle corners; there must be a multiple of 3
/meshes/0/primitives/0/mode | 9 | Format | has an unknown mode
/meshes/0/primitives/0/mode & /accessors/2/count | 5 & 2 | Format | has 2 triangle corners; there must be at least 3
/meshes/0/primitives/0/attributes/POSITION | 77 | IndexOutOfRange | accessor is 77; it must be below 6
/meshes/0/primitives/0/attributes | {"NORMAL": 1} | Format | primitive 0 has no POSITION
! | {"POSITION": 0, "NORMAL": 1, "TANGENT": 1} | Format | TANGENT (accessor 1) is of type VEC3
/meshes/0/primitives/0/indices | 77 | IndexOutOfRange | indices: accessor is 77
/meshes/0/primitives/0/targets/0/POSITION | 77 | IndexOutOfRange | target 0 POSITION: accessor is 77
/meshes/0/primitives | [] | ExampleMismatch | no mesh of the file has morph targets (it has mesh 0 'Square')
/meshes/0 | [null, null, "n", [], []] | Format | meshes[0] of the glTF is not made of objects
/meshes/0/primitives/0 | [{}] | Format | meshes[0] of the glTF is not made of objects
/meshes | [] | ExampleMismatch | it has no meshes

sparse accessors:
/accessors/5/sparse/count | 5 | Format | has a sparse count of 5; it must be at most its count of 4
/accessors/5/sparse/indices/bufferView | 99 | IndexOutOfRange | sparse indices: bufferView is 99
/accessors/5/sparse/values/bufferView | 99 | IndexOutOfRange | sparse values: bufferView is 99
/accessors/5/sparse/indices/byteOffset | 2 | Format | from byte 2 do not fit
/accessors/5/sparse/values/byteOffset | 18446744073709551615 | Format | from byte 18446744073709551615
/accessors/5/sparse/indices/componentType | 5125 | Format | 2 elements of 4 bytes
! | 5126 | Format | sparse indices have an unknown componentType
/accessors/5/sparse/indices | null | Format | accessors[5] of the glTF

morph targets:
/nodes/0/translation | ["x", 0, 0] | Format | nodes[0] of the glTF: invalid type: string "x", expected a number
/meshes/0/primitives/0/targets | [] | ExampleMismatch | no mesh of the file has morph targets
! | [5] | Format | meshes[0] of the glTF

nodes:
/nodes/0/children | [0] | Format | node 0 is its own ancestor
! | [7] | IndexOutOfRange | a child of node 0 is 7; it must be below 1
/nodes | [{"mesh": 0}, {"children": [0]}, {"children": [0]}] | Format | node 0 is a child of node 1 and of node 2
! | [{"mesh": 0, "children": [1]}, {"children": [0]}] | Format | node 0 is its own ancestor
! | [{"mesh": 0, "scale": [1e30, 1, 1]}, {"children": [0], "scale": [1e30, 1, 1]}] | NotFinite | the world matrix of node 0 is inf
/nodes/0/translation | [1e300, 0, 0] | Format | nodes[0] of the glTF: number out of range
/nodes/0/matrix | [1, 2, 3] | Format | nodes[0] of the glTF: invalid length 3
"#;

#[test]
fn values_that_lie() {
    let mut last = "";
    for line in LIES.lines().filter(|line| line.contains(" | ")) {
        let [pointer, value, kind, part] = line.split(" | ").map(str::trim).collect::<Vec<_>>()[..] else {
            panic!("{line}")
        };
        last = if pointer == "!" { last } else { pointer };
        let mut glb = square();
        for (pointer, value) in last.split(" & ").zip(value.split(" & ")) {
            let (parent, key) = pointer.rsplit_once('/').unwrap();
            let parent = glb.json.pointer_mut(parent).unwrap_or_else(|| panic!("{line}"));
            let value = serde_json::from_str(value).unwrap_or_else(|e| panic!("{line}: {e}"));
            match (key.parse::<usize>(), parent) {
                (Ok(i), Value::Array(list)) if i == list.len() => list.push(value),
                (Ok(i), Value::Array(list)) => list[i] = value,
                (_, parent) => parent[key] = value,
            }
        }
        let kinds = [Format, IndexOutOfRange, NotFinite, Unsupported, ErrorKind::ExampleMismatch, ErrorKind::Io];
        let kind = kinds.into_iter().find(|k| format!("{k:?}") == kind).unwrap_or_else(|| panic!("{line}"));
        expect(&glb.bytes(), kind, part);
    }
}

#[test]
fn files_that_are_something_else() {
    expect(b"", Format, "the file is empty");
    expect(b" \n\t", Format, "the file is empty");
    expect(b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR", Format, "a PNG image");
    expect(b"\xFF\xD8\xFF\xE0", Format, "a JPEG image");
    expect(b"PK\x03\x04", Format, "a ZIP archive");
    expect(b"BLENDER-v500", Format, "a Blender file");
    expect(b"Kaydara FBX Binary", Format, "an FBX file");
    expect(b"v 1 2 3", Format, "starts with 'v 1 2 3'");
    expect(b"glTf\x02\0\0\0", Format, "starts with 'glTf");
    expect(b"{", Format, "the glTF's JSON: EOF");
    expect(b"{}", Format, "no asset.version");
    expect(b"{\"asset\": 5}", Format, "no asset.version");
    expect("{\"a\": ".repeat(5000).as_bytes(), Format, "recursion limit");
}

#[test]
fn containers_that_lie() {
    let good = square().bytes();
    let with = |at: usize, value: u32| {
        let mut glb = good.clone();
        glb[at..at + 4].copy_from_slice(&value.to_le_bytes());
        glb
    };
    let length = good.len() as u32;
    expect(&good[..11], Format, "ends after 11 bytes");
    expect(&with(4, 1), Unsupported, "GLB version 1");
    expect(&with(8, length + 1), Format, &format!("says it has {} bytes; there are {length}", length + 1));
    expect(&with(8, length - 4), Format, "says it has");
    expect(&with(8, u32::MAX), Format, "says it has 4294967295 bytes");
    expect(&with(12, u32::MAX), Format, "the GLB chunk at byte 12 says it has 4294967295 bytes");
    expect(&with(12, length), Format, "the GLB chunk at byte 12");
    expect(&with(12, 0), Format, "the GLB chunk at byte 20 says it has");
    expect(&with(16, u32::from_le_bytes(*b"BIN\0")), Format, "the first GLB chunk is 'BIN\\x00'");
    expect(&container(b"{\"asset\": {\"version\": \"2.0\"}", None), Format, "the glTF's JSON");
    expect(&container(b"\xFF\xFE{}", None), Format, "the glTF's JSON");
    expect(
        &container(square().json.to_string().as_bytes(), None),
        Format,
        "buffer 0 has neither a uri nor a binary chunk",
    );
    expect(b"glTF\x02\0\0\0\x0C\0\0\0", Format, "no JSON chunk");
    // Chunks of unknown kinds, zeros after the JSON, and what a later minor version added, are skipped.
    let mut newer = square().json;
    newer["asset"] = json!({ "version": "2.1", "minVersion": "2.0" });
    let mut json = newer.to_string().into_bytes();
    json.extend_from_slice(&[0; 8]);
    let mut glb = container(&json, Some(&square().bin));
    glb.extend_from_slice(b"\x04\0\0\0ABCD1234");
    let length = glb.len() as u32;
    glb[8..12].copy_from_slice(&length.to_le_bytes());
    gltf_slice(&glb, None, MeshChoice::First).unwrap();
}

#[test]
fn missing_and_odd_external_files() {
    let folder = tempfile::tempdir().unwrap();
    let read = |uri: &str| {
        let mut json = square().json;
        json["buffers"][0]["uri"] = uri.into();
        gltf_slice(json.to_string().as_bytes(), Some(folder.path()), MeshChoice::First).unwrap_err()
    };
    let error = read("not%20there.bin");
    assert_eq!(error.kind(), ErrorKind::Io);
    assert!(error.to_string().contains("not there.bin"), "{error}");
    std::fs::create_dir(folder.path().join("folder.bin")).unwrap();
    assert_eq!(read("folder.bin").kind(), ErrorKind::Io);
    std::fs::write(folder.path().join("short.bin"), [0; 40]).unwrap();
    assert!(read("short.bin").to_string().contains("there are 40"));
    assert_eq!(read("nul%00.bin").kind(), ErrorKind::Io);
    let error = gltf_file(&folder.path().join("none.glb"), MeshChoice::First).unwrap_err();
    assert!(error.kind() == ErrorKind::Io && error.to_string().contains("none.glb"), "{error}");
    #[cfg(unix)]
    assert!(
        gltf_file(std::path::Path::new("/dev/zero"), MeshChoice::First)
            .unwrap_err()
            .to_string()
            .contains("not a regular file")
    );
}

/// Each primitive repeats the names of its mesh and of its material.
#[test]
fn a_long_name_costs_no_memory_for_each_primitive() {
    let long = "é".repeat(50_000);
    let mut glb = square();
    let primitive = glb.json["meshes"][0]["primitives"][0].clone();
    glb.json["meshes"][0]["name"] = long.clone().into();
    glb.json["accessors"][0]["count"] = 0.into();
    let message = refuse(&glb.bytes()).to_string();
    assert!(message.len() < 300 && message.contains("ééé…'"), "{message}");
    let mut glb = square();
    let mut made_of = primitive;
    made_of["material"] = 0.into();
    glb.json["materials"] = json!([{ "name": long }]);
    glb.json["meshes"][0]["primitives"] = vec![made_of; 1000].into();
    expect(&glb.bytes(), Format, "the material of mesh 0 'Square', primitive");
}

#[test]
fn a_small_file_may_not_ask_for_much_memory() {
    // Zeros that the file does not store.
    let mut glb = square();
    glb.json["accessors"][0] = json!({ "componentType": 5126, "count": 4_000_000_000u32, "type": "VEC3" });
    expect(&glb.bytes(), Format, "asks for 48000000000 bytes");
    // The same bytes, used again and again.
    let mut glb = Glb::empty();
    let values: Vec<f32> = (0..30_000).map(|i| i as f32).collect();
    glb.floats("VEC3", &values);
    let target = glb.json["accessors"][0].clone();
    let primitives: Vec<Value> = (0..400)
        .map(|_| {
            let accessor = glb.push("accessors", target.clone());
            json!({ "attributes": { "POSITION": accessor }, "mode": 5, "targets": [{ "POSITION": accessor }] })
        })
        .collect();
    glb.push("meshes", json!({ "primitives": primitives }));
    expect(&glb.bytes(), Format, "bytes may ask for");
}

#[test]
fn sparse_accessors_that_lie() {
    let indices = |values: &[u32], kind, part: &str| {
        let mut glb = square();
        let target = glb.sparse(4, None, 4, values, &vec![1.0; values.len() * 3]);
        glb.json["meshes"][0]["primitives"][0]["targets"][1]["POSITION"] = target.into();
        expect(&glb.bytes(), kind, part);
    };
    indices(&[2, 1], Format, "sparse indices[1] is 1 after 2; they must increase");
    indices(&[1, 1], Format, "sparse indices[1] is 1 after 1; they must increase");
    indices(&[1, 4], IndexOutOfRange, "sparse indices[1] is 4; it must be below 4");
    indices(&[0, 3, u32::MAX], IndexOutOfRange, "sparse indices[2] is 4294967295; it must be below 4");
    // A count of zero violates the specification but does no harm.
    let mut glb = square();
    glb.json["accessors"][5]["sparse"]["count"] = 0.into();
    gltf_slice(&glb.bytes(), None, MeshChoice::First).unwrap();
}

#[test]
fn numbers_that_are_none() {
    for (value, shown) in [(f32::NAN, "NaN"), (f32::INFINITY, "inf"), (f32::NEG_INFINITY, "-inf")] {
        // Offsets of one float each in the binary chunk: positions, dense deltas, sparse values. Normals are computed instead.
        for (view, element, part) in [
            (0, 7, "primitive 0 POSITION (accessor 0)[2].y"),
            (3, 11, "target 0 POSITION (accessor 3)[3].z"),
            (6, 3, "target 1 POSITION (accessor 5)[3].x"),
        ] {
            let mut glb = square();
            let at = glb.json["bufferViews"][view]["byteOffset"].as_u64().unwrap() as usize + element * 4;
            glb.bin[at..at + 4].copy_from_slice(&value.to_le_bytes());
            expect(&glb.bytes(), NotFinite, &format!("{part} is {shown}"));
        }
    }
}

#[test]
fn compressed_geometry_and_unknown_requirements_are_named() {
    let mut draco = square();
    draco.json["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
    gltf_slice(&draco.bytes(), None, MeshChoice::First).expect("another mesh may be compressed");
    draco.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    let part = "primitive 0 is compressed with Draco, which holds no morph targets";
    expect(&draco.bytes(), Unsupported, part);
    let mut unknown = square();
    unknown.json["extensionsRequired"] = json!(["VENDOR_thing"]);
    let notes = gltf_slice(&unknown.bytes(), None, MeshChoice::First).unwrap().notes;
    assert!(notes[0].starts_with("the file requires VENDOR_thing, which is not known here"), "{notes:?}");
    unknown.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    expect(&unknown.bytes(), Unsupported, "no positions of its own, and the file requires VENDOR_thing");
}

#[test]
fn packed_views_that_lie() {
    let packed = |change: Value| {
        let mut glb = square();
        let stream = glb.view(&[0xA0; 64]);
        let extension = json!({
            "buffer": 0, "byteOffset": glb.json["bufferViews"][stream]["byteOffset"], "byteLength": 64, "byteStride": 12,
            "count": 4, "mode": "ATTRIBUTES",
        });
        glb.json["bufferViews"][0]["extensions"] = json!({ "EXT_meshopt_compression": extension });
        for (key, value) in change.as_object().unwrap() {
            glb.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"][key] = value.clone();
        }
        refuse(&glb.bytes())
    };
    for (change, part) in [
        (json!({}), "bufferView 0 cannot be unpacked by meshoptimizer"),
        (json!({ "mode": "LINES" }), "'LINES' is no mode of meshoptimizer's compression"),
        (json!({ "count": 4_000_000_000u32 }), "asks for 48000000000 bytes"),
        (json!({ "byteStride": 3 }), "cannot be unpacked"),
        (json!({ "byteLength": 4000 }), "is 4000 bytes from byte"),
        (json!({ "buffer": 9 }), "buffer is 9; it must be below 1"),
        (json!({ "count": "4" }), "count of its compression is \"4\"; it must be a whole number"),
    ] {
        let error = packed(change).to_string();
        assert!(error.contains(part), "'{part}' is not in: {error}");
    }
}

#[test]
fn node_trees_that_are_none() {
    let deep: Vec<Value> = (0..20_000).map(|i| json!({ "children": [i + 1] })).chain([json!({ "mesh": 0 })]).collect();
    let mut glb = square();
    glb.json["nodes"] = deep.into();
    gltf_slice(&glb.bytes(), None, MeshChoice::First).unwrap();
}
