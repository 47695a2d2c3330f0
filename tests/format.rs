//! Baked sets: a loaded set equals the saved one, whatever its options. A damaged file gives an error, or a set that
//! keeps the promises; any damage is for the fuzz target `load`.

mod scenes;

#[path = "../fuzz/src/baked.rs"]
mod baked;

use std::sync::Arc;

use baked::{load_and_use, repair};
use crumple::{
    Blow, Deltas, Error, ErrorKind, ExampleData, ExampleSet, MeshData, Serial, SetOptions, Striker, ThreadPool,
    VertexMass,
};
use scenes::{Output, new, random_hits};

const HEADER: usize = 64;
const ENTRY: usize = 32;

fn load(file: &[u8]) -> Result<ExampleSet, Error> {
    ExampleSet::load(file.to_vec(), &Serial)
}

fn baked(tolerance: f32) -> SetOptions {
    SetOptions { tolerance: Some(tolerance), ..SetOptions::default() }
}

/// Sets with each optional part, and without any.
fn small_sets() -> Vec<(&'static str, Arc<ExampleSet>)> {
    let cube = scenes::cube(4);
    let bowls = scenes::bowls(&cube, 4, 0.5, 3);
    let masses = (0..cube.positions.len()).map(|v| 1.0 + v as f32).collect();
    let mut placed = bowls.clone();
    placed[2].name = "délle → 2".into();
    placed[0].blow = Blow {
        impulse: Some([0.5, -0.25, -9.0]),
        duration: Some(0.01),
        normal: Some([0.3, 0.4, 0.7]),
        striker: Striker {
            mass: Some(2.5),
            velocity: Some([0.1, 0.0, -4.0]),
            radius: Some(0.08),
            ..Default::default()
        },
    };
    placed[1].blow.duration = Some(0.02);
    placed[2].blow.striker.radius = Some(0.125);
    placed.push(ExampleData::new("", Deltas::Sparse { indices: vec![], values: vec![] }));
    let sheet = scenes::sheet(8);
    let points = MeshData { positions: sheet.positions.clone(), ..MeshData::default() };
    let point_dents = scenes::bowls(&sheet, 3, 0.4, 5);
    let mut levels = scenes::build(cube.clone(), placed.clone(), baked(1e-4));
    let set = Arc::get_mut(&mut levels).unwrap();
    set.add_lod(scenes::cube(6), &Serial).unwrap();
    set.add_lod(scenes::cube(2), &Serial).unwrap();
    let mut sets = vec![("levels of detail", levels)];
    let mut add = |name, mesh: &MeshData, examples: &[ExampleData], options| {
        sets.push((name, scenes::build(mesh.clone(), examples.to_vec(), options)));
    };
    add("cube", &cube, &bowls, SetOptions::default());
    add("baked cube", &cube, &bowls, baked(1e-3));
    let all_options = SetOptions {
        depth_limit: Some(0.2),
        mass: VertexMass::PerVertex(masses),
        drop_below: 1e-4,
        normal_tolerance: 3.0,
        mirror: false,
        ..baked(1e-4)
    };
    add("all options", &cube, &placed, all_options);
    let dents = scenes::bowls(&sheet, 3, 0.3, 7);
    let numbers = |scale: f32| (0..sheet.positions.len()).map(|v| scale * (v % 7) as f32).collect();
    let limited = MeshData { depth_limits: Some(numbers(0.01)), stiffness: Some(numbers(0.1)), ..sheet.clone() };
    add("held sheet with limits", &limited, &dents, baked(1e-5));
    add("points", &points, &point_dents, SetOptions { mass: VertexMass::Uniform(2.0), ..baked(1e-3) });
    let mut learned = scenes::learned(&scenes::sheet(12), 12, 4);
    Arc::get_mut(&mut learned).unwrap().add_lod(scenes::sheet(5), &Serial).unwrap();
    sets.push(("learned", learned));
    sets
}

