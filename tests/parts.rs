//! A body of several parts: one list of marks dents all of them, seams stay closed while they are mounted, parts come
//! off and go on again, and hits on rigid ones leave no mark.

mod scenes;

use crumple::glam::Vec3;
use crumple::{Error, ExampleSet, Hit, HitStatus, Instance, InstanceOptions, MeshData, Serial, SetOptions};
use proptest::prelude::*;
use scenes::{Dice, Output, bowls, push, random_hit};
use std::num::NonZeroU64;
use std::sync::{Arc, OnceLock};

/// Number of parts along x and along y.
const SIDE: usize = 3;
const PARTS: usize = SIDE * SIDE;

/// Vertices of a part along x and along y.
const EDGE: usize = 9;

/// A piece of a curved sheet of 1 m by 1 m. Pieces share the positions of their edges.
fn piece(n: usize) -> MeshData {
    let (column, row) = (n % SIDE, n / SIDE);
    let at = |part: usize, i: usize| (part * (EDGE - 1) + i) as f32 / (SIDE * (EDGE - 1)) as f32 - 0.5;
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for i in 0..EDGE {
        for j in 0..EDGE {
            let (x, y) = (at(column, i), at(row, j));
            positions.push([x, y, 0.2 * (0.25 - x * x)]);
            if i + 1 < EDGE && j + 1 < EDGE {
                let v = (i * EDGE + j) as u32;
                let e = EDGE as u32;
                triangles.extend([[v, v + e, v + e + 1], [v, v + e + 1, v + 1]]);
            }
        }
    }
    MeshData { positions, triangles, ..MeshData::default() }
}

/// The base mesh is all pieces joined; the pieces are meshes 1 to 9.
fn body_set() -> Arc<ExampleSet> {
    static SET: OnceLock<Arc<ExampleSet>> = OnceLock::new();
    let make = || {
        let mut whole = MeshData::default();
        for n in 0..PARTS {
            let (first, part) = (whole.positions.len() as u32, piece(n));
            whole.positions.extend(part.positions);
            whole.triangles.extend(part.triangles.iter().map(|t| t.map(|v| first + v)));
        }
        let with_normals = MeshData { normals: Some(vec![[0.0, 0.0, 1.0]; whole.positions.len()]), ..whole.clone() };
        let examples = bowls(&with_normals, 5, 0.3, 3);
        let mut set = ExampleSet::build(whole, examples, SetOptions::default(), &Serial).unwrap();
        for n in 0..PARTS {
            assert_eq!(set.add_lod(piece(n), &Serial).unwrap(), n + 1);
        }
        Arc::new(set)
    };
    SET.get_or_init(make).clone()
}

fn new() -> Instance {
    scenes::new(&body_set())
}

fn vertices(body: &mut Instance, lod: usize) -> Vec<[f32; 3]> {
    Output::fresh_level(body, lod).positions
}

/// The vertices of a part as the base mesh has them.
fn of_base(base: &[[f32; 3]], part: usize) -> &[[f32; 3]] {
    let count = EDGE * EDGE;
    &base[(part - 1) * count..part * count]
}

/// The part that a base vertex came from.
fn part_of(vertex: u32) -> usize {
    vertex as usize / (EDGE * EDGE) + 1
}

fn centre(part: usize) -> [f32; 3] {
    piece(part - 1).positions[EDGE * EDGE / 2]
}

fn dent(part: usize, depth: f32) -> Hit {
    push(centre(part), [0.0, 0.0, -depth])
}

