//! Small inputs to begin fuzzing with, and the small sets that targets use.

use std::path::Path;
use std::sync::{Arc, OnceLock};

use crumple::import::Imported;
use crumple::{
    Deltas, ExampleData, ExampleSet, Hit, Instance, InstanceOptions, MeshData, Rule, Serial, SetOptions, VertexMass,
};

/// Names of files and their bytes.
pub type Seeds = Vec<(String, Vec<u8>)>;

/// Writes seeds to a folder.
pub fn write(seeds: fn() -> Seeds, folder: &Path) {
    for (name, bytes) in seeds() {
        std::fs::write(folder.join(name), bytes).expect("a folder that can be written to");
    }
}

/// Files of the repository.
fn files(paths: &[&str]) -> Seeds {
    let read = |path: &&str| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path);
        let name = path.file_name().expect("a file").to_string_lossy().into_owned();
        (name, std::fs::read(path).expect("a file of the repository"))
    };
    paths.iter().map(read).collect()
}

/// A sheet of `n` by `n` squares with a seam down the middle.
pub fn sheet(n: u32) -> MeshData {
    let mut mesh = MeshData::default();
    for half in 0..2u32 {
        let first = mesh.positions.len() as u32;
        for i in 0..=n / 2 {
            for j in 0..=n {
                mesh.positions.push([(half * (n / 2) + i) as f32 / n as f32, j as f32 / n as f32, 0.0]);
            }
        }
        for i in 0..n / 2 {
            for j in 0..n {
                let a = first + i * (n + 1) + j;
                mesh.triangles.extend([[a, a + n + 1, a + n + 2], [a, a + n + 2, a + 1]]);
            }
        }
    }
    mesh
}

/// A small closed mesh.
pub fn tetrahedron() -> MeshData {
    MeshData {
        positions: vec![[0.5, 0.5, -0.1], [0.7, 0.5, -0.3], [0.4, 0.7, -0.3], [0.4, 0.3, -0.3]],
        triangles: vec![[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]],
        ..MeshData::default()
    }
}

/// Round dents in a sheet.
pub fn dents(mesh: &MeshData, count: u32) -> Vec<ExampleData> {
    let dent = |k: u32| {
        let c = [0.2 + 0.3 * (k % 3) as f32, 0.3 + 0.4 * (k / 3) as f32];
        let field = |p: &[f32; 3]| {
            let w = (1.0 - ((p[0] - c[0]).powi(2) + (p[1] - c[1]).powi(2)) / 0.09).max(0.0);
            [0.02 * w * (p[0] - c[0]), 0.0, -0.05 * w * w * (1.0 + k as f32)]
        };
        ExampleData::new(format!("dent {k}"), Deltas::Full(mesh.positions.iter().map(field).collect()))
    };
    (0..count).map(dent).collect()
}

/// Baked sets with each optional part, and without any.
pub fn baked() -> Seeds {
    let baked = SetOptions { tolerance: Some(1e-3), ..SetOptions::default() };
    let mesh = sheet(12);
    let points = MeshData { positions: mesh.positions.clone(), ..MeshData::default() };
    let mut one_empty = dents(&mesh, 4);
    one_empty[2].positions = Deltas::Sparse { indices: vec![], values: vec![] };
    let masses = vec![2.0; mesh.positions.len()];
    let tangents = MeshData { tangents: Some(vec![[1.0, 0.0, 0.0, 1.0]; mesh.positions.len()]), ..mesh.clone() };
    let sets = [
        (mesh.clone(), dents(&mesh, 2), SetOptions::default()),
        (mesh.clone(), dents(&mesh, 2), baked.clone()),
        (tangents, one_empty, SetOptions { mass: VertexMass::PerVertex(masses), ..baked }),
        (points.clone(), dents(&points, 1), SetOptions::default()),
        (sheet(2), dents(&sheet(2), 1), SetOptions { mirror: false, tolerance: Some(1e-7), ..SetOptions::default() }),
    ];
    let file = |(i, (mesh, examples, options))| {
        let set = ExampleSet::build(mesh, examples, options, &Serial).expect("a seed");
        (format!("set{i}.crumple"), set.save().expect("saved"))
    };
    sets.into_iter().enumerate().map(file).collect()
}