/// The small sets, and larger bodies, exact and baked.
fn sets() -> Vec<(String, Arc<ExampleSet>)> {
    let mut all: Vec<(String, Arc<ExampleSet>)> =
        small_sets().into_iter().chain(scenes::small_bodies()).map(|(n, s)| (n.to_owned(), s)).collect();
    for body in ["panel", "tube"] {
        for tolerance in [None, Some(1e-4)] {
            let options = SetOptions { tolerance, ..SetOptions::default() };
            all.push((format!("{body} {tolerance:?}"), scenes::solver_with(body, 9, options)));
        }
    }
    all
}

#[test]
fn loaded_sets_are_the_saved_ones_bit_for_bit() {
    let pool = ThreadPool::new(3).unwrap();
    for (name, set) in sets() {
        let file = set.save().unwrap();
        assert_eq!(file.len(), set.saved_bytes(), "{name}");
        let loaded = Arc::new(ExampleSet::load(file.clone(), &pool).unwrap_or_else(|e| panic!("{name}: {e}")));
        assert_eq!(loaded.save().unwrap(), file, "{name}");
        assert_eq!(loaded.fingerprint(), set.fingerprint(), "{name}");
        assert_eq!(*loaded.options(), SetOptions { basis: None, ..set.options().clone() }, "{name}");
        assert_eq!(loaded.report(), set.report(), "{name}");
        assert_eq!(loaded.example_errors(), set.example_errors(), "{name}");
        assert_eq!(loaded.depth_limit().to_bits(), set.depth_limit().to_bits(), "{name}");
        assert_eq!(loaded.mesh().triangles(), set.mesh().triangles(), "{name}");
        assert_eq!(loaded.mesh().seam_count(), set.mesh().seam_count(), "{name}");
        for (a, b) in loaded.examples().iter().zip(set.examples()) {
            assert_eq!((a.name(), a.depth()), (b.name(), b.depth()), "{name}");
            assert_eq!(a.blow(), b.blow(), "{name}");
        }
        let hits = random_hits(&set, 40, 11);
        let [mut a, mut b] = [&set, &loaded].map(new);
        for h in &hits {
            assert_eq!(a.submit(h).unwrap(), b.submit(h).unwrap(), "{name}");
        }
        assert_eq!(a.marks().unwrap(), b.marks().unwrap(), "{name}");
        assert_eq!(Output::fresh(&mut a).all_bits(), Output::fresh(&mut b).all_bits(), "{name}");
        for lod in 1..set.lod_count() {
            let [a, b] = [&mut a, &mut b].map(|instance| Output::fresh_level(instance, lod).positions);
            assert_eq!(a, b, "{name} at level {lod}");
            let at_rest = set.lod_mesh(lod).unwrap().positions();
            assert!(a.iter().zip(at_rest).any(|(p, rest)| *p != rest.to_array()), "{name} at level {lod}");
        }
        // The saved damage of one set loads into the other.
        b.reset();
        b.load(&a.save()).unwrap();
    }
}

/// The set of a body of more positions than nodes, whose file holds its examples whole, and as they are without that.
#[test]
fn files_without_whole_examples_are_smaller_and_give_the_same_dents() {
    let (mesh, examples) = scenes::solver("panel", 9);
    let build = |whole_examples| {
        let options = SetOptions { whole_examples, ..baked(1e-4) };
        Arc::new(ExampleSet::build(mesh.clone(), examples.clone(), options, &Serial).unwrap())
    };
    let (whole, set) = (build(true), build(false));
    let (whole_file, file) = (whole.save().unwrap(), set.save().unwrap());
    assert!(whole_file.len() - file.len() >= whole.report().anchored_bytes);
    let loaded = Arc::new(load(&file).unwrap());
    assert!(
        !loaded.has_whole_examples() && set.has_whole_examples() && load(&whole_file).unwrap().has_whole_examples()
    );
    assert_eq!(loaded.save().unwrap(), file);
    assert_eq!((loaded.fingerprint(), set.fingerprint()), (whole.fingerprint(), whole.fingerprint()));
    assert_eq!(loaded.memory_bytes() + whole.report().anchored_bytes, whole.memory_bytes());
    assert_eq!(loaded.report().anchored_bytes, 0);
    let [mut a, mut b, mut c] = [&set, &loaded, &whole].map(new);
    for hit in &random_hits(&set, 60, 11) {
        let told = a.submit(hit).unwrap();
        assert_eq!((b.submit(hit).unwrap(), c.submit(hit).unwrap()), (told, told));
    }
    let marks = a.marks().unwrap();
    assert_eq!((b.marks().unwrap(), c.marks().unwrap()), (marks, marks));
    let bits = Output::fresh(&mut a).all_bits();
    assert!(bits == Output::fresh(&mut b).all_bits() && bits == Output::fresh(&mut c).all_bits());
    let off = |v: u32| loaded.examples()[0].delta(v).distance(set.examples()[0].delta(v));
    assert!((0..set.vertex_count() as u32).all(|v| off(v) == 0.0));
    let classic = crumple::InstanceOptions::classic(crumple::Rule::MostDisplaced);
    let refused = crumple::Instance::new(loaded.clone(), classic).unwrap_err();
    assert!(refused.to_string().contains("baked without whole examples"), "{refused}");
}