proptest! {
    #![proptest_config(scenes::cases(16))]

    /// One list of marks dents every part, and all parts together are the whole body, bit for bit: so seams are closed.
    #[test]
    fn mounted_parts_are_the_whole_body(seed: u64) {
        let mut body = new();
        let mut dice = Dice::new(seed);
        for _ in 0..6 {
            body.submit(&random_hit(body.example_set(), &mut dice)).unwrap();
        }
        let whole = vertices(&mut body, 0);
        for part in 1..=PARTS {
            prop_assert_eq!(&vertices(&mut body, part)[..], of_base(&whole, part), "part {}", part);
        }
    }

    /// Parts come off and go on in any order. What is off keeps its dents and gets only its own; the rest gets no hit
    /// where the part was. A part that is on gets what the body gets.
    #[test]
    fn what_is_off_is_alone(seed: u64) {
        let set = body_set();
        let mut dice = Dice::new(seed);
        let mut body = new();
        // What each list of marks must have got: that of the body, and those of parts that came off.
        let mut whole = new();
        let mut own: Vec<Option<(Instance, Instance, bool)>> = (0..=PARTS).map(|_| None).collect();
        for _ in 0..30 {
            let part = 1 + dice.index(PARTS);
            match (dice.index(4), &mut own[part]) {
                (0, slot @ None) => {
                    let before = vertices(&mut body, part);
                    let mut released = body.release(part).unwrap();
                    prop_assert_eq!(vertices(&mut released, part), before, "it keeps its dents");
                    let mut alike = new();
                    alike.copy_damage_from(&mut whole).unwrap();
                    *slot = Some((released, alike, false));
                }
                (0, Some((instance, _, on))) if *on => {
                    body.unmount(instance).unwrap();
                    *on = false;
                }
                (0, Some((instance, _, on))) => {
                    body.mount(instance).unwrap();
                    *on = true;
                }
                (1, Some((instance, alike, false))) => {
                    let told = instance.submit(&random_hit(&set, &mut dice)).unwrap();
                    let known = set.lod_mesh(part).unwrap().positions();
                    prop_assert!(known.contains(&set.mesh().positions()[told.contact_vertex as usize]));
                    add(alike, told.mark);
                }
                _ => {
                    let told = body.submit(&random_hit(&set, &mut dice)).unwrap();
                    let at = set.mesh().positions()[told.contact_vertex as usize];
                    let on = |part: usize| own[part].as_ref().is_none_or(|(.., on)| *on);
                    let holds = |part: &usize| set.lod_mesh(*part).unwrap().positions().contains(&at);
                    prop_assert!((1..=PARTS).filter(holds).any(on), "it landed where nothing is");
                    add(&mut whole, told.mark);
                    for (_, alike, on) in own.iter_mut().flatten() {
                        if *on {
                            add(alike, told.mark);
                        }
                    }
                }
            }
        }
        prop_assert_eq!(body.marks().unwrap(), whole.marks().unwrap());
        for (instance, alike, _) in own.iter_mut().flatten() {
            prop_assert_eq!(instance.marks().unwrap(), alike.marks().unwrap());
        }
    }
}

/// Adds a mark as a hit would.
fn add(to: &mut Instance, mark: Option<crumple::Mark>) {
    let Some(mark) = mark else { return };
    let mut marks = to.marks().unwrap().to_vec();
    let same = marks.iter_mut().find(|m| scenes::key(m) == scenes::key(&mark));
    match same {
        Some(same) => same.energy += mark.energy,
        None => marks.push(mark),
    }
    to.set_marks(&marks).unwrap();
}

#[test]
fn quick_a_bumper_falls_off_and_is_put_on_again() {
    let mut body = new();
    body.submit(&dent(5, 0.03)).unwrap();
    let mut bumper = body.release(5).unwrap();
    assert_eq!(bumper.revision(), body.revision());
    // On again: hits on the body land on it, and dent it too, also in parts of a contact.
    body.mount(&mut bumper).unwrap();
    let before = bumper.measure(5).unwrap();
    let id = NonZeroU64::new(7).unwrap();
    for _ in 0..2 {
        let told = body.submit(&dent(5, 0.02).of_contact(id)).unwrap();
        assert_eq!(part_of(told.contact_vertex), 5);
    }
    body.end_contact(id).unwrap();
    let mark = body.contact(id).unwrap().unwrap().mark.unwrap();
    assert!(body.marks().unwrap().contains(&mark) && bumper.marks().unwrap().contains(&mark));
    assert!(bumper.measure(5).unwrap().deepest > before.deepest);
    // A part that is gone for ever is no harm.
    drop(bumper);
    body.submit(&dent(4, 0.02)).unwrap();
    let damage = body.measure(0).unwrap();
    let moved: Vec<f32> = vertices(&mut body, 0)
        .iter()
        .zip(body.example_set().mesh().positions())
        .map(|(now, base)| (Vec3::from_array(*now) - *base).length())
        .collect();
    assert!((damage.deepest - moved.iter().copied().fold(0.0, f32::max)).abs() < 1e-6);
    assert!((damage.mean - moved.iter().sum::<f32>() / moved.len() as f32).abs() < 1e-6);
}

#[test]
fn quick_what_is_measured_depends_on_the_marks_alone() {
    let mut plain = new();
    let options = InstanceOptions { grow_time: 1.0, ..InstanceOptions::default() };
    let mut slow = Instance::new(body_set(), options).unwrap();
    for body in [&plain, &slow] {
        body.submit(&dent(5, 0.03)).unwrap();
        body.submit(&dent(3, 0.002)).unwrap();
    }
    for part in 0..=PARTS {
        assert_eq!(slow.measure(part).unwrap(), plain.measure(part).unwrap());
    }
    assert_eq!(slow.measure(5).unwrap().deepest, plain.measure(0).unwrap().deepest);
    assert!(vertices(&mut slow, 5) == piece(4).positions, "nothing is shown yet");
}

#[test]
fn quick_energy_lies_where_the_contacts_are() {
    let mut body = new();
    body.submit(&dent(1, 0.02)).unwrap();
    body.submit(&dent(9, 0.02)).unwrap();
    let energy = |body: &mut Instance, lod| body.measure(lod).unwrap().energy;
    let one = energy(&mut body, 1);
    assert!((one - 0.02).abs() < 1e-4);
    assert!((energy(&mut body, 0) / one - 2f32.powf(1.0 / 2.4)).abs() < 1e-4);
    assert_eq!((energy(&mut body, 5), energy(&mut body, 9)), (0.0, one));
    // A contact on the seam is on both parts.
    body.submit(&push(piece(4).positions[EDGE / 2], [0.0, 0.0, -0.01])).unwrap();
    assert!((energy(&mut body, 4) - 0.01).abs() < 1e-4 && (energy(&mut body, 5) - 0.01).abs() < 1e-4);
}