/// Three bodies of one set with some dents: two with marks, one with a classic rule.
pub fn dented() -> [Instance; 3] {
    static SET: OnceLock<Arc<ExampleSet>> = OnceLock::new();
    let set = SET.get_or_init(|| {
        let mesh = sheet(6);
        Arc::new(ExampleSet::build(mesh.clone(), dents(&mesh, 4), SetOptions::default(), &Serial).expect("a seed"))
    });
    let few = InstanceOptions { capacity: 4, ..InstanceOptions::default() };
    [InstanceOptions::default(), few, InstanceOptions::classic(Rule::MostDisplaced)].map(|options| {
        let body = Instance::new(set.clone(), options).expect("valid options");
        for at in [[0.2, 0.3, 0.0], [0.7, 0.5, 0.0]] {
            body.submit(&Hit::displacement(at, [0.0, 0.0, -0.03])).expect("a hit on the sheet");
        }
        body
    })
}

/// Saved damage of each kind. The first byte says what reads it.
pub fn damage() -> Seeds {
    let mut bodies = dented();
    bodies[0].submit(&Hit::displacement([0.5, 0.5, 0.0], [0.0, 0.01, -0.04])).expect("a hit on the sheet");
    let each = [0, 1, 2].map(|at| (at as u8, bodies[at].save()));
    let all = (3, crumple::save_all(&mut bodies));
    let file = |(i, (kind, bytes)): (usize, (u8, Vec<u8>))| (format!("damage{i}"), [&[kind][..], &bytes].concat());
    each.into_iter().chain([all]).enumerate().map(file).collect()
}

/// A base OBJ and its example.
pub fn obj() -> Seeds {
    let files = files(&["tests/fixtures/plate.obj", "tests/fixtures/plate_dent.obj"]);
    vec![("plate".into(), files.iter().map(|(_, bytes)| bytes.as_slice()).collect::<Vec<_>>().join(&0))]
}

/// glTF files as their JSON, a zero byte and their binary chunk.
pub fn gltf() -> Seeds {
    let names = ["nodes", "animated", "seams_sparse", "two_materials", "two_materials_sparse"];
    let paths = names.map(|name| format!("tests/fixtures/{name}.glb"));
    let glb = files(&paths.each_ref().map(String::as_str));
    let parts = |(name, file): &(String, Vec<u8>)| {
        let length = u32::from_le_bytes(file[12..16].try_into().expect("4 bytes")) as usize;
        let (json, binary) = (&file[20..20 + length], &file[28 + length..]);
        (name.replace(".glb", ""), [json, &[0], binary].concat())
    };
    glb.iter().map(parts).collect()
}

/// The GLB file of a JSON text and a binary chunk with a zero byte between them.
pub fn glb(parts: &[u8]) -> Vec<u8> {
    let mut halves = parts.splitn(2, |byte| *byte == 0);
    let mut file = [&b"glTF"[..], &2u32.to_le_bytes(), &[0; 4]].concat();
    for (kind, fill) in [(b"JSON", b' '), (b"BIN\0", 0)] {
        let Some(chunk) = halves.next() else { break };
        let padded = chunk.len().next_multiple_of(4);
        file.extend((padded as u32).to_le_bytes());
        file.extend(kind);
        file.extend(chunk);
        file.extend(vec![fill; padded - chunk.len()]);
    }
    let length = file.len() as u32;
    file[8..12].copy_from_slice(&length.to_le_bytes());
    file
}

/// Builds a set from what was imported, hits it and deforms it.
pub fn build_and_use(imported: Imported) {
    if let Ok(set) = ExampleSet::build(imported.mesh, imported.examples, SetOptions::default(), &Serial) {
        crate::baked::load_and_use(set.save().expect("a small set"));
    }
}

/// The lists of impacts in the documentation.
pub fn impacts() -> Seeds {
    let page = files(&["docs/impacts.md"]).remove(0).1;
    let page = String::from_utf8(page).expect("a text");
    let lists = page.split("```json").skip(1).filter_map(|part| part.split("```").next());
    lists.enumerate().map(|(i, list)| (format!("impacts{i}.json"), list.into())).collect()
}

/// Random bytes, for targets whose every input means something.
pub fn noise() -> Seeds {
    let bytes = |seed: u64| {
        let mut state = seed + 1;
        let mut next = || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            state as u8
        };
        (0..512 << (seed % 3)).map(|_| next()).collect()
    };
    (0..12).map(|seed| (format!("noise{seed}"), bytes(seed))).collect()
}
