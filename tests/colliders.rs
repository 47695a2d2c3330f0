//! Colliders that follow: which triangles a deform changed and the box around them, a proxy in Rapier on which a second
//! ball lands in the dent of the first, and convex pieces of which only those that a dent reaches are made again.

mod scenes;

use std::num::NonZeroU64;
use std::ops::Range;
use std::sync::Arc;

use crumple::glam::Vec3;
use crumple::{
    Aabb, DeformJob, ExampleSet, Hit, Instance, InstanceOptions, MeshData, Serial, SetOptions, Tracker, VertexMemory,
    deform,
};
use proptest::prelude::*;
use rapier3d::parry::query::PointQuery;
use rapier3d::prelude::{
    ColliderBuilder, ColliderHandle, PhysicsWorld, Pose, RigidBodyBuilder, SharedShape, TriMesh, TriMeshFlags, Vector,
};
use scenes::{Output, bowl, random_hits, sheet, small_bodies};

/// The vertices of one level of detail, and the tracker of what they show.
struct Level {
    lod: usize,
    positions: Vec<[f32; 3]>,
    tracker: Tracker,
}

impl Level {
    fn new(body: &mut Instance, lod: usize) -> Self {
        let count = body.example_set().lod_mesh(lod).unwrap().positions().len();
        let mut level = Level { lod, positions: vec![[0.0; 3]; count], tracker: Tracker::new() };
        level.update(body);
        level
    }

    fn update(&mut self, body: &mut Instance) {
        body.fold();
        let memory = VertexMemory::separate(&mut self.positions, None, None).unwrap();
        deform(&mut [DeformJob { lod: self.lod, instance: body, tracker: &mut self.tracker, memory }], &Serial)
            .unwrap();
    }

    fn points(&self) -> Vec<Vector> {
        self.positions.iter().map(|p| Vector::from_array(*p)).collect()
    }
}

fn contains(bounds: &Aabb, p: [f32; 3]) -> bool {
    Vec3::from_array(p).cmpge(bounds.min).all() && Vec3::from_array(p).cmple(bounds.max).all()
}

proptest! {
    #![proptest_config(scenes::cases(30))]

    #[test]
    fn changed_triangles_and_their_box_hold_all_that_moved(which in 0usize..3, seed: u64, apart in 1usize..4) {
        let set = small_bodies().swap_remove(which).1;
        let mut body = scenes::new(&set);
        let mut output = Output::fresh(&mut body);
        let triangles = set.mesh().triangles();
        for hits in random_hits(&set, 6, seed).chunks(apart) {
            let before = output.positions.clone();
            hits.iter().for_each(|h| _ = body.submit(h).unwrap());
            output.update(&mut body);
            let found: Vec<Range<u32>> = output.tracker.changed_triangles(triangles);
            prop_assert!(found.array_windows().all(|[a, b]| a.end < b.start) && found.iter().all(|r| r.start < r.end));
            let moved = |v: &u32| before[*v as usize] != output.positions[*v as usize];
            for (t, corners) in triangles.iter().enumerate() {
                let written = corners.iter().any(|v| output.tracker.changed().iter().any(|r| r.contains(v)));
                prop_assert_eq!(found.iter().any(|r| r.contains(&(t as u32))), written, "triangle {}", t);
                prop_assert!(written || !corners.iter().any(moved), "triangle {} moved", t);
            }
            let Some(bounds) = output.tracker.changed_bounds() else {
                prop_assert!(found.is_empty());
                continue;
            };
            for v in output.tracker.changed().iter().cloned().flatten() {
                let v = v as usize;
                prop_assert!(contains(&bounds, before[v]) && contains(&bounds, output.positions[v]), "vertex {}", v);
            }
        }
        output.update(&mut body);
        prop_assert!(output.tracker.changed_triangles(triangles).is_empty());
        prop_assert_eq!(output.tracker.changed_bounds(), None);
    }
}

/// A plate, one example of a dent 6 cm deep in its middle, and a proxy of 484 vertices.
fn plate() -> Arc<ExampleSet> {
    let mesh = sheet(48);
    let middle = bowl(&mesh, scenes::nearest(&mesh, [0.0; 3]), 0.06, 0.35);
    let mut set = ExampleSet::build(mesh, vec![middle], SetOptions::default(), &Serial).unwrap();
    set.add_lod(MeshData { normals: None, tangents: None, ..sheet(21) }, &Serial).unwrap();
    Arc::new(set)
}

struct Scene {
    world: PhysicsWorld,
    plate: ColliderHandle,
}

impl Scene {
    const STEP: f32 = 1.0 / 240.0;

    fn new(proxy: &Level, triangles: &[[u32; 3]]) -> Self {
        let mut world = PhysicsWorld { gravity: Vector::Z * -9.81, ..PhysicsWorld::default() };
        world.integration_parameters.dt = Self::STEP;
        let mesh = TriMesh::with_flags(proxy.points(), triangles.to_vec(), TriMeshFlags::DEFORMABLE).unwrap();
        let plate = world.insert_collider(ColliderBuilder::new(SharedShape::new(mesh)), None);
        Scene { world, plate }
    }