/// Limits and stiffness of vertices are those of the parts that they are in.
#[test]
fn quick_a_part_has_a_limit_and_a_stiffness_of_its_own() {
    let set = body_set();
    let of = |value: f32, part: usize, other: f32| {
        (0..set.vertex_count() as u32).map(|v| if part_of(v) == part { value } else { other }).collect()
    };
    let mesh = MeshData {
        positions: set.mesh().positions().iter().map(|p| p.to_array()).collect(),
        triangles: set.mesh().triangles().to_vec(),
        depth_limits: Some(of(0.01, 5, 1.0)),
        stiffness: Some(of(0.5, 9, 0.0)),
        ..MeshData::default()
    };
    let with_normals = MeshData { normals: Some(vec![[0.0, 0.0, 1.0]; mesh.positions.len()]), ..mesh.clone() };
    let mut limited = ExampleSet::build(mesh, bowls(&with_normals, 5, 0.3, 3), SetOptions::default(), &Serial).unwrap();
    for n in 0..PARTS {
        limited.add_lod(piece(n), &Serial).unwrap();
    }
    let (mut limited, mut free) = (scenes::new(&Arc::new(limited)), new());
    for part in [1, 5, 9] {
        let hit = dent(part, 0.03);
        limited.submit(&hit).unwrap();
        free.submit(&hit).unwrap();
    }
    let deepest = |body: &mut Instance, part| body.measure(part).unwrap().deepest;
    assert_eq!(deepest(&mut limited, 1), deepest(&mut free, 1));
    assert!(deepest(&mut limited, 5) <= 0.010001 && deepest(&mut free, 5) > 0.029);
    assert!(deepest(&mut limited, 9) < 0.6 * deepest(&mut free, 9));
}

#[test]
fn quick_glass_reports_and_does_not_dent() {
    let mut body = new();
    body.set_rigid(5, true).unwrap();
    let told = body.submit(&dent(5, 0.03)).unwrap();
    assert_eq!((told.status, told.mark, part_of(told.contact_vertex)), (HitStatus::Rigid, None, 5));
    assert!(told.target[2] < -0.029);
    assert!(body.marks().unwrap().is_empty());
    // The frame around it is not glass.
    let edge = push(piece(4).positions[0], [0.0, 0.0, -0.03]);
    assert_eq!(body.submit(&edge).unwrap().status, HitStatus::Marked);
    body.set_rigid(5, false).unwrap();
    assert_eq!(body.submit(&dent(5, 0.03)).unwrap().status, HitStatus::Marked);
}

#[test]
fn quick_what_cannot_come_off_is_refused_by_name() {
    let mut body = new();
    let message = |r: Result<Instance, Error>| r.unwrap_err().to_string();
    assert!(message(body.release(0)).starts_with("part is 0; it must be 1 or more"));
    assert!(message(body.release(99)).contains("is 99; it must be below 10"));
    let mut part = body.release(2).unwrap();
    assert!(message(body.release(2)).contains("this one is off"));
    assert!(message(part.release(3)).contains("a part has no parts"));
    let mut other = new();
    assert!(other.mount(&mut part).unwrap_err().to_string().contains("off the body"));
    assert!(body.unmount(&mut part).unwrap_err().to_string().contains("on this body"));
    body.mount(&mut part).unwrap();
    assert!(body.mount(&mut part).unwrap_err().to_string().contains("off the body"));
    assert!(body.mount(&mut other).unwrap_err().to_string().starts_with("part is 0"));
    body.unmount(&mut part).unwrap();
    // All but one may come off.
    let mut off = vec![part];
    for n in (1..=PARTS).filter(|n| *n != 2 && *n != 7) {
        off.push(body.release(n).unwrap());
    }
    let told = body.submit(&dent(1, 0.02)).unwrap();
    let at = body.example_set().mesh().positions()[told.contact_vertex as usize].to_array();
    assert!(piece(6).positions.contains(&at));
    assert!(message(body.release(7)).contains("one of several on the body"));
    // A mesh that shares no vertex with the base mesh is no part.
    let (sheet, examples) = (scenes::sheet(4), bowls(&scenes::sheet(4), 2, 0.4, 1));
    let mut coarse = ExampleSet::build(sheet, examples, SetOptions::default(), &Serial).unwrap();
    let mut proxy = scenes::sheet(3);
    proxy.positions.iter_mut().for_each(|p| p[2] += 0.01);
    coarse.add_lod(proxy, &Serial).unwrap();
    assert!(message(scenes::new(&Arc::new(coarse)).release(1)).contains("positions of base vertices"));
}