#[test]
fn aligned_bytes_are_used_where_they_lie_and_others_copied() {
    let file = scenes::sheet_set().save().unwrap();
    let mut room = vec![0u8; file.len() + 64];
    for shift in [0usize, 1, 4, 8, 16] {
        let start = room.as_ptr().align_offset(64) + shift;
        room[start..start + file.len()].copy_from_slice(&file);
        // Leaking is fine in a test.
        let bytes: &'static [u8] = &room.clone().leak()[start..start + file.len()];
        let set = ExampleSet::load(bytes, &Serial).unwrap();
        let inside = bytes.as_ptr_range().contains(&set.mesh().positions().as_ptr().cast::<u8>());
        assert_eq!(inside, bytes.as_ptr().addr().is_multiple_of(16), "{shift}");
        assert_eq!(set.save().unwrap(), file);
    }
}

#[test]
fn the_source_order_stays_with_the_set() {
    let mut mesh = scenes::ball(2);
    let mut examples = scenes::bowls(&mesh, 3, 0.3, 1);
    let order = crumple::reorder(&mut mesh, &mut examples);
    let mut set = ExampleSet::build(mesh, examples, SetOptions::default(), &Serial).unwrap();
    assert!(set.set_source_order(vec![0; order.len()]).is_err());
    assert!(set.set_source_order(vec![0]).is_err());
    set.set_source_order(order.clone()).unwrap();
    assert_eq!(load(&set.save().unwrap()).unwrap().source_order(), Some(&order[..]));
}

#[test]
fn a_damaged_file_says_what_is_wrong() {
    let file = scenes::sheet_set().save().unwrap();
    let message = |damage: &dyn Fn(&mut Vec<u8>)| {
        let mut f = file.clone();
        damage(&mut f);
        load(&f).unwrap_err().to_string()
    };
    assert!(message(&|f| f[0] = b'X').contains("'Xrumple\\n'"), "{}", message(&|f| f[0] = b'X'));
    assert!(message(&|f| f.truncate(30)).contains("30 bytes"));
    assert!(message(&|f| f.clear()).contains("0 bytes"));
    assert!(message(&|f| f.truncate(5000)).contains("5000"));
    assert!(message(&|f| f[24] = 9).contains("version 9"));
    let middle = file.len() / 2;
    assert!(message(&|f| f[middle] ^= 1).contains("checksum"));
    let e = load(b"glTF, or anything else that is no set; long enough for a header that it has not").unwrap_err();
    assert_eq!(e.kind(), ErrorKind::Format);
}