    /// Throws a ball from `start` for `seconds` and takes it away. Tells each impulse on the plate and its point. Returns
    /// where the ball ended.
    fn throw(
        &mut self,
        (radius, mass): (f32, f32),
        start: Vector,
        seconds: f32,
        mut told: impl FnMut(Vector, Vector),
    ) -> Vector {
        let body = RigidBodyBuilder::dynamic().translation(start).angular_damping(4.0).linear_damping(0.3);
        let (ball, _) = self.world.insert(body, ColliderBuilder::ball(radius).mass(mass));
        for _ in 0..(seconds / Self::STEP) as usize {
            let before = self.world.bodies[ball].linvel();
            self.world.step();
            let ball = &self.world.bodies[ball];
            let impulse = (before + self.world.gravity * Self::STEP - ball.linvel()) * mass;
            if impulse.length() > 1.0 {
                told(ball.translation() + impulse.normalize() * radius, impulse);
            }
        }
        let end = self.world.bodies[ball].translation();
        self.world.remove_body(ball);
        end
    }
}

#[test]
fn a_second_ball_in_rapier_lands_on_the_metal_that_the_first_dented() {
    let set = plate();
    let options = InstanceOptions { compliance: Some(0.0025), ..InstanceOptions::default() };
    let mut body = Instance::new(set.clone(), options).unwrap();
    let (mut base, mut proxy) = (Level::new(&mut body, 0), Level::new(&mut body, 1));
    let triangles = set.lod_mesh(1).unwrap().triangles();
    let mut scene = Scene::new(&proxy, triangles);

    let place = Vector::new(0.1, 0.05, 0.0);
    let contact = NonZeroU64::new(1).unwrap();
    scene.throw((0.15, 4.0), place + Vector::Z * 0.9, 0.6, |point, impulse| {
        let hit = Hit::impulse(point.to_array(), impulse.to_array(), 0.01, None);
        body.submit(&hit.of_contact(contact)).unwrap();
    });
    body.end_contact(contact).unwrap();
    base.update(&mut body);
    proxy.update(&mut body);

    // The changed triangles are those whose leaves a tree must know.
    let dented = TriMesh::new(proxy.points(), triangles.to_vec()).unwrap();
    let mut tree = scene.world.colliders[scene.plate].shape().as_trimesh().unwrap().bvh().clone();
    let changed: Vec<u32> = proxy.tracker.changed_triangles(triangles).into_iter().flatten().collect();
    changed.iter().for_each(|&t| tree.insert(dented.triangle(t).local_aabb(), t));
    for t in 0..triangles.len() as u32 {
        assert_eq!(tree.leaf_node(t).unwrap().aabb(), dented.triangle(t).local_aabb(), "triangle {t}");
    }

    let small = (0.03, 0.2);
    let start = place + Vector::new(0.02, 0.0, 0.08);
    let on_the_rest_shape = scene.throw(small, start, 3.0, |_, _| ());
    let shape = scene.world.colliders[scene.plate].shape_mut();
    shape.as_trimesh_mut().unwrap().set_vertices(&proxy.points());
    let in_the_dent = scene.throw(small, start, 3.0, |_, _| ());

    // The render mesh is the judge, not the proxy.
    let metal = TriMesh::new(base.points(), set.mesh().triangles().to_vec()).unwrap();
    let gap = |ball: Vector| metal.distance_to_point(&Pose::IDENTITY, ball, false) - small.0;
    assert!(gap(in_the_dent).abs() < 0.002, "{} m from the metal at {in_the_dent}", gap(in_the_dent));
    assert!(gap(on_the_rest_shape) > 0.02, "{} m from the metal at {on_the_rest_shape}", gap(on_the_rest_shape));
}

#[test]
fn only_convex_pieces_that_a_dent_reaches_are_made_again() {
    const PIECES: usize = 4;
    let mesh = sheet(48);
    let dent = bowl(&mesh, scenes::nearest(&mesh, [0.0; 3]), 0.06, 0.2);
    let mut set = ExampleSet::build(mesh, vec![dent], SetOptions::default(), &Serial).unwrap();
    // Plates of 0.25 m by 0.25 m by 1 cm.
    let piece = |n: usize| {
        let corner = |k: usize| {
            let at = |piece: usize, end: usize| 0.25 * (piece + end) as f32 - 0.5;
            [at(n % PIECES, k & 1), at(n / PIECES, k >> 1 & 1), -0.01 * (k >> 2) as f32]
        };
        MeshData { positions: (0..8).map(corner).collect(), ..MeshData::default() }
    };
    for n in 0..PIECES * PIECES {
        assert_eq!(set.add_lod(piece(n), &Serial).unwrap(), n + 1);
    }
    let mut body = scenes::new(&Arc::new(set));
    let mut pieces: Vec<Level> = (1..=PIECES * PIECES).map(|lod| Level::new(&mut body, lod)).collect();
    let rest: Vec<_> = pieces.iter().map(|p| p.positions.clone()).collect();

    // A dent on the corner at which four pieces meet reaches these four alone.
    body.submit(&scenes::push([0.25, 0.25, 0.0], [0.0, 0.0, -0.05])).unwrap();
    pieces.iter_mut().for_each(|p| p.update(&mut body));
    let changed: Vec<usize> = (0..pieces.len()).filter(|&n| !pieces[n].tracker.changed().is_empty()).collect();
    assert_eq!(changed, [10, 11, 14, 15]);
    for (n, piece) in pieces.iter().enumerate() {
        assert_eq!(piece.positions != rest[n], changed.contains(&n), "piece {n}");
        let hull = SharedShape::convex_hull(&piece.points()).unwrap();
        let lowest = hull.compute_local_aabb().mins.z;
        assert_eq!(lowest < -0.05, changed.contains(&n), "the hull of piece {n} reaches down to {lowest} m");
    }
}
