//! Hits from several threads while their body is folded and its parts come off and go on. `cargo xtask schedules` runs these tests in
//! thousands of orders of the threads' steps.

use super::Instance;
use crate::base::tasks::Serial;
use crate::damage::mark::Mark;
use crate::example::data::{Deltas, ExampleData};
use crate::example::options::SetOptions;
use crate::example::set::ExampleSet;
use crate::mesh::data::MeshData;
use crate::select::hit::Hit;
use crate::select::options::InstanceOptions;
use glam::{Mat4, Vec3};
#[cfg(shuttle)]
use shuttle::thread;
use std::sync::{Arc, OnceLock};
#[cfg(not(shuttle))]
use std::thread;

/// Vertices of a part along an edge.
const EDGE: usize = 5;
/// The centre of part 1 and that of part 2.
const CENTRES: [[f32; 3]; 2] = [[-0.5, 0.0, 0.0], [0.5, 0.0, 0.0]];

/// A plate of 1 m by 1 m about a centre.
fn plate(centre: [f32; 3]) -> MeshData {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for v in 0..EDGE * EDGE {
        let at = |i: usize| i as f32 / (EDGE - 1) as f32 - 0.5;
        positions.push([centre[0] + at(v / EDGE), at(v % EDGE), 0.0]);
        if v / EDGE + 1 < EDGE && v % EDGE + 1 < EDGE {
            let (v, e) = (v as u32, EDGE as u32);
            triangles.extend([[v, v + e, v + e + 1], [v, v + e + 1, v + 1]]);
        }
    }
    MeshData { positions, triangles, ..MeshData::default() }
}

/// Two plates side by side, from -1 to 1 and from -0.5 to 0.5, each a part, with a dent in the middle of each.
pub(crate) fn plates() -> Arc<ExampleSet> {
    static SET: OnceLock<Arc<ExampleSet>> = OnceLock::new();
    let make = || {
        let mut whole = plate(CENTRES[0]);
        let (first, other) = (whole.positions.len() as u32, plate(CENTRES[1]));
        whole.positions.extend(other.positions);
        whole.triangles.extend(other.triangles.iter().map(|t| t.map(|v| first + v)));
        let example = |centre: [f32; 3]| {
            let middle = whole.positions.iter().position(|p| *p == centre).unwrap() as u32;
            ExampleData::new("dent", Deltas::Sparse { indices: vec![middle], values: vec![[0.0, 0.0, -0.1]] })
        };
        let examples = CENTRES.map(example).to_vec();
        let mut set = ExampleSet::build(whole, examples, SetOptions::default(), &Serial).unwrap();
        for centre in CENTRES {
            set.add_lod(plate(centre), &Serial).unwrap();
        }
        Arc::new(set)
    };
    SET.get_or_init(make).clone()
}

fn body() -> Instance {
    Instance::new(plates(), InstanceOptions::default()).unwrap()
}

/// How many hits are in the marks of each plate.
fn hits(body: &mut Instance) -> [u64; 2] {
    let set = body.example_set().clone();
    let mut hits = [0, 0];
    for mark in body.marks().unwrap() {
        hits[usize::from(set.mesh().positions()[mark.contact as usize].x > 0.0)] += mark.energy / Mark::ONE;
    }
    hits
}

/// Runs `test` in random orders, and in orders in which threads are rarely interrupted.
#[cfg(shuttle)]
fn all_orders(test: fn()) {
    shuttle::check_random(test, 30_000);
    shuttle::check_pct(test, 30_000, 3);
}

/// Runs `test` in the orders that happen.
#[cfg(not(shuttle))]
fn all_orders(test: fn()) {
    (0..200).for_each(|_| test());
}

/// A thread that hits the middle of part 2 twice.
fn hit_twice(body: &Instance) -> thread::JoinHandle<()> {
    let inbox = body.inbox().clone();
    let hit = Hit::displacement(CENTRES[1], [0.0, 0.0, -0.05]);
    thread::spawn(move || {
        for _ in 0..2 {
            inbox.submit(&hit).unwrap();
        }
    })
}

#[test]
fn each_hit_is_folded_once_while_the_body_is_folded_and_moved() {
    all_orders(|| {
        let mut body = body();
        let threads = [hit_twice(&body), hit_twice(&body)];
        body.fold();
        body.set_transform(Mat4::from_translation(Vec3::X)).unwrap();
        let shown = hits(&mut body);
        threads.into_iter().for_each(|thread| thread.join().unwrap());
        assert!(shown[1] <= 4 && hits(&mut body) == [0, 4]);
    });
}

#[test]
fn a_hit_lands_on_a_part_that_comes_off_or_on_what_is_left() {
    all_orders(|| {
        let mut body = body();
        let threads = [hit_twice(&body), hit_twice(&body)];
        let mut part = body.release(2).unwrap();
        threads.into_iter().for_each(|thread| thread.join().unwrap());
        let (on_body, on_part) = (hits(&mut body), hits(&mut part));
        assert_eq!(on_body[0] + on_body[1], 4);
        assert_eq!(on_part, [0, on_body[1]], "a hit on the part must come off with it; the body has {on_body:?}");
    });
}

#[test]
fn a_hit_reaches_a_mounted_part_if_it_lands_on_it() {
    all_orders(|| {
        let mut body = body();
        let mut part = body.release(2).unwrap();
        body.mount(&mut part).unwrap();
        let threads = [hit_twice(&body), hit_twice(&body)];
        part.fold();
        body.unmount(&mut part).unwrap();
        threads.into_iter().for_each(|thread| thread.join().unwrap());
        let (on_body, on_part) = (hits(&mut body), hits(&mut part));
        assert_eq!(on_body[0] + on_body[1], 4);
        assert_eq!(on_part, [0, on_body[1]], "hits that landed on the part; the body has {on_body:?}");
    });
}