/// Found by fuzzing: such a slope is longer than floats tell.
#[test]
fn slopes_of_any_size_leave_normals_finite() {
    let mut file = scenes::sheet_set().save().unwrap();
    let word = |file: &[u8], at: usize| u64::from_le_bytes(file[at..at + 8].try_into().unwrap()) as usize;
    let id = |at: &usize| file[*at..*at + 4] == 37u32.to_le_bytes();
    let entry = (HEADER..).step_by(ENTRY).find(id).unwrap();
    let (from, length) = (word(&file, entry + 8), word(&file, entry + 16));
    for unit in file[from..from + length].chunks_exact_mut(4) {
        unit.copy_from_slice(&1e38f32.to_le_bytes());
    }
    baked::repair(&mut file);
    assert!(baked::load_and_use(file));
}

#[test]
fn a_wrong_blow_is_named() {
    let (_, set) = &small_sets()[0];
    let file = set.save().unwrap();
    let blow = sections(&file)[1].0 + 48;
    assert_eq!(file[blow..blow + 4], 0.5f32.to_le_bytes(), "the first number of the first example's blow");
    let cases = [(16, 2.0f32, "blow.normal of example 0"), (28, -2.5, "blow.striker.mass of example 0 is -2.5")];
    for (at, value, message) in cases {
        let mut wrong = file.clone();
        wrong[blow + at..blow + at + 4].copy_from_slice(&value.to_le_bytes());
        repair(&mut wrong);
        let e = load(&wrong).unwrap_err();
        assert!(e.kind() == ErrorKind::Format && e.to_string().contains(message), "{e} is not {message}");
    }
}

/// Offset and length of every section.
fn sections(file: &[u8]) -> Vec<(usize, usize)> {
    let word = |at: usize| u64::from_le_bytes(file[at..at + 8].try_into().unwrap()) as usize;
    let count = u32::from_le_bytes(file[28..32].try_into().unwrap()) as usize;
    (0..count).map(|i| HEADER + i * ENTRY).map(|at| (word(at + 8), word(at + 16))).collect()
}

#[test]
fn every_byte_of_header_and_table_matters_or_does_no_harm() {
    let (_, set) = &small_sets()[2];
    let file = set.save().unwrap();
    let end = HEADER + sections(&file).len() * ENTRY;
    for at in 0..end {
        for value in [0, 1, 0x7F, 0x80, 0xFF, file[at] ^ 1, file[at].wrapping_add(64)] {
            if value == file[at] {
                continue;
            }
            let mut damaged = file.clone();
            damaged[at] = value;
            assert!(load(&damaged).is_err(), "byte {at} = {value} passes");
            // The file with its length and checksum corrected may load only if the damage was in those two fields.
            repair(&mut damaged);
            assert!(!load_and_use(damaged) || (8..24).contains(&at), "byte {at} = {value} passes when repaired");
        }
    }
}

#[test]
fn optional_sections_are_skipped_and_others_refused() {
    let file = scenes::sheet_set().save().unwrap();
    let count = sections(&file).len();
    let end = HEADER + count * ENTRY;
    // Adds a table entry before the first section, and moves the sections to make room for it.
    let with = |flags: u32| {
        let shift = 64;
        let mut out = file[..end].to_vec();
        for i in 0..count {
            let at = HEADER + i * ENTRY + 8;
            let offset = u64::from_le_bytes(out[at..at + 8].try_into().unwrap()) + shift;
            out[at..at + 8].copy_from_slice(&offset.to_le_bytes());
        }
        let first = sections(&file)[0].0;
        let last = (file.len() as u64 + shift).next_multiple_of(64);
        out[28..32].copy_from_slice(&(count as u32 + 1).to_le_bytes());
        out.extend([9999u32.to_le_bytes(), 0u32.to_le_bytes()].concat());
        out.extend(last.to_le_bytes());
        out.extend(3u64.to_le_bytes());
        out.extend([1u32.to_le_bytes(), flags.to_le_bytes()].concat());
        out.resize(first + shift as usize, 0);
        out.extend(&file[first..]);
        out.resize(last as usize, 0);
        out.extend(b"new");
        repair(&mut out);
        out
    };
    assert_eq!(load(&with(1)).unwrap().save().unwrap(), file);
    let e = load(&with(0)).unwrap_err();
    assert!(e.kind() == ErrorKind::Unsupported && e.to_string().contains("9999"), "{e}");
}
