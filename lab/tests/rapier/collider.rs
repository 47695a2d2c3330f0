//! A proxy as Rapier's collider: a second ball lands in the dent of the first.

use std::num::NonZeroU64;
use std::sync::Arc;

use crumple::{ExampleSet, Hit, Instance, InstanceOptions, MeshData, Serial, SetOptions};
use rapier3d::parry::query::PointQuery;
use rapier3d::prelude::{
    ColliderBuilder, ColliderHandle, PhysicsWorld, Pose, RigidBodyBuilder, SharedShape, TriMesh, TriMeshFlags, Vector,
};

use crate::scenes::{self, Output, bowl, sheet};

fn points(level: &Output) -> Vec<Vector> {
    level.positions.iter().map(|p| Vector::from_array(*p)).collect()
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

    fn new(proxy: &Output, triangles: &[[u32; 3]]) -> Self {
        let mut world = PhysicsWorld { gravity: Vector::Z * -9.81, ..PhysicsWorld::default() };
        world.integration_parameters.dt = Self::STEP;
        let mesh = TriMesh::with_flags(points(proxy), triangles.to_vec(), TriMeshFlags::DEFORMABLE).unwrap();
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
    let (mut base, mut proxy) = (Output::fresh_level(&mut body, 0), Output::fresh_level(&mut body, 1));
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
    let dented = TriMesh::new(points(&proxy), triangles.to_vec()).unwrap();
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
    shape.as_trimesh_mut().unwrap().set_vertices(&points(&proxy));
    let in_the_dent = scene.throw(small, start, 3.0, |_, _| ());

    // The render mesh is the judge, not the proxy.
    let metal = TriMesh::new(points(&base), set.mesh().triangles().to_vec()).unwrap();
    let gap = |ball: Vector| metal.distance_to_point(&Pose::IDENTITY, ball, false) - small.0;
    assert!(gap(in_the_dent).abs() < 0.002, "{} m from the metal at {in_the_dent}", gap(in_the_dent));
    assert!(gap(on_the_rest_shape) > 0.02, "{} m from the metal at {on_the_rest_shape}", gap(on_the_rest_shape));
}
